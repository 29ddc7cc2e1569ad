"""Searches: an error over one number of the filter, over many runs, with the least and the printed value marked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import log10
from typing import Any

import numpy as np

from layouts.figures.common import Figure, packed, round_up
from layouts.figures.papers.look import filter_line, frame, log_axis, marks, path, titled, upright
from layouts.text import significant
from layouts.theme import SCORES, tokens
from tracker_core.experiment import Experiment
from tracker_core.metrics import METRICS
from tracker_core.papers import Paper
from tracker_core.papers.sweeps import sweep
from tracker_core.stability import is_stable
from tracker_core.types import FloatArray

SYMBOLS = {
    "alpha": ("α", ""), "gamma": ("γ", ""), "xi": ("ξ", ""),
    "process_variance": ("σ<sub>w</sub>²", "m²/s⁴"), "sensor_variance": ("σ<sub>v</sub>²", "m²"),
}  # fmt: skip
PLACES = ("diamond", "square")
"""What marks the least of the first and of the second objective."""

TOP = 3.5
"""A linear axis ends at so many times the least error: where the filter diverges there is no end to it."""


def search(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """One or two objectives over a parameter: median of the runs and the band of all of them."""
    experiment, parameter = paper.run(options["runs"][0]).experiment, options["parameter"]
    values, seeds = spread(options), range(1, options["seeds"] + 1)
    symbol, unit = SYMBOLS[parameter]
    titles = (f"{symbol} ({unit})" if unit else symbol, "total error (m)")
    if options["objectives"] == ["innovation_total"]:
        titles = (titles[0], "total innovation (m)")
    data: list[dict[str, Any]] = []
    leasts, greatest = [], 0.0
    for objective, place in zip(options["objectives"], PLACES, strict=False):
        name, look = METRICS[objective].title.split(",")[0], SCORES[objective.split("_")[0]]
        found = sweep(experiment, parameter, values.tolist(), objective, seeds)
        middle = np.median(found, axis=0)
        known = np.isfinite(middle)
        best = int(np.nanargmin(middle))
        where, least = float(values[best]), float(middle[best])
        leasts.append(least)
        greatest = max(greatest, float(found[:, known].max()))
        solid = {"width": 2, "color": tokens(theme)[look]}
        mark = marks(f"Least at {symbol} = {significant(where, 3)}", [where], [least], titles, theme)
        data += [
            _band(values[known], found[:, known], f"{name}, all runs", look, theme),
            path(f"{name}, median and band", values, middle, titles, solid),
            mark | {"marker": mark["marker"] | {"symbol": place}},
        ]
    ends = float(values[0]), float(values[-1])
    if options["logarithmic"]:
        low, high = 0.8 * min(leasts), 1.25 * greatest
        x_axis, y_axis = log_axis(titles[0], *ends), log_axis(titles[1], low, high)
    else:
        low, high = 0.0, round_up(TOP * max(leasts))
        x_axis, y_axis = titled(titles[0], range=list(ends)), titled(titles[1], range=[low, high])
    if options.get("unstable"):
        data.append(_unstable(experiment, parameter, ends[1], high, theme))
    data.append(upright(f"Printed: {options['printed']:g}", options["printed"], low, high, theme))
    return {"data": data, "layout": frame(theme, xaxis=x_axis, yaxis=y_axis)}


def spread(options: Mapping[str, Any]) -> FloatArray:
    """The values that are tried: `count` from `low` to `high`, evenly, or evenly in the logarithm."""
    if options.get("logarithmic"):
        return np.logspace(log10(options["low"]), log10(options["high"]), options["count"])
    return np.linspace(options["low"], options["high"], options["count"])


def _band(values: FloatArray, found: FloatArray, name: str, role: str, theme: str) -> dict[str, Any]:
    """Between the least and the greatest of all runs."""
    return {
        "type": "scatter", "mode": "lines", "name": name, "fill": "toself", "hoverinfo": "skip", "opacity": 0.3,
        "showlegend": False,
        "x": packed(np.concatenate((values, values[::-1]))),
        "y": packed(np.concatenate((found.max(axis=0), found.min(axis=0)[::-1]))),
        "fillcolor": tokens(theme)[role], "line": {"width": 0, "color": tokens(theme)[role]},
    }  # fmt: skip


def _unstable(experiment: Experiment, parameter: str, end: float, top: float, theme: str) -> dict[str, Any]:
    """The values of a gain from which on the filter is unstable, up to `end`."""
    low, high = float(getattr(experiment, parameter)), end
    for _ in range(40):
        middle = (low + high) / 2
        changes: dict[str, Any] = {parameter: middle}
        low, high = (middle, high) if is_stable(replace(experiment, **changes).gains()) else (low, middle)
    return {
        "type": "scatter", "mode": "lines", "name": f"Unstable from {significant(high, 4)}", "fill": "toself",
        "x": [high, end, end, high], "y": [0, 0, top, top], "fillcolor": tokens(theme)["bad-soft"],
        "line": {"width": 0, "color": tokens(theme)["bad"]}, "hoverinfo": "skip",
    }  # fmt: skip


def precision(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """The error in units of the sensor's over alpha, for sensors of several precisions."""
    base = paper.run(options["runs"][0]).experiment
    alphas, seeds = spread(options), range(1, options["seeds"] + 1)
    titles = ("α", "estimation RMSE / σ")
    data: list[dict[str, Any]] = []
    bests: list[tuple[float, float]] = []
    low = high = 1.0
    for index, std in enumerate(options["stds"]):
        sensed = replace(
            base, noise="white", noise_std=(float(std),), samples=options["samples"], order=2,
            design="benedict-bordner", alpha=0.5, beta=None, gamma=None,
        )  # fmt: skip
        error = np.median(sweep(sensed, "alpha", alphas.tolist(), "estimation_rmse", seeds), axis=0) / std
        best = int(np.argmin(error))
        low, high = min(low, float(error.min())), max(high, float(error.max()))
        bests.append((float(alphas[best]), float(error[best])))
        name = f"σ = {std} m, least at α = {bests[-1][0]:.2f}"
        data.append(path(name, alphas, error, titles, filter_line(index, theme)))
    data.append(marks("Least", [x for x, _ in bests], [y for _, y in bests], titles, theme) | {"showlegend": False})
    ends = np.array([float(alphas[0]), float(alphas[-1])])
    raw = {"color": tokens(theme)["observed"], "width": 1.5, "dash": "2px 2px"}
    data.append(path(METRICS["observation_rmse"].title, ends, np.ones(2), titles, raw))
    return {
        "data": data,
        "layout": frame(
            theme,
            xaxis=titled(titles[0], range=[0, 1.02 * float(ends[1])]),
            yaxis=log_axis(titles[1], 0.8 * low, 1.25 * high),
        ),
    }
