"""The workloads of benchmarks/speed.py with FilterPy and simdkalman, as their users would write them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tracker_core.motion import transition
from tracker_core.types import FloatArray


def ghk_track(z: FloatArray, t: float, g: FloatArray) -> FloatArray:
    """FilterPy's GHKFilter over every axis of z (n, axes), start by two points: smoothed positions (n, axes).

    Its third gain is half of the normalised one.
    """
    from filterpy.gh import GHKFilter

    smoothed = np.array(z)
    for axis in range(z.shape[1]):
        one = GHKFilter(x=z[1, axis], dx=(z[1, axis] - z[0, axis]) / t, ddx=0.0, dt=t, g=g[0], h=g[1], k=g[2] / 2)
        for i in range(2, len(z)):
            smoothed[i, axis] = one.update(z[i, axis])[0]
    return smoothed


def gh_rmse(z: FloatArray, truth: FloatArray, t: float, gains: FloatArray) -> FloatArray:
    """FilterPy's GHFilter, one gain set after the other: estimation RMSE, shape (m,)."""
    from filterpy.gh import GHFilter

    found = []
    for g, h in gains:
        smoothed = np.array(z)
        for axis in range(z.shape[1]):
            one = GHFilter(x=z[1, axis], dx=(z[1, axis] - z[0, axis]) / t, dt=t, g=g, h=h)
            for i in range(2, len(z)):
                smoothed[i, axis] = one.update(z[i, axis])[0]
        found.append(np.sqrt(np.mean(np.sum((smoothed - truth) ** 2, axis=1))))
    return np.array(found)


def gh_arrays_rmse(z: FloatArray, truth: FloatArray, t: float, gains: FloatArray) -> FloatArray:
    """FilterPy's GHFilter whose state and gains are arrays over the gain sets: estimation RMSE, shape (m,)."""
    from filterpy.gh import GHFilter

    g, h = gains.T
    squares = np.full(len(gains), np.sum((z[:2] - truth[:2]) ** 2))
    for axis in range(z.shape[1]):
        speed = (z[1, axis] - z[0, axis]) / t
        one = GHFilter(x=np.full(len(g), z[1, axis]), dx=np.full(len(g), speed), dt=t, g=g, h=h)
        for i in range(2, len(z)):
            squares += (one.update(z[i, axis])[0] - truth[i, axis]) ** 2
    return np.sqrt(squares / len(z))


def kalman_rmse(
    z: FloatArray, truth: FloatArray, t: float, models: Sequence[tuple[FloatArray, FloatArray]], state: FloatArray
) -> FloatArray:
    """simdkalman over all runs z (r, n, axes) at once: estimation RMSE of every filter, shape (filters, r).

    Every filter begins in the steady state of its model, so that its gains are constant.

    Args:
        z, truth: measurements, and the truth (n, axes).
        t: the interval.
        models: per filter the covariances of the process noise and of the steady prediction, for a unit of
            measurement noise.
        state: shape (axes, 4), one interval before the first sample.
    """
    import simdkalman

    found = []
    for process, prediction in models:
        order = len(process)
        f = transition(order, t)
        one = simdkalman.KalmanFilter(
            state_transition=f, process_noise=process, observation_model=np.eye(1, order), observation_noise=1.0
        )
        squares = np.zeros(z.shape[:2])
        for axis in range(z.shape[2]):
            filtered = one.compute(
                z[:, :, axis], 0, initial_value=f @ state[axis, :order], initial_covariance=prediction,
                smoothed=False, filtered=True,
            ).filtered  # fmt: skip
            squares += (filtered.states.mean[:, :, 0] - truth[:, axis]) ** 2
        found.append(np.sqrt(squares.mean(axis=1)))
    return np.array(found)
