"""Long columns of numbers as text, every digit of them: as many as tell a number from its neighbours, no more."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from tracker_core.types import FloatArray, IntArray

PIECE = 5_000
"""Rows of a long table that stand in memory as text at a time."""

PLAIN = (1e-4, 1e16)
"""Magnitudes, with zero, that everybody writes without an exponent, and so in the same way."""


def cells(column: FloatArray | IntArray, said: Callable[[float], str]) -> list[str]:
    """The numbers of a column as Python's `repr` writes them.

    Where orjson is there, as it is with the pages, it writes them, many times faster. Both write the shortest digits
    that give the same number back (Steele & White 1990); only small and large ones look different.

    Args:
        column: shape (n,), n > 0.
        said: how one number is written that is NaN or infinite; any other as `repr` does.
    """
    if not np.issubdtype(column.dtype, np.floating):
        return list(map(repr, column.tolist()))
    values = np.ascontiguousarray(column, dtype=np.float64)
    if (orjson := _orjson()) is None:
        texts, others = list(map(repr, values.tolist())), ~np.isfinite(values)
    else:
        written: bytes = orjson.dumps(values, option=orjson.OPT_SERIALIZE_NUMPY)
        texts = written[1:-1].decode("ascii").split(",")
        size = np.abs(values)
        others = ~((size >= PLAIN[0]) & (size < PLAIN[1]) | (size == 0))
    for place in np.flatnonzero(others).tolist():
        texts[place] = said(float(values[place]))
    return texts


@cache
def _orjson() -> Any:
    """The package; None where it is not installed."""
    try:
        import orjson
    except ImportError:
        return None
    return orjson
