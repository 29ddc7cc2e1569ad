"""Which column is the time, and how it is written."""

from __future__ import annotations

from itertools import pairwise

from tracker_core.recordings.choose_position import POSITIONS
from tracker_core.recordings.layout import Layout
from tracker_core.recordings.names import Name
from tracker_core.recordings.proposal import Proposal, titled

_TIMES = (
    "time", "timestamp", "t", "times", "ts", "epoch", "unixtime", "unix", "datetime", "basedatetime", "timeutc",
    "utctime", "utc", "gpstime", "posixtime", "snapshotts", "lastupdate", "seconds", "sec", "secs", "s", "millis", "ms",
    "date", "hms", "hhmmss", "dt", "elapsed", "tod",
)  # fmt: skip
_TIMES_OF_DAY = ("utc", "hms", "hhmmss", "nmea", "tod", "gps")
_NO_TIMES = POSITIONS | {"sample", "index", "row", "no", "nr", "n", "k", "i", "id", "number", "count"}

_COUNTERS = frozenset({
    "sample", "samples", "n", "k", "i", "idx", "index", "frame", "scan", "row", "step", "cycle", "counter", "count",
    "number", "nr", "no", "seq", "sequence", "tick", "ticks", "update", "iteration",
})  # fmt: skip
_OF_COUNTERS = _COUNTERS | {"id", "num"}


def choose_time(made: Proposal, layout: Layout, names: list[Name]) -> None:
    """Choose the column of the time and its clock: by name, by what it holds, or because it counts or rises first."""
    timed = {"number", "date", "clock"}
    wholes = [name.whole for name in names]
    named = [wholes.index(known) for known in _TIMES if known in wholes]
    # A date alone beside a time of day is no time; the time of day is one.
    column = next((c for c in named if layout.kinds[c] in timed and not _is_day(layout, c)), None)
    if column is None:
        column = next((c for c, kind in enumerate(layout.kinds) if kind in {"date", "clock"}), None)
    why = "Its name says so." if column in named else "It holds dates or times."
    counter = _counter(layout, names) if column is None else None
    if counter is not None:
        why = "counts whole numbers up, and no column is a time. One second a count is assumed; its gaps are kept."
        made.choose("time", counter + 1, f"{titled(layout, counter)}: {why}")
        made.choose("clock", "seconds", f"{titled(layout, counter)} is a counter: T = 1 s a count is assumed.")
        return
    if column is None:
        numeric = [c for c, kind in enumerate(layout.kinds) if kind == "number"]
        if len(numeric) > 1 and _may_be_time(names[numeric[0]]) and _rises(layout.values(numeric[0])):
            column, why = numeric[0], "It is the first column of numbers, and they rise."
    if column is None:
        made.choose("time", 0, "No column looks like a time: say the interval between two rows.")
        return
    made.choose("time", column + 1, f"{titled(layout, column)}: {why[0].lower()}{why[1:]}")
    clock, why = _clock(layout, column, names[column])
    made.choose("clock", clock, why)


def _counter(layout: Layout, names: list[Name]) -> int | None:
    """The first column that by name and values counts samples."""
    # Of the axes e, n, u the second is no counter.
    axes = {"e", "u"} & {name.whole for name in names}
    for column, name in enumerate(names):
        named = not _COUNTERS.isdisjoint(name.words) and _OF_COUNTERS.issuperset(name.words)
        if named and layout.kinds[column] == "number" and not (axes and name.whole == "n"):
            values = layout.values(column)
            if _rises(values) and all(value.is_integer() for value in values):
                return column
    return None


def _may_be_time(name: Name) -> bool:
    return _NO_TIMES.isdisjoint({name.whole, *name.words})


def _is_day(layout: Layout, column: int) -> bool:
    cells = layout.cells(column)
    return (
        layout.kinds[column] == "date" and not any(":" in cell for cell in cells) and len(set(cells)) * 2 <= len(cells)
    )


def _rises(values: list[float]) -> bool:
    return len(values) > 1 and all(later > earlier for earlier, later in pairwise(values))


def _clock(layout: Layout, column: int, name: Name) -> tuple[str, str]:
    if layout.kinds[column] == "date":
        aware = any(cell.strip().endswith(("Z", "z", "UTC")) or _zone(cell) for cell in layout.cells(column))
        note = "" if aware else " No zone is given: taken as UTC."
        return "iso", f"Its cells are dates and times (ISO 8601).{note}"
    if layout.kinds[column] == "clock":
        return "hms", "Its cells are times of day; the day after begins at midnight."
    if _looks_like_hhmmss(layout.cells(column), name):
        return "hms", "Its numbers are hhmmss, as in NMEA sentences."
    if name.unit in {"ms", "us"} or name.whole in {"ms", "millis"}:
        clock = "microseconds" if name.unit == "us" else "milliseconds"
        return clock, f"Its name says {clock}."
    values = sorted(abs(value) for value in layout.values(column))
    middle = values[len(values) // 2] if values else 0.0
    if middle >= 1e14:
        return "microseconds", "Its numbers are microseconds since 1970."
    if middle >= 1e11:
        return "milliseconds", "Its numbers are milliseconds since 1970."
    return "seconds", "Its numbers are seconds since 1970." if middle >= 2e8 else "Numbers, taken as seconds."


def _zone(cell: str) -> bool:
    tail = cell.strip()[-6:]
    return tail[:1] in {"+", "-"} and tail[3:4] == ":"


def _looks_like_hhmmss(cells: list[str], name: Name) -> bool:
    heads = [cell.strip().partition(".")[0] for cell in cells]
    valid = all(
        len(head) == 6 and head.isdigit() and head < "240000" and head[2:4] < "60" and head[4:] < "60" for head in heads
    )
    hinted = any(word in name.words for word in _TIMES_OF_DAY) or any(head.startswith("0") for head in heads)
    return bool(heads) and valid and hinted
