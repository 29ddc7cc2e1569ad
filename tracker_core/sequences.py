"""Gain sets and runs one after the other: slower than side by side, but for any intervals, and for any truth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tracker_core.lanes import Batch, Group, write
from tracker_core.starts import start_axes
from tracker_core.types import ORDERS, FloatArray, IntArray


def sequential_errors(batch: Batch, dt: FloatArray) -> dict[str, dict[str, FloatArray]]:
    """What `Batch.errors` gives, wherever samples lie and whatever of the truth is known.

    Args:
        batch: what is run; its interval does not matter, and its truth is NaN where nobody knows it.
        dt: the interval before each sample, or the one number if it is constant, s.

    Returns:
        Errors by kind and figure, shape (m, r).
    """
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    found = batch.room()
    for run, positions in enumerate(batch.positions):
        z = np.array(positions.T, order="C")
        truth = np.array(batch.truth[min(run, len(batch.truth) - 1)].T, order="C")
        for group in batch.groups:
            given = None if batch.states is None else np.array(batch.states[run, :, : group.order])
            parts = []
            for gains, start in _alike(batch.start, group, z, dt, given):
                sums = np.empty((3, 4, len(gains)))
                kernels.track_errors(z, truth, dt, gains, *start, batch.limit, sums)
                parts.append(sums)
            write(found, group.rows, run, np.concatenate(parts, axis=2)[..., None])
    return found


_Start = tuple[FloatArray, IntArray, FloatArray, FloatArray]
"""States, shape (axes, 4), where the recursion begins, and the positions before that: see `kernels.track_errors`."""


def _alike(
    start: str, group: Group, z: FloatArray, dt: FloatArray, given: FloatArray | None
) -> Iterator[tuple[FloatArray, _Start]]:
    """Gain sets that start alike: all, but for an expanding memory, which ends at each one's own gain."""
    padded = np.zeros((len(group.gains), ORDERS[-1]))
    padded[:, : group.order] = group.gains
    room = np.empty((2, *z.shape, group.order))
    together = 1 if start == "expanding" else len(padded)
    for first in range(0, len(padded), together):
        yield padded[first : first + together], _begin(start, z, dt, group.gains[first], given, *room)


def _begin(
    start: str, z: FloatArray, dt: FloatArray, g: FloatArray, given: FloatArray | None, predicted: FloatArray,
    smoothed: FloatArray,
) -> _Start:  # fmt: skip
    leading, begins = start_axes(start, z, dt, g, given, predicted, smoothed)
    states = np.zeros((len(z), ORDERS[-1]))
    states[:, : len(g)] = leading
    before = int(begins.max())
    predictions, estimates = (np.ascontiguousarray(part[:, :before, 0]) for part in (predicted, smoothed))
    return states, begins, predictions, estimates
