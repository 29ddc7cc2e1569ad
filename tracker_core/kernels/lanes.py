"""Errors of many filters in many runs, without their tracks."""

from __future__ import annotations

import numpy as np

from tracker_core.kernels.compiled import compiled
from tracker_core.kernels.steps import (
    COUNT,
    ESTIMATION,
    FARTHEST,
    GAINS,
    GREATEST,
    JOINT,
    KEPT,
    KEPT_HERE,
    LANES,
    PREDICTED,
    ROWS_OF_AXIS,
    ROWS_OF_SUMS,
    SQUARES,
    STRETCH,
    TOTAL,
    add_squares,
    at,
    fold,
    step2,
    step3,
    step4,
)
from tracker_core.types import HANDOVER, BoolArray, FloatArray, IntArray

STRIP = 32
"""Samples that are moved at a time."""


@compiled
def transposed(runs: FloatArray, numbers: IntArray, tile: FloatArray, missing: BoolArray) -> None:
    """The runs (r, n, axes) of these numbers, shape (LANES,), side by side in a tile (n or more, axes, LANES).

    missing (n,) becomes true where a value is NaN. Some samples of all runs are moved at a time: what is read and what
    is written then stay in the nearest cache.
    """
    n = runs.shape[1]
    for first in range(0, n, STRIP):
        for lane in range(LANES):
            run = numbers[lane]
            for i in range(first, min(first + STRIP, n)):
                for axis in range(runs.shape[2]):
                    value = runs[run, i, axis]
                    tile[i, axis, lane] = value
                    if np.isnan(value):
                        missing[i] = True


@compiled
def lane_errors(
    z: FloatArray, truth: FloatArray, special: BoolArray, counted: BoolArray, t: float, gains: FloatArray,
    opening: FloatArray, until: FloatArray, before: FloatArray, farthest: float, limit: float, wanted: BoolArray,
    each: bool, found: FloatArray,
) -> None:  # fmt: skip
    """Sums of the errors of c groups of lanes.

    Args:
        z: measurements, shape (n + 1, axes) where all lanes see the same, else (n + 1, axes, LANES); the last row is
            room to work.
        truth: shape (n, axes) or (n, axes, LANES).
        special: shape (n,), true for the samples of the start, those where any lane misses a measurement, and those
            where an error is not defined.
        counted: shape (3, n), where errors of each kind are defined, but for missing measurements.
        t: the interval.
        gains: shape (c, order, LANES), normalised.
        opening: shape (axes, b, order), normalised gains of the start at the first b samples.
        until: shape (axes, b): they are used by the lanes whose position gain times HANDOVER is less than this.
        before: shape (axes, order, LANES), the state one interval before the first sample.
        farthest: the greatest magnitude of a true position.
        limit: of the magnitude of a smoothed position.
        wanted: shape (3,), the kinds of errors that are asked for.
        each: whether sums and greatest errors are asked for, or sums of squares alone.
        found: shape (3, 4, c, LANES), filled in: of every kind the sum, the sum of squares, the square of the greatest
            and the number of errors; all NaN where a position passed the limit.
    """
    n, axes, order = truth.shape[0], truth.shape[1], gains.shape[1]
    states, sums = np.empty((axes, ROWS_OF_AXIS, LANES)), np.empty((ROWS_OF_SUMS, LANES))
    noted = wanted[0] or wanted[2]
    for c in range(gains.shape[0]):
        # Small errors alone show that no position went too far. Only where they do not, every position is looked at.
        for watched in range(2):
            _begin(c, gains, t, before, states, sums)
            ordinary = n
            i = 0
            while i < n:
                row = i
                if special[i]:
                    _prepare(z, i, c, gains, opening, until, t, states, sums)
                    row, ordinary = n, ordinary - 1
                elif not noted and not each and watched == 0 and _plain(special, i):
                    for axis in range(axes):
                        if order == 2:
                            step2(z, i, truth, i, STRETCH, axis, t, False, states)
                        elif order == 3:
                            step3(z, i, truth, i, STRETCH, axis, t, False, states)
                        else:
                            step4(z, i, truth, i, STRETCH, axis, t, False, states)
                    i += STRETCH
                    continue
                for axis in range(axes):
                    if order == 2:
                        step2(z, row, truth, i, 1, axis, t, noted, states)
                    elif order == 3:
                        step3(z, row, truth, i, 1, axis, t, noted, states)
                    else:
                        step4(z, row, truth, i, 1, axis, t, noted, states)
                    # The squares of estimation errors have been added on the way.
                    if wanted[0]:
                        for into in range(SQUARES, JOINT + 1 if each else JOINT, 3):
                            add_squares(truth, i, axis, PREDICTED, states, sums, into)
                    if wanted[1] and each:
                        add_squares(truth, i, axis, 0, states, sums, JOINT + 1)
                    if wanted[2]:
                        for into in range(SQUARES + 2, JOINT + 3 if each else JOINT + 2, 3):
                            add_squares(z, row, axis, PREDICTED, states, sums, into)
                    if watched > 0 and counted[1, i]:
                        _watch(states, axis, sums)
                if special[i]:
                    _settle(z, i, c, gains, counted, t, states, sums)
                if each:
                    for kind in range(3):
                        if wanted[kind]:
                            fold(sums, kind)
                i += 1
            _gather(states, sums)
            if watched == 0 and _clear(sums, farthest, n * axes, limit):
                break
        _report(c, sums, ordinary, limit, found)


@compiled
def _plain(special: BoolArray, i: int) -> bool:
    """Whether the next samples are nothing special."""
    if i + STRETCH > len(special):
        return False
    count = 0
    for k in range(i, i + STRETCH):
        count += special[k]
    return count == 0


@compiled
def _begin(c: int, gains: FloatArray, t: float, before: FloatArray, states: FloatArray, sums: FloatArray) -> None:
    """Everything before the first sample."""
    for row in range(ROWS_OF_SUMS):
        for lane in range(LANES):
            sums[row, lane] = 0.0
    for axis in range(before.shape[0]):
        for lane in range(LANES):
            states[axis, ESTIMATION, lane] = 0.0
        for r in range(before.shape[1]):
            for lane in range(LANES):
                states[axis, r, lane] = before[axis, r, lane]
    _steady(c, gains, t, states)


@compiled
def _steady(c: int, gains: FloatArray, t: float, states: FloatArray) -> None:
    """Put the gains of the lanes to use."""
    back = 1.0
    for r in range(gains.shape[1]):
        for axis in range(states.shape[0]):
            for lane in range(LANES):
                states[axis, GAINS + r, lane] = gains[c, r, lane] * back
        back = back / t


@compiled
def _prepare(
    z: FloatArray, i: int, c: int, gains: FloatArray, opening: FloatArray, until: FloatArray, t: float,
    states: FloatArray, sums: FloatArray,
) -> None:  # fmt: skip
    """Gains and measurements of a special sample; and its sums are kept, for errors that turn out not to be defined.

    The last row of z becomes this sample: where nothing was measured that is 0, and so are the gains.
    """
    for row in range(3):
        for lane in range(LANES):
            sums[KEPT + row, lane] = sums[SQUARES + row, lane]
    for axis in range(z.shape[1]):
        for lane in range(LANES):
            states[axis, KEPT_HERE, lane] = states[axis, ESTIMATION, lane]
            missing = np.isnan(at(z, i, axis, lane))
            starting = i < until.shape[1] and until[axis, i] > gains[c, 0, lane] * HANDOVER
            back = 1.0
            for r in range(gains.shape[1]):
                if missing:
                    states[axis, GAINS + r, lane] = 0.0
                elif starting:
                    states[axis, GAINS + r, lane] = opening[axis, i, r] * back
                back = back / t
    this, room = z[i].reshape(-1), z[-1].reshape(-1)
    for k in range(len(this)):
        room[k] = 0.0 if np.isnan(this[k]) else this[k]


@compiled
def _settle(
    z: FloatArray, i: int, c: int, gains: FloatArray, counted: BoolArray, t: float, states: FloatArray,
    sums: FloatArray,
) -> None:  # fmt: skip
    """Count the errors of a special sample, take back what was added where they are not defined, and go on steadily."""
    for kind in range(3):
        for lane in range(LANES):
            defined = counted[kind, i]
            if kind == 2:
                for axis in range(z.shape[1]):
                    defined = defined and not np.isnan(at(z, i, axis, lane))
            if defined:
                sums[COUNT + kind, lane] += 1
            else:
                sums[SQUARES + kind, lane] = sums[KEPT + kind, lane]
                sums[JOINT + kind, lane] = 0.0
                if kind == 1:
                    for axis in range(z.shape[1]):
                        states[axis, ESTIMATION, lane] = states[axis, KEPT_HERE, lane]
    _steady(c, gains, t, states)


@compiled
def _watch(states: FloatArray, axis: int, sums: FloatArray) -> None:
    """Keep the greatest magnitude of the position; NaN, which comes after infinity, counts as the greatest of all."""
    for lane in range(LANES):
        if not abs(states[axis, 0, lane]) <= sums[FARTHEST, lane]:
            sums[FARTHEST, lane] = abs(states[axis, 0, lane])


@compiled
def _gather(states: FloatArray, sums: FloatArray) -> None:
    """Add up over the axes what each has summed for itself."""
    for axis in range(states.shape[0]):
        for lane in range(LANES):
            sums[SQUARES + 1, lane] += states[axis, ESTIMATION, lane]


@compiled
def _clear(sums: FloatArray, farthest: float, count: int, limit: float) -> bool:
    """Whether the estimation errors say of every lane if a position passed the limit; infinity is noted where one did.

    A position is at most as far away as the farthest true one and the root of the sum of squares together; and one of
    `count` errors is at least as great as the root of their mean square.
    """
    clear = True
    for lane in range(LANES):
        norm = np.sqrt(sums[SQUARES + 1, lane])
        if not norm <= 2 * np.sqrt(count) * (limit + farthest):
            sums[FARTHEST, lane] = np.inf
        elif farthest + norm > limit:
            clear = False
    return clear


@compiled
def _report(c: int, sums: FloatArray, ordinary: int, limit: float, found: FloatArray) -> None:
    """What came out of a group of lanes."""
    for kind in range(3):
        for lane in range(LANES):
            kept = 1.0 if sums[FARTHEST, lane] <= limit else np.nan
            found[kind, 0, c, lane] = sums[TOTAL + kind, lane] * kept
            found[kind, 1, c, lane] = sums[SQUARES + kind, lane] * kept
            found[kind, 2, c, lane] = sums[GREATEST + kind, lane] * kept
            found[kind, 3, c, lane] = (ordinary + sums[COUNT + kind, lane]) * kept
