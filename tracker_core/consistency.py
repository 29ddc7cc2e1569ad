"""Whether a filter's errors look as its model says: NEES and NIS with their chi-square bounds.

The normalised innovation squared (NIS) needs no truth, the normalised error squared (NEES) does. Both are measured by
the covariance that the filter's constant gains really have on the model, from the Joseph form, so that they also serve
gains that are not optimal. Innovations of such gains are correlated even if the model is right: an average of NIS then
tells as much as one of fewer independent values, see `average`.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from math import exp, inf, lgamma, log, sqrt
from statistics import NormalDist

import numpy as np

from tracker_core.checks import POSITIVE, Domain, InputError
from tracker_core.conventions import Gains
from tracker_core.gating import INDEX, WIDTH, Gate
from tracker_core.motion import transition
from tracker_core.optimal import distance_from_optimal, process_input
from tracker_core.responses import steady_covariance
from tracker_core.types import FloatArray

LEVEL = 0.95
DEGREES = Domain(1, 1e7)
LEVELS = Domain(1e-6, 0.999999)
SQUARE = Domain(0)

AXES = Domain(1, 1000, whole=True)


@dataclass(frozen=True, slots=True)
class ModelCovariance:
    """Steady covariance of the errors on a model, interval 1 and unit measurement variance.

    Attributes:
        predicted, smoothed: of the state before and after the measurement, shape (order, order).
        innovation: variance of the innovation.
        correlation: sum over all lags from 1 on of the squared autocorrelations of the innovations; 0 for the gains
            that are optimal on the model.
    """

    predicted: FloatArray
    smoothed: FloatArray
    innovation: float
    correlation: float


@dataclass(frozen=True, slots=True)
class Consistency:
    """The average of a statistic, and where it lies if the model is right.

    Attributes:
        mean: the average.
        low, high: the interval that holds it with the probability asked for.
        count: how many values were averaged.
    """

    mean: float
    low: float
    high: float
    count: int

    @property
    def holds(self) -> bool:
        """Whether the average lies in the interval."""
        return self.low <= self.mean <= self.high


def model_covariance(gains: Gains, tracking_index: float) -> ModelCovariance:
    """The covariance that any stable gains have on the model of `tracker_core.optimal`.

    P = (I - K H)(F P F' + Q)(I - K H)' + K K', the Joseph form, which holds for every gain. Innovations k samples apart
    have the covariance H F A^(k-1) (P- H' - K S), A = (I - K H) F, S the variance of one (Mehra 1970).

    Args:
        gains: any stable set.
        tracking_index: 0 for a target that keeps its highest derivative.

    Raises:
        InputError: for gains that are not stable by more than rounding, or a tracking index outside 0 to a million.
    """
    g, f = gains.vector, transition(gains.order, 1.0)
    drive = INDEX.check("tracking_index", tracking_index) * process_input(gains.order)
    left = drive - g * drive[0]
    smoothed = steady_covariance(gains, np.outer(left, left) + np.outer(g, g))
    predicted = f @ smoothed @ f.T + np.outer(drive, drive)
    innovation = float(predicted[0, 0]) + 1
    left = predicted[:, 0] - g * innovation
    squares = f[0] @ steady_covariance(gains, np.outer(left, left)) @ f[0]
    return ModelCovariance(predicted, smoothed, innovation, float(squares) / innovation**2)


def innovation_squared(innovations: FloatArray, variance: float) -> FloatArray:
    """NIS per value: the innovation squared over its variance, > 0; shape as given."""
    return innovations**2 / POSITIVE.check("variance", variance)


def error_squared(errors: FloatArray, covariance: FloatArray) -> FloatArray:
    """NEES per sample: e' P^-1 e.

    Args:
        errors: shape (..., order), derivative i times T^i.
        covariance: shape (order, order), in the same units.
    """
    whitened = np.linalg.solve(np.linalg.cholesky(covariance), np.moveaxis(errors, -1, 0).reshape(len(covariance), -1))
    return (whitened**2).sum(axis=0).reshape(errors.shape[:-1])


def average(values: FloatArray, dimension: int, level: float = LEVEL, correlation: float = 0.0) -> Consistency:
    """The average of values that are chi-square distributed if the model is right.

    The square of a normal variable that is correlated by r with another one's is correlated by r^2 with that one's
    square. So the average varies 1 + 2 correlation times as much as that of independent values, and has as many times
    fewer degrees of freedom.

    Args:
        values: in the order of time; NaN where there is none.
        dimension: degrees of freedom of one value.
        level: probability of the interval.
        correlation: sum over all lags from 1 on of the squared autocorrelations of what was squared.

    Returns:
        The average, NaN of no values at all, and its interval.
    """
    known = values[~np.isnan(values)]
    degrees = max(1.0, known.size * dimension / (1 + 2 * correlation))
    low, high = chi_square_interval(degrees, level)
    mean = float(known.mean()) if known.size else float("nan")
    return Consistency(mean, low * dimension / degrees, high * dimension / degrees, known.size)


def chi_square_interval(degrees: float, level: float = LEVEL) -> tuple[float, float]:
    """The central interval that holds a chi-square variable with a given probability.

    Args:
        degrees: of freedom, 1 to 10 million.
        level: probability, 1e-6 to 1 - 1e-6.

    Raises:
        InputError: for arguments outside.
    """
    DEGREES.check("degrees", degrees)
    LEVELS.check("level", level)
    return chi_square_quantile(degrees, (1 - level) / 2), chi_square_quantile(degrees, (1 + level) / 2)


def default_gate(gains: Gains, sensor_std: tuple[float, ...], interval: float, width: float) -> Gate:
    """A gate that expects of a filter what the model that suits its gains best makes it do.

    The model is that of `tracker_core.optimal.distance_from_optimal`; for unstable gains, which none suits, the target
    keeps its highest derivative.

    Args:
        gains: of the filter.
        sensor_std: standard deviation of the measurements, m, one number or one per axis.
        interval: nominal sampling interval, s.
        width: the greatest normalised innovation that is believed, 1 to 100.

    Raises:
        InputError: for a number outside its domain.
    """
    index = 0.0
    with suppress(InputError):
        index = distance_from_optimal(gains).tracking_index
    return Gate(width, sensor_std, index, interval)


def reject_probability(width: float, axes: int) -> float:
    """How often a gate refuses a right measurement: the tail of the chi-square distribution above width^2.

    Args:
        width: of the gate, 1 to 100.
        axes: that are measured jointly, a whole number from 1 on.

    Raises:
        InputError: for arguments outside.
    """
    return chi_square_tail(AXES.check("axes", axes), WIDTH.check("width", width) ** 2)


def believed_share(width: float, axes: int) -> float:
    """How much smaller NIS is if a gate refuses right measurements alone: its mean below width^2, over that of all.

    That is F(width^2; axes + 2)/F(width^2; axes), F the chi-square distribution function.

    Args:
        width: of the gate, 1 to 100.
        axes: that are measured jointly, a whole number from 1 on.

    Raises:
        InputError: for arguments outside.
    """
    kept = 1 - reject_probability(width, axes)
    return (1 - chi_square_tail(axes + 2, width**2)) / kept


@lru_cache(maxsize=256)
def chi_square_quantile(degrees: float, probability: float) -> float:
    """Where the chi-square distribution function has a value: safeguarded Newton from Wilson and Hilferty's cube.

    Args:
        degrees: of freedom, 1 to 10 million.
        probability: from 5e-7 to 1 - 5e-7.
    """
    spread = 2 / (9 * degrees)
    x = degrees * max(1e-3, 1 - spread + NormalDist().inv_cdf(probability) * sqrt(spread)) ** 3
    low, high = 0.0, inf
    for _ in range(200):
        miss = _gamma(degrees / 2, x / 2)[0] - probability
        low, high = (low, x) if miss > 0 else (x, high)
        slope = exp((degrees / 2 - 1) * log(x / 2) - x / 2 - lgamma(degrees / 2)) / 2
        after = x - miss / slope if slope > 0 else inf
        if not low < after < high:
            after = (low + high) / 2 if high < inf else 2 * x
        if abs(after - x) <= 1e-15 * x:
            return after
        x = after
    return x


def chi_square_tail(degrees: float, value: float) -> float:
    """The probability that a chi-square variable exceeds a value; small ones keep their digits.

    Args:
        degrees: of freedom, 1 to 10 million.
        value: >= 0.

    Raises:
        InputError: for arguments outside.
    """
    DEGREES.check("degrees", degrees)
    value = SQUARE.check("value", value)
    return _gamma(degrees / 2, value / 2)[1] if value > 0 else 1.0


def _gamma(a: float, x: float) -> tuple[float, float]:
    """Regularised incomplete gamma functions, lower and upper: a series below the middle, a continued fraction above.

    The smaller of the two keeps all its digits.
    """
    factor = exp(a * log(x) - x - lgamma(a))
    if x < a + 1:
        term = total = 1 / a
        n = a
        while term > total * 1e-17:
            n += 1
            term *= x / n
            total += term
        return total * factor, 1 - total * factor
    # Lentz's method.
    b = x + 1 - a
    c, d = inf, 1 / b
    fraction = d
    for i in range(1, 100_000):
        an = -i * (i - a)
        b += 2
        d = 1 / (an * d + b)
        c = b + an / c
        step = c * d
        fraction *= step
        if abs(step - 1) < 1e-16:
            break
    return 1 - fraction * factor, fraction * factor
