"""The plot of a study in numbers: rows of the tables under it."""

from __future__ import annotations

from math import isfinite

import numpy as np

from layouts.figures.tuning.look import axis_name
from layouts.numbers import listed
from layouts.pages.tune.words import at_text, number
from layouts.text import significant
from tracker_core.statistics import Interval
from tracker_core.tuning import Map, MapOutcome, Optimum, SearchOutcome, SweepOutcome
from tracker_core.types import GAIN_NAMES

TABLES = {
    "told-values": ("The values tried", ("", "mean (m)", "95 %: from (m)", "to (m)", "Estimation RMSE (m)")),
    "told-cells": ("The best cells", ("", "mean (m)", "95 %: from (m)", "to (m)")),
    "told-generations": ("The search", ("generations", "best found so far (m)")),
}
"""Caption and columns of the table of each kind of study, by its name."""

MOST_CELLS = 20

Rows = list[list[str]]


def value_rows(outcome: SweepOutcome, best: Optimum) -> Rows:
    """Some of the values, the best one among them, with their scores.

    The last column says what the error is where the truth is known; it is empty where the score is one itself.
    """
    sweep, count = outcome.sweep, len(outcome.sweep.values)
    mean, width = outcome.mean()
    beside = [significant(each) for each in outcome.mean(1)[0].tolist()] if len(sweep.objectives) > 1 else [""] * count
    rows = []
    for index in sorted({*range(count)[listed(count)], best.index}):
        name, middle, half = at_text(sweep, significant(sweep.values[index])), float(mean[index]), float(width[index])
        said = ["unstable", "", "", ""]
        if outcome.stable[index]:
            said = [*_score(Interval(middle, middle - half, middle + half)), beside[index]]
        rows.append([name, *said])
    return rows


def _score(score: Interval) -> list[str]:
    """A score, and the ends of its interval if it has one."""
    said = number(score.mean, score.low, score.high)
    return [*said] if isfinite(score.low) else [said[0], "", ""]


def cell_rows(study: Map, outcome: MapOutcome) -> Rows:
    """The cells with the least scores, the best first."""
    means = outcome.scores[0].mean(axis=0)
    known = np.flatnonzero(np.isfinite(means))
    names = [axis_name(gain, study.experiment.convention) for gain in study.plane]
    columns = [GAIN_NAMES.index(gain) for gain in study.plane]
    rows = []
    for cell in known[np.argsort(means[known], kind="stable")][:MOST_CELLS].tolist():
        gains = outcome.vectors[cell][columns].tolist()
        place = ", ".join(f"{name} = {significant(gain, 3)}" for name, gain in zip(names, gains, strict=True))
        rows.append([place, *_score(outcome.score(cell))])
    return rows


def generation_rows(outcome: SearchOutcome) -> Rows:
    """The best score after some of the generations, the last among them."""
    count = len(outcome.history)
    some = {*range(count)[listed(count)], *range(count)[-1:]}
    return [[f"{index + 1:,}", significant(outcome.history[index], 5)] for index in sorted(some)]
