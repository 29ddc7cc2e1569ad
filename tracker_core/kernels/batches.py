"""Many gain sets over the same measurements: sums of errors, no tracks.

Axis by axis a filter adds the squares of its deviations, per sample, to those of the axes before; a sample that one
axis does not define is NaN in the end.
"""

from __future__ import annotations

import numpy as np

from tracker_core.kernels.compiled import compiled
from tracker_core.types import FloatArray, IntArray


@compiled
def deviations2(
    z: FloatArray, truth: FloatArray, t: float, g: FloatArray, state: FloatArray, begin: int, limit: float,
    squares: FloatArray,
) -> int:  # fmt: skip
    """Alpha-beta filter over one axis: z and truth (n,), squares (3, n) of tracking, estimation, innovation."""
    n = z.shape[0]
    k0, k1 = g[0], g[1] / t
    x, v = state[0], state[1]
    for i in range(begin, n):
        x = x + t * v
        deviation = x - truth[i]
        e = z[i] - x
        squares[0, i] += deviation * deviation
        squares[2, i] += e * e
        if not np.isnan(e):
            x = x + k0 * e
            v = v + k1 * e
        deviation = x - truth[i]
        squares[1, i] += deviation * deviation
        if not abs(x) <= limit:
            return i
    return n


@compiled
def deviations3(
    z: FloatArray, truth: FloatArray, t: float, g: FloatArray, state: FloatArray, begin: int, limit: float,
    squares: FloatArray,
) -> int:  # fmt: skip
    """Alpha-beta-gamma filter over one axis, as above."""
    n = z.shape[0]
    half = t * t / 2
    k0, k1, k2 = g[0], g[1] / t, g[2] / (t * t)
    x, v, a = state[0], state[1], state[2]
    for i in range(begin, n):
        x = x + t * v + half * a
        v = v + t * a
        deviation = x - truth[i]
        e = z[i] - x
        squares[0, i] += deviation * deviation
        squares[2, i] += e * e
        if not np.isnan(e):
            x = x + k0 * e
            v = v + k1 * e
            a = a + k2 * e
        deviation = x - truth[i]
        squares[1, i] += deviation * deviation
        if not abs(x) <= limit:
            return i
    return n


@compiled
def deviations4(
    z: FloatArray, truth: FloatArray, t: float, g: FloatArray, state: FloatArray, begin: int, limit: float,
    squares: FloatArray,
) -> int:  # fmt: skip
    """Alpha-beta-gamma-eta filter over one axis, as above."""
    n = z.shape[0]
    half, sixth = t * t / 2, t * t * t / 6
    k0, k1, k2, k3 = g[0], g[1] / t, g[2] / (t * t), g[3] / (t * t * t)
    x, v, a, j = state[0], state[1], state[2], state[3]
    for i in range(begin, n):
        x = x + t * v + half * a + sixth * j
        v = v + t * a + half * j
        a = a + t * j
        deviation = x - truth[i]
        e = z[i] - x
        squares[0, i] += deviation * deviation
        squares[2, i] += e * e
        if not np.isnan(e):
            x = x + k0 * e
            v = v + k1 * e
            a = a + k2 * e
            j = j + k3 * e
        deviation = x - truth[i]
        squares[1, i] += deviation * deviation
        if not abs(x) <= limit:
            return i
    return n


@compiled
def batch_errors(
    z: FloatArray, truth: FloatArray, t: float, gains: FloatArray, states: FloatArray, begins: IntArray,
    heads: FloatArray, limit: float, sums: FloatArray,
) -> None:  # fmt: skip
    """Errors of every gain set, all axes jointly.

    Args:
        z, truth: shape (axes, n).
        t: the interval.
        gains: shape (m, order), normalised.
        states: shape (axes, order), after the start.
        begins: shape (axes,), where the recursion begins.
        heads: shape (3, n), squares of the samples before that; 0 from then on, NaN where nothing is defined.
        limit: of the magnitude of a smoothed position.
        sums: shape (m, 3, 4), filled in: of tracking, estimation and innovation the sum, the sum of squares, the
            greatest and the number of errors; all NaN where a position passed the limit.
    """
    axes, n = z.shape
    order = gains.shape[1]
    squares = np.empty((3, n))
    for k in range(gains.shape[0]):
        squares[:] = heads
        stopped = False
        for axis in range(axes):
            if order == 2:
                end = deviations2(z[axis], truth[axis], t, gains[k], states[axis], begins[axis], limit, squares)
            elif order == 3:
                end = deviations3(z[axis], truth[axis], t, gains[k], states[axis], begins[axis], limit, squares)
            else:
                end = deviations4(z[axis], truth[axis], t, gains[k], states[axis], begins[axis], limit, squares)
            stopped = stopped or end < n
        if stopped:
            sums[k] = np.nan
            continue
        for kind in range(3):
            total, square, greatest, count = 0.0, 0.0, 0.0, 0
            for i in range(n):
                s = squares[kind, i]
                if not np.isnan(s):
                    error = np.sqrt(s)
                    total += error
                    square += s
                    greatest = max(greatest, error)
                    count += 1
            sums[k, kind, 0] = total
            sums[k, kind, 1] = square
            sums[k, kind, 2] = greatest
            sums[k, kind, 3] = count
