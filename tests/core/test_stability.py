"""Stability: polynomial, poles, Jury's table and the exact regions, against eigenvalues of F (I - K H)."""

import functools
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import Gains, assess
from tracker_core.poles import characteristic_polynomial, poles
from tracker_core.stability import (
    INEQUALITIES,
    is_stable,
    jury_margins,
    jury_table,
    printed_conditions,
    region_conditions,
    region_margins,
    stable,
)

ORDERS = [2, 3, 4]
DRAWS = 100_000
BORDER = 1e-9


@pytest.fixture(scope="module")
def draws_of(closed_loop, random_gains, spectral_radius):
    """100,000 gain sets of an order that are no closer than 1e-9 to the border, and whether each is stable."""

    @functools.cache
    def drawn(order):
        g = random_gains(order, DRAWS + 1000, seed=order)
        radius = spectral_radius(closed_loop(g))
        away = np.abs(radius - 1) > BORDER
        return g[away][:DRAWS], radius[away][:DRAWS] < 1

    return drawn


@pytest.fixture(scope="module", params=ORDERS, ids="order-{}".format)
def draws(request, draws_of):
    return draws_of(request.param)


def test_random_gain_sets_are_a_fair_mixture(draws):
    g, expected = draws
    assert len(g) == DRAWS
    assert 0.2 < expected.mean() < 0.8


def test_verdict_is_that_of_the_eigenvalues(draws):
    """For 100,000 gain sets of each order, by the closed-form region."""
    g, expected = draws
    assert np.flatnonzero(stable(g) != expected).tolist() == []


def test_jury_table_is_that_of_the_eigenvalues(draws):
    """For as many, by the general table of the characteristic polynomial."""
    g, expected = draws
    polynomials = np.array([characteristic_polynomial(Gains(tuple(row))) for row in g.tolist()])
    verdicts = (jury_margins(polynomials) > 0).all(axis=1)
    assert np.flatnonzero(verdicts != expected).tolist() == []
    # One table at a time says the same.
    for polynomial, verdict in zip(polynomials[:2_000], verdicts[:2_000].tolist(), strict=True):
        assert all(condition.holds for condition in jury_table(polynomial)) == verdict


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("where", [1.0, -1.0, 1j], ids=["at-one", "at-minus-one", "pair"])
def test_a_billionth_inside_and_outside_the_border(gains_with_poles, order, where):
    """The largest pole, or pair, is placed a billionth within the unit circle and beyond it; the others lie inside."""
    draw = np.random.default_rng(order)
    count = 2000
    angles = draw.uniform(0.3, np.pi - 0.3, count)
    border = [np.full(count, where)] if where != 1j else [np.exp(1j * angles), np.exp(-1j * angles)]
    rest = order - len(border)
    other = 0.6 * draw.random((count, rest // 2)) * np.exp(1j * np.pi * draw.random((count, rest // 2)))
    single = draw.uniform(-0.6, 0.6, (count, rest % 2))
    others = np.concatenate((other, other.conj(), single), axis=1)
    for factor, inside in ((1 - BORDER, True), (1 + BORDER, False)):
        roots = np.concatenate((factor * np.stack(border, axis=1), others), axis=1)
        g = gains_with_poles(roots)
        assert (stable(g) == inside).all()
        for row in g[:200].tolist():
            gains = Gains(tuple(row))
            assert is_stable(gains) == assess(gains).stable == inside
            assert all(c.holds for c in jury_table(characteristic_polynomial(gains))) == inside


@pytest.mark.parametrize("order", ORDERS)
def test_margins_of_many_are_those_of_each(random_gains, order):
    g = random_gains(order, 60, seed=order).reshape(3, 20, order)
    margins = region_margins(g)
    assert margins.shape == (3, 20, len(INEQUALITIES[order]))
    for row, expected in zip(g.reshape(-1, order), margins.reshape(60, -1), strict=True):
        assert [condition.margin for condition in region_conditions(Gains.normalised(row))] == expected.tolist()
    assert np.array_equal(stable(g), (margins > 0).all(axis=-1))


def test_what_is_no_number_is_not_stable():
    assert stable(np.full((2, 3), np.nan)).tolist() == [False, False]


# What has been printed ---------------------------------------------------------------------------------------------


def printed(order, g):
    """Yu & Wu 2017, eq. 10-12 and 21-24, in their convention: the third gain is twice, the fourth six times ours."""
    a, b, c = g[:, 0], g[:, 1], 2 * g[:, 2]
    inside = (a > 0) & (a < 2) & (b > 0) & (b < 13 / 6 * (4 - 2 * a)) & (c > 0) & (c < 4 * a * b / (2 - a))
    return inside & (6 * g[:, 3] > 0) & (6 * g[:, 3] < 24 * (2 - a)) if order == 4 else inside


@pytest.mark.parametrize("order", [3, 4])
def test_printed_conditions_are_those_of_the_paper(random_gains, order):
    g = random_gains(order, 4000, seed=order)
    verdicts = [all(c.holds for c in printed_conditions(Gains(tuple(row)))) for row in g.tolist()]
    assert np.array_equal(verdicts, printed(order, g))
    assert 0.2 < np.mean(verdicts) < 0.8


@pytest.mark.parametrize("order", [3, 4])
def test_printed_conditions_are_not_the_region(draws_of, order):
    """At order 3 they let unstable gains pass; at order 4 they refuse stable ones besides."""
    g, expected = draws_of(order)
    passed = printed(order, g)
    assert (passed & ~expected).mean() > 0.03
    assert ((expected & ~passed).mean() > 0.03) == (order == 4)
    if order == 3:
        assert not (expected & ~passed).any()


@pytest.mark.parametrize(
    ("g", "passes", "stays"),
    [
        ((0.5, 5.0, 0.1), True, False),
        ((0.5, 0.3, 0.1), True, True),
        ((0.5, 5.0, 0.1, 0.1), True, False),
        ((0.6, 0.5, 0.2, 0.02), True, True),
        # All poles at -0.2.
        ((0.9984, 2.0736, 2.7648, 2.0736), True, True),
        # All poles at -0.9: stable, and refused.
        ((0.3439, 26.3891 / 6, 1.3718, 13.0321), False, True),
    ],
    ids=str,
)
def test_printed_conditions_by_hand(g, passes, stays):
    gains = Gains(g)
    assert all(condition.holds for condition in printed_conditions(gains)) == passes
    assert is_stable(gains) == stays


def test_nothing_was_printed_for_order_two():
    assert printed_conditions(Gains((0.5, 0.5))) == ()


def test_assessment_is_that_of_the_eigenvalues(closed_loop, spectral_radius, draws):
    g, verdicts = (part[:: DRAWS // 1000] for part in draws)
    for row, expected in zip(g.tolist(), verdicts, strict=True):
        verdict = assess(Gains(tuple(row)))
        assert verdict.stable == expected == (verdict.spectral_radius < 1)
        assert verdict.spectral_radius == pytest.approx(spectral_radius(closed_loop(row)), rel=1e-5, abs=0)


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


def test_fading_memory_is_stable_below_one_and_only_there():
    for xi in [0, 0.3, 0.9, 0.999]:
        assert assess(Gains((1 - xi**3, 1.5 * (1 - xi) ** 2 * (1 + xi), (1 - xi) ** 3))).stable
    xi = 1.001
    assert not assess(Gains((1 - xi**3, 1.5 * (1 - xi) ** 2 * (1 + xi), (1 - xi) ** 3))).stable
