"""How a file is read, as a small description that fits a link."""

from __future__ import annotations

from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any
from urllib.parse import quote, unquote

from tracker_core.checks import Domain, InputError, check_choice
from tracker_core.recordings.bounds import ID_LENGTH, LATE, MOST_COLUMNS
from tracker_core.recordings.clocks import CLOCKS
from tracker_core.recordings.units import ANGLES, LENGTHS

DELIMITERS = MappingProxyType({"comma": ",", "semicolon": ";", "tab": "\t", "pipe": "|", "space": " "})
"""What may stand between two cells; any run of blanks counts as one "space"."""

DECIMALS = MappingProxyType({"point": ".", "comma": ","})
"""What may stand before the fraction of a number."""

FRAMES = MappingProxyType({"plane": (1, 3), "geographic": (2, 3), "polar": (2, 3)})
"""What the columns of a position are, and the fewest and most of them: axes; latitude, longitude and perhaps altitude;
range, bearing clockwise from north and perhaps elevation angle."""

HELD = ("kept", "missing")
"""What is done with a position that is exactly the one before."""

COLUMN = Domain(1, MOST_COLUMNS, whole=True)
_COLUMN_OR_NONE = Domain(0, MOST_COLUMNS, whole=True)
_INTERVAL = Domain(0, LATE, low_open=True)


@dataclass(frozen=True, slots=True)
class Reading:
    """How a file is read. `text` and `from_text` are inverse to each other.

    Attributes:
        delimiter: a name in DELIMITERS.
        decimal: a name in DECIMALS.
        header: whether the first row that is wide enough holds names.
        time: column of the time, from 1; 0 where there is none.
        interval: s between two rows where there is no column of the time; else not used.
        clock: a name in CLOCKS: how a time is written.
        frame: a name in FRAMES.
        at: columns of the position. A column that is named twice in a row holds two numbers, as in "51.5,-0.1".
        units: names in LENGTHS, of the axes of a plane (one for all, or one each), of the altitude or of the range.
        angle: a name in ANGLES, of bearing and elevation angle.
        truth: columns of the true position in the same frame and units; none, or as many as `at`.
        track: column that tells the tracks of a file apart; 0 for none.
        only: id of the track that is read.
        held: one of HELD.

    Raises:
        InputError: when a field is not one of these.
    """

    delimiter: str = "comma"
    decimal: str = "point"
    header: bool = True
    time: int = 1
    interval: float = 1.0
    clock: str = "seconds"
    frame: str = "plane"
    at: tuple[int, ...] = (2, 3)
    units: tuple[str, ...] = ("m",)
    angle: str = "deg"
    truth: tuple[int, ...] = ()
    track: int = 0
    only: str = ""
    held: str = "kept"

    def __post_init__(self) -> None:
        for field, choices in _CHOICES.items():
            check_choice(field, getattr(self, field), choices)
        for field in ("time", "track"):
            object.__setattr__(self, field, int(_COLUMN_OR_NONE.check(field, getattr(self, field))))
        for field in ("at", "truth"):
            object.__setattr__(self, field, tuple(int(COLUMN.check(field, column)) for column in getattr(self, field)))
        object.__setattr__(self, "interval", _INTERVAL.check("interval", self.interval))
        object.__setattr__(self, "units", tuple(check_choice("units", unit, LENGTHS) for unit in self.units))
        self._check_together()

    def _check_together(self) -> None:
        fewest, most = FRAMES[self.frame]
        if not fewest <= len(self.at) <= most:
            raise InputError("at", f"must name {fewest} to {most} columns of a {self.frame} position", self.at)
        if self.time and self.time in self.at + self.truth:
            raise InputError("at", "must not name the column of the time", self.time)
        if self.truth and len(self.truth) != len(self.at):
            raise InputError("truth", "must name as many columns as the position has, or none", self.truth)
        if len(self.units) != 1 and (self.frame != "plane" or len(self.units) != len(self.at)):
            raise InputError("units", "must be one for all; in a plane, it may be one per axis", self.units)
        _check_id(self.only)
        if self.track and not self.only:
            raise InputError("only", "must name the track that is read", self.only)

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes that positions are read to."""
        names = ("x", "y", "z") if self.frame == "plane" else ("east", "north", "up")
        return names[: len(self.at)]

    @property
    def columns(self) -> int:
        """How many columns a row must have."""
        return max(self.time, self.track, *self.at, *self.truth)

    def text(self) -> str:
        """The fields that differ from their defaults, as in `clock:iso,frame:geographic,at:3.4`."""
        parts = []
        for field in fields(self):
            value = getattr(self, field.name)
            if value != field.default:
                parts.append(f"{field.name}:{_written(value)}")
        return ",".join(parts)

    @classmethod
    def from_text(cls, text: Any) -> Reading:
        """The reading that `text` describes.

        Raises:
            InputError: when it names a field twice or one that is not there, or a value that is not admitted.
        """
        if not isinstance(text, str) or len(text) > _LONGEST:
            raise InputError("reading", f"must be a text of at most {_LONGEST:,} characters", text)
        values: dict[str, object] = {}
        for part in text.split(",") if text else ():
            name, colon, value = part.partition(":")
            if not colon or name not in _READERS or name in values:
                raise InputError("reading", f"must be name:value parts, each of {', '.join(_READERS)} once", part)
            values[name] = _READERS[name](value)
        return cls(**values)  # type: ignore[arg-type]


_CHOICES = {
    "delimiter": DELIMITERS,
    "decimal": DECIMALS,
    "clock": CLOCKS,
    "frame": FRAMES,
    "angle": ANGLES,
    "held": HELD,
}

_LONGEST = 2_000
"""Characters of a text: of a link."""


def _check_id(value: object) -> None:
    if not isinstance(value, str) or len(value) > ID_LENGTH:
        raise InputError("only", f"must be an id of at most {ID_LENGTH} characters", value)


def _written(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return ".".join(str(item) for item in value)
    return quote(value, safe="", errors="replace") if isinstance(value, str) else repr(value)


def _read_header(value: str) -> bool:
    return check_choice("header", value, ("yes", "no")) == "yes"


def _read_columns(value: str) -> tuple[str, ...]:
    return tuple(value.split(".")) if value else ()


_READERS = {field.name: unquote for field in fields(Reading)} | {
    "header": _read_header,
    "at": _read_columns,
    "truth": _read_columns,
    "units": _read_columns,
}
