"""Whether a series with holes is white: correlations with its own past, and how sure its mean is all the same."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from tracker_core.consistency import chi_square_tail
from tracker_core.types import FloatArray

MOST_LAGS = 20
"""Autocorrelations that are looked at by default, where there are five values for each."""


@dataclass(frozen=True, slots=True)
class Whiteness:
    """Whether innovations are correlated with later ones: the portmanteau test of Ljung and Box (1978).

    Attributes:
        statistic: chi-square distributed if they are not; over several axes the sum of theirs.
        degrees: of freedom.
        probability: of a statistic as large or larger, if they are not correlated.
        autocorrelations: shape (n_axes, lags), from lag 1 on; NaN at a lag that no two measurements have.
        band: of each axis, how far from zero 95 % of the autocorrelations lie if they are not correlated; 0 for an axis
            that has none.
    """

    statistic: float
    degrees: int
    probability: float
    autocorrelations: FloatArray
    band: tuple[float, ...]


def whiteness(series: FloatArray, lags: int | None = None) -> Whiteness | None:
    """The test of Ljung and Box on one series.

    Q = n (n + 2) sum over the lags k of r_k^2/m_k, r_k = sum of c_i c_(i+k) / sum of c_i^2, c being the series less its
    mean and m_k the number of pairs; without missing values m_k = n - k and Q is as printed by Ljung and Box (1978,
    Biometrika 65, 297-303). With missing ones, r_k has the variance m_k/(n (n + 2)) to the same order (Stoffer & Toloi
    1992, Statistics & Probability Letters 13, 391-396).

    Args:
        series: shape (n,), NaN where a value is missing.
        lags: how many; by default 20, or a fifth of the values.

    Returns:
        The test; None for fewer than five values per lag asked for, or values that are all the same.
    """
    known = ~np.isnan(series)
    n = int(known.sum())
    lags = min(MOST_LAGS, n // 5) if lags is None else lags
    if lags < 1 or n < 5 * lags:
        return None
    centred = np.where(known, series - series[known].mean(), 0.0)
    power = float(centred @ centred)
    if not power > (n * np.finfo(float).eps * np.abs(series[known]).max()) ** 2:
        return None
    r, statistic, degrees = np.full(lags, np.nan), 0.0, 0
    for k in range(1, min(lags, len(series) - 1) + 1):
        pairs = int(np.count_nonzero(known[:-k] & known[k:]))
        if pairs:
            r[k - 1] = centred[:-k] @ centred[k:] / power
            statistic += n * (n + 2) * r[k - 1] ** 2 / pairs
            degrees += 1
    if not degrees:
        return None
    return Whiteness(statistic, degrees, chi_square_tail(degrees, statistic), r[None], (1.96 / sqrt(n),))


def joint_whiteness(axes: list[Whiteness | None]) -> Whiteness | None:
    """Of several axes whose noise is independent: the sum of their statistics."""
    known = [axis for axis in axes if axis is not None]
    if not known:
        return None
    statistic, degrees = sum(axis.statistic for axis in known), sum(axis.degrees for axis in known)
    lags = max(axis.autocorrelations.shape[1] for axis in known)
    table = np.full((len(axes), lags), np.nan)
    for row, axis in zip(table, axes, strict=True):
        if axis is not None:
            row[: axis.autocorrelations.shape[1]] = axis.autocorrelations[0]
    bands = tuple(0.0 if axis is None else axis.band[0] for axis in axes)
    return Whiteness(statistic, degrees, chi_square_tail(degrees, statistic), table, bands)


def mean_and_error(series: FloatArray, lags: int | None = None) -> tuple[float | None, float | None]:
    """The mean of a series (n,), and its standard error by autocovariances with Bartlett's weights.

    Newey & West 1987, Econometrica 55, 703-708; missing values add nothing (Parzen 1963, Sankhya A 25, 383-392), so
    that the variance cannot become negative.
    """
    known = ~np.isnan(series)
    n = int(known.sum())
    if not n:
        return None, None
    mean = float(series[known].mean())
    if n < 2:
        return mean, None
    lags = min(MOST_LAGS, n // 5) if lags is None else min(lags, n // 5)
    centred = np.where(known, series - mean, 0.0)
    total = float(centred @ centred)
    for k in range(1, lags + 1):
        total += 2 * (1 - k / (lags + 1)) * float(centred[:-k] @ centred[k:])
    return mean, sqrt(max(0.0, total) / (n * (n - 1)))
