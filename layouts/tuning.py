"""What the Tune page is asked for, as its controls and the link say it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

from layouts.entries import read_entries
from tracker_core import DESIGNS, Experiment, InputError
from tracker_core.checks import Domain, check_choice
from tracker_core.tuning import OBJECTIVES, PARAMETERS
from tracker_core.tuning.base import WEIGHT, has_chance, knows_truth
from tracker_core.tuning.maps import CELLS
from tracker_core.tuning.objectives import NOISE_LAG, objectives_of
from tracker_core.tuning.search import BUDGET
from tracker_core.tuning.sweeps import POINTS, RUNS, offered

STUDIES = {"sweep": "One parameter", "map": "Two gains", "search": "All gains"}
END = Domain(-1e9, 1e9)
_SWITCH = ("off", "on")


@dataclass(frozen=True, slots=True)
class Tuning:
    """What is varied, over what, and what for.

    Attributes:
        study: one of STUDIES.
        objective: what should be small, a name in OBJECTIVES; without a truth one of the innovation.
        against: the parameter of a sweep, a name in PARAMETERS; None for the one that the design is made from.
        low, high: ends of a sweep; None for the usual ones.
        points: values of a sweep.
        cells: of a map, along each side.
        budget: gain sets that a search tries at most.
        runs: with seeds of their own.
        weight: of the noise in the objective that weighs it against the lag.
        without_truth: whether only what a tracker sees may be tuned for; always where nobody knows more.
    """

    study: str = "sweep"
    objective: str = "estimation_rmse"
    against: str | None = None
    low: float | None = None
    high: float | None = None
    points: int = 101
    cells: int = 60
    budget: int = 30_000
    runs: int = 20
    weight: float = 0.5
    without_truth: bool = False

    def parameter(self, experiment: Experiment) -> str:
        """What a sweep varies: what was chosen, or where the filter has no such thing what it is made from."""
        if self.against is not None and self.against in offered(experiment):
            return self.against
        return own_parameter(experiment)

    def fitted(self, experiment: Experiment) -> Tuning:
        """The same as it can be meant here: without what goes without saying for this filter, or cannot be known."""
        goes_without_saying = self.against is not None and self.parameter(experiment) == own_parameter(experiment)
        fitted = replace(self, against=None) if goes_without_saying else self
        return fitted if knows_truth(experiment) else fitted.blind()

    def blind(self) -> Tuning:
        """The same without the truth: the same figure of the innovations."""
        objective = self.objective
        if OBJECTIVES[objective].needs_truth:
            objective = _of_kind("innovation", objective)
        return replace(self, objective=objective, without_truth=True)


TUNING_FIELDS = {
    "tune": "study",
    "tune_for": "objective",
    "against": "against",
    "from": "low",
    "to": "high",
    "points": "points",
    "cells": "cells",
    "budget": "budget",
    "tune_runs": "runs",
    "noise_weight": "weight",
    "without_truth": "without_truth",
}
"""The attribute that each control, and each field of the link, sets."""

_READERS: dict[str, Callable[[Any], Any]] = {
    "tune": lambda value: check_choice("tune", value, STUDIES),
    "tune_for": lambda value: check_choice("tune_for", value, OBJECTIVES),
    "against": lambda value: check_choice("against", value, PARAMETERS),
    "from": lambda value: END.check("from", value),
    "to": lambda value: END.check("to", value),
    "points": lambda value: int(POINTS.check("points", value)),
    "cells": lambda value: int(CELLS.check("cells", value)),
    "budget": lambda value: int(BUDGET.check("budget", value)),
    "tune_runs": lambda value: int(RUNS.check("tune_runs", value)),
    "noise_weight": lambda value: WEIGHT.check("noise_weight", value),
    "without_truth": lambda value: check_choice("without_truth", value, _SWITCH) == _SWITCH[True],
}


def own_parameter(experiment: Experiment) -> str:
    """The number that a filter is made from: its design's, the first gain where they are set by hand, else ξ."""
    if experiment.design in DESIGNS:
        return next(iter(DESIGNS[experiment.design].parameters))
    return "xi" if experiment.method is not None else "alpha"


def read_tuning(values: Mapping[str, Any]) -> tuple[Tuning, list[InputError]]:
    """What is asked for; nothing and empty texts are the default, what cannot be read is left there and reported."""
    read, errors = read_entries(_READERS, values)
    tuning = Tuning(**{TUNING_FIELDS[name]: value for name, value in read.items()})
    return tuning.blind() if tuning.without_truth else tuning, errors


def tuning_query(tuning: Tuning, experiment: Experiment) -> dict[str, str]:
    """The fields of the link: whatever is not the default for this target."""
    usual, said = Tuning().fitted(experiment), {}
    for name, attribute in TUNING_FIELDS.items():
        value = getattr(tuning, attribute)
        if value != getattr(usual, attribute):
            said[name] = _SWITCH[value] if isinstance(value, bool) else str(value)
    return said


def tuning_controls(tuning: Tuning, experiment: Experiment) -> dict[str, Any]:
    """Every control as it stands."""
    values = {name: getattr(tuning, attribute) for name, attribute in TUNING_FIELDS.items()}
    empty = {name: "" for name in ("from", "to") if values[name] is None}
    shown = {"against": tuning.parameter(experiment), "without_truth": _SWITCH[tuning.without_truth]}
    return values | empty | shown


def follow(controls: dict[str, Any], changed: Collection[str]) -> None:
    """Change what cannot be meant any more after a hand has moved something.

    Another filter is varied by what it is made from, another parameter over its usual values; who gets the truth back
    is judged by it again.
    """
    moved = set(changed)
    if moved & {"design", "order", "preset"} and "against" not in moved:
        controls["against"] = ""
    if moved & {"design", "order", "preset", "convention", "against"}:
        controls |= {name: "" for name in ("from", "to") if name not in moved}
    if "without_truth" in moved and "tune_for" not in moved and controls.get("without_truth") == _SWITCH[False]:
        objective = controls.get("tune_for")
        if objective in OBJECTIVES and not OBJECTIVES[objective].needs_truth:
            controls["tune_for"] = _of_kind("estimation", objective)


def _of_kind(kind: str, objective: str) -> str:
    """The same figure of another error; the RMSE for what is no figure of an error."""
    return f"{kind}_{OBJECTIVES[objective].how or 'rmse'}"


def fields_in_use(tuning: Tuning, experiment: Experiment) -> dict[str, bool]:
    """Which fields mean something now."""
    sweep, closed = tuning.study == "sweep", tuning.objective == NOISE_LAG
    return {
        **dict.fromkeys(("against", "from", "to", "points"), sweep),
        **dict.fromkeys(("plane", "cells"), tuning.study == "map"),
        "budget": tuning.study == "search",
        "tune_runs": not closed and has_chance(experiment),
        "noise_weight": closed,
    }


def objectives_offered(tuning: Tuning, experiment: Experiment) -> list[str]:
    """What can be tuned for here: without a truth, only what a tracker sees."""
    return [name for name in objectives_of(experiment) if not (tuning.without_truth and OBJECTIVES[name].needs_truth)]
