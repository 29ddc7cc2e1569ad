"""Where the present filter stands in a study."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from layouts.pages.tune.studies import Study
from tracker_core import Experiment
from tracker_core.design.steady_kalman import time_power
from tracker_core.stability import is_stable
from tracker_core.tuning import PARAMETERS
from tracker_core.tuning.base import steps_of
from tracker_core.tuning.evaluate import effective_runs, scored
from tracker_core.types import GAIN_NAMES, FloatArray

MOST_STEPS = 2 * 10**7
"""Filter steps that are taken to see how well the present filter does in the runs of a study: a tenth of a second."""


def present_value(experiment: Experiment, parameter: str) -> float | None:
    """The value of a parameter that the filter has now, gains in its convention.

    None where the filter is made from something else: it does not lie on the curve then.
    """
    field = PARAMETERS[parameter].sets
    if field in GAIN_NAMES:
        # Another value, the other gains held, is a filter by hand; the present one is among them.
        return None if experiment.method is not None else experiment.gains().values[GAIN_NAMES.index(field)]
    value: float | None = getattr(experiment, field)
    if value is not None and parameter == "process_variance":
        return (value / experiment.interval ** time_power(experiment.order)) ** 2
    return 1.0 if value is not None and parameter == "sensor_variance" else value


def present_scores(study: Study, experiment: Experiment) -> FloatArray | None:
    """Scores of the present filter in the runs of a study, shape (runs,).

    None where it has no constant gains, is not stable, or that would take too long.
    """
    runs = effective_runs(study.experiment, study.objective, study.runs)
    return scores_in(study.experiment, study, runs, experiment)


def scores_in(runs_of: Experiment, study: Study, runs: int, *filters: Experiment) -> FloatArray | None:
    """Scores of filters by a study's objective, shape (filters * runs,), the runs of one filter after another.

    Args:
        runs_of: target, sensor and first seed.
        study: whose objective counts.
        runs: how many.
        filters: whose gains are tried; None comes back where one has no constant ones, or none that are stable.
    """
    if any(each.method is not None or not is_stable(each.gains()) for each in filters):
        return None
    if len(filters) * runs * steps_of(runs_of) > MOST_STEPS:
        return None
    vectors = tuple(tuple(each.gains().vector.tolist()) for each in filters)
    return _scores(runs_of, vectors, study.objective, runs, study.weight)


@lru_cache(maxsize=64)
def _scores(
    experiment: Experiment, vectors: tuple[tuple[float, ...], ...], objective: str, runs: int, weight: float
) -> FloatArray:
    *_, (_, _, scores) = scored(experiment, np.array(vectors), (objective,), runs, weight, None)
    return scores[0].T.ravel()
