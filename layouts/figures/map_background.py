"""What lies behind a map of two gains: a figure of merit as colour, and the part that a limit forbids."""

from __future__ import annotations

from math import log10
from typing import Any

import numpy as np

from layouts.shown import Shown
from layouts.state import Limits
from layouts.theme import tokens
from tracker_core.responses import lag_coefficient, noise_gain, step_figures
from tracker_core.types import GAIN_NAMES, FloatArray

GRID = 120
"""Points along each axis."""

NOTHING: dict[str, Any] = {"x0": 0.0, "dx": 1.0, "y0": 0.0, "dy": 1.0, "z": [[None]]}

BACKGROUND_TICKS = {
    "noise": ("variance of the smoothed position / σ²", (0.01, 0.03, 0.1, 0.3, 1, 3, 10)),
    "lag": ("lag / ({manoeuvre} · T{power})", (0.01, 0.1, 1, 10, 100, 1_000, 10_000)),
}
"""Of each background what its colours mean, and the values that are marked."""

MANOEUVRES = {2: ("acceleration", "²"), 3: ("jerk", "³"), 4: ("snap", "⁴")}
"""By order, what the filter lags behind, and the power of the interval that goes with it."""


def background(shown: Shown, ranges: list[list[float]]) -> dict[str, Any]:
    """Noise gain or lag over the plane as colour; while a slider moves it stays as it was."""
    kind = shown.view.background
    if kind == "none":
        return {"type": "heatmap", "visible": False, **NOTHING}
    title, ticks = BACKGROUND_TICKS[kind]
    manoeuvre, power = MANOEUVRES[shown.result.gains.order]
    title = title.format(manoeuvre=manoeuvre, power=power)
    t = tokens(shown.theme)
    part = NOTHING
    if not shown.live:
        vectors, cells = _grid(shown, ranges)
        stable = np.isfinite(noise := noise_gain(vectors))
        values = noise if kind == "noise" else np.where(stable, np.abs(lag_coefficient(vectors)), np.nan)
        # At alpha = 1 nothing lags; that has no logarithm, and is drawn as the least there is.
        values = np.log10(np.maximum(values, ticks[0] / 10))
        part = {**cells, "z": _rows(values)}
    return {
        "type": "contour", **part, "autocontour": False, "showlegend": False,
        "contours": {
            "start": log10(ticks[0]), "end": log10(ticks[-1]), "size": 0.125 if kind == "noise" else 0.5,
            "coloring": "heatmap", "showlines": True,
        },
        "line": {"width": 0.6, "color": t["line"]},
        "zmin": log10(ticks[0]), "zmax": log10(ticks[-1]),
        "colorscale": [[0, t["scale-low"]], [0.5, t["scale-middle"]], [1, t["scale-high"]]],
        "colorbar": {
            "title": {"text": title, "side": "right", "font": {"size": 11}}, "thickness": 10, "outlinewidth": 0,
            "tickvals": [log10(tick) for tick in ticks], "ticktext": [f"{tick:g}" for tick in ticks],
            "tickfont": {"size": 10},
        },
        "hoverinfo": "skip",
    }  # fmt: skip


def forbidden(shown: Shown, ranges: list[list[float]]) -> dict[str, Any]:
    """The part of the plane that a limit forbids, shaded."""
    limits, t = shown.settings.limits, tokens(shown.theme)
    part = NOTHING
    if limits.given() and not shown.live:
        vectors, cells = _grid(shown, ranges)
        bad = exceeded(vectors, limits, shown.settings.experiment.interval)
        part = {**cells, "z": [[1 if value else None for value in row] for row in bad.tolist()]}
    # A contour as well, so that it lies over the background.
    return {
        "type": "contour", **part, "contours": {"coloring": "heatmap", "showlines": False}, "zmin": 0, "zmax": 1,
        "autocontour": False, "ncontours": 1, "showscale": False, "hoverinfo": "skip", "showlegend": False,
        "colorscale": [[0, t["forbidden"]], [1, t["forbidden"]]], "name": "Beyond your limits",
    }  # fmt: skip


def exceeded(vectors: FloatArray, limits: Limits, interval: float) -> np.ndarray:
    """Which stable gain vectors exceed a limit, shape (...).

    Args:
        vectors: normalised gains, shape (..., order).
        limits: what must not be exceeded.
        interval: T, s.
    """
    noise = noise_gain(vectors)
    stable = np.isfinite(noise)
    bad = np.zeros(stable.shape, dtype=bool)
    if not stable.any():
        return bad
    if limits.limit_noise is not None:
        bad[stable] |= noise[stable] > limits.limit_noise
    if limits.limit_lag is not None:
        lag = np.abs(lag_coefficient(vectors[stable])) * interval ** vectors.shape[-1]
        bad[stable] |= lag > limits.limit_lag
    if limits.limit_overshoot is not None or limits.limit_settling is not None:
        overshoot, settling = step_figures(vectors[stable])
        if limits.limit_overshoot is not None:
            # Where it is not known, nobody can say that it is small.
            bad[stable] |= ~(100 * overshoot <= limits.limit_overshoot)
        if limits.limit_settling is not None:
            bad[stable] |= settling * interval > limits.limit_settling
    return bad


def _grid(shown: Shown, ranges: list[list[float]]) -> tuple[FloatArray, dict[str, float]]:
    """Gain vectors over the plane, shape (GRID, GRID, order), rows along the second gain; and where the cells lie."""
    gains, plane = shown.result.gains, shown.view.plane
    axes = [np.linspace(low, high, GRID) for low, high in ranges]
    vectors = np.broadcast_to(gains.vector, (GRID, GRID, gains.order)).copy()
    vectors[..., GAIN_NAMES.index(plane[0])] = axes[0]
    vectors[..., GAIN_NAMES.index(plane[1])] = axes[1][:, None]
    (x, y) = axes
    return vectors, {
        "x0": float(x[0]), "dx": float(x[1] - x[0]), "y0": float(y[0]), "dy": float(y[1] - y[0])
    }  # fmt: skip


def _rows(values: FloatArray) -> list[list[float | None]]:
    return [[None if value != value else round(value, 4) for value in row] for row in values.tolist()]
