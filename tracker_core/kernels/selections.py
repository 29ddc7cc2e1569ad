"""Filters whose gains change from sample to sample, and the searches that choose them.

`truth` is one true state at every sample: what only a search in hindsight has. Where a kernel returns a number it is
the index at which it stopped, the number of samples if it ran to the end.
"""

from __future__ import annotations

import numpy as np

from tracker_core.kernels.compiled import compiled
from tracker_core.kernels.motion import powers_of
from tracker_core.types import FloatArray, IntArray


@compiled
def _predict(state: FloatArray, forward: FloatArray, out: FloatArray) -> None:
    """out = F(t) state, forward[d] = t^d/d!."""
    for r in range(state.shape[0]):
        total = state[r]
        for c in range(r + 1, state.shape[0]):
            total += forward[c - r] * state[c]
        out[r] = total


@compiled
def _correct(state: FloatArray, gains: FloatArray, e: float, t: float) -> None:
    """state += K e, K[i] = g[i] / t^i."""
    step = e
    for r in range(state.shape[0]):
        state[r] += gains[r] * step
        step = step / t


@compiled
def scheduled(
    z: FloatArray, dt: FloatArray, gains: FloatArray, state: FloatArray, begin: int, limit: float,
    predicted: FloatArray, smoothed: FloatArray, used: FloatArray,
) -> int:  # fmt: skip
    """One axis with the gains of every sample given: gains (n, m), outputs (n, m)."""
    n = z.shape[0]
    x, forward, back = np.zeros_like(state), np.zeros_like(state), np.zeros_like(state)
    for i in range(begin, n):
        t = dt[i] if dt.shape[0] > 1 else dt[0]
        if i == begin or dt.shape[0] > 1:
            powers_of(t, forward, back)
        _predict(state, forward, x)
        predicted[i] = x
        e = z[i] - x[0]
        if not np.isnan(e):
            _correct(x, gains[i], e, t)
            used[i] = gains[i]
        smoothed[i] = x
        state[:] = x
        if not abs(x[0]) <= limit:
            return i
    return n


@compiled
def weight_costs(
    z: FloatArray, dt: FloatArray, gains: FloatArray, fixed_beta: float, weights: FloatArray, state: FloatArray,
    begin: int, limit: float, absolute: bool, costs: FloatArray,
) -> None:  # fmt: skip
    """Sum of squared (or absolute) innovations over one axis for every share of a fixed beta in that of gains (n, 2).

    Infinite where the filter leaves the limit.
    """
    n = z.shape[0]
    for k in range(weights.shape[0]):
        x, v = state[0], state[1]
        cost = 0.0
        for i in range(begin, n):
            t = dt[i] if dt.shape[0] > 1 else dt[0]
            x = x + t * v
            e = z[i] - x
            if not np.isnan(e):
                cost += abs(e) if absolute else e * e
                x = x + gains[i, 0] * e
                v = v + (weights[k] * fixed_beta + (1 - weights[k]) * gains[i, 1]) / t * e
            if not abs(x) <= limit:
                cost = np.inf
                break
        costs[k] = cost


@compiled
def _window_cost(
    z: FloatArray, dt: FloatArray, alpha: float, x: float, v: float, first: int, last: int, absolute: bool
) -> float:
    """Sum of the squared (or absolute) innovations of samples first to last, from the state before them."""
    beta = alpha * alpha / (2 - alpha)
    cost = 0.0
    for i in range(first, last + 1):
        t = dt[i] if dt.shape[0] > 1 else dt[0]
        x = x + t * v
        e = z[i] - x
        if not np.isnan(e):
            cost += abs(e) if absolute else e * e
            x = x + alpha * e
            v = v + beta / t * e
    return cost


@compiled
def window_search(
    z: FloatArray, dt: FloatArray, alpha: float, window: int, step: int, grid: int, refinements: int, absolute: bool,
    state: FloatArray, begin: int, limit: float, predicted: FloatArray, smoothed: FloatArray, used: FloatArray,
) -> int:  # fmt: skip
    """Alpha-beta filter over one axis whose alpha is chosen anew every `step` samples, for the samples to come.

    The last `window` samples are filtered again, from the state that the filter had before them, with every alpha of
    a grid over (0, 1]; around the best one the grid is refined. Of equally good ones of a grid the smallest is
    taken. The first window is that after the first predicted sample. A window of fewer than two measurements chooses
    nothing: its innovations do not depend on alpha.
    """
    n = z.shape[0]
    seen = one_before = -1
    x, v = state[0], state[1]
    beta = alpha * alpha / (2 - alpha)
    for i in range(begin, n):
        t = dt[i] if dt.shape[0] > 1 else dt[0]
        x = x + t * v
        predicted[i, 0] = x
        predicted[i, 1] = v
        e = z[i] - x
        if not np.isnan(e):
            x = x + alpha * e
            v = v + beta / t * e
            used[i, 0] = alpha
            used[i, 1] = beta
            one_before, seen = seen, i
        smoothed[i, 0] = x
        smoothed[i, 1] = v
        if not abs(x) <= limit:
            return i
        first = i + 1 - window
        if first <= begin or one_before < first or (first - begin) % step != 1 % step:
            continue
        low, high = 0.0, 1.0
        best = np.inf
        chosen = alpha
        for _ in range(refinements + 1):
            width = (high - low) / grid
            for k in range(1, grid + 1):
                candidate = low + width * k
                cost = _window_cost(
                    z, dt, candidate, smoothed[first - 1, 0], smoothed[first - 1, 1], first, i, absolute
                )
                if cost < best:
                    best = cost
                    chosen = candidate
            low, high = max(0.0, chosen - width), min(1.0, chosen + width)
        alpha = chosen
        beta = alpha * alpha / (2 - alpha)
    return n


@compiled
def _vertex(x1: float, f1: float, x2: float, f2: float, x3: float, f3: float) -> float:
    """Where the parabola through three points is least; NaN where it has no least value."""
    slope1 = (f2 - f1) / (x2 - x1)
    slope2 = (f3 - f2) / (x3 - x2)
    bend = (slope2 - slope1) / (x3 - x1)
    if not bend > 0:
        return np.nan
    return 0.5 * (x1 + x2) - 0.5 * slope1 / bend


@compiled
def sample_search(
    z: FloatArray, dt: FloatArray, truth: FloatArray, which: int, candidates: FloatArray, last: bool,
    lower: IntArray, upper: IntArray, state: FloatArray, begin: int, limit: float,
    predicted: FloatArray, smoothed: FloatArray, used: FloatArray,
) -> int:  # fmt: skip
    """One axis; at every sample the candidate (C, m) whose state number `which` comes nearest to the truth is used.

    Of equally good ones the first is taken, or the last. `lower` and `upper` (C,) name the candidates beside each one
    along gain number `which`, -1 where there is none: through the three errors goes a parabola, and where both
    neighbours are no better its vertex replaces the gain. Empty: no parabola.
    """
    n, count = z.shape[0], candidates.shape[0]
    x, forward, back = np.zeros_like(state), np.zeros_like(state), np.zeros_like(state)
    gains = np.zeros_like(state)
    values = candidates[:, which].copy()
    for i in range(begin, n):
        t = dt[i] if dt.shape[0] > 1 else dt[0]
        if i == begin or dt.shape[0] > 1:
            powers_of(t, forward, back)
        _predict(state, forward, x)
        predicted[i] = x
        e = z[i] - x[0]
        if not np.isnan(e):
            step = e
            for _ in range(which):
                step = step / t
            base, target = x[which], truth[i]
            least = np.inf
            best = 0
            if last:
                for k in range(count):
                    error = abs(base + values[k] * step - target)
                    if error <= least:
                        least = error
                        best = k
            else:
                for k in range(count):
                    error = abs(base + values[k] * step - target)
                    if error < least:
                        least = error
                        best = k
            gains[:] = candidates[best]
            if lower.shape[0] and lower[best] >= 0 and upper[best] >= 0:
                g1, g2, g3 = candidates[lower[best], which], gains[which], candidates[upper[best], which]
                f1, f3 = abs(base + g1 * step - target), abs(base + g3 * step - target)
                if least <= f1 and least <= f3:
                    vertex = _vertex(g1, f1, g2, least, g3, f3)
                    if not np.isnan(vertex):
                        gains[which] = vertex
            _correct(x, gains, e, t)
            used[i] = gains
        smoothed[i] = x
        state[:] = x
        if not abs(x[0]) <= limit:
            return i
    return n


@compiled
def candidate_scores(
    z: FloatArray, dt: FloatArray, truth: FloatArray, which: int, candidates: FloatArray, state: FloatArray,
    begin: int, limit: float, scores: FloatArray,
) -> None:  # fmt: skip
    """Adds to scores (C,) the squared error of state number `which` over one axis, with each candidate held."""
    n, order = z.shape[0], state.shape[0]
    now = np.zeros_like(state)
    forward, back = np.zeros_like(state), np.zeros_like(state)
    powers_of(dt[0], forward, back)
    for k in range(candidates.shape[0]):
        now[:] = state
        total = 0.0
        for i in range(begin, n):
            if dt.shape[0] > 1:
                powers_of(dt[i], forward, back)
            for r in range(order):
                for c in range(r + 1, order):
                    now[r] += forward[c - r] * now[c]
            e = z[i] - now[0]
            if not np.isnan(e):
                for r in range(order):
                    now[r] += candidates[k, r] * back[r] * e
            if not abs(now[0]) <= limit:
                total = np.inf
                break
            total += (now[which] - truth[i]) ** 2
        scores[k] += total
