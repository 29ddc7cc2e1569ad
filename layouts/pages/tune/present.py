"""Where the present filter stands in a study."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from layouts.pages.tune.studies import Study
from tracker_core import Experiment
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
        return (value / experiment.interval**2) ** 2
    return 1.0 if value is not None and parameter == "sensor_variance" else value


def present_scores(study: Study, experiment: Experiment) -> FloatArray | None:
    """Scores of the present filter in the runs of a study, shape (runs,).

    None where it has no constant gains, is not stable, or that would take too long.
    """
    if experiment.method is not None or not is_stable(experiment.gains()):
        return None
    runs = effective_runs(study.experiment, study.objective, study.runs)
    if runs * steps_of(study.experiment) > MOST_STEPS:
        return None
    vector = tuple(experiment.gains().vector.tolist())
    return _scores(study.experiment, vector, study.objective, runs, study.weight)


@lru_cache(maxsize=64)
def _scores(experiment: Experiment, vector: tuple[float, ...], objective: str, runs: int, weight: float) -> FloatArray:
    *_, (_, _, scores) = scored(experiment, np.array([vector]), (objective,), runs, weight, None)
    return scores[0, :, 0]
