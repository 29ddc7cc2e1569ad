"""Gain sets and runs laid out side by side for `kernels.lane_errors`: in every lane one filter in one run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tracker_core.openings import Opening, opening
from tracker_core.starts import STARTS
from tracker_core.types import BoolArray, FloatArray, IntArray

KINDS = ("tracking", "estimation", "innovation")
FIGURES = ("total", "rmse", "max", "l2")

BLOCK = 128
"""Groups of lanes whose sums are kept at a time."""


@dataclass(frozen=True, slots=True)
class Group:
    """Gain sets of one order.

    Attributes:
        rows: shape (m,), where they stand among all.
        gains: shape (m, order), normalised.
    """

    rows: IntArray
    gains: FloatArray

    @property
    def order(self) -> int:
        """Of their filters."""
        return self.gains.shape[1]

    @property
    def least(self) -> float:
        """The least position gain."""
        return float(self.gains[:, 0].min())


@dataclass(frozen=True, slots=True)
class Batch:
    """What is to be run, checked, and what is asked for.

    Attributes:
        groups: the gain sets.
        positions: shape (r, n_samples, n_axes), contiguous; NaN where a measurement is missing.
        truth: shape (1 or r, n_samples, n_axes), contiguous; side by side all of it must be known.
        interval: s.
        start: a name in STARTS.
        states: shape (r, n_axes, greatest order), before the first sample; None but for the start "known".
        limit: of the magnitude of a smoothed position, m.
        kinds: of KINDS.
        figures: of FIGURES.
    """

    groups: list[Group]
    positions: FloatArray
    truth: FloatArray
    interval: float
    start: str
    states: FloatArray | None
    limit: float
    kinds: tuple[str, ...]
    figures: tuple[str, ...]

    @property
    def farthest(self) -> float:
        """The greatest magnitude of a true position, m."""
        return float(np.abs(self.truth).max())

    @property
    def sets(self) -> int:
        """How many gain sets there are."""
        return sum(len(group.rows) for group in self.groups)

    def room(self) -> dict[str, dict[str, FloatArray]]:
        """Room for what is asked for, by kind and figure, shape (m, r)."""
        shape = self.sets, len(self.positions)
        return {kind: {name: np.empty(shape) for name in self.figures} for kind in self.kinds}

    def errors(self) -> dict[str, dict[str, FloatArray]]:
        """By kind and figure, shape (m, r)."""
        from tracker_core.kernels import LANES  # compiled code is loaded when the first filter runs

        sets, runs = self.sets, len(self.positions)
        found = self.room()
        regular = self._regular()
        usual = np.flatnonzero(regular)
        # Lanes are filled with gain sets or with runs, whichever leaves fewer of them empty; the answer is the same.
        if sets * -(-len(usual) // LANES) >= len(usual) * sum(-(-len(group.rows) // LANES) for group in self.groups):
            usual = usual[:0]
        order = np.concatenate((usual, np.setdiff1d(np.arange(runs), usual)))
        for first, rows, sums in self._over_runs(usual):
            write(found, rows, first, sums)
        for column in range(len(usual), runs):
            for rows, sums in self._over_sets(int(order[column])):
                write(found, rows, column, sums)
        if not regular.all():
            back = np.argsort(order)
            return {kind: {name: values[:, back] for name, values in all_.items()} for kind, all_ in found.items()}
        return found

    def _regular(self) -> BoolArray:
        """The runs, shape (r,), of which nothing is missing while they start: all of them start alike."""
        length = STARTS[self.start].points
        if self.start == "expanding":
            length = max((len(self._all_there(group).until) for group in self.groups), default=0)
        return np.asarray(~np.isnan(self.positions[:, :length]).any(axis=(1, 2)))

    def _all_there(self, group: Group) -> Opening:
        return opening(self.start, group.order, np.ones(self.positions.shape[1], dtype=bool), group.least)

    def _over_sets(self, run: int) -> Iterator[tuple[IntArray, FloatArray]]:
        """One run, the lanes are gain sets: rows of the answer and their sums, shape (3, 4, rows, 1)."""
        from tracker_core.kernels import LANES

        z, truth = self.positions[run], self.truth[min(run, len(self.truth) - 1)]
        missing = np.isnan(z)
        z = np.concatenate((z, np.zeros((1, z.shape[1]))))
        for group in self.groups:
            beginning = Beginning.of([opening(self.start, group.order, ~axis, group.least) for axis in missing.T])
            before = self._before(np.full(LANES, run), group.order)
            for rows in _blocks(len(group.rows), BLOCK * LANES):
                some = group.gains[rows]
                filled = some[np.arange(-(-len(some) // LANES) * LANES) % len(some)]
                lanes = np.ascontiguousarray(filled.reshape(-1, LANES, group.order).transpose(0, 2, 1))
                sums = self._sums(z, truth, np.asarray(missing.any(axis=1)), beginning, lanes, before)
                yield group.rows[rows], sums.reshape(3, 4, -1, 1)[:, :, : len(some)]

    def _over_runs(self, runs: IntArray) -> Iterator[tuple[int, IntArray, FloatArray]]:
        """Runs that start alike, which are the lanes: number of the first, rows, sums, shape (3, 4, rows, runs)."""
        from tracker_core.kernels import LANES, transposed

        _, samples, axes = self.positions.shape
        z, missing = np.zeros((samples + 1, axes, LANES)), np.empty(samples, dtype=bool)
        truth = self.truth[0] if len(self.truth) == 1 else np.empty((samples, axes, LANES))
        beginnings = [Beginning.of([self._all_there(group)] * axes) for group in self.groups]
        for first in range(0, len(runs), LANES):
            count = min(LANES, len(runs) - first)
            here = runs[first + np.arange(LANES) % count]
            missing[:] = False
            transposed(self.positions, here, z, missing)
            if len(self.truth) > 1:
                transposed(self.truth, here, truth, missing)
            for group, beginning in zip(self.groups, beginnings, strict=True):
                before = self._before(here, group.order)
                for rows in _blocks(len(group.rows), BLOCK):
                    lanes = np.repeat(group.gains[rows, :, None], LANES, axis=2)
                    sums = self._sums(z, truth, missing, beginning, lanes, before)
                    yield first, group.rows[rows], sums[..., :count]

    def _before(self, runs: IntArray, order: int) -> FloatArray:
        """The states of these runs before the first sample, shape (n_axes, order, len(runs))."""
        if self.states is None:
            return np.zeros((self.positions.shape[2], order, len(runs)))
        return np.ascontiguousarray(self.states[runs, :, :order].transpose(1, 2, 0))

    def _sums(
        self, z: FloatArray, truth: FloatArray, missing: BoolArray, beginning: Beginning, lanes: FloatArray,
        before: FloatArray,
    ) -> FloatArray:  # fmt: skip
        """What `kernels.lane_errors` finds, shape (3, 4, c, LANES)."""
        from tracker_core import kernels

        found = np.empty((3, 4, len(lanes), kernels.LANES))
        wanted = np.array([kind in self.kinds for kind in KINDS])
        each = "total" in self.figures or "max" in self.figures
        kernels.lane_errors(
            z, truth, missing | beginning.special, beginning.counted, self.interval, lanes, beginning.gains,
            beginning.until, before, self.farthest, self.limit, wanted, each, found,
        )  # fmt: skip
        return found


@dataclass(frozen=True, slots=True)
class Beginning:
    """How all axes start, as `kernels.lane_errors` is told.

    Attributes:
        gains: shape (n_axes, b, order), normalised.
        until: shape (n_axes, b).
        counted: shape (3, n_samples).
        special: shape (n_samples,), but for missing measurements.
    """

    gains: FloatArray
    until: FloatArray
    counted: BoolArray
    special: BoolArray

    @classmethod
    def of(cls, axes: list[Opening]) -> Beginning:
        """From how each starts."""
        length, order = max(len(one.until) for one in axes), axes[0].gains.shape[1]
        gains, until = np.zeros((len(axes), length, order)), np.full((len(axes), length), -np.inf)
        for axis, one in enumerate(axes):
            gains[axis, : len(one.gains)], until[axis, : len(one.until)] = one.gains, one.until
        predicted = np.logical_and.reduce([one.predicted for one in axes])
        smoothed = np.logical_and.reduce([one.smoothed for one in axes])
        special = ~(predicted & smoothed)
        special[:length] = True
        return cls(gains, until, np.stack((predicted, smoothed, predicted)), special)


def write(found: dict[str, dict[str, FloatArray]], rows: IntArray, first: int, sums: FloatArray) -> None:
    """Make figures of sums.

    Args:
        found: by kind and figure, shape (m, r), filled in.
        rows: where the gain sets stand, shape (k,).
        first: number of the first of the runs.
        sums: shape (3, 4, k, runs): of every kind the sum, the sum of squares, the square of the greatest and the
            number of errors.
    """
    columns = slice(first, first + sums.shape[-1])
    with np.errstate(invalid="ignore", divide="ignore"):
        for kind, figures in found.items():
            total, squares, greatest, count = sums[KINDS.index(kind)]
            defined = np.where(count == 0, np.nan, 1.0)
            for name, values in figures.items():
                if name == "total":
                    values[rows, columns] = total * defined
                elif name == "rmse":
                    values[rows, columns] = np.sqrt(squares / count)
                elif name == "max":
                    values[rows, columns] = np.sqrt(greatest) * defined
                else:
                    values[rows, columns] = np.sqrt(squares) / count


def _blocks(count: int, size: int) -> Iterator[slice]:
    return (slice(first, first + size) for first in range(0, count, size))
