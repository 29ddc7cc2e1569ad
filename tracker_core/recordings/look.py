"""A first look at a file: what it seems to be, and how to read it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

from tracker_core.checks import InputError
from tracker_core.recordings.bounds import MOST_TRACKS, BoundError, clip
from tracker_core.recordings.columns import column_of, track_id
from tracker_core.recordings.content import Content
from tracker_core.recordings.findings import Ledger
from tracker_core.recordings.layout import Layout, find_layout
from tracker_core.recordings.proposal import Proposal
from tracker_core.recordings.propose import propose
from tracker_core.recordings.read import read_content
from tracker_core.recordings.reading import DELIMITERS, Reading
from tracker_core.recordings.rows import pieces

PREVIEWED = 8
"""Rows that are shown."""

_FIRST_VALUES = 3

_MOST_HELD = 0.5
"""Share of held positions over which the target may well stand still."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a file.

    Attributes:
        number: from 1.
        name: as it stands in the file, as text and never interpreted; empty where there is none.
        kind: "number", "date", "clock", "pair", "text" or "empty".
        first: its first values.
    """

    number: int
    name: str
    kind: str
    first: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Look:
    """What a file seems to be.

    Attributes:
        format: what it was recognised as.
        encoding: how its letters are coded.
        packed: whether it came as gzip.
        columns: of the table.
        rows: how many rows it has, the names not counted.
        reading: how to read it.
        why: a sentence for every field of the reading that was chosen.
        tracks: ids in the column that tells tracks apart with their rows, most rows first; at most MOST_TRACKS.
        preview: the first rows with their line numbers, cells clipped.
    """

    format: str
    encoding: str
    packed: bool
    columns: tuple[Column, ...]
    rows: int
    reading: Reading
    why: dict[str, str]
    tracks: tuple[tuple[str, int], ...]
    preview: tuple[tuple[int, tuple[str, ...]], ...]


def look(data: bytes) -> Look:
    """What a file seems to be and how to read it: a proposal, every field of which may be changed.

    Args:
        data: the bytes of the file, packed by gzip or not.

    Raises:
        InputError: when the file passes a bound, or holds no rows of text.
    """
    content = Content(data)
    layout = find_layout(content)
    made = propose(layout)
    count, ids = _count(content, layout.delimiter, made.ids) if made.ids else (None, [])
    tracks = _choose_track(made, layout, ids)
    reading, rows = _with_held(content, Reading(**made.values), made)  # type: ignore[arg-type]
    if rows is None:
        rows = count or _count(content, layout.delimiter, [])[0]
        rows -= layout.header
    return Look(
        format=made.format,
        encoding=content.encoding,
        packed=content.packed,
        columns=_columns(layout),
        rows=rows,
        reading=reading,
        why=made.why,
        tracks=tracks,
        preview=tuple((number, tuple(map(clip, row))) for number, row in layout.rows[:PREVIEWED]),
    )


def tracks(data: bytes, reading: Reading, column: int) -> tuple[tuple[str, int], ...]:
    """The ids in a column with their rows, most rows first; at most MOST_TRACKS.

    Args:
        data: the bytes of the file, packed by gzip or not.
        reading: delimiter and header are taken from it.
        column: from 1.

    Raises:
        InputError: when the file passes a bound.
    """
    _, (ids,) = _count(Content(data), reading.delimiter, [column], skip=int(reading.header))
    return _most(ids)


def _columns(layout: Layout) -> tuple[Column, ...]:
    return tuple(
        Column(index + 1, clip(name), kind, tuple(map(clip, layout.cells(index)[:_FIRST_VALUES])))
        for index, (name, kind) in enumerate(zip(layout.names, layout.kinds, strict=True))
    )


def _count(content: Content, delimiter: str, columns: Iterable[int], skip: int = 0) -> tuple[int, list[Counter[str]]]:
    """The number of rows, and how often every id stands in each of some columns."""
    ids: list[tuple[int, Counter[str]]] = [(column, Counter()) for column in columns]
    count = 0
    with content.open() as stream:
        for piece in pieces(stream, DELIMITERS[delimiter], Ledger()):
            for column, counter in ids:
                counter.update(map(track_id, column_of(piece[max(skip - count, 0) :], column)))
            count += len(piece)
    return count, [counter for _, counter in ids]


def _most(ids: Counter[str]) -> tuple[tuple[str, int], ...]:
    return tuple((name, count) for name, count in ids.most_common(MOST_TRACKS + 1) if name)[:MOST_TRACKS]


def _choose_track(made: Proposal, layout: Layout, ids: list[Counter[str]]) -> tuple[tuple[str, int], ...]:
    """The first column whose ids come again and again, and its most frequent id."""
    for column, counter in zip(made.ids, ids, strict=True):
        if layout.header:
            counter[layout.names[column - 1]] -= 1
        found = tuple((name, count) for name, count in _most(counter) if count > 0)
        if len(found) > 1 and 3 * len(found) <= sum(counter.values()):
            why = f"“{layout.names[column - 1][:40]}” holds {len(found):,} ids; the most frequent is read."
            made.choose("track", column, why)
            made.choose("only", found[0][0], why)
            return found
    return ()


def _with_held(content: Content, reading: Reading, made: Proposal) -> tuple[Reading, int | None]:
    """The reading, with held positions missing where they are some but not most; the rows if it can be read."""
    try:
        recorded = read_content(content, reading)
    except BoundError:
        raise
    except InputError:
        return reading, None
    held, measured = recorded.counts.get("held", 0), recorded.measured
    if not 0 < held <= _MOST_HELD * measured:
        if held:
            made.why["held"] = f"{held:,} of {measured:,} positions repeat the one before: it may stand still."
        return reading, recorded.rows
    made.why["held"] = f"{held:,} of {measured:,} positions repeat the one before: the sensor held its last."
    return replace(reading, held="missing"), recorded.rows
