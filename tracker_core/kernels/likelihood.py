"""The Kalman filter that gives the likelihood of a model, and what all other samples say of each.

Time is counted in nominal intervals and the measurement noise has unit variance, so that a model is one number, its
tracking index. The state is unknown at the beginning and after a long silence: its covariance is P + k P_inf with k
beyond all bounds, and P_inf is gone after as many measurements as there are states (Koopman 1997, J. American
Statistical Association 92, 1630-1638; Durbin & Koopman 2012, sections 5.2 and 5.3).
"""

from __future__ import annotations

import numpy as np

from tracker_core.kernels.compiled import compiled
from tracker_core.types import BoolArray, FloatArray

SQUARES, LOGS, PLAIN, COUNT, SUMS = 0, 1, 2, 3, 4
"""Columns of the sums: of e^2/s, log s and e^2 over the innovations e with variance s, and their number."""

STATES = 4
"""Of every order: those that one does not have stay zero. Loops of known length become straight code."""

_SETTLED = 1e-15

_TELLS = 1e-8
"""Of a measurement that the others know to 10,000 sigma only, they say nothing."""


@compiled
def step_matrices(order: int, t: float, push: float, f: FloatArray, q: FloatArray) -> None:
    """F over a time t, and the covariance Q that pushes of variance `push` per interval add over it; (4, 4) each.

    Order 2: an acceleration held over the time, its variance push/t; 3 and 4: an increment of the last state, of
    variance push t. The power of the pushes thus does not depend on how often the target is seen.
    """
    half, sixth = t * t / 2, t * t * t / 6
    for r in range(STATES):
        for c in range(STATES):
            f[r, c] = 0.0
    for r in range(order):
        f[r, r] = 1.0
    for r in range(order - 1):
        f[r, r + 1] = t
    for r in range(order - 2):
        f[r, r + 2] = half
    if order == 4:
        f[0, 3] = sixth
    power = push / t if order == 2 else push * t
    for r in range(STATES):
        for c in range(STATES):
            if order == 2:
                a = half if r == 0 else t if r == 1 else 0.0
                b = half if c == 0 else t if c == 1 else 0.0
                q[r, c] = power * a * b
            else:
                q[r, c] = power * f[r, order - 1] * f[c, order - 1]


@compiled
def spread(f: FloatArray, p: FloatArray, work: FloatArray) -> None:
    """P becomes F P F'; all (4, 4)."""
    for r in range(STATES):
        for c in range(STATES):
            total = 0.0
            for k in range(STATES):
                total += f[r, k] * p[k, c]
            work[r, c] = total
    for r in range(STATES):
        for c in range(STATES):
            total = 0.0
            for k in range(STATES):
                total += work[r, k] * f[c, k]
            p[r, c] = total


@compiled
def correct(p: FloatArray, gain: FloatArray, left: float, noise: float, work: FloatArray) -> None:
    """P becomes (I - K H) P (I - K H)' + noise K K', the Joseph form; `left` is 1 - K[0] with all its digits."""
    for c in range(STATES):
        work[0, c] = left * p[0, c]
        for r in range(1, STATES):
            work[r, c] = p[r, c] - gain[r] * p[0, c]
    for r in range(STATES):
        over = work[r, 0] - noise * gain[r]
        for c in range(r, STATES):
            p[r, c] = p[c, r] = work[r, c] - over * gain[c]


@compiled
def gather(f: FloatArray, r: FloatArray, m: FloatArray, work: FloatArray) -> None:
    """What is said of the state after F, of the state before it: every row r (axes, 4) becomes F' r, N F' N F."""
    for axis in range(r.shape[0]):
        for a in range(STATES - 1, -1, -1):
            total = 0.0
            for b in range(a + 1):
                total += f[b, a] * r[axis, b]
            r[axis, a] = total
    for a in range(STATES):
        for b in range(STATES):
            total = 0.0
            for k in range(STATES):
                total += m[a, k] * f[k, b]
            work[a, b] = total
    for a in range(STATES):
        for b in range(STATES):
            total = 0.0
            for k in range(STATES):
                total += f[k, a] * work[k, b]
            m[a, b] = total


@compiled
def forget(order: int, x: FloatArray, p: FloatArray, unknown: FloatArray) -> None:
    """Nothing is known of the states x (axes, 4)."""
    for r in range(STATES):
        for axis in range(x.shape[0]):
            x[axis, r] = 0.0
        for c in range(STATES):
            p[r, c] = 0.0
            unknown[r, c] = 1.0 if r == c and r < order else 0.0


@compiled
def move(f: FloatArray, x: FloatArray) -> None:
    """The states x (axes, 4) become F x."""
    for axis in range(x.shape[0]):
        for r in range(STATES):
            total = 0.0
            for c in range(r, STATES):
                total += f[r, c] * x[axis, c]
            x[axis, r] = total


@compiled
def kalman(
    z: FloatArray, used: BoolArray, dt: FloatArray, order: int, index: float, silence: float, warm: int,
    e: FloatArray, precision: FloatArray, gain: FloatArray, begins: BoolArray, sums: FloatArray,
) -> None:  # fmt: skip
    """The filter of tracking index `index` over axes that are measured at the same times, nothing known before.

    z (axes, n) with NaN where there is none; dt (n,), in nominal intervals. A measurement that is not `used` (n,) is
    predicted, no more. After more than `silence` intervals without a used one the state is forgotten.

    Filled: innovations e (axes, n), NaN where there is none; `precision` (n,), one over their variance, 0 where that is
    without bound or the measurement is not used; `gain` (n, 4), for a measurement that is not used the covariance
    of the position with the state in its place; `begins` (n,), whether nothing was known. `sums` (axes, SUMS) are added
    to from the measurement on that has `warm` used ones before it, `warm` being the order or more.
    """
    axes, n = z.shape
    f, q, work = np.zeros((STATES, STATES)), np.zeros((STATES, STATES)), np.zeros((STATES, STATES))
    p, unknown, x = np.zeros((STATES, STATES)), np.zeros((STATES, STATES)), np.zeros((axes, STATES))
    t, seen, silent, settled = 1.0, 0, 0.0, False
    step_matrices(order, t, index * index, f, q)
    for i in range(n):
        begins[i] = False
        precision[i] = 0.0
        if dt[i] != t:
            t = dt[i]
            settled = False
            step_matrices(order, t, index * index, f, q)
        silent += t
        if not silent <= silence:
            seen = 0
        measured = not np.isnan(z[0, i])
        here = measured and used[i]
        if seen == 0:
            if here:
                begins[i] = True
                forget(order, x, p, unknown)
        else:
            move(f, x)
            if not (settled and here):
                spread(f, p, work)
                for r in range(STATES):
                    for c in range(STATES):
                        p[r, c] += q[r, c]
                if seen < order:
                    spread(f, unknown, work)
        known = here or (measured and seen >= order)
        for axis in range(axes):
            e[axis, i] = z[axis, i] - x[axis, 0] if known else np.nan
        if not here:
            settled = False
            for r in range(STATES):
                gain[i, r] = p[r, 0]
            continue
        silent = 0.0
        if seen < order:
            for r in range(STATES):
                gain[i, r] = unknown[r, 0] / unknown[0, 0]
            correct(p, gain[i], 0.0, 1.0, work)
            correct(unknown, gain[i], 0.0, 0.0, work)
        elif settled:
            precision[i] = precision[i - 1]
            for r in range(STATES):
                gain[i, r] = gain[i - 1, r]
        else:
            # Rounding makes a variance negative where intervals differ by many powers of ten.
            p[0, 0] = max(p[0, 0], 0.0)
            precision[i] = 1.0 / (p[0, 0] + 1.0)
            settled = seen > order and dt[i] == dt[i - 1]
            for r in range(STATES):
                gain[i, r] = p[r, 0] * precision[i]
                settled = settled and abs(gain[i, r] - gain[i - 1, r]) <= _SETTLED * gain[i, r]
            correct(p, gain[i], precision[i], 1.0, work)
        for axis in range(axes):
            for r in range(STATES):
                x[axis, r] += gain[i, r] * e[axis, i]
            if seen >= warm:
                sums[axis, SQUARES] += e[axis, i] * e[axis, i] * precision[i]
                sums[axis, LOGS] -= np.log(precision[i])
                sums[axis, PLAIN] += e[axis, i] * e[axis, i]
                sums[axis, COUNT] += 1.0
        seen += 1


@compiled
def profile(
    z: FloatArray, used: BoolArray, dt: FloatArray, order: int, indices: FloatArray, silence: float, warm: int,
    sums: FloatArray,
) -> None:  # fmt: skip
    """The sums of `kalman` for many tracking indices (m,): `sums` (m, axes, SUMS), zero before."""
    axes, n = z.shape
    e, precision, gain, begins = np.empty((axes, n)), np.empty(n), np.empty((n, STATES)), np.empty(n, np.bool_)
    for k in range(indices.shape[0]):
        kalman(z, used, dt, order, indices[k], silence, warm, e, precision, gain, begins, sums[k])


@compiled
def deletions(
    z: FloatArray, used: BoolArray, dt: FloatArray, order: int, index: float, silence: float, found: FloatArray
) -> None:
    """How far every measurement lies from what all other used ones say, over the standard deviation of that.

    Axes that are measured at the same times, z and `found` (axes, n); unit measurement variance; NaN where the others
    do not say. The disturbance smoother (de Jong 1989, J. American Statistical Association 84, 1085-1088; Durbin &
    Koopman 2012, sections 4.5, 5.3 and 7.5): going back, r and N hold what later innovations say of the state, and
    the covariance of that.
    """
    axes, n = z.shape
    e, precision, gain, begins = np.empty((axes, n)), np.empty(n), np.empty((n, STATES)), np.empty(n, np.bool_)
    f, q, work = np.zeros((STATES, STATES)), np.zeros((STATES, STATES)), np.zeros((STATES, STATES))
    m, r, share = np.zeros((STATES, STATES)), np.zeros((axes, STATES)), np.zeros(STATES)
    t = 1.0
    step_matrices(order, t, 1.0, f, q)
    kalman(z, used, dt, order, index, silence, n, e, precision, gain, begins, np.zeros((axes, SUMS)))
    for i in range(n - 1, -1, -1):
        whole = 0.0
        for a in range(STATES):
            share[a] = 0.0
            for b in range(STATES):
                share[a] += m[a, b] * gain[i, b]
            whole += share[a] * gain[i, a]
        here = used[i] and not np.isnan(e[0, i])
        d = precision[i] + whole
        left = max(1.0, 1.0 + gain[i, 0] - whole)
        for axis in range(axes):
            told = 0.0
            for a in range(STATES):
                told += gain[i, a] * r[axis, a]
            if here:
                u = e[axis, i] * precision[i] - told
                r[axis, 0] += u
                found[axis, i] = u / np.sqrt(d) if d > _TELLS else np.nan
            else:
                found[axis, i] = (e[axis, i] - told) / np.sqrt(left)
        if here:
            m[0, 0] += d - 2 * share[0]
            for a in range(1, STATES):
                m[0, a] -= share[a]
                m[a, 0] = m[0, a]
        if dt[i] != t:
            t = dt[i]
            step_matrices(order, t, 1.0, f, q)
        gather(f, r, m, work)
        if begins[i]:
            for a in range(STATES):
                for axis in range(axes):
                    r[axis, a] = 0.0
                for b in range(STATES):
                    m[a, b] = 0.0
