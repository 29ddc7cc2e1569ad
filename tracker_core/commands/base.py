"""What the commands share: the parser, flags of the experiment's fields, JSON."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Sequence
from typing import Any, NoReturn, Protocol

from tracker_core.fields import FIELDS


class Commands(Protocol):
    """Where a command adds itself; argparse has no public name for it."""

    def add_parser(self, name: str, *, help: str) -> argparse.ArgumentParser:  # noqa: A002 - argparse's own word
        """The parser of a new command."""


class Parser(argparse.ArgumentParser):
    """Reports a wrong command line in one line."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **{"allow_abbrev": False, **options})
        # Before Python 3.14 argparse takes -1e-3 for a flag.
        self._negative_number_matcher = re.compile(r"^-(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?$")

    def error(self, message: str) -> NoReturn:
        """End with status 2."""
        self.exit(2, f"{self.prog}: {' '.join(message.split())}\n")


def add_field(parser: argparse.ArgumentParser, name: str) -> None:
    """Add the flag of one field of the experiment."""
    field = FIELDS[name]
    unit = f" [{field.unit}]" if field.unit else ""
    # Values stay text here: reading them is the experiment's business, so that all messages are alike.
    parser.add_argument(f"--{name.replace('_', '-')}", metavar=field.symbol or name.upper(), help=field.sentence + unit)


def given(options: argparse.Namespace, names: Sequence[str]) -> dict[str, Any]:
    """The flags of some names that were given."""
    return {name: getattr(options, name) for name in names if getattr(options, name) is not None}


def complex_pairs(roots: Sequence[complex]) -> list[list[float]]:
    """Each as [real, imaginary]: JSON has no complex numbers."""
    return [[root.real, root.imag] for root in roots]


def print_json(value: Any) -> None:
    """One JSON object on the standard output."""
    print(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))
