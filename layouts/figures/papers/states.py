"""States against time: of several filters with their errors, of one filter with its measurements, and lags."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from layouts.figures.common import Figure
from layouts.figures.error import running_rms, window
from layouts.figures.papers.look import UNITS, filter_line, four, in_row, log_axis, path, rows, titled
from layouts.theme import line
from tracker_core import run_experiment
from tracker_core.metrics import distances
from tracker_core.papers import Paper
from tracker_core.types import STATE_NAMES, FloatArray

TIME = "time (s)"
LEAST_LAG = 3.0
"""A lag below that is not drawn, m."""


def states(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """One state of one axis as several filters see it, each beside the truth of its own run; below, their errors."""
    axis, quantity = options["axis"], options["quantity"]
    results = [run_experiment(paper.run(name).experiment) for name in options["runs"]]
    unit, letter = UNITS[quantity], results[0].scenario.axes[axis]
    title = letter if quantity == 0 else f"{STATE_NAMES[quantity]} in {letter}"
    titles, error_titles = (TIME, f"{title} ({unit})"), (TIME, f"error ({unit})")
    above, below = [], []
    for index, (result, name) in enumerate(zip(results, options["names"], strict=True)):
        times, true = result.truth.times, result.truth.states[:, axis, quantity]
        smoothed = result.track.smoothed[:, axis, quantity]
        own = line("truth", theme) | ({"dash": "2px 2px"} if index else {})
        above += [
            path(f"True, {name}" if len(results) > 1 else "True", times, true, titles, own),
            path(name, times, smoothed, titles, filter_line(index, theme)),
        ]
        below.append(path(name, times, smoothed - true, error_titles, filter_line(index, theme, 1.25)))
    return rows(
        theme,
        in_row(0, above) + in_row(1, below, listed=False),
        titled(TIME),
        [titled(titles[1]), titled(error_titles[1])],
    )


def stages(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """Every state of the only axis over time, row by row: true, observed, predicted, smoothed."""
    result = run_experiment(paper.run(options["run"]).experiment)
    times = result.truth.times
    data, axes = [], []
    for quantity in range(result.experiment.order):
        name = result.scenario.axes[0] if quantity == 0 else STATE_NAMES[quantity]
        titles = (TIME, f"{name} ({UNITS[quantity]})")
        series: dict[str, FloatArray] = {
            "truth": result.truth.states[:, 0, quantity],
            "observed": result.measurements.positions[:, 0],
            "predicted": result.track.predicted[:, 0, quantity],
            "smoothed": result.track.smoothed[:, 0, quantity],
        }
        shown = [kind for kind in series if quantity == 0 or kind != "observed"]
        traces = [four(kind, times, series[kind], titles, theme) for kind in shown]
        data += in_row(quantity, traces, listed=quantity == 0)
        axes.append(titled(titles[1], nticks=5))
    return rows(theme, data, titled(TIME), axes)


def comparison(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """The running RMS of the prediction error, and below that of the estimation error, of several filters."""
    data, tops = [], [0.0, 0.0]
    names = ("tracking error (m)", "estimation error (m)")
    for index, (run, name) in enumerate(zip(options["runs"], options["names"], strict=True)):
        result = run_experiment(paper.run(run).experiment)
        times, true = result.truth.times, result.truth.positions
        for row, track in enumerate((result.track.predicted, result.track.smoothed)):
            errors = running_rms(distances(track[:, :, 0] - true), window(len(times)))
            tops[row] = max(tops[row], float(np.nanmax(errors)))
            drawn = path(name, times, errors, (TIME, names[row]), filter_line(index, theme, 1.75))
            data += in_row(row, [drawn], listed=row == 0)
    return rows(
        theme,
        data,
        titled(TIME),
        [titled(name, range=[0, 1.08 * top]) for name, top in zip(names, tops, strict=True)],
    )


def lags(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """How far Benedict-Bordner filters of several alpha trail the target where nothing is measured wrongly."""
    experiment = paper.run(options["run"]).experiment
    titles = ("smoothed: lag (m)", "predicted: lag (m)")
    data, greatest = [], 0.0
    for index, alpha in enumerate(options["alphas"]):
        tried = replace(
            experiment, noise="none", samples=options["samples"], order=2, design="benedict-bordner", alpha=alpha,
            beta=None, gamma=None,
        )  # fmt: skip
        result = run_experiment(tried)
        true = result.truth.positions[:, 0]
        for row, track in enumerate((result.track.smoothed, result.track.predicted)):
            lag = true - track[:, 0, 0]
            greatest = max(greatest, float(lag.max()))
            # Before the aircraft accelerates nothing lags, which has no logarithm.
            seen = np.where(lag > LEAST_LAG, lag, np.nan)
            drawn = path(f"α = {alpha:g}", result.truth.times, seen, (TIME, titles[row]), filter_line(index, theme))
            data += in_row(row, [drawn], listed=row == 0)
    axes = [log_axis(title, LEAST_LAG, 1.5 * greatest) for title in titles]
    return rows(theme, data, titled(TIME), axes)
