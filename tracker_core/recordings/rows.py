"""The rows of a table, by Python's csv module, piece by piece.

Blank lines and comments are left out, and so is the line `sep=;` that spreadsheets write. A cell in quotation marks may
go over lines, but only over so many: a mark that is never closed costs its own line and no more.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from itertools import chain, islice
from typing import Any, TextIO

from tracker_core.recordings.bounds import (
    MOST_CELL,
    MOST_CELLS,
    MOST_COLUMNS,
    MOST_LINE,
    MOST_LINES,
    MOST_ROWS,
    MOST_UNCLOSED,
    BoundError,
    clip,
)
from tracker_core.recordings.findings import Ledger

COMMENTS = ("#", "%", "//")

SPAN = 20
"""Lines that a cell in quotation marks may go over."""

Row = tuple[int, list[str]]
"""Number of its first line in the file, from 1, and its cells."""

_Lines = list[tuple[int, str]]

PIECE = 1 << 17
"""Characters that are split at a time: their cells fit a processor's cache."""


def pieces(stream: TextIO, delimiter: str, ledger: Ledger, size: int = PIECE) -> Iterator[list[Row]]:
    """The rows of a table, some thousand at a time.

    Args:
        stream: of text, whose lines end with a line feed each.
        delimiter: one character; a blank stands for any run of them.
        ledger: where lines are noted that open a quotation mark and do not close it.
        size: characters that are split at a time.

    Raises:
        BoundError: naming the bound that the table passes.
    """
    splitter = _Splitter(delimiter, ledger)
    waiting: _Lines = []
    count = cells = 0
    for lines in chain(_lines(stream, size), [None]):
        piece, waiting = splitter.split(waiting + (lines or []), last=lines is None)
        width = [len(row) for _, row in piece]
        count += len(piece)
        cells += sum(width)
        if count > MOST_ROWS:
            raise BoundError("rows", f"must be at most {MOST_ROWS:,}: thin the file out or split it", "more")
        if cells > MOST_CELLS:
            rule = f"(rows times columns) must be at most {MOST_CELLS:,}: leave columns out"
            raise BoundError("cells", rule, f"more, in line {piece[-1][0]}")
        if max(width, default=0) > MOST_COLUMNS:
            number, row = piece[width.index(max(width))]
            rule = f"must be at most {MOST_COLUMNS:,}: check the delimiter, or leave columns out"
            raise BoundError("columns", rule, f"{len(row):,} in line {number}")
        yield piece


def first_rows(stream: TextIO, delimiter: str, count: int) -> list[Row]:
    """The first rows of a table, `count` at most; see `pieces`."""
    return list(islice(chain.from_iterable(pieces(stream, delimiter, Ledger(), size=PIECE // 16)), count))


def _lines(stream: TextIO, size: int) -> Iterator[_Lines]:
    """The lines that are part of the table, with their numbers; piece by piece."""
    first, rest = 1, ""
    while text := stream.read(size):
        *lines, rest = (rest + text).split("\n")
        yield _of_table(lines, first)
        first += len(lines)
        if len(rest) > MOST_LINE:
            rule = f"must have at most {MOST_LINE:,} characters: is this a table?"
            raise BoundError(f"line {first}", rule, f"more: {clip(rest)}")
        if first > MOST_LINES:
            raise BoundError("lines", f"must be at most {MOST_LINES:,}: thin the file out", "more")
    yield _of_table([rest], first)


def _of_table(lines: list[str], first: int) -> _Lines:
    numbered: _Lines = [
        (number, line)
        for number, line in enumerate(lines, first)
        if (text := line.lstrip()) and not text.startswith(COMMENTS)
    ]
    hinted = numbered and numbered[0][0] == 1 and numbered[0][1][:4].lower() == "sep="
    return numbered[1:] if hinted and len(numbered[0][1].rstrip()) <= 5 else numbered


class _Splitter:
    """Lines to rows of cells."""

    def __init__(self, delimiter: str, ledger: Ledger) -> None:
        self._delimiter = delimiter
        self._ledger = ledger
        self._unclosed = 0

    def split(self, lines: _Lines, *, last: bool) -> tuple[list[Row], _Lines]:
        """The rows in some lines, and the lines at their end that need more to be told."""
        texts = [line for _, line in lines]
        if self._delimiter == " ":
            texts = [" ".join(text.split()) for text in texts]
        # A line more would be part of the row before it if a quotation mark were open.
        try:
            found = list(self._read([*texts, "."]))
        except csv.Error:
            found = []
        numbers = [number for number, _ in lines]
        if len(found) == len(lines) + 1:
            rest: _Lines = []
            split = list(zip(numbers, found[:-1], strict=True))
        else:
            split, rest = self._over_lines(lines, [text + "\n" for text in texts], last=last)
        if len(found) != len(lines) + 1 or max(map(len, texts), default=0) > MOST_CELL:
            _check_cells(split)
        return split, rest

    def _read(
        self, texts: Iterable[str], *, strict: bool = False
    ) -> Any:  # the class of its readers has no public name
        return csv.reader(texts, delimiter=self._delimiter, skipinitialspace=self._delimiter != " ", strict=strict)

    def _over_lines(self, lines: _Lines, texts: list[str], *, last: bool) -> tuple[list[Row], _Lines]:
        """The same where a row goes over lines, or a mark is not closed.

        Rows are read strictly: a stray mark is closed by the one that opens a later cell, and what follows that is then
        an error. A line that is whole by itself may be as it likes.
        """
        found: list[Row] = []
        begin = 0
        while begin < len(lines):
            reader, first = self._read(chain(islice(texts, begin, None), "."), strict=True), begin
            while begin < len(lines):
                try:
                    row = next(reader)
                except csv.Error:
                    row = None
                end = first + reader.line_num
                if row is None and end == begin + 1:
                    row = self._alone(texts[begin])
                if row is None or end > min(begin + SPAN, len(lines)):
                    break
                number, line = lines[begin]
                found.append((number, row))
                if end > begin + 1:
                    self._ledger.add("lines", number, f"{end - begin} lines: {line}")
                begin = end
            if len(lines) - begin < SPAN and not last:
                return found, lines[begin:]
            if begin < len(lines):
                self._note(*lines[begin])
                begin += 1
        return found, []

    def _alone(self, text: str) -> list[str] | None:
        """The row in one line; None where a mark is left open."""
        try:
            found = list(self._read([text, "."]))
        except csv.Error:
            return None
        return found[0] if len(found) == 2 else None

    def _note(self, number: int, line: str) -> None:
        self._ledger.add("quote", number, line)
        self._unclosed += 1
        if self._unclosed > MOST_UNCLOSED:
            rule = f"must be closed but for {MOST_UNCLOSED:,} at most: check the delimiter"
            raise BoundError("quotation marks", rule, f"more, in line {number}")


def _check_cells(split: list[Row]) -> None:
    for number, row in split:
        longest = max(row, key=len, default="")
        if len(longest) > MOST_CELL:
            rule = f"must have at most {MOST_CELL:,} characters"
            raise BoundError("cell", rule, f"{len(longest):,} in line {number}: {clip(longest)}")
