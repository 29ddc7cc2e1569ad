"""Entries as a page or a link gives them: those that say something, each read by its own reader."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from tracker_core import InputError


def read_entries(
    readers: Mapping[str, Callable[[Any], Any]], values: Mapping[str, Any]
) -> tuple[dict[str, Any], list[InputError]]:
    """What the readers make of the values under their names.

    Returns:
        What was read, by name: nothing and empty texts say nothing and are left out. And for every value that its
        reader refuses the error.
    """
    read, errors = {}, []
    for name, reader in readers.items():
        if values.get(name) in (None, ""):
            continue
        try:
            read[name] = reader(values[name])
        except InputError as error:
            errors.append(error.kept())
    return read, errors
