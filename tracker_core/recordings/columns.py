"""The chosen columns of a file as numbers, row by row as they stand there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from tracker_core.checks import InputError
from tracker_core.recordings.bounds import ID_LENGTH, LATE
from tracker_core.recordings.clocks import CLOCKS
from tracker_core.recordings.content import Content
from tracker_core.recordings.findings import Ledger
from tracker_core.recordings.numbers import NOTHING, Cells, numbers, split
from tracker_core.recordings.reading import DECIMALS, DELIMITERS, Reading
from tracker_core.recordings.rows import Row, pieces
from tracker_core.types import BoolArray, FloatArray, IntArray

PARTS = {
    "plane": ("x", "y", "z"),
    "geographic": ("latitude", "longitude", "altitude"),
    "polar": ("range", "bearing", "elevation"),
}
"""What the columns of a position hold, by frame."""


@dataclass(frozen=True, slots=True)
class Columns:
    """The rows that have a time, in the order of the file.

    Attributes:
        ticks: shape (n,), of the clock of the reading; of rows without a column of the time, s from the first.
        positions: shape (n, axes), in the units of the file; NaN where there is no number.
        truth: the same of the true position; shape (n, 0) where the reading names none.
        lines: shape (n,), number in the file, from 1.
        rows: how many rows the table has, the names not counted.
        others: how many of them belong to other tracks.
    """

    ticks: FloatArray
    positions: FloatArray
    truth: FloatArray
    lines: IntArray
    rows: int
    others: int


def columns(content: Content, reading: Reading, ledger: Ledger) -> Columns:
    """The columns that a reading names.

    Raises:
        InputError: when no row is wide enough, no row belongs to the track, or a bound is passed.
    """
    parts = []
    count = others = 0
    with content.open() as stream:
        table = pieces(stream, DELIMITERS[reading.delimiter], ledger)
        for piece in _bodies(table, reading, ledger):
            own = _of_track(piece, reading)
            if own:
                parts.append(_convert(own, reading, ledger, count - others))
            count += len(piece)
            others += len(piece) - len(own)
    if not parts:
        if count:
            raise InputError("only", "must be the id of a track in this file", reading.only)
        raise InputError("rows", "must follow the names", "none")
    ticks, positions, truth, lines = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Columns(ticks, positions, truth, lines, count, others)


def _bodies(table: Iterable[list[Row]], reading: Reading, ledger: Ledger) -> Iterator[list[Row]]:
    """The rows after the names, or all of them."""
    widest, needed = 0, reading.columns
    begun = False
    for piece in table:
        if begun:
            yield piece
            continue
        width = [len(row) for _, row in piece]
        first = next((place for place, cells in enumerate(width) if cells >= needed), None)
        begun = first is not None
        if reading.header:
            for number, row in piece[:first]:
                ledger.add("before", number, ", ".join(row[:10]))
            yield [] if first is None else piece[first + 1 :]
        else:
            yield piece
        widest = max([widest, *width])
    if not begun:
        raise InputError("columns", f"must be at least {needed}, as the reading says: check the delimiter", widest)


def _of_track(piece: list[Row], reading: Reading) -> list[Row]:
    if not reading.track:
        return piece
    own = zip(piece, column_of(piece, reading.track), strict=True)
    return [row for row, cell in own if track_id(cell) == reading.only]


def track_id(cell: str) -> str:
    """The id of a track as it is compared and listed."""
    return cell.strip()[:ID_LENGTH]


def column_of(piece: list[Row], column: int) -> list[str]:
    """The cells of one column, counted from 1; empty where a row is too short."""
    try:
        return [row[column - 1] for _, row in piece]
    except IndexError:
        return [row[column - 1] if len(row) >= column else "" for _, row in piece]


_Numbers = tuple[FloatArray, FloatArray, FloatArray, IntArray]


def _convert(piece: list[Row], reading: Reading, ledger: Ledger, before: int) -> _Numbers:
    lines = np.fromiter((number for number, _ in piece), np.int64, len(piece))
    needed = reading.columns
    for number, row in piece:
        if len(row) < needed:
            ledger.add("short", number, f"{len(row)} of {needed} columns")
    ticks, timed = _times(piece, reading, ledger, before)
    if not timed.all():
        piece = [row for row, good in zip(piece, timed, strict=True) if good]
        ticks, lines = ticks[timed], lines[timed]
    positions = _positions(piece, reading, reading.at, ledger, "position")
    truth = _positions(piece, reading, reading.truth, ledger, "truth")
    return ticks, positions, truth, lines


def _times(piece: list[Row], reading: Reading, ledger: Ledger, before: int) -> tuple[FloatArray, BoolArray]:
    if not reading.time:
        return np.arange(before, before + len(piece), dtype=np.float64) * reading.interval, np.ones(
            len(piece), dtype=bool
        )
    clock = CLOCKS[reading.clock]
    cells = column_of(piece, reading.time)
    ticks = clock.read(cells, DECIMALS[reading.decimal])
    timed = np.asarray(np.abs(ticks) <= LATE * clock.per_second)
    untimed = np.flatnonzero(~timed).tolist()
    ledger.add_all("time", len(untimed), ((piece[place][0], cells[place].strip() or "empty") for place in untimed))
    return ticks, timed


def _positions(piece: list[Row], reading: Reading, chosen: tuple[int, ...], ledger: Ledger, kind: str) -> FloatArray:
    """The numbers of the chosen columns; what is none is noted, once a row."""
    values = np.empty((len(piece), len(chosen)))
    wrong = np.zeros((len(piece), len(chosen)), dtype=bool)
    cells_of: list[Cells] = []
    for axis, column in enumerate(chosen):
        cells: Cells = column_of(piece, column)
        decimal = DECIMALS[reading.decimal]
        if chosen.count(column) > 1:
            cells, decimal = _parts(cells, chosen[:axis].count(column), decimal), "."
        values[:, axis], wrong[:, axis] = numbers(cells, decimal)
        cells_of.append(cells)
    names = PARTS[reading.frame]
    found = np.flatnonzero(wrong.any(axis=1)).tolist()
    first = np.argmax(wrong, axis=1).tolist() if found else []
    texts = ((piece[place][0], f"{names[first[place]]}: {cells_of[first[place]][place]}") for place in found)
    ledger.add_all(kind, len(found), texts)
    if kind == "position":
        empty = np.isnan(values) & ~wrong
        found = np.flatnonzero(empty.any(axis=1)).tolist()
        missing = ((piece[place][0], _listed(names, empty[place])) for place in found)
        ledger.add_all("empty", len(found), missing)
    return values


def _listed(names: tuple[str, ...], chosen: BoolArray) -> str:
    return " and ".join(name for name, one in zip(names, chosen, strict=False) if one)


def _parts(cells: Cells, part: int, decimal: str) -> list[str]:
    """One of several numbers in a cell, as in "(51.5, -0.1)"; the whole cell where it has not so many."""
    return [
        parts[part] if part < len(parts) else "" if cell.strip().lower() in NOTHING else cell
        for parts, cell in ((split(cell, decimal), cell) for cell in cells)
    ]
