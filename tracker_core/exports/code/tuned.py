"""What an exported filter is made from, and the ten measurements with which it proves itself."""

from __future__ import annotations

from dataclasses import dataclass
from sys import float_info

import numpy as np

from tracker_core.checks import InputError
from tracker_core.conventions import Gains
from tracker_core.filters import STOP_LIMIT, run_filter, set_up
from tracker_core.gating import Gate
from tracker_core.run import Result, known_state
from tracker_core.starts import STARTS
from tracker_core.types import FloatArray, Measurements, Track

TRIAL = 10
"""Measurements that the self-test of an exported filter runs."""


@dataclass(frozen=True, slots=True)
class Trial:
    """Measurements, and what the filter makes of them.

    Attributes:
        intervals: before each sample, shape (n,), s.
        measured: shape (n, n_axes), m; NaN where missing.
        smoothed: shape (n, n_axes), m.
        state: shape (n_axes, order), SI units: the state before the first sample at which every axis is past its
            start.
        onward: the samples from there on, shape (at most TRIAL, n_axes), NaN where missing or refused by the gate;
            those too at which the filter had stopped, as long as there are numbers.
        onward_intervals, onward_smoothed: as above for these samples.
    """

    intervals: FloatArray
    measured: FloatArray
    smoothed: FloatArray
    state: FloatArray
    onward: FloatArray
    onward_intervals: FloatArray
    onward_smoothed: FloatArray


@dataclass(frozen=True, slots=True)
class TunedFilter:
    """A filter with constant gains, and everything that its code says of it.

    Attributes:
        gains: in the convention in which they were tuned.
        interval: the nominal one, s.
        start: a name in STARTS.
        initial_state: shape (n_axes, order), one interval before the first measurement, for the start "known".
        limit: magnitude of a smoothed position, m, at which the filter stops.
        gate: refuses outliers, or None.
        axes: their names.
        trial: for the self-test.
        title: what the experiment is called; any text.
        origin: where it comes from, such as a link; any text.
    """

    gains: Gains
    interval: float
    start: str
    initial_state: FloatArray | None
    limit: float
    gate: Gate | None
    axes: tuple[str, ...]
    trial: Trial
    title: str = ""
    origin: str = ""

    @property
    def growing(self) -> bool:
        """Whether least squares goes on where the first measurements end."""
        return self.start == "expanding" and self.gains.vector[0] < 1

    @property
    def points(self) -> int:
        """Measurements that an axis uses up before it begins."""
        return self.gains.order if self.growing else STARTS[self.start].points


def tuned_filter(result: Result, *, title: str = "", origin: str = "") -> TunedFilter:
    """The filter of an experiment.

    Args:
        result: its run.
        title, origin: any text; see TunedFilter.

    Raises:
        InputError: for a method that chooses the gains as it runs, which no constant gains stand for.
    """
    if result.selection is not None:
        raise InputError("design", "must be one with constant gains to be exported", result.experiment.design)
    return describe(
        result.measurements, result.gains, start=result.experiment.start, initial_state=known_state(result.experiment),
        limit=result.track.limit, gate=result.gate, axes=result.scenario.axes, title=title or result.scenario.title,
        origin=origin,
    )  # fmt: skip


def describe(
    measurements: Measurements,
    gains: Gains,
    *,
    start: str = "two-point",
    initial_state: FloatArray | None = None,
    limit: float = STOP_LIMIT,
    gate: Gate | None = None,
    axes: tuple[str, ...],
    title: str = "",
    origin: str = "",
) -> TunedFilter:
    """The filter that `run_filter` is with these arguments; the first measurements serve as its trial.

    Raises:
        InputError: as `run_filter` does.
    """
    track = run_filter(measurements, gains, start=start, initial_state=initial_state, limit=limit, gate=gate)
    if len(axes) != track.smoothed.shape[1]:
        raise InputError("axes", f"must be {track.smoothed.shape[1]} names", axes)
    interval = measurements.interval
    if interval is None:
        interval = float(np.median(np.diff(measurements.times)))
    return TunedFilter(
        gains=gains, interval=float(interval), start=start,
        initial_state=None if initial_state is None else np.asarray(initial_state, dtype=np.float64),
        limit=float(limit), gate=gate, axes=axes, trial=_trial(measurements, track, gains, start, initial_state),
        title=title, origin=origin,
    )  # fmt: skip


def _trial(
    measurements: Measurements, track: Track, gains: Gains, start: str, initial_state: FloatArray | None
) -> Trial:
    z = np.asarray(measurements.positions, dtype=np.float64)
    left = z if track.rejected is None else np.where(track.rejected[:, None], np.nan, z)
    believed = Measurements(measurements.times, left, measurements.interval)
    setting = set_up(believed, gains.order, start=start, initial_state=initial_state)
    intervals = np.broadcast_to(setting.dt, len(z))
    # Where constant gains alone rule every axis: without what the gate refused the plain filter is the same.
    room = setting.room()
    begun = [setting.begin(axis, gains.vector, room[axis], room[axis].copy()) for axis in range(z.shape[1])]
    begin = max(sample for _, sample in begun)
    # No limit stops what goes on from there.
    free = track
    if track.stopped_at is not None:
        free = run_filter(believed, gains, start=start, initial_state=initial_state, limit=float_info.max)
    state = np.array([state for state, _ in begun]) if begin == 0 else free.smoothed[begin - 1]
    going = free.smoothed[begin : begin + TRIAL, :, 0]
    going = going[: np.append(np.isfinite(going).all(axis=1), False).argmin()]
    end = begin + len(going)
    return Trial(
        intervals[:TRIAL], z[:TRIAL], track.smoothed[:TRIAL, :, 0], state, left[begin:end], intervals[begin:end], going
    )
