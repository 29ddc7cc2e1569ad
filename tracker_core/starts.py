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


@dataclass(frozen=True, slots=True)
class Beginning:
    """What the first measurements of an axis alone give.

    Attributes:
        state: shape (order,), at sample begin - 1; zero beyond what is known.
        weights: the matrix that makes its leading part out of those measurements, shape (points, points); empty for
            the start "known", and where too few are measured to tell anything.
        begin: the sample after them.
        growing: whether least squares goes on from here.
    """

    state: FloatArray
    weights: FloatArray
    begin: int
    growing: bool

    def covariance(self) -> FloatArray:
        """Of the errors of the state, for a unit measurement variance; zero where nothing was measured."""
        points = len(self.weights)
        covariance = np.zeros((len(self.state), len(self.state)))
        covariance[:points, :points] = self.weights @ self.weights.T
        return covariance


def begin_axis(
    start: str,
    z: FloatArray,
    dt: FloatArray,
    g: FloatArray,
    given: FloatArray | None,
    predicted: FloatArray,
    smoothed: FloatArray,
) -> Beginning:
    """Use the measurements without which an axis cannot begin; arguments and errors as for `start_axis`."""
    if given is not None:
        return Beginning(given.astype(np.float64), np.empty((0, 0)), 0, growing=False)
    order, points = len(g), STARTS[start].points
    seen = _first_measured(z, max(points, order if start == "expanding" else 1))
    if len(seen) < points:
        raise InputError("positions", f"must hold at least {points} measurements per axis for '{start}'", len(seen))
    # A growing memory begins with the gain 1: a filter that keeps a gain as high is started by its first measurement.
    if start == "expanding" and g[0] < 1:
        return _interpolate(z, dt, order, seen, predicted, smoothed)
    seen = seen[:points]
    begin = int(seen[-1]) + 1
    predicted[:begin] = smoothed[:begin] = np.nan
    smoothed[seen, 0] = z[seen]
    state, weights = _through(z, dt, seen, order)
    smoothed[begin - 1] = state
    return Beginning(state, weights, begin, growing=False)


def first_polynomial(z: FloatArray, dt: FloatArray, order: int) -> Beginning:
    """What the first measurements of an axis, as many as the order, say of its state, whatever it is started with.

    Args:
        z, dt: as for `start_axis`.
        order: of the filter.

    Returns:
        Where least squares can go on from; it begins after the last sample, and knows nothing, where there are fewer
        measurements.
    """
    seen = _first_measured(z, order)
    if len(seen) < order:
        return Beginning(np.zeros(order), np.empty((0, 0)), len(z), growing=False)
    return Beginning(*_through(z, dt, seen, order), int(seen[-1]) + 1, growing=True)


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
    first = begin_axis(start, z, dt, g, given, predicted, smoothed)
    if not first.growing:
        return first.state, first.begin
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    state = first.state
    begin = kernels.least_squares_start(z, dt, float(g[0]), state, first.covariance(), first.begin, predicted, smoothed)
    return state, int(begin)


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


def _interpolate(
    z: FloatArray, dt: FloatArray, order: int, seen: IntArray, predicted: FloatArray, smoothed: FloatArray
) -> Beginning:
    """A growing memory while it is the polynomial through all measurements, which are too few for least squares."""
    n = len(z)
    predicted[: seen[0] + 1] = smoothed[: seen[0]] = np.nan
    for count in range(1, len(seen) + 1):
        here = int(seen[count - 1])
        state, weights = _through(z, dt, seen[:count], order)
        smoothed[here] = state
        if count < order:
            following = int(seen[count]) if count < len(seen) else n
            for i in range(here + 1, min(following + 1, n)):
                predicted[i] = transition(order, _elapsed(dt, here, i)) @ state
                if i < following:
                    smoothed[i] = predicted[i]
    if len(seen) < order:
        return Beginning(state, weights, n, growing=False)
    return Beginning(state, weights, here + 1, growing=True)


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
