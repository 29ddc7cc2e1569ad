"""The stable region in a plane of two gains: design curves, damping, backgrounds, limits, the operating point."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

import numpy as np

from layouts.figures.common import META, Figure, packed, round_up, shortened, xy
from layouts.figures.map_background import background, forbidden
from layouts.shown import Shown
from layouts.theme import layout, tokens
from tracker_core import DESIGNS, Gains, Result
from tracker_core.design.curves import curve_designs, design_curve
from tracker_core.fields import FIELDS
from tracker_core.region import printed_slice, region_slice
from tracker_core.types import GAIN_NAMES, FloatArray

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


def stability_map(shown: Shown) -> Figure:
    """The map in the plane that the view asks for, through the other gains of the run."""
    plane, gains = shown.view.plane, shown.result.gains
    border = region_slice(gains, plane)
    ranges = [axis_range(gains, name, values) for name, values in zip(plane, border, strict=True)]
    t = tokens(shown.theme)
    behind, beyond = background(shown, ranges), forbidden(shown, ranges)
    data = _base(shown, plane)
    data[BACKGROUND], data[FORBIDDEN] = behind, beyond
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
    damping = underdamped() if plane == ALPHA_BETA and gains.order == 2 else (np.empty(0), np.empty(0))
    border, printed = (
        [shortened(values) for values in curve] for curve in (region_slice(gains, plane), printed_slice(gains, plane))
    )
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
