"""M2 and M3 of Al-Wagih & Abdulla: least squares over all measurements so far, and its blend with a fixed beta."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker_core import DESIGNS, Gains, Measurements, run_filter
from tracker_core.adaptive import METHODS
from tracker_core.adaptive.growing_memory import growing_gains
from tracker_core.adaptive.linear_combination import WEIGHTS

GROWING, COMBINED, FIXED = (METHODS[name] for name in ("growing-memory", "linear-combination", "benedict-bordner"))


def series(seed, samples=60, axes=1):
    draw = np.random.default_rng(seed)
    return draw.normal(size=(samples, axes)).cumsum(axis=0) * 30 + draw.normal(size=(samples, axes)) * 10


def regular(positions, interval=1.0):
    return Measurements(np.arange(len(positions)) * interval, positions, interval)


def fitted_state(z, order, interval):
    """The polynomial of least squares through measurements as a state at the last one; of lower degree if they are
    fewer than the order. Times are scaled to (-1, 0] so that the equations stay well conditioned.
    """
    degree, span = min(order, len(z)), len(z) * interval
    times = np.arange(1 - len(z), 1) * interval / span
    terms = np.stack([times**k / math.factorial(k) for k in range(degree)], axis=1)
    state = np.zeros((order, *z.shape[1:]))
    solved = np.linalg.lstsq(terms, z, rcond=None)[0]
    state[:degree] = solved / span ** np.arange(degree).reshape(-1, *[1] * (z.ndim - 1))
    return state


# Gains -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [2, 3, 4])
def test_gains_are_what_the_last_measurement_does_to_a_least_squares_fit(order):
    counts = np.arange(1, 61)
    found = growing_gains(order, counts)
    for n in counts:
        last = np.zeros(n)
        last[-1] = 1
        assert found[n - 1] == pytest.approx(fitted_state(last, order, 1.0), rel=1e-12, abs=0)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_gains_fall_and_never_stop_falling(order):
    gains = growing_gains(order, np.arange(order, 100_000))
    assert (np.diff(gains, axis=0) < 0).all()
    assert (gains > 0).all()


# Runs --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("start", ["first", "two-point"])
@pytest.mark.parametrize("interval", [0.2, 1.0, 5.0])
def test_a_run_is_a_polynomial_fit_to_all_measurements_so_far(order, start, interval):
    z = series(order, 50, axes=2)
    selection = GROWING.run(regular(z, interval), order, start=start)
    begin = 0 if start == "first" else 1
    for n in range(begin, 50):
        expected = fitted_state(z[: n + 1], order, interval).T
        size = np.abs(z).max() / interval ** np.arange(order)
        assert (np.abs(selection.track.smoothed[n] - expected) <= 1e-12 * size).all()


def test_missing_measurements_do_not_count():
    z = series(1)
    z[[5, 6, 30], 0] = np.nan
    gains = GROWING.run(regular(z), 2, start="first").gains[:, 0]
    used = gains[~np.isnan(z[:, 0])][1:]
    n = np.arange(2, len(used) + 2)
    assert used[:, 0] == pytest.approx((4 * n - 2) / (n * (n + 1)), rel=1e-15, abs=0)
    assert used[:, 1] == pytest.approx(6 / (n * (n + 1)), rel=1e-15, abs=0)


def test_a_known_state_counts_as_many_measurements_as_it_has_components():
    gains = GROWING.run(regular(series(1)), 3, start="known", initial_state=np.zeros((1, 3))).gains[:, 0]
    assert np.array_equal(gains, growing_gains(3, np.arange(4, 64)))


@pytest.mark.parametrize("alpha", [0.02, 0.5, 1.0])
def test_m1_is_the_filter_with_constant_gains(alpha):
    z = series(3, axes=2)
    selection = FIXED.run(regular(z), fixed_alpha=alpha)
    track = run_filter(regular(z), Gains((alpha, alpha**2 / (2 - alpha))))
    assert np.array_equal(selection.track.smoothed, track.smoothed, equal_nan=True)
    assert np.array_equal(selection.track.predicted, track.predicted, equal_nan=True)
    assert (selection.gains[2:] == DESIGNS["benedict-bordner"].gains(2, alpha=alpha)).all()


# M3 ----------------------------------------------------------------------------------------------------------------


def test_weight_one_has_the_beta_of_m1_and_the_alpha_of_m2():
    measurements = regular(series(5))
    gains = COMBINED.run(measurements, weight=1, fixed_alpha=0.3).gains[2:, 0]
    assert np.array_equal(gains[:, 1], FIXED.run(measurements, fixed_alpha=0.3).gains[2:, 0, 1])
    assert np.array_equal(gains[:, 0], GROWING.run(measurements, 2).gains[2:, 0, 0])


def test_weight_zero_is_m2_to_the_last_bit():
    measurements = regular(series(5, axes=2))
    one, other = COMBINED.run(measurements, weight=0), GROWING.run(measurements, 2)
    assert np.array_equal(one.track.predicted, other.track.predicted, equal_nan=True)
    assert np.array_equal(one.track.smoothed, other.track.smoothed, equal_nan=True)
    assert np.array_equal(one.gains, other.gains, equal_nan=True)


@settings(max_examples=20)
@given(weight=st.floats(0, 1), alpha=st.floats(0.01, 1))
def test_beta_lies_between_the_two(weight, alpha):
    gains = COMBINED.run(regular(series(7)), weight=weight, fixed_alpha=alpha).gains[2:, 0]
    n = np.arange(3, 61)
    expected = weight * alpha**2 / (2 - alpha) + (1 - weight) * 6 / (n * (n + 1))
    assert gains[:, 1] == pytest.approx(expected, rel=1e-14, abs=0)


def manoeuvre(seed):
    """A slow first axis, and a second one that turns away: their best weights differ."""
    times = np.arange(80.0)
    push = np.stack((0 * times, np.maximum(times - 30, 0) ** 2), axis=1)
    return regular(push + 20 * np.random.default_rng(seed).normal(size=push.shape))


@pytest.mark.parametrize("criterion", ["mean-square", "mean-absolute"])
@pytest.mark.parametrize("seed", range(3))
def test_the_searched_weight_has_the_least_innovations(criterion, seed):
    measurements = manoeuvre(seed)
    measurements.positions[[11, 40], 0] = np.nan
    weights = [k / 100 for k in range(101)]
    runs = [COMBINED.run(measurements, weight=weight, fixed_alpha=0.2).track.innovation for weight in weights]
    size = (lambda e: e * e) if criterion == "mean-square" else abs
    costs = np.array([np.nanmean(size(innovation), axis=0) for innovation in runs])
    selection = COMBINED.run(measurements, criterion=criterion, fixed_alpha=0.2)
    found = selection.found["weight"]
    assert found == pytest.approx([weights[k] for k in costs.argmin(axis=0)], rel=0, abs=1e-15)
    assert found[0] != found[1]
    for axis, weight in enumerate(found):
        again = COMBINED.run(measurements, weight=weight, fixed_alpha=0.2)
        assert np.array_equal(selection.track.smoothed[:, axis], again.track.smoothed[:, axis], equal_nan=True)
        assert again.found == {}


def test_weights_are_the_hundredths():
    assert np.abs(WEIGHTS - np.arange(101) / 100).max() <= 1e-15
