"""Scores of many filters in many runs: what takes the time of a study, in parts that any executor can share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from tracker_core.batch import Errors, Runs, errors_of_runs
from tracker_core.experiment import Experiment
from tracker_core.measured import File, deliver, parcel
from tracker_core.responses import lag_coefficient, noise_gain
from tracker_core.run import believed_runs, known_states, observe, strength_of
from tracker_core.stability import stable
from tracker_core.tuning.base import BLOCK_STEPS, has_chance, steps_of
from tracker_core.tuning.executors import ordered
from tracker_core.tuning.objectives import NOISE_LAG, OBJECTIVES
from tracker_core.types import FloatArray

LANES = 64
"""Filters of a part are a multiple of this, as far as there are as many."""

_REMEMBERED_VALUES = 500_000
"""Measured values of runs that are remembered, 4 MB."""


@dataclass(frozen=True, slots=True)
class Part:
    """A piece of the work: seeds of the runs, and the filters, from `first` up to `last`."""

    seeds: tuple[int, ...]
    first: int
    last: int


def parts_of(experiment: Experiment, runs: int, filters: int) -> list[Part]:
    """The work of a study in pieces, one run after the other; they depend on the study alone."""
    steps = steps_of(experiment)
    fit = max(1, BLOCK_STEPS // steps)
    seeds = [experiment.seed + run for run in range(runs)]
    if fit >= filters:
        together = max(1, fit // max(1, filters))
        return [Part(tuple(seeds[at : at + together]), 0, filters) for at in range(0, runs, together)]
    width = max(LANES, fit // LANES * LANES)
    return [Part((seed,), first, min(first + width, filters)) for seed in seeds for first in range(0, filters, width)]


def scored(
    experiment: Experiment,
    vectors: FloatArray,
    objectives: Sequence[str],
    runs: int,
    weight: float,
    executor: Executor | None,
) -> Iterator[tuple[int, int, FloatArray]]:
    """The scores of every filter in every run, as they come.

    Args:
        experiment: the runs: its target, sensor, start, and its seed and the ones after it.
        vectors: normalised gains, shape (p, order).
        objectives: names in OBJECTIVES.
        runs: how many; one where nothing is left to chance.
        weight: of the noise in NOISE_LAG.
        executor: as for `executors.ordered`.

    Yields:
        Runs that are complete, filter steps done, and the scores, shape (objectives, runs, p), NaN where a run
        stopped or has not been computed: always the same array, of which the complete runs do not change any more.
    """
    scores = np.full((len(objectives), runs, len(vectors)), np.nan)
    for row, name in enumerate(objectives):
        if name == NOISE_LAG:
            scores[row] = noise_against_lag(experiment, vectors, weight)
    run_names = [name for name in objectives if name != NOISE_LAG]
    if not run_names:
        yield runs, runs * len(vectors) * steps_of(experiment), scores
        return
    rows = [objectives.index(name) for name in run_names]
    steps, done = steps_of(experiment), 0
    parts = parts_of(experiment, runs, len(vectors))
    tasks = ((part.seeds, vectors[part.first : part.last]) for part in parts)
    # A worker of a cluster need not have the file of a recording.
    work = partial(_scores_of, parcel(experiment.data), experiment, tuple(run_names))
    for part, found in zip(parts, ordered(executor, work, tasks), strict=True):
        first = part.seeds[0] - experiment.seed
        scores[rows, first : first + len(part.seeds), part.first : part.last] = found
        done += len(part.seeds) * (part.last - part.first) * steps
        yield done // (len(vectors) * steps), done, scores


def _scores_of(
    file: File | None,
    experiment: Experiment,
    objectives: tuple[str, ...],
    task: tuple[tuple[int, ...], FloatArray],
) -> FloatArray:
    """Shape (objectives, runs, filters)."""
    deliver(experiment.data, file)
    seeds, vectors = task
    wanted = [OBJECTIVES[name] for name in objectives]
    errors = run_errors(
        experiment,
        seeds,
        vectors,
        figures=tuple(dict.fromkeys(o.how for o in wanted)),
        kinds=tuple(dict.fromkeys(o.kind for o in wanted)),
    )
    return np.array([objective.of(errors).T for objective in wanted])


def run_errors(
    experiment: Experiment,
    seeds: Sequence[int],
    vectors: FloatArray | Sequence[FloatArray],
    *,
    figures: tuple[str, ...],
    kinds: tuple[str, ...],
) -> dict[str, Errors]:
    """Errors of gain sets, of one order or of several, in the runs with these seeds: arrays of shape (p, runs).

    All see the same measurements: those that the experiment's own filter believes, if it has a gate.
    """
    # What is looked at again and again, as in a search, is drawn once.
    small = len(seeds) * steps_of(experiment) <= _REMEMBERED_VALUES
    return errors_of_runs(
        _remembered(experiment, tuple(seeds)) if small else believed_runs(experiment, seeds),
        vectors,
        start=experiment.start,
        initial_state=known_states(experiment, seeds, max(map(len, vectors))),
        figures=figures,
        kinds=kinds,
    )


@lru_cache(maxsize=8)
def _remembered(experiment: Experiment, seeds: tuple[int, ...]) -> Runs:
    return believed_runs(experiment, seeds)


def noise_against_lag(experiment: Experiment, vectors: FloatArray, weight: float) -> FloatArray:
    """√(w σ²V + (1 − w) L²) of every gain set, m, shape (p,); infinite for unstable gains.

    V is the variance of the smoothed position per variance of white measurement noise, σ² that variance over all axes;
    L the steady lag under a manoeuvre as strong as the target's over all axes: see `run.strength_of`.

    Args:
        experiment: target, sensor, order and seed; with coloured noise its variance is taken as if it were white.
        vectors: normalised gains of that order, shape (p, order).
        weight: w, 0 to 1.
    """
    _, _, std = observe(experiment)
    lag = lag_coefficient(vectors) * experiment.interval**experiment.order * strength_of(experiment)
    with np.errstate(invalid="ignore"):
        score = np.sqrt(weight * sum(sigma**2 for sigma in std) * noise_gain(vectors) + (1 - weight) * lag**2)
    return np.where(stable(vectors), score, np.inf)


def effective_runs(experiment: Experiment, objective: str, runs: int) -> int:
    """How many runs tell more than one: all, or one where nothing is left to chance."""
    return runs if objective != NOISE_LAG and has_chance(experiment) else 1
