"""Command line: python -m tracker_core run|suggest|design|stability|sweep|reproduce|compile."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence

from tracker_core.checks import InputError, show
from tracker_core.commands import COMMANDS
from tracker_core.commands.base import Parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status: 0, or 2 for bad input."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Greek letters must not stop an output that cannot show them.
            stream.reconfigure(errors="replace")
    parser = _parser()
    options = parser.parse_args(arguments)
    try:
        options.action(options)
        sys.stdout.flush()
    except InputError as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # Whoever read the output has seen enough; nothing more may be written, not even at the end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        print(f"{parser.prog}: {show(error.filename or 'output')}: {error.strerror}", file=sys.stderr)
        return 2
    return 0


def _parser() -> Parser:
    parser = Parser(prog="python -m tracker_core", description="Fixed-gain tracking filters.")
    commands = parser.add_subparsers(
        dest="command", required=True, metavar="run|suggest|design|stability|sweep|reproduce|compile"
    )
    for command in COMMANDS:
        command.add(commands)
    for added in commands.choices.values():
        added.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


if __name__ == "__main__":
    sys.exit(main())
