"""The rows of a table, by Python's csv module, one after the other.

Blank lines and comments are left out, and so is the line `sep=;` that spreadsheets write. A cell in quotation marks may
go over lines, but only over so many: a mark that is never closed costs its own line and no more.
"""

from __future__ import annotations

import csv
from collections import deque
from collections.abc import Iterator
from typing import TextIO

from tracker_core.checks import InputError
from tracker_core.recordings.bounds import (
    MOST_CELL,
    MOST_CELLS,
    MOST_COLUMNS,
    MOST_LINE,
    MOST_LINES,
    MOST_ROWS,
    MOST_UNCLOSED,
    clip,
)
from tracker_core.recordings.findings import Ledger

COMMENTS = ("#", "%", "//")

SPAN = 20
"""Lines that a cell in quotation marks may go over."""

Row = tuple[int, list[str]]
"""Number of its first line in the file, from 1, and its cells."""


class _NotClosedError(Exception):
    pass


class _Lines:
    """Lines that are part of the table, with those of the row that is being read at hand to be given again."""

    def __init__(self, stream: TextIO, *, blanks: bool) -> None:
        self._read = stream.readline
        self._blanks = blanks
        self._again: deque[tuple[int, str]] = deque()
        self._number = 0
        self.row: list[tuple[int, str]] = []
        self.ended = False

    def __iter__(self) -> _Lines:
        return self

    def __next__(self) -> str:
        if len(self.row) == SPAN:
            raise _NotClosedError
        number, line = self._again.popleft() if self._again else self._fresh()
        self.row.append((number, line))
        return line

    def _fresh(self) -> tuple[int, str]:
        while True:
            line = self._read(MOST_LINE + 1)
            if not line:
                self.ended = True
                raise StopIteration
            self._number += 1
            if self._number > MOST_LINES:
                raise InputError("lines", f"must be at most {MOST_LINES:,}: thin the file out", "more")
            if len(line) > MOST_LINE:
                rule = f"must have at most {MOST_LINE:,} characters: is this a table?"
                raise InputError(f"line {self._number}", rule, f"more: {clip(line)}")
            if line.isspace() or line.lstrip().startswith(COMMENTS) or (self._number == 1 and _is_hint(line)):
                continue
            return self._number, " ".join(line.split()) + "\n" if self._blanks else line

    def back(self) -> Row:
        """Give the lines of this row again, but for the first, which is returned."""
        first, *others = self.row
        self._again.extendleft(reversed(others))
        self.row.clear()
        self.ended = False
        return first[0], [first[1]]


def _is_hint(line: str) -> bool:
    return len(line.strip()) <= 5 and line[:4].lower() == "sep="


def rows(stream: TextIO, delimiter: str, ledger: Ledger) -> Iterator[Row]:
    """The rows of a table.

    Args:
        stream: of text, with the ends of its lines.
        delimiter: one character; a blank stands for any run of them.
        ledger: where lines are noted that open a quotation mark and do not close it.

    Raises:
        InputError: naming the bound that the table passes.
    """
    lines = _Lines(stream, blanks=delimiter == " ")
    reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=delimiter != " ")
    count = cells = unclosed = 0
    while True:
        lines.row.clear()
        try:
            row = next(reader)
            if lines.ended and len(lines.row) > 1:
                raise _NotClosedError
        except StopIteration:
            return
        except (_NotClosedError, csv.Error):
            number, (line,) = lines.back()
            unclosed += 1
            ledger.add("quote", number, line)
            if unclosed > MOST_UNCLOSED:
                rule = f"must be closed but for {MOST_UNCLOSED:,} at most: check the delimiter"
                raise InputError("quotation marks", rule, f"more, in line {number}") from None
            continue
        count += 1
        cells += len(row)
        number, line = lines.row[0]
        _check(row, number, count, cells, long=len(line) > MOST_CELL or len(lines.row) > 1)
        yield number, row


def _check(row: list[str], number: int, count: int, cells: int, *, long: bool) -> None:
    if count > MOST_ROWS:
        raise InputError("rows", f"must be at most {MOST_ROWS:,}: thin the file out or split it", "more")
    if len(row) > MOST_COLUMNS:
        rule = f"must be at most {MOST_COLUMNS:,}: check the delimiter, or leave columns out"
        raise InputError("columns", rule, f"{len(row):,} in line {number}")
    if cells > MOST_CELLS:
        rule = f"(rows times columns) must be at most {MOST_CELLS:,}: leave columns out"
        raise InputError("cells", rule, f"more, in line {number}")
    if long and max(map(len, row)) > MOST_CELL:
        longest = max(row, key=len)
        rule = f"must have at most {MOST_CELL:,} characters"
        raise InputError("cell", rule, f"{len(longest):,} in line {number}: {clip(longest)}")
