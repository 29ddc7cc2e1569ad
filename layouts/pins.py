"""Pins: filters that are kept under a name, to be compared with the present one on the same data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated, Any

from msgspec import Meta

from tracker_core import DESIGNS, Experiment, InputError
from tracker_core.adaptive import METHODS
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.design import MANUAL
from tracker_core.experiment import PARAMETERS, read_filter
from tracker_core.fields import FIELDS
from tracker_core.types import GAIN_NAMES

SLOTS = (1, 2, 3, 4, 5, 6)
Slot = Annotated[int, Meta(ge=SLOTS[0], le=SLOTS[-1])]
NAME_LENGTH = 40
TEXT_LENGTH = 600
"""Characters of a pin in a link that are looked at."""

_NAME = ",name:"


@dataclass(frozen=True, slots=True)
class Pin:
    """One filter, which runs on whatever the present target and sensor are.

    Attributes:
        slot: one of SLOTS; its colour, dash and marker go with it.
        values: the filter as `experiment.read_filter` gives it, names and values.
        given_name: what a user calls it; empty for the usual name.
    """

    slot: int
    values: tuple[tuple[str, Any], ...]
    given_name: str = ""

    @property
    def name(self) -> str:
        """What it is called: at most NAME_LENGTH characters, any of them."""
        return self.given_name or filter_name(dict(self.values))

    def on(self, experiment: Experiment) -> Experiment:
        """The experiment with this filter instead of its own.

        Raises:
            InputError: where the filter does not fit its target.
        """
        return experiment.with_filter(dict(self.values))

    def named(self, name: str) -> Pin:
        """The same filter under another name; its usual one for an empty name."""
        given = clean_name(name)
        return Pin(self.slot, self.values, "" if given == filter_name(dict(self.values)) else given)

    def text(self) -> str:
        """The pin in a link: its design, what else says which filter it is, and a given name last."""
        (_, design), *rest = self.values
        said = [str(design), *(f"{name}:{value}" for name, value in rest)]
        return ",".join(said) + (_NAME + self.given_name if self.given_name else "")


def pin_of(slot: int, experiment: Experiment) -> Pin:
    """The filter of an experiment as a pin."""
    return Pin(slot, tuple(experiment.filter_values().items()))


def read_pin(slot: int, text: str) -> Pin:
    """A pin from a link; whether it fits a target is for `Pin.on` to find out.

    Raises:
        InputError: naming the value that cannot be read.
    """
    said, _, name = text[:TEXT_LENGTH].partition(_NAME)
    design, *rest = said.split(",")
    values = {"design": design}
    for item in rest:
        field, colon, value = item.partition(":")
        if not colon or field in values:
            raise InputError(field, "must be given once, as name:value", item)
        values[field] = value
    return Pin(slot, tuple(read_filter(values).items())).named(name)


def read_pins(pairs: Iterable[tuple[int, str]]) -> tuple[Pin, ...]:
    """Pins as a page sends them, pairs of slot and text; what is none, or a second one in its slot, is let go."""
    pins: dict[int, Pin] = {}
    for slot, text in pairs:
        if slot not in pins:
            with suppress(InputError):
                pins[slot] = read_pin(slot, text)
    return tuple(pins.values())


def clean_name(name: str) -> str:
    """A name in one line of at most NAME_LENGTH characters, each of which can be seen."""
    return " ".join("".join(part for part in name if part.isprintable() or part.isspace()).split())[
        :NAME_LENGTH
    ].strip()


def filter_name(values: Mapping[str, Any]) -> str:
    """What a filter is called by itself: its design and what that is computed from."""
    design = values["design"]
    if design == MANUAL:
        return shortened("Manual", " " + ", ".join(_plain(values[name]) for name in GAIN_NAMES if name in values))
    said, usual = "", METHODS[design].parameters if design in METHODS else {}
    for name in (*PARAMETERS, *METHOD_PARAMETERS):
        field, value = FIELDS[name], values.get(name)
        # A default that follows the interval is always said, and tells no filter from another.
        if value is None or field.kind == "choice" or callable(usual.get(name)):
            continue
        part = f" {field.symbol or field.title.lower()} {_plain(value)}"
        said += part if len(said + part) <= NAME_LENGTH // 2 else ""
    said += f", order {values['order']}" if "order" in values else ""
    title = DESIGNS[design].title if design in DESIGNS else METHODS[design].title
    return shortened(title, said)


def shortened(title: str, rest: str) -> str:
    """A title with what follows it, of which the title makes room."""
    room = NAME_LENGTH - len(rest)
    if len(title) <= room:
        return title + rest
    return f"{title[: max(room, 1) - 1].rstrip()}…{rest}"[:NAME_LENGTH]


def _plain(value: float) -> str:
    return f"{value:.0f}" if 1000 <= abs(value) < 1e6 else f"{value:.3g}"
