"""What a selection method is: a way of choosing the gains anew while the filter runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import exp
from typing import Any

import numpy as np

from tracker_core.adaptive.parameters import PARAMETERS
from tracker_core.checks import Domain, InputError
from tracker_core.filters import STOP_LIMIT, Setting, set_up
from tracker_core.types import ORDERS, FloatArray, IntArray, Measurements, Track, Truth

WORK_LIMIT = 500_000_000
"""Filter steps that one run of a method may take: some seconds."""

STORE_LIMIT = 8_000_000
"""Weights of bank members that one run may keep: 64 MB."""

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
        shares: shape (n_samples, K): each member's share in the track of a mixed bank; None elsewhere.
        speaker: shape (n_samples, n_axes): the member that alone is the track, -1 for none; None elsewhere.
        found: what was searched over the whole run, by name of the parameter: one number per axis or for all.
    """

    track: Track
    gains: FloatArray
    members: FloatArray | None = None
    shares: FloatArray | None = None
    speaker: IntArray | None = None
    found: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def weights(self) -> FloatArray | None:
        """Each member's share in the track, shape (n_samples, n_axes, K), NaN where nobody speaks; None without a bank.

        Made when it is asked for: a bank of which one member speaks is kept as the number of that member.
        """
        samples, axes, _ = self.gains.shape
        if self.shares is not None:
            return np.broadcast_to(self.shares[:, None, :], (samples, axes, self.shares.shape[1]))
        if self.speaker is None or self.members is None:
            return None
        weights = (self.speaker[..., None] == np.arange(len(self.members))).astype(np.float64)
        weights[self.speaker < 0] = np.nan
        return weights

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
class Shape:
    """What the rules of a method's parameters depend on.

    Attributes:
        samples, axes: of the measurements.
        order: of the filter.
        known_states: how many of the true states, from the position on, are known; 0 without a truth.
    """

    samples: int
    axes: int
    order: int
    known_states: int


@dataclass(frozen=True, slots=True)
class Problem:
    """What a method is given.

    Attributes:
        setting: the run before its first sample.
        truth: shape (n_samples, n_axes, 5); NaN where nobody knows it.
    """

    setting: Setting
    truth: FloatArray

    @property
    def shape(self) -> tuple[int, int, int]:
        """Samples, axes, order."""
        return (*self.setting.z.shape, self.setting.order)

    @property
    def interval(self) -> float:
        """The sampling interval, s; the median where it varies."""
        return float(np.median(self.setting.dt))

    def decays(self, memory: float) -> FloatArray:
        """What a window with a time constant, s, leaves of the past after each interval, shape that of `setting.dt`."""
        return np.array([exp(-t / memory) for t in self.setting.dt.tolist()])

    def true_state(self, which: int) -> FloatArray:
        """One true state of every axis, shape (n_axes, n_samples)."""
        return np.ascontiguousarray(self.truth[:, :, which].T)


@dataclass(slots=True)
class Draft:
    """The arrays that a method fills.

    Attributes:
        problem: what it was given.
        predicted, smoothed: shape (n_axes, n_samples, order).
        used: the gains, same shape.
        stops: where the axes were stopped; the number of samples for those that were not.
    """

    problem: Problem
    predicted: FloatArray
    smoothed: FloatArray
    used: FloatArray
    stops: list[int]

    @classmethod
    def of(cls, problem: Problem) -> Draft:
        """Nothing known yet."""
        room = problem.setting.room
        used = room()
        used.fill(np.nan)
        return cls(problem, room(), room(), used, [])

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
        work: the method itself: from a problem and the parameters, checked, to a selection.
        rule: refuses parameters that do not fit the shape of a run with an InputError.
        sentence: what it does, plainly.
        source: where it comes from.
        hindsight: from the parameters to the reason why no tracker could run it, in one line; empty for a causal one.
        counterpart: name of the causal method of the same idea; None for a causal one.
    """

    name: str
    title: str
    orders: tuple[int, ...]
    parameters: Mapping[str, Default]
    work: Callable[..., Selection]
    sentence: str
    source: str
    rule: Callable[[Shape, Mapping[str, Any]], None] = lambda _shape, _parameters: None
    hindsight: Callable[[Mapping[str, Any]], str] = lambda _: ""
    counterpart: str | None = None

    def defaults(self, interval: float) -> dict[str, Any]:
        """Every parameter that has one, by name."""
        values = {
            name: default(interval) if callable(default) else default for name, default in self.parameters.items()
        }
        return {name: value for name, value in values.items() if value is not None}

    def check(self, shape: Shape, start: str, interval: float, parameters: Mapping[str, Any]) -> dict[str, Any]:
        """The parameters, checked and filled up.

        Args:
            shape: of the run.
            start: a name in STARTS.
            interval: s; defaults depend on it.
            parameters: by name; None for the default.

        Raises:
            InputError: for an order or start that the method does not serve, a parameter that it does not know or
                that breaks a rule.
        """
        if shape.order not in self.orders:
            either = " or ".join(map(str, self.orders))
            raise InputError("order", f"must be {either} for the method '{self.name}'", shape.order)
        if start == "expanding":
            raise InputError("start", f"must not be 'expanding' for the method '{self.name}'", start)
        given = {name: value for name, value in parameters.items() if value is not None}
        for name, value in given.items():
            if name not in self.parameters:
                raise InputError(name, f"must be left out for the method '{self.name}'", value)
        filled = dict.fromkeys(self.parameters) | self.defaults(interval) | given
        checked = {
            name: None if value is None else PARAMETERS[name].read(name, value) for name, value in filled.items()
        }
        self.rule(shape, checked)
        return checked

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
            InputError: for what `check` refuses, and measurements that `run_filter` would refuse.
        """
        if order is None and len(self.orders) == 1:
            order = self.orders[0]
        order = int(Domain(min(ORDERS), max(ORDERS), whole=True).check("order", order))
        setting = set_up(measurements, order, start=start, initial_state=initial_state, limit=limit)
        samples, axes = setting.z.shape
        states = np.full((samples, axes, 5), np.nan) if truth is None else truth.states
        known = int(np.logical_and.accumulate(~np.isnan(states).any(axis=(0, 1))).sum())
        problem = Problem(setting, states)
        checked = self.check(Shape(samples, axes, order, known), start, problem.interval, parameters)
        return self.work(problem, **checked)


def check_work(field: str, value: Any, steps: int) -> None:
    """Refuse what would take too long: `steps` filter steps.

    Raises:
        InputError: naming the parameter to make smaller.
    """
    if steps > WORK_LIMIT:
        raise InputError(field, f"must be smaller: at most {WORK_LIMIT:,} filter steps a run, not {steps:,}", value)


def check_weights(shape: Shape, members: int, orders: int) -> None:
    """Refuse a bank whose weights would not fit: `members` of so many orders.

    Raises:
        InputError: naming the parameter to make smaller.
    """
    most = STORE_LIMIT // (shape.samples * orders)
    if members > most:
        raise InputError("members", f"must be <= {most} for {shape.samples:,} samples and order {shape.order}", members)
