"""NEES, NIS and their bounds: against scipy's chi-square, Riccati and Lyapunov solutions, and simulated models."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov
from scipy.stats import chi2

from tracker_core import DESIGNS, Gains, InputError
from tracker_core.consistency import (
    average,
    believed_share,
    chi_square_interval,
    chi_square_quantile,
    chi_square_tail,
    error_squared,
    innovation_squared,
    model_covariance,
    reject_probability,
)
from tracker_core.optimal import optimal_gains
from tracker_core.responses import variance_reduction

ORDERS = [2, 3, 4]
DRIVE = {2: np.array([1 / 2, 1]), 3: np.array([1 / 2, 1, 1]), 4: np.array([1 / 6, 1 / 2, 1, 1])}


# The covariance on the model ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tracking_index", [0.01, 0.3, 5])
def test_covariance_of_the_kalman_filter_is_the_riccati_solution(closed_loop, order, tracking_index):
    drive = tracking_index * DRIVE[order]
    f, h = closed_loop(np.zeros(order)), np.eye(order)[:, :1]
    p = solve_discrete_are(f.T, h, np.outer(drive, drive), [[1.0]])
    found = model_covariance(Gains.normalised(optimal_gains(order, tracking_index)), tracking_index)
    assert found.predicted == pytest.approx(p, rel=1e-8)
    assert found.smoothed == pytest.approx(p - np.outer(p[:, 0], p[0]) / (p[0, 0] + 1), rel=1e-8)
    assert found.innovation == pytest.approx(p[0, 0] + 1, rel=1e-9)
    # What is left of the position's variance is alpha.
    assert found.smoothed[0, 0] == pytest.approx(optimal_gains(order, tracking_index)[0], rel=1e-10)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tracking_index", [0, 0.2, 3])
def test_covariance_of_any_gains_is_the_lyapunov_solution(closed_loop, stable_gains, order, tracking_index):
    f = closed_loop(np.zeros(order))
    q = tracking_index**2 * np.outer(DRIVE[order], DRIVE[order])
    for g in stable_gains(order, 15, seed=order, radius=0.85):
        keep = np.eye(order) - np.outer(g, np.eye(order)[0])
        smoothed = solve_discrete_lyapunov(keep @ f, keep @ q @ keep.T + np.outer(g, g))
        found = model_covariance(Gains.normalised(g), tracking_index)
        scale = np.abs(smoothed).max()
        assert found.smoothed == pytest.approx(smoothed, rel=1e-8, abs=1e-10 * scale)
        assert found.predicted == pytest.approx(f @ smoothed @ f.T + q, rel=1e-8, abs=1e-10 * scale)
        assert found.innovation == found.predicted[0, 0] + 1


def test_a_target_that_does_not_manoeuvre_leaves_the_noise():
    gains = Gains((0.5, 0.2, 0.08))
    found = model_covariance(gains, 0)
    assert np.diag(found.smoothed) == pytest.approx(variance_reduction(gains).smoothed, rel=1e-14)
    assert found.predicted[0, 0] == pytest.approx(variance_reduction(gains).predicted, rel=1e-14)


@pytest.mark.parametrize(
    ("g", "tracking_index", "field"),
    [
        ((0.5, 3.5), 1, "gains"),
        ((0.5, 0.0), 1, "gains"),
        ((0.5, 0.2), -1, "tracking_index"),
        ((0.5, 0.2), math.nan, "tracking_index"),
        ((0.5, 0.2), math.inf, "tracking_index"),
    ],
    ids=str,
)
def test_a_model_that_there_is_not_is_refused(g, tracking_index, field):
    with pytest.raises(InputError) as caught:
        model_covariance(Gains(g), tracking_index)
    assert caught.value.field == field


# On its own model, a filter is consistent --------------------------------------------------------------------------


def simulated(closed_loop, g, tracking_index, runs, samples, draw):
    """Innovations (samples, runs) and smoothed errors (samples, runs, order) after a long start, by the plain loop."""
    order = len(g)
    f = closed_loop(np.zeros(order))
    error = np.zeros((order, runs))
    innovations, errors = [], []
    for _ in range(samples + 150):
        # Of truth minus estimate: the process noise adds to it, the innovation is what of it is measured.
        error = f @ error + (tracking_index * DRIVE[order])[:, None] * draw.standard_normal(runs)
        innovation = error[0] + draw.standard_normal(runs)
        error = error - g[:, None] * innovation
        innovations.append(innovation)
        errors.append(error.T)
    return np.array(innovations[150:]), np.array(errors[150:])


@pytest.mark.parametrize("order", ORDERS)
def test_nis_of_a_kalman_filter_lies_in_its_bounds(closed_loop, order):
    """In 95 % of 4,000 runs, give or take two; a run is the average over a hundred samples, whose innovations are
    independent where the gains are the model's own."""
    g = optimal_gains(order, 0.5)
    variance = model_covariance(Gains.normalised(g), 0.5).innovation
    innovations, _ = simulated(closed_loop, g, 0.5, 4000, 100, np.random.default_rng(order))
    held = [average(run, 1).holds for run in innovation_squared(innovations, variance).T]
    assert np.mean(held) == pytest.approx(0.95, abs=0.02)


def correlations(g, tracking_index, lags=400):
    """Autocorrelations of the innovations on the model, lag by lag, from the answers to a unit of either noise."""
    order = len(g)
    f = np.array([[1 / math.factorial(j - i) if j >= i else 0 for j in range(order)] for i in range(order)])
    answers = []
    for error, measured in ((tracking_index * DRIVE[order], 0.0), (np.zeros(order), 1.0)):
        answer, state = [error[0] + measured], f @ (error - g * (error[0] + measured))
        for _ in range(lags - 1):
            answer.append(state[0])
            state = f @ (state - g * state[0])
        answers.append(answer)
    found = sum(np.correlate(answer, answer, "full")[lags - 1 :] for answer in answers)
    return found[1:] / found[0]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tracking_index", [0, 0.02, 3])
def test_innovations_of_any_gains_are_correlated_as_foretold(stable_gains, order, tracking_index):
    for g in stable_gains(order, 15, seed=order, radius=0.85):
        expected = float((correlations(g, tracking_index) ** 2).sum())
        assert model_covariance(Gains.normalised(g), tracking_index).correlation == pytest.approx(expected, rel=1e-8)
    best = Gains.normalised(optimal_gains(order, 0.3))
    assert model_covariance(best, 0.3).correlation == pytest.approx(0, abs=1e-20)


@pytest.mark.parametrize(("order", "index"), [(2, 0.05), (2, 5.0), (3, 0.02), (4, 0.02), (4, 5.0)])
def test_nis_of_gains_that_are_not_optimal_lies_in_its_bounds(closed_loop, order, index):
    """As often as that of the Kalman filter; taken for independent, its values would be too sure of themselves."""
    g = optimal_gains(order, index)
    model = model_covariance(Gains.normalised(g), 0.5)
    innovations, _ = simulated(closed_loop, g, 0.5, 4000, 100, np.random.default_rng(order))
    runs = innovation_squared(innovations, model.innovation).T
    held = [average(run, 1, correlation=model.correlation).holds for run in runs]
    assert np.mean(held) == pytest.approx(0.95, abs=0.02)
    assert np.mean([average(run, 1).holds for run in runs]) < 0.9


@pytest.mark.parametrize("order", ORDERS)
def test_nees_of_any_gains_lies_in_its_bounds(closed_loop, order):
    """Over 4,000 independent runs at one time, for gains that are not optimal; repeated at forty times apart."""
    g = DESIGNS["fading-memory"].gains(order, xi=0.5)
    covariance = model_covariance(Gains.normalised(g), 0.5).smoothed
    _, errors = simulated(closed_loop, g, 0.5, 4000, 400, np.random.default_rng(order))
    values = error_squared(errors[::10], covariance)
    assert values.shape == (40, 4000)
    assert values.mean() == pytest.approx(order, rel=0.01)
    assert (values < chi2.ppf(0.95, order)).mean() == pytest.approx(0.95, abs=0.003)
    # Forty averages of which two are expected outside; ten have a probability of 1e-5.
    assert sum(not average(row, order).holds for row in values) < 10


def test_a_filter_with_another_model_is_found_out(closed_loop):
    g = optimal_gains(2, 0.5)
    innovations, _ = simulated(closed_loop, g, 1.0, 200, 100, np.random.default_rng(0))
    variance = model_covariance(Gains.normalised(g), 0.5).innovation
    assert not average(innovation_squared(innovations, variance), 1).holds


# The statistics ----------------------------------------------------------------------------------------------------


def test_nis_by_hand():
    assert innovation_squared(np.array([[3.0, -2.0], [0.0, math.nan]]), 4.0)[0].tolist() == [2.25, 1.0]
    assert np.isnan(innovation_squared(np.array([math.nan]), 4.0))[0]


@pytest.mark.parametrize("variance", [0, -1, math.nan])
def test_nis_needs_a_variance(variance):
    with pytest.raises(InputError, match="^variance must be a finite number > 0"):
        innovation_squared(np.ones(3), variance)


@given(st.lists(st.floats(-3, 3), min_size=9, max_size=9), st.lists(st.floats(-5, 5), min_size=6, max_size=6))
def test_nees_is_the_quadratic_form(entries, numbers):
    root = np.array(entries).reshape(3, 3)
    covariance = root @ root.T + 0.1 * np.eye(3)
    errors = np.array(numbers).reshape(2, 3)
    found = error_squared(errors, covariance)
    assert found.shape == (2,)
    expected = [e @ np.linalg.inv(covariance) @ e for e in errors]
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_nees_of_a_missing_error_is_missing():
    found = error_squared(np.array([[1.0, 0.0], [math.nan, 0.0], [0.0, 2.0]]), np.eye(2))
    assert found[[0, 2]].tolist() == [1.0, 4.0]
    assert np.isnan(found[1])


def test_the_average_and_its_interval():
    found = average(np.array([1.0, 2.0, math.nan, 6.0]), 2)
    assert (found.mean, found.count) == (3.0, 3)
    assert [found.low, found.high] == pytest.approx(chi2.ppf([0.025, 0.975], 6) / 3, rel=1e-13, abs=0)
    assert found.holds
    assert not average(np.array([9.0, 9.0, 9.0]), 2).holds
    assert average(np.array([9.0]), 2, level=0.99).holds


def test_correlated_values_count_for_fewer():
    """Three of two degrees of freedom each, whose mean varies four times as much: 1.5 degrees, at least one."""
    found = average(np.array([1.0, 2.0, 6.0]), 2, correlation=1.5)
    assert (found.mean, found.count) == (3.0, 3)
    assert [found.low, found.high] == pytest.approx(chi2.ppf([0.025, 0.975], 1.5) / 1.5 * 2, rel=1e-12, abs=0)
    few = average(np.array([1.0]), 2, correlation=50.0)
    assert [few.low, few.high] == pytest.approx(chi2.ppf([0.025, 0.975], 1) * 2, rel=1e-12, abs=0)


def test_the_average_of_nothing_does_not_hold():
    found = average(np.full(3, math.nan), 2)
    assert math.isnan(found.mean)
    assert found.count == 0
    assert not found.holds


def test_an_infinite_value_is_not_left_out():
    assert average(np.array([1.0, math.inf]), 1).mean == math.inf


# Chi-square --------------------------------------------------------------------------------------------------------

DEGREES = [1, 1.5, 2, 3, 4, 7, 10, 30, 99, 100, 400, 1000, 3000, 8000, 20_000]


@pytest.mark.parametrize("degrees", DEGREES)
@pytest.mark.parametrize("level", [0.01, 0.5, 0.9, 0.95, 0.99, 0.9999])
def test_chi_square_interval_has_twelve_digits(degrees, level):
    expected = chi2.ppf([(1 - level) / 2, (1 + level) / 2], degrees)
    assert chi_square_interval(degrees, level) == pytest.approx(expected, rel=1e-12, abs=0)


@pytest.mark.parametrize("degrees", [1e5, 1e6, 1e7])
def test_chi_square_interval_of_very_many_degrees(degrees):
    assert chi_square_interval(degrees) == pytest.approx(chi2.ppf([0.025, 0.975], degrees), rel=1e-11, abs=0)


@given(degrees=st.floats(1, 1000), probability=st.floats(5e-7, 1 - 5e-7))
def test_chi_square_quantile_is_scipys(degrees, probability):
    expected = chi2.ppf(probability, degrees)
    # Near the upper end the distribution function is 1 to its last digits.
    assert chi_square_quantile(degrees, probability) == pytest.approx(expected, rel=1e-11, abs=0)


@pytest.mark.parametrize("level", [1e-6, 0.999999])
@pytest.mark.parametrize("degrees", [1, 20_000])
def test_chi_square_interval_at_the_ends_of_its_levels(degrees, level):
    low, high = chi_square_interval(degrees, level)
    assert chi2.cdf(high, degrees) - chi2.cdf(low, degrees) == pytest.approx(level, abs=1e-11)
    assert low < high


@pytest.mark.parametrize(
    ("degrees", "level", "field"),
    [
        (0, 0.95, "degrees"),
        (0.99, 0.95, "degrees"),
        (-1, 0.95, "degrees"),
        (math.nan, 0.95, "degrees"),
        (1.1e7, 0.95, "degrees"),
        (3, 0, "level"),
        (3, 1, "level"),
        (3, 1 - 1e-16, "level"),
        (3, math.nan, "level"),
    ],
)
def test_a_distribution_that_there_is_not_is_refused(degrees, level, field):
    with pytest.raises(InputError) as caught:
        chi_square_interval(degrees, level)
    assert caught.value.field == field


# The tail ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axes", [1, 2, 3, 8, 100])
@given(width=st.floats(1, 37))
def test_reject_probability_is_the_tail_of_chi_square(axes, width):
    assert reject_probability(width, axes) == pytest.approx(chi2.sf(width**2, axes), rel=1e-11)


@pytest.mark.parametrize("axes", [1, 2, 3, 8])
@pytest.mark.parametrize("width", [1.0, 2.5, 3.0, 4.0, 10.0])
def test_what_a_gate_leaves_of_the_mean_is_the_integral_below_it(axes, width):
    below = chi2.expect(lambda x: x, args=(axes,), lb=0, ub=width**2, conditional=True)
    assert believed_share(width, axes) == pytest.approx(below / axes, rel=1e-7)


@pytest.mark.parametrize("function", [reject_probability, believed_share])
@pytest.mark.parametrize(("width", "axes"), [(0.5, 1), (101, 1), (3, 0), (3, 1.5), (math.nan, 1)])
def test_a_gate_that_there_is_not_has_no_probability(function, width, axes):
    with pytest.raises(InputError):
        function(width, axes)


@pytest.mark.parametrize("degrees", DEGREES)
@pytest.mark.parametrize("share", [0, 0.1, 0.5, 1, 2, 5])
def test_the_tail_keeps_its_digits(degrees, share):
    value = share * degrees
    expected = chi2.sf(value, degrees)
    # Of a tail of 1e-300 the exponent takes some digits.
    assert chi_square_tail(degrees, value) == pytest.approx(expected, rel=1e-9, abs=1e-300)


@given(degrees=st.floats(1, 1000), probability=st.floats(1e-6, 1 - 1e-6))
def test_tail_and_quantile_are_each_others_inverse(degrees, probability):
    assert chi_square_tail(degrees, chi_square_quantile(degrees, probability)) == pytest.approx(
        1 - probability, rel=1e-8
    )


@pytest.mark.parametrize(("degrees", "value"), [(0.5, 1), (3, -1), (3, math.nan), (3, math.inf)])
def test_a_tail_that_there_is_not_is_refused(degrees, value):
    with pytest.raises(InputError):
        chi_square_tail(degrees, value)
