"""What names of columns tell."""

from __future__ import annotations

import re
from dataclasses import dataclass

_UNIT = re.compile(r"[\[(]\s*([^\[\]()]{1,20}?)\s*[\])]")
_WORDS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+")

_UNITS = {
    "m": "m", "metre": "m", "metres": "m", "meter": "m", "meters": "m",
    "km": "km", "kilometre": "km", "kilometres": "km", "kilometer": "km", "kilometers": "km",
    "ft": "ft", "feet": "ft", "foot": "ft", "nm": "NM", "nmi": "NM",
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "rad": "rad", "radian": "rad", "radians": "rad",
    "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s",
    "ms": "ms", "millis": "ms", "msec": "ms", "millisecond": "ms", "milliseconds": "ms",
    "us": "us", "µs": "us", "μs": "us", "micros": "us", "usec": "us", "microsecond": "us", "microseconds": "us",
}  # fmt: skip

TRUE = frozenset({"true", "truth", "gt", "ref", "reference", "actual", "groundtruth"})
OBSERVED = frozenset({"observed", "obs", "measured", "meas", "measurement", "noisy", "sensor", "raw"})
_COMPUTED = frozenset({"predicted", "smoothed", "filtered", "estimated", "estimate", "est", "error", "std", "sigma"})
_RATES = frozenset({"velocity", "speed", "acceleration", "jerk", "rate", "vel", "acc"})


@dataclass(frozen=True, slots=True)
class Name:
    """A name taken apart.

    Attributes:
        whole: its small letters and digits alone, without a unit in brackets.
        words: its words in small letters: those between signs, and those that begin with a capital.
        unit: "m", "km", "ft", "NM", "deg", "rad", "s", "ms" or "us"; empty where it names none.
    """

    whole: str
    words: tuple[str, ...]
    unit: str

    @property
    def bare(self) -> str:
        """The words but for those that say whether it is observed or true."""
        return "".join(word for word in self.words if word not in OBSERVED | TRUE)

    @property
    def true(self) -> bool:
        """Whether it names the truth."""
        return not TRUE.isdisjoint(self.words)

    @property
    def observed(self) -> bool:
        """Whether it names what a sensor said."""
        return not OBSERVED.isdisjoint(self.words)

    @property
    def other(self) -> bool:
        """Whether it names something that is no position of a sensor or of the target."""
        return not (_COMPUTED | _RATES).isdisjoint(self.words)


def take_apart(name: str) -> Name:
    """What a name says, whatever its spelling."""
    name = name[:200]
    bracket = _UNIT.search(name)
    unit = _UNITS.get(bracket.group(1).lower(), "") if bracket else ""
    words = tuple(word.lower() for word in _WORDS.findall(_UNIT.sub(" ", name)))
    if not unit and len(words) > 1 and words[-1] in _UNITS and words[-1] != "s":
        unit, words = _UNITS[words[-1]], words[:-1]
    return Name("".join(words), words, unit)
