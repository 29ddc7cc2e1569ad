"""Gains that follow from the number of measurements alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tracker_core.adaptive.base import Draft, Problem, Selection
from tracker_core.filters import Setting
from tracker_core.types import FloatArray, IntArray


def measurement_counts(setting: Setting, axis: int) -> IntArray:
    """How many measurements there have been up to each sample, shape (n_samples,).

    Those of the start count; a state that was given counts as many measurements as it has components.
    """
    given = setting.order if setting.initial_state is not None else 0
    return np.cumsum(~np.isnan(setting.z[:, axis])) + given


def run_schedule(problem: Problem, gains: Callable[[int, IntArray], FloatArray]) -> Selection:
    """Filter every axis with the gains of each measurement's number.

    Args:
        problem: the run.
        gains: from an axis and the `measurement_counts` of it to the gains of every sample, (n_samples, order).
    """
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    draft, setting = Draft.of(problem), problem.setting
    for axis in range(problem.shape[1]):
        schedule = np.ascontiguousarray(gains(axis, measurement_counts(setting, axis)))
        state, begin = draft.begin(axis)
        draft.stops.append(
            kernels.scheduled(
                setting.column(axis), setting.dt, schedule, state, begin, setting.limit,
                draft.predicted[axis], draft.smoothed[axis], draft.used[axis],
            )
        )  # fmt: skip
    return draft.selection()
