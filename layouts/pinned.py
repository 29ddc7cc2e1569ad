"""Pinned filters as they run on the present target and sensor."""

from __future__ import annotations

from functools import lru_cache

from layouts.state import Settings
from tracker_core import Experiment, InputError, Metrics, run_experiment
from tracker_core.merits import merits


def last_pinned(settings: Settings) -> Experiment | None:
    """The present run with the filter that was pinned last; None without one, or where it does not fit."""
    try:
        return settings.pins[-1].on(settings.experiment) if settings.pins else None
    except InputError:
        return None


@lru_cache(maxsize=256)
def metrics_of(experiment: Experiment) -> Metrics | None:
    """How good a run is; None if it was stopped."""
    result = run_experiment(experiment)
    return result.metrics if result.track.stopped_at is None else None


@lru_cache(maxsize=256)
def merits_of(experiment: Experiment) -> dict[str, float | None]:
    """What its gains buy."""
    return merits(run_experiment(experiment).gains, experiment.interval)
