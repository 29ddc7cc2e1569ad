"""Cells as numbers, whole columns at a time."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import nan

import numpy as np

from tracker_core.types import BoolArray, FloatArray

Cells = Sequence[str]

NOTHING = frozenset({"", "-", "--", "nan", "none", "null", "na", "n/a", "#n/a", "\\n", "nil", "missing"})
"""How programs write that there is no number, in small letters."""

_BETWEEN = re.compile(r"[,;\s]+")
_BETWEEN_COMMAS = re.compile(r"\s*;\s*|\s*,\s+|\s+")
_POINTED = re.compile(r"[+-]?\d+\.\d+(?:(?:\s*[,;]\s*|\s+)[+-]?\d+\.\d+)+")

_BEGINNINGS = frozenset("0123456789+-.iInN")


def numbers(cells: Cells, decimal: str = ".") -> tuple[FloatArray, BoolArray]:
    """The numbers in cells.

    Args:
        cells: texts.
        decimal: the sign before a fraction.

    Returns:
        The values, NaN for what is none, and which of those are some other text instead of nothing; each of shape
        (n_cells,). Values may be infinite.
    """
    if decimal != ".":
        # A point in such a file would group thousands: it must not pass for a fraction.
        cells = [cell.replace(".", "_").replace(decimal, ".") for cell in cells]
    try:
        # Python admits 1_000; no other program writes that.
        if "_" not in "".join(cells):
            values = np.fromiter(map(float, cells), float, len(cells))
            return values, np.zeros(len(cells), dtype=bool)
    except ValueError:
        pass
    values = np.fromiter(map(number, cells), float, len(cells))
    wrong = np.isnan(values)
    suspects = np.flatnonzero(wrong).tolist()
    wrong[suspects] = [cells[place].strip().lower() not in NOTHING for place in suspects]
    return values, wrong


def number(cell: str) -> float:
    """The number in a cell with a decimal point; NaN where there is none."""
    # An error that is raised takes ten times as long as a look at the first character.
    if cell.lstrip()[:1] not in _BEGINNINGS or "_" in cell:
        return nan
    try:
        return float(cell)
    except ValueError:
        return nan


def split(cell: str, decimal: str = ".") -> list[str]:
    """The numbers in a cell that holds several, as in "(51.5, -0.1)", each with a decimal point.

    With another sign before the fraction a comma separates only if a blank follows it, as in "51,5 -0,1",
    "51,5; -0,1" and "51,5, -0,1"; numbers that all have points are taken as they are.
    """
    text = cell.strip(" ()[]")
    if decimal == "." or _POINTED.fullmatch(text):
        return _BETWEEN.split(text)
    return [part.replace(".", "_").replace(decimal, ".") for part in _BETWEEN_COMMAS.split(text)]
