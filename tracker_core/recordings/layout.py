"""The layout of a table, found from its first lines: delimiter, sign before a fraction, names, kinds of columns."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite

from tracker_core.checks import InputError
from tracker_core.recordings.bounds import MOST_COLUMNS, MOST_LINE
from tracker_core.recordings.clocks import microseconds, second_of_day
from tracker_core.recordings.content import Content
from tracker_core.recordings.numbers import NOTHING, number, split
from tracker_core.recordings.reading import DECIMALS, DELIMITERS
from tracker_core.recordings.rows import COMMENTS, Row, first_rows

LOOKED_AT = 200
"""Rows from which the layout is found."""

_ORDER = ("tab", "semicolon", "pipe", "comma", "space")
"""Where two fit equally well, the first is meant: it is the rarer one in texts and numbers."""

_WITH_COMMA = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*")
_PAIR_WITH_COMMAS = re.compile(r"\s*[(\[]?\s*[+-]?\d+,\d+(?:\s*;\s*|\s*,\s+|\s+)[+-]?\d+,\d+\s*[)\]]?\s*")
_PAIR = re.compile(r"\s*[(\[]?\s*[+-]?\d+(?:\.\d+)?\s*[,; ]\s*[+-]?\d+(?:\.\d+)?\s*[)\]]?\s*")

_LONGEST_PAIR = 100
"""Characters of a cell from which on it is not looked at as a pair."""


@dataclass(frozen=True, slots=True)
class Layout:
    """What the first rows of a table look like.

    Attributes:
        delimiter: a name in DELIMITERS.
        decimal: a name in DECIMALS.
        header: whether a row holds the names.
        names: of the columns, as they stand there; empty where there are none.
        kinds: what the cells of each column are: "number", "date", "clock" (hh:mm:ss), "pair", "text" or "empty".
        rows: the first rows after the names, with their line numbers.
    """

    delimiter: str
    decimal: str
    header: bool
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    rows: tuple[Row, ...]

    def cells(self, column: int) -> list[str]:
        """The first cells of a column, counted from 0, that are not empty."""
        cells = (row[column] for _, row in self.rows if column < len(row))
        return [cell for cell in cells if cell.strip().lower() not in NOTHING]

    def values(self, column: int) -> list[float]:
        """The first numbers of a column, counted from 0."""
        values = (number(self._point(cell)) for cell in self.cells(column))
        return [value for value in values if isfinite(value)]

    def _point(self, cell: str) -> str:
        return cell.replace(",", ".") if self.decimal == "comma" else cell


def find_layout(content: Content) -> Layout:
    """The layout of a table.

    Raises:
        InputError: when there is no row, or a bound is passed within the first.
    """
    delimiter, head = max(_tries(content), key=lambda found: _score(*found))
    if not head:
        raise InputError("file", "must hold rows of cells", "none")
    decimal = _decimal(delimiter, head)
    width = _width(head)
    # What stands before the first row of the usual width is no part of the table.
    first = next(place for place, (_, row) in enumerate(head) if len(row) >= width)
    head = head[first:]
    header = _is_header(head, decimal)
    body = tuple(head[1:] if header else head)
    names = head[0][1] if header else _commented_names(content, delimiter, width)
    widest = min(max(width, len(names), max((len(row) for _, row in body), default=0)), MOST_COLUMNS)
    names = [name.strip() for name in names] + [""] * (widest - len(names))
    kinds = tuple(_kind(body, column, decimal) for column in range(widest))
    return Layout(delimiter, decimal, header, tuple(names), kinds, body)


def _tries(content: Content) -> Iterable[tuple[str, list[Row]]]:
    for delimiter in _ORDER:
        with content.open() as stream:
            yield delimiter, first_rows(stream, DELIMITERS[delimiter], LOOKED_AT)


def _score(delimiter: str, head: list[Row]) -> tuple[float, int]:
    """How well a delimiter fits: numbers and times in a row, times the share of rows of the usual width."""
    if not head:
        return 0.0, -_ORDER.index(delimiter)
    width = _width(head)
    usual = [row for _, row in head if len(row) == width]
    comma = delimiter != "comma"
    cells = [cell for row in usual for cell in row]
    pairs = sum(map(_is_pair_with_commas, cells)) if comma else 0
    told = (sum(_tells(cell, comma=comma) for cell in cells) + 2 * pairs) / len(usual)
    share = len(usual) / len(head)
    # A table of one column has no delimiter, or the usual one.
    order = _ORDER.index(delimiter) if width > 1 else delimiter != "comma"
    return share * (told + 0.1 * (width > 1)), -order


def _width(head: list[Row]) -> int:
    """The usual number of cells; of two that are as usual, the greater."""
    counts = Counter(len(row) for _, row in head)
    return max(counts, key=lambda width: (counts[width], width))


def _tells(cell: str, *, comma: bool) -> bool:
    """Whether a cell is a number or a time."""
    return _is_number(cell) or (comma and bool(_WITH_COMMA.fullmatch(cell))) or _is_date(cell) or _is_clock(cell)


def _is_number(cell: str) -> bool:
    value = number(cell)
    return value == value


def _is_date(cell: str) -> bool:
    # Digits alone are a number, though 20240101 is a date of ISO 8601.
    value = microseconds(cell) if "-" in cell or "/" in cell else float("nan")
    return value == value


def _is_clock(cell: str) -> bool:
    value = second_of_day(cell) if ":" in cell else float("nan")
    return value == value


def _decimal(delimiter: str, head: list[Row]) -> str:
    cells = [cell for _, row in head for cell in row]
    with_comma = sum(bool(_WITH_COMMA.fullmatch(cell)) or _is_pair_with_commas(cell) for cell in cells)
    with_point = sum("." in cell and _is_number(cell) for cell in cells)
    # Between commas, a cell with a comma was quoted.
    return "comma" if with_comma > with_point and (delimiter != "comma" or with_comma >= len(head) // 2) else "point"


def _is_header(head: list[Row], decimal: str) -> bool:
    """Whether the first row holds names: text where the rows after it hold numbers or times."""
    first = head[0][1]
    comma = decimal == "comma"
    if len(head) == 1:
        return not any(_tells(cell, comma=comma) for cell in first)
    told = [
        column
        for column in range(len(first))
        if _kind(head[1:], column, decimal) in {"number", "date", "clock", "pair"}
    ]
    named = [not _tells(first[column], comma=comma) and first[column].strip().lower() not in NOTHING for column in told]
    return sum(named) * 2 > len(named) if named else True


def _commented_names(content: Content, delimiter: str, width: int) -> list[str]:
    """Names in the last comment before the first row, where it has as many cells."""
    last = ""
    with content.open() as stream:
        for _ in range(LOOKED_AT):
            line = stream.readline(MOST_LINE)
            text = line.strip()
            if text.startswith(COMMENTS):
                last = text.lstrip("#%/ \t")
            elif text or not line:
                break
    cells = last.split() if delimiter == "space" else next(csv.reader([last], delimiter=DELIMITERS[delimiter]), [])
    return cells if len(cells) == width else []


def _kind(body: Iterable[Row], column: int, decimal: str) -> str:
    """What most cells of a column are that are not empty."""
    counts: Counter[str] = Counter()
    for _, row in body:
        cell = row[column] if column < len(row) else ""
        if cell.strip().lower() in NOTHING:
            continue
        if _is_number(cell) or (decimal == "comma" and _WITH_COMMA.fullmatch(cell)):
            counts["number"] += 1
        elif _is_clock(cell):
            counts["clock"] += 1
        elif _is_date(cell):
            counts["date"] += 1
        else:
            counts["pair" if _is_pair(cell, decimal) else "text"] += 1
    return max(counts, key=lambda kind: counts[kind]) if counts else "empty"


def _is_pair(cell: str, decimal: str) -> bool:
    if len(cell) >= _LONGEST_PAIR:
        return False
    if decimal == "point":
        return bool(_PAIR.fullmatch(cell))
    parts = split(cell, DECIMALS[decimal])
    return len(parts) == 2 and all(map(_is_number, parts))


def _is_pair_with_commas(cell: str) -> bool:
    """Whether a cell holds two numbers that tell the decimal sign: the commas in them are none between cells."""
    return "," in cell and len(cell) < _LONGEST_PAIR and bool(_PAIR_WITH_COMMAS.fullmatch(cell))
