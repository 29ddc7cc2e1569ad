"""The filter with a gate: a measurement too far from its prediction is not believed, but bridged like a missing one."""

from __future__ import annotations

import numpy as np

from tracker_core.kernels.compiled import compiled
from tracker_core.kernels.motion import powers_of
from tracker_core.types import HANDOVER, BoolArray, FloatArray, IntArray

HUGE = 1e100
"""A variance that has grown to this grows no further: the gate is open, and nothing overflows."""

FAR = 1e50
"""The root of HUGE: a state counts as no more standard deviations off than this."""


@compiled
def prepare(t: float, g: FloatArray, ahead: FloatArray, gain: FloatArray) -> None:
    """ahead[d] = t^d/d! and gain[i] = g[i]/t^i, with the rounding of `track`."""
    ahead[1], ahead[2], ahead[3] = t, t * t / 2, t * t * t / 6
    divisor = 1.0
    for r in range(g.shape[0]):
        gain[r] = g[r] / divisor
        divisor = divisor * t


@compiled
def carry(forward: FloatArray, state: FloatArray) -> None:
    """state = F(t) state in place, F[r, c] = forward[c - r]."""
    for r in range(state.shape[0]):
        total = state[r]
        for c in range(r + 1, state.shape[0]):
            total += forward[c - r] * state[c]
        state[r] = total


@compiled
def carry_covariance(forward: FloatArray, covariance: FloatArray, work: FloatArray) -> None:
    """covariance = F(t) covariance F(t)' in place; `work` is room of the same shape."""
    order = covariance.shape[0]
    for r in range(order):
        for c in range(order):
            total = 0.0
            for k in range(r, order):
                total += forward[k - r] * covariance[k, c]
            work[r, c] = total
    for r in range(order):
        for c in range(order):
            total = 0.0
            for k in range(c, order):
                total += work[r, k] * forward[k - c]
            covariance[r, c] = total


@compiled
def learn(gain: FloatArray, covariance: FloatArray, work: FloatArray) -> None:
    """What recursive least squares knows after a measurement: covariance -= gain covariance[0], in place."""
    order = covariance.shape[0]
    for r in range(order):
        work[0, r] = covariance[0, r]
    for r in range(order):
        for c in range(order):
            covariance[r, c] -= gain[r] * work[0, c]


@compiled
def disturb(forward: FloatArray, rate: float, covariance: FloatArray) -> None:
    """covariance += rate G G', G = [t^2/2, t] or [..., t, 1] as in `tracker_core.optimal`: its last is forward[0 or 1].

    forward[d] = t^d/d!, for d up to the order.
    """
    order = covariance.shape[0]
    top = max(2, order - 1)
    for r in range(order):
        for c in range(order):
            covariance[r, c] += rate * forward[top - r] * forward[top - c]


@compiled
def correct_covariance(gain: FloatArray, covariance: FloatArray, work: FloatArray) -> None:
    """The Joseph form (I - K H) covariance (I - K H)' + K K' in place: right for any gain K, shape (order,)."""
    order = covariance.shape[0]
    for r in range(order):
        for c in range(order):
            work[r, c] = covariance[r, c] - gain[r] * covariance[0, c]
    for r in range(order):
        for c in range(order):
            covariance[r, c] = work[r, c] - work[r, 0] * gain[c] + gain[r] * gain[c]


@compiled
def correct(z: float, gain: FloatArray, state: FloatArray) -> None:
    """state += gain (z - state[0]) in place."""
    e = z - state[0]
    for r in range(state.shape[0]):
        state[r] += gain[r] * e


@compiled
def scale(factor: float, covariance: FloatArray) -> None:
    """covariance *= factor."""
    for r in range(covariance.shape[0]):
        for c in range(covariance.shape[0]):
            covariance[r, c] *= factor


@compiled
def keep(state: FloatArray, out: FloatArray) -> None:
    """out = state: a loop is compiled sooner than an assignment of arrays."""
    for r in range(state.shape[0]):
        out[r] = state[r]


@compiled
def weigh(memory: FloatArray, learnt: FloatArray) -> None:
    """The gain of least squares."""
    for r in range(learnt.shape[0]):
        learnt[r] = memory[r, 0] / (memory[0, 0] + 1.0)


@compiled
def believe(
    z: float, alpha: float, gain: FloatArray, ahead: FloatArray, growing: bool, before: FloatArray, state: FloatArray,
    error: FloatArray, memory: FloatArray, learnt: FloatArray, work: FloatArray, predicted: FloatArray,
) -> bool:  # fmt: skip
    """Correct the predicted state of an axis, and its covariances; returns whether least squares goes on."""
    if growing:
        weigh(memory, learnt)
        if learnt[0] <= alpha * HANDOVER:
            # The steady filter takes this sample over, and predicts it itself.
            growing = False
            keep(before, state)
            carry(ahead, state)
            keep(state, predicted)
        else:
            learn(learnt, memory, work)
    k = learnt if growing else gain
    correct(z, k, state)
    correct_covariance(k, error, work)
    return growing


@compiled
def accompany(
    z: float, alpha: float, gain: FloatArray, std: float, guide: FloatArray, state: FloatArray, error: FloatArray,
    memory: FloatArray, learnt: FloatArray, work: FloatArray,
) -> bool:  # fmt: skip
    """Correct least squares beside an axis, before the axis itself is; returns whether it goes on.

    Once its position gain has fallen to alpha, what it says that the state is wrong by becomes a part of the state's
    covariance, which the filter's own gains rule from then on.
    """
    order = state.shape[0]
    weigh(memory, learnt)
    if learnt[0] <= alpha * HANDOVER:
        for r in range(order):
            work[0, r] = min(max((guide[r] - state[r]) / std, -FAR), FAR)
        for r in range(order):
            for c in range(order):
                error[r, c] += work[0, r] * work[0, c]
        correct_covariance(gain, error, work)
        return False
    learn(learnt, memory, work)
    correct(z, learnt, guide)
    correct_covariance(learnt, error, work)
    return True


@compiled
def start_end(smoothed: FloatArray, begins: IntArray, limit: float) -> int:
    """The first sample of a start whose position passes the limit, the number of samples if none does."""
    end = smoothed.shape[1]
    for axis in range(smoothed.shape[0]):
        for i in range(begins[axis]):
            if abs(smoothed[axis, i, 0]) > limit:
                end = min(end, i)
    return end


@compiled
def gated_track(
    z: FloatArray, dt: FloatArray, g: FloatArray, states: FloatArray, begins: IntArray, growing: BoolArray,
    guides: FloatArray, known: IntArray, beside: BoolArray, memories: FloatArray, sensor: FloatArray,
    width: float, process: float, interval: float, patience: int, doubt: float, limit: float,
    predicted: FloatArray, smoothed: FloatArray, spread: FloatArray, rejected: BoolArray,
) -> int:  # fmt: skip
    """All axes side by side, from their state and sample on; returns the index at which the run stopped.

    The arithmetic of the state is that of `track` and `least_squares_start`, to the last bit.

    z, spread (axes, n); states (axes, order), updated in place; begins (axes,); growing (axes,) marks those in which
    least squares goes on, with covariances memories (axes, order, order), until its position gain has fallen to g[0].
    beside (axes,) marks those in which it goes on so beside the filter, with states guides (axes, order), updated in
    place. memories: covariance of the states, or guides, measurement variance 1, from which that on the model begins;
    guides and memories belong to the sample before known (axes,). sensor (axes,), m. `process` is the variance of the
    model's noise at `interval`. See `tracker_core.gating` for the rest.
    """
    axes, n, order = z.shape[0], z.shape[1], g.shape[0]
    errors = memories.copy()
    begin, opened = begins[0], known[0]
    for axis in range(axes):
        begin, opened = min(begin, begins[axis]), max(opened, known[axis])
    end = start_end(smoothed, begins, limit)
    forward, back = np.zeros(order + 1), np.zeros(order + 1)
    ahead, gain, learnt = np.ones(4), np.zeros(order), np.zeros(order)
    work = np.zeros((order, order))
    refusals = 0
    for i in range(begin, min(end + 1, n)):
        if i == begin or dt.shape[0] > 1:
            t = dt[i] if dt.shape[0] > 1 else dt[0]
            powers_of(t, forward, back)
            prepare(t, g, ahead, gain)
            rate = process * (interval / t if order == 2 else t / interval)
        squared = 0.0
        measured = False
        for axis in range(axes):
            if i < begins[axis]:
                continue
            state, error = states[axis], errors[axis]
            carry(forward if growing[axis] else ahead, state)
            keep(state, predicted[axis, i])
            if i < known[axis]:
                continue
            carry_covariance(forward, error, work)
            disturb(forward, rate, error)
            if growing[axis] or beside[axis]:
                carry_covariance(forward, memories[axis], work)
            spread[axis, i] = sensor[axis] * np.sqrt(error[0, 0] + 1.0)
            if beside[axis]:
                carry(forward, guides[axis])
                spread[axis, i] = np.hypot(spread[axis, i], guides[axis, 0] - state[0])
            e = z[axis, i] - state[0]
            if not np.isnan(e):
                measured = True
                squared += (e / spread[axis, i]) ** 2
        rejected[i] = i >= opened and squared > width * width
        if rejected[i]:
            refusals += 1
        elif measured:
            refusals = 0
        for axis in range(axes):
            if i < begins[axis]:
                continue
            state, error = states[axis], errors[axis]
            if rejected[i]:
                if refusals >= patience:
                    scale(doubt, error)
            elif not np.isnan(z[axis, i]):
                if beside[axis]:
                    if i >= known[axis]:
                        beside[axis] = accompany(
                            z[axis, i], g[0], gain, sensor[axis], guides[axis], state, error, memories[axis], learnt,
                            work,
                        )  # fmt: skip
                    correct(z[axis, i], gain, state)
                else:
                    growing[axis] = believe(
                        z[axis, i], g[0], gain, ahead, growing[axis], smoothed[axis, i - 1], state, error,
                        memories[axis], learnt, work, predicted[axis, i],
                    )  # fmt: skip
            if error[0, 0] > HUGE:
                scale(HUGE / error[0, 0], error)
            keep(state, smoothed[axis, i])
            if not abs(state[0]) <= limit:
                end = i
        if end <= i:
            break
    return end
