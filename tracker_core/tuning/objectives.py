"""What a filter is tuned for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

from tracker_core.batch import KINDS, Errors
from tracker_core.checks import InputError, check_choice
from tracker_core.experiment import Experiment
from tracker_core.run import strength_of
from tracker_core.tuning.base import knows_truth
from tracker_core.types import STATE_NAMES, FloatArray

HOWS = ("rmse", "total", "max", "l2")

NOISE_LAG = "noise_lag"


@dataclass(frozen=True, slots=True)
class Objective:
    """A number that a filter should make small, m.

    Attributes:
        name: key in the registry.
        title: for menus and axes.
        sentence: what it is, plainly.
        kind: the error it is made from, of `batch.KINDS`; empty for the one that needs no runs.
        how: what is made of the errors of a run: "rmse", "total", "max" or "l2".
    """

    name: str
    title: str
    sentence: str
    kind: str = ""
    how: str = ""

    @property
    def needs_truth(self) -> bool:
        """Whether somebody must know where the target really was."""
        return self.kind != "innovation"

    def of(self, errors: Mapping[str, Errors]) -> FloatArray:
        """The objective of every run whose errors these are."""
        return getattr(errors[self.kind], self.how)


_TITLES = {"tracking": "Tracking", "estimation": "Estimation", "innovation": "Innovation"}
_BETWEEN = {
    "tracking": "predicted and true position",
    "estimation": "smoothed and true position",
    "innovation": "measured and predicted position",
}
_HOWS = {
    "rmse": ("{} RMSE", "Root mean square distance between {}."),
    "total": ("{} error, total", "Distances between {}, added up over the run."),
    "max": ("Worst case: greatest {} error", "The largest distance between {} in a run."),
    "l2": ("{} L2", "Euclidean norm of all distances between {} over their number, as Yu & Wu use it."),
}


def _errors(kind: str, how: str) -> Objective:
    title, sentence = _HOWS[how]
    noun = _TITLES[kind] if title.startswith("{") else _TITLES[kind].lower()
    name = title.format(noun).replace("Innovation error, total", "Innovation, total")
    name = name.replace("innovation error", "innovation")
    return Objective(f"{kind}_{how}", name, sentence.format(_BETWEEN[kind]), kind, how)


OBJECTIVES: dict[str, Objective] = {
    objective.name: objective
    for objective in (
        *(_errors(kind, how) for kind in KINDS for how in HOWS),
        Objective(
            NOISE_LAG,
            "Noise against lag, weighted",
            "√(w σ²V + (1 − w) L²): σ²V the variance that white noise leaves in the smoothed position, L its steady "
            "lag under a manoeuvre as strong as the target's, its random pushes among it; nothing is run.",
        ),
    )
}
"""What can be tuned for; all in metres, and the smaller the better."""

TRUTH, DERIVATIVE, STEADY, IMPULSIVE = (
    "must not need the truth: nobody knows where the target was",
    "must not need the {} of the target: nobody knows it",
    "must not weigh a lag that no filter has: the {} of the target is zero, and the smoother the better",
    "must not weigh a lag that has no size: the {} of the target comes in impulses",
)
"""Rules that an objective breaks which cannot be had."""


def objectives_of(experiment: Experiment) -> tuple[str, ...]:
    """What a filter can be tuned for in an experiment: without a truth the innovations alone."""
    return tuple(name for name in OBJECTIVES if not _broken(name, experiment))


def usual_objective(experiment: Experiment) -> str:
    """What a filter is tuned for where nobody says: the smoothed position, or else the innovation."""
    return "estimation_rmse" if knows_truth(experiment) else "innovation_rmse"


def check_objective(name: str, experiment: Experiment) -> str:
    """The name of an objective, if it can be had.

    Raises:
        InputError: for an unknown one, and for one that needs what nobody knows of the target.
    """
    rule = _broken(check_choice("objective", name, OBJECTIVES), experiment)
    if rule:
        raise InputError("objective", rule, name)
    return name


def _broken(name: str, experiment: Experiment) -> str:
    """The rule that an objective breaks; empty where it can be had."""
    if not OBJECTIVES[name].needs_truth:
        return ""
    if not knows_truth(experiment):
        return TRUTH
    if name == NOISE_LAG and experiment.target.known_states <= experiment.order:
        return DERIVATIVE.format(_DERIVATIVES[experiment.order])
    if name == NOISE_LAG and (rule := {0.0: STEADY, inf: IMPULSIVE}.get(strength_of(experiment))):
        return rule.format(_DERIVATIVES[experiment.order])
    return ""


_DERIVATIVES = (*STATE_NAMES, "snap")
