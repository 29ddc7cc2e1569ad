"""The search without derivatives on functions whose least value is known."""

import numpy as np
import pytest

from tracker_core.tuning.islands import EDGE, POPULATION, Islands


def ackley(places):
    """Many hollows, the deepest at 1 ... 1, where it is 0.1."""
    x = places - 1
    return 20.1 - 20 * np.exp(-0.2 * np.sqrt((x**2).mean(axis=1))) + np.e - np.exp(np.cos(2 * np.pi * x).mean(axis=1))


def rosenbrock(places):
    """A bent valley to 1 ... 1, where it is 2."""
    x = places
    return 2 + (100 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1 - x[:, :-1]) ** 2).sum(axis=1)


def searched(function, starts, generations=400, seed=0):
    islands, least, where, tried = Islands(starts, seed), np.inf, None, 0
    for _ in range(generations):
        if not islands:
            break
        places = islands.ask()
        assert places.shape == (len(islands) * POPULATION, starts.shape[1])
        scores = function(places)
        tried += len(places)
        if scores.min() < least:
            least, where = float(scores.min()), places[int(np.argmin(scores))]
        islands.tell(scores)
    assert not islands
    return least, where, tried


@pytest.mark.parametrize("dimensions", [2, 3, 4])
@pytest.mark.parametrize(("function", "least"), [(ackley, 0.1), (rosenbrock, 2.0)])
def test_the_deepest_hollow_is_found(function, least, dimensions):
    starts = 2 * np.random.default_rng(5).standard_normal((24, dimensions))
    found, where, _ = searched(function, starts)
    assert found == pytest.approx(least, rel=1e-4)
    assert where == pytest.approx(np.ones(dimensions), abs=0.05)


def test_the_same_seed_takes_the_same_way():
    starts = np.random.default_rng(5).standard_normal((6, 3))
    first, again, other = (searched(ackley, starts, seed=seed) for seed in (3, 3, 4))
    assert first[0] == again[0]
    assert np.array_equal(first[1], again[1])
    assert first[2] == again[2]
    assert not np.array_equal(first[1], other[1])


def test_where_nothing_differs_it_ends_at_once():
    assert searched(lambda places: np.zeros(len(places)), np.zeros((4, 2)))[2] == 4 * POPULATION


def test_islands_on_one_place_become_one():
    alone = searched(rosenbrock, np.zeros((1, 2)))[2]
    assert searched(rosenbrock, np.zeros((20, 2)))[2] < 20 * alone


def test_places_that_come_to_nothing_are_left():
    def half(places):
        return np.where(places[:, 0] < 0.2, np.nan, ackley(places))

    starts = np.random.default_rng(5).standard_normal((24, 2))
    assert searched(half, starts)[0] == pytest.approx(0.1, rel=1e-4)
    assert searched(lambda places: np.full(len(places), np.inf), starts)[0] == np.inf


def test_the_edge_is_kept():
    islands = Islands(np.full((3, 2), 50.0))
    for _ in range(20):
        places = islands.ask()
        assert np.abs(places).max() <= EDGE
        islands.tell(1e3 - places.sum(axis=1))
        if not islands:
            break
