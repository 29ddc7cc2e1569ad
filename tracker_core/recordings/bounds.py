"""How much a file may hold. An error names the bound it met, and what to do."""

from __future__ import annotations

from tracker_core.checks import InputError


class BoundError(InputError):
    """A file holds more than is read, however it is read."""


MOST_BYTES = 10_000_000
"""Of the file as it comes."""

MOST_UNPACKED = 40_000_000
"""Bytes, of a packed file's content."""

MOST_ROWS = 200_000
"""Rows of a table; also samples of a recording, those of its gaps included."""

MOST_LINES = 2 * MOST_ROWS
"""Lines of a file, blank ones and comments included."""

MOST_COLUMNS = 1_000

MOST_CELLS = 6_000_000
"""Rows times columns."""

MOST_CELL = 10_000
"""Characters of a cell."""

MOST_LINE = 100_000
"""Characters of a line; fewer than the csv module admits in one cell."""

MOST_LISTED = 1_000
"""Findings that are listed; all are counted."""

MOST_TRACKS = 1_000
"""Ids of tracks that are listed."""

MOST_UNCLOSED = 200
"""Quotation marks that open a cell and are never closed."""

ID_LENGTH = 100
"""Characters of a track's id that are looked at."""

SHOWN = 80
"""Characters of a cell that are shown."""

FEWEST = 3
"""Measurements."""

FAR = 1e9
"""Greatest magnitude of a position that is taken, m: beyond the moon."""

LATE = 1e11
"""Greatest magnitude of a time that is taken, s: the year 5138."""


def clip(text: str) -> str:
    """`text` in one line of at most SHOWN characters."""
    text = " ".join(text[: 2 * SHOWN].split())
    return text if len(text) <= SHOWN else text[: SHOWN - 1] + "…"
