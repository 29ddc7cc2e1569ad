"""Yu & Wu 2017: the gains that come nearest to the true acceleration or jerk, searched anew at every sample.

The grid has `grid` levels of alpha, beta and gamma, and `grid_eta` of eta, between the bounds that the paper prints
for them (eq. 10-12, 21-24); as beta's bound depends on alpha and gamma's on both, the levels are shares of them. The
objective is one state's error, and that depends on one gain only: all sets with the same value of it are equally good,
and which of them is taken decides how the other states fare. So levels are kept as fractions until the end: equal
gains are equal to the last bit, and ties are broken by rule.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from tracker_core.adaptive.base import Draft, Method, Problem, Selection, Shape, check_work
from tracker_core.checks import InputError
from tracker_core.stability import region_margins
from tracker_core.types import GAIN_NAMES, STATE_NAMES, FloatArray, IntArray

PRINTED = Fraction(13, 6)
"""Factor of beta's bound in eq. 11 and 22; 1 is right for order 3."""

STEP_OF_A_FILTER = 3
"""What a step of a whole filter counts in the work of a run: it takes many times as long as trying one gain."""

CLEAR = 1e-11
"""How far a set must lie within the stable region: end points give sets on its border, which rounding may let in."""


def level(end_points: str, number: int, count: int) -> Fraction:
    """Level `number` (from 1) of `count` as a share of the range of a gain."""
    if end_points == "upper":
        return Fraction(number, count)
    if end_points == "middle":
        return Fraction(2 * number - 1, 2 * count)
    if end_points == "both":
        return Fraction(number - 1, count - 1)
    return Fraction(number, count + 1)


@lru_cache(maxsize=64)
def candidates(order: int, grid: int, grid_eta: int, end_points: str, bound: str) -> tuple[FloatArray, IntArray]:
    """The sets of gains that are tried, in the order in which ties are broken: by level of gamma, alpha, beta, eta.

    Args:
        order: 3 or 4.
        grid: levels of alpha, beta and gamma.
        grid_eta: levels of eta.
        end_points: key of END_POINTS.
        bound: key of BOUNDS.

    Returns:
        Normalised gains, shape (C, order), and their levels, same shape, from 1.

    Raises:
        InputError: when no set is admitted.
    """
    counts = (grid, grid, grid, grid_eta)[:order]
    for name, count in zip(("grid", "grid_eta"), counts[2:], strict=False):
        if end_points == "both" and count < 2:
            raise InputError(name, "must be >= 2 for levels at both ends", count)
    gains, levels = [], []
    for gamma_level, alpha_level, beta_level, *eta_level in product(
        *(range(1, count + 1) for count in (grid, grid, grid, *counts[3:]))
    ):
        numbers = (alpha_level, beta_level, gamma_level, *eta_level)
        shares = [level(end_points, number, count) for number, count in zip(numbers, counts, strict=True)]
        gains.append([float(gain) for gain in _between_bounds(shares, PRINTED if bound == "printed" else Fraction(1))])
        levels.append(numbers)
    sets, numbers_of = np.array(gains), np.array(levels)
    if bound == "exact":
        kept = np.all(region_margins(sets) > CLEAR, axis=-1)
        sets, numbers_of = sets[kept], numbers_of[kept]
    if not len(sets):
        raise InputError("grid", "must hold a stable set of gains", grid)
    for array in (sets, numbers_of):
        array.setflags(write=False)
    return sets, numbers_of


def _between_bounds(shares: list[Fraction], factor: Fraction) -> list[Fraction]:
    """Normalised gains at these shares of eq. 10-12 and 21-24; the paper's gamma is twice, its delta six times them."""
    alpha = 2 * shares[0]
    beta_bound = factor * (4 - 2 * alpha)
    # 4 alpha beta/(2 - alpha), whose divisor is one of beta's bound: nothing is divided by zero at alpha = 2.
    gamma_bound = 8 * alpha * factor * shares[1]
    gains = [alpha, beta_bound * shares[1], gamma_bound * shares[2] / 2]
    if len(shares) == 4:
        gains.append(24 * (2 - alpha) * shares[3] / 6)
    return gains


def neighbours(levels: IntArray, which: int) -> tuple[IntArray, IntArray]:
    """For every set the one a level lower, and a level higher, in gain number `which`; -1 where there is none."""
    place = {tuple(row): i for i, row in enumerate(levels.tolist())}

    def beside(row: list[int], step: int) -> int:
        return place.get((*row[:which], row[which] + step, *row[which + 1 :]), -1)

    lower, upper = (np.array([beside(row, step) for row in levels.tolist()]) for step in (-1, 1))
    return lower, upper


def distinct(values: FloatArray, *, last: bool) -> IntArray:
    """Where every distinct value stands first, or last, in ascending order.

    Sets that share the gain of the followed state leave the same error of it: one of them stands for all.
    """
    backwards = values[::-1]
    _, places = np.unique(backwards if last else values, return_index=True)
    return np.sort(len(values) - 1 - places if last else places)


def rule(shape: Shape, parameters: Mapping[str, Any]) -> None:
    """There is a set to try, the search takes seconds at most, and the objective is known and followed."""
    objective, grid = parameters["objective"], parameters["grid"]
    which = STATE_NAMES.index(objective)
    if not shape.known_states:
        raise InputError("design", "must not be one that needs the truth where nobody knows it", "a search")
    followed = min(shape.order, shape.known_states)
    if which >= followed:
        names = ", ".join(STATE_NAMES[:followed])
        raise InputError("objective", f"must be one of {names}, which are known and followed here", objective)
    tried = grid**3 * (parameters["grid_eta"] if shape.order == 4 else 1)
    check_work("grid", grid, tried * max(20_000, shape.samples * shape.axes))
    candidates(shape.order, grid, parameters["grid_eta"], parameters["end_points"], parameters["bound"])


def rule_for_the_run(shape: Shape, parameters: Mapping[str, Any]) -> None:
    """The same; and every admitted set is a whole filter, where a search at a sample only compares one gain."""
    rule(shape, parameters)
    names = ("grid", "grid_eta", "end_points", "bound")
    sets, _ = candidates(shape.order, *(parameters[name] for name in names))
    check_work("grid", parameters["grid"], STEP_OF_A_FILTER * len(sets) * shape.samples * shape.axes)


def per_sample(
    problem: Problem, *, grid: int, grid_eta: int, end_points: str, bound: str, ties: str, parabola: str, objective: str
) -> Selection:
    """At every sample, and for every axis, the set that leaves the least error of one state."""
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    which = STATE_NAMES.index(objective)
    truth, (_, axes, order) = problem.true_state(which), problem.shape
    sets, levels = candidates(order, grid, grid_eta, end_points, bound)
    lower = upper = np.empty(0, dtype=np.int64)
    if parabola == "printed":
        lower, upper = neighbours(levels, which)
    else:
        sets = sets[distinct(sets[:, which], last=ties == "last")]
        # As those above: to compiled code an array that may be written to is of another type.
        sets.setflags(write=False)
    draft, setting = Draft.of(problem), problem.setting
    for axis in range(axes):
        state, begin = draft.begin(axis)
        draft.stops.append(
            kernels.sample_search(
                setting.column(axis), setting.dt, truth[axis], which, sets, ties == "last", lower, upper,
                state, begin, setting.limit, draft.predicted[axis], draft.smoothed[axis], draft.used[axis],
            )
        )  # fmt: skip
    return draft.selection()


def for_the_run(
    problem: Problem, *, grid: int, grid_eta: int, end_points: str, bound: str, ties: str, objective: str
) -> Selection:
    """The one set that leaves the least mean square error of a state over the whole run, all axes together."""
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    which = STATE_NAMES.index(objective)
    truth, (samples, axes, order) = problem.true_state(which), problem.shape
    sets, _ = candidates(order, grid, grid_eta, end_points, bound)
    scores, setting = np.zeros(len(sets)), problem.setting
    room = np.empty((samples, order))
    for axis in range(axes):
        state, begin = setting.begin(axis, np.ones(order), room, room)
        kernels.candidate_scores(
            setting.column(axis), setting.dt, truth[axis], which, sets, state, begin, setting.limit, scores
        )
    best = len(scores) - 1 - int(np.argmin(scores[::-1])) if ties == "last" else int(np.argmin(scores))
    gains = np.ascontiguousarray(np.broadcast_to(sets[best], (samples, order)))
    draft = Draft.of(problem)
    for axis in range(axes):
        state, begin = draft.begin(axis)
        draft.stops.append(
            kernels.scheduled(
                setting.column(axis), setting.dt, gains, state, begin, setting.limit,
                draft.predicted[axis], draft.smoothed[axis], draft.used[axis],
            )
        )  # fmt: skip
    return draft.selection(found={name: (float(gain),) for name, gain in zip(GAIN_NAMES, sets[best], strict=False)})


def _reason(parameters: Mapping[str, Any]) -> str:
    return f"The gains are those that come nearest to the true {parameters['objective']}, which no tracker knows."


GRID = {"grid": 4, "grid_eta": 6, "end_points": "interior", "bound": "exact", "ties": "first"}

PER_SAMPLE = Method(
    name="sample-search",
    title="Search at every sample (Yu & Wu)",
    orders=(3, 4),
    parameters={**GRID, "parabola": "none", "objective": "acceleration"},
    work=per_sample,
    rule=rule,
    sentence="At every sample each set of gains of a grid is tried, and the one used whose smoothed acceleration (or "
    "other state) comes nearest to the truth.",
    source="Yu & Wu 2017, section 3",
    hindsight=_reason,
    counterpart="critically-damped-bank",
)

FOR_THE_RUN = Method(
    name="run-search",
    title="Search for the run (constant gains)",
    orders=(3, 4),
    parameters={**GRID, "objective": "position"},
    work=for_the_run,
    rule=rule_for_the_run,
    sentence="The same grid; the one set is used whose smoothed position (or other state) is nearest to the truth over "
    "the whole run.",
    source="The grid of Yu & Wu 2017 with one choice for each interval T",
    hindsight=_reason,
    counterpart="critically-damped-bank",
)
