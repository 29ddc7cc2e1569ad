"""From what a link says to the study that it asks for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from layouts.state import Settings
from tracker_core import Experiment, InputError
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.design import MANUAL
from tracker_core.experiment import PARAMETERS
from tracker_core.tuning import Map, Search, Sweep
from tracker_core.tuning.base import knows_truth
from tracker_core.tuning.sweeps import usual_values, varied
from tracker_core.types import GAIN_NAMES

Study = Sweep | Map | Search

JUDGE = "estimation_rmse"
"""What tuning without a truth is measured by where the truth is known after all."""

CONTROLS = {
    "parameter": "against", "low": "from", "high": "to", "values": "points", "columns": "cells", "rows": "cells",
    "runs": "tune_runs", "objective": "tune_for", "weight": "noise_weight",
}  # fmt: skip
"""The control that is to blame where a study refuses one of its fields."""


def study_of(settings: Settings) -> Study:
    """The study that the settings ask for: the same one whatever they say that does not matter to it.

    Raises:
        InputError: naming the control, for what cannot be studied, or would take too long.
    """
    try:
        return STUDIES[settings.view.tuning.study](settings)
    except InputError as error:
        raise InputError(CONTROLS.get(error.field, error.field), error.rule, error.received) from error


def _sweep(settings: Settings) -> Sweep:
    tuning, experiment = settings.view.tuning, settings.experiment
    parameter = tuning.parameter(experiment)
    values = usual_values(experiment, parameter, tuning.low, tuning.high, tuning.points)
    for control, end in (("from", values[0]), ("to", values[-1])):
        try:
            varied(experiment, parameter, end)
        except InputError as error:
            raise InputError(control, error.rule, end) from error
    # Of the sensor's variance Λ counts, from which the process's is known; what a gate refuses is up to all gains.
    if parameter != "sensor_variance" and experiment.gate is None:
        experiment = varied(experiment, parameter, values[0])
    return Sweep(experiment, parameter, values, beside=_beside(settings), **_common(settings))


def _map(settings: Settings) -> Map:
    experiment, plane, cells = settings.experiment, settings.view.plane, settings.view.tuning.cells
    if experiment.method is not None:
        raise InputError("design", "must have constant gains for a map", experiment.design)
    gains = dict(zip(GAIN_NAMES, experiment.gains().values, strict=False))
    if experiment.gate is None:
        gains |= dict.fromkeys(plane, 0.5)
    common = _common(settings)
    return Map(by_hand(experiment, gains), plane, columns=cells, rows=cells, beside=_beside(settings), **common)


def _search(settings: Settings) -> Search:
    experiment = settings.experiment
    gains = dict.fromkeys(GAIN_NAMES[: experiment.order], 0.1)
    if experiment.gate is not None:
        gains = dict(zip(GAIN_NAMES, experiment.gains().values, strict=False))
    return Search(by_hand(experiment, gains), budget=settings.view.tuning.budget, **_common(settings))


STUDIES: dict[str, Callable[[Settings], Study]] = {"sweep": _sweep, "map": _map, "search": _search}


def _common(settings: Settings) -> dict[str, Any]:
    tuning = settings.view.tuning
    return {"objective": tuning.objective, "runs": tuning.runs, "weight": tuning.weight}


def _beside(settings: Settings) -> tuple[str, ...]:
    return (JUDGE,) if settings.view.tuning.without_truth and knows_truth(settings.experiment) else ()


def by_hand(experiment: Experiment, gains: dict[str, float]) -> Experiment:
    """The same target, sensor and start with constant gains, in the experiment's convention."""
    values: dict[str, Any] = dict.fromkeys((*PARAMETERS, *METHOD_PARAMETERS)) | gains
    return replace(experiment, design=MANUAL, **values)
