"""Methods that choose the gains of the α-β filter: what they choose, what they predict, and how well."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from statistics import fmean, median
from typing import Any

import numpy as np

from layouts.figures.common import Figure, packed
from layouts.figures.error import running_rms
from layouts.figures.papers.look import filter_line, four, frame, hover, in_row, log_axis, path, rows, titled
from layouts.theme import hollow, tokens
from tracker_core import Gains, InputError, Result, run_experiment
from tracker_core.adaptive import Selection
from tracker_core.filters import run_filter
from tracker_core.papers import Paper, Table
from tracker_core.papers.printed import number
from tracker_core.types import FloatArray

TIME = "time (s)"
LEAST_RMSE = 5.0
"""Where the bars begin, m: a logarithm has no zero."""
REACH = 3.5
"""How many standard deviations of the noise are shown of the predictions; slow members are farther off."""

RMS_WINDOW = 5
"""Samples over which an error is averaged, where methods are compared."""


def chosen(paper: Paper, run: str) -> tuple[Result, Selection]:
    """A run and how its method chose the gains.

    Raises:
        InputError: for a run whose gains are constant.
    """
    result = run_experiment(paper.run(run).experiment)
    if result.selection is None:
        raise InputError("run", "must be one of a method that chooses the gains", run)
    return result, result.selection


def window(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """The α that a moving window chooses over time, for every axis, and how far the first window reaches."""
    result, selection = chosen(paper, options["runs"][0])
    times, t = result.truth.times, tokens(theme)
    length = result.experiment.window or 0
    reach = float(times[length])
    titles = (TIME, "α")
    first = {
        "type": "scatter", "mode": "lines", "name": f"First window, {length} samples", "fill": "toself",
        "x": [0, reach, reach, 0], "y": [0, 0, 1.05, 1.05], "fillcolor": t["region"], "hoverinfo": "skip",
        "line": {"width": 0, "color": t["region-line"]},
    }  # fmt: skip
    alphas = [
        path(f"α for {letter}", times, selection.gains[:, axis, 0], titles, filter_line(axis, theme))
        for axis, letter in enumerate(result.scenario.axes)
    ]
    return {
        "data": [first, *alphas],
        "layout": frame(theme, xaxis=titled(TIME), yaxis=titled("α", range=[0, 1.05])),
    }


def bank(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """What every member of a bank predicts over a stretch of the run, which one speaks, and what is then measured."""
    result, selection = chosen(paper, options["runs"][0])
    axis, (first, last) = options["axis"], options["stretch"]
    stretch = slice(first, last + 1)
    members = np.empty((0, 2)) if selection.members is None else selection.members
    true = result.truth.states[stretch, axis, 0]
    each = np.stack([
        run_filter(result.measurements, Gains.normalised(gains), start=result.experiment.start)
        .predicted[stretch, axis, 0] for gains in members
    ])  # fmt: skip
    times, reach = result.truth.times[stretch], REACH * result.noise_std[axis]
    letter = result.scenario.axes[axis]
    titles = (TIME, f"{letter} − true {letter} (m)")
    t = tokens(theme)
    alphas = np.repeat(members[:, 0], len(times))
    everyone = path(f"The {len(members)} predictions", np.tile(times, len(members)), (each - true).ravel(), titles, {})
    everyone |= {
        "mode": "markers", "customdata": packed(alphas),
        "marker": {"symbol": "line-ew", "size": 12, "line": {"width": 1.25, "color": t["curve-2"]}, "opacity": 0.6},
        "hovertemplate": f"α = %{{customdata:.2f}}<br>{hover('', *titles).removeprefix('<br>')}",
    }  # fmt: skip
    speaker = path("The one that speaks", times, result.track.predicted[stretch, axis, 0] - true, titles, {})
    speaker |= {"mode": "markers", "marker": {"symbol": "diamond", "size": 9, "color": t["predicted"]}}
    measured = path("Observed", times, result.measurements.positions[stretch, axis] - true, titles, {})
    measured |= {"mode": "markers", "marker": hollow(theme, 13) | {"line": {"width": 2, "color": t["observed"]}}}
    return {
        "data": [everyone, measured, speaker],
        "layout": frame(theme, xaxis=titled(TIME), yaxis=titled(titles[1], range=[-reach, reach])),
    }


def methods(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """One axis as several methods predict it, beside truth and measurements; below, the size of their errors."""
    axis = options["axis"]
    results = [run_experiment(paper.run(name).experiment) for name in options["runs"]]
    times, true = results[0].truth.times, results[0].truth.states[:, axis, 0]
    letter = results[0].scenario.axes[axis]
    titles, error_titles = (TIME, f"{letter} (m)"), (TIME, f"error of {letter} (m)")
    above = [
        four("truth", times, true, titles, theme),
        four("observed", times, results[0].measurements.positions[:, axis], titles, theme),
    ]
    below: list[dict[str, Any]] = []
    errors: list[FloatArray] = []
    for index, (result, name) in enumerate(zip(results, options["names"], strict=True)):
        predicted, look = result.track.predicted[:, axis, 0], filter_line(index, theme, 1.75)
        above.append(path(name, times, predicted, titles, look))
        errors.append(running_rms(predicted - true, RMS_WINDOW))
        below.append(path(name, times, errors[-1], error_titles, look))
    least, greatest = 0.8 * float(np.nanmin(errors)), 1.25 * float(np.nanmax(errors))
    return rows(
        theme,
        in_row(0, above) + in_row(1, below, listed=False),
        titled(TIME),
        [titled(titles[1]), log_axis(error_titles[1], least, greatest)],
    )


def prediction_rmse(paper: Paper, run: str, seeds: int) -> FloatArray:
    """The RMSE of the prediction per axis, median over the seeds, shape (n_axes,), m."""
    experiment = paper.run(run).experiment
    found = [run_experiment(replace(experiment, seed=seed)).axis_metrics() for seed in range(1, seeds + 1)]
    per_axis = zip(*found, strict=True)
    return np.array([median(metrics.tracking_rmse or np.nan for metrics in axis) for axis in per_axis])


def printed_means(table: Table, axis: int) -> list[float]:
    """The mean of every column over the rows of an axis, as they are printed."""
    rows_of_axis = [row for row in table.rows if row.options["axis"] == axis]
    return [fmean(float(number(row.cells[column])) for row in rows_of_axis) for column in range(len(table.columns))]


def rmse(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """The RMSE of several methods, a row for each axis: as printed beside the median of our runs."""
    t = tokens(theme)
    names = list(options["names"])
    found = np.stack([prediction_rmse(paper, run, options["seeds"]) for run in options["runs"]], axis=1)
    data, axes = [], []
    for row, letter in enumerate(run_experiment(paper.run(options["runs"][0]).experiment).scenario.axes):
        title = f"RMSE of {letter} (m)"
        printed = printed_means(paper.table(options["table"]), row)
        pair = (
            ("Printed, mean of five", names[: len(printed)], printed, t["control"]),
            (f"Here, median of {options['seeds']} runs", names, found[row].tolist(), t["predicted"]),
        )
        bars = [
            {
                "type": "bar", "name": name, "x": x, "y": y, "marker": {"color": colour},
                "hovertemplate": f"{name}<br>%{{x}}<br>RMSE of {letter} %{{y:.4~g}} m<extra></extra>",
            }
            for name, x, y, colour in pair
        ]  # fmt: skip
        data += in_row(row, bars, listed=row == 0)
        axes.append(log_axis(title, LEAST_RMSE, 1.2 * max(*printed, float(found[row].max()))))
    return rows(theme, data, titled("method", type="category"), axes, barmode="group", bargap=0.25)
