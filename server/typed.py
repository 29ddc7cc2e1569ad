"""What comes from outside, read against a description of its form and size: types of msgspec.

Form and size are settled here, once, before anything is done with it; what it means is for the pages to judge.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import msgspec

from tracker_core.checks import InputError

T = TypeVar("T")

Reader = Callable[[bytes | str], T]
"""From JSON to a value of a type; raises InputError, naming the part that is not as it must be."""

_SHOWN = 100
"""Bytes of what could not be read that are looked at for the message."""


def reader(kind: Any, name: str) -> Reader[Any]:
    """What reads JSON of a type.

    Args:
        kind: the type; its `__post_init__` may raise InputError.
        name: what the whole of it is called in errors; its parts are called by their own names.
    """
    decoder = msgspec.json.Decoder(kind)

    def read(raw: bytes | str) -> Any:
        try:
            return decoder.decode(raw)
        except msgspec.ValidationError as error:
            if isinstance(error.__cause__, InputError):
                raise error.__cause__ from None
            raise _wrong(name, str(error), raw) from None
        except (msgspec.DecodeError, UnicodeError, RecursionError):
            raise InputError(name, "must be JSON of a moderate depth", _beginning(raw)) from None

    return read


def _wrong(name: str, said: str, raw: bytes | str) -> InputError:
    """The error for what msgspec says: "Expected `int`, got `str` - at `$.seq`", say."""
    what, _, place = said.partition(" - at ")
    what, _, got = what.partition(", got ")
    # A place within a key is said as "`key` in `$.controls`".
    path = place.rpartition("$")[2].strip("`.")
    rule = f"must be {what.removeprefix('Expected ')}" if what.startswith("Expected ") else f"must fit: {what}"
    return InputError(path or name, rule.replace("`", ""), got.strip("`") or _beginning(raw))


def _beginning(raw: bytes | str) -> str:
    beginning = raw[:_SHOWN]
    return beginning if isinstance(beginning, str) else bytes(beginning).decode(errors="replace")
