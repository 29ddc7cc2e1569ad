"""Paths in the plane on equal scales, and below them how far the filter is from the truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from layouts.figures.common import NAMES, SERIES, Figure, packed, padded_range, trace
from layouts.figures.error import running_rms, window
from layouts.figures.papers.look import filter_line, four, frame, hover, marks, path, titled
from layouts.theme import line, tokens
from tracker_core import run_experiment
from tracker_core.metrics import METRICS, distances
from tracker_core.papers import Paper
from tracker_core.types import FloatArray

PLANE = ("x (m)", "y (m)")
OVER_TIME = ("time (s)", "error (m)")


def trajectory(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """The true path, with its first and its last position."""
    true = run_experiment(paper.run(options["runs"][0]).experiment).truth.positions
    x, y = true.T
    first, last = true[0].tolist(), true[-1].tolist()
    begin, end = marks("First", [first[0]], [first[1]], PLANE, theme), marks("Last", [last[0]], [last[1]], PLANE, theme)
    end["marker"] = end["marker"] | {"symbol": "square"}
    return {
        "data": [four("truth", x, y, PLANE, theme), begin, end],
        "layout": frame(
            theme,
            xaxis=titled(PLANE[0], range=padded_range(x)),
            yaxis=titled(PLANE[1], range=padded_range(y), scaleanchor="x"),
        ),
    }


def tracks(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """True, observed, predicted and smoothed path of one run, and the distance of the last two from the first."""
    result = run_experiment(paper.run(options["runs"][0]).experiment)
    series = {
        "truth": result.truth.positions, "observed": result.measurements.positions,
        "predicted": result.track.predicted[:, :, 0], "smoothed": result.track.smoothed[:, :, 0],
    }  # fmt: skip
    data = [four(kind, series[kind][:, 0], series[kind][:, 1], PLANE, theme) for kind in SERIES]
    times, width = result.truth.times, window(len(result.truth.times))
    raw = float(np.sqrt(np.mean(distances(series["observed"] - series["truth"]) ** 2)))
    measured = METRICS["observation_rmse"].title
    level = packed(np.array([raw, raw])), packed(times[[0, -1]])
    greatest = 0.0
    for kind in ("predicted", "smoothed"):
        errors = distances(series[kind] - series["truth"])
        greatest = max(greatest, float(np.nanpercentile(errors, 99)))
        faint = {"color": tokens(theme)[f"{kind}-faint"], "width": 1}
        for values, look in ((errors, {"line": faint, "hoverinfo": "skip"}), (running_rms(errors, width), {})):
            said = {} if look else {"hovertemplate": hover(f"{NAMES[kind]}, running RMS", *OVER_TIME)}
            data.append(trace(kind, times, values, theme, **_below, **said, **look))
    data.append(
        {
            "type": "scatter", "mode": "lines", "x": level[1], "y": level[0], "name": measured,
            "line": {"color": tokens(theme)["observed"], "width": 1.5, "dash": "2px 2px"},
            "hovertemplate": hover(measured, *OVER_TIME), **_below,
        }
    )  # fmt: skip
    both = np.concatenate((series["truth"], series["observed"]))
    return _with_errors(theme, data, both, titled(OVER_TIME[1], range=[0, 1.1 * greatest]), 0.42)


def paths(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """The smoothed paths of several runs, each with the truth of its own, and their errors."""
    data: list[dict[str, Any]] = []
    errors = []
    for index, (name, title) in enumerate(zip(options["runs"], options["names"], strict=True)):
        result = run_experiment(paper.run(name).experiment)
        true, smoothed = result.truth.positions, result.track.smoothed[:, :, 0]
        data += [
            path(f"True, {title}", true[:, 0], true[:, 1], PLANE, _own_truth(index, theme)),
            path(title, smoothed[:, 0], smoothed[:, 1], PLANE, filter_line(index, theme)),
        ]
        error = distances(smoothed - true)
        errors.append(path(title, result.truth.times, error, OVER_TIME, filter_line(index, theme, 1.25)) | _below)
    whole = np.concatenate([run_experiment(paper.run(name).experiment).truth.positions for name in options["runs"]])
    return _with_errors(theme, data + errors, whole, titled(OVER_TIME[1], rangemode="tozero"), 0.5)


def _own_truth(index: int, theme: str) -> dict[str, Any]:
    """The line of the truth of the index-th run."""
    return line("truth", theme) | ({"dash": "2px 2px"} if index else {})


_below: dict[str, Any] = {"xaxis": "x2", "yaxis": "y2", "showlegend": False}


def _with_errors(
    theme: str, data: list[dict[str, Any]], plane: FloatArray, error_axis: dict[str, Any], share: float
) -> Figure:
    """The path above, which takes so much of the height, and the errors over time below."""
    x, y = plane.T
    return {
        "data": data,
        "layout": frame(
            theme,
            xaxis=titled(PLANE[0], range=padded_range(x), anchor="y"),
            yaxis=titled(PLANE[1], range=padded_range(y), scaleanchor="x", domain=[1 - share, 1]),
            xaxis2=titled(OVER_TIME[0], anchor="y2"),
            yaxis2={**error_axis, "domain": [0, 1 - share - 0.2], "anchor": "x2"},
        ),
    }
