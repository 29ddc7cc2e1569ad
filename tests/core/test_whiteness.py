"""Correlations of a series with holes: against sums in plain Python and scipy's chi-square."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2, kstest

from tracker_core.whiteness import joint_whiteness, mean_and_error, whiteness

NAN = math.nan


def ljung_box(x, lags):
    """As statsmodels computes it: autocorrelations with the divisor n, the mean taken out."""
    n, c = len(x), [value - math.fsum(x) / len(x) for value in x]
    power = math.fsum(value * value for value in c)
    r = [math.fsum(c[i] * c[i + k] for i in range(n - k)) / power for k in range(1, lags + 1)]
    return r, n * (n + 2) * math.fsum(r[k - 1] ** 2 / (n - k) for k in range(1, lags + 1))


@given(values=st.lists(st.integers(-10_000, 10_000), min_size=10, max_size=60), lags=st.integers(1, 2))
def test_statistic_is_that_of_ljung_and_box(values, lags):
    found = whiteness(np.array(values, dtype=float), lags)
    if found is None:
        assert len(set(values)) == 1
        return
    r, statistic = ljung_box(values, lags)
    assert found.autocorrelations[0] == pytest.approx(r, rel=1e-6, abs=1e-9)
    assert found.statistic == pytest.approx(statistic, rel=1e-6, abs=1e-9)
    assert found.degrees == lags
    assert found.probability == pytest.approx(chi2.sf(found.statistic, lags), rel=1e-10)
    assert found.band == (1.96 / math.sqrt(len(values)),)


@pytest.mark.parametrize(("n", "lags"), [(4, None), (5, 1), (50, 10), (99, 19), (1000, 20)])
def test_lags_by_default(n, lags):
    found = whiteness(np.random.default_rng(0).normal(size=n))
    assert (None if found is None else found.degrees) == lags


@pytest.mark.parametrize("missing", [0, 0.3])
def test_probabilities_of_white_noise_are_uniform(missing):
    """So that 5 % of white series are found correlated at the 5 % level, holes or not."""
    draw = np.random.default_rng(1)
    found = []
    for _ in range(600):
        x = draw.normal(3, 2, 400)
        x[draw.random(400) < missing] = NAN
        found.append(whiteness(x, 10).probability)
    assert kstest(found, "uniform").pvalue > 0.01


def test_a_correlated_series_is_found_out():
    e = np.random.default_rng(2).normal(size=400)
    x = e[1:] + 0.5 * e[:-1]
    x[::7] = NAN
    found = whiteness(x)
    assert found.probability < 1e-4
    assert found.autocorrelations[0, 0] == pytest.approx(0.4 * 0.7, abs=0.15)


def test_a_lag_that_no_two_measurements_have():
    x = np.full(40, NAN)
    x[::2] = np.random.default_rng(0).normal(size=20)
    found = whiteness(x, 4)
    assert np.isnan(found.autocorrelations[0, [0, 2]]).all()
    assert found.degrees == 2
    # Twice as far apart, the same series without holes.
    assert found.statistic == pytest.approx(whiteness(x[::2], 2).statistic)


@pytest.mark.parametrize("x", [[], [1.0] * 30, [NAN] * 30, [1.0, 2.0, 1.5]], ids=["none", "constant", "unknown", "few"])
def test_too_little_to_be_said(x):
    assert whiteness(np.array(x)) is None
    assert joint_whiteness([None, None]) is None


def test_axes_together():
    draw = np.random.default_rng(3)
    one, other = whiteness(draw.normal(size=100)), whiteness(draw.normal(size=50))
    found = joint_whiteness([one, None, other])
    assert found.statistic == one.statistic + other.statistic
    assert found.degrees == 30
    assert found.probability == pytest.approx(chi2.sf(found.statistic, 30), rel=1e-10)
    assert found.autocorrelations.shape == (3, 20)
    assert found.autocorrelations[0].tolist() == one.autocorrelations[0].tolist()
    assert np.isnan(found.autocorrelations[1]).all()
    assert found.band == (*one.band, 0.0, *other.band)


# The mean ----------------------------------------------------------------------------------------------------------


def test_mean_and_error_by_hand():
    x = [1.0, 2.0, 4.0, NAN, 7.0, 1.0]
    mean = 3.0
    c = [value - mean if value == value else 0.0 for value in x]
    total = sum(v * v for v in c) + 2 * 0.5 * sum(a * b for a, b in pairwise(c))
    assert mean_and_error(np.array(x)) == pytest.approx((mean, math.sqrt(total / (5 * 4))))
    assert mean_and_error(np.array(x), 0) == pytest.approx((mean, np.nanstd(x, ddof=1) / math.sqrt(5)))


def test_error_of_the_mean_minds_correlation():
    """Of an autoregressive series with 0.6 it is about twice that of a white one."""
    draw = np.random.default_rng(4)
    means, errors = [], []
    for _ in range(300):
        e = draw.normal(size=500)
        x = np.empty(500)
        x[0] = e[0] / 0.8
        for i in range(1, 500):
            x[i] = 0.6 * x[i - 1] + e[i]
        mean, error = mean_and_error(x)
        means.append(mean)
        errors.append(error)
    assert np.mean(errors) == pytest.approx(np.std(means), rel=0.15)
    assert np.std(means) > 1.8 * 1.25 / math.sqrt(500)


def test_mean_of_little():
    assert mean_and_error(np.array([NAN, NAN])) == (None, None)
    assert mean_and_error(np.array([NAN, 2.0])) == (2.0, None)


@given(st.lists(st.floats(-10, 10) | st.just(NAN), min_size=2, max_size=40))
def test_an_error_is_never_imaginary(values):
    _, error = mean_and_error(np.array(values))
    assert error is None or error >= 0
