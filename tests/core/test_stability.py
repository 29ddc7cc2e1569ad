"""Stability: polynomial, poles, Jury's table and the exact regions, against eigenvalues of F (I - K H)."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import Gains, assess
from tracker_core.stability import (
    alpha_bounds,
    beta_bounds,
    characteristic_polynomial,
    jury_table,
    poles,
    region_conditions,
    region_slice,
)

ORDERS = [2, 3, 4]
DRAWS = 100_000
BORDER = 1e-9
# Boxes that hold the whole stable region of each order and a margin around it; order 4: |poles| < 1 bounds them all.
BOXES = {
    2: [(-0.5, 2.5), (-1, 5)],
    3: [(-0.5, 2.5), (-1, 5), (-1, 5)],
    4: [(-0.5, 2.5), (-1, 5), (-1, 7), (-1, 9)],
}


def spectral_radius(matrices):
    return np.abs(np.linalg.eigvals(matrices)).max(axis=-1)


def coefficients(roots):
    """Of the polynomials with the given roots, shape (n, order), without the leading one."""
    polynomial = np.ones((len(roots), 1), dtype=complex)
    for root in roots.T:
        zero = np.zeros((len(roots), 1))
        polynomial = np.hstack((polynomial, zero)) - root[:, None] * np.hstack((zero, polynomial))
    return polynomial[:, 1:].real


def gains_with_poles(closed_loop, roots):
    """The gains that place the poles: the characteristic polynomial is affine in the gains, so solve for them."""
    corners = np.concatenate((np.zeros((1, roots.shape[1])), np.eye(roots.shape[1])))
    base, *others = coefficients(np.linalg.eigvals(closed_loop(corners)))
    return (coefficients(roots) - base) @ np.linalg.inv(np.array(others) - base)


def random_gains(closed_loop, order, draws, seed):
    """A quarter uniform in a box around the stable region, the rest with poles uniform in a disc of radius 1.2."""
    draw = np.random.default_rng(seed)
    low, high = np.array(BOXES[order]).T
    boxed = draw.uniform(low, high, (draws // 4, order))
    count, pairs = draws - len(boxed), order // 2
    upper = 1.2 * np.sqrt(draw.random((count, pairs))) * np.exp(1j * np.pi * draw.random((count, pairs)))
    roots = np.concatenate((upper, upper.conj()), axis=1)
    # A third of the draws have two real poles in place of the first pair.
    real = draw.random(count) < 1 / 3
    roots[real, 0], roots[real, pairs] = draw.uniform(-1.2, 1.2, (2, real.sum()))
    if order == 3:
        roots = np.concatenate((roots, draw.uniform(-1.2, 1.2, (count, 1))), axis=1)
    return np.concatenate((boxed, gains_with_poles(closed_loop, roots)))


@pytest.fixture(scope="module", params=ORDERS, ids="order-{}".format)
def draws(request, closed_loop):
    """100,000 gain sets of one order that are no closer than 1e-9 to the border, and whether each is stable."""
    g = random_gains(closed_loop, request.param, DRAWS + 1000, seed=request.param)
    radius = spectral_radius(closed_loop(g))
    away = np.abs(radius - 1) > BORDER
    return g[away][:DRAWS], radius[away][:DRAWS] < 1


def test_random_gain_sets_are_a_fair_mixture(draws):
    g, stable = draws
    assert len(g) == DRAWS
    assert 0.2 < stable.mean() < 0.8


def test_verdict_is_that_of_the_eigenvalues(draws):
    """For 100,000 gain sets of each order, by the closed-form region."""
    g, stable = draws
    verdicts = [all(c.holds for c in region_conditions(Gains(tuple(row)))) for row in g.tolist()]
    assert np.flatnonzero(np.array(verdicts) != stable).tolist() == []


def test_jury_table_is_that_of_the_eigenvalues(draws):
    """For a fifth of them, by the general table of the characteristic polynomial."""
    g, stable = (part[::5] for part in draws)
    verdicts = [all(c.holds for c in jury_table(characteristic_polynomial(Gains(tuple(row))))) for row in g.tolist()]
    assert np.flatnonzero(np.array(verdicts) != stable).tolist() == []


def test_assessment_is_that_of_the_eigenvalues(closed_loop, draws):
    g, stable = (part[:: DRAWS // 1000] for part in draws)
    for row, expected in zip(g.tolist(), stable, strict=True):
        verdict = assess(Gains(tuple(row)))
        assert verdict.stable == expected == (verdict.spectral_radius < 1)
        assert verdict.spectral_radius == pytest.approx(spectral_radius(closed_loop(row)), rel=1e-5, abs=0)


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


# Verdicts on and beside the border ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "g",
    [(0, 0.5), (2, 0), (0.5, 0), (0.5, 3), (1.5, 1), (0.5, 0.3, 0), (0.5, 3, 0.1), (0.5, 0.375, 0.25), (0, 0.2, 0.1)],
    ids=str,
)
def test_the_border_counts_as_unstable(g):
    verdict = assess(Gains(g))
    assert not verdict.stable
    assert min(condition.margin for condition in verdict.conditions) <= 0
    assert verdict.spectral_radius >= 1 - 1e-6


@pytest.mark.parametrize("name", ["normalised", "taylor", "half"])
@given(data=st.data())
def test_verdict_does_not_depend_on_the_convention(name, data):
    g = Gains(tuple(data.draw(st.lists(st.floats(0.01, 2), min_size=2, max_size=4))))
    there = g.to(name)
    assert poles(there) == pytest.approx(poles(g), rel=1e-3, abs=1e-3)
    assert [c.margin for c in region_conditions(there)] == pytest.approx(
        [c.margin for c in region_conditions(g)], rel=1e-12, abs=1e-13
    )


def test_a_condition_says_what_it_is():
    verdict = assess(Gains((0.5, 3.2)))
    texts = [condition.text for condition in verdict.conditions]
    assert texts == ["α > 0", "2 − α > 0", "β > 0", "4 − 2α − β > 0"]
    assert [condition.holds for condition in verdict.conditions] == [True, True, True, False]
    assert verdict.conditions[3].margin == pytest.approx(-0.2, rel=1e-14, abs=0)
    assert all(condition.numbers == () for condition in verdict.conditions)
    # z^2 + 1.7 z + 0.5: p(-1) = -0.2.
    assert [condition.text for condition in verdict.jury] == ["p(1) > 0", "p(−1) > 0", "|a₀| < a₂"]
    assert [condition.margin for condition in verdict.jury] == pytest.approx([3.2, -0.2, 0.5], rel=1e-14, abs=0)
    assert verdict.jury[0].numbers == pytest.approx((0.5, 1.7, 1.0), rel=1e-14, abs=0)


@pytest.mark.parametrize("order", ORDERS)
@given(data=st.data())
def test_a_margin_is_the_side_that_its_text_names(order, data):
    """The inequality as a reader sees it, with the products written out, evaluated by Python."""
    g = data.draw(st.lists(st.floats(-3, 6), min_size=order, max_size=order))
    names = dict(zip("αβγη", g, strict=False))
    for condition in region_conditions(Gains(tuple(g))):
        side, _, zero = condition.text.partition(" > ")
        assert zero == "0"
        products = re.sub(r"(?<=[0-9αβγη²)])(?=[αβγη(])", "*", side).replace("²", "**2").replace("−", "-")
        assert condition.margin == pytest.approx(eval(products, {}, names), rel=1e-12, abs=1e-11)


@given(alpha=st.floats(0.01, 1.99), beta=st.floats(0.01, 3.9), gamma=st.floats(0.001, 4))
def test_order_three_region_in_the_half_convention(alpha, beta, gamma):
    """gamma < 4 alpha beta/(2 - alpha) within the triangle, where gamma/2T^2 multiplies the innovation."""
    margin = 4 * alpha * beta / (2 - alpha) - gamma
    triangle = 4 - 2 * alpha - beta
    if min(abs(margin), abs(triangle)) > 1e-9:
        assert assess(Gains((alpha, beta, gamma), "half")).stable == (margin > 0 and triangle > 0)


# Jury's table for any polynomial -----------------------------------------------------------------------------------


@pytest.mark.parametrize("degree", range(1, 9))
def test_jury_table_of_any_degree_agrees_with_the_roots(degree):
    draw = np.random.default_rng(degree)
    verdicts = []
    for _ in range(1500):
        pairs = degree // 2
        half = 1.1 * np.sqrt(draw.random(pairs)) * np.exp(2j * np.pi * draw.random(pairs))
        roots = np.concatenate((half, half.conj(), draw.uniform(-1.1, 1.1, degree % 2)))
        if abs(np.abs(roots).max() - 1) < 1e-4:
            continue
        # A positive factor moves no root.
        table = jury_table(np.poly(roots).real * draw.uniform(0.5, 2))
        assert all(c.holds for c in table) == (np.abs(roots).max() < 1), roots
        assert len(table) == max(3, degree + 1)
        verdicts.append(np.abs(roots).max() < 1)
    assert 0.15 < np.mean(verdicts) < 0.95


def test_jury_table_of_a_printed_example():
    """p(z) = z^4 + 0.7 z^3 - 0.4 z^2 + 0.2 z - 0.1, worked by hand."""
    table = jury_table(np.array([1, 0.7, -0.4, 0.2, -0.1]))
    assert [condition.text for condition in table] == [
        "p(1) > 0", "p(−1) > 0", "|a₀| < a₄", "|b₀| > |b₃|", "|c₀| > |c₂|",
    ]  # fmt: skip
    b = [-0.99, -0.72, 0.44, -0.27]
    c = [b[0] * b[k] - b[3] * b[3 - k] for k in range(3)]
    assert table[3].numbers == pytest.approx(b, rel=1e-14, abs=0)
    assert table[4].numbers == pytest.approx(c, rel=1e-14, abs=0)
    margins = [1.4, -0.4, 0.9, abs(b[0]) - abs(b[3]), abs(c[0]) - abs(c[2])]
    assert [condition.margin for condition in table] == pytest.approx(margins, rel=1e-14, abs=0)


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


def with_slice(alpha, beta, rest):
    return np.column_stack((alpha, beta, *(np.full_like(alpha, value) for value in rest)))


@pytest.mark.parametrize("rest", SLICES, ids=str)
def test_slice_border_lies_on_the_unit_circle(closed_loop, rest):
    alpha, beta = region_slice(Gains((0.5, 0.5, *rest)), points=150)
    assert alpha.shape == beta.shape == (301,)
    assert (alpha[0], beta[0]) == (alpha[-1], beta[-1])
    assert np.abs(spectral_radius(closed_loop(with_slice(alpha, beta, rest))) - 1).max() <= 1e-6


@pytest.mark.parametrize("rest", SLICES, ids=str)
def test_slice_border_encloses_exactly_the_stable_gains(closed_loop, rest):
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
def test_any_slice_border_lies_on_the_unit_circle(closed_loop, gamma, eta):
    rest = (gamma,) if eta is None else (gamma, eta)
    alpha, beta = region_slice(Gains((0.5, 0.5, *rest)), points=40)
    if alpha.size:
        assert np.abs(spectral_radius(closed_loop(with_slice(alpha, beta, rest))) - 1).max() <= 1e-6
        return
    grid = np.stack(np.meshgrid(np.linspace(0, 2, 61), np.linspace(0, 8, 161)), axis=-1).reshape(-1, 2)
    assert (spectral_radius(closed_loop(with_slice(grid[:, 0], grid[:, 1], rest))) >= 1 - 1e-6).all()


@given(gamma=st.floats(0.01, 7.9), eta=st.floats(0.01, 12) | st.none())
def test_alpha_bounds_are_where_the_beta_bounds_meet(gamma, eta):
    gains = Gains((0.5, 0.5, gamma) if eta is None else (0.5, 0.5, gamma, eta))
    left, right = alpha_bounds(gains)
    if right - left < 1e-6:
        return
    low, high = beta_bounds(gains, np.array([left, right]))
    assert low == pytest.approx(high, rel=1e-9, abs=1e-9)
    low, high = beta_bounds(gains, np.linspace(left, right, 12)[1:-1])
    assert (low < high).all()


@given(data=st.data(), gamma=st.floats(0.01, 7.9), eta=st.floats(0.01, 12) | st.none())
def test_beta_bounds_are_the_verdict_at_any_alpha(data, gamma, eta):
    """Also where no beta is stable: the bounds have crossed there."""
    alpha, beta = data.draw(st.floats(gamma / 4, 2)), data.draw(st.floats(-1, 7))
    gains = Gains((alpha, beta, gamma) if eta is None else (alpha, beta, gamma, eta))
    low, high = beta_bounds(gains, np.array(alpha))
    if min(abs(beta - low), abs(beta - high), 2 - alpha, alpha - gamma / 4) > 1e-9:
        assert assess(gains).stable == (low < beta < high)


def test_alpha_bounds_of_the_triangle():
    assert alpha_bounds(Gains((0.5, 0.5))) == (0, 2)


@pytest.mark.parametrize("rest", NO_SLICE, ids=str)
def test_no_slice_where_nothing_is_stable(closed_loop, rest):
    alpha, beta = region_slice(Gains((0.5, 0.5, *rest)))
    assert alpha.size == beta.size == 0
    grid = np.stack(np.meshgrid(np.linspace(-0.5, 2.5, 121), np.linspace(-0.5, 6, 131)), axis=-1).reshape(-1, 2)
    assert (spectral_radius(closed_loop(with_slice(grid[:, 0], grid[:, 1], rest))) >= 1 - 1e-6).all()


@pytest.mark.parametrize("rest", SLICES, ids=str)
def test_beta_bounds_are_where_the_verdict_changes(rest):
    gains = Gains((0.0, 0.0, *rest))
    polygon, _ = region_slice(gains, points=21)
    for alpha in polygon[1:20]:
        low, high = (float(bound[0]) for bound in beta_bounds(gains, np.array([alpha])))
        step = 1e-9 * (high - low)
        for beta, stable in [(low - step, False), (low + step, True), (high - step, True), (high + step, False)]:
            assert assess(Gains((alpha, beta, *rest))).stable == stable


def test_the_order_two_slice_is_the_triangle():
    alpha, beta = region_slice(Gains((0.5, 0.5)))
    area = abs(np.dot(alpha[:-1], beta[1:]) - np.dot(beta[:-1], alpha[1:])) / 2
    assert area == pytest.approx(4, rel=1e-14, abs=0)
    assert (alpha.min(), alpha.max(), beta.min(), beta.max()) == (0, 2, 0, 4)


def test_fading_memory_is_stable_below_one_and_only_there():
    for xi in [0, 0.3, 0.9, 0.999]:
        assert assess(Gains((1 - xi**3, 1.5 * (1 - xi) ** 2 * (1 + xi), (1 - xi) ** 3))).stable
    xi = 1.001
    assert not assess(Gains((1 - xi**3, 1.5 * (1 - xi) ** 2 * (1 + xi), (1 - xi) ** 3))).stable


def test_poles_of_a_known_filter():
    """z^2 - 1.7 z + 0.8: alpha 0.2 and beta 0.1 give a conjugate pair of magnitude sqrt(0.8)."""
    first, second = poles(Gains((0.2, 0.1)))
    assert abs(first) == pytest.approx(math.sqrt(0.8), rel=1e-14, abs=0)
    assert first == second.conjugate()
    assert first.real == pytest.approx(0.85, rel=1e-14, abs=0)
