"""What the Compare page is asked for, as its controls and the link say it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from layouts.entries import read_entries
from layouts.pins import SLOTS
from tracker_core import METRICS, Experiment, InputError
from tracker_core.batch import KINDS
from tracker_core.checks import Domain, check_choice
from tracker_core.tuning.base import knows_truth
from tracker_core.tuning.monte_carlo import FIGURES, RUNS

PRESENT = 0
"""Where a slot of a pin may stand: the present filter."""

CHOICES = (PRESENT, *SLOTS)
"""Slots of all filters that there can be."""

_SLOT = Domain(PRESENT, SLOTS[-1], whole=True)


@dataclass(frozen=True, slots=True)
class Comparing:
    """What filters are compared by, and with which of them.

    Attributes:
        reference: slot of the pin that the others are compared with; PRESENT for the present filter.
        compared: the error shown over time, one of KINDS.
        figure: the metric whose differences are drawn, one of FIGURES.
        runs: with seeds of their own.
    """

    reference: int = PRESENT
    compared: str = "estimation"
    figure: str = "estimation_rmse"
    runs: int = 100

    def fitted(self, experiment: Experiment) -> Comparing:
        """The same as it can be shown here: where nobody knows the truth, the innovations."""
        return self if knows_truth(experiment) else replace(self, compared="innovation")


COMPARING_FIELDS = ("reference", "compared", "figure", "runs")

_READERS: dict[str, Callable[[Any], Any]] = {
    "reference": lambda value: int(_SLOT.check("reference", value)),
    "compared": lambda value: check_choice("compared", value, KINDS),
    "figure": lambda value: check_choice("figure", value, FIGURES),
    "runs": lambda value: int(RUNS.check("runs", value)),
}

FIGURE_TITLES = {name: METRICS[name].title for name in FIGURES}


def read_comparing(values: Mapping[str, Any]) -> tuple[Comparing, list[InputError]]:
    """What is compared; nothing and empty texts mean the default, what cannot be used is left out and reported."""
    read, errors = read_entries(_READERS, values)
    return Comparing(**read), errors


def comparing_controls(comparing: Comparing) -> dict[str, Any]:
    """The controls as they stand."""
    return {name: getattr(comparing, name) for name in COMPARING_FIELDS}


def comparing_query(comparing: Comparing, experiment: Experiment) -> dict[str, str]:
    """What a link says of it: whatever is not the default for this target."""
    usual = comparing_controls(Comparing().fitted(experiment))
    return {name: str(value) for name, value in comparing_controls(comparing).items() if value != usual[name]}
