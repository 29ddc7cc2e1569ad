"""The stable region: slices, intervals, the surface and the way back, against eigenvalues of F (I - K H)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import Gains, assess
from tracker_core.region import alpha_bounds, gain_interval, region_slice

# Slices of the region ----------------------------------------------------------------------------------------------

SLICES = [
    (),
    (1e-6,),
    (0.1,),
    (0.5,),
    (2.0,),
    (3.9,),
    (0.1, 0.01),
    (0.1, 0.1),
    (0.5, 0.1),
    (2.0, 0.5),
    (1e-4, 1e-8),
    (5.0, 5.0),
]
NO_SLICE = [(0.0,), (-0.1,), (8.0,), (0.0, 0.0), (0.1, -0.01), (-0.1, 0.01), (3.0, 20.0), (8.0, 1.0)]


def beta_interval(alpha, rest):
    """The stable interval of beta at each alpha."""
    return gain_interval(with_slice(alpha, np.zeros_like(alpha), rest), 1)


def with_slice(alpha, beta, rest):
    return np.stack((alpha, beta, *(np.full_like(alpha, value) for value in rest)), axis=-1)


@pytest.mark.parametrize("rest", SLICES, ids=str)
def test_slice_border_lies_on_the_unit_circle(closed_loop, spectral_radius, rest):
    alpha, beta = region_slice(Gains((0.5, 0.5, *rest)), points=150)
    assert alpha.shape == beta.shape == (301,)
    assert (alpha[0], beta[0]) == (alpha[-1], beta[-1])
    assert np.abs(spectral_radius(closed_loop(with_slice(alpha, beta, rest))) - 1).max() <= 1e-6


@pytest.mark.parametrize("rest", SLICES, ids=str)
def test_slice_border_encloses_exactly_the_stable_gains(closed_loop, spectral_radius, rest):
    """On every vertical through the slice: stable just inside both borders, unstable just outside, and nowhere else."""
    alpha, beta = region_slice(Gains((0.5, 0.5, *rest)), points=80)
    middle, low, high = alpha[1:79], beta[1:79], beta[80:160][::-1][1:79]
    width = high - low
    for share, stable in [(0.01, True), (0.5, True), (0.99, True), (-0.01, False), (1.01, False)]:
        radius = spectral_radius(closed_loop(with_slice(middle, low + share * width, rest)))
        assert ((radius < 1) == stable).all()
    for outside in (alpha.min() - 1e-3, alpha.max() + 1e-3):
        column = np.linspace(-1, 9, 2001)
        assert (spectral_radius(closed_loop(with_slice(np.full_like(column, outside), column, rest))) >= 1 - 1e-6).all()


@given(gamma=st.floats(0.01, 7.9), eta=st.floats(0.01, 12) | st.none())
def test_any_slice_border_lies_on_the_unit_circle(closed_loop, spectral_radius, gamma, eta):
    rest = (gamma,) if eta is None else (gamma, eta)
    alpha, beta = region_slice(Gains((0.5, 0.5, *rest)), points=40)
    if alpha.size:
        assert np.abs(spectral_radius(closed_loop(with_slice(alpha, beta, rest))) - 1).max() <= 1e-6
        return
    grid = np.stack(np.meshgrid(np.linspace(0, 2, 61), np.linspace(0, 8, 161)), axis=-1).reshape(-1, 2)
    assert (spectral_radius(closed_loop(with_slice(grid[:, 0], grid[:, 1], rest))) >= 1 - 1e-6).all()


@given(gamma=st.floats(0.01, 7.9), eta=st.floats(0.01, 12) | st.none())
def test_alpha_bounds_are_where_the_interval_of_beta_closes(gamma, eta):
    rest = (gamma,) if eta is None else (gamma, eta)
    left, right = alpha_bounds(Gains((0.5, 0.5, *rest)))
    if right - left < 1e-6:
        return
    step = 1e-9 * (right - left)
    low, high = beta_interval(np.array([left + step, right - step]), rest)
    assert low == pytest.approx(high, rel=1e-6, abs=1e-6)
    assert (low < high).all()
    outside = beta_interval(np.array([left - step, right + step]), rest)
    assert np.array_equal(outside, np.zeros((2, 2)))
    low, high = beta_interval(np.linspace(left, right, 12)[1:-1], rest)
    assert (low < high).all()


@given(data=st.data(), gamma=st.floats(0.01, 7.9), eta=st.floats(0.01, 12) | st.none())
def test_the_interval_of_beta_is_the_verdict_at_any_alpha(data, gamma, eta):
    """Also where no beta is stable: the interval is empty there."""
    alpha, beta = data.draw(st.floats(-0.5, 2.5)), data.draw(st.floats(-1, 7))
    rest = (gamma,) if eta is None else (gamma, eta)
    low, high = beta_interval(np.array(alpha), rest)
    if min(abs(beta - low), abs(beta - high)) > 1e-9:
        assert assess(Gains((alpha, beta, *rest))).stable == (low < beta < high)


def test_alpha_bounds_of_the_triangle():
    assert alpha_bounds(Gains((0.5, 0.5))) == (0, 2)


@pytest.mark.parametrize("rest", NO_SLICE, ids=str)
def test_no_slice_where_nothing_is_stable(closed_loop, spectral_radius, rest):
    alpha, beta = region_slice(Gains((0.5, 0.5, *rest)))
    assert alpha.size == beta.size == 0
    grid = np.stack(np.meshgrid(np.linspace(-0.5, 2.5, 121), np.linspace(-0.5, 6, 131)), axis=-1).reshape(-1, 2)
    assert (spectral_radius(closed_loop(with_slice(grid[:, 0], grid[:, 1], rest))) >= 1 - 1e-6).all()


@pytest.mark.parametrize("rest", SLICES, ids=str)
def test_the_interval_of_beta_ends_where_the_verdict_changes(rest):
    polygon, _ = region_slice(Gains((0.0, 0.0, *rest)), points=21)
    for alpha in polygon[1:20]:
        low, high = (float(bound) for bound in beta_interval(alpha, rest))
        step = 1e-9 * (high - low)
        for beta, stable in [(low - step, False), (low + step, True), (high - step, True), (high + step, False)]:
            assert assess(Gains((alpha, beta, *rest))).stable == stable


def test_the_order_two_slice_is_the_triangle():
    alpha, beta = region_slice(Gains((0.5, 0.5)))
    area = abs(np.dot(alpha[:-1], beta[1:]) - np.dot(beta[:-1], alpha[1:])) / 2
    assert area == pytest.approx(4, rel=1e-14, abs=0)
    assert (alpha.min(), alpha.max(), beta.min(), beta.max()) == (0, 2, 0, 4)
