"""M3 of Al-Wagih & Abdulla: alpha of the growing memory, beta between its own and that of a fixed alpha."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tracker_core.adaptive.base import Draft, Method, Problem, Selection
from tracker_core.adaptive.growing_memory import growing_gains
from tracker_core.adaptive.scheduled import measurement_counts, run_schedule
from tracker_core.design import DESIGNS
from tracker_core.types import FloatArray, IntArray

WEIGHTS = np.linspace(0, 1, 101)
"""What is tried where no weight is given; the smallest of equally good ones is taken."""


def combined_gains(fixed_alpha: float, weight: float, counts: IntArray) -> FloatArray:
    """Gains of each measurement's number, shape (n_samples, 2): beta = w beta_fixed + (1 - w) beta_growing."""
    gains = growing_gains(2, counts)
    gains[:, 1] = weight * _fixed_beta(fixed_alpha) + (1 - weight) * gains[:, 1]
    return gains


def _fixed_beta(fixed_alpha: float) -> float:
    return float(DESIGNS["benedict-bordner"].gains(2, alpha=fixed_alpha)[1])


def work(problem: Problem, *, fixed_alpha: float, weight: float | None, criterion: str) -> Selection:
    """With the weight given; without, that of each axis whose innovations over the whole run are least."""
    axes = range(problem.shape[1])
    weights = [_best_weight(problem, axis, fixed_alpha, criterion) if weight is None else weight for axis in axes]
    selection = run_schedule(problem, lambda axis, counts: combined_gains(fixed_alpha, weights[axis], counts))
    return selection if weight is not None else replace(selection, found={"weight": tuple(weights)})


def _best_weight(problem: Problem, axis: int, fixed_alpha: float, criterion: str) -> float:
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    setting, costs = problem.setting, np.zeros(len(WEIGHTS))
    state, begin = Draft.of(problem).begin(axis)
    gains = growing_gains(2, measurement_counts(setting, axis))
    kernels.weight_costs(
        setting.column(axis), setting.dt, gains, _fixed_beta(fixed_alpha), WEIGHTS, state, begin, setting.limit,
        criterion == "mean-absolute", costs,
    )  # fmt: skip
    return float(WEIGHTS[np.argmin(costs)])


def hindsight(parameters: Mapping[str, Any]) -> str:
    """A weight that is searched is known only after the run."""
    if parameters.get("weight") is not None:
        return ""
    return "The weight is searched over the whole run, the future included."


METHOD = Method(
    name="linear-combination",
    title="Linear combination (M3)",
    orders=(2,),
    parameters={"fixed_alpha": 0.05, "weight": None, "criterion": "mean-square"},
    work=work,
    sentence="α of the growing memory; β = w β₀ + (1 − w) β of the growing memory, β₀ = α₀²/(2 − α₀). Without a "
    "weight the one with the least innovations is searched, for each axis.",
    source="Al-Wagih & Abdulla, eq. 25, algorithm 1, method M3",
    hindsight=hindsight,
    counterpart="growing-memory",
)
