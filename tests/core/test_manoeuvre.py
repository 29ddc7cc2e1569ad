"""Manoeuvre noise: the recursion, its covariance, and streams of its own."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import InputError
from tracker_core.manoeuvre import MANOEUVRES, held_std, wander
from tracker_core.noise import white

NAMES = [name for name in MANOEUVRES if name != "none"]
every_model = pytest.mark.parametrize("name", NAMES)

# Written out again, as the papers print them.
INPUT = {
    "acceleration-pulses": lambda t: np.array([t * t / 2, t, 0]),
    "acceleration-jumps": lambda t: np.array([t * t / 2, t, 1]),
    "jerk-pulses": lambda t: np.array([t * t * t / 6, t * t / 2, t]),
}


def transition(t):
    return np.array([[1, t, t * t / 2], [0, 1, t], [0, 0, 1]])


def drawn(seed, axis, count):
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(axis, 1))).standard_normal(count)


@pytest.mark.parametrize("name", MANOEUVRES)
def test_manoeuvre_is_described(name):
    model = MANOEUVRES[name]
    assert model.name == name
    assert model.title
    assert bool(model.formula) == bool(model.unit) == (name != "none")


@every_model
@given(interval=st.floats(1e-3, 100), std=st.floats(1e-3, 1e3), seed=st.integers(0, 2**53 - 1))
def test_wander_is_the_recursion(name, interval, std, seed):
    """Sample by sample with the transition matrix; where the sum cancels, the scale is the way travelled."""
    found = wander(name, 50, 2, interval, std, seed)
    for axis in range(2):
        w, d = std * drawn(seed, axis, 49), np.zeros(3)
        largest = np.zeros(3)
        for k in range(49):
            d = transition(interval) @ d + INPUT[name](interval) * w[k]
            largest = np.maximum(largest, np.abs(d))
            assert (np.abs(found[k + 1, axis, :3] - d) <= 1e-12 * largest).all()
    assert not found[0].any()
    assert not found[:, :, 3:].any()


@every_model
@pytest.mark.parametrize("interval", [0.1, 2.0])
def test_its_covariance_is_that_of_the_model(name, interval):
    """P(k+1) = F P F' + G G' std^2, against the spread over many axes, which are independent."""
    axes, samples, std = 10_000, 12, 3.0
    found = wander(name, samples, axes, interval, std, 5)
    f, g = transition(interval), INPUT[name](interval)[:, None]
    expected = np.zeros((3, 3))
    for k in range(samples):
        spread = np.cov(found[k, :, :3].T, bias=True)
        deviations = np.sqrt(np.diag(expected))
        # The variance of an estimated covariance: (P_ii P_jj + P_ij^2)/n.
        error = np.sqrt((np.outer(deviations, deviations) ** 2 + expected**2) / axes)
        assert (np.abs(spread - expected) <= 4.5 * error).all()
        expected = f @ expected @ f.T + g @ g.T * std**2


@every_model
@pytest.mark.parametrize("derivative", [2, 3, 4])
def test_what_is_held_for_an_interval_is_that_derivative(name, derivative):
    """As its G says: T^d/d! of the position; wander shows none of it at the samples."""
    interval = 0.7
    g, held = INPUT[name](interval), [interval**derivative / math.factorial(derivative)]
    held += [interval ** (derivative - 1) / math.factorial(derivative - 1)]
    holds = g[:2] == pytest.approx(held) and (derivative > 2 or g[2] == 0)
    # A jump of a derivative, such as of one that is held, is an impulse of the next.
    comes_in_impulses = derivative > {"acceleration-pulses": 2, "acceleration-jumps": 2, "jerk-pulses": 3}[name]
    assert held_std(name, derivative, 3.0) == (math.inf if comes_in_impulses else 3.0 if holds else 0.0)
    assert held_std(name, derivative, 0.0) == 0


def test_nothing_is_held_where_nothing_pushes():
    assert held_std("none", 2, 3.0) == 0
    with pytest.raises(InputError, match="^manoeuvre_std must be"):
        held_std("jerk-pulses", 3, -1.0)


def test_pulses_leave_no_acceleration_and_jumps_do():
    assert not wander("acceleration-pulses", 20, 2, 1.0, 1.0, 1)[:, :, 2].any()
    assert wander("acceleration-jumps", 20, 2, 1.0, 1.0, 1)[1:, :, 2].all()


@pytest.mark.parametrize("name", MANOEUVRES)
@given(seed=st.integers(0, 2**53 - 1), short=st.integers(1, 30), more=st.integers(0, 30))
def test_a_longer_run_begins_with_the_shorter_one(name, seed, short, more):
    longer, shorter = (wander(name, samples, 2, 0.5, 2.0, seed) for samples in (short + more, short))
    assert np.array_equal(longer[:short], shorter)


@pytest.mark.parametrize("name", MANOEUVRES)
@given(seed=st.integers(0, 2**53 - 1))
def test_adding_an_axis_changes_no_other(name, seed):
    assert np.array_equal(wander(name, 20, 3, 0.5, 2.0, seed)[:, :2], wander(name, 20, 2, 0.5, 2.0, seed))


@given(seed=st.integers(0, 2**53 - 2))
def test_streams_are_those_of_this_seed_and_none_of_the_measurement_noise(seed):
    """With T = 1 the acceleration of jumps is the sum of w itself."""
    found, following = (
        np.diff(wander("acceleration-jumps", 20, 2, 1.0, 1.0, which)[:, :, 2], axis=0) for which in (seed, seed + 1)
    )
    assert found[:, 0] == pytest.approx(drawn(seed, 0, 19), abs=1e-13)
    for other in (white((20, 3), (1.0,), seed), following):
        assert np.abs(found.ravel()[:, None] - other.ravel()).min() > 1e-13


@pytest.mark.parametrize("name", MANOEUVRES)
def test_without_strength_nothing_moves(name):
    assert not wander(name, 10, 2, 1.0, 0.0, 1).any()


def test_none_moves_nothing():
    assert not wander("none", 10, 2, 1.0, 5.0, 1).any()


@pytest.mark.parametrize(
    ("field", "given"),
    [
        ("manoeuvre", {"name": "loop"}),
        ("interval", {"interval": 0.0}),
        ("interval", {"interval": math.nan}),
        ("manoeuvre_std", {"std": -1.0}),
        ("manoeuvre_std", {"std": math.inf}),
    ],
    ids=str,
)
def test_what_makes_no_sense_is_refused(field, given):
    usual = {"name": "jerk-pulses", "samples": 5, "axes": 1, "interval": 1.0, "std": 1.0, "seed": 1}
    with pytest.raises(InputError) as caught:
        wander(**{**usual, **given})
    assert caught.value.field == field
