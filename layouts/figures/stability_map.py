"""The stable region in a plane of two gains: design curves, damping, backgrounds, limits, the operating point."""

from __future__ import annotations

from functools import cache, lru_cache
from math import log10
from typing import Any

import numpy as np

from layouts.figures.common import META, Figure, packed, round_up, xy
from layouts.shown import Shown
from layouts.state import Limits
from layouts.theme import layout, tokens
from tracker_core import DESIGNS, Gains, Result
from tracker_core.design.curves import curve_designs, design_curve
from tracker_core.fields import FIELDS
from tracker_core.region import printed_slice, region_slice
from tracker_core.responses import lag_coefficient, noise_gain, step_figures
from tracker_core.types import GAIN_NAMES, FloatArray

GRID = 120
"""Points along each axis of a background."""

BACKGROUND = 3
FORBIDDEN = 4
TRAIL = 5
POINT = 6
TRAIL_POINTS = 1_500
"""More different gains than this of a run are thinned out in its trail."""

_POINT_MOVING = (*xy(POINT), ("data", POINT, "marker", "color"), ("data", POINT, "marker", "symbol"))
MOVING = (
    META,
    *xy(0, 2, TRAIL),
    *_POINT_MOVING,
    *(("data", index, part) for index in (BACKGROUND, FORBIDDEN) for part in ("x0", "dx", "y0", "dy", "z")),
    ("layout", "xaxis", "range"),
    ("layout", "yaxis", "range"),
    ("layout", "annotations"),
)
SMALL_MOVING = (META, *xy(0, 2, TRAIL), *_POINT_MOVING, ("layout", "annotations"))

ALPHA_BETA = ("alpha", "beta")
RANGES = {"alpha": [-0.1, 2.1], "beta": [-0.2, 4.2]}
CURVE_DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")

BACKGROUND_TICKS = {
    "noise": ("variance of the smoothed position / σ²", (0.01, 0.03, 0.1, 0.3, 1, 3, 10)),
    "lag": ("lag per unit of manoeuvre / T^m", (0.01, 0.1, 1, 10, 100, 1_000, 10_000)),
}


def stability_map(shown: Shown) -> Figure:
    """The map in the plane that the view asks for, through the other gains of the run."""
    plane, gains = shown.view.plane, shown.result.gains
    border = region_slice(gains, plane)
    ranges = [axis_range(gains, name, values) for name, values in zip(plane, border, strict=True)]
    t = tokens(shown.theme)
    background, forbidden = _background(shown, ranges), _forbidden(shown, ranges)
    data = _base(shown, plane)
    data[BACKGROUND], data[FORBIDDEN] = background, forbidden
    if shown.view.background != "none":
        # The colours of the background are read from a scale: nothing may tint them.
        data[0]["fillcolor"] = data[1]["fillcolor"] = "rgba(0,0,0,0)"
    for index, (name, curve) in enumerate(design_curves(gains.order, plane)):
        data.append(
            {
                "type": "scatter", "mode": "lines", "x": packed(curve[:, 0]), "y": packed(curve[:, 1]),
                "line": {
                    "width": 1.75,
                    "color": t[f"curve-{index % 4 + 1}"],
                    "dash": CURVE_DASHES[index % len(CURVE_DASHES)],
                },
                "name": name, "hoverinfo": "name",
            }
        )  # fmt: skip
    figure = _figure(shown, plane, data, ranges)
    figure["layout"] |= {
        "uirevision": f"{gains.order}|{plane}",
        "showlegend": True,
        "legend": {
            "orientation": "h",
            "x": 0,
            "y": 0,
            "yref": "container",
            "yanchor": "bottom",
            "font": {"size": 11},
        },
        "margin": {"l": 48, "r": 12, "t": 8, "b": 100},
    }
    return figure


def map_key(shown: Shown) -> str:
    """What the map shows beside the present gains."""
    chosen = shown.result.selection is not None
    return f"{shown.result.gains.order}|{shown.view.plane}|{shown.view.background}|{chosen}"


def small_map(shown: Shown) -> Figure:
    """The same in the (alpha, beta) plane, without curves and backgrounds."""
    return _figure(shown, ALPHA_BETA, _base(shown, ALPHA_BETA), [RANGES[name] for name in ALPHA_BETA])


def small_key(shown: Shown) -> str:
    """What the small map shows beside the present gains."""
    return f"{shown.result.gains.order}|{shown.result.selection is not None}"


def _base(shown: Shown, plane: tuple[str, str]) -> list[dict[str, Any]]:
    """Region, damping, printed bounds, places of the two backgrounds, operating point."""
    t, gains, stable = tokens(shown.theme), shown.result.gains, shown.result.verdict.stable
    border, printed = region_slice(gains, plane), printed_slice(gains, plane)
    damping = underdamped() if plane == ALPHA_BETA and gains.order == 2 else (np.empty(0), np.empty(0))
    x, y = (float(gains.vector[GAIN_NAMES.index(name)]) for name in plane)
    symbols = [FIELDS[name].symbol for name in plane]
    return [
        {
            "type": "scatter", "mode": "lines", "x": packed(border[0]), "y": packed(border[1]), "fill": "toself",
            "fillcolor": t["region"], "line": {"color": t["region-line"], "width": 1.5}, "hoverinfo": "skip",
            "name": "Stable region", "showlegend": False,
        },
        {
            "type": "scatter", "mode": "lines", "x": packed(damping[0]), "y": packed(damping[1]), "fill": "toself",
            "fillcolor": t["region"], "line": {"color": t["ink-soft"], "width": 1, "dash": "dot"},
            "hoverinfo": "skip", "name": "Critically damped", "showlegend": False,
        },
        {
            "type": "scatter", "mode": "lines", "x": packed(printed[0]), "y": packed(printed[1]), "hoverinfo": "name",
            "line": {"color": t["bad"], "width": 1.25, "dash": "dash"}, "name": "Bounds as Yu & Wu print them",
            "showlegend": bool(gains.order > 2 and plane == ALPHA_BETA),
        },
        {"type": "heatmap", "visible": False},
        {"type": "heatmap", "visible": False},
        _trail(shown, plane),
        {
            "type": "scatter", "mode": "markers", "x": [x], "y": [y],
            "marker": {
                "size": 13, "color": t["good"] if stable else t["bad"], "symbol": "circle" if stable else "x",
                "line": {"width": 2, "color": t["surface"]},
            },
            "name": "Present gains", "showlegend": False,
            "hovertemplate": f"{symbols[0]} %{{x:.4g}}<br>{symbols[1]} %{{y:.4g}}<extra></extra>",
        },
    ]  # fmt: skip


def _trail(shown: Shown, plane: tuple[str, str]) -> dict[str, Any]:
    """The way of the gains over the run, where a method has chosen them."""
    t, (x, y) = tokens(shown.theme), trail(shown.result, shown.view.axis, plane)
    return {
        "type": "scatter", "mode": "lines+markers", "x": packed(x), "y": packed(y), "hoverinfo": "skip",
        "line": {"color": t["trail"], "width": 1}, "marker": {"color": t["trail"], "size": 4},
        "name": "Gains over the run", "showlegend": shown.result.selection is not None,
    }  # fmt: skip


def trail(result: Result, axis: int, plane: tuple[str, str]) -> tuple[FloatArray, FloatArray]:
    """The gains of an axis over the run in a plane, each of shape (points,): where they stay they are one point."""
    if result.selection is None:
        return np.empty(0), np.empty(0)
    used = result.selection.gains[:, axis][:, [GAIN_NAMES.index(name) for name in plane]]
    used = used[~np.isnan(used).any(axis=1)]
    moved = np.concatenate(([True], (np.diff(used, axis=0) != 0).any(axis=1)))[: len(used)]
    points = used[moved]
    points = points[:: max(1, -(-len(points) // TRAIL_POINTS))]
    return points[:, 0], points[:, 1]


def _figure(shown: Shown, plane: tuple[str, str], data: list[dict[str, Any]], ranges: list[list[float]]) -> Figure:
    return {
        "data": data,
        "layout": layout(
            shown.theme,
            uirevision="small",
            meta=shown.meta,
            showlegend=False,
            annotations=_notes(shown, plane, ranges, empty=not _has_points(data[0])),
            xaxis={"title": {"text": FIELDS[plane[0]].symbol}, "range": ranges[0]},
            yaxis={"title": {"text": FIELDS[plane[1]].symbol}, "range": ranges[1]},
        ),
    }


def _has_points(trace: dict[str, Any]) -> bool:
    return bool(trace["x"]["bdata"])


def _notes(shown: Shown, plane: tuple[str, str], ranges: list[list[float]], *, empty: bool) -> list[dict[str, Any]]:
    t = tokens(shown.theme)
    if empty:
        fixed = ", ".join(FIELDS[name].symbol for name in GAIN_NAMES[: shown.result.gains.order] if name not in plane)
        text = f"no {FIELDS[plane[0]].symbol}, {FIELDS[plane[1]].symbol} is stable with this {fixed}"
        return [_note(0.97, 0.97, text, t["bad"], t["surface"])]
    if plane != ALPHA_BETA or shown.result.gains.order != 2:
        return []
    places = ((0.42, 1.45, "underdamped"), (0.86, 0.14, "overdamped"), (1.42, 0.5, "alternating"))
    (left, right), (low, high) = ranges
    return [
        _note((x - left) / (right - left), (y - low) / (high - low), text, t["ink"], t["surface"], "center")
        for x, y, text in places
    ]


def _note(x: float, y: float, text: str, colour: str, ground: str, anchor: str = "right") -> dict[str, Any]:
    """A text that is read on a ground of its own, whatever it lies over."""
    return {
        "x": x, "y": y, "xref": "paper", "yref": "paper", "xanchor": anchor, "yanchor": "middle", "text": text,
        "showarrow": False, "font": {"color": colour, "size": 11}, "bgcolor": ground, "borderpad": 2,
    }  # fmt: skip


@cache
def underdamped() -> tuple[FloatArray, FloatArray]:
    """Border of the part of the triangle with complex poles: beta = 2 - alpha +- 2 sqrt(1 - alpha)."""
    # Closer samples where the border turns back, at alpha = 1.
    alpha = 1 - np.linspace(1, 0, 60) ** 2
    root = 2 * np.sqrt(1 - alpha)
    return np.concatenate((alpha, alpha[::-1])), np.concatenate((2 - alpha - root, (2 - alpha + root)[::-1]))


def axis_range(gains: Gains, name: str, border: FloatArray) -> list[float]:
    """What an axis spans: alpha and beta everything, a small gain its part of the region, in round steps.

    Args:
        gains: the operating point, which must be seen.
        name: of the gain along the axis.
        border: its values along the border of the slice.
    """
    whole = float(border.max(initial=0.0))
    if name in RANGES:
        # With a great eta, beta may be greater than 4.
        low, high = RANGES[name]
        return [low, max(high, 1.05 * whole)]
    value = abs(float(gains.vector[GAIN_NAMES.index(name)]))
    # Where the region reaches far beyond the point, its near part is shown.
    high = round_up(max(min(whole, 25 * value) if value else whole, 1.5 * value, 1e-6))
    return [-0.05 * high, 1.05 * high]


@lru_cache(maxsize=32)
def design_curves(order: int, plane: tuple[str, str]) -> tuple[tuple[str, FloatArray], ...]:
    """The design curves seen in a plane, shape (points, 2); designs that draw the same curve share it."""
    columns = [GAIN_NAMES.index(name) for name in plane]
    curves: list[tuple[str, FloatArray]] = []
    for name in curve_designs(order):
        curve = design_curve(name, order)[:, columns]
        same = next((i for i, (_, other) in enumerate(curves) if _coincide(curve, other)), None)
        if same is None:
            curves.append((DESIGNS[name].title, curve))
        else:
            curves[same] = (f"{curves[same][0]} = {DESIGNS[name].title}", curves[same][1])
    return tuple(curves)


def _coincide(one: FloatArray, other: FloatArray) -> bool:
    """Whether two curves over an increasing abscissa lie on each other where both are drawn."""
    (one, other) = (curve[np.argsort(curve[:, 0])] for curve in (one, other))
    low, high = max(one[0, 0], other[0, 0]), min(one[-1, 0], other[-1, 0])
    x = np.linspace(low, high, 40)[1:-1]
    first, second = np.interp(x, *one.T), np.interp(x, *other.T)
    return bool(np.abs(first - second).max() < 4e-3 * float(np.abs(second).max()))


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


def _background(shown: Shown, ranges: list[list[float]]) -> dict[str, Any]:
    """Noise gain or lag over the plane as colour; while a slider moves it stays as it was."""
    kind = shown.view.background
    hidden = {"x0": 0.0, "dx": 1.0, "y0": 0.0, "dy": 1.0, "z": [[None]]}
    if kind == "none":
        return {"type": "heatmap", "visible": False, **hidden}
    title, ticks = BACKGROUND_TICKS[kind]
    t = tokens(shown.theme)
    part = hidden
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


def _rows(values: FloatArray) -> list[list[float | None]]:
    return [[None if value != value else round(value, 4) for value in row] for row in values.tolist()]


def _forbidden(shown: Shown, ranges: list[list[float]]) -> dict[str, Any]:
    """The part of the plane that a limit forbids, shaded."""
    limits, t = shown.settings.limits, tokens(shown.theme)
    part: dict[str, Any] = {"x0": 0.0, "dx": 1.0, "y0": 0.0, "dy": 1.0, "z": [[None]]}
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
