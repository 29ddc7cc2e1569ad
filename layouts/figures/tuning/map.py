"""The score over two gains as colour, with the border of stability, the design curves and the best cell."""

from __future__ import annotations

import base64
from math import log, log10
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layouts.figures.common import Figure, packed
from layouts.figures.stability_map import CURVE_DASHES, design_curves
from layouts.figures.tuning.look import axis_name, name_of, ticks
from layouts.theme import layout, tokens
from tracker_core.region import region_slice
from tracker_core.tuning import Map, MapOutcome
from tracker_core.types import GAIN_NAMES, FloatArray

REACH = 6.0
"""Scores of more than so many times the best one have all the same colour."""

FIRST_LEVEL = 1.05
"""The innermost level line, as a multiple of the best score; the next ones are its square, its fourth power, ..."""

LEVELS = 5

MARGIN = 0.03
"""Around the stable part of the plane, as a part of it."""


def map_figure(study: Map, outcome: MapOutcome, theme: str) -> Figure:
    """The study as it stands.

    Args:
        study: what was asked.
        outcome: what it has come to so far.
        theme: "light" or "dark".
    """
    t = tokens(theme)
    x_name, y_name = (axis_name(gain, study.experiment.convention) for gain in study.plane)
    border = region_slice(study.experiment.gains(), study.plane)
    ranges = [_range(along) for along in border]
    data = [_heat(study, outcome, theme), _levels(outcome, theme)]
    data.append(
        {
            "type": "scatter", "mode": "lines", "x": packed(border[0]), "y": packed(border[1]), "hoverinfo": "skip",
            "line": {"color": t["region-line"], "width": 1.5}, "name": "Edge of stability", "showlegend": False,
        }
    )  # fmt: skip
    data += _curves(study, theme) + _best(study, outcome, theme)
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=f"{study.experiment.order}|{study.plane}|{ranges}",
            meta={"study": "map", "theme": theme, "runs": outcome.runs, "plane": list(study.plane)},
            showlegend=True,
            legend={"orientation": "h", "x": 0, "y": 0, "yref": "container", "yanchor": "bottom", "font": {"size": 11}},
            margin={"l": 56, "r": 12, "t": 12, "b": 104},
            xaxis={"title": {"text": x_name}, "range": ranges[0]},
            yaxis={"title": {"text": y_name}, "range": ranges[1]},
        ),
    }


def _curves(study: Map, theme: str) -> list[dict[str, Any]]:
    """The design curves as on the map of stability; of a slice they miss the gains that it holds."""
    t, seen = tokens(theme), "" if study.experiment.order == len(study.plane) else ", projected"
    return [
        {
            "type": "scatter", "mode": "lines", "x": packed(curve[:, 0]), "y": packed(curve[:, 1]),
            "line": {"width": 1.5, "color": t[f"curve-{index % 4 + 1}"],
                     "dash": CURVE_DASHES[index % len(CURVE_DASHES)]},
            "name": f"{name}{seen}", "hoverinfo": "name", "hoverlabel": {"namelength": -1},
        }
        for index, (name, curve) in enumerate(design_curves(study.experiment.order, study.plane))
    ]  # fmt: skip


def _best(study: Map, outcome: MapOutcome, theme: str) -> list[dict[str, Any]]:
    """The best cell, and an outline of those that are not shown to be worse."""
    t, best = tokens(theme), outcome.best()
    if best is None:
        return []
    near = outcome.spread(np.where(outcome.near_best(), 1.0, 0.0)) == 1
    edges = map(packed, outline(outcome.x, outcome.y, near))
    x, y = (float(outcome.vectors[best][GAIN_NAMES.index(name)]) for name in study.plane)
    return [
        {
            "type": "scatter", "mode": "lines", "hoverinfo": "skip", "line": {"color": t["ink"], "width": 1.75},
            "name": "Not shown to be worse", "showlegend": bool(near.sum() > 1),
            **dict(zip(("x", "y"), edges, strict=True)),
        },
        {
            "type": "scatter", "mode": "markers", "name": "Best cell", "x": [x], "y": [y], "hoverinfo": "skip",
            "marker": {"symbol": "diamond", "size": 11, "color": t["marker"],
                       "line": {"width": 1.5, "color": t["surface"]}},
        },
    ]  # fmt: skip


def _range(along: FloatArray) -> list[float]:
    low, high = float(along.min()), float(along.max())
    return [low - MARGIN * (high - low), high + MARGIN * (high - low)]


def _heat(study: Map, outcome: MapOutcome, theme: str) -> dict[str, Any]:
    """Colours by the logarithm of the mean; the numbers themselves are kept for who points at them."""
    t, mean = tokens(theme), outcome.mean()
    known = mean[np.isfinite(mean) & (mean > 0)]
    low = float(known.min()) if known.size else 1.0
    high = max(min(float(known.max()), REACH * low), 1.05 * low) if known.size else REACH
    with np.errstate(divide="ignore", invalid="ignore"):
        colours = np.log10(np.clip(mean, low, high))
    marks = ticks(low, high)
    x_name, y_name = (axis_name(gain, study.experiment.convention) for gain in study.plane)
    return {
        "type": "heatmap", "x": packed(outcome.x, "f8"), "y": packed(outcome.y, "f8"), "z": _table(colours),
        "customdata": _table(mean), "zmin": log10(low), "zmax": log10(high), "name": name_of(study.objective),
        "colorscale": [[0, t["scale-low"]], [0.5, t["scale-middle"]], [1, t["scale-high"]]], "hoverongaps": False,
        "colorbar": {
            "title": {"text": f"{name_of(study.objective)} (m)", "side": "right", "font": {"size": 11}},
            "thickness": 12, "outlinewidth": 0, "tickvals": [log10(value) for value, _ in marks],
            "ticktext": [text for _, text in marks],
            "tickfont": {"size": 10},
        },
        "hovertemplate": f"%{{customdata:.4~g}} m<br>{x_name} %{{x:.3~g}}, {y_name} %{{y:.3~g}}<extra></extra>",
    }  # fmt: skip


def _levels(outcome: MapOutcome, theme: str) -> dict[str, Any]:
    """Lines of equal score, each twice as far from the best one as the one before, by the logarithm."""
    mean = outcome.mean()
    known = mean[np.isfinite(mean) & (mean > 0)]
    low = float(known.min()) if known.size else 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        doublings = np.log2(np.maximum(np.log(mean / low) / log(FIRST_LEVEL), 2.0**-3))
    said = ", ".join(f"{100 * (FIRST_LEVEL**2**level - 1):.0f}" for level in range(LEVELS))
    return {
        "type": "contour", "x": packed(outcome.x, "f8"), "y": packed(outcome.y, "f8"), "z": _table(doublings),
        "autocontour": False, "contours": {"start": 0, "end": LEVELS - 1, "size": 1, "coloring": "none"},
        "line": {"color": tokens(theme)["trail"], "width": 0.75}, "hoverinfo": "skip", "connectgaps": False,
        "name": f"{said} % above the best", "showlegend": True,
    }  # fmt: skip


def _table(values: FloatArray) -> dict[str, str]:
    """Rows of numbers in plotly's binary form."""
    rows, columns = values.shape
    data = base64.b64encode(np.ascontiguousarray(values, dtype="f4").tobytes()).decode("ascii")
    return {"dtype": "f4", "bdata": data, "shape": f"{rows}, {columns}"}


def outline(x: FloatArray, y: FloatArray, marked: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """The edges between marked cells and others, as a line with gaps.

    Args:
        x, y: middles of the columns and rows, evenly spaced, shapes (columns,) and (rows,).
        marked: shape (rows, columns).
    """
    dx, dy = (x[1] - x[0]) / 2, (y[1] - y[0]) / 2
    framed = np.pad(marked, 1).astype(int)
    # Between the cells of a row the edges stand upright.
    rows, columns = np.nonzero(np.diff(framed, axis=1)[1:-1])
    at = np.append(x - dx, x[-1] + dx)[columns]
    upright = np.stack([at, at, np.full(len(at), np.nan)]), np.stack([y[rows] - dy, y[rows] + dy, at * np.nan])
    rows, columns = np.nonzero(np.diff(framed, axis=0)[:, 1:-1])
    at = np.append(y - dy, y[-1] + dy)[rows]
    level = np.stack([x[columns] - dx, x[columns] + dx, at * np.nan]), np.stack([at, at, at * np.nan])
    return tuple(np.concatenate((one.T.ravel(), other.T.ravel())) for one, other in zip(upright, level, strict=True))  # type: ignore[return-value]
