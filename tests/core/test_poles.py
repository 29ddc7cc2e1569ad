"""Polynomial and poles: against determinants and products; the gains that place poles, and poles in a hand."""

import cmath
import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tracker_core import DESIGNS, Gains, InputError
from tracker_core.poles import (
    DAMPING,
    SNAP,
    characteristic_polynomial,
    damping_class,
    damping_ratio,
    gains_from_poles,
    is_real,
    move_pole,
    offset_polynomial,
    poles,
)

ORDERS = [2, 3, 4]
REAL = st.floats(-1.5, 1.5)
UPPER = st.builds(cmath.rect, st.floats(0, 1.5), st.floats(0, math.pi))
PAIR = UPPER.map(lambda z: [z, z.conjugate()])


def pole_sets(order):
    """Closed under conjugation, in any sequence."""
    singles = st.lists(REAL.map(complex), min_size=order % 2, max_size=order % 2)
    pairs = st.lists(
        PAIR | st.lists(REAL.map(complex), min_size=2, max_size=2), min_size=order // 2, max_size=order // 2
    )
    return st.tuples(singles, pairs).flatmap(lambda parts: st.permutations(sum(parts[1], parts[0])))


ANY_POLES = st.sampled_from(ORDERS).flatmap(pole_sets)

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
    assert abs(found[-1]) <= 1e-15


def gains_with(*roots):
    return Gains(tuple(gains_from_poles(roots)))


@pytest.mark.parametrize("order", ORDERS)
@given(place=st.floats(-0.999, 0.9999))
def test_poles_that_are_all_equal_have_all_their_digits(order, place):
    found = poles(gains_with(*[place] * order))
    assert set(found) == {found[0]}
    assert found[0].imag == 0
    assert abs(found[0].real - place) <= 1e-13 * max(abs(1 - place), abs(place))


@pytest.mark.parametrize(
    "roots",
    [
        (0.64, 0.64, 0.3),
        (0.9, 0.9, 0.9, -0.2),
        (0.9, 0.9, 0.5, 0.5),
        (0.7, 0.7, 0.6 + 0.2j, 0.6 - 0.2j),
        (0.6 + 0.2j, 0.6 - 0.2j, 0.6 + 0.2j, 0.6 - 0.2j),
    ],
    ids=str,
)
def test_poles_of_which_some_are_equal(roots):
    found = poles(gains_with(*roots))
    assert len(set(found)) == len(set(roots))
    for root in found:
        nearest = min(roots, key=lambda known: abs(known - root))
        assert abs(root - nearest) <= 1e-13
        assert (root.imag == 0) == (nearest.imag == 0)


def exact_poles(g):
    """From the polynomial in powers of z - 1, in sixty digits."""
    with mp.workdps(60):
        g0, g1, g2, g3 = (mp.mpf(float(value)) for value in (*g, 0, 0)[:4])
        sums = [1, g0 + g1 + g2 / 2 + g3 / 6, g1 + 3 * g2 / 2 + 7 * g3 / 6, g2 + 2 * g3, g3][: len(g) + 1]
        roots = [complex(1 + root) for root in mp.polyroots(sums[::-1], asc=True, maxsteps=500, extraprec=500)]
    return sorted(roots, key=lambda root: (-round(abs(root), 12), -root.imag))


@pytest.mark.parametrize("gap", [1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("place", [-0.5, 0.0, 0.3, 0.9, 0.999])
@pytest.mark.parametrize("others", [(), (0.2,), (0.2, -0.4), (0.25 + 0.3j, 0.25 - 0.3j)], ids=str)
def test_poles_that_are_not_equal_stay_apart(place, gap, others):
    """As far as the gains tell them apart: to a tenth of the gap."""
    half = gap * (1 - place) / 2
    for shift in (half, half * 1j):
        gains = gains_with(place - shift, place + shift, *others).values
        found = sorted(poles(Gains(gains)), key=lambda z: abs(z - place))[:2]
        exact = sorted(exact_poles(gains), key=lambda z: abs(z - place))[:2]
        assert abs(found[0] - found[1]) == pytest.approx(abs(exact[0] - exact[1]), rel=0.1)
        assert min(abs(found[0] - root) for root in exact) <= 0.1 * half


@pytest.mark.parametrize(
    "gains",
    [
        (1.0, 0.001999500000005, 9.999999900000001e-07),
        (0.9826146814558953, 1.1853605647365748, 0.7042768711194932, 0.16453834207730863),
        tuple(gains_from_poles((0.9, 0.9, 0.5, 0.5001))),
        tuple(gains_from_poles((0.9, 0.9, 0.90005, 0.3))),
    ],
    ids=str,
)
def test_near_poles_are_the_exact_ones_of_these_gains(gains):
    found, exact = poles(Gains(gains)), exact_poles(gains)
    for root in exact:
        # A twentieth of the gap to the next one that is not equal.
        gap = min((abs(root - other) for other in exact if abs(root - other) > 1e-7), default=1.0)
        assert min(abs(root - other) for other in found) <= gap / 20


@pytest.mark.parametrize("g", [(1, 0), (1, 0, 0), (1, 0, 0, 0), (0, 0), (0, 0, 0, 0)], ids=str)
def test_a_filter_that_corrects_no_derivative_has_them_as_poles_at_one(g):
    found = poles(Gains(tuple(map(float, g))))
    assert sorted(found, key=abs) == [0.0] * (g[0] == 1) + [1.0] * (len(g) - (g[0] == 1))


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
        assert [first, second] == pytest.approx([0.8, 0.8], rel=1e-14)
    else:
        assert first.imag == second.imag == 0
        assert (first.real * second.real < 0) == (damping == "alternating")


def test_poles_of_a_known_filter():
    """z^2 - 1.7 z + 0.8: alpha 0.2 and beta 0.1 give a conjugate pair of magnitude sqrt(0.8)."""
    first, second = poles(Gains((0.2, 0.1)))
    assert abs(first) == pytest.approx(math.sqrt(0.8), rel=1e-14, abs=0)
    assert first == second.conjugate()
    assert first.real == pytest.approx(0.85, rel=1e-14, abs=0)


@pytest.mark.parametrize("order", ORDERS)
@given(data=st.data())
def test_polynomial_around_one_is_the_same_polynomial(order, data):
    g = Gains(tuple(data.draw(st.lists(st.floats(-8, 8), min_size=order, max_size=order))))
    shifted, plain = offset_polynomial(g), characteristic_polynomial(g)
    for z in np.exp(2j * np.pi * (np.arange(order + 1) + 0.4) / (order + 1)):
        assert abs(np.polyval(shifted, z - 1) - np.polyval(plain, z)) <= 1e-12 * (1 + np.abs(plain).sum())


@pytest.mark.parametrize("tracking_index", [1e-10, 1e-6, 1e-3, 1, 100, 1e4])
@pytest.mark.parametrize("order", ORDERS)
def test_poles_keep_their_digits(order, tracking_index):
    """Also their distance from one, where the gains are small."""
    g = DESIGNS["steady-kalman"].gains(order, tracking_index=tracking_index)
    for found, expected in zip(poles(Gains.normalised(g)), exact_poles(g), strict=True):
        assert abs(found - expected) <= 1e-11 * min(1, abs(1 - expected))


# Gains from poles --------------------------------------------------------------------------------------------------


@given(roots=ANY_POLES)
@example(roots=[0j, 0j, 0j, 0j])
@example(roots=[1 + 0j, -1 + 0j, 1j, -1j])
def test_placed_poles_are_the_roots_of_the_polynomial(roots):
    """Multiplied out by np.poly, which shares nothing with it."""
    polynomial = characteristic_polynomial(Gains.normalised(gains_from_poles(roots)))
    expected = np.poly(np.array(roots)).real
    assert polynomial == pytest.approx(expected, rel=0, abs=1e-13 * (1 + np.abs(expected).max()))


@given(roots=ANY_POLES)
def test_gains_return_from_their_poles(roots):
    """To 1e-9, multiple poles among them."""
    g = gains_from_poles(roots)
    assert gains_from_poles(poles(Gains.normalised(g))) == pytest.approx(g, rel=0, abs=1e-9)


@pytest.mark.parametrize("xi", [0, 0.2, 0.5, 0.9, 0.99, 0.999])
@pytest.mark.parametrize("order", ORDERS)
def test_equal_poles_place_the_fading_memory_filter(order, xi):
    g = DESIGNS["fading-memory"].gains(order, xi=xi)
    assert gains_from_poles([complex(xi)] * order) == pytest.approx(g, rel=1e-12, abs=0)
    assert gains_from_poles(poles(Gains.normalised(g))) == pytest.approx(g, rel=1e-12, abs=0)


@pytest.mark.parametrize("order", ORDERS)
def test_many_gains_return_from_their_poles(random_gains, order):
    for g in random_gains(order, 4000, seed=order):
        assert gains_from_poles(poles(Gains.normalised(g))) == pytest.approx(g, rel=0, abs=1e-9)


@pytest.mark.parametrize(
    ("roots", "rule"),
    [
        ([0.5], "must be 2, 3 or 4 numbers"),
        ([0.5] * 5, "must be 2, 3 or 4 numbers"),
        ([], "must be 2, 3 or 4 numbers"),
        ([0.5, math.nan], "must be numbers of magnitude"),
        ([0.5, math.inf, 0.1], "must be numbers of magnitude"),
        ([0.5, complex(0.1, math.nan)], "must be numbers of magnitude"),
        ([1e200, 1e200, 1e200], "must be numbers of magnitude"),
        ([0.5 + 0.1j, 0.5], "must come in conjugate pairs"),
        ([0.5 + 0.1j, 0.5 + 0.1j], "must come in conjugate pairs"),
        ([0.5 + 0.1j, 0.4 - 0.1j], "must come in conjugate pairs"),
        ([0.5 + 0.1j, 0.5 - 0.1j, 0.3 + 1e-8j], "must come in conjugate pairs"),
    ],
    ids=str,
)
def test_poles_that_no_gains_place_are_refused(roots, rule):
    with pytest.raises(InputError) as caught:
        gains_from_poles(roots)
    assert caught.value.field == "poles"
    assert caught.value.rule.startswith(rule)


# A hand that drags a pole ------------------------------------------------------------------------------------------


def closed(roots):
    """Every pole has its exact mirror image, as often as itself."""
    return sorted(map(str, map(canonical, roots))) == sorted(map(str, (canonical(root.conjugate()) for root in roots)))


def canonical(root):
    return complex(root.real, root.imag + 0.0)


@given(roots=ANY_POLES, data=st.data(), target=st.builds(complex, st.floats(-3, 3), st.floats(-3, 3)))
def test_moved_poles_stay_closed_and_few_move(roots, data, target):
    index = data.draw(st.integers(0, len(roots) - 1))
    moved = move_pole(roots, index, target)
    assert len(moved) == len(roots)
    assert closed(moved)
    # The held pole and one partner; of the others, those that count as real lose their imaginary part.
    changed = [i for i, (old, new) in enumerate(zip(roots, moved, strict=True)) if old != new]
    far = [i for i in changed if i != index and moved[i] != complex(roots[i].real)]
    assert len(far) <= 1
    assert all(is_real(roots[i]) for i in changed if i != index and i not in far)
    assert moved[index] in {target, complex(target.real)}
    gains_from_poles(moved)


@given(roots=ANY_POLES, data=st.data(), target=st.builds(complex, st.floats(-3, 3), st.floats(-3, 3)))
def test_a_hand_that_leaves_the_axis_takes_hold_or_stays(roots, data, target):
    """Only the one real pole of an odd set has no partner."""
    index = data.draw(st.integers(0, len(roots) - 1))
    alone = is_real(roots[index]) and sum(map(is_real, roots)) == 1
    snapped = abs(target.imag) <= min(SNAP, abs(1 - target) / 5)
    expected = complex(target.real) if alone or snapped else target
    assert move_pole(roots, index, target)[index] == expected


@pytest.mark.parametrize(
    ("roots", "index", "target", "expected"),
    [
        # The mirror image follows.
        ([0.5 + 0.3j, 0.5 - 0.3j], 0, 0.6 + 0.1j, [0.6 + 0.1j, 0.6 - 0.1j]),
        ([0.5 + 0.3j, 0.5 - 0.3j], 1, 0.6 + 0.1j, [0.6 - 0.1j, 0.6 + 0.1j]),
        ([0.5 + 0.3j, 0.9, 0.5 - 0.3j], 2, 0.2 - 0.4j, [0.2 + 0.4j, 0.9, 0.2 - 0.4j]),
        # Two equal real poles on the axis and within SNAP of it.
        ([0.5 + 0.3j, 0.5 - 0.3j], 0, 0.7, [0.7, 0.7]),
        ([0.5 + 0.3j, 0.5 - 0.3j], 0, 0.7 - 0.007j, [0.7, 0.7]),
        # Near 1, where a slow filter has its poles, much nearer ones are told apart.
        ([0.993 + 0.007j, 0.993 - 0.007j], 0, 0.992 + 0.007j, [0.992 + 0.007j, 0.992 - 0.007j]),
        # A real pole alone.
        ([0.5, 0.8], 0, 0.1 + 0.005j, [0.1, 0.8]),
        ([0.5, 0.5], 0, 0.1, [0.1, 0.5]),
        # Off the axis with the nearest real one.
        ([0.5, 0.8], 0, 0.6 + 0.2j, [0.6 + 0.2j, 0.6 - 0.2j]),
        ([0.1, 0.5, 0.8], 1, 0.6 + 0.2j, [0.1, 0.6 + 0.2j, 0.6 - 0.2j]),
        ([0.1, 0.4, 0.8], 1, 0.6 - 0.2j, [0.6 + 0.2j, 0.6 - 0.2j, 0.8]),
        ([0.1, 0.5, 0.9 + 0.1j, 0.9 - 0.1j], 0, 1j, [1j, -1j, 0.9 + 0.1j, 0.9 - 0.1j]),
        # None left to pair with.
        ([0.3, 0.9 + 0.1j, 0.9 - 0.1j], 0, 0.6 + 0.2j, [0.6, 0.9 + 0.1j, 0.9 - 0.1j]),
        # Nearly equal ones count as real.
        ([0.5001, 0.49995 + 1e-4j, 0.49995 - 1e-4j], 1, 0.3, [0.5001, 0.3, 0.49995]),
        ([0.5001, 0.49995 + 1e-4j, 0.49995 - 1e-4j], 0, 0.3 + 0.1j, [0.3 + 0.1j, 0.3 - 0.1j, 0.49995]),
    ],
    ids=str,
)
def test_moved_poles_by_hand(roots, index, target, expected):
    assert list(move_pole(roots, index, target)) == expected


@pytest.mark.parametrize("target", [complex(math.nan), complex(0, math.inf), complex(0.5, math.nan)], ids=str)
def test_a_pole_is_not_moved_nowhere(target):
    with pytest.raises(InputError, match="^target must be a finite number"):
        move_pole([0.5, 0.2], 0, target)


# Damping -----------------------------------------------------------------------------------------------------------


@given(zeta=st.floats(-0.999, 1), frequency=st.floats(1e-3, 3))
def test_damping_ratio_of_a_sampled_oscillator(zeta, frequency):
    """s = omega (-zeta + i sqrt(1 - zeta^2)) at unit intervals, as long as the angle stays below half a turn."""
    s = frequency * complex(-zeta, math.sqrt(1 - zeta**2))
    if abs(s.imag) < 3.1:
        assert damping_ratio(cmath.exp(s)) == pytest.approx(zeta, rel=1e-9, abs=1e-9)
        assert damping_ratio(cmath.exp(s).conjugate()) == damping_ratio(cmath.exp(s))


@pytest.mark.parametrize(
    ("pole", "ratio"),
    [
        (0, 1),
        (0.5, 1),
        (1e-300, 1),
        (1, 0),
        (-1, 0),
        (1j, 0),
        (2, -1),
        (-0.5, math.log(2) / math.hypot(math.log(2), math.pi)),
        (0.5j, math.log(2) / math.hypot(math.log(2), math.pi / 2)),
    ],
    ids=str,
)
def test_damping_ratio_by_hand(pole, ratio):
    assert damping_ratio(complex(pole)) == pytest.approx(ratio, rel=1e-14, abs=0)


@given(alpha=st.floats(1e-9, 0.999))
@example(alpha=1e-12)
@example(alpha=0.5)
def test_critical_damping_in_the_triangle_is_found_exactly(alpha):
    """On the curve, and a millionth beside it."""
    _, beta = DESIGNS["critically-damped"].gains(alpha=alpha)
    assert damping_class(Gains((alpha, beta))) == "critically damped"
    assert damping_class(Gains((alpha, beta * (1 + 1e-6)))) == "underdamped"
    assert damping_class(Gains((alpha, beta * (1 - 1e-6)))) in {"overdamped", "alternating"}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("xi", [0, 0.1, 0.5, 0.9, 0.99, 0.999, 0.99999])
def test_fading_memory_is_critically_damped(order, xi):
    assert damping_class(Gains.normalised(DESIGNS["fading-memory"].gains(order, xi=xi))) == "critically damped"


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tracking_index", [1e-12, 1e-6, 0.01, 1])
def test_steady_kalman_filters_are_underdamped(order, tracking_index):
    """However slow they are."""
    g = DESIGNS["steady-kalman"].gains(order, tracking_index=tracking_index)
    assert damping_class(Gains.normalised(g)) == "underdamped"


@pytest.mark.parametrize(
    ("roots", "expected"),
    [
        ([0.8, 0.7], "overdamped"),
        ([0.8, 0], "overdamped"),
        ([0.8, -0.2], "alternating"),
        ([-0.5, -0.5], "alternating"),
        ([1.1, 0.9], "overdamped"),
        ([0.8, 0.7, 0.7], "overdamped"),
        ([0.8, 0.8, 0.7, 0.7], "overdamped"),
        ([0.8, 0.8, 0.8, 0.7], "overdamped"),
        ([0.8, 0.5 + 0.1j, 0.5 - 0.1j], "underdamped"),
        ([-0.8, 0.5 + 0.1j, 0.5 - 0.1j], "underdamped"),
        ([-0.3, 0.8, 0.8], "alternating"),
        ([-0.3, -0.3, -0.3, -0.3], "alternating"),
        ([0.9999 + 0.0001j, 0.9999 - 0.0001j, 0.2], "underdamped"),
        ([0, 0, 0, 0.5], "overdamped"),
    ],
    ids=str,
)
def test_damping_by_hand(roots, expected):
    assert damping_class(Gains.normalised(gains_from_poles(roots))) == expected
    assert expected in DAMPING
