"""What holds for every method that chooses the gains while the filter runs, whatever it chooses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker_core import Measurements, Truth
from tracker_core.adaptive import METHODS, PARAMETERS

SMALL = {
    "moving-window": {"window": 6, "levels": 7},
    "parallel-bank": {"members": 5},
    "parallel-bank-causal": {"members": 5},
    "critically-damped-bank": {"members": 3},
    "sample-search": {"grid": 3, "grid_eta": 4},
    # With an odd grid alpha = 1 is a level, at which the smoothed position does not depend on the other gains.
    "run-search": {"grid": 4, "grid_eta": 3},
}
CASES = [pytest.param(name, order, id=f"{name}-{order}") for name in METHODS for order in METHODS[name].orders]
CAUSAL = [
    *[pytest.param(name, order, SMALL.get(name, {}), id=f"{name}-{order}") for name, method in METHODS.items()
      for order in method.orders if not method.hindsight(method.defaults(1.0))],
    pytest.param("linear-combination", 2, {"weight": 0.3}, id="linear-combination-2-weight"),
]  # fmt: skip
JOINT = ("critically-damped-bank", "run-search")
"""Methods whose axes share a choice."""

SAMPLES = 40


def scene(seed, samples=SAMPLES, axes=2, interval=0.5):
    """A weaving target, its true states, and noisy measurements of it."""
    times = np.arange(samples) * interval
    states = np.zeros((samples, axes, 5))
    for axis in range(axes):
        rate = 0.3 + 0.2 * axis
        for k in range(5):
            states[:, axis, k] = 100 * rate**k * np.sin(rate * times + k * np.pi / 2)
    noise = np.random.default_rng(seed).normal(size=(samples, axes)) * 40 / 10.0 ** np.arange(axes)
    return Truth(times, states), Measurements(times, states[:, :, 0] + noise, interval)


def straight(times, axes=2):
    """Constant velocity without noise."""
    states = np.zeros((len(times), axes, 5))
    states[:, :, 1] = 7.0 - 3 * np.arange(axes)
    states[:, :, 0] = 100 + times[:, None] * states[:, :, 1]
    return Truth(times, states)


def run(name, order, measurements, truth, **parameters):
    return METHODS[name].run(measurements, order, truth=truth, **{**SMALL.get(name, {}), **parameters})


def changed(measurements, positions):
    return Measurements(measurements.times, positions, measurements.interval)


def arrays_of(selection):
    return selection.track.predicted, selection.track.smoothed, selection.gains


def assert_same(one, other):
    for mine, theirs in zip(arrays_of(one), arrays_of(other), strict=True):
        assert np.array_equal(mine, theirs, equal_nan=True)


# The registry ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", METHODS)
def test_method_is_described(name):
    method = METHODS[name]
    assert method.name == name
    assert method.title
    assert method.source
    assert method.sentence.endswith(".")
    assert set(method.parameters) <= set(PARAMETERS)
    assert list(method.orders) == sorted(set(method.orders))


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("interval", [1e-5, 0.2, 3.0, 1e6])
def test_defaults_are_admitted(name, interval):
    for parameter, value in METHODS[name].defaults(interval).items():
        assert PARAMETERS[parameter].read(parameter, value) == value


@pytest.mark.parametrize("name", METHODS)
def test_a_method_of_hindsight_says_why_and_names_a_causal_one(name):
    method = METHODS[name]
    reason = method.hindsight(method.defaults(1.0))
    assert (method.counterpart is None) == (reason == "")
    if method.counterpart is not None:
        assert reason.endswith(".")
        assert METHODS[method.counterpart].counterpart is None
    assert METHODS["linear-combination"].hindsight({"weight": 0.0}) == ""


# What a tracker may know -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "order", "parameters"), CAUSAL)
@settings(max_examples=20)
@given(k=st.integers(0, SAMPLES - 1), seed=st.integers(0, 99), gap=st.booleans())
def test_a_causal_method_knows_nothing_of_what_comes(name, order, parameters, k, seed, gap):
    """Prediction k comes before measurement k."""
    _, measurements = scene(seed)
    measurements.positions[7:9, 0] = np.nan
    later = measurements.positions.copy()
    later[k:] = np.nan if gap and k >= 2 else 1e3 * np.random.default_rng(seed).normal(size=later[k:].shape)
    one, other = (METHODS[name].run(changed(measurements, z), order, **parameters)
                  for z in (measurements.positions, later))  # fmt: skip
    assert np.array_equal(one.track.predicted[: k + 1], other.track.predicted[: k + 1], equal_nan=True)
    assert np.array_equal(one.track.smoothed[:k], other.track.smoothed[:k], equal_nan=True)
    assert np.array_equal(one.gains[:k], other.gains[:k], equal_nan=True)
    assert not np.array_equal(one.track.smoothed[k:], other.track.smoothed[k:], equal_nan=True)


@pytest.mark.parametrize(("name", "order", "parameters"), CAUSAL)
def test_a_causal_method_does_not_look_at_the_truth(name, order, parameters):
    truth, measurements = scene(1)
    assert_same(*(METHODS[name].run(measurements, order, truth=known, **parameters) for known in (None, truth)))


@pytest.mark.parametrize("name", ["parallel-bank", "linear-combination", "run-search"])
def test_a_prediction_in_hindsight_has_seen_what_it_predicts(name):
    truth, measurements = scene(3)
    later = measurements.positions.copy()
    later[20:] += 500
    order = METHODS[name].orders[0]
    one, other = (run(name, order, changed(measurements, z), truth) for z in (measurements.positions, later))
    assert not np.array_equal(one.track.predicted[:21], other.track.predicted[:21], equal_nan=True)


@pytest.mark.parametrize(("name", "order"), [("sample-search", 3), ("sample-search", 4), ("run-search", 3)])
def test_a_search_with_the_truth_depends_on_it(name, order):
    truth, measurements = scene(3)
    other = Truth(truth.times, truth.states * np.linspace(1, 3, SAMPLES)[:, None, None])
    one, two = (run(name, order, measurements, known) for known in (truth, other))
    assert not np.array_equal(one.track.smoothed, two.track.smoothed, equal_nan=True)


# Laws of every filter ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "order"), CASES)
@pytest.mark.parametrize("regular", [True, False], ids=["regular", "irregular"])
def test_a_straight_line_is_followed_exactly(name, order, regular):
    """From two points without noise, whatever the gains and intervals."""
    times = np.arange(SAMPLES) * 0.5
    if not regular:
        times = np.cumsum(np.random.default_rng(5).uniform(0.4, 0.6, SAMPLES))
    truth = straight(times)
    selection = run(name, order, Measurements(times, truth.positions.copy(), 0.5 if regular else None), truth)
    for states, begin in ((selection.track.predicted, 2), (selection.track.smoothed, 1)):
        expected = truth.states[begin:, :, :order]
        assert np.abs(states[begin:] - expected).max() <= 1e-9 * np.abs(truth.positions).max()


@pytest.mark.parametrize(("name", "order"), CASES)
@pytest.mark.parametrize("factor", [-1.0, 8.0, 2.0**-20])
def test_the_unit_of_length_does_not_matter(name, order, factor):
    """With a power of two as the new unit, bit for bit."""
    truth, measurements = scene(4)
    one = run(name, order, measurements, truth)
    other = run(
        name, order, changed(measurements, factor * measurements.positions), Truth(truth.times, factor * truth.states)
    )
    assert np.array_equal(other.track.predicted, factor * one.track.predicted, equal_nan=True)
    assert np.array_equal(other.track.smoothed, factor * one.track.smoothed, equal_nan=True)
    assert np.array_equal(other.gains, one.gains, equal_nan=True)
    assert other.found == one.found


@pytest.mark.parametrize(("name", "order"), CASES)
def test_the_origin_does_not_matter(name, order):
    truth, measurements = scene(6)
    moved = truth.states.copy()
    moved[:, :, 0] += 1234.5
    one = run(name, order, measurements, truth)
    other = run(name, order, changed(measurements, measurements.positions + 1234.5), Truth(truth.times, moved))
    size = 1234.5 + np.abs(measurements.positions).max()
    for mine, theirs in zip(arrays_of(one)[:2], arrays_of(other)[:2], strict=True):
        shift = np.where(np.arange(order) == 0, 1234.5, 0.0)
        # Before the start takes over, states are not known.
        assert np.array_equal(np.isnan(mine), np.isnan(theirs))
        assert np.nanmax(np.abs(theirs - shift - mine)) <= 1e-9 * size
    assert np.nanmax(np.abs(one.gains - other.gains)) <= 1e-9


@pytest.mark.parametrize(("name", "order"), CASES)
def test_axes_are_apart_unless_they_choose_together(name, order):
    truth, measurements = scene(9)
    both = run(name, order, measurements, truth)
    alone = run(
        name, order, changed(measurements, measurements.positions[:, 1:]), Truth(truth.times, truth.states[:, 1:])
    )
    same = all(
        np.array_equal(mine[:, 1:], theirs, equal_nan=True)
        for mine, theirs in zip(arrays_of(both), arrays_of(alone), strict=True)
    )
    assert same == (name not in JOINT)
    for parameter, values in both.found.items():
        assert len(values) == (1 if name in JOINT else 2)
        if name not in JOINT:
            assert values[1:] == alone.found[parameter]


@pytest.mark.parametrize(("name", "order"), CASES)
def test_gaps_are_bridged(name, order):
    truth, measurements = scene(9)
    z = measurements.positions
    z[0, 0] = z[[5, 6, 20], 0] = z[[6, 39], 1] = z[25:33] = np.nan
    selection = run(name, order, measurements, truth)
    predicted, smoothed, gains = arrays_of(selection)
    for axis, begin in ((0, 3), (1, 2)):
        assert np.isnan(predicted[:begin, axis]).all()
        assert not np.isnan(predicted[begin:, axis]).any()
        assert not np.isnan(smoothed[begin - 1 :, axis]).any()
        assert np.isnan(gains[:begin, axis]).all()
        missing = np.isnan(z[begin:, axis])
        assert (np.isnan(gains[begin:, axis]) == missing[:, None]).all()
        # In a bank that chooses for all axes together a measurement of another axis moves the weights.
        missing = np.isnan(z[begin:]).all(axis=1) if name == "critically-damped-bank" else missing
        assert np.array_equal(smoothed[begin:, axis][missing], predicted[begin:, axis][missing])
    assert selection.track.missing == 3 + 2 + 16
    assert selection.track.stopped_at is None


@pytest.mark.parametrize(("name", "order"), CASES)
def test_all_axes_stop_with_the_first_of_them(name, order):
    truth, measurements = scene(2)
    z = np.random.default_rng(2).normal(size=(SAMPLES, 2))
    z[20:, 0] = 1e9
    selection = METHODS[name].run(
        changed(measurements, z), order, truth=truth, limit=1e3, **SMALL.get(name, {})
    )  # fmt: skip
    stop = selection.track.stopped_at
    assert stop is not None
    assert stop >= 20 or name == "run-search"
    predicted, smoothed, gains = arrays_of(selection)
    for array in (predicted, smoothed, gains):
        assert np.isnan(array[stop + 1 :]).all()
        assert not np.isnan(array[2 : stop + 1]).any()
    assert np.abs(smoothed[stop, :, 0]).max() > 1e3
    assert (np.abs(smoothed[:stop, :, 0]) <= 1e3).all()


@pytest.mark.parametrize("name", METHODS)
def test_the_start_may_pass_the_limit_too(name):
    truth, measurements = scene(2)
    selection = METHODS[name].run(
        changed(measurements, np.full((SAMPLES, 2), 200.0)), METHODS[name].orders[0], truth=truth, limit=100.0,
        **SMALL.get(name, {}),
    )  # fmt: skip
    assert selection.track.stopped_at == 0
    assert np.isnan(selection.gains).all()


# The gains in use at a sample --------------------------------------------------------------------------------------


def test_gains_at_are_the_last_ones_used():
    _, measurements = scene(9)
    measurements.positions[[5, 6], 0] = np.nan
    selection = METHODS["growing-memory"].run(measurements, 2)
    assert np.array_equal(selection.gains_at(4, 0), selection.gains[4, 0])
    assert np.array_equal(selection.gains_at(6, 0), selection.gains[4, 0])
    assert np.array_equal(selection.gains_at(6, 1), selection.gains[6, 1])
    assert np.array_equal(selection.gains_at(0, 0), selection.gains[2, 0])
    assert np.array_equal(selection.gains_at(10_000, 0), selection.gains[-1, 0])


def test_gains_at_are_zero_where_nothing_was_corrected():
    selection = METHODS["growing-memory"].run(Measurements(np.arange(2.0), np.ones((2, 1)), 1.0), 3)
    assert selection.gains_at(1, 0).tolist() == [0, 0, 0]
