"""What the figures share: arrays in plotly's binary form, the four kinds of traces, what moves with a slider."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from math import floor, log10
from typing import Any

import numpy as np

from layouts.theme import hollow, line
from tracker_core.types import FloatArray, IntArray

Figure = dict[str, Any]
Path = tuple[str | int, ...]

DRAWN_SAMPLES = 5_000
"""More samples than this are thinned out for drawing; metrics never are."""

DRAWN_MARKERS = 350
"""Of more measurements than this only every n-th is marked where a whole run is shown; the close-up marks all."""

SERIES = ("truth", "observed", "predicted", "smoothed")
NAMES = {
    "truth": "True", "observed": "Observed", "predicted": "Predicted", "smoothed": "Smoothed", "counterpart": "Causal",
}  # fmt: skip


class Packed(dict[str, str]):
    """An array as plotly's typed array, with the numbers themselves for who does not need them as text."""

    __slots__ = ("numbers",)
    numbers: FloatArray | IntArray


def packed(values: FloatArray | IntArray, dtype: str = "f4") -> Packed:
    """An array as plotly's typed array: 32-bit floats, or 64-bit ones ("f8") where metres count on a long way.

    Numbers of samples are whole ("i4").
    """
    numbers = np.asarray(values, dtype=dtype)
    array = Packed(dtype=dtype, bdata=base64.b64encode(numbers.tobytes()).decode("ascii"))
    array.numbers = numbers
    return array


def every(count: int, most: int) -> slice:
    """All of so many, or every n-th, so that there are at most so many."""
    return slice(None, None, max(1, -(-count // most)))


def drawn(samples: int) -> slice:
    """The samples that are drawn of a run of that length: all, or every n-th."""
    return every(samples, DRAWN_SAMPLES)


def thinned(samples: int) -> slice:
    """The measurements that a whole run shows: all, or every n-th; markers are what makes a plot slow."""
    return every(samples, DRAWN_MARKERS)


def grain(values: FloatArray) -> FloatArray:
    """The step to which values are drawn that span so much: finer than a pixel a hundred times enlarged.

    Args:
        values: shape (n,) or (n, n_axes).

    Returns:
        Between 2^-17 and 2^-16 of their span, shape () or (n_axes,); a power of two, so that what is sent has fewer
        digits. NaN where nothing is spanned.
    """
    known = np.isfinite(values)
    span = np.max(values, axis=0, initial=-np.inf, where=known) - np.min(values, axis=0, initial=np.inf, where=known)
    return np.exp2(np.floor(np.log2(np.where((span > 0) & np.isfinite(span), span, np.nan))) - 16)


def grained(values: FloatArray, step: FloatArray | float) -> FloatArray:
    """Values for drawing, rounded to a step; as they are where there is none."""
    with np.errstate(over="ignore", invalid="ignore"):
        rounded = np.round(values / step) * step
    return np.where(np.isfinite(rounded), rounded, values)


def shortened(values: FloatArray) -> FloatArray:
    """Values for drawing, rounded to 17 binary digits, so that what is sent has fewer; small ones stay exact enough."""
    fractions, powers = np.frexp(values)
    return np.ldexp(np.round(fractions * 2**17) / 2**17, powers)


def trace(kind: str, x: FloatArray, y: FloatArray, theme: str, **more: Any) -> dict[str, Any]:
    """One of the four series: the same colour, line and marker on every plot."""
    base: dict[str, Any] = {"type": "scatter", "name": NAMES[kind], "x": packed(x), "y": packed(y)}
    if kind == "observed":
        base |= {"mode": "markers", "marker": hollow(theme)}
    else:
        base |= {"mode": "lines", "line": line(kind, theme)}
    return base | more


def moving(figure: Figure, paths: Iterable[Path]) -> list[tuple[Path, Any]]:
    """The parts of a figure that change with the gains, each with the path to it."""
    parts = []
    for path in paths:
        value: Any = figure
        for key in path:
            value = value[key]
        parts.append((path, value))
    return parts


def xy(*indices: int) -> tuple[Path, ...]:
    """Paths to the coordinates of some traces."""
    return tuple(("data", index, axis) for index in indices for axis in ("x", "y"))


def chosen(*indices: int) -> tuple[Path, ...]:
    """Paths to the coordinates of some traces that show only some samples, and to which ones these are."""
    return (*xy(*indices), *(("data", index, "customdata") for index in indices))


def moving_traces(paths: Iterable[Path]) -> list[int]:
    """Of the parts that move, the traces whose coordinates do."""
    return [int(path[1]) for path in paths if path[0] == "data" and path[2] == "x"]


def coordinates(values: dict[str, str] | list[float]) -> FloatArray:
    """The coordinates of a trace as 32-bit floats."""
    if isinstance(values, Packed):
        return values.numbers.astype("f4")
    if isinstance(values, dict):
        return np.frombuffer(base64.b64decode(values["bdata"]), dtype=values["dtype"]).astype("f4")
    return np.array(values, dtype="f4")


def padded_range(values: FloatArray, margin: float = 0.05) -> list[float]:
    """An axis range that shows all finite values with a margin."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return [-1.0, 1.0]
    low, high = float(finite.min()), float(finite.max())
    pad = margin * (high - low) or max(abs(high), 1.0) * margin
    return [low - pad, high + pad]


def clipped(values: FloatArray, limit: float) -> FloatArray:
    """Values for drawing: beyond the limit nothing is drawn, so that a diverging run cannot spoil an axis."""
    return np.where(np.abs(values) <= limit, values, np.nan)


def round_up(value: float) -> float:
    """The next of 1, 1.5, 2, 3, 5, 7, 10, 15 ... and their tenths."""
    power = 10.0 ** floor(log10(value))
    return next(step * power for step in (1, 1.5, 2, 3, 5, 7, 10) if step * power >= value * (1 - 1e-9))


META: Path = ("layout", "meta")
