"""How likely measurements are under a model, for every tracking index, and where that is greatest.

The innovations of the Kalman filter of a model are independent and normal with variances sigma^2 s, so that the density
of the measurements is the product of theirs (Schweppe 1965, IEEE Trans. Information Theory 11, 61-70). s depends on the
tracking index L alone; for a given L the sensor variance of an axis is the mean of e^2/s, and with it put in, one
number is left to be searched for (Harvey 1989, Forecasting, Structural Time Series Models and the Kalman Filter,
section 3.4).

The first `WARM` measurements of a stretch only say where the target is. They are as many for every order, so that the
likelihoods of several orders are those of the same measurements and may be compared.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log, pi

import numpy as np

from tracker_core.checks import POSITIVE, InputError
from tracker_core.design.kalata import TRACKING_INDEX
from tracker_core.filters import check_measurements
from tracker_core.peaks import Profile
from tracker_core.types import ORDERS, BoolArray, FloatArray, Measurements

LOWEST, HIGHEST = log(TRACKING_INDEX.low), log(TRACKING_INDEX.high)
"""Between these lies the logarithm of a tracking index."""

MOST_SAMPLES = 10_000
"""Of more samples than this, blocks that are spread evenly over them are used: they tell the noise to a percent."""

BLOCKS = 10

WARM = max(ORDERS)

LEAST_MEASUREMENTS = 10

LARGEST = 1e150
"""Position, m, whose square is a number."""

SILENCE = 100
"""Typical times between two measurements after which a target is taken for a new one."""

EXACT = 1e-12
"""Innovations smaller than this share of the largest position are rounding."""

_PROBE = 0.01
_APART = 1e9
_SQUARES, _LOGS, _PLAIN, _COUNT, _SUMS = range(5)


@dataclass(frozen=True, slots=True)
class Likelihood:
    """Measurements, and the model's order: all that the likelihood of a tracking index depends on.

    Attributes:
        order: of the model.
        interval: that the tracking index belongs to, s.
        rows: shape (n,), which samples of the measurements are used, in order.
        columns: shape (n_axes, n), m, less the first measurement of the axis; NaN where there is none.
        steps: shape (n,), time since the sample before, in intervals.
        groups: axes that are measured at the same times.
        silence: intervals without a measurement after which the target is taken for a new one.
        rounding: of each axis, the size of innovations that are nothing but rounding, m; shape (n_axes,).
        used: shape (n,), the samples that are believed.
    """

    order: int
    interval: float
    rows: BoolArray
    columns: FloatArray
    steps: FloatArray
    groups: tuple[tuple[int, ...], ...]
    silence: float
    rounding: FloatArray
    used: BoolArray

    def believing(self, used: BoolArray) -> Likelihood:
        """The same with other samples believed."""
        return replace(self, used=used)

    def sums(self, indices: FloatArray) -> FloatArray:
        """Of e^2/s, log s and e^2, and the number of innovations: shape (m, n_axes, 4), for unit sensor variance."""
        from tracker_core import kernels  # compiled code is loaded when the first likelihood is computed

        found = np.zeros((len(indices), len(self.columns), _SUMS))
        for group in self.groups:
            own = np.zeros((len(indices), len(group), _SUMS))
            columns = np.ascontiguousarray(self.columns[list(group)])
            kernels.profile(columns, self.used, self.steps, self.order, indices, self.silence, WARM, own)
            found[:, list(group)] = own
        return found

    def live(self) -> BoolArray:
        """Axes whose innovations are more than rounding, shape (n_axes,)."""
        sums = self.sums(np.array([_PROBE]))[0]
        return sums[:, _PLAIN] > sums[:, _COUNT] * self.rounding**2

    def counts(self) -> FloatArray:
        """Innovations of every axis that the likelihood is made of, shape (n_axes,)."""
        return self.sums(np.array([_PROBE]))[0, :, _COUNT]

    def profile(self, live: BoolArray) -> Profile:
        """Logarithm of the greatest likelihood of some axes, by the logarithm of the tracking index."""
        return Profile(lambda logs: self.values(logs, live), LOWEST, HIGHEST)

    def values(self, logs: FloatArray, live: BoolArray) -> FloatArray:
        """Logarithm of the greatest likelihood of some axes for tracking indices with these logarithms, shape (m,)."""
        sums = self.sums(np.exp(logs))[:, live]
        count = sums[..., _COUNT]
        terms = count * (np.log(2 * pi * sums[..., _SQUARES] / count) + 1) + sums[..., _LOGS]
        return np.nan_to_num(-terms.sum(axis=1) / 2, nan=-np.inf)

    def sensor_std(self, index: float) -> FloatArray:
        """The most likely standard deviation of the measurements for a tracking index, shape (n_axes,), m."""
        sums = self.sums(np.array([index]))[0]
        return np.sqrt(sums[:, _SQUARES] / sums[:, _COUNT])

    def deletions(self, index: float) -> FloatArray:
        """How far each measurement is from what the others say, for unit sensor variance: shape (n_axes, n).

        One that is not believed and has fewer than `order` believed ones before it is judged with time reversed, which
        makes no difference to the model where the intervals are alike, and hardly one elsewhere.
        """
        found = _deletions(self, index)
        silent = np.isnan(found) & ~np.isnan(self.columns) & ~self.used
        if not silent.any():
            return found
        steps = np.concatenate((self.steps[:1], self.steps[:0:-1]))
        turned = replace(self, columns=self.columns[:, ::-1], steps=steps, used=self.used[::-1].copy())
        return np.where(silent, _deletions(turned, index)[:, ::-1], found)


def _deletions(model: Likelihood, index: float) -> FloatArray:
    """The same as the kernel tells it: NaN for what is not believed and comes first."""
    from tracker_core import kernels  # compiled code is loaded when the first likelihood is computed

    found = np.empty(model.columns.shape)
    for group in model.groups:
        own = np.empty((len(group), len(model.steps)))
        columns = np.ascontiguousarray(model.columns[list(group)])
        kernels.deletions(columns, model.used, model.steps, model.order, index, model.silence, own)
        found[list(group)] = own
    return found


def likelihood(measurements: Measurements, order: int, interval: float | None = None) -> Likelihood:
    """The likelihood of a model of an order.

    Args:
        measurements: n_samples by n_axes positions, NaN where one is missing.
        order: 2, 3 or 4.
        interval: s, that tracking indices belong to; by default the interval of the measurements, where it varies the
            median one.

    Raises:
        InputError: for measurements that do not fit together, an axis with fewer than ten, or another order.
    """
    if order not in ORDERS:
        raise InputError("order", "must be 2, 3 or 4", order)
    z = check_measurements(measurements)
    fewest = int((~np.isnan(z)).sum(axis=0).min())
    if fewest < LEAST_MEASUREMENTS:
        raise InputError("positions", f"must hold {LEAST_MEASUREMENTS} measurements of every axis or more", fewest)
    largest = float(np.nanmax(np.abs(z)))
    if largest > LARGEST:
        raise InputError("positions", f"must be {LARGEST:g} m at most", largest)
    if measurements.interval is None:
        steps = np.diff(measurements.times)
        interval = float(np.median(steps)) if interval is None else POSITIVE.check("interval", interval)
        steps = np.concatenate(([1.0], steps / interval))
    else:
        interval = measurements.interval if interval is None else POSITIVE.check("interval", interval)
        steps = np.full(len(z), measurements.interval / interval)
    rows = _spread(len(z))
    steps = np.where(np.concatenate(([False], ~rows[:-1])), _APART, steps)[rows]
    z = z[rows]
    measured = ~np.isnan(z)
    since = np.diff(np.cumsum(steps)[measured.any(axis=1)])
    found = Likelihood(
        order=order,
        interval=interval,
        rows=rows,
        columns=np.array([column - column[known][0] for column, known in zip(z.T, measured.T, strict=True)]),
        steps=steps,
        groups=_alike(measured),
        silence=SILENCE * max(1.0, float(np.median(since))),
        rounding=EXACT * np.nanmax(np.abs(z), axis=0),
        used=np.ones(len(z), dtype=bool),
    )
    counted = int(found.counts().min())
    if counted < LEAST_MEASUREMENTS - WARM:
        raise InputError(
            "positions", f"must hold {LEAST_MEASUREMENTS} measurements of every axis without long gaps", counted + WARM
        )
    return found


def _spread(samples: int) -> BoolArray:
    """Which of so many samples are used: all, or blocks of neighbours."""
    rows = np.ones(samples, dtype=bool)
    if samples > MOST_SAMPLES:
        length = MOST_SAMPLES // BLOCKS
        rows[:] = False
        for begin in np.linspace(0, samples - length, BLOCKS).astype(int):
            rows[begin : begin + length] = True
    return rows


def _alike(measured: BoolArray) -> tuple[tuple[int, ...], ...]:
    """Axes that have the same columns (n, n_axes)."""
    groups: dict[bytes, list[int]] = {}
    for axis in range(measured.shape[1]):
        groups.setdefault(measured[:, axis].tobytes(), []).append(axis)
    return tuple(tuple(group) for group in groups.values())
