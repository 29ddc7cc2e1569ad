"""Bytes and a reading to a recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from tracker_core.checks import InputError
from tracker_core.recordings.bounds import FEWEST
from tracker_core.recordings.clocks import CLOCKS, start_of, unroll
from tracker_core.recordings.columns import PARTS, Columns, columns
from tracker_core.recordings.content import Content
from tracker_core.recordings.findings import KINDS, Ledger
from tracker_core.recordings.frames import beyond, joined, origin_of, to_metres
from tracker_core.recordings.reading import Reading
from tracker_core.recordings.recorded import Recorded
from tracker_core.recordings.timing import LONG, Grid, find_grid, regularity
from tracker_core.types import BoolArray, FloatArray, IntArray

_Cell = TypeVar("_Cell", bound=np.generic)


@dataclass(slots=True)
class _Rows:
    """Rows in the order of time."""

    ticks: FloatArray
    positions: FloatArray
    truth: FloatArray
    lines: IntArray

    def take(self, places: IntArray) -> _Rows:
        return _Rows(self.ticks[places], self.positions[places], self.truth[places], self.lines[places])


def read(data: bytes, reading: Reading) -> Recorded:
    """The recording in a file.

    Rows are put in the order of time, one for each; what is left out, moved or taken as missing is counted and listed.
    Where the interval is constant, times are whole multiples of it and gaps hold samples without a measurement, as long
    as there are no more than MOST_ROWS of them; else times are as stamped.

    Args:
        data: the bytes of the file, packed by gzip or not.
        reading: how it is read.

    Raises:
        InputError: when the file passes a bound, does not fit the reading, or holds less than FEWEST measurements.
    """
    return read_content(Content(data), reading)


def read_content(content: Content, reading: Reading) -> Recorded:
    """As `read`, of a file that was unpacked before."""
    ledger = Ledger()
    if content.encoding == "latin-1":
        ledger.add("encoding", 0, "read as Latin-1")
    table = columns(content, reading, ledger)
    found = _in_time(_admitted(table, reading, ledger), reading, ledger)
    held = _mark_held(found, reading, ledger)
    place = origin_of(found.positions, reading)
    positions = to_metres(found.positions, reading, place)
    measured = int(np.isfinite(positions).any(axis=1).sum())
    if measured < FEWEST:
        raise InputError("rows", _too_few(ledger), f"{measured} measurements in {table.rows:,} rows")
    truth = to_metres(found.truth, reading, place) if reading.truth else np.empty((len(positions), 0))
    per_second = CLOCKS[reading.clock].per_second if reading.time else 1.0
    times = (found.ticks - found.ticks[0]) / per_second
    grid = _grid(times, found.ticks[0] / per_second, reading)
    even = regularity(times, grid.interval if grid else None)
    _list_gaps(times, even.nominal, found.lines, ledger)
    if grid:
        times = grid.interval * np.arange(grid.samples[-1] + 1)
        positions, truth = (_spread(values, grid.samples) for values in (positions, truth))
    return Recorded(
        reading=reading,
        axes=reading.axes,
        times=times,
        positions=positions,
        truth=truth if reading.truth else None,
        interval=grid.interval if grid else None,
        regularity=even,
        lines=_spread_one(found.lines, grid),
        held=_spread_one(held, grid),
        start=start_of(reading.clock, float(found.ticks[0])) if reading.time else "",
        place=place,
        rows=table.rows,
        others=table.others,
        counts=ledger.counts,
        findings=ledger.listed(),
    )


def _too_few(ledger: Ledger) -> str:
    rule = f"must hold at least {FEWEST} with a time and a position"
    if not ledger.counts:
        return rule
    kind, count = max(ledger.counts.items(), key=lambda item: item[1])
    return f"{rule} (found most: {KINDS[kind].title.lower()}, {count:,} times)"


def _admitted(table: Columns, reading: Reading, ledger: Ledger) -> _Rows:
    """The rows with NaN for positions that cannot be."""
    names = PARTS[reading.frame]
    wrong = beyond(table.positions, reading)
    found = np.flatnonzero(wrong.any(axis=1))
    texts = (
        (
            int(table.lines[row]),
            ", ".join(f"{names[axis]} {table.positions[row, axis]:g}" for axis in _true(wrong[row])),
        )
        for row in found
    )
    ledger.add_all("beyond", len(found), texts)
    positions = joined(np.where(wrong, np.nan, table.positions), reading)
    truth = table.truth
    if reading.truth:
        wrong = beyond(truth, reading)
        found = np.flatnonzero(wrong.any(axis=1))
        ledger.add_all("truth", len(found), ((int(table.lines[row]), "out of range") for row in found))
        truth = joined(np.where(wrong, np.nan, truth), reading)
    ticks = unroll(table.ticks) if reading.time and CLOCKS[reading.clock].daily else table.ticks
    if not len(ticks):
        raise InputError("rows", _too_few(ledger), f"none in {table.rows:,} rows")
    return _Rows(ticks, positions, truth, table.lines)


def _true(mask: BoolArray) -> list[int]:
    return np.flatnonzero(mask).tolist()


def _in_time(table: _Rows, reading: Reading, ledger: Ledger) -> _Rows:
    """Sorted by time, one row each."""
    per_second = CLOCKS[reading.clock].per_second if reading.time else 1.0
    behind = np.maximum.accumulate(table.ticks) - table.ticks
    late = np.flatnonzero(behind > 0)
    texts = ((int(table.lines[row]), f"{behind[row] / per_second:.6g} s before a row above it") for row in late)
    ledger.add_all("order", len(late), texts)

    measured = np.isfinite(table.positions).any(axis=1)
    # Within a time those with a position first, then as in the file.
    order = np.lexsort((~measured, table.ticks))
    table = table.take(order)
    first = np.concatenate(([True], np.diff(table.ticks) > 0))
    kept = np.flatnonzero(first)
    again = np.flatnonzero(~first)
    original = kept[np.cumsum(first) - 1]
    again = again[np.argsort(table.lines[again])]
    ledger.add_all("duplicate", len(again), (_twice(table, int(row), int(original[row])) for row in again))
    return table.take(kept)


def _twice(table: _Rows, row: int, original: int) -> tuple[int, str]:
    same = np.array_equal(table.positions[row], table.positions[original], equal_nan=True)
    return int(table.lines[row]), f"{'same' if same else 'another'} position as in line {table.lines[original]}"


def _mark_held(table: _Rows, reading: Reading, ledger: Ledger) -> BoolArray:
    """Note positions that are exactly those of the measurement before, and take them away if the reading says so.

    Returns:
        Which they are, shape (n,).
    """
    whole = np.flatnonzero(np.isfinite(table.positions).all(axis=1))
    same = (table.positions[whole[1:]] == table.positions[whole[:-1]]).all(axis=1)
    held, before = whole[1:][same], whole[:-1][same]
    texts = (
        (int(table.lines[row]), f"as in line {table.lines[first]}") for row, first in zip(held, before, strict=True)
    )
    ledger.add_all("held", len(held), texts)
    if reading.held == "missing":
        table.positions[held] = np.nan
    marked = np.zeros(len(table.lines), dtype=bool)
    marked[held] = True
    return marked


def _grid(times: FloatArray, offset: float, reading: Reading) -> Grid | None:
    if not reading.time:
        return Grid(reading.interval, np.arange(len(times)))
    return find_grid(times, offset)


def _list_gaps(times: FloatArray, nominal: float, lines: IntArray, ledger: Ledger) -> None:
    steps = np.diff(times)
    gaps = np.flatnonzero(steps > LONG * nominal)
    texts = ((int(lines[gap + 1]), f"{steps[gap]:.6g} s instead of {nominal:.6g} s") for gap in gaps)
    ledger.add_all("gap", len(gaps), texts)


def _spread(values: FloatArray, samples: IntArray) -> FloatArray:
    """Rows at their sample numbers, NaN between them."""
    spread = np.full((int(samples[-1]) + 1, values.shape[1]), np.nan)
    spread[samples] = values
    return spread


def _spread_one(values: NDArray[_Cell], grid: Grid | None) -> NDArray[_Cell]:
    """One value a row at its sample number, zero between them."""
    if grid is None:
        return values
    spread = np.zeros(int(grid.samples[-1]) + 1, dtype=values.dtype)
    spread[grid.samples] = values
    return spread
