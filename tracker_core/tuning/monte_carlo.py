"""Several filters in the same runs: what each comes to, and which differences are more than chance."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from tracker_core.batch import KINDS
from tracker_core.checks import Domain, InputError
from tracker_core.experiment import Experiment
from tracker_core.fields import SEED
from tracker_core.metrics import METRICS
from tracker_core.run import SEEN, observation_rmse, observe_runs, run_experiment
from tracker_core.statistics import CONFIDENCE, Interval, half_width, percent_interval
from tracker_core.tuning.base import BLOCK_STEPS, Progress, check_steps, has_chance, steps_of
from tracker_core.tuning.evaluate import run_errors
from tracker_core.tuning.executors import ordered
from tracker_core.tuning.objectives import HOWS
from tracker_core.types import FloatArray, IntArray

RUNS = Domain(2, 1_000_000, whole=True)
FILTERS = Domain(1, 7, whole=True)

METHOD_STEPS, GATE_STEPS = 500, 80
"""A filter whose gains are chosen as it runs counts as this many, and one with a gate."""

STREAM_STEPS, VALUE_STEPS = 8_000, 3
"""Filter steps that take as long as it does to begin the noise of an axis, and to draw a value of it."""

_ERRORS = tuple(name for name in METRICS if name.partition("_")[0] in KINDS)

FIGURES = (*_ERRORS, "noise_reduction")
"""The metrics that differ from run to run, as METRICS names them."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One filter against another in the same runs.

    Attributes:
        interval: the mean difference, in the unit of the metric.
        percent: the same, in percent of the other's mean, which is itself uncertain; NaN where that is zero, or where
            one of the two has the metric in a run in which the other has not.
        significant: whether zero lies outside the interval of the mean difference; 95 % of that hold for a number of
            runs that was fixed beforehand.
        runs: in which both have the metric.
    """

    interval: Interval
    percent: Interval
    significant: bool
    runs: int


@dataclass(frozen=True, slots=True)
class Moments:
    """Counts, means and sums of squared deviations.

    Attributes:
        count, mean, square: shape (figures, filters, filters); of filter i minus filter j, and on the diagonal of
            filter i itself, over the runs in which they have the figure.
    """

    count: IntArray
    mean: FloatArray
    square: FloatArray

    @classmethod
    def of(cls, values: FloatArray) -> Moments:
        """Those of runs, shape (runs, filters, figures); NaN where a run was stopped."""
        by_figure = values.transpose(2, 1, 0)
        pairs = by_figure[:, :, None] - by_figure[:, None]
        own = np.arange(values.shape[1])
        pairs[:, own, own] = by_figure
        defined = ~np.isnan(pairs)
        count = defined.sum(axis=-1)
        mean = np.where(defined, pairs, 0.0).sum(axis=-1) / np.maximum(count, 1)
        deviations = np.where(defined, pairs - mean[..., None], 0.0)
        return cls(count, mean, np.einsum("...r,...r->...", deviations, deviations))

    def merged(self, other: Moments) -> Moments:
        """Those of the runs of both (Chan, Golub & LeVeque 1979)."""
        count = self.count + other.count
        shift, share = other.mean - self.mean, other.count / np.maximum(count, 1)
        return Moments(count, self.mean + shift * share, self.square + other.square + shift**2 * (self.count * share))


@dataclass(frozen=True, slots=True)
class Comparison:
    """What a Monte Carlo comparison has come to.

    Attributes:
        filters: how many are compared.
        runs: so far.
        stopped: per filter the runs in which it was stopped, shape (filters,).
        moments: of FIGURES.
    """

    filters: int
    runs: int
    stopped: IntArray
    moments: Moments

    def own(self, figure: str, number: int, confidence: float = CONFIDENCE) -> Interval:
        """Mean of a filter's figure with its interval; NaN where it has none."""
        return self._interval(FIGURES.index(figure), number, number, confidence)

    def difference(self, figure: str, number: int, reference: int, confidence: float | None = None) -> Difference:
        """A filter's figure minus that of another one, run by run.

        Args:
            figure: a name in FIGURES.
            number, reference: of the filters.
            confidence: of the interval; None for 95 % that all comparisons of this figure with the reference hold
                together (Bonferroni).
        """
        level = 1 - (1 - CONFIDENCE) / max(1, self.filters - 1) if confidence is None else confidence
        row = FIGURES.index(figure)
        interval = self._interval(row, number, reference, level)
        percent = self._percent(row, number, reference, level)
        significant = interval.low > 0 or interval.high < 0
        return Difference(interval, percent, significant, int(self.moments.count[row, number, reference]))

    def _interval(self, row: int, i: int, j: int, confidence: float) -> Interval:
        count = int(self.moments.count[row, i, j])
        if not count:
            return Interval(float("nan"), float("nan"), float("nan"))
        mean = float(self.moments.mean[row, i, j])
        width = half_width(float(self.moments.square[row, i, j]), count, confidence)
        return Interval(mean, mean - width, mean + width)

    def _percent(self, row: int, i: int, j: int, confidence: float) -> Interval:
        """By how many percent the mean of filter i is off that of filter j."""
        counts = self.moments.count[row]
        count, base = int(counts[i, j]), float(self.moments.mean[row, j, j])
        # The covariance of i and j follows from their difference only where all three are of the same runs.
        if not base or not counts[i, i] == counts[j, j] == count:
            return Interval(float("nan"), float("nan"), float("nan"))
        shift = float(self.moments.mean[row, i, j])
        ratio = 1 + shift / base
        of_i, of_j, of_both = (float(self.moments.square[row, a, b]) for a, b in ((i, i), (j, j), (i, j)))
        # Of i - ratio j, with 2 cov = i + j - (i - j); rounding may leave it a little below zero.
        square = max((1 - ratio) * (of_i - ratio * of_j) + ratio * of_both, 0.0)
        return percent_interval(shift, base, square, count, confidence)


@dataclass(frozen=True, slots=True)
class MonteCarlo:
    """Filters compared over seeds: the run with number k has the seed of the experiments plus k.

    Attributes:
        experiments: 1 to 7, which differ in their filter alone.
        runs: 2 to 1,000,000.

    Raises:
        InputError: for what does not fit together, takes too long, or leaves nothing to chance.
    """

    experiments: tuple[Experiment, ...]
    runs: int

    def __post_init__(self) -> None:
        FILTERS.check("experiments", len(self.experiments))
        RUNS.check("runs", self.runs)
        first = self.experiments[0]
        for other in self.experiments[1:]:
            for name in SEEN:
                if getattr(other, name) != getattr(first, name):
                    raise InputError(name, "must be the same for all filters", getattr(other, name))
        if first.target.measured:
            raise InputError("runs", "must not be asked for of a recording: it cannot be run again", self.runs)
        if not has_chance(first):
            raise InputError("noise", "must leave something to chance: every run would be the same", first.noise)
        SEED.check("seed", first.seed + self.runs - 1)
        check_steps("runs", self.runs, self._steps(self.runs))

    def _steps(self, runs: int) -> int:
        first = self.experiments[0]
        weights = sum(map(_weight, self.experiments))
        drawn = steps_of(first) * VALUE_STEPS + steps_of(first) // first.samples * STREAM_STEPS
        return runs * (weights * steps_of(first) + drawn)

    def stream(self, executor: Executor | None = None) -> Iterator[Progress[Comparison]]:
        """The comparison as it grows; closing the iterator ends the work."""
        together = max(1, min(1_000, BLOCK_STEPS // self._steps(1)))
        first = self.experiments[0].seed
        tasks = (range(first + at, first + min(at + together, self.runs)) for at in range(0, self.runs, together))
        so_far, stopped, runs = None, np.zeros(len(self.experiments), dtype=int), 0
        for found, halted, count in ordered(executor, partial(_compared, self.experiments), tasks):
            so_far = found if so_far is None else so_far.merged(found)
            stopped, runs = stopped + halted, runs + count
            comparison = Comparison(len(self.experiments), runs, stopped, so_far)
            yield Progress(self._steps(runs), self._steps(self.runs), comparison)


def _weight(experiment: Experiment) -> int:
    """How many filters side by side take as long."""
    if experiment.method is not None:
        return METHOD_STEPS
    return 1 if experiment.gate is None else GATE_STEPS


def _compared(experiments: tuple[Experiment, ...], seeds: range) -> tuple[Moments, IntArray, int]:
    """Moments over some runs, and how often every filter was stopped."""
    values = figures_of(experiments, seeds)
    return Moments.of(values), np.isnan(values).all(axis=2).sum(axis=0), len(seeds)


def figures_of(experiments: tuple[Experiment, ...], seeds: range) -> FloatArray:
    """FIGURES of every filter in every run, shape (runs, filters, figures); NaN where it was stopped."""
    values = np.full((len(seeds), len(experiments), len(FIGURES)), np.nan)
    constant = [number for number, experiment in enumerate(experiments) if experiment.method is None]
    raw = observation_rmse(observe_runs(experiments[0], seeds)) if constant else np.empty(0)
    for numbers in _together(experiments, constant):
        vectors = [experiments[number].gains().vector for number in numbers]
        errors = run_errors(experiments[numbers[0]], seeds, vectors, figures=HOWS, kinds=KINDS)
        for column, name in enumerate(_ERRORS):
            group, _, how = name.partition("_")
            values[:, numbers, column] = getattr(errors[group], how).T
        with np.errstate(divide="ignore", invalid="ignore"):
            reduction = 100 * (1 - errors["estimation"].rmse.T / raw[:, None])
        values[:, numbers, -1] = np.where(raw[:, None] > 0, reduction, np.nan)
    for number, experiment in enumerate(experiments):
        if experiment.method is not None:
            values[:, number] = [_of_method(replace(experiment, seed=seed)) for seed in seeds]
    return values


def _together(experiments: tuple[Experiment, ...], constant: list[int]) -> list[list[int]]:
    """Numbers of the filters that start alike and believe alike: with a gate each what it believes itself."""
    groups: dict[tuple[str, int | None], list[int]] = {}
    for number in constant:
        experiment = experiments[number]
        groups.setdefault((experiment.start, None if experiment.gate is None else number), []).append(number)
    return list(groups.values())


def _of_method(experiment: Experiment) -> list[float]:
    result = run_experiment(experiment, remember=False)
    if result.track.stopped_at is not None:
        return [float("nan")] * len(FIGURES)
    found = (getattr(result.metrics, name) for name in FIGURES)
    return [float("nan") if value is None else value for value in found]
