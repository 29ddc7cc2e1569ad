"""What a number of runs says: means, intervals, differences, and where the least mean lies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import atan2, cos, isfinite, pi, sin, sqrt
from statistics import NormalDist

import numpy as np

from tracker_core.checks import Domain
from tracker_core.types import FloatArray

LEVEL = Domain(0, 1, low_open=True, high_open=True)
FREEDOM = Domain(1, 10**15, whole=True)

CONFIDENCE = 0.95

_SERIES = 400
"""Degrees of freedom up to which Student's distribution is summed term by term."""

_REDRAWN = 400
"""Resamples of a bootstrap."""

_GROUPS = 200
"""More runs than this are resampled in as many groups of neighbours."""


@dataclass(frozen=True, slots=True)
class Interval:
    """A mean, and where the true one lies with a stated confidence.

    Attributes:
        mean: of the runs; NaN where there is nothing to be averaged.
        low, high: ends of the interval; NaN for fewer than two runs.
    """

    mean: float
    low: float
    high: float


def two_sided(t: float, freedom: int) -> float:
    """P(|T| > |t|) of Student's distribution: the finite series of Abramowitz & Stegun 26.7.3 and 26.7.4.

    Args:
        t: any number.
        freedom: degrees of freedom, a whole number from 1 on; above 400 the expansion that `t_quantile` uses would do.
    """
    freedom = int(FREEDOM.check("freedom", freedom))
    angle = atan2(abs(t), sqrt(freedom))
    square = cos(angle) ** 2
    term = total = 1.0
    for k in range(freedom % 2 + 2, freedom - 1, 2):
        term *= square * (k - 1) / k
        total += term
    if freedom % 2 == 0:
        return 1 - sin(angle) * total
    return 1 - 2 / pi * (angle + (sin(angle) * cos(angle) * total if freedom > 1 else 0.0))


@lru_cache(maxsize=256)
def t_quantile(confidence: float, freedom: int) -> float:
    """The t that Student's |T| stays below with that probability.

    Term by term up to 400 degrees of freedom; beyond them the expansion in 1/freedom, Abramowitz & Stegun 26.7.5, is
    right to ten digits.

    Raises:
        InputError: for a probability outside (0, 1), or degrees of freedom that are not a whole number from 1 on.
    """
    confidence, freedom = LEVEL.check("confidence", confidence), int(FREEDOM.check("freedom", freedom))
    x = NormalDist().inv_cdf((1 + confidence) / 2)
    if freedom > _SERIES:
        powers = (
            x,
            (x**3 + x) / 4,
            (5 * x**5 + 16 * x**3 + 3 * x) / 96,
            (3 * x**7 + 19 * x**5 + 17 * x**3 - 15 * x) / 384,
            (79 * x**9 + 776 * x**7 + 1482 * x**5 - 1920 * x**3 - 945 * x) / 92160,
        )
        return sum(term / freedom**k for k, term in enumerate(powers))
    low, high = 0.0, max(1.0, x)
    while two_sided(high, freedom) > 1 - confidence:
        low, high = high, 2 * high
    while True:
        middle = (low + high) / 2
        if middle in (low, high):
            return middle
        low, high = (middle, high) if two_sided(middle, freedom) > 1 - confidence else (low, middle)


def mean_interval(values: FloatArray, confidence: float = CONFIDENCE) -> tuple[FloatArray, FloatArray]:
    """Means over the runs, and how far the true ones lie from them at most.

    Args:
        values: shape (runs, ...).
        confidence: of each interval for itself.

    Returns:
        Mean and half width, each of shape (...); a width is NaN for fewer than two runs. A NaN among the values makes
        both NaN.
    """
    runs = len(values)
    mean = values.mean(axis=0)
    if runs < 2:
        return mean, np.full(mean.shape, np.nan)
    with np.errstate(invalid="ignore"):
        return mean, t_quantile(confidence, runs - 1) * values.std(axis=0, ddof=1) / sqrt(runs)


def half_width(square: float, count: int, confidence: float = CONFIDENCE) -> float:
    """How far a mean may be off, from its sum of squared deviations over the runs; NaN for fewer than two."""
    return t_quantile(confidence, count - 1) * sqrt(square / (count - 1) / count) if count > 1 else float("nan")


def percent_interval(shift: float, base: float, square: float, count: int, confidence: float = CONFIDENCE) -> Interval:
    """By how many percent one mean is off another one of the same runs, which is uncertain itself: the delta method.

    Args:
        shift: the mean difference.
        base: the other mean.
        square: the sum of squared deviations of one minus the ratio of the means times the other.
        count: of the runs.
        confidence: of the interval.

    Returns:
        NaN where there is nothing that percents could be of, and for the ends with fewer than two runs.
    """
    if not base or not isfinite(base):
        return Interval(float("nan"), float("nan"), float("nan"))
    share, width = 100 / abs(base), half_width(square, count, confidence)
    return Interval(shift * share, (shift - width) * share, (shift + width) * share)


def percent_more(values: FloatArray, base: FloatArray, confidence: float = CONFIDENCE) -> Interval:
    """By how many percent the mean of some values is off that of others, run by run: see `percent_interval`.

    Args:
        values, base: shape (runs,).
        confidence: of the interval.
    """
    with np.errstate(invalid="ignore"):
        shift, mean = float((values - base).mean()), float(base.mean())
        rest = values - (1 + shift / mean) * base if mean else values
        return percent_interval(shift, mean, float(((rest - rest.mean()) ** 2).sum()), len(values), confidence)


def least_places(places: FloatArray, scores: FloatArray, *, redraws: int = _REDRAWN) -> tuple[float, FloatArray]:
    """Where the mean score is least: the vertex of the parabola through the lowest mean and its neighbours.

    Args:
        places: shape (p,), increasing.
        scores: shape (runs, p); columns with NaN or infinity are left out.
        redraws: of the bootstrap over the runs, the same ones every time.

    Returns:
        The place, and where it lies when the runs are drawn anew from themselves: shape (redraws,), empty for fewer
        than two runs. The place is NaN where nothing is left.
    """
    kept = np.isfinite(scores).all(axis=0)
    places, scores = places[kept], scores[:, kept]
    if not places.size:
        return np.nan, np.empty(0)
    place = float(_vertices(places, scores.mean(axis=0)[None])[0])
    if len(scores) < 2:
        return place, np.empty(0)
    sums, sizes = scores, np.ones(len(scores))
    if len(scores) > _GROUPS:
        groups = np.array_split(scores, _GROUPS)
        sums, sizes = np.array([group.sum(axis=0) for group in groups]), np.array([len(group) for group in groups])
    draws = np.random.default_rng(0).multinomial(len(sums), np.full(len(sums), 1 / len(sums)), redraws)
    return place, _vertices(places, draws @ sums / (draws @ sizes)[:, None])


def place_interval(place: float, again: FloatArray, runs: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Where the true place of the least mean lies, from what `least_places` gives.

    A bootstrap of few runs is too sure of itself: it knows the variance no better than the runs do, and takes that of
    n runs for that of n - 1. Its quantiles are widened about the place as far as Student's distribution is wider than
    the normal one, and by the root of n/(n - 1).

    Args:
        place, again: the place, and where it lies when the runs are drawn anew.
        runs: how many there are.
        confidence: of the interval.

    Returns:
        Both ends; NaN for fewer than two runs.
    """
    if not again.size or runs < 2:
        return float("nan"), float("nan")
    low, high = np.quantile(again, ((1 - confidence) / 2, (1 + confidence) / 2))
    normal = NormalDist().inv_cdf((1 + confidence) / 2)
    wider = t_quantile(confidence, runs - 1) / normal * sqrt(runs / (runs - 1))
    return place + wider * (float(low) - place), place + wider * (float(high) - place)


def _vertices(places: FloatArray, means: FloatArray) -> FloatArray:
    """The lowest point of every row of means (m, p)."""
    least = np.argmin(means, axis=1)
    best = places[least]
    if len(places) < 3:
        return best
    inner = np.clip(least, 1, len(places) - 2)
    rows = np.arange(len(means))
    x1, x2, x3 = (places[inner + shift] for shift in (-1, 0, 1))
    f1, f2, f3 = (means[rows, inner + shift] for shift in (-1, 0, 1))
    rise1, rise2 = (f2 - f1) / (x2 - x1), (f3 - f2) / (x3 - x2)
    bend = (rise2 - rise1) / (x3 - x1)
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = (x1 + x2) / 2 - rise1 / bend / 2
    return np.where(bend > 0, np.clip(vertex, x1, x3), best)
