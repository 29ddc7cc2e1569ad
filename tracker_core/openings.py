"""The ways of starting as gains: what many filters do before their own gains take over, without a loop over them.

Every start is a filter that begins at rest in the origin and whose gains change from measurement to measurement: those
of the polynomial through the first measurements, then, for an expanding memory, those of least squares. They depend on
which samples were measured, not on what was measured. See `starts.start_axis` for one filter alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tracker_core.checks import InputError
from tracker_core.motion import transition
from tracker_core.starts import STARTS, interpolation
from tracker_core.types import HANDOVER, BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class Opening:
    """The first b samples of an axis.

    Attributes:
        gains: shape (b, order), normalised.
        until: shape (b,): a filter uses them while HANDOVER times its own position gain is less than this.
        predicted, smoothed: shape (n_samples,), where these are defined.
    """

    gains: FloatArray
    until: FloatArray
    predicted: BoolArray
    smoothed: BoolArray


def opening(start: str, order: int, measured: BoolArray, least: float) -> Opening:
    """How an axis starts.

    Args:
        start: a name in STARTS.
        order: of the filter.
        measured: shape (n_samples,), whether there is a measurement.
        least: the least position gain among the filters: an expanding memory ends when its own has fallen to it.

    Raises:
        InputError: when there are fewer measurements than the start needs.
    """
    samples, points = len(measured), STARTS[start].points
    seen = np.flatnonzero(measured)
    if len(seen) < points:
        raise InputError("positions", f"must hold at least {points} measurements per axis for '{start}'", len(seen))
    predicted, smoothed = np.ones(samples, dtype=bool), np.ones(samples, dtype=bool)
    if start == "known":
        return Opening(np.empty((0, order)), np.empty(0), predicted, smoothed)
    if start == "expanding":
        predicted[: seen[0] + 1] = False
        smoothed[: seen[0]] = False
        gains, until = _growing_memory(order, measured.tobytes(), least)
        return Opening(gains, until, predicted, smoothed)
    begin = int(seen[points - 1]) + 1
    predicted[:begin] = False
    smoothed[:begin] = measured[:begin]
    gains = np.zeros((begin, order))
    for count in range(1, points + 1):
        gains[seen[count - 1], :count] = _through(tuple(seen[:count].tolist()))[:, -1]
    return Opening(gains, np.full(begin, np.inf), predicted, smoothed)


def _through(points: tuple[int, ...]) -> FloatArray:
    """The matrix from measurements at these samples to the state at the last of them, in units of the interval."""
    return interpolation(tuple(float(point - points[-1]) for point in points))


@lru_cache(maxsize=64)
def _growing_memory(order: int, measured: bytes, least: float) -> tuple[FloatArray, FloatArray]:
    """Gains and bounds of an expanding memory until its position gain has fallen to `least`.

    The covariance form of recursive least squares, for a unit measurement variance: see
    `kernels.least_squares_start`.
    """
    seen = np.frombuffer(measured, dtype=bool)
    gains, until = np.zeros((len(seen), order)), np.full(len(seen), np.inf)
    points: list[int] = []
    move, covariance = transition(order, 1.0), np.zeros((order, order))
    bound = np.inf
    for i in range(len(seen)):
        if len(points) == order:
            covariance = move @ covariance @ move.T
        if seen[i] and len(points) < order:
            points.append(i)
            inverse = _through(tuple(points))
            gains[i, : len(points)] = inverse[:, -1]
            # What is started by one measurement alone keeps a gain of 1 or more.
            bound = np.inf if len(points) == 1 else 1.0
            covariance[: len(points), : len(points)] = inverse @ inverse.T
        elif seen[i]:
            gain = covariance[:, 0] / (covariance[0, 0] + 1)
            bound = min(bound, float(gain[0]))
            if bound <= least * HANDOVER:
                return gains[:i], until[:i]
            gains[i] = gain
            covariance -= np.outer(gain, covariance[0])
        until[i] = bound
    return gains, until
