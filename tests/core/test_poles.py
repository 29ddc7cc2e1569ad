"""Polynomial and poles: against determinants and products, and the gains that place given poles."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import Gains
from tracker_core.poles import characteristic_polynomial, poles

ORDERS = [2, 3, 4]

# Polynomial and poles ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@given(data=st.data())
def test_polynomial_is_that_of_the_closed_loop(closed_loop, order, data):
    g = data.draw(st.lists(st.floats(-8, 8), min_size=order, max_size=order))
    matrix = closed_loop(g)
    polynomial = characteristic_polynomial(Gains(tuple(g)))
    assert polynomial.shape == (order + 1,)
    assert polynomial[0] == 1
    # det(zI - A) at more points than a polynomial of this degree can agree in by accident.
    for z in np.exp(2j * np.pi * (np.arange(order + 1) + 0.4) / (order + 1)):
        determinant = np.linalg.det(z * np.eye(order) - matrix)
        assert abs(np.polyval(polynomial, z) - determinant) <= 1e-12 * (1 + np.abs(polynomial).sum())


@pytest.mark.parametrize("order", ORDERS)
@given(data=st.data())
def test_poles_are_the_roots_largest_first(order, data):
    g = Gains(tuple(data.draw(st.lists(st.floats(-3, 6), min_size=order, max_size=order))))
    found = poles(g)
    assert len(found) == order
    assert np.diff(np.abs(found)).max() <= 0
    # Multiplied out again, they give the polynomial; this holds where single roots are ill-conditioned.
    expected = characteristic_polynomial(g)
    assert np.poly(found) == pytest.approx(expected, rel=0, abs=1e-12 * (1 + np.abs(expected).max()))


@pytest.mark.parametrize("g", [(1.0, 0.5), (1.0, 1.0), (1.0, 1.5, 1.0), (1.0, 11 / 6, 2.0, 1.0)], ids=str)
def test_a_position_gain_of_one_has_a_pole_at_zero(g):
    found = poles(Gains(g))
    assert len(found) == len(g)
    # The triple root of the last two is known to the cube root of the rounding error.
    assert abs(found[-1]) <= 1e-4


@pytest.mark.parametrize(
    ("g", "damping"),
    [((0.5, 0.2), "complex"), ((0.36, 0.04), "double"), ((0.36, 0.01), "real"), ((1.5, 0.2), "alternating")],
    ids=str,
)
def test_damping_in_the_triangle(g, damping):
    """Critical at (g0 + g1 - 2)^2 = 4(1 - g0); beyond alpha = 1 one pole is negative and the response alternates."""
    first, second = poles(Gains(g))
    if damping == "complex":
        assert first.imag == -second.imag > 0
    elif damping == "double":
        assert [first, second] == pytest.approx([0.8, 0.8], abs=1e-7)
    else:
        assert first.imag == second.imag == 0
        assert (first.real * second.real < 0) == (damping == "alternating")


def test_poles_of_a_known_filter():
    """z^2 - 1.7 z + 0.8: alpha 0.2 and beta 0.1 give a conjugate pair of magnitude sqrt(0.8)."""
    first, second = poles(Gains((0.2, 0.1)))
    assert abs(first) == pytest.approx(math.sqrt(0.8), rel=1e-14, abs=0)
    assert first == second.conjugate()
    assert first.real == pytest.approx(0.85, rel=1e-14, abs=0)
