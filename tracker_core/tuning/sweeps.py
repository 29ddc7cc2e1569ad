"""One number of a filter varied: how well it does at every value, in every run."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from math import exp, inf, isfinite, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracker_core.checks import POSITIVE, Domain, InputError, check_choice
from tracker_core.conventions import rewrite
from tracker_core.design import DESIGNS, MANUAL
from tracker_core.design.steady_kalman import time_power, tracking_index_of
from tracker_core.experiment import PARAMETERS as DESIGN_PARAMETERS
from tracker_core.experiment import Experiment
from tracker_core.fields import SEED
from tracker_core.region import BOX, gain_interval
from tracker_core.stability import stable
from tracker_core.statistics import Interval, least_places, mean_interval, percent_more, place_interval
from tracker_core.tuning.base import WEIGHT, Progress, check_scores, check_steps, steps_of
from tracker_core.tuning.evaluate import effective_runs, scored
from tracker_core.tuning.objectives import check_objective
from tracker_core.types import GAIN_NAMES, FloatArray

RUNS = Domain(1, 10_000, whole=True)
POINTS = Domain(2, 1_001, whole=True)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that can be varied.

    Attributes:
        name: key in the registry.
        symbol, title, unit: for menus and axes.
        sets: the field of the experiment that follows from it.
        logarithmic: whether it is varied by factors.
        span: what is looked at where nothing else is said; a gain's follows from the stable region.
        unit_of_jerk: the unit for filters that take the target for one of random jerk, where it is another.
    """

    name: str
    symbol: str
    title: str
    unit: str
    sets: str
    logarithmic: bool = False
    span: tuple[float, float] = (0.0, 1.0)
    unit_of_jerk: str | None = None

    def unit_at(self, order: int) -> str:
        """The unit for a filter of that order."""
        return self.unit if self.unit_of_jerk is None or time_power(order) < 3 else self.unit_of_jerk


PARAMETERS: dict[str, Parameter] = {
    parameter.name: parameter
    for parameter in (
        Parameter("alpha", "α", "Position gain", "", "alpha"),
        Parameter("beta", "β", "Velocity gain", "", "beta"),
        Parameter("gamma", "γ", "Acceleration gain", "", "gamma"),
        Parameter("eta", "η", "Jerk gain", "", "eta"),
        Parameter("xi", "ξ", "Fading factor", "", "xi", span=(0.0, 0.99)),
        Parameter("tracking_index", "Λ", "Tracking index", "", "tracking_index", True, (1e-4, 100.0)),
        Parameter(
            "process_variance",
            "σ_w²",
            "Process variance, σ_v² = 1 m²",
            "m²/s⁴",
            "tracking_index",
            True,
            (1e-8, 1e4),
            "m²/s⁶",
        ),
        Parameter(
            "sensor_variance", "σ_v²", "Sensor variance, σ_w² as it is", "m²", "tracking_index", True, (1e-4, 1e8)
        ),
    )
}
"""What can be varied. The gains depend on the two variances through Λ = T² √(σ_w²/σ_v²) alone, at order 4 through
T³ √(σ_w²/σ_v²)."""


def varied(experiment: Experiment, parameter: str, value: float) -> Experiment:
    """The experiment with one number changed.

    A gain that the design does not take is changed by hand, the others kept; a number of another design, ξ say, brings
    the design that is made from it.

    Args:
        experiment: one with constant gains, or of a method where the number brings a design.
        parameter: a name in PARAMETERS. Variances are those at which the other one is fixed: the sensor's at 1, the
            process's at (Λ/T²)², for order 4 (Λ/T³)², with the experiment's Λ, or with Λ = 1 where it has none.
        value: of it; gains in the convention of the experiment.

    Raises:
        InputError: for an unknown parameter, one that the order does not have, or a value outside its domain.
    """
    field = PARAMETERS[check_choice("parameter", parameter, PARAMETERS)].sets
    if parameter == "process_variance":
        process_std = sqrt(POSITIVE.check(parameter, value))
        value = tracking_index_of(experiment.order, process_std, 1.0, experiment.interval)
    elif parameter == "sensor_variance":
        value = (experiment.tracking_index or 1.0) / sqrt(POSITIVE.check(parameter, value))
    change: dict[str, Any] = {field: value}
    return replace(_prepared(experiment, parameter, field), **change)


def _prepared(experiment: Experiment, parameter: str, field: str) -> Experiment:
    """The experiment with a design, or gains by hand, of which the field is one."""
    if experiment.design in DESIGNS and field in DESIGNS[experiment.design].parameters:
        return experiment
    if field in GAIN_NAMES:
        names = GAIN_NAMES[: experiment.order]
        if field not in names:
            raise InputError("parameter", f"must be a gain of order {experiment.order}", parameter)
        if experiment.method is not None:
            raise InputError("parameter", "must not be a gain: the method chooses them as it runs", parameter)
        held = dict(zip(names, experiment.gains().values, strict=True))
        return _rebuilt(experiment, {"design": MANUAL, **held})
    return _rebuilt(experiment, {field: 0.5 if field == "xi" else 1.0})


def _rebuilt(experiment: Experiment, filter_values: dict[str, Any]) -> Experiment:
    """The same target, sensor, order and start with another filter."""
    kept = {
        name: value
        for name, value in experiment.to_dict().items()
        if name not in DESIGN_PARAMETERS and name not in experiment.parameters() and name != "design"
    }
    return Experiment.from_dict(kept | filter_values)


def offered(experiment: Experiment) -> tuple[str, ...]:
    """The parameters that can be varied in an experiment."""
    gains = () if experiment.method is not None else GAIN_NAMES[: experiment.order]
    return tuple(name for name in PARAMETERS if name in gains or name not in GAIN_NAMES)


def usual_values(
    experiment: Experiment, parameter: str, low: float | None = None, high: float | None = None, points: int = 101
) -> tuple[float, ...]:
    """Values to look at: evenly spaced, or by equal factors.

    Args:
        experiment: as for `varied`.
        parameter: a name in PARAMETERS.
        low, high: the first and the last one; None for the end of what makes sense, inside which they then lie.
        points: how many.

    Raises:
        InputError: for an unknown parameter, ends that are not in order, or a number of points out of range.
    """
    what = PARAMETERS[check_choice("parameter", parameter, PARAMETERS)]
    points = int(POINTS.check("points", points))
    ends = _span(experiment, what)
    first, last = ends[0] if low is None else low, ends[1] if high is None else high
    if not first < last:
        # The end that was given is the one to be mended.
        if high is None:
            raise InputError("low", f"must be < {last:g}", low)
        raise InputError("high", f"must be > {first:g}", high)
    if what.logarithmic:
        POSITIVE.check("low", first)
        return tuple(float(value) for value in np.geomspace(first, last, points))
    # An end of the stable region is not stable itself.
    inner = np.linspace(0, 1, points)
    open_low, open_high = low is None and parameter in GAIN_NAMES, high is None and parameter in GAIN_NAMES
    step = 1 / points / 2
    inner = step * open_low + inner * (1 - step * open_low - step * open_high)
    return tuple(float(first + (last - first) * share) for share in inner)


def _span(experiment: Experiment, parameter: Parameter) -> tuple[float, float]:
    if parameter.name not in GAIN_NAMES:
        return parameter.span
    design = DESIGNS.get(experiment.design)
    if design is not None and parameter.name in design.parameters:
        domain = design.parameters[parameter.name]
        return max(0.0, domain.low), min(2.0, domain.high)
    index = GAIN_NAMES.index(parameter.name)
    if index >= experiment.order:
        raise InputError("parameter", f"must be a gain of order {experiment.order}", parameter.name)
    gains = experiment.gains()
    low, high = (float(end) for end in gain_interval(gains.vector, index))
    if not low < high:
        low, high = 0.0, BOX[experiment.order][index]
    convention = gains.convention
    return rewrite(low, index, "normalised", convention), rewrite(high, index, "normalised", convention)


@dataclass(frozen=True, slots=True)
class Optimum:
    """The best value of a parameter.

    Attributes:
        value: where the mean score is least; NaN where no value has one.
        low, high: between which it lies with 95 % (runs drawn anew from themselves); NaN for a single run.
        score: the mean score at the nearest value looked at, with its 95 % interval, m.
        index: of that value.
        at_edge: whether it is the first or the last one looked at.
    """

    value: float
    low: float
    high: float
    score: Interval
    index: int
    at_edge: bool


@dataclass(frozen=True, slots=True)
class SweepOutcome:
    """What a sweep has come to.

    Attributes:
        sweep: what was asked.
        gains: normalised, shape (p, order).
        stable: per value whether its gains are, shape (p,).
        scores: shape (objectives, runs, p), m; NaN where a run stopped.
        runs: complete ones.
    """

    sweep: Sweep
    gains: FloatArray
    stable: NDArray[np.bool_]
    scores: FloatArray
    runs: int

    def mean(self, row: int = 0) -> tuple[FloatArray, FloatArray]:
        """Mean score per value and the half width of its 95 % interval, each of shape (p,)."""
        return mean_interval(self.scores[row])

    def optimum(self, row: int = 0) -> Optimum:
        """The best of the values whose gains are stable, for one of the objectives."""
        values = np.array(self.sweep.values)
        scores = np.where(self.stable, self.scores[row], np.inf)
        logarithmic = PARAMETERS[self.sweep.parameter].logarithmic
        near = np.log(values) if logarithmic else values
        place, again = least_places(near, scores)
        if not isfinite(place):
            nothing = float("nan")
            return Optimum(nothing, nothing, nothing, Interval(nothing, nothing, nothing), 0, at_edge=False)
        ends = place_interval(place, again, len(scores))
        # The widened interval of few runs may leave what was looked at.
        low, high = (min(max(end, near[0]), near[-1]) for end in ends)
        back = exp if logarithmic else float
        index = int(np.nanargmin(np.where(np.isfinite(scores).all(axis=0), scores.mean(axis=0), inf)))
        mean, width = mean_interval(scores[:, index])
        interval = Interval(float(mean), float(mean - width), float(mean + width))
        return Optimum(back(place), back(low), back(high), interval, index, at_edge=index in (0, len(values) - 1))

    def cost(self, chosen: int, judge: int) -> Interval:
        """By how much one objective is worse where another is best, percent of its own best, with its 95 % interval.

        NaN where the own best is zero.

        Args:
            chosen: number of the objective whose best value is taken.
            judge: number of the objective that is looked at.
        """
        taken, best = self.optimum(chosen).index, self.optimum(judge).index
        return percent_more(self.scores[judge][:, taken], self.scores[judge][:, best])


@dataclass(frozen=True, slots=True)
class Sweep:
    """A parameter varied.

    Attributes:
        experiment: what is run, with its seed and the ones after it; what its own filter's gate refuses is left out.
        parameter: a name in PARAMETERS that it offers.
        values: of it, increasing, 2 to 1,001.
        objective: a name in OBJECTIVES; where nobody knows the truth, one of the innovation.
        runs: 1 to 10,000; one is enough, and taken, where nothing is left to chance.
        weight: of the noise in the objective that weighs it against the lag.
        beside: other objectives that are to be known as well.

    Raises:
        InputError: for what does not fit together, or takes too long.
    """

    experiment: Experiment
    parameter: str
    values: tuple[float, ...]
    objective: str
    runs: int = 20
    weight: float = 0.5
    beside: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_choice("parameter", self.parameter, offered(self.experiment))
        for name in self.objectives:
            check_objective(name, self.experiment)
        RUNS.check("runs", self.runs)
        SEED.check("seed", self.experiment.seed + self.runs - 1)
        WEIGHT.check("weight", self.weight)
        POINTS.check("values", len(self.values))
        if any(not a < b for a, b in zip(self.values, self.values[1:], strict=False)):
            raise InputError("values", "must increase", list(self.values))
        for value in (self.values[0], self.values[-1]):
            self.at(value)
        check_scores("runs", self.runs, self.runs * len(self.values) * len(self.objectives))
        check_steps("runs", self.runs, self.runs * len(self.values) * steps_of(self.experiment))

    @property
    def objectives(self) -> tuple[str, ...]:
        """All that is looked at; the first is tuned for."""
        return (self.objective, *self.beside)

    def at(self, value: float) -> Experiment:
        """The experiment at a value of the parameter."""
        return varied(self.experiment, self.parameter, value)

    def vectors(self) -> FloatArray:
        """Normalised gains at every value, shape (p, order)."""
        return np.array([self.at(value).gains().vector for value in self.values])

    def stream(self, executor: Executor | None = None) -> Iterator[Progress[SweepOutcome]]:
        """The outcome as it grows, run by run; closing the iterator ends the work."""
        vectors = self.vectors()
        runs = effective_runs(self.experiment, self.objective, self.runs)
        total = runs * len(vectors) * steps_of(self.experiment)
        are_stable = stable(vectors)
        for complete, done, scores in scored(self.experiment, vectors, self.objectives, runs, self.weight, executor):
            outcome = SweepOutcome(self, vectors, are_stable, scores[:, : max(1, complete)], complete)
            yield Progress(done, total, outcome)
