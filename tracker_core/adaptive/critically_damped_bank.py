"""A causal bank of critically damped filters, mixed by their past innovations.

K filters of the wanted order and K of the order below run side by side, each with its own state: fading-memory
filters with every pole at x = exp(-T/tau), tau spaced evenly in its logarithm. The track is their mean, weighted by
J^(-N/2): J the innovation power over a window that fades with the memory, all axes added, and N the window's length,
the sum of its weights. With one axis that is the probability of each member given the window, were its innovations
white and Gaussian with a variance nobody knows; several axes count as one, which mixes more cautiously. It needs
neither the noise nor the truth; and a mean of stable filters is bounded for every bounded input.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import exp
from typing import Any

import numpy as np

from tracker_core.adaptive.base import Draft, Method, Problem, Selection, Shape, check_weights
from tracker_core.checks import InputError
from tracker_core.design import DESIGNS
from tracker_core.types import FloatArray


def member_orders(order: int) -> range:
    """The order itself and the one below, if there is one."""
    return range(max(2, order - 1), order + 1)


def rule(shape: Shape, parameters: Mapping[str, Any]) -> None:
    """The fastest member is the fastest, and the weights fit into memory."""
    shortest, longest = parameters["shortest"], parameters["longest"]
    if not shortest <= longest:
        raise InputError("longest", f"must be >= {shortest:g}, the shortest", longest)
    check_weights(shape, parameters["members"], len(member_orders(shape.order)))


def bank_members(order: int, members: int, shortest: float, longest: float, interval: float) -> FloatArray:
    """The gains of the bank, shape (K or 2 K, order), normalised; a gain that a member does not have is zero."""
    rows = []
    for member_order in member_orders(order):
        for tau in np.geomspace(shortest, longest, members).tolist():
            gains = DESIGNS["fading-memory"].gains(member_order, xi=exp(-interval / tau))
            rows.append(np.pad(gains, (0, order - member_order)))
    return np.array(rows)


def work(problem: Problem, *, members: int, shortest: float, longest: float, memory: float) -> Selection:
    """See the module."""
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    samples, axes, order = problem.shape
    gains = bank_members(order, members, shortest, longest, problem.interval)
    draft, setting = Draft.of(problem), problem.setting
    states, begins = np.zeros((axes, len(gains), order)), np.zeros(axes, dtype=np.int64)
    for axis in range(axes):
        state, begins[axis] = draft.begin(axis)
        # A member without the last gain has no last state: it would never be corrected.
        states[axis] = np.where(gains != 0, state, 0.0)
    weights = np.full((samples, len(gains)), np.nan)
    draft.stops.append(
        kernels.bank_mixture(
            np.array(setting.z, order="C"), setting.dt, gains, states, begins, setting.limit,
            problem.decays(memory), draft.predicted, draft.smoothed, draft.used, weights,
        )
    )  # fmt: skip
    return draft.selection(members=gains, shares=weights)


METHOD = Method(
    name="critically-damped-bank",
    title="Bank of critically damped filters",
    orders=(2, 3, 4),
    parameters={
        "members": 12,
        "shortest": lambda interval: 1.2 * interval,
        "longest": lambda interval: max(20.0, 24 * interval),
        "memory": lambda interval: max(4.0, 10 * interval),
    },
    work=work,
    rule=rule,
    sentence="Fading-memory filters of this order and the one below, their time constants τ spaced evenly in the "
    "logarithm, mixed by their past innovations; the gains shown are their mean. Needs neither the noise nor the "
    "truth, and stays bounded.",
    source="Gainscope; the weights are those of a Bayesian mean over members with unknown innovation variance",
)
