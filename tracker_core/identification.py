"""Sensor and manoeuvre noise from measurements alone, by maximum likelihood of the innovations.

The model is that of `tracker_core.optimal`, with pushes of constant power where the intervals vary: over a time t an
acceleration that is held has the variance sigma_w^2 T/t (order 2), an increment sigma_w^2 t/T (orders 3 and 4).
What a target does is rarely white: the estimates describe the noise with which the model's filter tracks it best.
Mehra 1970, IEEE Trans. Automatic Control 15, 175-184; Bar-Shalom, Li & Kirubarajan 2001, Estimation with Applications
to Tracking and Navigation, section 5.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log, nan, prod, sqrt
from statistics import NormalDist

import numpy as np

from tracker_core.consistency import chi_square_quantile
from tracker_core.design.kalata import TRACKING_INDEX
from tracker_core.design.steady_kalman import optimal_gains, time_power
from tracker_core.likelihood import EXACT, HIGHEST, LOWEST, Likelihood, likelihood
from tracker_core.types import BoolArray, FloatArray, Measurements

BELIEVED = 4.5
"""Standard deviations from what all others say at which a measurement is set aside; of several axes, the distance that
is as rare."""

MOST_SET_ASIDE = 0.2
"""Where more than this share would have to be set aside, none is: so many are no outliers, but how the sensor is."""

LEVEL = 0.95

_ROUNDS, _FIRST = 10, 2
_MOST_AT_FIRST = 0.5
_ROUGH, _FINE, _CROSSING = 0.02, 1e-8, 1e-5
_QUARTILE = NormalDist().inv_cdf(0.75)
_LEAST_SHARE = 0.05


@dataclass(frozen=True, slots=True)
class Identified:
    """The noise that makes measurements most likely under a model.

    Attributes:
        order: of the model.
        interval: T, s, that the tracking index belongs to.
        sensor_std: of each axis, m; 0 for an axis that a polynomial of degree order - 1 explains but for rounding.
        process_std: sigma_w of each axis: m/s^2 (orders 2 and 3), m/s^3 (order 4).
        tracking_index: sigma_w T^2/sigma (order 4: T^3), common to the axes; the ends of its domain stand for no
            manoeuvre at all and no noise at all.
        index_interval: its 95 % interval by the likelihood ratio; an end is that of the domain where none is found.
        log_likelihood: of the innovations that were counted; None where no axis has any but rounding.
        aic, bic: Akaike's and Schwarz's criteria, less is better; None with it. The noise of every axis and the
            tracking index are counted as parameters.
        count: innovations in the likelihood, of all axes.
        samples: that were used: all, or evenly spread blocks of more than MOST_SAMPLES.
        set_aside: shape (n_samples,) of the measurements, those that were left out as outliers.
        crowded: whether more than MOST_SET_ASIDE would have been set aside, so that none was.
    """

    order: int
    interval: float
    sensor_std: tuple[float, ...]
    process_std: tuple[float, ...]
    tracking_index: float
    index_interval: tuple[float, float]
    log_likelihood: float | None
    aic: float | None
    bic: float | None
    count: int
    samples: int
    set_aside: BoolArray
    crowded: bool

    @property
    def rejected(self) -> int:
        """How many samples were set aside."""
        return int(self.set_aside.sum())

    @property
    def manoeuvre_found(self) -> bool:
        """Whether a target without manoeuvres is unlikely, at the 5 % level."""
        return self.log_likelihood is not None and self.index_interval[0] > TRACKING_INDEX.low

    @property
    def noise_found(self) -> bool:
        """Whether a sensor without noise is unlikely, at the 5 % level."""
        return self.log_likelihood is not None and self.index_interval[1] < TRACKING_INDEX.high

    @property
    def suggested_index(self) -> float:
        """What to build a filter on.

        The estimate; without a manoeuvre the upper end of its interval, because no target flies straight for ever; if
        neither manoeuvre nor noise is certain and the estimate is nothing, noise and manoeuvre as large as one another.
        """
        if self.noise_found and not self.manoeuvre_found:
            return self.index_interval[1]
        return self.tracking_index if self.tracking_index > TRACKING_INDEX.low else 1.0

    @property
    def gains(self) -> FloatArray:
        """The steady Kalman filter's for the suggested index, normalised, shape (order,)."""
        return optimal_gains(self.order, self.suggested_index)


def identify(
    measurements: Measurements, order: int, *, robust: bool = True, interval: float | None = None
) -> Identified:
    """Estimate sensor and manoeuvre noise.

    Outliers are measurements that lie far from what all others, before and after them, say of their place: the start of
    a manoeuvre is told from them by what comes after it. They are set aside, all is estimated anew, and all
    measurements are judged again until nothing changes; at first by the median of their distances, which outliers move
    little, then by the estimate.

    Args:
        measurements: n_samples by n_axes positions, NaN where one is missing; ten of each axis or more.
        order: 2, 3 or 4.
        robust: whether to set outliers aside.
        interval: s, that the tracking index shall belong to; by default that of the measurements, or the median one.

    Raises:
        InputError: for measurements that do not fit together, too few, or another order.
    """
    model = likelihood(measurements, order, interval)
    kept, place = _believed(model, by_median=True) if robust else (model, None)
    if kept is None:
        # The median of the distances says little of measurements in coarse steps, or of a target that often rests.
        kept, place = _believed(model, by_median=False)
    crowded = kept is None
    return fitted(model if kept is None else kept, place, crowded=crowded)


def fitted(model: Likelihood, start: float | None = None, *, crowded: bool = False) -> Identified:
    """The estimate from the samples that a likelihood believes; the search begins at a logarithm, if one is given."""
    live = model.live()
    index, ends, value = TRACKING_INDEX.high, (TRACKING_INDEX.low, TRACKING_INDEX.high), None
    if live.any():
        profile = model.profile(live)
        place, value = profile.peak(_FINE) if start is None else profile.peak_near(start, _FINE)
        nothing = profile.at(LOWEST)
        # So near to no manoeuvre at all the profile is flat, but for rounding.
        place, value = (LOWEST, nothing) if value - nothing < 1e-9 * abs(value) + 1e-6 else (place, value)
        level = value - chi_square_quantile(1, LEVEL) / 2
        low, high = (profile.crossing(place, value, level, end, _CROSSING) for end in (LOWEST, HIGHEST))
        index = _index(place)
        ends = (
            TRACKING_INDEX.low if low is None else _index(low),
            TRACKING_INDEX.high if high is None else _index(high),
        )
    std = np.where(live, model.sensor_std(index), 0.0)
    process = index * std / model.interval ** time_power(model.order)
    count, parameters = int(model.counts()[live].sum()), int(live.sum()) + 1
    set_aside = np.zeros(len(model.rows), dtype=bool)
    set_aside[model.rows] = ~model.used
    return Identified(
        order=model.order,
        interval=model.interval,
        sensor_std=tuple(std.tolist()),
        process_std=tuple(process.tolist()),
        tracking_index=index,
        index_interval=ends,
        log_likelihood=value,
        aic=None if value is None else 2 * parameters - 2 * value,
        bic=None if value is None else parameters * log(count) - 2 * value,
        count=count,
        samples=int(model.rows.sum()),
        set_aside=set_aside,
        crowded=crowded,
    )


def _believed(model: Likelihood, *, by_median: bool) -> tuple[Likelihood | None, float | None]:
    """The likelihood of the measurements that are no outliers, None if there are too many; and where it is greatest.

    The first scale is the median of the distances, or the estimate.
    """
    place: float | None = None
    measured = ~np.isnan(model.columns).all(axis=0)
    for turn in range(_ROUNDS):
        live = model.live()
        if not live.any():
            break
        profile = model.profile(live)
        place, _ = profile.peak(_ROUGH) if place is None else profile.peak_near(place, _ROUGH)
        distances = np.abs(model.deletions(_index(place)))
        likely = np.maximum(np.where(live, model.sensor_std(_index(place)), 0.0), model.rounding)
        scale = likely
        if turn == 0 and by_median:
            typical = np.array([np.median(row[~np.isnan(row)]) if (~np.isnan(row)).any() else nan for row in distances])
            typical /= _QUARTILE
            scale = np.maximum(np.where(np.isnan(typical), likely, typical), _LEAST_SHARE * likely)
            scale = np.minimum(scale, likely)
        used = _judged(model.used, distances, scale)
        settled = bool((used == model.used).all())
        # At first, neighbours of outliers look like some.
        most = _MOST_AT_FIRST if turn < _FIRST and not settled else MOST_SET_ASIDE
        if (~used & measured).sum() > most * measured.sum():
            return None, None
        if settled:
            break
        model = model.believing(used)
    return model, place


def _judged(unknown: BoolArray, distances: FloatArray, scale: FloatArray) -> BoolArray:
    """Which samples are believed: distances (n_axes, n) in units of a scale (n_axes,) are not too large together.

    Where no distance is known, `unknown` (n,) says it.
    """
    squares = (distances / np.where(scale > 0, scale, 1.0)[:, None]) ** 2
    axes = (~np.isnan(squares)).sum(axis=0)
    rare = 2 * (1 - NormalDist().cdf(BELIEVED))
    bounds = np.array([nan, *(chi_square_quantile(k, 1 - rare) for k in range(1, len(scale) + 1))])
    with np.errstate(invalid="ignore"):
        fine = np.nansum(squares, axis=0) <= bounds[axes]
    return np.where(axes > 0, fine, unknown)


def _index(place: float) -> float:
    """The tracking index with a logarithm; the ends are those of its domain to the last digit."""
    if place in {LOWEST, HIGHEST}:
        return TRACKING_INDEX.low if place == LOWEST else TRACKING_INDEX.high
    return exp(place)


def measured_std(measurements: Measurements) -> tuple[float, ...]:
    """A quick estimate of the sensor's noise on every axis, m, from third differences of neighbouring measurements.

    A third difference of a path with constant acceleration is noise alone, of variance 20 sigma^2; over varying
    intervals a divided difference is scaled likewise. Their median is moved little by outliers and manoeuvres; noise
    whose errors are alike from one measurement to the next is underrated.

    Args:
        measurements: n_samples by n_axes positions, NaN where one is missing.

    Returns:
        One number per axis: 0 for fewer than four measurements, or a path without noise but for rounding.
    """
    found = []
    for column in measurements.positions.T:
        known = ~np.isnan(column)
        times = np.flatnonzero(known) if measurements.interval is not None else measurements.times[known]
        std = _typical(times.astype(np.float64), column[known])
        found.append(std if std > EXACT * np.abs(column[known]).max(initial=0.0) else 0.0)
    return tuple(found)


def _typical(times: FloatArray, values: FloatArray) -> float:
    """Median size of the third differences of a series, as the standard deviation of one value."""
    count = len(values) - 3
    if count < 1:
        return 0.0
    if (np.diff(times) == 1).all():
        differences = np.diff(values, 3) / sqrt(20)
    else:
        t = [times[k : k + count] for k in range(4)]
        weights = [1 / prod(t[k] - t[other] for other in range(4) if other != k) for k in range(4)]
        total = sum(weight * values[k : k + count] for k, weight in enumerate(weights))
        differences = total / np.sqrt(sum(weight**2 for weight in weights))
    return float(np.median(np.abs(differences))) / _QUARTILE
