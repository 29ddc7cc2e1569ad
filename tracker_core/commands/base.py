"""What the commands share: the parser, flags of the experiment's fields, JSON."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn, Protocol

from tracker_core.checks import InputError
from tracker_core.fields import FIELDS
from tracker_core.measured import SHELF, File, clean_name
from tracker_core.recordings.bounds import MOST_BYTES


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


def add_experiment(parser: argparse.ArgumentParser) -> None:
    """Add what says which experiment it is: a file of one, and a flag for each of its fields."""
    parser.add_argument("--experiment", metavar="FILE", help="experiment as a JSON object; flags override its fields")
    for name in FIELDS:
        if name == "data":
            parser.add_argument("--data", metavar="FILE", help="file of measured data, which is then what is tracked")
        else:
            add_field(parser, name)


def experiment_values(options: argparse.Namespace) -> dict[str, Any]:
    """The fields of the experiment that the command line describes; a file of measured data is put on the shelf.

    Raises:
        InputError: for a file that cannot be used.
    """
    values = {**experiment_file(options.experiment), **given(options, [name for name in FIELDS if name != "data"])}
    if options.data is not None:
        content = _content(Path(options.data))
        values["data"] = SHELF.keep(File(clean_name(options.data), content))
    return values


def _content(path: Path) -> bytes:
    try:
        with path.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise InputError("data", "must be a file that can be read", f"{path}: {error.strerror}") from None
    if len(content) > MOST_BYTES:
        raise InputError("data", f"must be a file of at most {MOST_BYTES:,} bytes", str(path))
    return content


def experiment_file(path: str | None) -> dict[str, Any]:
    """The fields of an experiment that a file holds as a JSON object; none without a file.

    Raises:
        InputError: for a file that holds something else.
    """
    if path is None:
        return {}
    try:
        values = json.loads(Path(path).read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError("experiment", "must be a JSON file", f"{path}: {error}") from None
    if not isinstance(values, dict):
        raise InputError("experiment", "must be a JSON object", values)
    return values


def complex_pairs(roots: Sequence[complex]) -> list[list[float]]:
    """Each as [real, imaginary]: JSON has no complex numbers."""
    return [[root.real, root.imag] for root in roots]


def print_json(value: Any) -> None:
    """One JSON object on the standard output."""
    print(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))
