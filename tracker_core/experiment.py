"""The experiment: one small description from which everything shown follows, and its run.

Same experiment, same bits. The link in the address bar, the page, the command line, exports and tests all speak
`Experiment.to_dict`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import numpy as np

from tracker_core.checks import InputError
from tracker_core.conventions import Gains
from tracker_core.design import DESIGNS, MANUAL
from tracker_core.fields import FIELDS
from tracker_core.filters import run_filter
from tracker_core.metrics import Metrics, measure, measure_axes
from tracker_core.noise import NOISES
from tracker_core.scenarios import SCENARIOS, Scenario
from tracker_core.stability import Verdict, assess
from tracker_core.starts import STARTS
from tracker_core.types import GAIN_NAMES, FloatArray, Measurements, Track, Truth

PARAMETERS = (*GAIN_NAMES, "xi", "tracking_index")
"""Fields that a gain design may be computed from."""

DEFAULTS: dict[str, Any] = {
    "scenario": "jeong-ship",
    "samples": 200,
    "interval": 1.0,
    "noise": "white",
    "noise_std": (10.0,),
    "seed": 1,
    "start": "two-point",
    "order": 3,
    "convention": "normalised",
    "design": "fading-memory",
    "xi": 0.64,
}

_DESIGN_FIELDS = ("order", "design", *PARAMETERS)
CACHED_SAMPLES = 20_000


@dataclass(frozen=True, slots=True)
class Experiment:
    """A complete, valid description; made by `from_dict`, which fills in what is left out.

    Attributes:
        scenario: a name in SCENARIOS.
        samples: number of measurements, 3 to 200,000.
        interval: T, s.
        noise: a name in NOISES.
        noise_std: standard deviation of the measurement error, m: one number, or one per axis.
        seed: of the noise.
        start: a name in STARTS.
        order: 2, 3 or 4.
        convention: a name in CONVENTIONS; alpha ... eta below are written in it.
        design: a name in DESIGNS, or "manual".
        alpha, beta, gamma, eta, xi, tracking_index: what the design is computed from, and None for the rest.

    Raises:
        InputError: for anything that does not fit together.
    """

    scenario: str
    samples: int
    interval: float
    noise: str
    noise_std: tuple[float, ...]
    seed: int
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

    def __post_init__(self) -> None:
        for name, field in FIELDS.items():
            value = getattr(self, name)
            if value is not None:
                field.read(name, value)
        _check_sensor(self)
        if self.order < STARTS[self.start].least_order:
            raise InputError("start", f"must not be '{self.start}' for a filter of order {self.order}", self.start)
        self.gains()

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

    def gains(self) -> Gains:
        """The gains of this experiment, written in its convention."""
        given = {name: getattr(self, name) for name in PARAMETERS if getattr(self, name) is not None}
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

    def to_dict(self, *, minimal: bool = False) -> dict[str, Any]:
        """Plain values by field name; `from_dict` gives the same experiment back.

        Args:
            minimal: leave out what `from_dict` would fill in by itself.
        """
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        values = {name: value for name, value in values.items() if value is not None}
        values["noise_std"] = list(self.noise_std)
        if not minimal:
            return values
        usual = {**_usual(self.scenario, self.design, self.order), "scenario": DEFAULTS["scenario"]}
        usual["noise_std"] = list(usual["noise_std"])
        return {name: value for name, value in values.items() if usual.get(name) != value}


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
            errors.append(error)
    if errors:
        return None, errors
    try:
        return Experiment(**_complete(known)), []
    except InputError as error:
        return None, [error]


def _scenario_defaults(scenario: str) -> dict[str, Any]:
    """What the scenario sets; its design, if it has one, replaces the usual one whole."""
    defaults = dict(SCENARIOS[scenario].defaults)
    if "design" in defaults:
        defaults = {"xi": None, **defaults}
    return defaults


def _usual(scenario: str, design: str | None = None, order: int | None = None) -> dict[str, Any]:
    """What an experiment is filled up from; design parameters only while they belong to this design and order."""
    usual = {**DEFAULTS, **_scenario_defaults(scenario)}
    same = design in (None, usual["design"]) and (design != MANUAL or order == usual["order"])
    return usual if same else {name: value for name, value in usual.items() if name not in PARAMETERS}


def _complete(known: dict[str, Any]) -> dict[str, Any]:
    scenario = known.get("scenario", DEFAULTS["scenario"])
    usual = _usual(scenario)
    given = [name for name in PARAMETERS if name in known]
    design = known.get("design") or _implied_design(given, known.get("order", usual["order"]), usual["design"])
    order = known.get("order") or _implied_order(given, design, usual)
    complete = {**_usual(scenario, design, order), **known, "design": design, "order": order}
    return {name: value for name, value in complete.items() if value is not None}


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
    if design in DESIGNS and usual["order"] not in DESIGNS[design].formulas:
        return DESIGNS[design].orders[0]
    return int(usual["order"])


def _check_sensor(experiment: Experiment) -> None:
    """What noise, samples, interval and the scenario's recording must have in common."""
    scenario = SCENARIOS[experiment.scenario]
    if len(experiment.noise_std) not in (1, len(scenario.axes)):
        axes = len(scenario.axes)
        rule = (
            "must be one number"
            if axes == 1
            else f"must be one number, or {axes} for the axes {', '.join(scenario.axes)}"
        )
        raise InputError("noise_std", rule, list(experiment.noise_std))
    if experiment.noise != "recorded":
        return
    recording = scenario.recording
    if recording is None:
        raise InputError("noise", f"must not be 'recorded': nothing was recorded for '{scenario.name}'", "recorded")
    if experiment.samples > len(recording.positions):
        raise InputError(
            "samples", f"must be <= {len(recording.positions)} for recorded measurements", experiment.samples
        )
    if experiment.interval != recording.interval:
        raise InputError("interval", f"must be {recording.interval:g} for recorded measurements", experiment.interval)


@dataclass(frozen=True, slots=True)
class Result:
    """Everything that follows from one experiment.

    Attributes:
        experiment: the description.
        gains: the gains it ran with, in its convention.
        verdict: their stability.
        truth: what the target did.
        measurements: what the sensor saw of it.
        track: what the filter made of that.
        metrics: how good the track is, all axes jointly.
    """

    experiment: Experiment
    gains: Gains
    verdict: Verdict
    truth: Truth
    measurements: Measurements
    track: Track
    metrics: Metrics

    @property
    def scenario(self) -> Scenario:
        """The scenario that was run."""
        return SCENARIOS[self.experiment.scenario]

    def axis_metrics(self) -> tuple[Metrics, ...]:
        """The figures of merit of every axis for itself."""
        return measure_axes(self.track, self.measurements, self.truth, self.gains, stable=self.verdict.stable)


def observe(experiment: Experiment) -> tuple[Truth, Measurements]:
    """The truth of an experiment and what the sensor measured of it; short ones are remembered."""
    key = (
        experiment.scenario, experiment.samples, experiment.interval, experiment.noise, experiment.noise_std,
        experiment.seed,
    )  # fmt: skip
    return _remembered(*key) if experiment.samples <= CACHED_SAMPLES else _observe(*key)


def _observe(
    scenario_name: str, samples: int, interval: float, noise: str, noise_std: tuple[float, ...], seed: int
) -> tuple[Truth, Measurements]:
    scenario = SCENARIOS[scenario_name]
    truth = scenario.truth((scenario.first_sample + np.arange(samples, dtype=np.float64)) * interval, seed)
    if noise == "recorded" and scenario.recording is not None:
        positions = np.array(scenario.recording.positions[:samples])
    else:
        draw = NOISES[noise].draw
        positions = truth.positions.copy()
        if draw is not None:
            positions += draw(positions.shape, noise_std, seed, 0.0)
    for array in (truth.times, truth.states, positions):
        array.setflags(write=False)
    return truth, Measurements(truth.times, positions, interval)


_remembered = lru_cache(maxsize=32)(_observe)


def known_state(experiment: Experiment) -> FloatArray | None:
    """The state that the start "known" is given: the truth one interval before the first sample; else None."""
    if experiment.start != "known":
        return None
    scenario = SCENARIOS[experiment.scenario]
    before = (scenario.first_sample - 1) * experiment.interval
    return scenario.truth(np.array([before]), experiment.seed).states[0, :, : experiment.order]


def run_experiment(experiment: Experiment) -> Result:
    """Run it: truth, measurements, track, stability, metrics."""
    gains = experiment.gains()
    truth, measurements = observe(experiment)
    track = run_filter(measurements, gains, start=experiment.start, initial_state=known_state(experiment))
    verdict = assess(gains)
    return Result(
        experiment=experiment,
        gains=gains,
        verdict=verdict,
        truth=truth,
        measurements=measurements,
        track=track,
        metrics=measure(track, measurements, truth, gains, stable=verdict.stable),
    )
