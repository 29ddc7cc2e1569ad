"""The stable region: slices, intervals, the surface and the way back, against eigenvalues of F (I - K H)."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.optimize import minimize

from tracker_core import CONVENTIONS, DESIGNS, Gains, InputError, assess
from tracker_core.poles import gains_from_poles, poles
from tracker_core.region import (
    BOX,
    PLANES,
    RADIUS,
    alpha_bounds,
    gain_interval,
    nearest_stable,
    printed_slice,
    region_slice,
    region_surface,
)
from tracker_core.stability import is_stable, printed_conditions, stable

ORDERS = [2, 3, 4]
ALL_PLANES = [(order, plane) for order in ORDERS for plane in PLANES[order]]
NAMES = ("alpha", "beta", "gamma", "eta")
# Of four equal poles.
SCATTER = 2e-4

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
    for share, inside in [(0.01, True), (0.5, True), (0.99, True), (-0.01, False), (1.01, False)]:
        radius = spectral_radius(closed_loop(with_slice(middle, low + share * width, rest)))
        assert ((radius < 1) == inside).all()
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
        for beta, inside in [(low - step, False), (low + step, True), (high - step, True), (high + step, False)]:
            assert assess(Gains((alpha, beta, *rest))).stable == inside


def test_the_order_two_slice_is_the_triangle():
    alpha, beta = region_slice(Gains((0.5, 0.5)))
    area = abs(np.dot(alpha[:-1], beta[1:]) - np.dot(beta[:-1], alpha[1:])) / 2
    assert area == pytest.approx(4, rel=1e-14, abs=0)
    assert (alpha.min(), alpha.max(), beta.min(), beta.max()) == (0, 2, 0, 4)


# The box -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
def test_the_box_holds_every_stable_filter_and_no_smaller_one_does(stable_gains, order):
    """Its faces are touched where all poles lie at one and at minus one; there the gains leave the region."""
    drawn = stable_gains(order, 50_000, seed=order, radius=1)
    assert (drawn > 0).all()
    assert (drawn < BOX[order]).all()
    corners = np.array([gains_from_poles([1.0] * (order - k) + [-1.0] * k) for k in range(order + 1)])
    assert corners.max(axis=0) == pytest.approx(BOX[order], rel=1e-15, abs=0)
    assert corners.min(axis=0) == pytest.approx(0, abs=1e-15)
    within = np.array([gains_from_poles([0.999] * (order - k) + [-0.999] * k) for k in range(order + 1)])
    assert stable(within).all()
    assert within.max(axis=0) == pytest.approx(BOX[order], rel=0.01)


@pytest.mark.parametrize("order", ORDERS)
def test_stable_filters_lie_in_the_simplex_of_the_corners(stable_gains, order):
    """Fam & Meditch 1978: barycentric coordinates of none are negative."""
    corners = np.array([gains_from_poles([1.0] * (order - k) + [-1.0] * k) for k in range(order + 1)])
    drawn = stable_gains(order, 20_000, seed=order, radius=1)
    weights = np.linalg.solve(np.vstack((corners.T, np.ones(order + 1))), np.vstack((drawn.T, np.ones(len(drawn)))))
    assert weights.min() > -1e-12


# Intervals ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("order", "index"), [(order, index) for order in ORDERS for index in range(order)])
def test_the_interval_of_a_gain_is_the_verdict(random_gains, closed_loop, spectral_radius, order, index):
    """On 20,000 gain sets around the border, by eigenvalues."""
    g = random_gains(order, 20_000, seed=10 * order + index)
    radius = spectral_radius(closed_loop(g))
    low, high = gain_interval(g, index)
    inside = (low < g[:, index]) & (g[:, index] < high)
    away = np.abs(radius - 1) > 1e-9
    assert np.flatnonzero(inside[away] != (radius < 1)[away]).tolist() == []
    assert (low <= high).all()
    assert ((low == 0) & (high == 0) | (low < high)).all()


@pytest.mark.parametrize(("order", "index"), [(order, index) for order in ORDERS for index in range(order)])
def test_the_ends_of_an_interval_lie_on_the_border(stable_gains, closed_loop, spectral_radius, order, index):
    g = stable_gains(order, 2000, seed=10 * order + index)
    for end in gain_interval(g, index):
        at_end = g.copy()
        at_end[:, index] = end
        assert spectral_radius(closed_loop(at_end)) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("index", [-1, 2, 1.5])
def test_a_gain_that_the_order_does_not_have_has_no_interval(index):
    with pytest.raises(InputError, match="^index must be one of 0 to 1"):
        gain_interval(np.array([0.5, 0.2]), index)


def test_what_is_no_number_has_no_interval():
    assert np.array_equal(gain_interval(np.array([[np.nan, np.nan, np.nan, np.nan]]), 2), np.zeros((2, 1)))


# Slices in every plane ---------------------------------------------------------------------------------------------


def test_the_planes_are_all_pairs_of_gains_alpha_and_beta_first():
    assert [len(PLANES[order]) for order in ORDERS] == [1, 3, 6]
    assert all(PLANES[order][0] == ("alpha", "beta") for order in ORDERS)


def in_plane(vector, plane, x, y):
    vectors = np.repeat(np.asarray(vector)[None], len(x), axis=0)
    for name, values in zip(plane, (x, y), strict=True):
        vectors[:, NAMES.index(name)] = values
    return vectors


@pytest.mark.parametrize(("order", "plane"), ALL_PLANES, ids=str)
def test_slices_in_every_plane_lie_on_the_unit_circle(stable_gains, closed_loop, spectral_radius, order, plane):
    """Through two hundred stable gain sets, whose poles may come as near to the circle as they like."""
    for g in stable_gains(order, 200, seed=order, radius=1):
        x, y = region_slice(Gains.normalised(g), plane, points=40)
        assert x.shape == y.shape == (81,)
        assert (x[0], y[0]) == (x[-1], y[-1])
        assert np.abs(spectral_radius(closed_loop(in_plane(g, plane, x, y))) - 1).max() <= 1e-6


@pytest.mark.parametrize(("order", "plane"), ALL_PLANES, ids=str)
def test_slices_hold_exactly_the_stable_gains(random_gains, order, plane):
    """Also through unstable gains: whatever they have in the plane plays no part. A fine grid finds nothing else."""
    across, up = (NAMES.index(name) for name in plane)
    box = np.array(BOX[order])
    found = 0
    for g in random_gains(order, 60, seed=order):
        x, _ = region_slice(Gains.normalised(g), plane, points=200)
        columns = np.linspace(-0.1, 1.1, 61) * box[across]
        rows = np.linspace(-0.1, 1.1, 181) * box[up]
        grid = np.stack(np.meshgrid(columns, rows, indexing="ij"), axis=-1).reshape(-1, 2)
        verdict = stable(in_plane(g, plane, *grid.T)).reshape(61, 181)
        if not x.size:
            assert not verdict.any()
            continue
        found += 1
        low, high = gain_interval(in_plane(g, plane, columns, np.zeros(61)), up)
        inside = (x[0] < columns) & (columns < x[199])
        assert not verdict[~inside].any()
        # Every column between the ends holds stable gains: the slice is of one piece.
        assert (low < high)[inside].all()
        assert np.array_equal(verdict, (low[:, None] < rows) & (rows < high[:, None]))
    assert found > 10


@pytest.mark.parametrize("order", [3, 4])
@given(data=st.data())
def test_a_slice_has_the_ends_that_the_intervals_have(order, data):
    """A hair inside an end some value of the other gain is stable, a hair outside none."""
    plane = data.draw(st.sampled_from(PLANES[order]))
    up = NAMES.index(plane[1])
    g = [data.draw(st.floats(1e-3, top)) * data.draw(st.sampled_from([1, 0.1, 1e-3])) for top in BOX[order]]
    x, _ = region_slice(Gains(tuple(g)), plane, points=9)
    if x.size and x[8] - x[0] > 1e-6:
        hair = 1e-7 * (x[8] - x[0])
        probes = np.array([x[0] - hair, x[0] + hair, x[8] - hair, x[8] + hair])
        low, high = gain_interval(in_plane(g, plane, probes, np.zeros(4)), up)
        assert (low < high).tolist() == [False, True, True, False]


@pytest.mark.parametrize(
    ("g", "plane"),
    [
        # alpha, beta and gamma fixed beyond the region, and on its border.
        ((0.5, 4.0, 0.1), ("alpha", "gamma")),
        ((0.5, 0.0, 0.1), ("alpha", "gamma")),
        ((2.0, 0.5, 0.1), ("beta", "gamma")),
        ((0.0, 0.5, 0.1), ("beta", "gamma")),
        ((-1.0, 0.5, 0.1), ("beta", "gamma")),
        ((0.5, 0.1, 0.1, 0.3), ("alpha", "gamma")),
        ((0.5, 5.4, 0.1, 0.1), ("alpha", "eta")),
        ((0.5, 0.5, 0.0, 0.1), ("alpha", "eta")),
        ((1.0, 0.5, 0.1, 8.0), ("beta", "gamma")),
        ((0.5, 0.5, 2.0, 0.1), ("beta", "eta")),
        ((2.0, 0.5, 0.1, 0.1), ("beta", "eta")),
        ((1.0, 8 / 3, 0.1, 0.1), ("gamma", "eta")),
        ((1e9, 1e9, 1e9, 1e9), ("alpha", "gamma")),
    ],
    ids=str,
)
def test_a_plane_without_stable_gains_has_no_slice(g, plane):
    x, y = region_slice(Gains(g), plane)
    assert x.size == y.size == 0


@pytest.mark.parametrize("plane", [("beta", "alpha"), ("alpha", "gamma"), ("alpha", "alpha"), ("x", "y")])
def test_a_plane_that_the_order_does_not_have_is_refused(plane):
    with pytest.raises(InputError, match="^plane must be two gains of order 2"):
        region_slice(Gains((0.5, 0.2)), plane)


@pytest.mark.parametrize(
    "g", [(0.5, 0.2, 0.1), (1.5, 0.2, 2.0), (0.5, 0.5, 0.1, 0.02), (0.5, 0.5, 1.0, 3.0), (1, 1, 5, 7.9)], ids=str
)
def test_the_printed_slice_is_what_the_printed_conditions_say(g):
    alpha, beta = printed_slice(Gains(g))
    if not alpha.size:
        grid = np.stack(np.meshgrid(np.linspace(0, 2, 101), np.linspace(0, 9, 101)), axis=-1).reshape(-1, 2)
        assert not any(passes((*pair, *g[2:])) for pair in grid.tolist())
        return
    assert (alpha[0], beta[0]) == (alpha[-1], beta[-1])
    middle, low, high = alpha[1:99], beta[1:99], beta[100:200][::-1][1:99]
    for share, expected in [(-1e-9, False), (1e-9, True), (0.5, True), (1 - 1e-9, True), (1 + 1e-9, False)]:
        at = low + share * (high - low)
        assert [passes((a, b, *g[2:])) for a, b in zip(middle, at, strict=True)] == [expected] * 98
    for outside in (alpha.min() - 1e-6, alpha.max() + 1e-6):
        assert not any(passes((outside, b, *g[2:])) for b in np.linspace(0, 9, 1001))


def passes(g):
    return all(condition.holds for condition in printed_conditions(Gains(tuple(g))))


@pytest.mark.parametrize(
    ("g", "plane"),
    [
        ((0.5, 0.5), ("alpha", "beta")),
        ((0.5, 0.5, 0.1), ("alpha", "gamma")),
        ((0.5, 0.5, 0.0), ("alpha", "beta")),
        ((0.5, 0.5, 20.0), ("alpha", "beta")),
        ((0.5, 0.5, 0.1, 0.0), ("alpha", "beta")),
        ((0.5, 0.5, 0.1, 8.0), ("alpha", "beta")),
    ],
    ids=str,
)
def test_nothing_was_printed_there(g, plane):
    alpha, beta = printed_slice(Gains(g), plane)
    assert alpha.size == beta.size == 0


# The surface of order 3 --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [{}, {"rows": 1, "columns": 1}, {"rows": 3, "columns": 7}], ids=str)
def test_the_surface_is_a_closed_ball(size):
    """Every edge belongs to two triangles that run along it in opposite directions; V - E + F = 2."""
    vertices, faces = region_surface(**size)
    assert vertices.dtype == np.float64
    assert faces.dtype == np.int32
    edges = Counter((a, b) for face in faces.tolist() for a, b in zip(face, (*face[1:], face[0]), strict=True))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    assert len(vertices) - len(edges) // 2 + len(faces) == 2
    assert set(faces.ravel().tolist()) == set(range(len(vertices)))
    a, b, c = vertices[faces].transpose(1, 0, 2)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=-1).min() > 1e-6


def test_the_surface_is_the_border(closed_loop, spectral_radius):
    vertices, _ = region_surface()
    assert 2000 <= len(vertices) <= 4000
    # At the corners poles meet at one and minus one; three are known to the cube root of the rounding error.
    assert spectral_radius(closed_loop(vertices)) == pytest.approx(1, abs=2e-5)
    corners = np.array([(0, 0, 0), (2, 0, 0), (0, 4, 0), (2, 0, 8)])
    away = np.linalg.norm(vertices[:, None] - corners, axis=-1).min(axis=1) > 0.1
    assert away.sum() > 2000
    assert spectral_radius(closed_loop(vertices[away])) == pytest.approx(1, abs=1e-6)
    assert vertices.max(axis=0) == pytest.approx(BOX[3], rel=1e-12)
    assert vertices.min(axis=0).tolist() == [0, 0, 0]


def test_the_surface_encloses_the_volume_of_the_region():
    """The integral of 2 ab/(2 - a) over the triangle, which is that of 4 a (2 - a) da from 0 to 2.

    Outward normals make it positive; the error of flat triangles falls with the square of their size.
    """
    exact = 16 / 3
    errors = []
    for size in (12, 24, 48):
        vertices, faces = region_surface(size, size)
        a, b, c = vertices[faces].transpose(1, 0, 2)
        errors.append(np.einsum("ij,ij->", a, np.cross(b, c)) / 6 - exact)
    assert abs(errors[-1]) < 0.01 * exact
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.2)


@pytest.mark.parametrize("size", [{"rows": 0}, {"columns": 0}, {"rows": 2.5}])
def test_a_surface_needs_steps(size):
    with pytest.raises(InputError, match="^(rows|columns) must be a whole number >= 1"):
        region_surface(**size)


# The way back ------------------------------------------------------------------------------------------------------


def distance_over_poles(target, radius, starts, seed):
    """The least distance that a general minimiser finds over the poles themselves, as products of real factors."""
    order = len(target)
    draw = np.random.default_rng(seed)

    def gains(factors):
        polynomial = np.array([1.0])
        for x, y in factors[: order - order % 2].reshape(-1, 2):
            # (x, y) in the unit square covers the triangle of stable z^2 + p z + q: q = y, p = x (1 + y).
            polynomial = np.polymul(polynomial, [1, radius * x * (1 + y), radius**2 * y])
        if order % 2:
            polynomial = np.polymul(polynomial, [1, radius * factors[-1]])
        return matrix @ polynomial[1:] + base

    base, matrix = affine(order)
    best = np.inf
    for start in draw.uniform(-0.95, 0.95, (starts, order)):
        done = minimize(
            lambda factors: ((gains(factors) - target) ** 2).sum(), start, bounds=[(-1, 1)] * order, method="SLSQP",
            options={"ftol": 1e-15, "maxiter": 300},
        )  # fmt: skip
        best = min(best, done.fun)
    return np.sqrt(best)


def affine(order):
    """Gains as base + matrix @ coefficients, from as many polynomials as it takes."""
    draw = np.random.default_rng(0)
    sets = [draw.uniform(-0.9, 0.9, order) for _ in range(order + 1)]
    coefficients = np.array([np.poly(roots)[1:] for roots in sets])
    solution = np.linalg.solve(
        np.column_stack((np.ones(order + 1), coefficients)), np.array([gains_from_poles(roots) for roots in sets])
    )
    return solution[0], solution[1:].T


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("scale", [0.02, 1.0, 30.0])
def test_nearest_stable_gains_are_the_nearest(order, scale):
    """No farther than what a general minimiser finds from 25 starts, and within the circle."""
    draw = np.random.default_rng([order, round(100 * scale)])
    for target in draw.uniform(-0.4, 1.4, (4, order)) * BOX[order] * scale:
        gains = Gains.normalised(target)
        if is_stable(gains):
            continue
        found = nearest_stable(gains)
        assert abs(poles(found)[0]) <= RADIUS + SCATTER
        distance = np.linalg.norm(found.vector - target)
        general = distance_over_poles(target, RADIUS, 25, seed=1)
        assert distance <= general * (1 + 1e-8) + 1e-9


def onto_triangle(point, corners):
    """The nearest point of a triangle that a point outside has: on one of its sides."""
    candidates = []
    for a, b in zip(corners, np.roll(corners, 1, axis=0), strict=True):
        share = np.clip(np.dot(point - a, b - a) / np.dot(b - a, b - a), 0, 1)
        candidates.append(a + share * (b - a))
    return min(candidates, key=lambda candidate: np.linalg.norm(candidate - point))


@given(alpha=st.floats(-5, 8), beta=st.floats(-5, 8), radius=st.sampled_from([0.5, 0.9, 0.99, 0.999]))
@example(alpha=0.5, beta=3.5, radius=0.99)
def test_nearest_stable_gains_of_order_two_are_the_projection_onto_a_triangle(alpha, beta, radius):
    """Its corners have both poles at r, both at -r, and one at each."""
    corners = np.array([gains_from_poles(pair) for pair in ([radius, radius], [-radius, -radius], [radius, -radius])])
    gains = Gains((alpha, beta))
    found = nearest_stable(gains, radius)
    if found != gains:
        assert found.vector == pytest.approx(onto_triangle(np.array([alpha, beta]), corners), rel=0, abs=1e-9)
    else:
        assert abs(poles(gains)[0]) <= radius + 1e-6


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_gains_within_the_circle_come_back_as_they_are(stable_gains, order, convention):
    for g in stable_gains(order, 30, seed=order, radius=0.9):
        gains = Gains.normalised(g).to(convention)
        assert nearest_stable(gains) is gains


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_nearest_stable_gains_are_given_in_the_convention_of_the_question(random_gains, order, convention):
    """The distance is that of the normalised gains, whatever they are written in."""
    for g in random_gains(order, 12, seed=order):
        gains = Gains.normalised(g)
        found = nearest_stable(gains.to(convention))
        assert found.convention == convention
        assert is_stable(found)
        assert found.vector == pytest.approx(nearest_stable(gains).vector, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("order", ORDERS)
def test_the_nearest_of_the_nearest_is_itself(random_gains, order):
    for g in random_gains(order, 40, seed=order):
        once = nearest_stable(Gains.normalised(g))
        assert nearest_stable(once).vector == pytest.approx(once.vector, rel=0, abs=1e-9)


@pytest.mark.parametrize("order", ORDERS)
def test_far_away_gains_find_back(order):
    """The largest that can be written; the way back is taken from the polynomial, not from the distance."""
    for sign in (1, -1):
        found = nearest_stable(Gains((sign * 1e9,) * order))
        assert is_stable(found)
        assert abs(poles(found)[0]) <= RADIUS + SCATTER


@pytest.mark.parametrize("radius", [1e-3, 0.5])
def test_a_small_circle_leaves_little_but_the_last_samples(radius):
    """With all poles near zero the gains are those of a polynomial through the last samples."""
    found = nearest_stable(Gains((0.5, 0.2, 0.05)), radius)
    assert abs(poles(found)[0]) <= radius + SCATTER
    assert found.vector == pytest.approx([1, 1.5, 1], abs=8 * radius)


def test_slow_filters_are_brought_within_the_circle():
    """Stable, with all poles at 0.999."""
    gains = Gains.normalised(DESIGNS["fading-memory"].gains(3, xi=0.999))
    found = nearest_stable(gains)
    assert found != gains
    assert abs(poles(found)[0]) <= RADIUS + SCATTER


@pytest.mark.parametrize("radius", [0, 1, -0.5, 2, float("nan")])
def test_a_circle_that_is_not_within_the_unit_circle_is_refused(radius):
    with pytest.raises(InputError, match="^radius must be a finite number > 0 and < 1"):
        nearest_stable(Gains((3.0, 1.0)), radius)


@pytest.mark.parametrize("points", [1, -3, 2.5, 2e6])
def test_a_border_has_points(points):
    with pytest.raises(InputError, match="^points must be"):
        region_slice(Gains((0.5, 0.3)), points=points)
