"""What all studies have in common: the bounds, and how far one has come."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from tracker_core.checks import Domain, InputError
from tracker_core.experiment import Experiment

OutcomeT = TypeVar("OutcomeT")

MOST_STEPS = 10**11
"""Filter steps (one sample of one axis by one filter) that a study may take: some minutes on one processor."""

MOST_SCORES = 5_000_000
"""Scores, one per run and filter, that a study keeps."""

BLOCK_STEPS = 10_000_000
"""Filter steps after which a part of a study ends: some hundredths of a second."""

UNEVEN = 5
"""Steps side by side that take as long as one where filters run one after the other: see `batch.errors_of_runs`."""

WEIGHT = Domain(0, 1)


@dataclass(frozen=True, slots=True)
class Progress(Generic[OutcomeT]):
    """How far a study has come.

    Attributes:
        done, of: filter steps; they are equal once it has ended.
        outcome: what is known so far.
    """

    done: int
    of: int
    outcome: OutcomeT


def steps_of(experiment: Experiment) -> int:
    """Filter steps of one run of one filter; those that take longer count as several."""
    recording, steps = experiment.target.recording, experiment.samples * len(experiment.target.axes)
    if not experiment.target.measured or recording is None:
        return steps
    truth = None if recording.truth is None else np.isnan(recording.truth[: experiment.samples])
    partly = truth is not None and truth.any() and not truth.all()
    return steps * UNEVEN if partly or recording.times is not None else steps


def check_steps(field: str, value: object, steps: int) -> int:
    """The steps of a study, if they are not too many.

    Raises:
        InputError: naming the field that makes it large.
    """
    if steps > MOST_STEPS:
        rule = f"must be so small that no more than {MOST_STEPS:,} filter steps are taken; these are {steps:,}"
        raise InputError(field, rule, value)
    return steps


def check_scores(field: str, value: object, scores: int) -> None:
    """Refuse a study that would keep too many scores.

    Raises:
        InputError: naming the field that makes it large.
    """
    if scores > MOST_SCORES:
        rule = f"must be so small that no more than {MOST_SCORES:,} scores are kept; these are {scores:,}"
        raise InputError(field, rule, value)


def has_chance(experiment: Experiment) -> bool:
    """Whether another seed gives another run."""
    std = experiment.noise_std
    drawn = experiment.noise not in ("none", "recorded") and (std is None or any(std))
    return drawn or bool(experiment.manoeuvre_std) or experiment.target.random


def knows_truth(experiment: Experiment) -> bool:
    """Whether anybody knows where the target was at any sample."""
    scenario = experiment.target
    if not scenario.measured:
        return True
    truth = None if scenario.recording is None else scenario.recording.truth
    return truth is not None and not bool(np.isnan(truth[: experiment.samples]).all())
