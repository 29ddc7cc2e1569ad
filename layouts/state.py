"""What a link says: the experiment, the view of it, the limits set, the pinned filters; and the link itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any
from urllib.parse import urlencode

from layouts.comparing import COMPARING_FIELDS, Comparing, comparing_query, read_comparing
from layouts.entries import read_entries
from layouts.pins import SLOTS, Pin, read_pin
from layouts.tuning import TUNING_FIELDS, Tuning, read_tuning, tuning_query
from tracker_core import Experiment, InputError
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.checks import Domain, check_choice
from tracker_core.experiment import PARAMETERS, read_experiment
from tracker_core.region import PLANES
from tracker_core.types import STATE_NAMES

LINK_LIMIT = 2_000
EXAGGERATIONS = ("1", "2", "5", "10", "20", "50", "100")
BACKGROUNDS = ("none", "noise", "lag")
INPUTS = ("step", "ramp", "parabola", "cubic", "quartic")
"""Powers of the time, from none on; a filter has use for those up to its order, at which it lags: see `inputs_of`."""

VIEW_FIELDS = (
    "axis", "quantity", "exaggerate", "at", "plane", "background", "input", "beside", *COMPARING_FIELDS, *TUNING_FIELDS,
)  # fmt: skip
SWITCH = ("off", "on")
LIMIT_FIELDS = ("limit_noise", "limit_lag", "limit_overshoot", "limit_settling")
LIMIT = Domain(0, 1e9, low_open=True)

_LIMIT_READERS: dict[str, Callable[[Any], Any]] = {name: partial(LIMIT.check, name) for name in LIMIT_FIELDS}


@dataclass(frozen=True, slots=True)
class View:
    """What of a run is looked at.

    Attributes:
        axis: index of the axis in the plot against time.
        quantity: index of the state in it: 0 position to 3 jerk.
        exaggerate: factor by which deviations from the truth are drawn larger in path and close-up.
        at: index of the sample at the middle of the close-up; None for the middle of the run.
        plane: the two gains that the stability map is drawn over, of PLANES of the order.
        background: what the map shows behind the region, one of BACKGROUNDS.
        input: what the time responses answer to, of INPUTS up to the order.
        beside: whether the causal counterpart of a method that looks in hindsight is shown beside it.
        comparing: what filters are compared by.
        tuning: what is tuned, and what for.
    """

    axis: int = 0
    quantity: int = 0
    exaggerate: int = 1
    at: int | None = None
    plane: tuple[str, str] = ("alpha", "beta")
    background: str = "none"
    input: str = "step"
    beside: bool = False
    comparing: Comparing = field(default_factory=Comparing)
    tuning: Tuning = field(default_factory=Tuning)

    def cursor(self, samples: int) -> int:
        """The sample looked at, within a run of that length."""
        return samples // 2 if self.at is None else min(self.at, samples - 1)


@dataclass(frozen=True, slots=True)
class Limits:
    """What the user will not have exceeded; None for no limit.

    Attributes:
        limit_noise: greatest variance of the smoothed position, per measurement variance.
        limit_lag: greatest steady lag of the smoothed position under a manoeuvre of one unit (1 m/s² for order 2,
            1 m/s³ for order 3, 1 m/s⁴ for order 4), m.
        limit_overshoot: greatest overshoot of the smoothed step response, percent.
        limit_settling: longest time until the smoothed step response stays within 2 %, s.
    """

    limit_noise: float | None = None
    limit_lag: float | None = None
    limit_overshoot: float | None = None
    limit_settling: float | None = None

    def given(self) -> dict[str, float]:
        """The limits that are set, by name."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything that a link says.

    Attributes:
        experiment: what is run.
        view: what of it is looked at.
        pins: the pinned filters, in the order in which they were pinned.
        limits: what must not be exceeded.
    """

    experiment: Experiment
    view: View = View()
    pins: tuple[Pin, ...] = ()
    limits: Limits = Limits()


def to_query(settings: Settings) -> str:
    """The link's query string: whatever is not the default, nothing else."""
    scenario = settings.experiment.target
    values = _plain(settings.experiment)
    view, usual = settings.view, View()
    if view.axis:
        values["axis"] = scenario.axes[view.axis]
    if view.quantity:
        values["quantity"] = STATE_NAMES[view.quantity]
    if view.exaggerate != 1:
        values["exaggerate"] = str(view.exaggerate)
    if view.at is not None:
        values["at"] = str(view.at + 1)
    if view.plane != usual.plane:
        values["plane"] = plane_name(view.plane)
    if view.background != usual.background:
        values["background"] = view.background
    if view.input != usual.input:
        values["input"] = view.input
    if view.beside:
        values["beside"] = SWITCH[True]
    values |= tuning_query(view.tuning, settings.experiment)
    values |= {name: repr(value) for name, value in settings.limits.given().items()}
    values |= comparing_query(view.comparing, settings.experiment)
    values |= {f"pin{pin.slot}": pin.text() for pin in settings.pins}
    # Both may stand in an address as they are.
    return urlencode(values, safe=":,")


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
    # In the order in which they stand: the last is the last one pinned.
    pin_texts = {slot: values.pop(f"pin{slot}") for slot in _slots(query)}
    view_values = {name: values.pop(name) for name in VIEW_FIELDS if name in values}
    limit_values = {name: values.pop(name) for name in LIMIT_FIELDS if name in values}
    experiment, dropped = _lenient(values)
    notes += dropped
    view, errors = read_view(view_values, experiment)
    notes += [f"{error}; the default is shown." for error in errors]
    limits, errors = read_limits(limit_values)
    notes += [f"{error}; no limit is set." for error in errors]
    pins = []
    for slot, text in pin_texts.items():
        try:
            pins.append(read_pin(slot, str(text)))
        except InputError as error:
            notes.append(f"Pin {slot}: {error}; it is left out.")
    return Settings(experiment, view, tuple(pins), limits), notes


def _slots(query: Mapping[str, str]) -> list[int]:
    named = {f"pin{slot}": slot for slot in SLOTS}
    return [named[name] for name in query if name in named]


_OF_RECORDING = ("scenario", "data", "reading", "samples", "interval", "noise", "noise_level", "noise_std")
_BLAMED = ("order", "design", *PARAMETERS, *METHOD_PARAMETERS)


def _lenient(values: dict[str, Any]) -> tuple[Experiment, list[str]]:
    """The experiment of as many of the values as fit together."""
    values, notes = dict(values), list[str]()
    while True:
        experiment, errors = read_experiment(values)
        if experiment is not None:
            return experiment, notes
        for error in errors:
            blamed = [error.field] if error.field in values else [name for name in _BLAMED if name in values]
            if error.field == "data":
                # What was said of one recording is meant of no other target.
                blamed = [name for name in _OF_RECORDING if name in values]
            notes.append(f"{error}; the default is used.")
            for name in blamed or list(values):
                values.pop(name, None)


def read_view(values: Mapping[str, Any], experiment: Experiment) -> tuple[View, list[InputError]]:
    """The view that fits an experiment; what does not fit it is left at its default and reported."""
    axes = experiment.target.axes
    planes = {plane_name(plane): plane for plane in PLANES[experiment.order]}
    readers: dict[str, Callable[[Any], Any]] = {
        "axis": lambda value: axes.index(check_choice("axis", value, axes)),
        "quantity": lambda value: STATE_NAMES.index(check_choice("quantity", value, STATE_NAMES[: experiment.order])),
        "exaggerate": lambda value: int(check_choice("exaggerate", str(value), EXAGGERATIONS)),
        "at": lambda value: int(Domain(1, experiment.samples, whole=True).check("at", value)) - 1,
        "plane": lambda value: planes[check_choice("plane", value, planes)],
        "background": lambda value: check_choice("background", value, BACKGROUNDS),
        "input": lambda value: check_choice("input", value, inputs_of(experiment.order)),
        "beside": lambda value: check_choice("beside", value, SWITCH) == SWITCH[True],
    }
    read, errors = read_entries(readers, values)
    comparing, wrong = read_comparing(values)
    tuning, wrong_tuning = read_tuning(values)
    view = View(**read, comparing=comparing.fitted(experiment), tuning=tuning.fitted(experiment))
    return view, errors + wrong + wrong_tuning


def inputs_of(order: int) -> tuple[str, ...]:
    """What the time responses of a filter may answer to."""
    return INPUTS[: order + 1]


def read_limits(values: Mapping[str, Any]) -> tuple[Limits, list[InputError]]:
    """The limits; nothing and empty texts set none, what is no limit is left out and reported."""
    read, errors = read_entries(_LIMIT_READERS, values)
    return Limits(**read), errors


def plane_name(plane: tuple[str, str]) -> str:
    """A plane of two gains as one word."""
    return "-".join(plane)
