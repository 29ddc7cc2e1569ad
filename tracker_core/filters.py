"""One filter function for every order, number of axes, start, gap and interval.

predict   x_pred = F(T) x_est
innovate  e = z - x_pred[0]
correct   x_est = x_pred + K e,  K[i] = g[i] / T^i

A gate may stand between the last two: see `tracker_core.gating`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tracker_core.checks import POSITIVE, InputError, check_choice
from tracker_core.conventions import Gains
from tracker_core.gating import Gate, gated_run
from tracker_core.starts import STARTS, start_axes, start_axis
from tracker_core.types import FloatArray, Measurements, Track

STOP_LIMIT = 1e12
"""The run stops when a smoothed position passes this magnitude, m."""

EVEN = 0.01
"""Share of a constant interval by which the time between two samples may differ from it."""


@dataclass(frozen=True, slots=True)
class Setting:
    """A run before its first sample: checked measurements, and how the filter begins.

    Attributes:
        z: shape (n_samples, n_axes), m; NaN where a measurement is missing.
        columns: the same, shape (n_axes, n_samples), contiguous. A copy: for arrays that may not be written, such as
            those of an experiment, all would be compiled again.
        dt: the interval before each sample, or the one number if it is constant, s.
        order: of the filter.
        start: a name in STARTS.
        initial_state: shape (n_axes, order) for the start "known", else None.
        limit: magnitude of a smoothed position at which the run stops, m.
    """

    z: FloatArray
    columns: FloatArray
    dt: FloatArray
    order: int
    start: str
    initial_state: FloatArray | None
    limit: float

    def column(self, axis: int) -> FloatArray:
        """The measurements of one axis."""
        return self.columns[axis]

    def room(self) -> FloatArray:
        """Room for the states of every axis: axis first while filtering, so that each is contiguous."""
        samples, axes = self.z.shape
        return np.empty((axes, samples, self.order))

    def begin(self, axis: int, g: FloatArray, predicted: FloatArray, smoothed: FloatArray) -> tuple[FloatArray, int]:
        """Start one axis with gains g; its order may be below that of the setting. See `starts.start_axis`."""
        given = None if self.initial_state is None else self.initial_state[axis, : len(g)]
        return start_axis(self.start, self.column(axis), self.dt, g, given, predicted, smoothed)

    def track(self, predicted: FloatArray, smoothed: FloatArray, stop: int) -> Track:
        """The track from arrays of shape (n_axes, n_samples, order), filled up to sample `stop`."""
        from tracker_core import kernels  # compiled code is loaded when the first filter runs

        innovation = np.empty(self.columns.shape)
        missing = kernels.finish(self.columns, stop, predicted, smoothed, innovation)
        return self.finished(predicted, smoothed, innovation, missing, stop)

    def finished(
        self, predicted: FloatArray, smoothed: FloatArray, innovation: FloatArray, missing: int, stop: int
    ) -> Track:
        """The track from arrays that `kernels.finish` has seen."""
        return Track(
            predicted=predicted.transpose(1, 0, 2),
            smoothed=smoothed.transpose(1, 0, 2),
            innovation=innovation.T,
            missing=missing,
            stopped_at=stop if stop < len(self.z) else None,
            limit=self.limit,
        )


def set_up(
    measurements: Measurements,
    order: int,
    *,
    start: str = "two-point",
    initial_state: FloatArray | None = None,
    limit: float = STOP_LIMIT,
) -> Setting:
    """Check what a filter is given; arguments and errors as for `run_filter`."""
    z = check_measurements(measurements)
    check_start(start, order, initial_state, z.shape[1])
    POSITIVE.check("limit", limit)
    given = None if initial_state is None else np.asarray(initial_state, dtype=np.float64)
    return Setting(z, np.array(z.T, order="C"), _intervals(measurements), order, start, given, float(limit))


def run_filter(
    measurements: Measurements,
    gains: Gains,
    *,
    start: str = "two-point",
    initial_state: FloatArray | None = None,
    limit: float = STOP_LIMIT,
    gate: Gate | None = None,
) -> Track:
    """Track every axis with the same gains.

    Args:
        measurements: n_samples by n_axes positions; NaN is bridged by prediction.
        gains: two, three or four gains; they set the order.
        start: a name in STARTS.
        initial_state: shape (n_axes, order), SI units; the state one interval before the first sample. Needed by
            the start "known" and by no other. Where the interval varies, the first one counts as that interval.
        limit: magnitude of a smoothed position, m, at which the run stops.
        gate: refuses measurements that lie too far from their prediction; they are bridged like missing ones. None
            believes everything.

    Returns:
        The track; samples after a stop are NaN. Where the gate refuses nothing it is that without a gate, bit for bit.

    Raises:
        InputError: for arrays that do not fit together, times that do not increase or contradict the interval, an axis
            with fewer measurements than the start needs, an unknown start, or a gate for another number of axes.
    """
    setting = set_up(measurements, gains.order, start=start, initial_state=initial_state, limit=limit)
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    predicted, smoothed = setting.room(), setting.room()
    g, innovation = gains.vector, np.empty(setting.columns.shape)
    if gate is not None:
        stop, spread, rejected = gated_run(
            setting.columns, setting.dt, g, gate, start, setting.initial_state, setting.limit, predicted, smoothed
        )
        return replace(setting.track(predicted, smoothed, stop), rejected=rejected, spread=spread.T)
    states, begins = start_axes(
        setting.start, setting.columns, setting.dt, g, setting.initial_state, predicted, smoothed
    )
    stop, missing = kernels.track(
        setting.columns, setting.dt, g, states, begins, setting.limit, predicted, smoothed, innovation
    )
    return setting.finished(predicted, smoothed, innovation, missing, stop)


def check_measurements(measurements: Measurements) -> FloatArray:
    """The positions, if measurements fit together and can be filtered."""
    z = np.asarray(measurements.positions, dtype=np.float64)
    times = np.asarray(measurements.times, dtype=np.float64)
    if z.ndim != 2 or z.shape[1] < 1:
        raise InputError("positions", "must have shape (n_samples, n_axes)", z.shape)
    if times.shape != (z.shape[0],):
        raise InputError("times", f"must have shape ({z.shape[0]},) like the positions", times.shape)
    if np.isinf(z).any():
        raise InputError("positions", "must be finite or NaN", "an infinite number")
    if not np.isfinite(times).all():
        raise InputError("times", "must be finite", "an infinite or missing time")
    if measurements.interval is not None:
        _check_even(times, POSITIVE.check("interval", measurements.interval))
    else:
        intervals_of(times)
    return z


def _check_even(times: FloatArray, interval: float) -> None:
    """Refuse times that say otherwise than the interval."""
    steps = np.diff(times)
    aside = np.abs(steps - interval)
    if (aside <= EVEN * interval).all():
        return
    # Stamps far from zero are rounded.
    wrong = aside > EVEN * interval + 4 * np.spacing(np.abs(times[1:]))
    if wrong.any():
        raise InputError(
            "times",
            f"must follow each other by the interval, {interval:g} s, where one is given",
            f"{float(steps[wrong][0])} s between two",
        )


def check_start(start: str, order: int, initial_state: FloatArray | None, axes: int) -> None:
    """Refuse an unknown start, one that does not suit the order, and an initial state of another shape."""
    check_choice("start", start, STARTS)
    if order < STARTS[start].least_order:
        raise InputError("start", f"must not be '{start}' for a filter of order {order}", start)
    if (start == "known") != (initial_state is not None):
        raise InputError("initial_state", "must be given with the start 'known' and with no other", start)
    if initial_state is not None:
        state = np.asarray(initial_state)
        if state.shape != (axes, order):
            raise InputError("initial_state", f"must have shape ({axes}, {order})", state.shape)
        if not np.isfinite(state).all():
            raise InputError("initial_state", "must be finite", state.tolist())


def _intervals(measurements: Measurements) -> FloatArray:
    """The interval before each sample, or the one number if it is constant."""
    if measurements.interval is not None:
        return np.array([measurements.interval], dtype=np.float64)
    return intervals_of(np.asarray(measurements.times, dtype=np.float64))


def intervals_of(times: FloatArray) -> FloatArray:
    """The interval before each sample, s, shape (n_samples,) like the times; the first one counts twice.

    Raises:
        InputError: for fewer than two samples, or times that do not increase.
    """
    if len(times) < 2:
        raise InputError("times", "must hold at least 2 samples where no interval is given", len(times))
    steps = np.diff(times)
    if not (steps > 0).all():
        raise InputError("times", "must increase from sample to sample", f"{float(steps.min())} s between two")
    return np.concatenate((steps[:1], steps))
