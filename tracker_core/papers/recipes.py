"""How a printed cell is recomputed: from formulas, from other printed cells, or from runs over noise seeds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from math import hypot, sqrt
from typing import Any

import numpy as np

from tracker_core.checks import InputError
from tracker_core.design import DESIGNS
from tracker_core.experiment import Experiment
from tracker_core.metrics import Metrics
from tracker_core.motion import transition
from tracker_core.papers.document import Column, Paper, Row, Table
from tracker_core.papers.printed import EMPTY, number
from tracker_core.papers.sweeps import sweep
from tracker_core.run import run_experiment
from tracker_core.types import GAIN_NAMES


@dataclass(frozen=True, slots=True)
class Cell:
    """One printed cell, with where it stands.

    Attributes:
        paper, table, row, column: what it is a cell of.
    """

    paper: Paper
    table: Table
    row: Row
    column: Column

    @property
    def printed(self) -> str:
        """As printed."""
        return self.row.cells[self.table.columns.index(self.column)]

    @property
    def recipe(self) -> str:
        """The name of its recipe."""
        return self.row.recipes.get(self.column.name) or self.row.recipe or self.column.recipe

    def told(self, name: str, default: Any = None) -> Any:
        """What the recipe is told, by the row, else by the column; the default where neither does."""
        return self.row.options.get(name, self.column.options.get(name, default))

    def option(self, name: str) -> Any:
        """What the recipe must be told.

        Raises:
            InputError: where it is not.
        """
        value = self.told(name)
        if value is None:
            raise InputError(name, f"must be given for the recipe '{self.recipe}'", None)
        return value

    def experiment(self) -> Experiment:
        """The run that the cell reports."""
        run = self.row.run or str(self.option("run")).format(row=self.row.name)
        return self.paper.run(run).experiment

    def number(self, row: str, column: str) -> float:
        """A number printed in the table that the options name, else in this one."""
        return float(number(self._table().printed(row, column)))

    def rows(self) -> tuple[str, ...]:
        """Names of the rows of that table."""
        return tuple(row.name for row in self._table().rows)

    def _table(self) -> Table:
        return self.paper.table(self.told("table", self.table.name))


def cells(paper: Paper, table: Table) -> list[Cell]:
    """All cells of a table in which something is printed, row by row."""
    return [
        Cell(paper, table, row, column)
        for row in table.rows
        for column, printed in zip(table.columns, row.cells, strict=True)
        if printed != EMPTY
    ]


# From formulas -----------------------------------------------------------------------------------------------------


def _benedict_bordner_simpson(cell: Cell) -> float:
    """Jeong eq. 7 and 8 in rational arithmetic: gamma is zero identically."""
    alpha = Fraction(str(cell.option("alpha")))
    beta = alpha**2 / (2 - alpha)
    gamma = 2 * (2 * beta / alpha - alpha - beta)
    return float((alpha, beta, gamma)[GAIN_NAMES.index(cell.option("gain"))])


def _jeong_gray_murray(cell: Cell) -> float:
    """Jeong eq. 10-13."""
    gains = DESIGNS["jeong-gray-murray"].gains(3, tracking_index=cell.option("tracking_index"))
    return float(gains[GAIN_NAMES.index(cell.option("gain"))])


def _fading_memory(cell: Cell) -> float:
    """Jeong eq. 14-16 and 25-28; eq. 28 is a sixth of the normalised jerk gain."""
    gains = DESIGNS["fading-memory"].gains(cell.option("order"), xi=cell.option("xi"))
    index = GAIN_NAMES.index(cell.option("gain"))
    return float(gains[index]) / (6 if index == 3 else 1)


def _tracking_index(cell: Cell) -> float:
    """Jeong eq. 9, from printed variances."""
    ratio = cell.option("process_variance") / cell.option("sensor_variance")
    return sqrt(ratio) * cell.experiment().interval ** 2


def _damping(cell: Cell) -> float:
    """Jeong eq. 10: alpha = 1 - r^2."""
    alpha = DESIGNS["kalata"].gains(2, tracking_index=cell.option("tracking_index"))[0]
    return sqrt(1 - float(alpha))


def _standard_deviation(cell: Cell) -> float:
    """Of a printed variance."""
    return sqrt(cell.option("variance"))


def _target(cell: Cell) -> float:
    """What the run's target and sensor are at the first sample."""
    experiment = cell.experiment()
    state = run_experiment(experiment).truth.states[0]
    return {
        "x": float(state[0, 0]),
        "y": float(state[-1, 0]),
        "speed": hypot(*state[:, 1]),
        "interval": experiment.interval,
        "samples": float(experiment.samples),
    }[cell.option("quantity")]


def _state(cell: Cell) -> float:
    """A state of a run without random noise."""
    track = run_experiment(cell.experiment()).track
    states = track.predicted if cell.option("of") == "predicted" else track.smoothed
    return float(states[int(cell.option("sample")) - 1, 0, int(cell.option("state"))])


def _next_prediction(cell: Cell) -> float:
    """The position predicted for the sample after the one named."""
    experiment = cell.experiment()
    smoothed = run_experiment(experiment).track.smoothed[int(cell.option("sample")) - 1, 0]
    return float((transition(experiment.order, experiment.interval) @ smoothed)[0])


# From other printed cells ------------------------------------------------------------------------------------------


def _copy(cell: Cell) -> float:
    """What another table prints; the row there may have another name."""
    return cell.number(cell.told("row", cell.row.name), cell.told("column", cell.column.name))


def _excess(cell: Cell) -> float:
    """By how many percent one printed error exceeds another."""
    over, under = (cell.number(cell.row.name, cell.option(name)) for name in ("over", "under"))
    return 100 * (over / under - 1)


def _step_ratio(cell: Cell) -> float:
    """The printed error of the row before over that of this row."""
    rows, column = cell.rows(), cell.option("of")
    before = rows[rows.index(cell.row.name) - 1]
    return cell.number(before, column) / cell.number(cell.row.name, column)


def _mean_difference(cell: Cell) -> float:
    """Mean over the experiments of one axis, of one method's error less another's."""
    rows = [row for row in cell.rows() if row.endswith(f"-{cell.option('axis')}")]
    base, of = cell.option("base"), cell.option("of")
    return float(np.mean([cell.number(row, base) - cell.number(row, of) for row in rows]))


def _percent_change(cell: Cell) -> float:
    """Al-Wagih eq. 27."""
    base, of = (cell.number(cell.row.name, cell.option(name)) for name in ("base", "of"))
    return 100 * (base - of) / base


def _difference(cell: Cell) -> float:
    column = cell.told("column", cell.column.name)
    return cell.number(cell.option("minuend"), column) - cell.number(cell.option("subtrahend"), column)


def _difference_percent(cell: Cell) -> float:
    return 100 * _difference(cell) / cell.number(cell.option("minuend"), cell.told("column", cell.column.name))


Derived = Callable[[Cell], float]
DERIVED: dict[str, Derived] = {
    "benedict-bordner-simpson": _benedict_bordner_simpson,
    "jeong-gray-murray": _jeong_gray_murray,
    "fading-memory": _fading_memory,
    "tracking-index": _tracking_index,
    "damping": _damping,
    "standard-deviation": _standard_deviation,
    "target": _target,
    "state": _state,
    "next-prediction": _next_prediction,
    "copy": _copy,
    "excess": _excess,
    "step-ratio": _step_ratio,
    "mean-difference": _mean_difference,
    "percent-change": _percent_change,
    "difference": _difference,
    "difference-percent": _difference_percent,
}
"""Recipes without chance."""

# From runs over noise seeds ----------------------------------------------------------------------------------------


@lru_cache(maxsize=20_000)
def _metrics(experiment: Experiment, by_axis: bool) -> tuple[Metrics, ...]:
    """Of all axes jointly, or of every axis by itself; one run does for all."""
    result = run_experiment(experiment)
    return result.axis_metrics() if by_axis else (result.metrics,)


def _metric(cell: Cell, change: Mapping[str, Any], seed: int) -> float:
    """A figure of merit of a run, of all axes jointly or of one."""
    axis = cell.told("axis")
    found = _metrics(replace(cell.experiment(), seed=seed, **change), axis is not None)
    value = getattr(found[axis or 0], cell.option("metric"))
    return float("nan") if value is None else float(value)


def _optimum(cell: Cell, change: Mapping[str, Any], seed: int) -> float:
    """Where on a grid of one parameter a total is least."""
    values = grid(cell)
    experiment = replace(cell.experiment(), **change)
    totals = sweep(experiment, cell.option("parameter"), values, cell.option("objective"), (seed,))[0]
    return values[int(np.nanargmin(totals))]


def grid(cell: Cell) -> tuple[float, ...]:
    """The values that an optimum is looked for among: steps between two ends, or decades."""
    decades = cell.told("decades")
    if decades is not None:
        return tuple(10.0**power for power in range(decades[0], decades[1] + 1))
    low, high, step = (cell.option(name) for name in ("low", "high", "step"))
    return tuple(round(low + step * i, 12) for i in range(round((high - low) / step) + 1))


Simulated = Callable[[Cell, Mapping[str, Any], int], float]
SIMULATED: dict[str, Simulated] = {"metric": _metric, "optimum": _optimum}
"""Recipes that depend on the noise: of a cell, changed fields of its experiment, and a seed."""
