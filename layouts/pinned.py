"""Pinned filters as they run on the present target and sensor."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from layouts.comparing import PRESENT
from layouts.pins import Pin, filter_name, pin_of
from layouts.state import Settings
from layouts.text import error_text
from tracker_core import Experiment, InputError, Metrics, Result, run_experiment
from tracker_core.merits import merits
from tracker_core.run import CACHED_SAMPLES


@dataclass(frozen=True, slots=True)
class Candidate:
    """A filter that is compared with others.

    Attributes:
        slot: of the pin; PRESENT for the present filter.
        name: what it is called.
        experiment: its run; None where it does not fit the present target.
        reason: why it does not, in a sentence; else empty.
    """

    slot: int
    name: str
    experiment: Experiment | None
    reason: str = ""

    @property
    def key(self) -> str:
        """Which filter it is, whatever it is called; empty where it does not fit."""
        return "" if self.experiment is None else pin_of(self.slot, self.experiment).text()


def candidates(settings: Settings) -> tuple[Candidate, ...]:
    """The present filter, then the pinned ones by slot."""
    return _candidates(settings.experiment, settings.pins)


@lru_cache(maxsize=16)
def _candidates(present: Experiment, pins: tuple[Pin, ...]) -> tuple[Candidate, ...]:
    found = [Candidate(PRESENT, filter_name(present.filter_values()), present)]
    for pin in sorted(pins, key=lambda pin: pin.slot):
        try:
            found.append(Candidate(pin.slot, pin.name, pin.on(present)))
        except InputError as error:
            found.append(Candidate(pin.slot, pin.name, None, error_text(error)))
    return tuple(found)


def reference_of(settings: Settings) -> int:
    """Slot of the filter that the others are compared with: the chosen one, if it runs, else the present one."""
    chosen = settings.view.comparing.reference
    runs = {candidate.slot for candidate in candidates(settings) if candidate.experiment is not None}
    return chosen if chosen in runs else PRESENT


def last_pinned(settings: Settings) -> Experiment | None:
    """The present run with the filter that was pinned last; None without one, or where it does not fit."""
    try:
        return settings.pins[-1].on(settings.experiment) if settings.pins else None
    except InputError:
        return None


def pinned_runs(settings: Settings) -> list[tuple[Candidate, Result]]:
    """Every pinned filter that fits, by slot, with its run."""
    return [
        (candidate, result_of(candidate.experiment))
        for candidate in candidates(settings)[1:]
        if candidate.experiment is not None
    ]


def result_of(experiment: Experiment) -> Result:
    """The run of a pinned filter; short ones are remembered, since a slider moves none of them."""
    return _remembered(experiment) if experiment.samples <= CACHED_SAMPLES else run_experiment(experiment)


@lru_cache(maxsize=32)
def _remembered(experiment: Experiment) -> Result:
    return run_experiment(experiment)


@lru_cache(maxsize=256)
def metrics_of(experiment: Experiment) -> Metrics | None:
    """How good a run is; None if it was stopped."""
    result = result_of(experiment)
    return result.metrics if result.track.stopped_at is None else None


def errors_of(experiment: Experiment) -> dict[str, float | None] | None:
    """How good a run is, by name of the metric; None if it was stopped."""
    metrics = metrics_of(experiment)
    return None if metrics is None else metrics.to_dict()


@lru_cache(maxsize=256)
def evidence_of(experiment: Experiment) -> dict[str, float | None] | None:
    """What the innovations of a run say, by name; None if it was stopped."""
    result = result_of(experiment)
    return result.evidence().to_dict() if result.track.stopped_at is None else None


@lru_cache(maxsize=256)
def merits_of(experiment: Experiment) -> dict[str, float | None]:
    """What its gains buy."""
    return merits(result_of(experiment).gains, experiment.interval)
