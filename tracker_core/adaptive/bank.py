"""M5 of Al-Wagih & Abdulla, a bank of K alpha-beta filters of which one speaks, in hindsight; and causally."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tracker_core.adaptive.base import Draft, Method, Problem, Selection, Shape, check_work
from tracker_core.design import DESIGNS
from tracker_core.types import FloatArray

HINDSIGHT = -1.0
"""Stands for the decay of the window where there is none: see `kernels.bank_choice`."""


def bank_members(members: int) -> FloatArray:
    """The gains of the bank, shape (K, 2): alpha in the middle of each K-th of (0, 1), beta after Benedict-Bordner."""
    alphas = (np.arange(members) + 0.5) / members
    return np.stack([DESIGNS["benedict-bordner"].gains(2, alpha=alpha) for alpha in alphas.tolist()])


def _run(problem: Problem, members: int, decays: FloatArray) -> Selection:
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    samples, axes, _ = problem.shape
    gains = bank_members(members)
    draft, setting = Draft.of(problem), problem.setting
    chosen = np.full((axes, samples), -1)
    for axis in range(axes):
        state, begin = draft.begin(axis)
        draft.stops.append(
            kernels.bank_choice(
                setting.column(axis), setting.dt, gains, state, begin, setting.limit, decays,
                draft.predicted[axis], draft.smoothed[axis], draft.used[axis], chosen[axis],
            )
        )  # fmt: skip
    return draft.selection(members=gains, speaker=chosen.T)


def rule(shape: Shape, parameters: Mapping[str, Any]) -> None:
    """All members must be filtered within seconds."""
    members = parameters["members"]
    check_work("members", members, members * shape.samples * shape.axes)


def in_hindsight(problem: Problem, *, members: int) -> Selection:
    """The member whose prediction lies nearest the measurement speaks."""
    return _run(problem, members, np.array([HINDSIGHT]))


def causal(problem: Problem, *, members: int, memory: float) -> Selection:
    """The member with the least past innovations speaks."""
    return _run(problem, members, problem.decays(memory))


def _reason(_: Mapping[str, Any]) -> str:
    return "The prediction is picked after the measurement that it predicts has been seen."


ORACLE = Method(
    name="parallel-bank",
    title="Parallel bank (M5)",
    orders=(2,),
    parameters={"members": 12},
    work=in_hindsight,
    rule=rule,
    sentence="K filters run side by side; at every sample the one whose prediction lies nearest the measurement "
    "speaks. αᵢ = (i − ½)/K, β = α²/(2 − α).",
    source="Al-Wagih & Abdulla, algorithm 3, method M5",
    hindsight=_reason,
    counterpart="parallel-bank-causal",
)

CAUSAL = Method(
    name="parallel-bank-causal",
    title="Parallel bank by past innovations",
    orders=(2,),
    parameters={"members": 12, "memory": lambda interval: 10 * interval},
    work=causal,
    rule=rule,
    sentence="The same K filters; the one with the least innovation power so far speaks, the past fading with the "
    "memory.",
    source="The causal form of Al-Wagih & Abdulla's method M5",
)
