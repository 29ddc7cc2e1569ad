"""The filters of every order with constant gains, their least squares start, and the response to a step.

A filter returns the index at which it stopped, the number of samples if it ran to the end.
"""

from __future__ import annotations

import numpy as np

from tracker_core.kernels.compiled import compiled
from tracker_core.types import HANDOVER, FloatArray, IntArray


@compiled
def track2(
    z: FloatArray, dt: FloatArray, g: FloatArray, state: FloatArray, begin: int, limit: float,
    predicted: FloatArray, smoothed: FloatArray,
) -> int:  # fmt: skip
    """Alpha-beta filter over one axis: z (n,), state (2,), outputs (n, 2)."""
    n = z.shape[0]
    varying = dt.shape[0] > 1
    t = dt[0]
    k0, k1 = g[0], g[1] / t
    x, v = state[0], state[1]
    for i in range(begin, n):
        if varying:
            t = dt[i]
            k1 = g[1] / t
        x = x + t * v
        predicted[i, 0] = x
        predicted[i, 1] = v
        e = z[i] - x
        if not np.isnan(e):
            x = x + k0 * e
            v = v + k1 * e
        smoothed[i, 0] = x
        smoothed[i, 1] = v
        if not abs(x) <= limit:
            return i
    return n


@compiled
def track3(
    z: FloatArray, dt: FloatArray, g: FloatArray, state: FloatArray, begin: int, limit: float,
    predicted: FloatArray, smoothed: FloatArray,
) -> int:  # fmt: skip
    """Alpha-beta-gamma filter over one axis: z (n,), state (3,), outputs (n, 3)."""
    n = z.shape[0]
    varying = dt.shape[0] > 1
    t = dt[0]
    half = t * t / 2
    k0, k1, k2 = g[0], g[1] / t, g[2] / (t * t)
    x, v, a = state[0], state[1], state[2]
    for i in range(begin, n):
        if varying:
            t = dt[i]
            half = t * t / 2
            k1, k2 = g[1] / t, g[2] / (t * t)
        x = x + t * v + half * a
        v = v + t * a
        predicted[i, 0] = x
        predicted[i, 1] = v
        predicted[i, 2] = a
        e = z[i] - x
        if not np.isnan(e):
            x = x + k0 * e
            v = v + k1 * e
            a = a + k2 * e
        smoothed[i, 0] = x
        smoothed[i, 1] = v
        smoothed[i, 2] = a
        if not abs(x) <= limit:
            return i
    return n


@compiled
def track4(
    z: FloatArray, dt: FloatArray, g: FloatArray, state: FloatArray, begin: int, limit: float,
    predicted: FloatArray, smoothed: FloatArray,
) -> int:  # fmt: skip
    """Alpha-beta-gamma-eta filter over one axis: z (n,), state (4,), outputs (n, 4)."""
    n = z.shape[0]
    varying = dt.shape[0] > 1
    t = dt[0]
    half, sixth = t * t / 2, t * t * t / 6
    k0, k1, k2, k3 = g[0], g[1] / t, g[2] / (t * t), g[3] / (t * t * t)
    x, v, a, j = state[0], state[1], state[2], state[3]
    for i in range(begin, n):
        if varying:
            t = dt[i]
            half, sixth = t * t / 2, t * t * t / 6
            k1, k2, k3 = g[1] / t, g[2] / (t * t), g[3] / (t * t * t)
        x = x + t * v + half * a + sixth * j
        v = v + t * a + half * j
        a = a + t * j
        predicted[i, 0] = x
        predicted[i, 1] = v
        predicted[i, 2] = a
        predicted[i, 3] = j
        e = z[i] - x
        if not np.isnan(e):
            x = x + k0 * e
            v = v + k1 * e
            a = a + k2 * e
            j = j + k3 * e
        smoothed[i, 0] = x
        smoothed[i, 1] = v
        smoothed[i, 2] = a
        smoothed[i, 3] = j
        if not abs(x) <= limit:
            return i
    return n


@compiled
def finish(z: FloatArray, stop: int, predicted: FloatArray, smoothed: FloatArray, innovation: FloatArray) -> int:
    """Make a track of what was filtered up to sample `stop`: what comes after becomes NaN, innovations are taken.

    z and innovation (axes, n), states (axes, n, order). Returns how many missing measurements were bridged.
    """
    bridged = 0
    for axis in range(z.shape[0]):
        for i in range(stop + 1, z.shape[1]):
            for r in range(predicted.shape[2]):
                predicted[axis, i, r] = smoothed[axis, i, r] = np.nan
        for i in range(z.shape[1]):
            innovation[axis, i] = z[axis, i] - predicted[axis, i, 0]
        for i in range(z.shape[1]):
            bridged += np.isnan(z[axis, i]) and not np.isnan(smoothed[axis, i, 0])
    return bridged


@compiled
def track(
    z: FloatArray, dt: FloatArray, g: FloatArray, states: FloatArray, begins: IntArray, limit: float,
    predicted: FloatArray, smoothed: FloatArray, innovation: FloatArray,
) -> tuple[int, int]:  # fmt: skip
    """Every axis, with the filter whose order the gains have, from its state and sample on; then see `finish`.

    z (axes, n), states (axes, order), begins (axes,). Returns the index at which the run stopped, and how many missing
    measurements were bridged.
    """
    stop = z.shape[1]
    for axis in range(z.shape[0]):
        begin, end = begins[axis], z.shape[1]
        for i in range(begin):
            if abs(smoothed[axis, i, 0]) > limit:
                end = min(end, i)
        if end == z.shape[1]:
            column, state, x, s = z[axis], states[axis], predicted[axis], smoothed[axis]
            if g.shape[0] == 2:
                end = track2(column, dt, g, state, begin, limit, x, s)
            elif g.shape[0] == 3:
                end = track3(column, dt, g, state, begin, limit, x, s)
            else:
                end = track4(column, dt, g, state, begin, limit, x, s)
        stop = min(stop, end)
    return stop, finish(z, stop, predicted, smoothed, innovation)


@compiled
def least_squares_start(
    z: FloatArray, dt: FloatArray, alpha: float, state: FloatArray, covariance: FloatArray, begin: int,
    predicted: FloatArray, smoothed: FloatArray,
) -> int:  # fmt: skip
    """Growing-memory least squares over one axis until its position gain has fallen to `alpha`.

    The covariance form of recursive least squares for a polynomial of degree order - 1 and unit measurement
    variance: exact for gaps and irregular intervals. `state` (order,) and `covariance` (order, order) belong to
    sample begin - 1 and are updated in place. Returns the index of the first sample that was not processed.
    """
    n, order = z.shape[0], state.shape[0]
    varying = dt.shape[0] > 1
    t = dt[0]
    f = np.zeros((order, order))
    work = np.zeros((order, order))
    gain = np.zeros(order)
    for i in range(begin, n):
        if varying:
            t = dt[i]
        for r in range(order):
            term = 1.0
            for c in range(r, order):
                if c > r:
                    term = term * t / (c - r)
                f[r, c] = term
        for r in range(order):
            total = 0.0
            for c in range(r, order):
                total += f[r, c] * state[c]
            state[r] = total
        for r in range(order):
            for c in range(order):
                total = 0.0
                for k in range(r, order):
                    total += f[r, k] * covariance[k, c]
                work[r, c] = total
        for r in range(order):
            for c in range(order):
                total = 0.0
                for k in range(c, order):
                    total += work[r, k] * f[c, k]
                covariance[r, c] = total
        observed = not np.isnan(z[i])
        for r in range(order):
            gain[r] = covariance[r, 0] / (covariance[0, 0] + 1.0)
        if observed and gain[0] <= alpha * HANDOVER:
            # The steady filter takes this sample over, and predicts it itself.
            for r in range(order):
                state[r] = smoothed[i - 1, r]
            return i
        for r in range(order):
            predicted[i, r] = state[r]
        if observed:
            e = z[i] - state[0]
            for r in range(order):
                state[r] += gain[r] * e
            for r in range(order):
                work[0, r] = covariance[0, r]
            for r in range(order):
                for c in range(order):
                    covariance[r, c] -= gain[r] * work[0, c]
        for r in range(order):
            smoothed[i, r] = state[r]
    return n


@compiled
def autoregress(decay: FloatArray, series: FloatArray) -> None:
    """Turn what is new at every sample, shape (n,), into a first-order autoregressive series, in place.

    series[i] += decay[i] * series[i - 1]; `decay` holds that factor for each sample (the first one's is not used), or
    one number if it is constant.
    """
    varying = decay.shape[0] > 1
    rho = decay[0]
    for i in range(1, series.shape[0]):
        if varying:
            rho = decay[i]
        series[i] += rho * series[i - 1]


@compiled
def energy(g: FloatArray, order: int, power: FloatArray, work: FloatArray, total: FloatArray) -> None:
    """total = sum over k of (A^k)' h h' A^k, A = (I - K H) F, h h' picking the position; zero beyond the order.

    With an error s of the smoothed state, s' total s is the sum of the squares of all position errors from that one on.
    Each round doubles the number of terms. All are (4, 4); power and work are room.
    """
    for r in range(order):
        first, entry = 1.0, 1.0
        for c in range(order):
            first = first / c if c > 0 else first
            if c > r:
                entry = entry / (c - r)
            power[r, c] = (entry if c >= r else 0.0) - g[r] * first
    for r in range(4):
        for c in range(4):
            total[r, c] = 1.0 if r == c == 0 else 0.0
    for _ in range(60):
        for r in range(order):
            for c in range(order):
                work[r, c] = 0.0
                for k in range(order):
                    work[r, c] += total[r, k] * power[k, c]
        before, added = 0.0, 0.0
        for r in range(order):
            before += total[r, r]
        for r in range(order):
            for c in range(order):
                term = 0.0
                for k in range(order):
                    term += power[k, r] * work[k, c]
                total[r, c] += term
                if r == c:
                    added += term
        if not added > 1e-16 * before:
            break
        for r in range(order):
            for c in range(order):
                work[r, c] = 0.0
                for k in range(order):
                    work[r, c] += power[r, k] * power[k, c]
        power, work = work, power


@compiled
def step_response(gains: FloatArray, band: float, horizon: int, overshoot: FloatArray, settling: FloatArray) -> None:
    """Overshoot and settling time of the smoothed step response for every row of gains (n, 4), zero where unused.

    Follows the error of the state, which starts at -1 in the position, until what is left of it can neither leave the
    band nor shoot higher: no position error is greater than the root of the sum of its own square and of all later
    ones. NaN and infinity where the response is outside the band after `horizon` samples, or may be after four times as
    many, and for NaN among the gains.
    """
    power, work, total = np.zeros((4, 4)), np.zeros((4, 4)), np.zeros((4, 4))
    for point in range(gains.shape[0]):
        g = gains[point]
        order = 4
        while order > 2 and g[order - 1] == 0:
            order -= 1
        overshoot[point], settling[point] = np.nan, np.inf
        if np.isnan(g[0]):
            continue
        energy(g, order, power, work, total)
        x, v, a, j = -1.0, 0.0, 0.0, 0.0
        highest = 0.0
        last = 0
        for k in range(1, 4 * horizon + 1):
            x += v + a / 2 + j / 6
            v += a + j / 2
            a += j
            e = -x
            x += g[0] * e
            v += g[1] * e
            a += g[2] * e
            j += g[3] * e
            highest = max(highest, x)
            if not abs(x) <= band:
                last = k
                if k > horizon:
                    break
            elif k % 8 == 0 or k == 4 * horizon:
                left = total[0, 0] * x * x + 2 * x * (total[0, 1] * v + total[0, 2] * a + total[0, 3] * j)
                left += total[1, 1] * v * v + 2 * v * (total[1, 2] * a + total[1, 3] * j)
                left += total[2, 2] * a * a + 2 * a * total[2, 3] * j + total[3, 3] * j * j
                if left <= band * band:
                    overshoot[point], settling[point] = highest, last
                    if left <= max(highest, 1e-7) ** 2:
                        break
