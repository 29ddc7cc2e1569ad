"""The run of an experiment: truth, measurements, track, stability, metrics. The same experiment gives the same bits."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf
from typing import Any

import numpy as np

from tracker_core.adaptive import Selection
from tracker_core.batch import Runs
from tracker_core.checks import InputError
from tracker_core.consistency import default_gate
from tracker_core.conventions import Gains
from tracker_core.experiment import Experiment, target_of
from tracker_core.fields import FIELDS
from tracker_core.filters import run_filter
from tracker_core.gating import Gate
from tracker_core.innovations import Evidence, examine
from tracker_core.manoeuvre import held_std, wander
from tracker_core.metrics import Metrics, manoeuvre_strength, measure, measure_axes
from tracker_core.noise import NOISES, std_from_snr
from tracker_core.optimal import distance_from_optimal
from tracker_core.scenarios import Scenario
from tracker_core.stability import Verdict, assess, stable
from tracker_core.suggestion import Suggestion
from tracker_core.types import FloatArray, Measurements, Track, Truth

CACHED_SAMPLES = 20_000
"""Samples of a run that is remembered."""

CACHED_TARGETS = 32
"""Targets with their measurements that are remembered, those used last."""

CACHED_WEIGHTS = 400_000
"""Samples times members of a bank whose run is remembered: a run keeps a weight or more for each of them."""


@dataclass(frozen=True, slots=True)
class Result:
    """Everything that follows from one experiment.

    Attributes:
        experiment: the description.
        gains: the gains it ran with, in its convention; where a method chose them, those of the last sample of the
            first axis, or of another one: see `at`.
        verdict: their stability.
        truth: what the target did; NaN where nobody knows it.
        measurements: what the sensor saw of it.
        noise_std: standard deviation of its error, per axis, m.
        track: what the filter made of that.
        metrics: how good the track is, all axes jointly.
        selection: how a method chose the gains; None where they are constant.
        gate: which measurements were not believed; None where all were.
    """

    experiment: Experiment
    gains: Gains
    verdict: Verdict
    truth: Truth
    measurements: Measurements
    noise_std: tuple[float, ...]
    track: Track
    metrics: Metrics
    selection: Selection | None = None
    gate: Gate | None = None

    @property
    def scenario(self) -> Scenario:
        """The scenario that was run."""
        return self.experiment.target

    def axis_metrics(self) -> tuple[Metrics, ...]:
        """The figures of merit of every axis for itself."""
        steady = self.verdict.stable and self.selection is None
        pushes = pushes_of(self.experiment)
        return measure_axes(self.track, self.measurements, self.truth, self.gains, stable=steady, pushes=pushes)

    def at(self, sample: int, axis: int) -> Result:
        """The same result with the gains, and their verdict, that a method used at a sample of an axis."""
        if self.selection is None:
            return self
        gains = Gains.normalised(self.selection.gains_at(sample, axis)).to(self.experiment.convention)
        return replace(self, gains=gains, verdict=assess(gains))

    def evidence(self) -> Evidence:
        """What the track shows without a truth; with the gate's model, or the one that suits the gains best."""
        index = None
        if self.gate is not None:
            index = self.gate.tracking_index
        elif self.selection is None and self.verdict.stable:
            # Rounding may hide that gains are stable.
            with suppress(InputError):
                index = distance_from_optimal(self.gains).tracking_index
        std = self.noise_std if self.experiment.noise != "none" else None
        spread, width = (None, inf) if self.gate is None else (self.track.spread, self.gate.width)
        if spread is None and std is not None and index is not None and all(std) and not self.measurements.is_even:
            gate = Gate(inf, std, index, self.experiment.interval)
            spread = run_filter(self.measurements, self.gains, start=self.experiment.start, gate=gate).spread
        return examine(
            self.track, self.measurements, self.gains, sensor_std=std, tracking_index=index, spread=spread, width=width
        )

    def unstable_share(self) -> float:
        """Share of the corrections, over all axes, whose gains would be unstable if they were held."""
        if self.selection is None:
            return 0.0 if self.verdict.stable else 1.0
        used = self.selection.gains[~np.isnan(self.selection.gains[:, :, 0])]
        return float(1 - stable(used).mean()) if len(used) else 0.0


def observe(experiment: Experiment, *, remember: bool = True) -> tuple[Truth, Measurements, tuple[float, ...]]:
    """The truth of an experiment, what the sensor measured of it, and the standard deviation of its error per axis.

    Short runs are remembered, unless nobody will ask for them again.
    """
    key = tuple(getattr(experiment, name) for name in SEEN)
    if not remember or experiment.samples > CACHED_SAMPLES:
        return _observe(*key)
    return _remembered(*key)


SEEN = (
    "scenario", "data", "reading", "samples", "interval", "noise", "noise_level", "noise_std", "noise_correlation",
    "snr", "manoeuvre", "manoeuvre_std", "seed",
)  # fmt: skip
"""What truth and measurements follow from, in the order in which `_observe` takes it."""


def _observe(
    scenario_name: str,
    data: str | None,
    reading: str | None,
    samples: int,
    interval: float,
    noise: str,
    noise_level: str,
    noise_std: tuple[float, ...] | None,
    noise_correlation: float | None,
    snr: float | None,
    manoeuvre: str,
    manoeuvre_std: float | None,
    seed: int,
) -> tuple[Truth, Measurements, tuple[float, ...]]:
    scenario = target_of(scenario_name, data, reading)
    moved = _moved if samples <= CACHED_SAMPLES else _moved.__wrapped__
    truth = moved(scenario_name, data, reading, samples, interval, seed if scenario.random else 0)
    times, axes = truth.times, len(scenario.axes)
    if manoeuvre_std is not None:
        pushed = truth.states + wander(manoeuvre, samples, axes, interval, manoeuvre_std, seed)
        truth = Truth(times, pushed)
    std = _std_of(truth.positions, noise_level, noise_std, snr)
    if noise == "recorded" and scenario.recording is not None:
        positions = np.array(scenario.recording.positions[:samples])
    else:
        draw = NOISES[noise].draw
        positions = truth.positions.copy()
        if draw is not None:
            positions += draw(positions.shape, std, seed, noise_correlation or 0.0)
    for array in (truth.states, positions):
        array.setflags(write=False)
    constant = scenario.recording is None or scenario.recording.times is None
    return truth, Measurements(truth.times, positions, interval if constant else None), std


def _std_of(
    positions: FloatArray, noise_level: str, noise_std: tuple[float, ...] | None, snr: float | None
) -> tuple[float, ...]:
    """Standard deviation of the measurement error per axis; the true positions (n, axes) matter for a ratio."""
    if noise_std is None:
        return std_from_snr(positions, snr or 0.0, decibel=noise_level == "snr-decibel")
    return noise_std * positions.shape[1] if len(noise_std) == 1 else noise_std


@lru_cache(maxsize=8)
def _moved(name: str, data: str | None, reading: str | None, samples: int, interval: float, seed: int) -> Truth:
    """The truth without random pushes; the seed matters where the target is random."""
    scenario = target_of(name, data, reading)
    truth = scenario.truth(scenario.times(samples, interval), seed)
    for array in (truth.times, truth.states):
        array.setflags(write=False)
    return truth


_remembered = lru_cache(maxsize=CACHED_TARGETS)(_observe)


def observe_runs(experiment: Experiment, seeds: Sequence[int]) -> Runs:
    """Truth and measurements of an experiment with other seeds: the same bits that `observe` has for each of them.

    Raises:
        InputError: for a seed that the experiment does not admit.
    """
    for seed in (min(seeds), max(seeds)):
        FIELDS["seed"].read("seed", seed)
    scenario = experiment.target
    if scenario.random or experiment.manoeuvre_std is not None or experiment.noise == "recorded":
        several = [observe(replace(experiment, seed=seed), remember=False) for seed in seeds]
        truth, measured, _ = several[0]
        true = np.array([truth.positions for truth, _, _ in several]) if truth.known else None
        times = measured.times if measured.interval is None else None
        return Runs(np.array([measured.positions for _, measured, _ in several]), true, experiment.interval, times)
    truth, _, std = observe(experiment)
    draw, correlation = NOISES[experiment.noise].draw, experiment.noise_correlation or 0.0
    positions = np.repeat(truth.positions[None], len(seeds), axis=0)
    if draw is not None:
        for row, seed in enumerate(seeds):
            positions[row] += draw(truth.positions.shape, std, seed, correlation)
    return Runs(positions, truth.positions[None], experiment.interval)


def believed_runs(experiment: Experiment, seeds: Sequence[int]) -> Runs:
    """The same without what the experiment's own filter refuses: NaN where its gate does not believe a measurement.

    Whatever filter runs on them, it sees what the others see.
    """
    runs = observe_runs(experiment, seeds)
    if experiment.gate is None:
        return runs
    _, measured, _ = observe(experiment)
    gains, positions = experiment.gains(), runs.positions.copy()
    states = known_states(experiment, seeds, experiment.order)
    gates: dict[tuple[float, ...], Gate | None] = {}
    for row, seen in enumerate(runs.positions):
        true = seen if runs.truth is None else runs.truth[min(row, len(runs.truth) - 1)]
        # A ratio of signal to noise may give every target a noise of its own.
        std = _std_of(true, experiment.noise_level, experiment.noise_std, experiment.snr)
        if std not in gates:
            gates[std] = gate_of(experiment, gains, std)
        track = run_filter(
            replace(measured, positions=seen), gains, start=experiment.start, gate=gates[std],
            initial_state=states if states is None or states.ndim == 2 else states[row],
        )  # fmt: skip
        if track.rejected is not None:
            positions[row, track.rejected] = np.nan
    return replace(runs, positions=positions)


def observation_rmse(runs: Runs) -> FloatArray:
    """Root mean square distance between measured and true position of every run, m, shape (r,).

    Raises:
        InputError: for runs whose truth nobody knows.
    """
    if runs.truth is None:
        raise InputError("truth", "must be known", None)
    errors = runs.positions - runs.truth
    squares = np.einsum("rna,rna->rn", errors, errors)
    defined = ~np.isnan(squares)
    return np.sqrt(np.where(defined, squares, 0.0).sum(axis=1) / np.maximum(defined.sum(axis=1), 1))


def known_states(experiment: Experiment, seeds: Sequence[int], order: int) -> FloatArray | None:
    """What the start "known" is given: shape (axes, order), (r, axes, order) for a random target; None for others."""
    if experiment.start != "known":
        return None
    scenario = experiment.target
    before = np.array([(scenario.first_sample - 1) * experiment.interval])
    if not scenario.random:
        return scenario.truth(before).states[0, :, :order]
    return np.array([scenario.truth(before, seed).states[0, :, :order] for seed in seeds])


def known_state(experiment: Experiment) -> FloatArray | None:
    """The state that the start "known" is given: the truth one interval before the first sample; else None."""
    states = known_states(experiment, (experiment.seed,), experiment.order)
    return states if states is None or states.ndim == 2 else states[0]


def run_experiment(experiment: Experiment, *, remember: bool = True) -> Result:
    """Run it: truth, measurements, track, stability, metrics.

    Args:
        experiment: what is run.
        remember: whether short runs of methods are remembered; one of many that nobody will ask for again need not be.
    """
    samples = experiment.samples
    short = samples <= CACHED_SAMPLES and samples * (experiment.members or 0) <= CACHED_WEIGHTS
    if experiment.method is not None and short and remember:
        return _remembered_run(experiment)
    return _run(experiment)


def _run(experiment: Experiment) -> Result:
    truth, measurements, noise_std = observe(experiment)
    before, selection, gate = known_state(experiment), None, None
    if experiment.method is None:
        gains = experiment.gains()
        gate = gate_of(experiment, gains, noise_std)
        track = run_filter(measurements, gains, start=experiment.start, initial_state=before, gate=gate)
    else:
        selection = experiment.method.run(
            measurements, experiment.order, truth=truth, start=experiment.start, initial_state=before,
            **experiment.parameters(),
        )  # fmt: skip
        track = selection.track
        gains = Gains.normalised(selection.gains_at(experiment.samples, 0)).to(experiment.convention)
    verdict = assess(gains)
    # Gains that change have no steady lag.
    steady = verdict.stable and selection is None
    return Result(
        experiment=experiment,
        gains=gains,
        verdict=verdict,
        truth=truth,
        measurements=measurements,
        noise_std=noise_std,
        track=track,
        metrics=measure(track, measurements, truth, gains, stable=steady, pushes=pushes_of(experiment)),
        selection=selection,
        gate=gate,
    )


def pushes_of(experiment: Experiment) -> float:
    """What random pushes add to the first derivative that the filter does not model, in each axis, m/s^order.

    The root mean square of what they add and no true state shows; infinite where they are impulses of it.
    """
    return held_std(experiment.manoeuvre, experiment.order, experiment.manoeuvre_std or 0.0)


def strength_of(experiment: Experiment) -> float:
    """How strong the target manoeuvres for a filter of that order, m/s^order: see `metrics.manoeuvre_strength`."""
    return _strength(experiment.order, pushes_of(experiment), *(getattr(experiment, name) for name in SEEN))


@lru_cache(maxsize=64)
def _strength(order: int, pushes: float, *seen: Any) -> float:
    """A number is kept where a run, which may be long, is not."""
    observed = _remembered if seen[SEEN.index("samples")] <= CACHED_SAMPLES else _observe
    return manoeuvre_strength(observed(*seen)[0], order, pushes)


def suited(experiment: Experiment, suggestion: Suggestion) -> Experiment:
    """The same target under a suggested filter; of a recording the noise is that which was found."""
    values = dict(suggestion.values)
    noise_std = values.pop("noise_std")
    if experiment.target.measured:
        experiment = replace(experiment, noise_std=noise_std, gate=None)
    return experiment.with_filter({"convention": experiment.convention} | values)


def gate_of(experiment: Experiment, gains: Gains, noise_std: tuple[float, ...]) -> Gate | None:
    """The outlier gate of an experiment; None for none.

    Raises:
        InputError: for an axis whose sensor has no error: nothing else says how large an innovation may be.
    """
    if experiment.gate is None:
        return None
    if not all(noise_std):
        raise InputError("gate", "must be left out where the sensor of an axis has no error", experiment.gate)
    return default_gate(gains, noise_std, experiment.interval, experiment.gate)


@lru_cache(maxsize=8)
def _remembered_run(experiment: Experiment) -> Result:
    result = _run(experiment)
    arrays = [result.track.predicted, result.track.smoothed, result.track.innovation]
    if result.selection is not None:
        arrays.append(result.selection.gains)
    for array in arrays:
        array.setflags(write=False)
    return result
