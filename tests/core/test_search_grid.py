"""The grid that Yu & Wu 2017 search, in fractions: eq. 10-12 and 21-24, end points, bounds, equal gains."""

from collections import Counter
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from tracker_core import InputError
from tracker_core.adaptive.parameters import BOUNDS, END_POINTS
from tracker_core.adaptive.sample_search import candidates, neighbours

ORDERS = [3, 4]


def shares(end_points, count):
    numbers = [Fraction(i) for i in range(1, count + 1)]
    return {
        "interior": [i / (count + 1) for i in numbers],
        "middle": [(i - Fraction(1, 2)) / count for i in numbers],
        "upper": [i / count for i in numbers],
        "both": [(i - 1) / (count - 1) for i in numbers],
    }[end_points]


def printed_grid(order, grid, grid_eta, end_points, factor):
    """Eq. 10-12 and 21-24 in fractions, in the paper's convention: gamma is halved and delta divided by six after.

    The levels of gamma vary slowest, then those of alpha, beta and delta.
    """
    rows = []
    across = shares(end_points, grid)
    for c, a, b in product(across, repeat=3):
        alpha = 2 * a
        # 13/6 (4 - 2 alpha), and 4 alpha beta/(2 - alpha) without its division by zero.
        beta = factor * (4 - 2 * alpha) * b
        gamma = (4 * alpha * beta / (2 - alpha) if alpha < 2 else 8 * alpha * factor * b) * c
        fourth = shares(end_points, grid_eta) if order == 4 else [Fraction(0)]
        rows += [[alpha, beta, gamma / 2, 24 * (2 - alpha) * d / 6][:order] for d in fourth]
    return rows


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("bound", ["triangle", "printed"])
@pytest.mark.parametrize("end_points", END_POINTS)
def test_grid_is_the_printed_one(order, bound, end_points):
    factor = Fraction(13, 6) if bound == "printed" else Fraction(1)
    expected = printed_grid(order, 4, 6, end_points, factor)
    assert len(expected) == (64 if order == 3 else 384)
    sets, _ = candidates(order, 4, 6, end_points, bound)
    assert sets.tolist() == [[float(gain) for gain in row] for row in expected]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("end_points", END_POINTS)
def test_exact_bounds_leave_the_stable_sets_in_their_order(closed_loop, spectral_radius, order, end_points):
    sets, levels = candidates(order, 4, 6, end_points, "triangle")
    radius = spectral_radius(closed_loop(sets))
    # Sets on the border itself are for the exact test of stability to judge.
    clear = np.abs(radius - 1) > 1e-6
    kept, kept_levels = candidates(order, 4, 6, end_points, "exact")
    found = {tuple(row) for row in kept_levels.tolist()}
    for row, inside in zip(levels[clear].tolist(), (radius < 1)[clear].tolist(), strict=True):
        assert (tuple(row) in found) == inside
    rows = [row for row in levels.tolist() if tuple(row) in found]
    assert kept_levels.tolist() == rows
    assert (spectral_radius(closed_loop(kept)) < 1 - 1e-6).all()


@pytest.mark.parametrize(
    ("order", "bound", "stable", "of"),
    [(3, "triangle", 64, 64), (3, "printed", 32, 64), (4, "triangle", 44, 384), (4, "printed", 40, 384)],
)
def test_few_of_the_printed_sets_are_stable(closed_loop, spectral_radius, order, bound, stable, of):
    sets, _ = candidates(order, 4, 6, "interior", bound)
    radius = spectral_radius(closed_loop(sets))
    # None lies so near to the border that rounding could decide.
    assert np.abs(radius - 1).min() > 1e-6
    assert ((radius < 1).sum(), len(sets)) == (stable, of)
    if bound == "triangle":
        assert len(candidates(order, 4, 6, "interior", "exact")[0]) == stable


@pytest.mark.parametrize("grid", [3, 5, 6, 7])
def test_no_set_on_the_border_is_rounded_into_it(grid):
    """At order 3 the sets inside are those that lie at no end of any range."""
    _, levels = candidates(3, grid, 1, "both", "triangle")
    inside = ((levels > 1) & (levels < grid)).all(axis=1)
    assert candidates(3, grid, 1, "both", "exact")[1].tolist() == levels[inside].tolist()


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("end_points", END_POINTS)
def test_equal_gains_are_equal_to_the_last_bit(order, end_points):
    """As many different floats as there are different fractions, each as often."""
    sets, _ = candidates(order, 4, 6, end_points, "triangle")
    exact = printed_grid(order, 4, 6, end_points, Fraction(1))
    for which in range(order):
        floats = Counter(sets[:, which].tolist())
        fractions = Counter(row[which] for row in exact)
        assert sorted(floats.values()) == sorted(fractions.values())
    assert max(Counter(sets[:, 2].tolist()).values()) > 1


@pytest.mark.parametrize("which", range(4))
@pytest.mark.parametrize("bound", BOUNDS)
def test_neighbours_are_one_level_away(which, bound):
    _, levels = candidates(4, 3, 4, "interior", bound)
    lower, upper = neighbours(levels, which)
    rows = levels.tolist()
    step = np.eye(4, dtype=int)[which]
    for beside, sign in ((lower, -1), (upper, 1)):
        for k, row in enumerate(rows):
            wanted = (np.array(row) + sign * step).tolist()
            assert beside[k] == (rows.index(wanted) if wanted in rows else -1)


def test_a_grid_is_kept_unchangeable():
    with pytest.raises(ValueError, match="read-only"):
        candidates(3, 4, 6, "interior", "exact")[0][0, 0] = 0


@pytest.mark.parametrize(
    ("order", "grid", "grid_eta", "field"), [(3, 1, 6, "grid"), (4, 1, 6, "grid"), (4, 4, 1, "grid_eta")]
)
def test_levels_at_both_ends_are_two_at_least(order, grid, grid_eta, field):
    with pytest.raises(InputError) as caught:
        candidates(order, grid, grid_eta, "both", "exact")
    assert (caught.value.field, caught.value.received) == (field, 1)
    assert ">= 2" in caught.value.rule


def test_a_grid_without_a_stable_set_is_refused():
    with pytest.raises(InputError) as caught:
        candidates(3, 2, 6, "both", "exact")
    assert caught.value.field == "grid"
