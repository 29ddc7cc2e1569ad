"""What gains do to noise, steps, ramps and frequencies: against Lyapunov solutions, simulation and textbook loops."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_lyapunov

from tracker_core import DESIGNS, Gains, InputError
from tracker_core.analysis import steady_lag
from tracker_core.poles import gains_from_poles
from tracker_core.responses import (
    HORIZON,
    error_change,
    frequency_response,
    lag_coefficient,
    noise_gain,
    predicted_variance,
    smoothed_variance,
    steady_covariance,
    steady_variance,
    step_figures,
    time_response,
    variance_reduction,
)

ORDERS = [2, 3, 4]
UNSTABLE = [(0.5, 3.5), (0.5, 0.0), (2.0, 0.0), (0.5, 0.3, 0.0), (0.5, 0.3, 5.0), (0.5, 0.3, 0.1, -0.1), (0, 0, 0, 0)]


def exact_variances(g):
    """Sum of A^k K K' A'^k in sixty digits, by doubling: the smoothed variances, and the predicted position's."""
    with mp.workdps(60):
        n = len(g)
        gain = mp.matrix([mp.mpf(float(value)) for value in g])
        f = mp.matrix(n, n)
        for i in range(n):
            for j in range(i, n):
                f[i, j] = 1 / mp.factorial(j - i)
        a = f - gain * f[0, :]
        p = gain * gain.T
        for _ in range(60):
            p, a = p + a * p * a.T, a * a
        predicted = (f * p * f.T)[0, 0]
        return [float(p[i, i]) for i in range(n)], float(predicted)


def assert_closed_forms(g, digits):
    """Those of the position, against sixty digits; for plain numbers and for arrays."""
    smoothed, predicted = exact_variances(g)
    gains, within = Gains.normalised(g), {"rel": 10.0**-digits, "abs": 0}
    assert steady_variance(gains, smoothed_variance) == pytest.approx(smoothed[0], **within)
    assert steady_variance(gains, predicted_variance) == pytest.approx(predicted, **within)
    assert noise_gain(g) == pytest.approx(smoothed[0], **within)


# Variances ---------------------------------------------------------------------------------------------------------


def test_variances_of_order_three_by_hand():
    """g = (.5, .2, .08), T = 1."""
    found = variance_reduction(Gains((0.5, 0.2, 0.08)))
    assert found.smoothed == pytest.approx([4 / 7, 6 / 35, 4 / 175], rel=1e-14, abs=0)
    assert found.predicted == pytest.approx(9 / 7, rel=1e-14, abs=0)


@given(alpha=st.floats(0.01, 1.99), share=st.floats(0.01, 0.99))
def test_variances_of_order_two_are_the_closed_forms(alpha, share):
    """D = a(4 - 2a - b): (2a^2 + 2b - 3ab)/D, 2b^2/(T^2 D), predicted (2a^2 + 2b + ab)/D."""
    beta = share * (4 - 2 * alpha)
    d = alpha * (4 - 2 * alpha - beta)
    found = variance_reduction(Gains((alpha, beta)), interval=3.0)
    expected = [(2 * alpha**2 + 2 * beta - 3 * alpha * beta) / d, 2 * beta**2 / d / 9]
    assert found.smoothed == pytest.approx(expected, rel=1e-10, abs=0)
    assert found.predicted == pytest.approx((2 * alpha**2 + 2 * beta + alpha * beta) / d, rel=1e-10, abs=0)


@given(alpha=st.floats(0.05, 1.95), share=st.floats(0.01, 0.99), height=st.floats(0.01, 0.99))
def test_variances_of_order_three_are_the_closed_forms(alpha, share, height):
    beta = share * (4 - 2 * alpha)
    gamma = height * 2 * alpha * beta / (2 - alpha)
    wall, roof = 4 - 2 * alpha - beta, 2 * alpha * beta - gamma * (2 - alpha)
    expected = [
        (2 * beta * (2 * alpha**2 + 2 * beta - 3 * alpha * beta) - alpha * gamma * wall) / (wall * roof),
        (4 * beta**3 - 4 * beta**2 * gamma + 2 * gamma**2 * (2 - alpha)) / (wall * roof),
        4 * beta * gamma**2 / (wall * roof),
    ]
    found = variance_reduction(Gains((alpha, beta, gamma)))
    assert found.smoothed == pytest.approx(expected, rel=1e-8, abs=0)


@pytest.mark.parametrize("xi", [0, 0.3, 0.6, 0.9, 0.97, 0.99])
@pytest.mark.parametrize("order", ORDERS)
def test_variances_keep_twelve_digits(order, xi):
    g = DESIGNS["fading-memory"].gains(order, xi=xi)
    smoothed, predicted = exact_variances(g)
    found = variance_reduction(Gains.normalised(g))
    assert found.smoothed == pytest.approx(smoothed, rel=1e-12, abs=0)
    assert found.predicted == pytest.approx(predicted, rel=1e-12, abs=0)
    assert_closed_forms(g, 14)


@pytest.mark.parametrize("order", ORDERS)
def test_noise_gain_is_the_lyapunov_solution(stable_gains, closed_loop, order):
    """scipy's, for 500 gain sets of each order; F (I - K H) drives the prediction, A = (I - K H) F what is smoothed."""
    g = stable_gains(order, 500, seed=order, radius=0.9)
    found = noise_gain(g)
    for row, value in zip(g, found, strict=True):
        f = closed_loop(np.zeros(order))
        a = f - np.outer(row, f[0])
        expected = solve_discrete_lyapunov(a, np.outer(row, row))
        assert value == pytest.approx(expected[0, 0], rel=1e-9, abs=0)
        assert variance_reduction(Gains.normalised(row)).smoothed == pytest.approx(
            np.diag(expected), rel=1e-9, abs=1e-12
        )


@pytest.mark.parametrize("order", ORDERS)
def test_noise_gain_keeps_twelve_digits(stable_gains, order):
    for g in stable_gains(order, 15, seed=order, radius=0.7):
        smoothed, predicted = exact_variances(g)
        assert_closed_forms(g, 13)
        found = variance_reduction(Gains.normalised(g))
        assert found.smoothed == pytest.approx(smoothed, rel=1e-12, abs=0)
        assert found.predicted == pytest.approx(predicted, rel=1e-12, abs=0)


@pytest.mark.parametrize("order", ORDERS)
def test_predicted_and_smoothed_variance_belong_together(stable_gains, order):
    """Smoothing mixes the prediction with an independent measurement: (1 - a)^2 P + a^2."""
    for g in stable_gains(order, 50, seed=order):
        found = variance_reduction(Gains.normalised(g))
        assert found.smoothed[0] == pytest.approx((1 - g[0]) ** 2 * found.predicted + g[0] ** 2, rel=1e-9, abs=0)


@pytest.mark.parametrize("order", ORDERS)
def test_variances_are_those_of_simulated_noise(plain_track, stable_gains, order):
    """Twenty gain sets per order, 200,000 independent filters each, in standard errors of a normal sample variance.

    A filter is linear: its answer to samples of noise is theirs to one, shifted and added. Three standard errors hold
    a right variance in 99.7 % of comparisons, so that of the sixty of the position one may well lie beyond; four hold
    all but one in 16,000.
    """
    draw = np.random.default_rng(100 + order)
    count, length = 200_000, 25
    misses = []
    for g in stable_gains(order, 20, seed=order, radius=0.6):
        # 0.6^25 of the start is left.
        _, impulse = plain_track([1.0] + [0.0] * (length - 1), [1.0] * length, g, [0.0] * order)
        states = impulse[::-1].T @ draw.standard_normal((length, count))
        expected = variance_reduction(Gains.normalised(g)).smoothed
        misses.append(np.abs((states**2).mean(axis=1) / expected - 1) / math.sqrt(2 / count))
    assert np.max(misses) <= 4
    assert (np.array(misses)[:, 0] > 3).sum() <= 1


@pytest.mark.parametrize("g", UNSTABLE, ids=str)
def test_unstable_gains_have_no_variances(g):
    with pytest.raises(InputError, match="^gains must be stable"):
        variance_reduction(Gains(g))
    with pytest.raises(InputError, match="^gains must be stable, got"):
        steady_variance(Gains(g), smoothed_variance)
    assert math.isnan(noise_gain(np.array(g, dtype=float)))


def test_what_is_no_number_has_no_noise_gain():
    assert np.isnan(noise_gain(np.full((2, 3), np.nan))).all()


@pytest.mark.parametrize("interval", [0, -1, math.nan, math.inf])
def test_variances_need_an_interval(interval):
    with pytest.raises(InputError, match="^interval must be a finite number > 0"):
        variance_reduction(Gains((0.5, 0.2)), interval)


def test_noise_gain_has_the_shape_of_what_it_is_given(stable_gains):
    g = stable_gains(3, 24, seed=1).reshape(4, 6, 3)
    found = noise_gain(g)
    assert found.shape == (4, 6)
    assert found[2, 3] == noise_gain(g[2, 3])


@pytest.mark.parametrize("order", ORDERS)
def test_steady_covariance_solves_the_lyapunov_equation(stable_gains, closed_loop, order):
    draw = np.random.default_rng(order)
    f = closed_loop(np.zeros(order))
    for g in stable_gains(order, 40, seed=order):
        root = draw.normal(size=(order, order))
        gains, q = Gains.normalised(g), root @ root.T
        a = f - np.outer(g, f[0])
        assert error_change(gains) == pytest.approx(a - np.eye(order), abs=1e-15)
        p = steady_covariance(gains, q)
        assert p == pytest.approx(a @ p @ a.T + q, rel=1e-9, abs=1e-11 * np.abs(p).max())
        assert np.array_equal(p, p.T)


@pytest.mark.parametrize("tracking_index", [1e-12, 1e-9])
@pytest.mark.parametrize("order", ORDERS)
def test_variances_of_very_slow_filters_keep_their_digits(order, tracking_index):
    g = DESIGNS["steady-kalman"].gains(order, tracking_index=tracking_index)
    smoothed, predicted = exact_variances(g)
    found = variance_reduction(Gains.normalised(g))
    assert found.smoothed == pytest.approx(smoothed, rel=1e-11, abs=0)
    assert found.predicted == pytest.approx(predicted, rel=1e-11, abs=0)
    assert_closed_forms(g, 14)


@pytest.mark.parametrize(
    "poles", [(0.999, 0.5), (0.9999, 0.9, 0.3), (0.9999, 0.99, 0.5), (0.999, 0.99, 0.9, 0.3)], ids=str
)
def test_closed_forms_keep_their_digits_where_poles_are_far_apart(gains_with_poles, poles):
    """Slow and fast poles side by side are near the roof of the region."""
    (g,) = gains_with_poles(np.array([poles]))
    assert_closed_forms(g, 11)


def test_gains_that_rounding_puts_on_the_border_are_refused():
    """alpha = 2e-320 leaves the smaller gains stable by the inequalities, and no digits for an equation."""
    gains = Gains((0.0 + 1e-310, 1e-320))
    with pytest.raises(InputError, match="^gains must be stable by more than rounding"):
        variance_reduction(gains)


# Lag ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
def test_lag_coefficient_is_the_lag_of_one_unit(stable_gains, order):
    g = stable_gains(order, 20, seed=order)
    for row, value in zip(g, lag_coefficient(g), strict=True):
        assert value == pytest.approx(steady_lag(Gains.normalised(row), 1.0, 1.0), rel=1e-14, abs=0)


def test_a_vanishing_gain_lags_without_end():
    assert lag_coefficient(np.array([0.5, 1e-320])) == math.inf


# Frequencies -------------------------------------------------------------------------------------------------------


def through_the_state(g, frequency, exact=False):
    """H (zI - F(I - KH))^-1 F K for the prediction; K and what is left of the prediction for the estimate."""
    n = len(g)
    with mp.workdps(60 if exact else 15):
        z = mp.expjpi(2 * mp.mpf(float(frequency)))
        gain = mp.matrix([mp.mpf(float(value)) for value in g])
        f = mp.matrix(n, n)
        for i in range(n):
            for j in range(i, n):
                f[i, j] = 1 / mp.factorial(j - i)
        keep = mp.eye(n) - gain * mp.matrix([[1] + [0] * (n - 1)])
        predicted = mp.lu_solve(z * mp.eye(n) - f * keep, f * gain)[0]
        return complex(predicted), complex(gain[0] + (1 - gain[0]) * predicted)


@pytest.mark.parametrize("order", ORDERS)
def test_frequency_response_is_that_of_the_state_space(stable_gains, order):
    frequency = np.concatenate((np.geomspace(1e-5, 0.1, 9), [0.25, 0.4, 0.5]))
    for g in stable_gains(order, 12, seed=order, radius=0.98):
        found = frequency_response(Gains.normalised(g), frequency)
        for i, value in enumerate(frequency):
            predicted, smoothed = through_the_state(g, value, exact=True)
            assert abs(found.predicted[i] - predicted) <= 1e-11 * abs(predicted)
            assert abs(found.smoothed[i] - smoothed) <= 1e-11 * max(1e-2, abs(smoothed))


@pytest.mark.parametrize("order", ORDERS)
def test_frequency_response_of_a_slow_filter_keeps_its_digits(order):
    g = DESIGNS["fading-memory"].gains(order, xi=0.999)
    frequency = np.array([1e-6, 1e-4, 1e-3])
    found = frequency_response(Gains.normalised(g), frequency)
    for i, value in enumerate(frequency):
        predicted, smoothed = through_the_state(g, value, exact=True)
        assert abs(found.predicted[i] - predicted) <= 1e-12 * abs(predicted)
        assert abs(found.smoothed[i] - smoothed) <= 1e-12 * abs(smoothed)


@pytest.mark.parametrize("order", ORDERS)
def test_frequency_response_is_how_a_tone_comes_through(closed_loop, order):
    """A filter that has been running for long answers a tone with one of that amplitude and phase."""
    g = DESIGNS["fading-memory"].gains(order, xi=0.5)
    frequency, k = 0.07, np.arange(400)
    f = closed_loop(np.zeros(order))
    state, smoothed = np.zeros(order, dtype=complex), []
    for z in np.exp(2j * np.pi * frequency * k):
        state = f @ state
        state = state + g * (z - state[0])
        smoothed.append(state[0])
    found = frequency_response(Gains.normalised(g), np.array([frequency]))
    assert smoothed[-1] == pytest.approx(found.smoothed[0] * np.exp(2j * np.pi * frequency * k[-1]), rel=1e-10)


@pytest.mark.parametrize("order", ORDERS)
def test_slow_motion_comes_through_unchanged(stable_gains, order):
    for g in stable_gains(order, 10, seed=order):
        found = frequency_response(Gains.normalised(g), np.array([0.0]))
        assert abs(found.predicted[0] - 1) <= 1e-15
        assert abs(found.smoothed[0] - 1) <= 1e-15


def test_the_mean_square_of_the_response_is_the_noise_gain():
    """Parseval: white noise through the filter, integrated over all frequencies."""
    g = Gains((0.5, 0.2, 0.08))
    frequency = (np.arange(4000) + 0.5) / 8000
    found = frequency_response(g, frequency)
    assert np.mean(np.abs(found.smoothed) ** 2) == pytest.approx(4 / 7, rel=1e-12)
    assert np.mean(np.abs(found.predicted) ** 2) == pytest.approx(9 / 7, rel=1e-12)


@pytest.mark.parametrize("frequency", [-0.1, 0.51, math.nan, math.inf])
def test_a_frequency_outside_is_refused(frequency):
    with pytest.raises(InputError, match="^frequency must be a finite number >= 0 and <= 0.5"):
        frequency_response(Gains((0.5, 0.2)), np.array([0.1, frequency]))


# Steps, ramps, parabolas -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("order", "degree"), [(order, degree) for order in ORDERS for degree in range(order + 1)])
def test_time_response_is_the_textbook_loop(plain_track, stable_gains, order, degree):
    for g in stable_gains(order, 5, seed=order):
        found = time_response(Gains.normalised(g), degree, 50)
        z = [k**degree / math.factorial(degree) for k in range(50)]
        predicted, smoothed = plain_track(z, [1.0] * 50, g, [0.0] * order)
        assert found.input == pytest.approx(z, rel=1e-15, abs=0)
        assert found.predicted == pytest.approx(predicted[:, 0], rel=1e-10, abs=1e-10)
        assert found.smoothed == pytest.approx(smoothed[:, 0], rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("gains", [Gains((0.5, 0.2)), Gains((0.6, 0.3, 0.05)), Gains((0.8, 0.6, 0.25, 0.05))], ids=str)
def test_the_response_to_the_power_of_the_order_settles_to_the_lag(gains):
    """By the final value theorem: order 2 under unit acceleration, 3 under unit jerk, 4 under unit snap."""
    found = time_response(gains, gains.order, 200)
    smoothed, predicted = found.input[-1] - found.smoothed[-1], found.input[-1] - found.predicted[-1]
    assert smoothed == pytest.approx((1 - gains.vector[0]) / gains.vector[-1], rel=1e-7)
    assert predicted == pytest.approx(1 / gains.vector[-1], rel=1e-7)
    for degree in range(gains.order):
        below = time_response(gains, degree, 400)
        assert below.input[-1] - below.smoothed[-1] == pytest.approx(0, abs=1e-9 * max(1, below.input[-1]))


def test_an_unstable_response_grows_and_stops():
    found = time_response(Gains((0.5, 3.9)), 0, 500)
    assert np.abs(found.smoothed[:10]).max() > 1
    assert np.isnan(found.smoothed[-1])
    assert np.isfinite(found.input).all()


@pytest.mark.parametrize(
    ("degree", "samples", "field"),
    [
        (3, 10, "degree"),
        (-1, 10, "degree"),
        (0.5, 10, "degree"),
        (math.nan, 10, "degree"),
        (0, 0, "samples"),
        (0, 2.5, "samples"),
        (0, 200_001, "samples"),
    ],
)
def test_a_response_that_there_is_not_is_refused(degree, samples, field):
    with pytest.raises(InputError) as caught:
        time_response(Gains((0.5, 0.2)), degree, samples)
    assert caught.value.field == field


# Overshoot and settling --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
def test_step_figures_are_those_of_a_long_response(stable_gains, order):
    g = stable_gains(order, 150, seed=order, radius=0.98)
    overshoot, settling = step_figures(g)
    for row, over, settled in zip(g, overshoot, settling, strict=True):
        response = time_response(Gains.normalised(row), 0, 3000).smoothed
        assert over == pytest.approx(max(0.0, response.max() - 1), rel=1e-9, abs=2e-7)
        outside = np.flatnonzero(np.abs(response - 1) > 0.02)
        assert settled == (outside[-1] + 1 if outside.size else 0)


@pytest.mark.parametrize("order", ORDERS)
def test_a_filter_without_memory_settles_at_once(order):
    g = DESIGNS["fading-memory"].gains(order, xi=0)
    overshoot, settling = step_figures(g)
    assert (overshoot, settling) == (0, 0)


@pytest.mark.parametrize("g", [*UNSTABLE, (1.0, 0.0), (1.0, 0.0, 0.0), (math.nan, math.nan)], ids=str)
def test_unstable_gains_do_not_settle(g):
    """Neither those on the border whose step response dies away: without a velocity gain nothing but a step does."""
    overshoot, settling = step_figures(np.array(g, dtype=float))
    assert math.isnan(overshoot)
    assert settling == math.inf


def test_a_response_beyond_the_horizon_has_not_settled():
    """Poles at xi: what is left after the horizon is about n xi^n; 0.998 dies away within it, 0.9995 does not."""
    g = np.array([DESIGNS["fading-memory"].gains(2, xi=xi) for xi in (0.998, 0.9995)])
    overshoot, settling = step_figures(g)
    assert np.isfinite(overshoot).tolist() == [True, False]
    assert settling[0] < HORIZON
    assert settling[1] == math.inf


def poles_at(*poles):
    """Gains that put the poles there."""
    return gains_from_poles([complex(pole) for pole in poles])


@pytest.mark.parametrize(
    "g",
    [
        *(DESIGNS["fading-memory"].gains(2, xi=xi) for xi in (0.9985, 0.999, 0.9994)),
        DESIGNS["fading-memory"].gains(3, xi=0.998),
        DESIGNS["fading-memory"].gains(4, xi=0.997),
        poles_at(0.999 + 0.02j, 0.999 - 0.02j),
        poles_at(0.9989 + 0.03j, 0.9989 - 0.03j, 0.3),
        poles_at(0.99, 0.995 + 0.05j, 0.995 - 0.05j, 0.5),
        # One slow pole of which little is to be seen.
        poles_at(0.5, 0.9999),
        poles_at(0.2, 0.9, 0.99999),
    ],
    ids=range(10),
)
def test_slow_filters_settle_when_their_long_response_does(closed_loop, g):
    """The error of the state for 30,000 steps of its transition matrix."""
    f = closed_loop(np.zeros(len(g)))
    step, error = f - np.outer(g, f[0]), -np.eye(len(g))[0]
    x = np.array([(error := step @ error)[0] for _ in range(30_000)])
    outside = np.flatnonzero(np.abs(x) > 0.02)
    overshoot, settling = step_figures(g)
    assert settling == (outside[-1] + 1 if outside.size else 0)
    assert overshoot == pytest.approx(max(x.max(), 0), rel=1e-6, abs=1e-7)


def test_the_settling_of_slow_filters_is_known():
    """Critically damped filters of order 2, by a plain loop."""
    g = np.array([DESIGNS["fading-memory"].gains(2, xi=xi) for xi in (0.9985, 0.999)])
    assert step_figures(g)[1].tolist() == [3591, 5388]


def test_step_figures_have_the_shape_of_what_they_are_given(stable_gains):
    g = stable_gains(4, 24, seed=1).reshape(4, 6, 4)
    overshoot, settling = step_figures(g)
    assert overshoot.shape == settling.shape == (4, 6)
    assert (overshoot[2, 3], settling[2, 3]) == tuple(map(float, step_figures(g[2, 3])))
