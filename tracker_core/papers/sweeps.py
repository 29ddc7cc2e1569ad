"""One number of a filter varied over many runs: how well it does at every value, for every seed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from math import sqrt
from typing import Any

import numpy as np

from tracker_core.batch import KINDS, batch_errors
from tracker_core.checks import POSITIVE, InputError, check_choice
from tracker_core.experiment import Experiment
from tracker_core.run import known_state, observe
from tracker_core.types import FloatArray


def _same(_: Experiment, value: float) -> float:
    return value


def _process(experiment: Experiment, variance: float) -> float:
    """Tracking index at a sensor variance of 1."""
    return experiment.interval**2 * sqrt(POSITIVE.check("process_variance", variance))


def _sensor(experiment: Experiment, variance: float) -> float:
    """Tracking index at the process variance of the experiment, whose own index is that of a sensor variance of 1."""
    return (experiment.tracking_index or 0.0) / sqrt(POSITIVE.check("sensor_variance", variance))


SWEPT: dict[str, tuple[str, Callable[[Experiment, float], float]]] = {
    "alpha": ("alpha", _same),
    "gamma": ("gamma", _same),
    "xi": ("xi", _same),
    "process_variance": ("tracking_index", _process),
    "sensor_variance": ("tracking_index", _sensor),
}
"""What can be varied: the field of the experiment that it sets, and how that follows from a value.

The gains depend on the two variances through the tracking index T² √(σ_w²/σ_v²) alone.
"""


OBJECTIVES = tuple(f"{kind}_{how}" for kind in KINDS for how in ("total", "rmse", "max", "l2"))
"""What can be looked at: the errors of `batch.KINDS`, their total, root mean square, greatest and L2, m."""


def sweep(
    experiment: Experiment, parameter: str, values: Sequence[float], objective: str, seeds: Sequence[int]
) -> FloatArray:
    """A figure of merit at every value of a parameter, for every seed. Runs are remembered, for other ones as well.

    Args:
        experiment: one with constant gains; its design must have the field that the parameter sets.
        parameter: a name in SWEPT. Variances are in units in which the other one of the experiment is fixed: the
            sensor's at 1, the process's at (tracking_index/T²)².
        values: of the parameter, each in the domain of the design.
        objective: a name in OBJECTIVES.
        seeds: of the noise, whole numbers >= 0.

    Returns:
        Shape (len(seeds), len(values)), in the unit of the objective, not to be written to. NaN where the run stopped
        or the figure of merit is not defined.

    Raises:
        InputError: for an unknown parameter or objective, a design without that parameter, a value outside its domain.
    """
    check_choice("parameter", parameter, SWEPT)
    check_choice("objective", objective, OBJECTIVES)
    field = SWEPT[parameter][0]
    if getattr(experiment, field) is None:
        raise InputError("parameter", f"must be one of the design '{experiment.design}'", parameter)
    found = _measured(experiment, parameter, tuple(values), tuple(seeds))
    return found[OBJECTIVES.index(objective)]


@lru_cache(maxsize=512)
def _measured(experiment: Experiment, parameter: str, values: tuple[float, ...], seeds: tuple[int, ...]) -> FloatArray:
    """All objectives, shape (len(OBJECTIVES), len(seeds), len(values)): the runs are what takes the time."""
    field, follow = SWEPT[parameter]
    settings: list[dict[str, Any]] = [{field: follow(experiment, value)} for value in values]
    vectors = np.array([replace(experiment, **setting).gains().vector for setting in settings])
    found = np.empty((len(OBJECTIVES), len(seeds), len(values)))
    for row, seed in enumerate(seeds):
        seeded = replace(experiment, seed=seed)
        truth, measurements, _ = observe(seeded)
        before = known_state(seeded)
        errors = batch_errors(measurements, truth, vectors, start=experiment.start, initial_state=before)
        for index, objective in enumerate(OBJECTIVES):
            kind, how = objective.split("_")
            found[index, row] = getattr(errors[kind], how)
    found.setflags(write=False)
    return found
