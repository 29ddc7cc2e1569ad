"""What a link says: the experiment, the view of it, the pinned experiment; and the link itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any
from urllib.parse import parse_qsl, urlencode

from tracker_core import SCENARIOS, Experiment, InputError
from tracker_core.checks import Domain, check_choice
from tracker_core.experiment import PARAMETERS, read_experiment
from tracker_core.types import STATE_NAMES

LINK_LIMIT = 2_000
EXAGGERATIONS = ("1", "2", "5", "10", "20", "50", "100")
VIEW_FIELDS = ("axis", "quantity", "exaggerate", "at")


@dataclass(frozen=True, slots=True)
class View:
    """What of a run is looked at.

    Attributes:
        axis: index of the axis in the plot against time.
        quantity: index of the state in it: 0 position to 3 jerk.
        exaggerate: factor by which deviations from the truth are drawn larger in path and close-up.
        at: index of the sample at the middle of the close-up; None for the middle of the run.
    """

    axis: int = 0
    quantity: int = 0
    exaggerate: int = 1
    at: int | None = None

    def cursor(self, samples: int) -> int:
        """The sample looked at, within a run of that length."""
        return samples // 2 if self.at is None else min(self.at, samples - 1)


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything that a link says: the experiment, the view of it, the pinned experiment."""

    experiment: Experiment
    view: View = View()
    pin: Experiment | None = None


def to_query(settings: Settings) -> str:
    """The link's query string: whatever is not the default, nothing else."""
    scenario = SCENARIOS[settings.experiment.scenario]
    values = _plain(settings.experiment)
    view = settings.view
    if view.axis:
        values["axis"] = scenario.axes[view.axis]
    if view.quantity:
        values["quantity"] = STATE_NAMES[view.quantity]
    if view.exaggerate != 1:
        values["exaggerate"] = str(view.exaggerate)
    if view.at is not None:
        values["at"] = str(view.at + 1)
    if settings.pin is not None:
        values["pin"] = urlencode(_plain(settings.pin)) or "default"
    return urlencode(values)


def _plain(experiment: Experiment) -> dict[str, str]:
    return {
        name: ",".join(map(repr, value)) if isinstance(value, list) else str(value)
        for name, value in experiment.to_dict(minimal=True).items()
    }


def from_query(query: Mapping[str, str]) -> tuple[Settings, list[str]]:
    """Settings from a link; what cannot be used falls back to the default.

    Returns:
        The settings and a sentence for everything that was not used.
    """
    values: dict[str, Any] = dict(query)
    notes: list[str] = []
    pin_text = values.pop("pin", None)
    view_values = {name: values.pop(name) for name in VIEW_FIELDS if name in values}
    experiment, dropped = _lenient(values)
    notes += dropped
    view, errors = read_view(view_values, experiment)
    notes += [f"{error}; the default is shown." for error in errors]
    pin = None
    if pin_text is not None:
        pin, dropped = _lenient({} if pin_text == "default" else dict(parse_qsl(str(pin_text)[:LINK_LIMIT])))
        notes += [f"Pin: {note}" for note in dropped]
    return Settings(experiment, view, pin), notes


def _lenient(values: dict[str, Any]) -> tuple[Experiment, list[str]]:
    """The experiment of as many of the values as fit together."""
    values, notes = dict(values), list[str]()
    while True:
        experiment, errors = read_experiment(values)
        if experiment is not None:
            return experiment, notes
        for error in errors:
            blamed = (
                [error.field] if error.field in values else [n for n in ("order", "design", *PARAMETERS) if n in values]
            )
            notes.append(f"{error}; the default is used.")
            for name in blamed or list(values):
                values.pop(name, None)


def read_view(values: Mapping[str, Any], experiment: Experiment) -> tuple[View, list[InputError]]:
    """The view that fits an experiment; what does not fit it is left at its default and reported."""
    axes = SCENARIOS[experiment.scenario].axes
    view, errors = View(), []
    readers: dict[str, Callable[[Any], int]] = {
        "axis": lambda value: axes.index(check_choice("axis", value, axes)),
        "quantity": lambda value: STATE_NAMES.index(check_choice("quantity", value, STATE_NAMES[: experiment.order])),
        "exaggerate": lambda value: int(check_choice("exaggerate", str(value), EXAGGERATIONS)),
        "at": lambda value: int(Domain(1, experiment.samples, whole=True).check("at", value)) - 1,
    }
    for name, read in readers.items():
        if values.get(name) in (None, ""):
            continue
        try:
            view = replace(view, **{name: read(values[name])})
        except InputError as error:
            errors.append(error)
    return view, errors
