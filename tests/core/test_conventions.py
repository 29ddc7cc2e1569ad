"""Gain conventions: three ways of writing one filter."""

from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import CONVENTIONS, Gains, InputError, Measurements, assess, run_filter
from tracker_core.conventions import rewrite

# Normalised gain divided by written gain: 2 gamma/T^2, 6 eta/T^3 (Brookner) and gamma/2T^2, eta/6T^3 (Bar-Shalom).
FACTORS = {
    "normalised": (1, 1, 1, 1),
    "taylor": (1, 1, 2, 6),
    "half": (1, 1, Fraction(1, 2), Fraction(1, 6)),
}
# A gain of 1000 / 36 stays a gain in every convention, and one of 1e-290 keeps all its digits.
GAIN = st.floats(-27, 27).filter(lambda value: value == 0 or abs(value) > 1e-290)
PAIRS = list(permutations(FACTORS, 2))


def test_all_conventions_are_known_here():
    assert set(CONVENTIONS) == set(FACTORS)


@pytest.mark.parametrize("name", FACTORS)
def test_factors(name):
    assert CONVENTIONS[name].factors == tuple(map(float, FACTORS[name]))


@pytest.mark.parametrize(("source", "target"), PAIRS)
@given(value=GAIN)
def test_rewriting_rounds_once(source, target, value):
    for index in range(4):
        exact = Fraction(value) * FACTORS[source][index] / FACTORS[target][index]
        assert rewrite(value, index, source, target) == float(exact)


@pytest.mark.parametrize(("source", "target"), PAIRS)
@given(values=st.lists(GAIN, min_size=2, max_size=4))
def test_round_trip(source, target, values):
    there = Gains(tuple(values), source).to(target)
    back = there.to(source)
    assert (there.convention, back.convention) == (target, source)
    # Twos are exact in binary; sixes cost one unit in the last place.
    assert back.values[:3] == tuple(values[:3])
    assert back.values == pytest.approx(tuple(values), rel=2.3e-16, abs=0)


@pytest.mark.parametrize("name", FACTORS)
@given(values=st.lists(GAIN, min_size=2, max_size=4))
def test_vector_is_normalised(name, values):
    exact = [float(Fraction(value) * factor) for value, factor in zip(values, FACTORS[name], strict=False)]
    vector = Gains(tuple(values), name).vector
    assert vector.dtype == np.float64
    assert vector.tolist() == exact


@pytest.mark.parametrize("name", FACTORS)
def test_same_convention_changes_nothing(name):
    gains = Gains((0.1, 0.2, 0.3, 0.4), name)
    assert gains.to(name) == gains


@pytest.mark.parametrize("name", FACTORS)
def test_alpha_and_beta_are_the_same_in_every_convention(name):
    assert Gains((0.3, 0.7), "normalised").to(name).values == (0.3, 0.7)


@pytest.mark.parametrize("name", FACTORS)
def test_converting_leaves_the_filter_as_it_is(name):
    positions = np.random.default_rng(3).normal(size=(60, 2)).cumsum(axis=0)
    measurements = Measurements(np.arange(60.0), positions, 1.0)
    gains = Gains((0.5, 0.4, 0.1), "taylor")
    first, second = (run_filter(measurements, g, start="first") for g in (gains, gains.to(name)))
    assert np.array_equal(first.smoothed, second.smoothed)
    assert np.array_equal(first.predicted, second.predicted, equal_nan=True)


def test_normalised_takes_an_array():
    gains = Gains.normalised(np.array([0.5, 0.4, 0.1]))
    assert gains == Gains((0.5, 0.4, 0.1), "normalised")
    assert gains.order == 3
    assert all(type(value) is float for value in gains.values)


@pytest.mark.parametrize(
    "values", [np.array([0.5, 0.25]), [0.5, 0.25], (np.float64(0.5), np.float32(0.25)), ("0.5", "0.25")], ids=repr
)
def test_gains_are_plain_numbers_whatever_they_came_as(values):
    gains = Gains(values)
    assert gains == Gains((0.5, 0.25))
    assert hash(gains) == hash(Gains((0.5, 0.25)))
    assert [type(value) for value in gains.values] == [float, float]
    assert assess(gains).stable


@pytest.mark.parametrize(
    ("values", "convention", "field", "received"),
    [
        ((0.5,), "normalised", "gains", (0.5,)),
        ((), "normalised", "gains", ()),
        ((0.1,) * 5, "normalised", "gains", (0.1,) * 5),
        ((float("nan"), 0.1), "normalised", "alpha", float("nan")),
        ((0.1, float("inf")), "normalised", "beta", float("inf")),
        ((0.1, 0.1, -1000000001.0), "normalised", "gamma", -1000000001.0),
        ((1000000001.0, 0.1), "half", "alpha", 1000000001.0),
        ((0.1, 0.1, 0.1, 1e300), "taylor", "eta", 1e300),
        ((0.1, True), "normalised", "beta", True),
        ((0.1, 0.1), "brookner", "convention", "brookner"),
    ],
)
def test_bad_gains_are_refused(values, convention, field, received):
    with pytest.raises(InputError) as caught:
        Gains(values, convention)
    assert caught.value.field == field
    assert repr(caught.value.received) == repr(received)


@pytest.mark.parametrize("convention", FACTORS)
@pytest.mark.parametrize("value", [-1e6, 1e6])
def test_the_greatest_gains(convention, value):
    """A thousand times what a user may give, so that rewriting what he gives never leaves the domain."""
    assert Gains((value,) * 4, convention).values == (value,) * 4


def test_conversion_to_an_unknown_convention_is_refused():
    with pytest.raises(InputError, match="^convention must be one of normalised, taylor, half, got 'brookner'$"):
        Gains((0.1, 0.1)).to("brookner")


@pytest.mark.parametrize("convention", ["normalised", "taylor", "half"])
def test_gains_at_their_limit_can_be_rewritten(convention):
    gains = Gains((0.1, 0.1, 1e9, -1e9), "half" if convention == "taylor" else "taylor")
    assert gains.to(convention).to(gains.convention).values == pytest.approx(gains.values, rel=1e-15)
