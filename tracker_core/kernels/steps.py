"""One step of many filters side by side: the loops are over lanes, and become vector instructions.

A lane is one filter in one run. Measurements, and the truth, are the same for all lanes, shape (n, axes), or each
lane's own, shape (n, axes, LANES); what a lane computes is the same in both, to the last bit. For speed the compiler
must see that rows do not overlap: they are rows of few arrays whose shapes it knows, and never views, whose users would
be counted.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.extending import overload

from tracker_core.kernels.compiled import fma, inlined
from tracker_core.types import FloatArray

LANES = 64
"""Filters side by side: enough to keep the processor busy, few enough for its nearest cache."""

STRETCH = 4
"""Samples that a step may take at once, while the states stay in registers."""

GAINS, PREDICTED, KEPT_HERE, ESTIMATION, ROWS_OF_AXIS = 4, 8, 9, 15, 16
"""Rows of an axis: up to four states, as many gains in use, the predicted position, and the sum of the squares of the
estimation errors.

Rows lie 512 bytes apart. What a step reads after it wrote to another row should not lie a multiple of eight rows away:
the processor tells addresses apart by their last twelve bits.
"""

SQUARES, JOINT, TOTAL, GREATEST, COUNT, KEPT, FARTHEST, ROWS_OF_SUMS = 0, 3, 6, 9, 12, 15, 18, 19
"""Rows of what the axes have in common; all but the last come in threes, one for each kind of error: tracking,
estimation, innovation."""


def at(values: FloatArray, i: int, axis: int, lane: int) -> Any:
    """What a lane sees of an axis at sample i."""
    return values[i, axis] if values.ndim == 2 else values[i, axis, lane]


@overload(at, inline="always")
def _at(values: Any, i: Any, axis: Any, lane: Any) -> Any:  # noqa: ARG001
    def shared(values: Any, i: Any, axis: Any, lane: Any) -> Any:  # noqa: ARG001
        return values[i, axis]

    def its_own(values: Any, i: Any, axis: Any, lane: Any) -> Any:
        return values[i, axis, lane]

    return shared if values.ndim == 2 else its_own


@inlined
def step2(
    z: FloatArray, row: int, truth: FloatArray, i: int, count: int, axis: int, t: float, noted: bool, states: FloatArray
) -> None:
    """Alpha-beta filters over some samples of one axis: predict, correct, add the square of the estimation error.

    The measurements stand from row `row` on in z. The gains correct the states themselves: they are divided by powers
    of t. `noted` says whether to keep the position that is predicted for the first of the samples.
    """
    if noted:
        for lane in range(LANES):
            states[axis, PREDICTED, lane] = fma(t, states[axis, 1, lane], states[axis, 0, lane])
    for lane in range(LANES):
        x, v, total = (states[axis, 0, lane], states[axis, 1, lane], states[axis, ESTIMATION, lane])
        for u in range(count):
            x = fma(t, v, x)
            e = at(z, row + u, axis, lane) - x
            x = fma(states[axis, GAINS, lane], e, x)
            v = fma(states[axis, GAINS + 1, lane], e, v)
            d = x - at(truth, i + u, axis, lane)
            total = fma(d, d, total)
        states[axis, 0, lane] = x
        states[axis, 1, lane] = v
        states[axis, ESTIMATION, lane] = total


@inlined
def step3(
    z: FloatArray, row: int, truth: FloatArray, i: int, count: int, axis: int, t: float, noted: bool, states: FloatArray
) -> None:
    """Alpha-beta-gamma filters, as above."""
    half = t * t / 2
    if noted:
        for lane in range(LANES):
            x = fma(t, states[axis, 1, lane], states[axis, 0, lane])
            states[axis, PREDICTED, lane] = fma(half, states[axis, 2, lane], x)
    for lane in range(LANES):
        x, v, a, total = (
            states[axis, 0, lane],
            states[axis, 1, lane],
            states[axis, 2, lane],
            states[axis, ESTIMATION, lane],
        )
        for u in range(count):
            x = fma(half, a, fma(t, v, x))
            v = fma(t, a, v)
            e = at(z, row + u, axis, lane) - x
            x = fma(states[axis, GAINS, lane], e, x)
            v = fma(states[axis, GAINS + 1, lane], e, v)
            a = fma(states[axis, GAINS + 2, lane], e, a)
            d = x - at(truth, i + u, axis, lane)
            total = fma(d, d, total)
        states[axis, 0, lane] = x
        states[axis, 1, lane] = v
        states[axis, 2, lane] = a
        states[axis, ESTIMATION, lane] = total


@inlined
def step4(
    z: FloatArray, row: int, truth: FloatArray, i: int, count: int, axis: int, t: float, noted: bool, states: FloatArray
) -> None:
    """Alpha-beta-gamma-eta filters, as above."""
    half, sixth = t * t / 2, t * t * t / 6
    if noted:
        for lane in range(LANES):
            x = fma(half, states[axis, 2, lane], fma(t, states[axis, 1, lane], states[axis, 0, lane]))
            states[axis, PREDICTED, lane] = fma(sixth, states[axis, 3, lane], x)
    for lane in range(LANES):
        x, v, a, j, total = (
            states[axis, 0, lane],
            states[axis, 1, lane],
            states[axis, 2, lane],
            states[axis, 3, lane],
            states[axis, ESTIMATION, lane],
        )
        for u in range(count):
            x = fma(sixth, j, fma(half, a, fma(t, v, x)))
            v = fma(half, j, fma(t, a, v))
            a = fma(t, j, a)
            e = at(z, row + u, axis, lane) - x
            x = fma(states[axis, GAINS, lane], e, x)
            v = fma(states[axis, GAINS + 1, lane], e, v)
            a = fma(states[axis, GAINS + 2, lane], e, a)
            j = fma(states[axis, GAINS + 3, lane], e, j)
            d = x - at(truth, i + u, axis, lane)
            total = fma(d, d, total)
        states[axis, 0, lane] = x
        states[axis, 1, lane] = v
        states[axis, 2, lane] = a
        states[axis, 3, lane] = j
        states[axis, ESTIMATION, lane] = total


@inlined
def add_squares(
    goal: FloatArray, row: int, axis: int, which: int, states: FloatArray, sums: FloatArray, into: int
) -> None:
    """Add the squares of the distances between a row of the states and a goal to a row of the sums."""
    for lane in range(LANES):
        d = states[axis, which, lane] - at(goal, row, axis, lane)
        sums[into, lane] = fma(d, d, sums[into, lane])


@inlined
def fold(sums: FloatArray, kind: int) -> None:
    """Add the error of a sample, all axes together, and look whether it is the greatest."""
    for lane in range(LANES):
        sums[TOTAL + kind, lane] += np.sqrt(sums[JOINT + kind, lane])
    for lane in range(LANES):
        sums[GREATEST + kind, lane] = max(sums[GREATEST + kind, lane], sums[JOINT + kind, lane])
        sums[JOINT + kind, lane] = 0.0
