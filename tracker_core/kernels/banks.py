"""Banks of filters side by side, of which one speaks, or whose mean does.

Every kernel returns the index at which it stopped, the number of samples if it ran to the end.
"""

from __future__ import annotations

import numpy as np

from tracker_core.kernels.compiled import compiled
from tracker_core.kernels.motion import powers_of
from tracker_core.types import FloatArray, IntArray


@compiled
def bank_choice(
    z: FloatArray, dt: FloatArray, members: FloatArray, state: FloatArray, begin: int, limit: float, decays: FloatArray,
    predicted: FloatArray, smoothed: FloatArray, used: FloatArray, chosen: IntArray,
) -> int:  # fmt: skip
    """A bank of alpha-beta filters over one axis, of which one speaks at every sample: members (K, 2), state (2,).

    `decays`, like dt, is what is left of a past innovation's weight after each interval. With decays in [0, 1) the
    prediction is that of the member with the least past innovation power, the smoothed state that of the least one
    including the present innovation. With one negative decay the member whose prediction lies nearest the measurement
    speaks: hindsight. Of equally good ones the first is taken.
    """
    n, count = z.shape[0], members.shape[0]
    hindsight = decays[0] < 0
    powers = np.zeros(count)
    x, v = np.full(count, state[0]), np.full(count, state[1])
    before = x.copy()
    speaker = 0
    for i in range(begin, n):
        t = dt[i] if dt.shape[0] > 1 else dt[0]
        decay = 0.0 if hindsight else decays[i] if decays.shape[0] > 1 else decays[0]
        observed = not np.isnan(z[i])
        nearest = 0
        least = np.inf
        slow = v[speaker]
        for k in range(count):
            x[k] = x[k] + t * v[k]
            before[k] = x[k]
            powers[k] = decay * powers[k]
            if observed:
                e = z[i] - x[k]
                powers[k] += e * e
                if powers[k] < least:
                    least = powers[k]
                    nearest = k
        if observed and hindsight:
            speaker = nearest
            slow = v[speaker]
        predicted[i, 0] = before[speaker]
        predicted[i, 1] = slow
        if observed:
            for k in range(count):
                e = z[i] - before[k]
                x[k] = x[k] + members[k, 0] * e
                v[k] = v[k] + members[k, 1] / t * e
            speaker = nearest
            used[i] = members[speaker]
            chosen[i] = speaker
        smoothed[i, 0] = x[speaker]
        smoothed[i, 1] = v[speaker]
        if not abs(x[speaker]) <= limit:
            return i
    return n


@compiled
def bank_mixture(
    z: FloatArray, dt: FloatArray, members: FloatArray, states: FloatArray, begins: IntArray, limit: float,
    decays: FloatArray, predicted: FloatArray, smoothed: FloatArray, used: FloatArray, weights: FloatArray,
) -> int:  # fmt: skip
    """A bank of filters over all axes whose mean, weighted by past innovation power, is the track.

    z (n, a), members (K, m), states (a, K, m), outputs (a, n, m), weights (n, K). The weight of a member is in
    proportion to J^(-N/2): J its innovation power over a window, all axes added, and N the sum of that window's
    weights; `decays`, like dt, is what is left of them after each interval. Predictions are weighted by what was known
    before the measurement.
    """
    n, axes = z.shape
    count, order = members.shape
    powers = np.zeros(count)
    share = np.full(count, 1.0 / count)
    forward, back = np.zeros(order), np.zeros(order)
    powers_of(dt[0], forward, back)
    effective = 0.0
    for i in range(begins.min(), n):
        if dt.shape[0] > 1:
            powers_of(dt[i], forward, back)
        measured = False
        for a in range(axes):
            measured = measured or (i >= begins[a] and not np.isnan(z[i, a]))
        decay = decays[i] if decays.shape[0] > 1 else decays[0]
        effective = decay * effective + (1.0 if measured else 0.0)
        for k in range(count):
            powers[k] = decay * powers[k]
        for a in range(axes):
            if i < begins[a]:
                continue
            for r in range(order):
                predicted[a, i, r] = 0.0
            observed = not np.isnan(z[i, a])
            for k in range(count):
                for r in range(order):
                    total = states[a, k, r]
                    for c in range(r + 1, order):
                        total += forward[c - r] * states[a, k, c]
                    # States are predicted in their order: each needs only those that come after it.
                    states[a, k, r] = total
                    predicted[a, i, r] += share[k] * total
                if observed:
                    e = z[i, a] - states[a, k, 0]
                    powers[k] += e * e
                    for r in range(order):
                        states[a, k, r] += members[k, r] * back[r] * e
        if measured:
            least = max(powers.min(), 1e-300)
            total = 0.0
            for k in range(count):
                share[k] = np.exp(-0.5 * effective * np.log(max(powers[k], 1e-300) / least))
                total += share[k]
            for k in range(count):
                share[k] = share[k] / total
        weights[i] = share
        stopped = False
        for a in range(axes):
            if i < begins[a]:
                continue
            for r in range(order):
                mean = 0.0
                gain = 0.0
                for k in range(count):
                    mean += share[k] * states[a, k, r]
                    gain += share[k] * members[k, r]
                smoothed[a, i, r] = mean
                if not np.isnan(z[i, a]):
                    used[a, i, r] = gain
            stopped = stopped or not abs(smoothed[a, i, 0]) <= limit
        if stopped:
            return i
    return n
