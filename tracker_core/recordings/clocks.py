"""How a time is written, and its seconds.

A clock reads cells to ticks, of which it has `per_second` a second: whole microseconds stay whole numbers until the
first of them is subtracted, so that no digit of a date is lost.
"""

from __future__ import annotations

import re
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
_FIRST_DAY = _EPOCH.toordinal()


def microseconds(cell: str) -> float:
    """Microseconds from 1970 (UTC) to a date and time of ISO 8601; one without a zone is taken as UTC.

    Also taken: slashes for hyphens, and "UTC" after a blank for the zone. NaN for anything else.
    """
    try:
        stamp = datetime.fromisoformat(cell)
    except ValueError:
        try:
            stamp = datetime.fromisoformat(cell.strip().replace("/", "-").removesuffix(" UTC"))
        except ValueError:
            return nan
    # By hand: a difference of two dates with zones takes five times as long.
    hours = 24 * (stamp.toordinal() - _FIRST_DAY) + stamp.hour
    seconds: float = 3600 * hours + 60 * stamp.minute + stamp.second
    if stamp.tzinfo not in {None, UTC}:
        offset = stamp.utcoffset()
        seconds -= offset.total_seconds() if offset else 0
    return 1e6 * seconds + stamp.microsecond


def _read_dates(cells: Cells, decimal: str) -> FloatArray:
    del decimal  # ISO 8601 admits both
    return np.fromiter(map(microseconds, cells), float, len(cells))


# Colons between all three, or none; a minute that ends with a leap second has 61.
_TIME_OF_DAY = re.compile(r"\s*([01]?[0-9]|2[0-3])(:?)([0-5][0-9])\2((?:[0-5][0-9]|60)(?:\.[0-9]*)?)\s*")


def second_of_day(cell: str) -> float:
    """Seconds since midnight of hhmmss or hh:mm:ss, with or without a fraction. NaN for anything else."""
    found = _TIME_OF_DAY.fullmatch(cell)
    if not found:
        return nan
    hours, _, minutes, seconds = found.groups()
    return 3600 * int(hours) + 60 * int(minutes) + float(seconds)


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
