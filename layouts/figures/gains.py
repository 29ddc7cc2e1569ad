"""The gains over the run, where a method chooses them as it goes."""

from __future__ import annotations

import numpy as np

from layouts.figures.common import META, Figure, drawn, packed, padded_range, round_up, xy
from layouts.shown import Shown, seen_key
from layouts.theme import layout, tokens
from tracker_core import CONVENTIONS
from tracker_core.fields import FIELDS
from tracker_core.types import GAIN_NAMES, FloatArray

MOVING = (META, *xy(0, 1, 2, 3, 4), ("layout", "yaxis", "range"))
DASHES = ("solid", "dash", "dot", "dashdot")


def gains_figure(shown: Shown) -> Figure:
    """Every gain of one axis against time, in the convention of the run; nothing where the gains are constant."""
    result, view = shown.result, shown.view
    if result.selection is None:
        return _figure(shown, np.empty(0), np.empty((0, 4)), [0.0, 1.0])
    times, order = result.truth.times, result.gains.order
    rows = drawn(len(times))
    factors = np.array(CONVENTIONS[result.experiment.convention].factors)[:order]
    return _figure(shown, times[rows], result.selection.gains[rows, view.axis] / factors, padded_range(times, 0.02))


def _figure(shown: Shown, times: FloatArray, gains: FloatArray, span: list[float]) -> Figure:
    """From times (points,) and gains (points, order)."""
    theme, t = shown.theme, tokens(shown.theme)
    top = round_up(max(float(np.nanmax(gains, initial=0.0)), 1e-3))
    data = []
    for index, name in enumerate(GAIN_NAMES):
        used = index < gains.shape[1] and len(times) > 0
        data.append(
            {
                "type": "scatter", "mode": "lines", "x": packed(times if used else np.empty(0)),
                "y": packed(gains[:, index] if used else np.empty(0)),
                "line": {"color": t[f"curve-{index + 1}"], "width": 1.5, "dash": DASHES[index]},
                "name": FIELDS[name].symbol, "showlegend": used,
                "hovertemplate": f"{FIELDS[name].symbol} %{{y:.4g}}<extra></extra>",
            }
        )  # fmt: skip
    samples = shown.result.truth.times
    cursor = [float(samples[shown.view.cursor(len(samples))])] * 2 if len(times) else []
    data.append(
        {
            "type": "scatter", "mode": "lines", "x": cursor, "y": [0, top][: len(cursor)],
            "line": {"color": t["marker"], "width": 1.5}, "hoverinfo": "skip", "showlegend": False,
        }
    )  # fmt: skip
    every = drawn(len(samples)).step
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=gains_key(shown),
            meta=shown.meta | {"first": 0, "every": every, "every_marker": every},
            legend={"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
            margin={"l": 56, "r": 12, "t": 34, "b": 40},
            xaxis={"title": {"text": "time (s)"}, "range": span},
            yaxis={
                "title": {"text": f"gains in {shown.result.scenario.axes[shown.view.axis]}" if len(times) else ""},
                "range": [-0.03 * top, top],
            },
        ),
    }


def gains_key(shown: Shown) -> str:
    """What the plot shows beside the gains."""
    experiment = shown.settings.experiment
    if experiment.method is None:
        return ""
    look = f"{shown.view.axis}|{shown.view.at}|{experiment.order}|{experiment.convention}"
    return f"{seen_key(shown)}|{look}"
