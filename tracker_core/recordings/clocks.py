"""How a time is written, and its seconds.

A clock reads cells to ticks, of which it has `per_second` a second: whole microseconds stay whole numbers until the
first of them is subtracted, so that no digit of a date is lost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from math import inf, nan
from types import MappingProxyType

import numpy as np

from tracker_core.recordings.numbers import Cells, numbers
from tracker_core.types import FloatArray

DAY = 86_400.0


@dataclass(frozen=True, slots=True)
class Clock:
    """A way to write the time.

    Attributes:
        title: for labels.
        sentence: what it is, plainly.
        per_second: ticks in a second.
        read: cells and the sign before a fraction -> ticks, shape (n_cells,); NaN for what is no time.
        daily: whether it starts anew at midnight.
    """

    title: str
    sentence: str
    per_second: float
    read: Callable[[Cells, str], FloatArray]
    daily: bool = False


def _read_numbers(cells: Cells, decimal: str) -> FloatArray:
    return numbers(cells, decimal)[0]


_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_MICROSECOND = timedelta(microseconds=1)


def microseconds(cell: str) -> float:
    """Microseconds from 1970 (UTC) to a date and time of ISO 8601; one without a zone is taken as UTC.

    Also taken: slashes for hyphens, and "UTC" after a blank for the zone. NaN for anything else.
    """
    text = cell.strip().replace("/", "-")
    try:
        stamp = datetime.fromisoformat(text.removesuffix(" UTC"))
        aware = stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)
        return float((aware - _EPOCH) // _MICROSECOND)
    except (ValueError, OverflowError):
        return nan


def _read_dates(cells: Cells, decimal: str) -> FloatArray:
    del decimal  # ISO 8601 admits both
    return np.fromiter(map(microseconds, cells), float, len(cells))


def second_of_day(cell: str) -> float:
    """Seconds since midnight of hhmmss or hh:mm:ss, with or without a fraction. NaN for anything else."""
    parts = cell.strip().split(":")
    if len(parts) == 1:
        whole, point, fraction = parts[0].partition(".")
        parts = [whole[:-4], whole[-4:-2], whole[-2:] + point + fraction]
    try:
        hours, minutes, seconds = (_digits(part) for part in parts)
    except ValueError:
        return nan
    return 3600 * hours + 60 * minutes + seconds if hours < 24 and minutes < 60 and seconds < 61 else nan


def _digits(part: str) -> float:
    if not (part[:1].isdigit() and part.isascii() and part.replace(".", "", 1).isdigit()):
        raise ValueError
    return float(part)


def _read_time_of_day(cells: Cells, decimal: str) -> FloatArray:
    points = [cell.replace(decimal, ".") for cell in cells] if decimal != "." else cells
    return np.fromiter(map(second_of_day, points), float, len(cells))


CLOCKS = MappingProxyType(
    {
        "seconds": Clock("Seconds", "Seconds, from any start or since 1970 (Unix).", 1.0, _read_numbers),
        "milliseconds": Clock("Milliseconds", "Milliseconds, from any start or since 1970.", 1e3, _read_numbers),
        "microseconds": Clock("Microseconds", "Microseconds, from any start or since 1970.", 1e6, _read_numbers),
        "iso": Clock("Date and time", "ISO 8601; UTC where no zone is given.", 1e6, _read_dates),
        "hms": Clock(
            "Time of day",
            "hhmmss as in NMEA, or hh:mm:ss; after midnight the next day.",
            1.0,
            _read_time_of_day,
            daily=True,
        ),
    }
)


def unroll(seconds: FloatArray) -> FloatArray:
    """Times of day in the order of a file, with a day added at every midnight.

    A step back by over half a day is a midnight. A step forward by over half a day, after a midnight, is a row of the
    day before that came late.
    """
    steps = np.diff(seconds)
    turns = np.zeros(len(steps))
    day = 0
    for place in np.flatnonzero(np.abs(steps) > DAY / 2):
        turn = 1 if steps[place] < 0 else -1 if day > 0 else 0
        turns[place] = turn
        day += turn
    return seconds + DAY * np.concatenate(([0.0], np.cumsum(turns)))[: len(seconds)]


def start_of(clock: str, ticks: float) -> str:
    """The date and time of a tick in UTC; empty where the clock counts from somewhere else than 1970."""
    seconds = ticks / CLOCKS[clock].per_second
    if clock != "iso" and (CLOCKS[clock].daily or not _SINCE_1970 < seconds < inf):
        return ""
    try:
        stamp = _EPOCH + timedelta(seconds=seconds)
    except OverflowError:
        return ""
    return stamp.isoformat(sep=" ", timespec="seconds" if stamp.microsecond == 0 else "milliseconds")[:-6] + " UTC"


_SINCE_1970 = 2e8
"""s: a lesser number is no date of a log (it would be of before May 1976)."""
