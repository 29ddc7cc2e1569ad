"""All gains of an order at once: the best constant gains there are for an objective, and what the designs make of it.

The search takes place where every point is a stable filter (see `reflections`), from many starts (see `islands`): the
best values of the designs, and places around their curves. It knows the runs that it is judged by; so does every rival.
What its gains are worth is therefore told by as many runs again that nothing was chosen by.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from tracker_core.checks import Domain, InputError
from tracker_core.conventions import Gains
from tracker_core.design.curves import curve_designs, design_curve
from tracker_core.experiment import Experiment
from tracker_core.fields import SEED
from tracker_core.reflections import gains_at, place_of
from tracker_core.stability import stable
from tracker_core.statistics import Interval, mean_interval, percent_more
from tracker_core.tuning.base import MOST_STEPS, WEIGHT, Progress, check_steps, has_chance, steps_of
from tracker_core.tuning.evaluate import effective_runs, scored
from tracker_core.tuning.islands import EDGE, POPULATION, Islands
from tracker_core.tuning.objectives import NOISE_LAG, check_objective
from tracker_core.tuning.rivals import POINTS, Rival, best_of_designs
from tracker_core.types import FloatArray

RUNS = Domain(1, 1_000, whole=True)
BUDGET = Domain(2_000, 200_000, whole=True)

MOST_ISLANDS = 64
_ISLAND_SETS = 450
"""Gain sets that an island takes on average, with those that meet another one's place early."""

_SCATTERED, _JITTER, _APART = 1 / 15, 1.5, 0.7
"""Share of the budget that looks for starts, how far they are from the designs' curves, and from each other."""


@dataclass(frozen=True, slots=True)
class Fresh:
    """Found gains and rivals in runs that nothing was chosen by.

    Attributes:
        runs: how many.
        score: the found gains' mean with its 95 % interval, m.
        rivals: the same of every rival.
        differences: every rival minus the found gains, run by run, mean with its 95 % interval, m.
        percents: the same in percent of the found gains' mean, which is itself uncertain.
    """

    runs: int
    score: Interval
    rivals: tuple[Interval, ...]
    differences: tuple[Interval, ...]
    percents: tuple[Interval, ...]

    def worse(self, rival: int) -> bool:
        """Whether a rival is worse by more than chance."""
        return self.differences[rival].low > 0


@dataclass(frozen=True, slots=True)
class SearchOutcome:
    """What a search has come to.

    Attributes:
        search: what was asked.
        gains: the best so far, in the convention of the experiment; None before the first are known.
        score: their mean over the runs, m; infinite before.
        history: best score after every generation so far, m.
        tried: gain sets so far, the rivals' among them.
        rivals: every design of the order at its best, in the order of the registry; empty before they are known.
        fresh: found gains and rivals in fresh runs, at the end; None before, and where nothing is left to chance.
    """

    search: Search
    gains: Gains | None
    score: float
    history: tuple[float, ...]
    tried: int
    rivals: tuple[Rival, ...]
    fresh: Fresh | None

    @property
    def best_rival(self) -> int | None:
        """Number of the rival with the least score; None while there is none."""
        scores = [rival.score for rival in self.rivals]
        return scores.index(min(scores)) if scores else None

    @property
    def kalman(self) -> int | None:
        """Number of the steady-state Kalman filter among the rivals."""
        return next((number for number, rival in enumerate(self.rivals) if rival.is_kalman), None)


@dataclass(frozen=True, slots=True)
class Search:
    """The search for the best constant gains of an order.

    Attributes:
        experiment: target, sensor, start, order, and the seed and the ones after it; its own gains do not matter, but
            where it has a gate: what that refuses with them is left out.
        objective: a name in OBJECTIVES; where nobody knows the truth, one of the innovation.
        runs: 1 to 1,000, as many again for the comparison; one is taken where nothing is left to chance.
        weight: of the noise in the objective that weighs it against the lag.
        budget: gain sets that are tried at most, 2,000 to 200,000.

    Raises:
        InputError: for what does not fit together, or takes too long.
    """

    experiment: Experiment
    objective: str
    runs: int = 20
    weight: float = 0.5
    budget: int = 30_000

    def __post_init__(self) -> None:
        check_objective(self.objective, self.experiment)
        RUNS.check("runs", self.runs)
        WEIGHT.check("weight", self.weight)
        BUDGET.check("budget", self.budget)
        SEED.check("seed", self.experiment.seed + 2 * self.runs - 1)
        each = steps_of(self.experiment) * (self.budget + len(curve_designs(self.experiment.order)) + 1)
        if each > MOST_STEPS and self.objective != NOISE_LAG:
            most = MOST_STEPS // (each // self.experiment.samples)
            raise InputError("samples", f"must be <= {most:,} for {self.budget:,} gain sets", self.experiment.samples)
        check_steps("runs", self.runs, self.steps)

    @property
    def drawn(self) -> int:
        """Runs that every gain set is tried in."""
        return effective_runs(self.experiment, self.objective, self.runs)

    @property
    def compared(self) -> bool:
        """Whether there are fresh runs to compare in."""
        return self.objective != NOISE_LAG and has_chance(self.experiment)

    @property
    def steps(self) -> int:
        """Filter steps that are taken at most."""
        fresh = len(curve_designs(self.experiment.order)) + 1 if self.compared else 0
        return self.drawn * steps_of(self.experiment) * (self.budget + fresh)

    def stream(self, executor: Executor | None = None) -> Iterator[Progress[SearchOutcome]]:
        """The outcome as it grows, generation by generation; closing the iterator ends the work."""
        yield from _Work(self, executor).stream()


class _Work:
    """A search under way."""

    def __init__(self, search: Search, executor: Executor | None) -> None:
        self.search, self.executor = search, executor
        self.order = search.experiment.order
        self.done = self.tried = 0
        self.vector: FloatArray | None = None
        self.score = np.inf
        self.history: list[float] = []
        self.rivals: tuple[Rival, ...] = ()
        self.fresh: Fresh | None = None

    def stream(self) -> Iterator[Progress[SearchOutcome]]:
        self.rivals = yield from best_of_designs(self.order, self.scores)
        islands = Islands((yield from self.starts()))
        while islands and self.tried + len(islands) * POPULATION <= self.search.budget:
            islands.tell((yield from self.scores(gains_at(islands.ask()))))
            self.history.append(self.score)
            yield self.progress()
        if self.search.compared and self.vector is not None:
            self.fresh = yield from self.comparison(self.vector)
        yield self.progress(ended=True)

    def progress(self, *, ended: bool = False) -> Progress[SearchOutcome]:
        convention = self.search.experiment.convention
        gains = None if self.vector is None else Gains.normalised(self.vector).to(convention)
        history = tuple(self.history)
        outcome = SearchOutcome(self.search, gains, self.score, history, self.tried, self.rivals, self.fresh)
        return Progress(self.done, self.done if ended else self.search.steps, outcome)

    def scores(self, vectors: FloatArray) -> Generator[Progress[SearchOutcome], None, FloatArray]:
        """Mean scores, shape (p,), infinite where a run stopped; remembers the best that is stable."""
        search = self.search
        every = yield from self.every_score(search.experiment, vectors)
        mean = every.mean(axis=0)
        usable = np.where(np.isfinite(mean) & stable(vectors), mean, np.inf)
        self.tried += len(vectors)
        best = int(np.argmin(usable))
        if usable[best] < self.score:
            self.score, self.vector = float(usable[best]), vectors[best]
        return usable

    def every_score(
        self, experiment: Experiment, vectors: FloatArray
    ) -> Generator[Progress[SearchOutcome], None, FloatArray]:
        """Scores of gains in every run from the experiment's seed on, shape (runs, p)."""
        search, before = self.search, self.done
        last = np.empty((1, 0, 0))
        for _, done, scores in scored(
            experiment, vectors, [search.objective], search.drawn, search.weight, self.executor
        ):
            self.done, last = before + done, scores
            yield self.progress()
        return last[0]

    def starts(self) -> Generator[Progress[SearchOutcome], None, FloatArray]:
        """Where the islands begin, shape (islands, order): the best of many places around the curves of the designs."""
        curves = np.concatenate([design_curve(name, self.order, POINTS) for name in curve_designs(self.order)])
        best = [np.array(rival.vector) for rival in self.rivals]
        places = np.array([place_of(Gains.normalised(vector)) for vector in [*best, *curves[stable(curves)]]])
        places = np.clip(places[np.isfinite(places).all(axis=1)], -EDGE, EDGE)
        draw = np.random.default_rng(0)
        around = places[draw.integers(len(places), size=int(self.search.budget * _SCATTERED))]
        around = np.clip(around + _JITTER * draw.standard_normal(around.shape), -EDGE, EDGE)
        candidates = np.concatenate((places[: len(best)], around))
        found = yield from self.scores(gains_at(candidates))
        wanted = min(MOST_ISLANDS, max(4, self.search.budget // _ISLAND_SETS))
        chosen: list[FloatArray] = []
        for index in np.argsort(found, kind="stable"):
            if all(np.linalg.norm(candidates[index] - other) > _APART for other in chosen):
                chosen.append(candidates[index])
                if len(chosen) == wanted:
                    break
        return np.array(chosen)

    def comparison(self, found: FloatArray) -> Generator[Progress[SearchOutcome], None, Fresh]:
        """Found gains and rivals in the runs after those of the search."""
        search = self.search
        experiment = replace(search.experiment, seed=search.experiment.seed + search.drawn)
        vectors = np.array([found, *(rival.vector for rival in self.rivals)])
        scores = yield from self.every_score(experiment, vectors)
        own, *others = _intervals(scores)
        percents = tuple(percent_more(rival, scores[:, 0]) for rival in scores[:, 1:].T)
        return Fresh(len(scores), own, tuple(others), _intervals(scores[:, 1:] - scores[:, :1]), percents)


def _intervals(values: FloatArray) -> tuple[Interval, ...]:
    """Of every column."""
    pairs = zip(*mean_interval(values), strict=True)
    return tuple(Interval(float(mean), float(mean - width), float(mean + width)) for mean, width in pairs)
