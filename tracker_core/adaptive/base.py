"""What a selection method is: a way of choosing the gains anew while the filter runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tracker_core.adaptive.parameters import PARAMETERS
from tracker_core.checks import InputError
from tracker_core.filters import STOP_LIMIT, Setting, set_up
from tracker_core.types import STATE_NAMES, FloatArray, IntArray, Measurements, Track, Truth

WORK_LIMIT = 600_000_000
"""Filter steps that one run of a method may take: some seconds."""

STORE_LIMIT = 20_000_000
"""Weights of bank members that one run may return."""

Default = Any
"""A value, or a function from the sampling interval (s) to it."""


@dataclass(frozen=True, slots=True)
class Selection:
    """What a method made of the measurements.

    Attributes:
        track: predicted and smoothed states.
        gains: shape (n_samples, n_axes, order), normalised: what corrected that sample; NaN where nothing did (the
            start, a missing measurement, after a stop). For a weighted bank the weighted mean of its members' gains.
        members: shape (K, order), the gains of a bank's members, normalised; None without a bank.
        weights: shape (n_samples, n_axes, K): each member's share in the track; None without a bank.
        found: what was searched over the whole run, by name of the parameter: one number per axis or for all.
    """

    track: Track
    gains: FloatArray
    members: FloatArray | None = None
    weights: FloatArray | None = None
    found: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def gains_at(self, sample: int, axis: int) -> FloatArray:
        """The gains in use at a sample, shape (order,): the last ones up to it, else the first ones after it.

        Zeros where nothing was ever corrected.
        """
        used = np.flatnonzero(~np.isnan(self.gains[:, axis, 0]))
        if not used.size:
            return np.zeros(self.gains.shape[2])
        before = used[used <= sample]
        return self.gains[before[-1] if before.size else used[0], axis]


@dataclass(frozen=True, slots=True)
class Problem:
    """What a method is given: the run before its first sample, and, where it looks in hindsight, the truth."""

    setting: Setting
    truth: FloatArray | None

    @property
    def shape(self) -> tuple[int, int, int]:
        """Samples, axes, order."""
        return (*self.setting.z.shape, self.setting.order)

    @property
    def interval(self) -> float:
        """The sampling interval, s; the median where it varies."""
        return float(np.median(self.setting.dt))

    def true_state(self, which: int) -> FloatArray:
        """One true state of every axis, shape (n_axes, n_samples).

        Raises:
            InputError: where nobody knows it.
        """
        known = None if self.truth is None else self.truth[:, :, which]
        if known is None or np.isnan(known).any():
            raise InputError("objective", "must be a state whose truth is known", STATE_NAMES[which])
        return np.ascontiguousarray(known.T)


@dataclass(slots=True)
class Draft:
    """The arrays that a method fills, axis first."""

    problem: Problem
    predicted: FloatArray
    smoothed: FloatArray
    used: FloatArray
    stops: list[int]

    @classmethod
    def of(cls, problem: Problem) -> Draft:
        """Nothing known yet."""
        blank = problem.setting.blank
        return cls(problem, blank(), blank(), blank(), [])

    def begin(self, axis: int) -> tuple[FloatArray, int]:
        """The state after the start of an axis, and where its recursion begins: past the end if it was stopped."""
        setting = self.problem.setting
        predicted, smoothed = self.predicted[axis], self.smoothed[axis]
        state, begin = setting.begin(axis, np.ones(setting.order), predicted, smoothed)
        over = np.flatnonzero(np.abs(smoothed[:begin, 0]) > setting.limit)
        if over.size:
            self.stops.append(int(over[0]))
            return state, len(setting.z)
        return state, begin

    def selection(self, **rest: Any) -> Selection:
        """The finished arrays."""
        samples = self.problem.shape[0]
        stop = min(self.stops, default=samples)
        self.used[:, stop + 1 :] = np.nan
        track = self.problem.setting.track(self.predicted, self.smoothed, stop)
        return Selection(track, self.used.transpose(1, 0, 2), **rest)


@dataclass(frozen=True, slots=True)
class Method:
    """A way of choosing the gains while the filter runs.

    Attributes:
        name: key in the registry.
        title: for menus.
        orders: the filter orders that it serves, ascending.
        parameters: what it is told, with defaults; names are fields of the experiment. A default of None is searched.
        work: the method itself: from a problem and the parameters to a selection.
        sentence: what it does, plainly.
        source: where it comes from.
        hindsight: from the parameters to the reason why no tracker could run it, in one line; empty for a causal one.
        counterpart: name of the causal method of the same idea, and the parameters it takes over; None for a causal
            one.
        needs_truth: whether it cannot run without the truth.
    """

    name: str
    title: str
    orders: tuple[int, ...]
    parameters: Mapping[str, Default]
    work: Callable[..., Selection]
    sentence: str
    source: str
    hindsight: Callable[[Mapping[str, Any]], str] = lambda _: ""
    counterpart: str | None = None
    needs_truth: bool = False

    def defaults(self, interval: float) -> dict[str, Any]:
        """Every parameter that has one, by name."""
        values = {
            name: default(interval) if callable(default) else default for name, default in self.parameters.items()
        }
        return {name: value for name, value in values.items() if value is not None}

    def read(self, parameters: Mapping[str, Any], interval: float) -> dict[str, Any]:
        """The parameters, checked and filled up.

        Raises:
            InputError: for one it does not know, or that breaks its rule.
        """
        for name, value in parameters.items():
            if name not in self.parameters and value is not None:
                raise InputError(name, f"must be left out for the method '{self.name}'", value)
        given = {name: value for name, value in parameters.items() if value is not None}
        filled = dict.fromkeys(self.parameters) | self.defaults(interval) | given
        return {name: None if value is None else PARAMETERS[name].read(name, value) for name, value in filled.items()}

    def run(
        self,
        measurements: Measurements,
        order: int | None = None,
        *,
        truth: Truth | None = None,
        start: str = "two-point",
        initial_state: FloatArray | None = None,
        limit: float = STOP_LIMIT,
        **parameters: Any,
    ) -> Selection:
        """Track every axis.

        Args:
            measurements: n_samples by n_axes positions; NaN is bridged by prediction.
            order: of the filter; may be left out where the method serves one only.
            truth: what methods that look in hindsight at it need.
            start, initial_state, limit: as for `run_filter`; the start "expanding" is itself such a method.
            parameters: by name; what is left out takes its default.

        Raises:
            InputError: for an order or a start it does not serve, a missing truth, a parameter that breaks its rule,
                more work than WORK_LIMIT, or measurements that `run_filter` would refuse.
        """
        if order is None and len(self.orders) == 1:
            order = self.orders[0]
        if order not in self.orders:
            either = " or ".join(map(str, self.orders))
            raise InputError("order", f"must be {either} for the method '{self.name}'", order)
        if start == "expanding":
            raise InputError("start", f"must not be 'expanding' for the method '{self.name}'", start)
        if self.needs_truth and truth is None:
            raise InputError("design", "must be one that needs no truth where there is none", self.name)
        setting = set_up(measurements, order, start=start, initial_state=initial_state, limit=limit)
        problem = Problem(setting, None if truth is None else truth.states)
        return self.work(problem, **self.read(parameters, problem.interval))


def check_work(field: str, value: Any, steps: int) -> None:
    """Refuse what would take too long.

    Raises:
        InputError: naming the parameter to make smaller.
    """
    if steps > WORK_LIMIT:
        raise InputError(field, f"must be smaller: at most {WORK_LIMIT:,} filter steps a run, not {steps:,}", value)


def check_store(field: str, members: int, samples: int, axes: int) -> None:
    """Refuse a bank whose weights would not fit.

    Raises:
        InputError: naming the parameter to make smaller.
    """
    if members * samples * axes > STORE_LIMIT:
        rule = f"must be <= {STORE_LIMIT // (samples * axes)} for {samples:,} samples of {axes} axes"
        raise InputError(field, rule, members)


def one_hot(chosen: IntArray, members: int) -> FloatArray:
    """Weights of a bank in which one member speaks: chosen (n_axes, n_samples), -1 for none; NaN there."""
    weights = np.zeros((chosen.shape[1], chosen.shape[0], members))
    rows, axes = np.nonzero(chosen.T >= 0)
    weights[rows, axes, chosen.T[rows, axes]] = 1.0
    weights[chosen.T < 0] = np.nan
    return weights
