"""The searches of the documents: one number of a filter varied over many runs, all objectives at once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from tracker_core.batch import KINDS
from tracker_core.checks import InputError, check_choice
from tracker_core.experiment import Experiment
from tracker_core.tuning import OBJECTIVES, PARAMETERS
from tracker_core.tuning.evaluate import run_errors
from tracker_core.tuning.objectives import HOWS
from tracker_core.tuning.sweeps import varied
from tracker_core.types import FloatArray

MEASURED = tuple(name for name, objective in OBJECTIVES.items() if objective.kind)
"""The objectives that runs are needed for."""


def sweep(
    experiment: Experiment, parameter: str, values: Sequence[float], objective: str, seeds: Sequence[int]
) -> FloatArray:
    """A figure of merit at every value of a parameter, for every seed. Runs are remembered, for other ones as well.

    Args:
        experiment: one with constant gains; its design must have the field that the parameter sets.
        parameter: a name in `tuning.PARAMETERS`.
        values: of the parameter, each in the domain of the design.
        objective: a name in MEASURED.
        seeds: of the noise, whole numbers >= 0.

    Returns:
        Shape (len(seeds), len(values)), in the unit of the objective, not to be written to. NaN where the run stopped
        or the figure of merit is not defined.

    Raises:
        InputError: for an unknown parameter or objective, a design without that parameter, a value outside its domain.
    """
    field = PARAMETERS[check_choice("parameter", parameter, PARAMETERS)].sets
    check_choice("objective", objective, MEASURED)
    if getattr(experiment, field) is None:
        raise InputError("parameter", f"must be one of the design '{experiment.design}'", parameter)
    found = _measured(experiment, parameter, tuple(values), tuple(seeds))
    return found[MEASURED.index(objective)]


@lru_cache(maxsize=512)
def _measured(experiment: Experiment, parameter: str, values: tuple[float, ...], seeds: tuple[int, ...]) -> FloatArray:
    """All objectives, shape (len(MEASURED), len(seeds), len(values)): the runs are what takes the time."""
    vectors = np.array([varied(experiment, parameter, value).gains().vector for value in values])
    errors = run_errors(experiment, seeds, vectors, figures=HOWS, kinds=KINDS)
    found = np.array([OBJECTIVES[name].of(errors).T for name in MEASURED])
    found.setflags(write=False)
    return found
