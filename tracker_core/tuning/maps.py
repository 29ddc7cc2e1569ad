"""Two gains varied: how well a filter does over the stable part of their plane."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker_core.checks import Domain, InputError
from tracker_core.conventions import Gains
from tracker_core.experiment import Experiment
from tracker_core.fields import SEED
from tracker_core.region import PLANES, region_slice
from tracker_core.stability import stable
from tracker_core.statistics import CONFIDENCE, Interval, mean_interval, percent_more
from tracker_core.tuning.base import WEIGHT, Progress, check_scores, check_steps, steps_of
from tracker_core.tuning.evaluate import effective_runs, scored
from tracker_core.tuning.objectives import check_objective
from tracker_core.types import GAIN_NAMES, FloatArray

CELLS = Domain(2, 200, whole=True)
RUNS = Domain(1, 1_000, whole=True)

ROUNDING = 1e-9
"""Of a cell: what is less is nothing."""


@dataclass(frozen=True, slots=True)
class MapOutcome:
    """What a map has come to.

    Attributes:
        x, y: normalised gains at the middle of the columns and rows, shapes (columns,) and (rows,).
        stable: shape (rows, columns); only these cells are run.
        vectors: normalised gains of the stable cells, row by row, shape (cells, order).
        scores: shape (objectives, runs, cells), m; NaN where a run stopped or has not been computed yet.
        runs: complete ones.
    """

    x: FloatArray
    y: FloatArray
    stable: NDArray[np.bool_]
    vectors: FloatArray
    scores: FloatArray
    runs: int

    def spread(self, values: FloatArray) -> FloatArray:
        """Values of the stable cells at their places, shape (rows, columns), NaN elsewhere."""
        grid = np.full(self.stable.shape, np.nan)
        grid[self.stable] = values
        return grid

    def mean(self, row: int = 0) -> FloatArray:
        """Mean score per cell, shape (rows, columns)."""
        return self.spread(self.scores[row].mean(axis=0))

    def best(self, row: int = 0) -> int | None:
        """Number of the stable cell with the least mean score; None where there is none."""
        mean = self.scores[row].mean(axis=0)
        return None if not np.isfinite(mean).any() else int(np.nanargmin(np.where(np.isfinite(mean), mean, np.nan)))

    def score(self, cell: int, row: int = 0) -> Interval:
        """Mean score of a cell with its 95 % interval, m."""
        mean, width = mean_interval(self.scores[row][:, cell])
        return Interval(float(mean), float(mean - width), float(mean + width))

    def near_best(self, row: int = 0, confidence: float = CONFIDENCE) -> NDArray[np.bool_]:
        """Cells that are not shown to be worse than the best one by the differences in every run (one-sided t-test).

        Returns:
            Shape (cells,); the best cell alone where there is one run only.
        """
        cell = self.best(row)
        scores = self.scores[row]
        if cell is None:
            return np.zeros(len(self.vectors), dtype=bool)
        # A one-sided test at 95 % has the quantile of a two-sided one at 90 %.
        mean, width = mean_interval(scores - scores[:, [cell]], 2 * confidence - 1)
        near = mean - width <= 0
        near[cell] = True
        return near

    def near_ranges(self, row: int = 0) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """Between which values the cells lie that are not shown to be worse, half a cell more at either end.

        Returns:
            Lowest and highest of the horizontal gain and of the vertical one, normalised; None without a best cell.
        """
        if self.best(row) is None:
            return None
        near = self.spread(np.where(self.near_best(row), 1.0, 0.0)) == 1
        return _reach(self.x[near.any(axis=0)], self.x), _reach(self.y[near.any(axis=1)], self.y)

    def cost(self, chosen: int, judge: int) -> Interval:
        """By how much one objective is worse where another is best, percent of its own best, with its 95 % interval."""
        taken, best = self.best(chosen), self.best(judge)
        if taken is None or best is None:
            return Interval(np.nan, np.nan, np.nan)
        return percent_more(self.scores[judge][:, taken], self.scores[judge][:, best])


def _reach(marked: FloatArray, along: FloatArray) -> tuple[float, float]:
    """The outer edges of marked cells, of which `along` has all middles."""
    half = float(along[1] - along[0]) / 2
    low, high = float(marked.min()) - half, float(marked.max()) + half
    # The edge of the plane is where a gain vanishes; rounding leaves something of it.
    return (low if abs(low) > half * ROUNDING else 0.0), high


@dataclass(frozen=True, slots=True)
class Map:
    """Two gains varied over the stable part of their plane, through the other gains of the experiment.

    Attributes:
        experiment: what is run, with its seed and the ones after it; one with constant gains. What its own filter's
            gate refuses is left out.
        plane: names of the horizontal and the vertical gain, of `region.PLANES`.
        objective: a name in OBJECTIVES; where nobody knows the truth, one of the innovation.
        columns, rows: cells along each, 2 to 200.
        runs: 1 to 1,000; one is taken where nothing is left to chance.
        weight: of the noise in the objective that weighs it against the lag.
        beside: other objectives that are to be known as well.

    Raises:
        InputError: for what does not fit together, takes too long, or where nothing in the plane is stable.
    """

    experiment: Experiment
    plane: tuple[str, str]
    objective: str
    columns: int = 60
    rows: int = 60
    runs: int = 5
    weight: float = 0.5
    beside: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in self.objectives:
            check_objective(name, self.experiment)
        CELLS.check("columns", self.columns)
        CELLS.check("rows", self.rows)
        RUNS.check("runs", self.runs)
        SEED.check("seed", self.experiment.seed + self.runs - 1)
        WEIGHT.check("weight", self.weight)
        if self.experiment.method is not None:
            raise InputError("design", "must have constant gains for a map", self.experiment.design)
        if tuple(self.plane) not in PLANES[self.experiment.order]:
            raise InputError("plane", f"must be two gains of order {self.experiment.order}", self.plane)
        if not region_slice(self.experiment.gains(), self.plane)[0].size:
            raise InputError("plane", "must have a stable part with the other gains as they are", "-".join(self.plane))
        cells = self.columns * self.rows
        check_scores("runs", self.runs, self.runs * cells * len(self.objectives))
        check_steps("runs", self.runs, self.runs * cells * steps_of(self.experiment))

    @property
    def objectives(self) -> tuple[str, ...]:
        """All that is looked at; the first is tuned for."""
        return (self.objective, *self.beside)

    def grid(self) -> tuple[FloatArray, FloatArray]:
        """Middles of the columns and rows: the box around the stable part of the plane, in equal cells."""
        border = region_slice(self.experiment.gains(), self.plane)
        return tuple(  # type: ignore[return-value]
            float(along.min()) + (float(along.max()) - float(along.min())) * (np.arange(count) + 0.5) / count
            for along, count in zip(border, (self.columns, self.rows), strict=True)
        )

    def stream(self, executor: Executor | None = None) -> Iterator[Progress[MapOutcome]]:
        """The outcome as it grows, run by run; closing the iterator ends the work."""
        x, y = self.grid()
        across, up = (GAIN_NAMES.index(name) for name in self.plane)
        vectors = np.tile(self.experiment.gains().vector, (len(y), len(x), 1))
        vectors[:, :, across], vectors[:, :, up] = x, y[:, None]
        inside = stable(vectors)
        kept = vectors[inside]
        runs = effective_runs(self.experiment, self.objective, self.runs)
        total = runs * len(kept) * steps_of(self.experiment)
        for complete, done, scores in scored(self.experiment, kept, self.objectives, runs, self.weight, executor):
            yield Progress(done, total, MapOutcome(x, y, inside, kept, scores[:, : max(1, complete)], complete))

    def at(self, vector: FloatArray) -> Gains:
        """The gains of a cell in the convention of the experiment."""
        return Gains.normalised(vector).to(self.experiment.convention)
