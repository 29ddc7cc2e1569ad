"""Places and stable gains: every place is a stable filter, every stable filter has a place, and no digits are lost."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import DESIGNS, Gains
from tracker_core.reflections import gains_at, place_of

ORDERS = (2, 3, 4)


def gains_by_the_book(place):
    """Step up in powers of z with sixty digits, then the symmetric sums of 1 - z and the gains that they make."""
    with mpmath.workdps(60):
        polynomial = [mpmath.mpf(1)]
        for u in place:
            r = mpmath.tanh(mpmath.mpf(float(u)))
            ahead, back = [*polynomial, mpmath.mpf(0)], [mpmath.mpf(0), *polynomial[::-1]]
            polynomial = [a + r * b for a, b in zip(ahead, back, strict=True)]
        order = len(place)
        # The k-th derivative at z = 1 over k!, highest first.
        e = [
            sum(c * mpmath.binomial(order - i, order - k) for i, c in enumerate(polynomial)) for k in range(order + 1)
        ] + [mpmath.mpf(0)] * (4 - order)
        second = e[2] - mpmath.mpf(3) / 2 * e[3] + mpmath.mpf(11) / 6 * e[4]
        gains = [e[1] - e[2] + e[3] - e[4], second, e[3] - 2 * e[4], e[4]]
        return np.array([float(gain) for gain in gains[:order]])


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("spread", [0.5, 2.0, 5.0])
def test_gains_have_all_their_digits(order, spread):
    places = spread * np.random.default_rng(order).standard_normal((50, order))
    expected = np.array([gains_by_the_book(place) for place in places])
    found = gains_at(places)
    # A gain is a difference of symmetric sums where poles lie near -1; near 1 it is one of them.
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert np.max(np.abs(found - expected) / scale) < 1e-13
    assert gains_at(places[7]) == pytest.approx(found[7], rel=1e-15)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("xi", [0.0, 0.3, 0.9, 0.99, 0.999, 0.9999])
def test_slow_filters_come_back_to_the_last_digits(order, xi):
    gains = DESIGNS["fading-memory"].gains(order, xi=xi)
    assert gains_at(place_of(Gains.normalised(gains))) == pytest.approx(gains, rel=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_every_place_is_a_stable_filter(order, closed_loop, spectral_radius):
    places = 1.5 * np.random.default_rng(1).standard_normal((2_000, order))
    assert (spectral_radius(closed_loop(gains_at(places))) < 1).all()


@pytest.mark.parametrize("order", ORDERS)
def test_every_stable_filter_has_a_place(order, stable_gains):
    for gains in stable_gains(order, 500, seed=2):
        place = place_of(Gains.normalised(gains))
        assert np.isfinite(place).all()
        assert gains_at(place) == pytest.approx(gains, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_no_unstable_filter_has_a_place(order, random_gains, closed_loop, spectral_radius):
    gains = random_gains(order, 2_000, seed=3)
    radius = spectral_radius(closed_loop(gains))
    placed = np.array([np.isfinite(place_of(Gains.normalised(vector))).all() for vector in gains])
    sure = np.abs(radius - 1) > 1e-6
    assert np.array_equal(placed[sure], radius[sure] < 1)
    assert placed[sure].any()
    assert not placed[sure].all()


@given(st.lists(st.floats(-2, 2), min_size=2, max_size=4))
def test_a_place_comes_back(place):
    found = place_of(Gains.normalised(gains_at(np.array(place))))
    # Every step down loses a factor of 1/(1 - r^2), up to fourteen.
    assert found == pytest.approx(np.array(place), rel=1e-9, abs=1e-9)


def test_far_out_gains_become_zero():
    assert np.isfinite(gains_at(np.array([-1e4, 1e4, 0.0, 1e4]))).all()
    assert gains_at(np.array([-1e4, 0.3]))[1] == 0
