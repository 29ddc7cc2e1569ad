"""The score over one parameter: mean, interval, single runs, the best value and the present one."""

from __future__ import annotations

from itertools import pairwise
from math import isfinite, log10
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layouts.figures.common import Figure, packed, padded_range
from layouts.figures.papers.charts import typeset
from layouts.figures.papers.look import LEGEND, log_axis, titled
from layouts.figures.tuning.look import hover, kind_of, name_of, upright
from layouts.theme import layout, tokens
from tracker_core.tuning import PARAMETERS, Optimum, SweepOutcome
from tracker_core.types import FloatArray

FEW_RUNS = 30
"""Of so many runs every one is drawn."""

DECADES = 1
"""A score that spans more is drawn by its logarithm: its least value would hide in a flat line."""

REACH = 20
"""It is then shown up to so many times the best one: farther away nobody looks for it."""


def sweep_figure(outcome: SweepOutcome, best: Optimum, theme: str, present: float | None) -> Figure:
    """The study as it stands.

    Args:
        outcome: what it has come to so far.
        best: its optimum.
        theme: "light" or "dark".
        present: the value of the present filter; None where it is not made from this parameter. The line at it is the
            shape whose number stands in `meta.present`; the page moves it.
    """
    sweep, values = outcome.sweep, np.array(outcome.sweep.values)
    parameter = PARAMETERS[sweep.parameter]
    unit = parameter.unit_at(sweep.experiment.order)
    data = [trace for row in reversed(range(len(sweep.objectives))) for trace in _curves(outcome, values, row, theme)]
    if isfinite(best.value):
        data.append(_best(best, hover("Best", parameter.symbol, unit), theme))
    shapes = _unstable(values, outcome.stable, theme, logarithmic=parameter.logarithmic)
    shapes += [*_best_place(best, theme), upright(present, "present", tokens(theme)["good"], theme, "middle")]
    title = f"{parameter.title}, {parameter.symbol}" + (f" ({unit})" if unit else "")
    span = (float(values[0]), float(values[-1]))
    x_axis = log_axis(title, *span) if parameter.logarithmic else titled(title, range=padded_range(values, 0.0))
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=f"{sweep.parameter}|{span}|{sweep.objectives}",
            meta={
                "study": "sweep", "theme": theme, "runs": outcome.runs, "parameter": sweep.parameter,
                "present": len(shapes) - 1,
            },
            shapes=shapes,
            showlegend=True,
            legend=LEGEND,
            margin={"l": 64, "r": 16, "t": 34, "b": 48},
            xaxis=x_axis | {"title": {"text": typeset(title), "standoff": 8}},
            yaxis=_score_axis(outcome),
        ),
    }  # fmt: skip


def _best(best: Optimum, label: str, theme: str) -> dict[str, Any]:
    t = tokens(theme)
    edge = {"width": 1.5, "color": t["surface"]}
    return {
        "type": "scatter", "mode": "markers", "name": "Best", "x": [best.value], "y": [best.score.mean],
        "marker": {"symbol": "diamond", "size": 11, "color": t["marker"], "line": edge}, "showlegend": False,
        "hovertemplate": label,
    }  # fmt: skip


def _best_place(best: Optimum, theme: str) -> list[dict[str, Any]]:
    """Where the best value lies, and within which interval."""
    t, shapes = tokens(theme), []
    if isfinite(best.low):
        shapes.append(
            {
                "type": "rect", "x0": best.low, "x1": best.high, "y0": 0, "y1": 1, "yref": "paper", "layer": "below",
                "fillcolor": t["marker"], "opacity": 0.22, "line": {"width": 0},
            }
        )  # fmt: skip
    if isfinite(best.value):
        shapes.append(upright(best.value, "best", t["marker"], theme, "end"))
    return shapes


def _curves(outcome: SweepOutcome, values: FloatArray, row: int, theme: str) -> list[dict[str, Any]]:
    """Single runs, interval and mean of one objective, only where the filter is stable."""
    t, name = tokens(theme), outcome.sweep.objectives[row]
    kind, title = kind_of(name), name_of(name)
    colour, faint = t[kind], t[f"{kind}-faint"]
    parameter = PARAMETERS[outcome.sweep.parameter]
    label = hover(title, parameter.symbol, parameter.unit_at(outcome.sweep.experiment.order))
    scores = np.where(outcome.stable, outcome.scores[row], np.nan)
    mean, width = _mean(outcome, row)
    if row:
        # What is known beside it, to be compared with.
        look = {"color": colour, "width": 1.5, "dash": "4px 3px"}
        return [_line(title, values, mean, look, label)]
    traces = []
    if 1 < len(scores) <= FEW_RUNS:
        # One line with gaps instead of many.
        gaps = np.full((len(scores), 1), np.nan)
        x = np.concatenate((np.tile(values, (len(scores), 1)), gaps), axis=1).ravel()
        y = np.concatenate((scores, gaps), axis=1).ravel()
        traces.append(_line("Single runs", x, y, {"color": faint, "width": 1}, None) | {"opacity": 0.55})
    band = _band(values, mean - width, mean + width)
    traces.append(
        _line("95 % of the mean", *band, {"width": 0, "color": colour}, None) | {"fill": "toself", "fillcolor": faint}
    )
    traces.append(_line(title, values, mean, {"color": colour, "width": 2.5}, label))
    return traces


def _line(name: str, x: FloatArray, y: FloatArray, look: dict[str, Any], hovertemplate: str | None) -> dict[str, Any]:
    said = {"hoverinfo": "skip"} if hovertemplate is None else {"hovertemplate": hovertemplate}
    return {
        "type": "scatter", "mode": "lines", "name": name, "x": packed(x, "f8"), "y": packed(y, "f8"), "line": look,
        **said,
    }  # fmt: skip


def _mean(outcome: SweepOutcome, row: int) -> tuple[FloatArray, FloatArray]:
    mean, width = outcome.mean(row)
    known = outcome.stable & np.isfinite(mean)
    return np.where(known, mean, np.nan), np.where(known, width, np.nan)


def _band(x: FloatArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Outline of what lies between two curves, a polygon for every stretch without gaps, NaN between them."""
    known = np.isfinite(low) & np.isfinite(high)
    parts_x: list[FloatArray] = []
    parts_y: list[FloatArray] = []
    for first, last in stretches(known):
        piece = slice(first, last)
        parts_x += [x[piece], x[piece][::-1], np.array([np.nan])]
        parts_y += [low[piece], high[piece][::-1], np.array([np.nan])]
    if not parts_x:
        return np.empty(0), np.empty(0)
    return np.concatenate(parts_x), np.concatenate(parts_y)


def stretches(marked: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and one past the last index of every stretch of marked places."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], marked, [False])).astype(int)))
    return [(int(first), int(last)) for first, last in edges.reshape(-1, 2)]


def _unstable(values: FloatArray, stable: NDArray[np.bool_], theme: str, *, logarithmic: bool) -> list[dict[str, Any]]:
    """Where the filter would be unstable: up to half way to the next stable value."""
    along = np.log(values) if logarithmic else values
    half = [float((low + high) / 2) for low, high in pairwise(along)]
    borders = np.array([along[0], *half, along[-1]])
    borders = np.exp(borders) if logarithmic else borders
    t = tokens(theme)
    return [
        {
            "type": "rect", "x0": float(borders[first]), "x1": float(borders[last]), "y0": 0, "y1": 1, "yref": "paper",
            "layer": "below", "fillcolor": t["bad-soft"], "line": {"width": 0},
            "label": {"text": "unstable", "font": {"size": 11, "color": t["bad"]}, "textposition": "top center"},
        }
        for first, last in stretches(~stable)
    ]  # fmt: skip


def _score_axis(outcome: SweepOutcome) -> dict[str, Any]:
    """Everything that is known with its interval; by the logarithm where it spans decades."""
    names = outcome.sweep.objectives
    title = f"{name_of(names[0])} (m)" if len(names) == 1 else "RMSE (m)"
    ends = []
    for row in range(len(names)):
        mean, width = _mean(outcome, row)
        ends += [mean - np.nan_to_num(width), mean + np.nan_to_num(width)]
    seen = np.concatenate(ends)
    seen = seen[np.isfinite(seen)]
    if not seen.size:
        return titled(title, range=[0, 1])
    positive = seen[seen > 0]
    if positive.size and log10(positive.max() / positive.min()) > DECADES:
        low = float(positive.min())
        return log_axis(title, 0.85 * low, min(1.2 * float(positive.max()), REACH * low))
    return titled(title, range=padded_range(seen, 0.06))
