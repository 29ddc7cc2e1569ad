"""One run as a page is to show it: what figures are made from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from layouts.state import Settings, View
from tracker_core import Result


@dataclass(frozen=True, slots=True)
class Shown:
    """One run as a page is to show it.

    Attributes:
        result: the run.
        settings: what it follows from, and the view of it.
        theme: "light" or "dark".
        meta: what the page knows of this drawing; put into the layout of every plot.
        live: whether a slider is moving: only what moves will be looked at.
        scene: the token of the page's scene in three dimensions; empty for none.
        beside: the run of the causal counterpart, where it is wanted beside one in hindsight.
    """

    result: Result
    settings: Settings
    theme: str
    meta: dict[str, Any]
    live: bool = False
    scene: str = ""
    beside: Result | None = None

    @property
    def view(self) -> View:
        """What of the run is looked at."""
        return self.settings.view


def target_key(shown: Shown) -> str:
    """What must stay the same for a zoom to keep its meaning."""
    experiment = shown.settings.experiment
    target = (experiment.scenario, experiment.data, experiment.reading)
    return f"{target}|{experiment.samples}|{experiment.interval!r}"


def seen_key(shown: Shown) -> str:
    """What truth and measurements follow from."""
    experiment = shown.settings.experiment
    seen = (
        experiment.noise, experiment.noise_level, experiment.noise_std, experiment.snr, experiment.noise_correlation,
        experiment.manoeuvre, experiment.manoeuvre_std, experiment.seed,
    )  # fmt: skip
    return f"{target_key(shown)}|{seen}"


def beside_key(shown: Shown) -> str:
    """What stands beside the run."""
    return "" if shown.beside is None else shown.beside.experiment.design
