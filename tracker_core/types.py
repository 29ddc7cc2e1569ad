"""The data that flows: gains, truth, measurements, track. Frozen; arrays are float64 and time comes first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

ORDERS = (2, 3, 4)
GAIN_NAMES = ("alpha", "beta", "gamma", "eta")
STATE_NAMES = ("position", "velocity", "acceleration", "jerk")

HANDOVER = 1 + 1e-12
"""Least squares over all measurements gives way to a filter once its position gain is at most alpha times this.

Its gains are fractions such as 7/10: rounding, which no two programs share, must not decide whether one has fallen to
an alpha of 0.7.
"""


@dataclass(frozen=True, slots=True)
class Truth:
    """What the target really did.

    Attributes:
        times: shape (n_samples,), s.
        states: shape (n_samples, n_axes, 5): position, velocity, acceleration, jerk and snap of every axis,
            in m, m/s, ..., m/s^4; NaN where nobody knows it.
    """

    times: FloatArray
    states: FloatArray

    @property
    def positions(self) -> FloatArray:
        """Shape (n_samples, n_axes), m."""
        return self.states[:, :, 0]

    @property
    def known(self) -> bool:
        """Whether the position is known at any sample."""
        return not bool(np.isnan(self.states[:, :, 0]).all())


@dataclass(frozen=True, slots=True)
class Measurements:
    """What the sensor said.

    Attributes:
        times: shape (n_samples,), s, strictly increasing.
        positions: shape (n_samples, n_axes), m; NaN where a measurement is missing.
        interval: the sampling interval in s where it is constant and the times lie on it, else None.
    """

    times: FloatArray
    positions: FloatArray
    interval: float | None

    @property
    def is_even(self) -> bool:
        """Whether every axis was measured at every sample, at a constant interval."""
        return self.interval is not None and not np.isnan(self.positions).any()


@dataclass(frozen=True, slots=True)
class Track:
    """What the filter made of the measurements.

    Attributes:
        predicted: shape (n_samples, n_axes, order), the state before the measurement of that sample was seen;
            NaN before the filter predicts and after it was stopped.
        smoothed: same shape, the state after it; NaN before the start and after a stop.
        innovation: shape (n_samples, n_axes), m: measurement minus predicted position; NaN where either is missing.
        missing: number of missing measurements (axis values) that were bridged by prediction.
        stopped_at: index of the sample at which the magnitude of a smoothed position passed `limit`; None if none did.
        limit: that magnitude, m.
        rejected: shape (n_samples,), the samples that a gate refused; they too were bridged by prediction. None where
            no gate watched.
        spread: shape (n_samples, n_axes), m: with a gate, the standard deviation that it expected of the innovation;
            NaN until that is known, and after a stop.
    """

    predicted: FloatArray
    smoothed: FloatArray
    innovation: FloatArray
    missing: int
    stopped_at: int | None
    limit: float
    rejected: BoolArray | None = None
    spread: FloatArray | None = None

    @property
    def believed(self) -> FloatArray:
        """The innovation, m, with NaN at the samples that a gate refused; shape (n_samples, n_axes)."""
        return self.innovation if self.rejected is None else np.where(self.rejected[:, None], np.nan, self.innovation)
