"""Errors of filters one after the other: where samples are not evenly spaced, or not all of the truth is known."""

from __future__ import annotations

import numpy as np

from tracker_core.kernels.compiled import compiled
from tracker_core.types import FloatArray, IntArray


@compiled
def track_errors(
    z: FloatArray, truth: FloatArray, dt: FloatArray, gains: FloatArray, states: FloatArray, begins: IntArray,
    predicted: FloatArray, smoothed: FloatArray, limit: float, found: FloatArray,
) -> None:  # fmt: skip
    """Sums of the errors of m filters in one run, all of which start alike.

    Args:
        z: measurements, shape (axes, n).
        truth: shape (axes, n), NaN where nobody knows it.
        dt: the interval before each sample, or the one number if it is constant.
        gains: shape (m, 4), normalised, zero above the order: states without a gain stay zero.
        states: shape (axes, 4), before the recursion.
        begins: shape (axes,), the sample that it begins at.
        predicted, smoothed: shape (axes, b), positions of the samples before it, NaN where there are none.
        limit: of the magnitude of a smoothed position.
        found: shape (3, 4, m), filled in: for tracking, estimation and innovation the sum, the sum of squares, the
            square of the greatest and the number of errors that are defined; all NaN where a position passed the limit.
    """
    axes, n = z.shape
    varying = dt.shape[0] > 1
    now = np.empty((axes, 4))
    for c in range(gains.shape[0]):
        # Loops are compiled sooner than assignments of arrays.
        for axis in range(axes):
            for r in range(4):
                now[axis, r] = states[axis, r]
        _fill(found, c, 0.0)
        stopped = False
        t = dt[0]
        half, sixth = t * t / 2, t * t * t / 6
        k0, k1, k2, k3 = gains[c, 0], gains[c, 1] / t, gains[c, 2] / (t * t), gains[c, 3] / (t * t * t)
        for i in range(n):
            if varying:
                t = dt[i]
                half, sixth = t * t / 2, t * t * t / 6
                k1, k2, k3 = gains[c, 1] / t, gains[c, 2] / (t * t), gains[c, 3] / (t * t * t)
            tracking = estimation = innovation = 0.0
            for axis in range(axes):
                if i < begins[axis]:
                    before, after = predicted[axis, i], smoothed[axis, i]
                    stopped = stopped or abs(after) > limit
                else:
                    x, v, a, j = now[axis, 0], now[axis, 1], now[axis, 2], now[axis, 3]
                    x = x + t * v + half * a + sixth * j
                    v = v + t * a + half * j
                    a = a + t * j
                    before = x
                    e = z[axis, i] - x
                    if not np.isnan(e):
                        x = x + k0 * e
                        v = v + k1 * e
                        a = a + k2 * e
                        j = j + k3 * e
                    after = x
                    now[axis, 0], now[axis, 1], now[axis, 2], now[axis, 3] = x, v, a, j
                    stopped = stopped or not abs(x) <= limit
                tracking += (before - truth[axis, i]) ** 2
                estimation += (after - truth[axis, i]) ** 2
                innovation += (z[axis, i] - before) ** 2
            if stopped:
                break
            _add(found, 0, c, tracking)
            _add(found, 1, c, estimation)
            _add(found, 2, c, innovation)
        if stopped:
            _fill(found, c, np.nan)


@compiled
def _fill(found: FloatArray, c: int, value: float) -> None:
    """Give all sums of a filter one value."""
    for kind in range(found.shape[0]):
        for row in range(found.shape[1]):
            found[kind, row, c] = value


@compiled
def _add(found: FloatArray, kind: int, c: int, square: float) -> None:
    """Add the square of an error; NaN is none: nothing measured, or not known, or not yet started."""
    if square >= 0.0:
        found[kind, 0, c] += np.sqrt(square)
        found[kind, 1, c] += square
        found[kind, 2, c] = max(found[kind, 2, c], square)
        found[kind, 3, c] += 1.0
