"""The outlier gate: which measurements a filter believes.

A sample is refused, and bridged by prediction on all axes, where its normalised innovation

    d = sqrt(sum over the measured axes a of e_a^2 / S_a),   S_a = sensor_std_a^2 (P_a[0, 0] + 1)

exceeds the width. P, for a measurement variance of 1, is the covariance that the filter's own gains have on the model
of `tracker_core.optimal`, whether they suit it or not:

    predict   P = F P F' + Q
    correct   P = (I - K H) P (I - K H)' + K K'     where a measurement is believed, K that of the filter

Where the interval t differs from that of the tracking index, T, the model's noise keeps its power: a random walk of the
velocity (order 2, G = [t^2/2, t] w, variance of w times T/t), of the acceleration (order 3, G = [t^2/2, t, 1] w) or of
the jerk (order 4, G = [t^3/6, t^2/2, t, 1] w, variance of w times t/T).

The start. A given state has no error, and the gate watches from the first sample on. Else it watches once every axis
has had as many measurements as it has states, while an expanding memory still grows too. What they give of the state
has their least squares covariance. A filter that began with fewer, and took a derivative for zero, may be wrong by any
amount, whatever its sensor and its gains are. How wrong it is, its measurements tell: least squares over all of them
goes on beside it until its position gain has fallen to alpha, as in an expanding memory, and gives a state x_l with a
covariance P_l, on the model as above with the gains of least squares. With x the state of the filter, at the prediction

    S = sensor_std^2 (P_l[0, 0] + 1) + (x_l[0] - x[0])^2

and at the end P = P_l + (x_l - x)(x_l - x)'/sensor_std^2, which the filter forgets from then on as it forgets how it
was started. So the gate is as wide for a fast target as its start is wrong, and no wider for a slow one.

A track that is wrong itself, after a jump of the target or by an outlier among the first samples, must be able to find
its way back. While nothing is believed P grows by the model alone, which after a large jump takes thousands of samples.
So from PATIENCE refusals in a row on P is multiplied by DOUBT with each of them: what keeps contradicting the track is
taken for its error. P forgets this as the filter forgets its state, and the gate closes as the error dies out.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from tracker_core.checks import POSITIVE, Domain, InputError
from tracker_core.design.steady_kalman import time_power
from tracker_core.starts import begin_axis, first_polynomial
from tracker_core.types import BoolArray, FloatArray

WIDTH = Domain(1, 100)
INDEX = Domain(0, 1e6)

PATIENCE = 3
DOUBT = 4.0


@dataclass(frozen=True, slots=True)
class Gate:
    """Which innovations are believed.

    Attributes:
        width: the greatest normalised innovation that is believed, in standard deviations, 1 to 100; infinite to
            refuse nothing, where the spread alone is wanted.
        sensor_std: standard deviation of the measurements, m, > 0; one number, or one per axis. A number, a list or an
            array becomes a tuple.
        tracking_index: of the model on which the innovation's covariance is taken, 0 to a million.
        interval: that the tracking index belongs to, s, > 0.

    Raises:
        InputError: for a number outside its domain.
    """

    width: float
    sensor_std: tuple[float, ...]
    tracking_index: float
    interval: float

    def __post_init__(self) -> None:
        if self.width != inf:
            WIDTH.check("width", self.width)
        stds = np.atleast_1d(np.asarray(self.sensor_std, dtype=object)).tolist()
        if not stds:
            raise InputError("sensor_std", "must be one number, or one per axis", self.sensor_std)
        object.__setattr__(self, "sensor_std", tuple(POSITIVE.check("sensor_std", value) for value in stds))
        INDEX.check("tracking_index", self.tracking_index)
        POSITIVE.check("interval", self.interval)

    def stds(self, axes: int) -> tuple[float, ...]:
        """The standard deviation of every axis.

        Raises:
            InputError: where there is neither one number nor one per axis.
        """
        if len(self.sensor_std) not in {1, axes}:
            raise InputError("sensor_std", f"must be one number, or one per axis ({axes})", self.sensor_std)
        return self.sensor_std * axes if len(self.sensor_std) == 1 else self.sensor_std

    def noise_variance(self, order: int) -> float:
        """Variance of the model's noise w over `interval`, for a unit measurement variance.

        In 1/s^4, for order 4 in 1/s^6.
        """
        return (self.tracking_index / self.interval ** time_power(order)) ** 2


def gated_run(
    columns: FloatArray,
    dt: FloatArray,
    g: FloatArray,
    gate: Gate,
    start: str,
    given: FloatArray | None,
    limit: float,
    predicted: FloatArray,
    smoothed: FloatArray,
) -> tuple[int, FloatArray, BoolArray]:
    """Filter all axes with a gate.

    Args:
        columns: measurements, shape (n_axes, n_samples), m.
        dt: interval before each sample, or the one number if it is constant, s.
        g: shape (order,), normalised gains.
        gate: which of them are believed.
        start, given, limit: as for `run_filter`.
        predicted, smoothed: shape (n_axes, n_samples, order), filled in up to the sample of a stop.

    Returns:
        The sample at which the run stopped, n_samples if it did not; the spread, shape (n_axes, n_samples), NaN until
        an axis has had as many measurements as it has states; and what was rejected, shape (n_samples,).

    Raises:
        InputError: for a number of standard deviations that does not suit the axes, and when an axis has fewer
            measurements than the start needs.
    """
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    axes, samples = columns.shape
    sensor = np.array(gate.stds(axes))
    firsts = [
        begin_axis(start, columns[axis], dt, g, None if given is None else given[axis], predicted[axis], smoothed[axis])
        for axis in range(axes)
    ]
    # What its first measurements say of an axis that began with fewer.
    beside = [start != "known" and len(first.weights) < len(g) for first in firsts]
    guides = [
        first_polynomial(columns[axis], dt, len(g)) if beside[axis] else first for axis, first in enumerate(firsts)
    ]
    spread, rejected = np.full((axes, samples), np.nan), np.zeros(samples, dtype=np.bool_)
    stop = kernels.gated_track(
        columns,
        dt,
        g,
        np.array([first.state for first in firsts]),
        np.array([first.begin for first in firsts], dtype=np.int64),
        np.array([first.growing for first in firsts]),
        np.array([guide.state for guide in guides]),
        np.array([guide.begin for guide in guides], dtype=np.int64),
        np.array(beside),
        np.array([guide.covariance() for guide in guides]),
        sensor,
        float(gate.width),
        gate.noise_variance(len(g)),
        float(gate.interval),
        PATIENCE,
        DOUBT,
        limit,
        predicted,
        smoothed,
        spread,
        rejected,
    )
    return int(stop), spread, rejected
