"""Gain sets and runs laid out side by side for `kernels.lanes`: in every lane one filter in one run."""

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
        truth: shape (1 or r, n_samples, n_axes), contiguous.
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

    def errors(self) -> dict[str, dict[str, FloatArray]]:
        """By kind and figure, shape (m, r)."""
        from tracker_core.kernels import LANES  # compiled code is loaded when the first filter runs

        sets, runs = sum(len(group.rows) for group in self.groups), len(self.positions)
        found = {kind: {name: np.empty((sets, runs)) for name in self.figures} for kind in self.kinds}
        regular = self._regular()
        usual, unusual = np.flatnonzero(regular), np.flatnonzero(~regular)
        # Lanes are filled with gain sets or with runs, whichever leaves fewer of them empty; the answer is the same.
        by_runs = sets * -(-len(usual) // LANES)
        by_sets = len(usual) * sum(-(-len(group.rows) // LANES) for group in self.groups)
        if by_runs < by_sets:
            for first in range(0, len(usual), LANES):
                for rows, sums in self._over_runs(usual[first : first + LANES]):
                    self._write(found, rows, usual[first : first + LANES], sums)
        for run in unusual.tolist() if by_runs < by_sets else range(runs):
            for rows, sums in self._over_sets(run):
                self._write(found, rows, np.array([run]), sums)
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
        samples, axes = z.shape
        seen = np.zeros((samples + 1, axes, 2))
        seen[:-1, :, 0], seen[:-1, :, 1] = truth, z
        missing = np.isnan(z)
        for group in self.groups:
            openings = [opening(self.start, group.order, ~missing[:, axis], group.least) for axis in range(axes)]
            for rows in _blocks(len(group.rows), BLOCK * LANES):
                some = group.gains[rows]
                filled = some[np.arange(-(-len(some) // LANES) * LANES) % len(some)]
                lanes = np.ascontiguousarray(filled.reshape(-1, LANES, group.order).transpose(0, 2, 1))
                before = self._before(np.full(LANES, run), group.order)
                sums = self._sums(seen, np.asarray(missing.any(axis=1)), openings, lanes, before)
                yield group.rows[rows], sums.transpose(1, 2, 0, 3).reshape(3, 4, -1, 1)[:, :, : len(some)]

    def _over_runs(self, here: IntArray) -> Iterator[tuple[IntArray, FloatArray]]:
        """Up to LANES runs that start alike, which are the lanes: rows and sums, shape (3, 4, rows, runs)."""
        from tracker_core.kernels import LANES, transposed

        _, samples, axes = self.positions.shape
        runs = here[np.arange(LANES) % len(here)]
        seen, missing = np.zeros((samples + 1, axes, 2, LANES)), np.zeros(samples, dtype=bool)
        transposed(self.positions, self.truth, runs, seen, missing)
        for group in self.groups:
            openings = [self._all_there(group)] * axes
            for rows in _blocks(len(group.rows), BLOCK):
                lanes = np.repeat(group.gains[rows, :, None], LANES, axis=2)
                sums = self._sums(seen, missing, openings, lanes, self._before(runs, group.order))
                yield group.rows[rows], sums.transpose(1, 2, 0, 3)[..., : len(here)]

    def _before(self, runs: IntArray, order: int) -> FloatArray:
        """The states of these runs before the first sample, shape (n_axes, order, len(runs))."""
        if self.states is None:
            return np.zeros((self.positions.shape[2], order, len(runs)))
        return np.ascontiguousarray(self.states[runs, :, :order].transpose(1, 2, 0))

    def _sums(
        self, seen: FloatArray, missing: BoolArray, openings: list[Opening], lanes: FloatArray, before: FloatArray
    ) -> FloatArray:
        """What `kernels.lanes` finds, shape (c, 3, 4, LANES)."""
        from tracker_core import kernels

        predicted = np.logical_and.reduce([one.predicted for one in openings])
        smoothed = np.logical_and.reduce([one.smoothed for one in openings])
        counted = np.stack((predicted, smoothed, predicted))
        length = max(len(one.until) for one in openings)
        gains, until = np.zeros((len(openings), length, lanes.shape[1])), np.full((len(openings), length), -np.inf)
        for axis, one in enumerate(openings):
            gains[axis, : len(one.gains)], until[axis, : len(one.until)] = one.gains, one.until
        special = missing | ~counted.all(axis=0)
        special[:length] = True
        found = np.empty((len(lanes), 3, 4, kernels.LANES))
        kernels.lanes(
            seen, special, counted, self.interval, lanes, gains, until, before, float(np.abs(seen[:-1, :, 0]).max()),
            self.limit, np.array([kind in self.kinds for kind in KINDS]),
            "total" in self.figures or "max" in self.figures, found,
        )  # fmt: skip
        return found

    def _write(
        self, found: dict[str, dict[str, FloatArray]], rows: IntArray, columns: IntArray, sums: FloatArray
    ) -> None:
        for kind, figures in found.items():
            total, squares, greatest, count = sums[KINDS.index(kind)]
            with np.errstate(invalid="ignore", divide="ignore"):
                defined = np.where(count == 0, np.nan, 1.0)
                for name, values in figures.items():
                    if name == "total":
                        figure = total * defined
                    elif name == "rmse":
                        figure = np.sqrt(squares / count)
                    elif name == "max":
                        figure = np.sqrt(greatest) * defined
                    else:
                        figure = np.sqrt(squares) / count
                    values[np.ix_(rows, columns)] = figure


def _blocks(count: int, size: int) -> Iterator[slice]:
    return (slice(first, first + size) for first in range(0, count, size))
