"""The experiment: one small description from which everything shown follows.

Same experiment, same bits. The link in the address bar, the page, the command line, exports and tests all speak
`Experiment.to_dict`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from tracker_core.adaptive import METHODS, Method, Shape
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.checks import InputError, check_choice
from tracker_core.conventions import Gains
from tracker_core.design import DESIGNS, MANUAL
from tracker_core.fields import FIELDS
from tracker_core.measured import RECORDING, proposed, target
from tracker_core.noise import DECIBEL
from tracker_core.scenarios import SCENARIOS, Scenario
from tracker_core.starts import STARTS
from tracker_core.types import GAIN_NAMES, ORDERS

PARAMETERS = (*GAIN_NAMES, "xi", "tracking_index")
"""Fields that a gain design may be computed from."""

LEAST_MEASURED = 4
"""Measurements of every axis that any filter can be started with."""

FILTER_FIELDS = ("design", "order", *PARAMETERS, *METHOD_PARAMETERS, "convention", "start", "gate")
"""Fields that say which filter runs; the others say what it sees."""

DEFAULTS: dict[str, Any] = {
    "scenario": "jeong-ship",
    "samples": 200,
    "interval": 1.0,
    "noise": "white",
    "noise_level": "std",
    "noise_std": (10.0,),
    "manoeuvre": "none",
    "seed": 1,
    "start": "two-point",
    "order": 3,
    "convention": "normalised",
    "design": "fading-memory",
    "xi": 0.64,
}

BESIDE: dict[str, tuple[str, tuple[str, ...], Any]] = {
    "data": ("scenario", (RECORDING,), None),
    "reading": ("scenario", (RECORDING,), None),
    "noise_correlation": ("noise", ("coloured",), 0.5),
    "noise_std": ("noise_level", ("std",), (10.0,)),
    "snr": ("noise_level", ("snr", "snr-decibel"), 20.0),
    "manoeuvre_std": (
        "manoeuvre",
        ("acceleration-pulses", "acceleration-jumps", "jerk-pulses"),
        1.0,
    ),
}
"""Fields that mean something beside certain values of another field only: that field, the values, the default."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """A complete, valid description; made by `from_dict`, which fills in what is left out.

    Attributes:
        scenario: a name in SCENARIOS, or "recording".
        data: what the file is known by whose content is the recording: see `measured.content_name`.
        reading: how it is read, the text of a `recordings.Reading`; the proposed one if left out.
        samples: number of measurements, 3 to 200,000.
        interval: T, s; of a recording whose intervals vary their median.
        noise: a name in NOISES.
        noise_level: "std" if noise_std gives the level of the noise, "snr" or "snr-decibel" if snr does.
        noise_std: standard deviation of the measurement error, m: one number, or one per axis.
        snr: signal-to-noise ratio, of powers or in decibel: see `noise.std_from_snr`.
        noise_correlation: of coloured noise from sample to sample.
        manoeuvre: a name in MANOEUVRES.
        manoeuvre_std: standard deviation of the manoeuvre noise, in its unit.
        seed: of the noises, and of a random target.
        gate: greatest normalised innovation that is believed, in standard deviations: see `gating.Gate`; None for no
            gate.
        start: a name in STARTS.
        order: 2, 3 or 4.
        convention: a name in CONVENTIONS; alpha ... eta below are written in it.
        design: a name in DESIGNS or METHODS, or "manual".
        alpha, beta, gamma, eta, xi, tracking_index: what the design is computed from, and None for the rest.
        fixed_alpha, weight, criterion, window, step, levels, grid, grid_eta, refinements, members, memory, shortest,
            longest, objective, end_points, ties, bound, parabola: what the method is told, and None for the rest; see
            `adaptive.PARAMETERS`.

    Raises:
        InputError: for anything that does not fit together.
    """

    scenario: str
    data: str | None = None
    reading: str | None = None
    samples: int
    interval: float
    noise: str
    noise_level: str
    noise_std: tuple[float, ...] | None = None
    snr: float | None = None
    noise_correlation: float | None = None
    manoeuvre: str
    manoeuvre_std: float | None = None
    seed: int
    gate: float | None = None
    start: str
    order: int
    convention: str
    design: str
    alpha: float | None = None
    beta: float | None = None
    gamma: float | None = None
    eta: float | None = None
    xi: float | None = None
    tracking_index: float | None = None
    fixed_alpha: float | None = None
    weight: float | None = None
    criterion: str | None = None
    window: int | None = None
    step: int | None = None
    levels: int | None = None
    grid: int | None = None
    grid_eta: int | None = None
    refinements: int | None = None
    members: int | None = None
    memory: float | None = None
    shortest: float | None = None
    longest: float | None = None
    objective: str | None = None
    end_points: str | None = None
    ties: str | None = None
    bound: str | None = None
    parabola: str | None = None

    def __post_init__(self) -> None:
        for name, field in FIELDS.items():
            value = getattr(self, name)
            if value is not None:
                field.read(name, value)
        _check_sensor(self)
        if self.order < STARTS[self.start].least_order:
            raise InputError("start", f"must not be '{self.start}' for a filter of order {self.order}", self.start)
        if self.method is None:
            self.gains()
            return
        for name in PARAMETERS:
            if getattr(self, name) is not None:
                raise InputError(name, f"must be left out for the method '{self.design}'", getattr(self, name))
        if self.gate is not None:
            raise InputError("gate", f"must be left out for the method '{self.design}'", self.gate)
        scenario = self.target
        shape = Shape(self.samples, len(scenario.axes), self.order, scenario.known_states)
        self.method.check(shape, self.start, self.interval, self.parameters())

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Experiment:
        """The experiment that `values` describe; what they leave out comes from the scenario's defaults.

        Numbers may be given as strings. Where no design is named, the parameters given choose one: gains mean manual,
        xi the fading-memory filter, a tracking index the steady Kalman filter of that order.

        Raises:
            InputError: the first rule that is broken.
        """
        experiment, errors = read_experiment(values)
        if experiment is None:
            raise errors[0]
        return experiment

    @property
    def target(self) -> Scenario:
        """What is tracked.

        Raises:
            InputError: for a recording that is nowhere, or cannot be read as it is said.
        """
        return target_of(self.scenario, self.data, self.reading)

    @property
    def method(self) -> Method | None:
        """The method that chooses the gains as the filter runs; None where a design or a hand has set them."""
        return None if self.design in DESIGNS else METHODS.get(self.design)

    def parameters(self) -> dict[str, Any]:
        """What the method is told, by name; what is None is searched."""
        return {name: value for name in METHOD_PARAMETERS if (value := getattr(self, name)) is not None}

    @property
    def hindsight(self) -> str:
        """Why no tracker could run this, in one line; empty where one could."""
        return "" if self.method is None else self.method.hindsight(self.parameters())

    def counterpart(self) -> Experiment | None:
        """The same run with the causal method of the same idea; None unless this one looks in hindsight.

        Parameters that both methods have are taken over.
        """
        if self.method is None or not self.hindsight or self.method.counterpart is None:
            return None
        causal = METHODS[self.method.counterpart]
        kept = {name: value for name, value in self.parameters().items() if name in causal.parameters}
        values: dict[str, Any] = dict.fromkeys(METHOD_PARAMETERS) | causal.defaults(self.interval) | kept
        return replace(self, design=causal.name, **values)

    def gains(self) -> Gains:
        """The constant gains of this experiment, written in its convention.

        Raises:
            InputError: where a method chooses them as the filter runs: there is no one set.
        """
        for name, value in self.parameters().items():
            raise InputError(name, f"must be left out for the design '{self.design}'", value)
        given = {name: value for name in PARAMETERS if (value := getattr(self, name)) is not None}
        if self.design != MANUAL:
            return Gains.normalised(DESIGNS[self.design].gains(self.order, **given)).to(self.convention)
        wanted = GAIN_NAMES[: self.order]
        for name in wanted:
            if name not in given:
                raise InputError(name, f"must be given for order {self.order}", None)
        for name, value in given.items():
            if name not in wanted:
                raise InputError(name, f"must be left out for manual gains of order {self.order}", value)
        return Gains(tuple(given[name] for name in wanted), self.convention)

    def filter_values(self) -> dict[str, Any]:
        """The filter alone, by field name: `with_filter` makes the same one of it on any target.

        What is left out is usual for every target; what a method derives from the interval is always said.
        """
        return read_filter({name: getattr(self, name) for name in FILTER_FIELDS})

    def with_filter(self, values: Mapping[str, Any]) -> Experiment:
        """The same target and sensor under another filter.

        Args:
            values: of FILTER_FIELDS; what they leave out never depends on the target's own defaults.

        Raises:
            InputError: for values that describe no filter, or one that does not fit this target.
        """
        known = read_filter(values)
        design = known["design"]
        method = None if design in DESIGNS else METHODS.get(design)
        complete: dict[str, Any] = dict.fromkeys(FILTER_FIELDS) | _usual_filter(known)
        complete |= {} if method is None else method.defaults(self.interval)
        return replace(self, **complete | known)

    def to_dict(self, *, minimal: bool = False) -> dict[str, Any]:
        """Plain values by field name; `from_dict` gives the same experiment back.

        Args:
            minimal: leave out what `from_dict` would fill in by itself.
        """
        values = {name: value for name in _NAMES if (value := getattr(self, name)) is not None}
        if minimal:
            usual = {**_usual(self.target, self.design, self.order), "scenario": DEFAULTS["scenario"]}
            usual |= {name: value for name, value in _beside(values).items() if name not in usual}
            values = {name: value for name, value in values.items() if usual.get(name) != value}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}


_NAMES = tuple(item.name for item in fields(Experiment))


def read_experiment(values: Mapping[str, Any]) -> tuple[Experiment | None, list[InputError]]:
    """Like `Experiment.from_dict`, but with every error there is to report.

    Returns:
        The experiment, or None with the errors that prevent it.
    """
    errors: list[InputError] = []
    known: dict[str, Any] = {}
    for name, value in values.items():
        if name not in FIELDS:
            errors.append(InputError(str(name), "is not a field of the experiment", value))
            continue
        if value is None:
            continue
        try:
            known[name] = FIELDS[name].read(name, value)
        except InputError as error:
            errors.append(error.kept())
    if errors:
        return None, errors
    try:
        return Experiment(**_complete(known)), []
    except InputError as error:
        return None, [error.kept()]


def read_filter(values: Mapping[str, Any]) -> dict[str, Any]:
    """The filter that `values` describe: every value as its field's type, the design named, nothing that goes unsaid.

    Whether the values fit together is for `Experiment.with_filter` to find out.

    Raises:
        InputError: the first value that cannot be read or is none of the filter's.
    """
    known: dict[str, Any] = {}
    for name, value in values.items():
        if name not in FILTER_FIELDS:
            raise InputError(str(name), "is not a field of the filter", value)
        if value is not None:
            known[name] = FIELDS[name].read(name, value)
    given = [name for name in PARAMETERS if name in known]
    known.setdefault("design", _implied_design(given, known.get("order", DEFAULTS["order"]), DEFAULTS["design"]))
    usual = _usual_filter(known)
    return {name: known[name] for name in FILTER_FIELDS if name in known and known[name] != usual.get(name)}


def _usual_filter(known: Mapping[str, Any]) -> dict[str, Any]:
    """What goes unsaid of a filter: see `read_filter`."""
    design, given = known["design"], [name for name in PARAMETERS if name in known]
    usual = {name: DEFAULTS[name] for name in ("convention", "start")}
    usual["order"] = _implied_order(given, design, DEFAULTS)
    if design in METHODS and design not in DESIGNS:
        usual |= {name: value for name, value in METHODS[design].parameters.items() if not callable(value)}
    return usual


def target_of(scenario: str, data: str | None, reading: str | None) -> Scenario:
    """What is tracked where an experiment says this.

    Raises:
        InputError: for an unknown scenario, a recording that is nowhere, or one that cannot be read like this.
    """
    if scenario in SCENARIOS:
        return SCENARIOS[scenario]
    check_choice("scenario", scenario, (*SCENARIOS, RECORDING))
    if data is None:
        raise InputError("data", f"must be given where scenario is '{RECORDING}'", None)
    return target(data, proposed(data) if reading is None else reading)


def _scenario_defaults(scenario: Scenario) -> dict[str, Any]:
    """What the scenario sets; its design, if it has one, replaces the usual one whole."""
    defaults = dict(scenario.defaults)
    if "design" in defaults:
        defaults = {"xi": None, **defaults}
    return defaults


def _usual(scenario: Scenario, design: str | None = None, order: int | None = None) -> dict[str, Any]:
    """What an experiment is filled up from; design parameters only while they belong to this design and order."""
    usual = {**DEFAULTS, **_scenario_defaults(scenario)}
    same = design in (None, usual["design"]) and (design != MANUAL or order == usual["order"])
    return usual if same else {name: value for name, value in usual.items() if name not in PARAMETERS}


def _complete(known: dict[str, Any]) -> dict[str, Any]:
    known.setdefault("scenario", RECORDING if "data" in known else DEFAULTS["scenario"])
    scenario = target_of(known["scenario"], known.get("data"), known.get("reading"))
    if scenario.measured:
        # Said in full: what is proposed may be another thing tomorrow.
        known["reading"] = known.get("reading") or proposed(known["data"])
    usual = _usual(scenario)
    given = [name for name in PARAMETERS if name in known]
    design = known.get("design") or _implied_design(given, known.get("order", usual["order"]), usual["design"])
    order = known.get("order") or _implied_order(given, design, usual)
    complete = {**_usual(scenario, design, order), **known, "design": design, "order": order}
    for name, (other, values, _) in BESIDE.items():
        if complete[other] not in values and name not in known:
            complete.pop(name, None)
    complete = {**_beside(complete), **complete}
    return {name: value for name, value in complete.items() if value is not None}


def _beside(values: Mapping[str, Any]) -> dict[str, Any]:
    """Defaults of the fields that these values call for: see BESIDE; and of a method's parameters."""
    wanted = {name: default for name, (other, among, default) in BESIDE.items() if values.get(other) in among}
    design = values.get("design")
    if design in METHODS and design not in DESIGNS:
        wanted |= METHODS[str(design)].defaults(values["interval"])
    return wanted


def _implied_design(given: list[str], order: int, usual: str) -> str:
    takes = DESIGNS[usual].parameters if usual in DESIGNS else GAIN_NAMES
    if all(name in takes for name in given):
        return usual
    if "xi" in given:
        return "fading-memory"
    if "tracking_index" in given:
        return {2: "kalata", 3: "gray-murray"}.get(order, "steady-kalman")
    return MANUAL


def _implied_order(given: list[str], design: str, usual: dict[str, Any]) -> int:
    if design == MANUAL:
        least = max((GAIN_NAMES.index(name) + 1 for name in given if name in GAIN_NAMES), default=0)
        return max(2, least, usual["order"] if usual["design"] == MANUAL or not least else 0)
    serves = orders_of(design)
    return int(usual["order"]) if usual["order"] in serves else serves[0]


def orders_of(design: str) -> tuple[int, ...]:
    """The filter orders that a design or a method serves; all of them where the gains are set by hand."""
    if design in DESIGNS:
        return DESIGNS[design].orders
    return METHODS[design].orders if design in METHODS else ORDERS


def _check_sensor(experiment: Experiment) -> None:
    """What noise, samples, interval and the scenario's recording must have in common."""
    for name, (other, values, _) in BESIDE.items():
        value, beside = getattr(experiment, name), getattr(experiment, other)
        if (value is not None) != (beside in values):
            rule = "must be given" if value is None else "must be left out"
            raise InputError(name, f"{rule} where {other} is '{beside}'", value)
    scenario = experiment.target
    if experiment.noise_level == "snr" and not (experiment.snr or 0) > 0:
        raise InputError("snr", "must be > 0 as a ratio of powers", experiment.snr)
    if experiment.noise_level == "snr-decibel":
        DECIBEL.check("snr", experiment.snr)
    if experiment.noise_std is not None and len(experiment.noise_std) not in (1, len(scenario.axes)):
        axes = len(scenario.axes)
        rule = (
            "must be one number"
            if axes == 1
            else f"must be one number, or {axes} for the axes {', '.join(scenario.axes)}"
        )
        raise InputError("noise_std", rule, list(experiment.noise_std))
    if experiment.gate is not None and experiment.noise_std is not None and not all(experiment.noise_std):
        rule = "must be left out where noise_std is 0: nothing else says how large an innovation may be"
        raise InputError("gate", rule, experiment.gate)
    if scenario.measured:
        _check_measured(experiment)
    if experiment.noise != "recorded":
        return
    if experiment.manoeuvre != "none":
        raise InputError("manoeuvre", "must be 'none' for recorded measurements", experiment.manoeuvre)
    recording = scenario.recording
    if recording is None:
        raise InputError("noise", f"must not be 'recorded': nothing was recorded for '{scenario.name}'", "recorded")
    if experiment.samples > len(recording.positions):
        raise InputError(
            "samples", f"must be <= {len(recording.positions)} for recorded measurements", experiment.samples
        )
    if experiment.interval != recording.interval:
        raise InputError("interval", f"must be {recording.interval:g} for recorded measurements", experiment.interval)


def _check_measured(experiment: Experiment) -> None:
    """Nothing is drawn where everything was measured, and nobody knows the state before it."""
    for name, value in (("noise", "recorded"), ("noise_level", "std"), ("manoeuvre", "none")):
        if getattr(experiment, name) != value:
            raise InputError(name, f"must be '{value}' where scenario is '{RECORDING}'", getattr(experiment, name))
    recording = experiment.target.recording
    if recording is not None:
        least = int((~np.isnan(recording.positions[: experiment.samples])).sum(axis=0).min())
        if least < LEAST_MEASURED:
            rule = f"must be so many that every axis was measured {LEAST_MEASURED} times; of one there are {least}"
            raise InputError("samples", rule, experiment.samples)
    if experiment.start == "known":
        raise InputError("start", "must not be 'known': nobody knows the state before the first sample", "known")
