"""Intervals and quantiles beside SciPy's; the least mean beside a parabola's own vertex."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from tracker_core import InputError
from tracker_core.statistics import least_places, mean_interval, percent_more, place_interval, t_quantile, two_sided

FREEDOMS = (1, 2, 3, 4, 5, 10, 19, 20, 99, 200, 399, 400, 401, 500, 1_000, 10_000, 10**6)


@pytest.mark.parametrize("freedom", FREEDOMS)
@pytest.mark.parametrize("confidence", [0.5, 0.8, 0.9, 0.95, 0.99, 0.9917, 0.999])
def test_quantiles(freedom, confidence):
    expected = stats.t.ppf((1 + confidence) / 2, freedom)
    assert t_quantile(confidence, freedom) == pytest.approx(expected, rel=1e-9, abs=0)


@pytest.mark.parametrize("freedom", [f for f in FREEDOMS if f <= 400])
@pytest.mark.parametrize("t", [0.0, 0.1, 1.0, 2.0, -3.0, 12.0])
def test_probabilities(freedom, t):
    assert two_sided(t, freedom) == pytest.approx(2 * stats.t.sf(abs(t), freedom), rel=1e-8, abs=1e-14)


@given(freedom=st.integers(1, 100_000), confidence=st.floats(0.01, 0.999))
def test_the_quantile_falls_towards_the_normal_one(freedom, confidence):
    assert t_quantile(confidence, freedom) > t_quantile(confidence, freedom + 1) > stats.norm.ppf((1 + confidence) / 2)


@pytest.mark.parametrize(
    ("confidence", "freedom", "field"),
    [(0.0, 5, "confidence"), (1.0, 5, "confidence"), (0.9, 0, "freedom"), (0.9, 2.5, "freedom")],
)
def test_what_is_no_quantile_is_refused(confidence, freedom, field):
    with pytest.raises(InputError, match=f"^{field} must be"):
        t_quantile(confidence, freedom)


@pytest.mark.parametrize("runs", [2, 3, 20, 500])
def test_intervals_of_means(runs):
    values = np.random.default_rng(runs).normal(3, 2, (runs, 4))
    mean, width = mean_interval(values, 0.9)
    for column in range(4):
        own = values[:, column]
        low, high = stats.t.interval(0.9, runs - 1, own.mean(), stats.sem(own))
        assert (mean - width)[column] == pytest.approx(low, rel=1e-9)
        assert (mean + width)[column] == pytest.approx(high, rel=1e-9)


def test_one_run_has_no_interval():
    mean, width = mean_interval(np.array([[1.0, 2.0]]))
    assert mean.tolist() == [1, 2]
    assert np.isnan(width).all()


@pytest.mark.parametrize("runs", [2, 5, 40])
@pytest.mark.parametrize("sign", [1, -1])
def test_percent_of_a_mean_that_is_uncertain_itself(runs, sign):
    """By the delta method: the variance of the ratio of two means from their covariance matrix."""
    draw = np.random.default_rng(runs)
    base = sign * draw.normal(5, 1, runs)
    values = 1.3 * base + draw.normal(0, 0.4, runs)
    found = percent_more(values, base, 0.9)
    covariance, mean, ratio = np.cov(values, base) / runs, base.mean(), values.mean() / base.mean()
    slopes = np.array([1, -ratio]) / mean
    width = 100 * stats.t.ppf(0.95, runs - 1) * np.sqrt(slopes @ covariance @ slopes)
    assert found.mean == pytest.approx(sign * 100 * (ratio - 1), rel=1e-12)
    assert (found.high - found.mean, found.mean - found.low) == pytest.approx((width, width), rel=1e-9)


@pytest.mark.parametrize(
    ("values", "base", "mean"),
    [
        ([3.0], [2.0], 50.0),
        ([1.0, 2.0], [0.0, 0.0], np.nan),
        ([1.0, 2.0], [-1.0, 1.0], np.nan),
        ([1.0, np.nan], [1.0, 1.0], np.nan),
        ([1.0, 2.0], [np.inf, 1.0], np.nan),
        ([np.inf, 2.0], [np.inf, 1.0], np.nan),
    ],
)
def test_percent_without_an_interval(values, base, mean):
    found = percent_more(np.array(values), np.array(base))
    assert np.array_equal([found.mean, found.low, found.high], [mean, np.nan, np.nan], equal_nan=True)


@given(vertex=st.floats(0.05, 0.95), bend=st.floats(0.1, 100), points=st.integers(3, 60))
def test_the_vertex_of_a_parabola_is_found_exactly(vertex, bend, points):
    places = np.linspace(0, 1, points)
    place, again = least_places(places, 2 + bend * (places - vertex)[None] ** 2)
    assert place == pytest.approx(min(max(vertex, 0), 1), abs=1e-9 * points)
    assert again.size == 0


def test_places_without_a_number_are_left_out():
    places = np.linspace(0, 1, 11)
    scores = np.tile((places - 0.7) ** 2, (3, 1))
    scores[1, 7] = np.nan
    scores[2, 8] = np.inf
    place, again = least_places(places, scores)
    assert place == pytest.approx(0.7)
    assert len(again) == 400
    assert np.isnan(least_places(places, np.full((3, 11), np.nan))[0])


@pytest.mark.parametrize("runs", [2, 3, 5, 10, 30, 300, 1_000])
def test_the_interval_holds_the_true_place_about_as_often_as_it_says(runs):
    """Noisy parabolas whose least mean lies at 0.4, 250 times: no fewer than 90 % of the intervals at 95 % hold it."""
    places, rng, hits = np.linspace(-4, 5, 91), np.random.default_rng(5), 0
    for _ in range(250):
        vertices = rng.normal(0.4, 0.5, (runs, 1))
        low, high = place_interval(*least_places(places, (places - vertices) ** 2), runs)
        hits += low <= 0.4 <= high
    assert hits >= 225


def test_groups_of_unequal_size_carry_the_variance_of_all_runs():
    """300 runs in 200 groups: the spread of the redrawn places is that of the mean of the 300 vertices."""
    places = np.linspace(-4, 5, 91)
    vertices = np.random.default_rng(8).normal(0.4, 0.5, (300, 1))
    _, again = least_places(places, (places - vertices) ** 2, redraws=20_000)
    assert again.std() == pytest.approx(vertices.std(ddof=1) / np.sqrt(300), rel=0.05)


def test_one_run_has_no_interval_of_the_place():
    assert np.isnan(place_interval(*least_places(np.arange(3.0), np.array([[1.0, 0.0, 1.0]])), 1)).all()


def test_the_same_runs_give_the_same_bits():
    scores = np.random.default_rng(1).random((50, 9))
    first, second = (least_places(np.arange(9.0), scores) for _ in range(2))
    assert first[0] == second[0]
    assert np.array_equal(first[1], second[1])
