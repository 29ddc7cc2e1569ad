"""Checking what comes from outside: the one error type, the domains of numbers, and fields.

Every rejected input names the field, the rule it broke and the value received, so that a caller (a page, a
command line, a notebook) can put the message beside the thing to mend.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

RECEIVED_LENGTH = 60


class InputError(ValueError):
    """A value from outside breaks a rule.

    Attributes:
        field: name of the field, in the words of the experiment description.
        rule: what the value must be, as a clause after the name ("must be > 0").
        received: the value as it came.
    """

    def __init__(self, field: str, rule: str, received: Any) -> None:
        self.field = field
        self.rule = rule
        self.received = received
        name = field if field.isprintable() else repr(field)
        name = name if len(name) <= RECEIVED_LENGTH else name[: RECEIVED_LENGTH - 1] + "…"
        super().__init__(f"{name} {rule}, got {show(received)}")

    def kept(self) -> InputError:
        """Itself, without where it was raised.

        An exception knows all frames down to there, with everything in them. Kept in one of them it would keep that,
        until the collector looks at what is old.
        """
        self.__traceback__ = self.__cause__ = self.__context__ = None
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """So that it comes whole from another process."""
        return type(self), (self.field, self.rule, self.received), self.__dict__


def show(value: Any) -> str:
    """The value in one short line."""
    try:
        text = str(value) if isinstance(value, float) else repr(value)
    except (ValueError, RecursionError):
        # A number of thousands of digits, a list of lists of lists ...
        return f"a very large {type(value).__name__}"
    text = " ".join(text.split())
    return text if len(text) <= RECEIVED_LENGTH else text[: RECEIVED_LENGTH - 1] + "…"


@dataclass(frozen=True, slots=True)
class Domain:
    """The numbers a field admits: an interval, each end open or closed.

    Attributes:
        low, high: the ends; infinite for none.
        low_open, high_open: whether the end itself is excluded.
        whole: whether only whole numbers are admitted.
    """

    low: float = -math.inf
    high: float = math.inf
    low_open: bool = False
    high_open: bool = False
    whole: bool = False

    @property
    def rule(self) -> str:
        """The domain in words, as a clause after the name of the field."""
        parts = []
        if self.low > -math.inf:
            parts.append(f"{'>' if self.low_open else '>='} {_plain(self.low)}")
        if self.high < math.inf:
            high = f"{self.high:,.0f}" if self.whole else _plain(self.high)
            parts.append(f"{'<' if self.high_open else '<='} {high}")
        kind = "a whole number" if self.whole else "a finite number"
        return " ".join(["must be", kind, " and ".join(parts)]).rstrip()

    def __contains__(self, value: float) -> bool:
        above = value > self.low if self.low_open else value >= self.low
        below = value < self.high if self.high_open else value <= self.high
        return math.isfinite(value) and above and below

    def check(self, field: str, value: Any) -> float:
        """`value` as a number of this domain.

        Numbers and the strings that spell one are taken; booleans are not.

        Raises:
            InputError: when `value` is not a number, not finite or outside.
        """
        try:
            if isinstance(value, bool):
                raise TypeError
            number = float(value)
        except (TypeError, ValueError, OverflowError):
            raise InputError(field, self.rule, value) from None
        if number not in self or (self.whole and number != math.floor(number)):
            raise InputError(field, self.rule, value)
        return number


def _plain(number: float) -> str:
    return f"{number:,.0f}" if number == math.floor(number) and abs(number) < 1e7 else f"{number:g}"


def check_choice(field: str, value: Any, choices: Iterable[str]) -> str:
    """`value` if it is one of `choices`.

    Raises:
        InputError: naming the choices.
    """
    known = list(choices)
    if not isinstance(value, str) or value not in known:
        raise InputError(field, f"must be one of {', '.join(known)}", value)
    return value


POSITIVE = Domain(low=0, low_open=True)


@dataclass(frozen=True, slots=True)
class Field:
    """One named value that comes from outside.

    Attributes:
        symbol: as in formulas; empty where there is none.
        title: for labels.
        unit: SI symbol; empty for a pure number.
        sentence: what it is, plainly.
        kind: "number", "whole", "numbers" (one per axis), "choice" or "text".
        domain: the numbers it admits, a text's number of characters; a design may narrow it.
        choices: the names it admits.
    """

    symbol: str
    title: str
    unit: str
    sentence: str
    kind: str
    domain: Domain = Domain()
    choices: tuple[str, ...] = ()

    @property
    def rule(self) -> str:
        """What it admits in words, as a clause after its name."""
        if self.kind == "choice":
            return f"must be one of {', '.join(self.choices)}"
        if self.kind == "text":
            low, high = f"{self.domain.low:,.0f}", f"{self.domain.high:,.0f}"
            return f"must be a text of {low} to {high} characters that can be seen"
        return self.domain.rule

    def read(self, name: str, value: Any) -> Any:
        """`value` as this field's type.

        Raises:
            InputError: naming the field, the rule and the value.
        """
        if self.kind == "choice":
            return check_choice(name, value, self.choices)
        if self.kind == "numbers":
            return tuple(self.domain.check(name, item) for item in _items(name, value))
        if self.kind == "text":
            return self._text(name, value)
        number = self.domain.check(name, value)
        return int(number) if self.kind == "whole" else number

    def _text(self, name: str, value: Any) -> str:
        if not isinstance(value, str) or not value.isprintable() or len(value) not in self.domain:
            raise InputError(name, self.rule, value)
        return value


def _items(name: str, value: Any) -> list[Any]:
    if isinstance(value, str):
        return value.split(",")
    if isinstance(value, Iterable) and not isinstance(value, Mapping):
        items = list(value)
        if not 1 <= len(items) <= 8:
            raise InputError(name, "must be one number, or one per axis", f"{len(items)} values")
        return items
    return [value]


def choice(title: str, sentence: str, choices: Iterable[str]) -> Field:
    """A field that admits names."""
    return Field("", title, "", sentence, "choice", choices=tuple(choices))
