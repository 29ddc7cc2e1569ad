"""The first rows of a file as a reading splits them, whether or not it can be read like that."""

from __future__ import annotations

from dataclasses import dataclass

from tracker_core.recordings.bounds import clip
from tracker_core.recordings.content import Content
from tracker_core.recordings.reading import DELIMITERS
from tracker_core.recordings.rows import Row, first_rows

PREVIEWED = 8
"""Rows after the names."""

_LOOKED_AT = 40


@dataclass(frozen=True, slots=True)
class Preview:
    """The first rows of a table, cells clipped and never interpreted.

    Attributes:
        names: of the columns; empty where there are none.
        rows: the first rows after them, with their line numbers.
    """

    names: tuple[str, ...]
    rows: tuple[Row, ...]

    @property
    def width(self) -> int:
        """The most cells that a row has."""
        return max(len(self.names), *(len(row) for _, row in self.rows), 0)


def preview(data: bytes, delimiter: str, *, header: bool) -> Preview:
    """The first rows of a file, split at a delimiter.

    Args:
        data: the bytes of the file, packed by gzip or not.
        delimiter: a name in DELIMITERS.
        header: whether the first row of the usual width holds names.

    Raises:
        InputError: when the file passes a bound within them.
    """
    with Content(data).open() as stream:
        head = first_rows(stream, DELIMITERS[delimiter], _LOOKED_AT)
    widths = sorted(len(row) for _, row in head)
    usual = widths[len(widths) // 2] if widths else 0
    first = next((place for place, (_, row) in enumerate(head) if len(row) >= usual), 0)
    names = head[first][1] if header and head else []
    body = head[first + bool(names) :][:PREVIEWED]
    return Preview(
        tuple(clip(name.strip()) for name in names), tuple((line, [clip(cell) for cell in row]) for line, row in body)
    )
