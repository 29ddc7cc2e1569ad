"""One step of many filters side by side: the loops are over lanes, and become vector instructions.

A lane is one filter in one run. What is seen of the target, the truth and the measurement, is the same for all lanes,
shape (n, axes, 2), or each lane's own, shape (n, axes, 2, LANES); what a lane computes is the same in both, to the
last bit. For speed the compiler must see that rows do not overlap: they are rows of few arrays whose shapes it knows,
and never views, whose users would be counted.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.extending import overload

from tracker_core.kernels.compiled import fma, inlined
from tracker_core.types import FloatArray

LANES = 64
"""Filters side by side: enough to keep the processor busy, few enough for its nearest cache."""

TRUE, MEASURED = 0, 1
"""What is seen at a sample of an axis."""

GAINS, PREDICTED, ROWS_OF_STATE = 4, 8, 9
"""Rows of the states (axes, 9, LANES): up to four states, as many gains in use, and the predicted position."""

SQUARES, JOINT, TOTAL, GREATEST, COUNT, KEPT, FARTHEST, ROWS_OF_SUMS = 0, 3, 6, 9, 12, 15, 18, 19
"""Rows of the sums; all but the last come in threes, one for each kind of error: tracking, estimation, innovation."""


def at(seen: FloatArray, i: int, axis: int, what: int, lane: int) -> Any:
    """What a lane sees of an axis at sample i."""
    return seen[i, axis, what] if seen.ndim == 3 else seen[i, axis, what, lane]


@overload(at, inline="always")
def _at(seen: Any, i: Any, axis: Any, what: Any, lane: Any) -> Any:  # noqa: ARG001
    def shared(seen: Any, i: Any, axis: Any, what: Any, lane: Any) -> Any:  # noqa: ARG001
        return seen[i, axis, what]

    def its_own(seen: Any, i: Any, axis: Any, what: Any, lane: Any) -> Any:
        return seen[i, axis, what, lane]

    return shared if seen.ndim == 3 else its_own


@inlined
def step2(seen: FloatArray, i: int, axis: int, t: float, noted: bool, states: FloatArray, sums: FloatArray) -> None:
    """Alpha-beta filters over one sample of one axis: predict, correct, add the square of the estimation error.

    The gains correct the states themselves: they are divided by powers of t. `noted` says whether to keep the predicted
    position.
    """
    if noted:
        for lane in range(LANES):
            states[axis, PREDICTED, lane] = fma(t, states[axis, 1, lane], states[axis, 0, lane])
    for lane in range(LANES):
        v = states[axis, 1, lane]
        x = fma(t, v, states[axis, 0, lane])
        e = at(seen, i, axis, MEASURED, lane) - x
        x = fma(states[axis, GAINS + 0, lane], e, x)
        states[axis, 0, lane] = x
        states[axis, 1, lane] = fma(states[axis, GAINS + 1, lane], e, v)
        d = x - at(seen, i, axis, TRUE, lane)
        sums[SQUARES + 1, lane] = fma(d, d, sums[SQUARES + 1, lane])


@inlined
def step3(seen: FloatArray, i: int, axis: int, t: float, noted: bool, states: FloatArray, sums: FloatArray) -> None:
    """Alpha-beta-gamma filters, as above."""
    half = t * t / 2
    if noted:
        for lane in range(LANES):
            x = fma(t, states[axis, 1, lane], states[axis, 0, lane])
            states[axis, PREDICTED, lane] = fma(half, states[axis, 2, lane], x)
    for lane in range(LANES):
        v, a = states[axis, 1, lane], states[axis, 2, lane]
        x = fma(half, a, fma(t, v, states[axis, 0, lane]))
        v = fma(t, a, v)
        e = at(seen, i, axis, MEASURED, lane) - x
        x = fma(states[axis, GAINS + 0, lane], e, x)
        states[axis, 0, lane] = x
        states[axis, 1, lane] = fma(states[axis, GAINS + 1, lane], e, v)
        states[axis, 2, lane] = fma(states[axis, GAINS + 2, lane], e, a)
        d = x - at(seen, i, axis, TRUE, lane)
        sums[SQUARES + 1, lane] = fma(d, d, sums[SQUARES + 1, lane])


@inlined
def step4(seen: FloatArray, i: int, axis: int, t: float, noted: bool, states: FloatArray, sums: FloatArray) -> None:
    """Alpha-beta-gamma-eta filters, as above."""
    half, sixth = t * t / 2, t * t * t / 6
    if noted:
        for lane in range(LANES):
            x = fma(half, states[axis, 2, lane], fma(t, states[axis, 1, lane], states[axis, 0, lane]))
            states[axis, PREDICTED, lane] = fma(sixth, states[axis, 3, lane], x)
    for lane in range(LANES):
        v, a, j = states[axis, 1, lane], states[axis, 2, lane], states[axis, 3, lane]
        x = fma(sixth, j, fma(half, a, fma(t, v, states[axis, 0, lane])))
        v = fma(half, j, fma(t, a, v))
        a = fma(t, j, a)
        e = at(seen, i, axis, MEASURED, lane) - x
        x = fma(states[axis, GAINS + 0, lane], e, x)
        states[axis, 0, lane] = x
        states[axis, 1, lane] = fma(states[axis, GAINS + 1, lane], e, v)
        states[axis, 2, lane] = fma(states[axis, GAINS + 2, lane], e, a)
        states[axis, 3, lane] = fma(states[axis, GAINS + 3, lane], e, j)
        d = x - at(seen, i, axis, TRUE, lane)
        sums[SQUARES + 1, lane] = fma(d, d, sums[SQUARES + 1, lane])


@inlined
def add_squares(
    seen: FloatArray, i: int, axis: int, what: int, states: FloatArray, row: int, sums: FloatArray, into: int
) -> None:
    """Add the squares of the distances between a row of the states and what was seen to a row of the sums."""
    for lane in range(LANES):
        d = states[axis, row, lane] - at(seen, i, axis, what, lane)
        sums[into, lane] = fma(d, d, sums[into, lane])


@inlined
def fold(sums: FloatArray, kind: int) -> None:
    """Add the error of a sample, all axes together, and look whether it is the greatest."""
    for lane in range(LANES):
        sums[TOTAL + kind, lane] += np.sqrt(sums[JOINT + kind, lane])
    for lane in range(LANES):
        sums[GREATEST + kind, lane] = max(sums[GREATEST + kind, lane], sums[JOINT + kind, lane])
        sums[JOINT + kind, lane] = 0.0
