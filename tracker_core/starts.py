"""The ways of starting a filter: the state before its recursion takes over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tracker_core.checks import InputError
from tracker_core.motion import transition
from tracker_core.types import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class Start:
    """A way of starting the filter.

    Attributes:
        name: key in the registry.
        title: for menus.
        sentence: what it does, for tooltips and docs.
        points: measurements that each axis must have for it.
        least_order: the lowest filter order that it makes sense for.
    """

    name: str
    title: str
    sentence: str
    points: int
    least_order: int = 2


STARTS: dict[str, Start] = {
    s.name: s
    for s in (
        Start("known", "Known state", "The true state one interval before the first sample is given.", 0),
        Start("first", "First measurement", "Position from the first measurement, everything else zero.", 1),
        Start(
            "two-point",
            "Two points",
            "Position and velocity from the first two measurements; predictions begin at the third sample.",
            2,
        ),
        Start(
            "three-point",
            "Three points",
            "Position, velocity and acceleration of the parabola through the first three measurements.",
            3,
            least_order=3,
        ),
        Start(
            "expanding",
            "Expanding memory",
            "Least squares over all measurements so far, until its position gain has fallen to alpha.",
            1,
        ),
    )
}


def start_axis(
    start: str,
    z: FloatArray,
    dt: FloatArray,
    g: FloatArray,
    given: FloatArray | None,
    predicted: FloatArray,
    smoothed: FloatArray,
) -> tuple[FloatArray, int]:
    """Start one axis.

    Args:
        start: a name in STARTS.
        z: shape (n,), measurements, NaN where missing.
        dt: interval before each sample, or the one number if it is constant, s.
        g: shape (order,), normalised gains.
        given: shape (order,), the state before the first sample, for the start "known".
        predicted, smoothed: shape (n, order); what lies before the recursion is filled in here, NaN where undefined.

    Returns:
        The state before the recursion, and the index of the sample where it begins.

    Raises:
        InputError: when the axis has fewer measurements than the start needs.
    """
    if given is not None:
        return given.astype(np.float64), 0
    order, points = len(g), STARTS[start].points
    seen = _first_measured(z, max(points, order if start == "expanding" else 1))
    if len(seen) < points:
        raise InputError("positions", f"must hold at least {points} measurements per axis for '{start}'", len(seen))
    # A growing memory begins with the gain 1: a filter that keeps a gain as high is started by its first measurement.
    if start == "expanding" and g[0] < 1:
        return _expand(z, dt, g, seen, predicted, smoothed)
    seen = seen[:points]
    begin = int(seen[-1]) + 1
    predicted[:begin] = smoothed[:begin] = np.nan
    smoothed[seen, 0] = z[seen]
    state, _ = _through(z, dt, seen, order)
    smoothed[begin - 1] = state
    return state, begin


def start_axes(
    start: str,
    z: FloatArray,
    dt: FloatArray,
    g: FloatArray,
    given: FloatArray | None,
    predicted: FloatArray,
    smoothed: FloatArray,
) -> tuple[FloatArray, IntArray]:
    """Start every axis as `start_axis` does, to the last bit; all at once where nothing is missing.

    Args:
        start, dt, g: as there.
        z: shape (n_axes, n).
        given: shape (n_axes, order), for the start "known".
        predicted, smoothed: shape (n_axes, n, order).

    Returns:
        The states, shape (n_axes, order), and where the recursion begins, shape (n_axes,).

    Raises:
        InputError: when an axis has fewer measurements than the start needs.
    """
    axes, points = len(z), STARTS[start].points
    head = z[:, :points]
    states, begins = np.zeros((axes, len(g))), np.full(axes, points)
    if start in {"known", "expanding"} or head.shape[1] < points or np.isnan(head).any():
        for axis in range(axes):
            before = None if given is None else given[axis]
            states[axis], begins[axis] = start_axis(start, z[axis], dt, g, before, predicted[axis], smoothed[axis])
        return states, begins
    inverse = _inverse(dt, range(points))
    for axis in range(axes):
        states[axis, :points] = inverse @ head[axis]
    predicted[:, :points] = smoothed[:, :points] = np.nan
    smoothed[:, :points, 0] = head
    smoothed[:, points - 1] = states
    return states, begins


def _first_measured(z: FloatArray, count: int) -> IntArray:
    """Where the first `count` measurements are; all of them where there are fewer."""
    if not np.isnan(z[:count]).any():
        return np.arange(min(count, len(z)))
    return np.flatnonzero(~np.isnan(z))[:count]


def _expand(
    z: FloatArray, dt: FloatArray, g: FloatArray, seen: IntArray, predicted: FloatArray, smoothed: FloatArray
) -> tuple[FloatArray, int]:
    """Growing memory: the polynomial through the first measurements, then least squares."""
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    order, n = len(g), len(z)
    predicted[: seen[0] + 1] = smoothed[: seen[0]] = np.nan
    for count in range(1, len(seen) + 1):
        here = int(seen[count - 1])
        state, inverse = _through(z, dt, seen[:count], order)
        smoothed[here] = state
        if count < order:
            following = int(seen[count]) if count < len(seen) else n
            for i in range(here + 1, min(following + 1, n)):
                predicted[i] = transition(order, _elapsed(dt, here, i)) @ state
                if i < following:
                    smoothed[i] = predicted[i]
    if len(seen) < order:
        return state, n
    covariance = inverse @ inverse.T
    begin = kernels.least_squares_start(z, dt, float(g[0]), state, covariance, here + 1, predicted, smoothed)
    return state, int(begin)


def _through(z: FloatArray, dt: FloatArray, points: IntArray, order: int) -> tuple[FloatArray, FloatArray]:
    """The polynomial through some measurements as a state at the last of them.

    Returns:
        The state, shape (order,), zero beyond the polynomial's degree; and the matrix, shape (points, points), that
        makes its leading part out of the measurements.
    """
    count = len(points)
    inverse = _inverse(dt, points.tolist())
    state = np.zeros(order)
    state[:count] = inverse @ z[points]
    return state, inverse


def _inverse(dt: FloatArray, points: Sequence[int]) -> FloatArray:
    """The matrix from measurements at these samples to the state at the last of them."""
    return interpolation(tuple(-_elapsed(dt, point, points[-1]) for point in points))


@lru_cache(maxsize=256)
def interpolation(times: tuple[float, ...]) -> FloatArray:
    """The matrix from measurements at these times, s, to the state at time zero; the same ones come again and again."""
    inverse = np.linalg.inv(np.array([transition(len(times), time)[0] for time in times]))
    inverse.setflags(write=False)
    return inverse


def _elapsed(dt: FloatArray, earlier: int, later: int) -> float:
    """Time from one sample to a later one, s."""
    return (later - earlier) * float(dt[0]) if len(dt) == 1 else float(dt[earlier + 1 : later + 1].sum())
