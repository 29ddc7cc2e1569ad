"""The ways of starting a filter: known state, first measurements, growing memory."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import STARTS, Gains, InputError, Measurements, run_filter

GAINS = {2: Gains((0.3, 0.05)), 3: Gains((0.35, 0.07, 0.005)), 4: Gains((0.4, 0.1, 0.012, 0.0005))}
ORDERS = list(GAINS)


def regular(positions, interval=1.0):
    z = np.asarray(positions, dtype=float).reshape(len(positions), -1)
    return Measurements(np.arange(len(z)) * interval, z, interval)


def moving(state, times):
    """States of a polynomial target at the given times: shape (n, order)."""
    order = len(state)
    return np.array(
        [
            [sum(state[j] * t ** (j - i) / math.factorial(j - i) for j in range(i, order)) for i in range(order)]
            for t in times
        ]
    )


def fitted(times, positions, degree, order):
    """State at the last of the times, by numpy's least squares polynomial; zero beyond its degree."""
    span = max(times[-1] - times[0], 1.0)
    coefficients = np.polyfit((times - times[-1]) / span, positions, degree)[::-1]
    state = np.zeros(order)
    for i in range(degree + 1):
        state[i] = coefficients[i] * math.factorial(i) / span**i
    return state


def growing_gains(order, n):
    """Normalised gains of the growing-memory filter at sample n = 0, 1, ... (Brookner 1998, table 1.2-1)."""
    if order == 2:
        top, below = [2 * (2 * n + 1), 6], (n + 1) * (n + 2)
    elif order == 3:
        top, below = [3 * (3 * n**2 + 3 * n + 2), 18 * (2 * n + 1), 60], (n + 1) * (n + 2) * (n + 3)
    else:
        top = [8 * (2 * n**3 + 3 * n**2 + 7 * n + 3), 20 * (6 * n**2 + 6 * n + 5), 240 * (2 * n + 1), 840]
        below = (n + 1) * (n + 2) * (n + 3) * (n + 4)
    return np.array(top) / below


@pytest.mark.parametrize("name", STARTS)
def test_start_is_described(name):
    start = STARTS[name]
    assert start.name == name
    assert start.title
    assert start.sentence.endswith(".")


# Known state -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
def test_known_state_is_one_interval_before_the_first_sample(order):
    state = np.arange(1.0, order + 1)
    track = run_filter(regular([0, 0, 0], 0.5), GAINS[order], start="known", initial_state=state[None])
    assert track.predicted[0, 0] == pytest.approx(moving(state, [0.5])[0], rel=1e-15, abs=0)
    assert not np.isnan(track.smoothed).any()


# First measurement -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
def test_first_measurement_starts_at_rest(order):
    track = run_filter(regular([5, 7, 9]), GAINS[order], start="first")
    assert track.smoothed[0, 0].tolist() == [5] + [0] * (order - 1)
    assert np.isnan(track.predicted[0]).all()
    assert track.predicted[1, 0].tolist() == [5] + [0] * (order - 1)
    assert track.innovation[1, 0] == 2


# Two points --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("interval", [0.5, 3.0])
def test_two_points_give_position_and_mean_velocity(order, interval):
    """Al-Wagih & Abdulla, eq. 9-10: x = z1, v = (z1 - z0)/T, and the third sample is the first that is predicted."""
    track = run_filter(regular([4.0, 10.0, 0.0, 0.0], interval), GAINS[order], start="two-point")
    assert track.smoothed[1, 0] == pytest.approx([10, 6 / interval] + [0] * (order - 2), rel=1e-15, abs=0)
    assert np.isnan(track.predicted[:2]).all()
    assert track.predicted[2, 0, 0] == pytest.approx(16, rel=1e-15, abs=0)
    # Before there is a velocity, there is still a measured position.
    assert track.smoothed[0, 0, 0] == 4
    assert np.isnan(track.smoothed[0, 0, 1:]).all()


@pytest.mark.parametrize("order", ORDERS)
@given(state=st.tuples(st.floats(-1e4, 1e4), st.floats(-300, 300)), interval=st.floats(0.1, 10))
def test_two_points_are_exact_on_constant_velocity(order, state, interval):
    measurements = regular(moving(state, np.arange(20) * interval)[:, 0], interval)
    track = run_filter(measurements, GAINS[order], start="two-point")
    scale = 1 + np.abs(measurements.positions).max()
    assert np.abs(track.innovation[2:]).max() <= 1e-11 * scale
    assert np.abs(track.smoothed[1:, 0, 1] - state[1]).max() * interval <= 1e-11 * scale


@pytest.mark.parametrize("order", ORDERS)
def test_two_points_may_be_far_apart(order):
    """Missing measurements before and between the two do not spoil the velocity."""
    z = [np.nan, 10.0, np.nan, np.nan, 40.0, 50.0, 60.0]
    track = run_filter(regular(z, 2.0), GAINS[order], start="two-point")
    assert track.smoothed[4, 0] == pytest.approx([40, 5] + [0] * (order - 2), rel=1e-14, abs=0)
    assert np.isnan(track.predicted[:5]).all()
    assert track.innovation[5:] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_two_points_use_the_true_interval(order):
    times = np.array([0.0, 4.0, 5.0, 7.0])
    track = run_filter(Measurements(times, 3 * times[:, None], None), GAINS[order], start="two-point")
    assert track.smoothed[1:, 0, 1] == pytest.approx(3, rel=1e-14, abs=0)
    assert track.innovation[2:] == pytest.approx(0, abs=1e-13)


# Three points ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [3, 4])
def test_three_points_give_the_state_at_the_last(order):
    """a = (z2 - 2 z1 + z0)/T^2; the velocity is that of the same parabola at the last of its points."""
    z0, z1, z2, t = 1.0, 4.0, 13.0, 0.5
    track = run_filter(regular([z0, z1, z2, 0], t), GAINS[order], start="three-point")
    a = (z2 - 2 * z1 + z0) / t**2
    v = (z2 - z1) / t + a * t / 2
    assert track.smoothed[2, 0] == pytest.approx([z2, v, a] + [0] * (order - 3), rel=1e-14, abs=0)
    assert np.isnan(track.predicted[:3]).all()
    assert track.predicted[3, 0, 0] == pytest.approx(z2 + t * v + t**2 * a / 2, rel=1e-14, abs=0)


@pytest.mark.parametrize("order", [3, 4])
@given(
    state=st.tuples(st.floats(-1e4, 1e4), st.floats(-300, 300), st.floats(-20, 20)),
    steps=st.lists(st.floats(0.5, 3), min_size=19, max_size=19) | st.none(),
)
def test_three_points_are_exact_on_constant_acceleration(order, state, steps):
    """At a constant interval and at varying ones."""
    times = np.arange(20.0) if steps is None else np.concatenate(([0.0], np.cumsum(steps)))
    positions = moving(state, times)[:, :1]
    track = run_filter(Measurements(times, positions, None if steps else 1.0), GAINS[order], start="three-point")
    scale = 1 + np.abs(positions).max()
    assert np.abs(track.innovation[3:]).max() <= 1e-10 * scale
    assert np.abs(track.smoothed[2:, 0, 2] - state[2]).max() <= 1e-10 * scale


@pytest.mark.parametrize("order", [3, 4])
def test_three_points_may_be_far_apart(order):
    times = np.arange(12.0)
    z = moving((5, -3, 2), times)[:, 0]
    z[[0, 2, 3, 5]] = np.nan
    track = run_filter(regular(z), GAINS[order], start="three-point")
    assert track.smoothed[6, 0, :3] == pytest.approx(moving((5, -3, 2), [6.0])[0], rel=1e-12, abs=0)
    assert track.innovation[7:] == pytest.approx(0, abs=1e-10)


# Growing memory ----------------------------------------------------------------------------------------------------


def irregular_times(samples):
    return np.cumsum(np.random.default_rng(7).uniform(0.4, 2.5, samples))


LAYOUTS = {
    "regular": (3.0 * np.arange(60), []),
    "gaps": (3.0 * np.arange(60), [1, 4, 5, 6, 20]),
    "late": (3.0 * np.arange(60), [0, 1, 2]),
    "irregular": (irregular_times(60), []),
    "irregular-gaps": (irregular_times(60), [0, 2, 3, 9, 30]),
}


def gap_free_switch(order, alpha):
    """The number of measurements after which the growing-memory gain has fallen to alpha, at a constant interval."""
    return next(n for n in range(order, 1000) if growing_gains(order, n)[0] <= alpha)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_expanding_memory_is_the_least_squares_polynomial(order, layout):
    """Until the switch, every smoothed state is numpy's polynomial fit to all measurements so far."""
    times, missing = LAYOUTS[layout]
    z = 200 * np.sin(times / 20) + np.random.default_rng(1).normal(size=60) * 10
    z[missing] = np.nan
    interval = 3.0 if layout in {"regular", "gaps", "late"} else None
    # A gain so low that the steady filter takes over at the end or later.
    gains = Gains((0.01, *GAINS[order].values[1:]))
    track = run_filter(Measurements(times, z[:, None], interval), gains, start="expanding")
    scale = np.abs(np.nan_to_num(z)).max()
    seen = np.flatnonzero(~np.isnan(z))
    for count, index in enumerate(seen, start=1):
        expected = fitted(times[seen[:count]], z[seen[:count]], min(count, order) - 1, order)
        assert track.smoothed[index, 0] == pytest.approx(expected, rel=1e-12, abs=1e-12 * scale)
        if count > 1:
            # What was predicted for it is the fit to all measurements before, carried on.
            before = seen[count - 2]
            carried = moving(track.smoothed[before, 0], [times[index] - times[before]])[0]
            assert track.predicted[index, 0] == pytest.approx(carried, rel=1e-10, abs=1e-10 * scale)
    assert np.isnan(track.predicted[: seen[0] + 1]).all()
    # In a gap the fit is carried on; before the first measurement there is none.
    for index in missing:
        if index < seen[0]:
            assert np.isnan(track.smoothed[index]).all()
        else:
            before = seen[seen < index][-1]
            carried = moving(track.smoothed[before, 0], [times[index] - times[before]])[0]
            assert track.smoothed[index, 0] == pytest.approx(carried, rel=1e-10, abs=1e-10 * scale)


@pytest.mark.parametrize(
    ("order", "n"), [(order, n) for order in ORDERS for n in (2, 3, 4, 5, 10, 25, 50) if n >= order]
)
@pytest.mark.parametrize("interval", [0.5, 3.0])
def test_expanding_memory_has_the_growing_memory_gains(order, n, interval):
    """What an innovation does to the state at sample n is the published gain over T^i."""
    z = np.random.default_rng(n).normal(size=n + 1)
    track = run_filter(regular(z, interval), Gains((0.001, *GAINS[order].values[1:])), start="expanding")
    found = (track.smoothed[n, 0] - track.predicted[n, 0]) / track.innovation[n, 0] * interval ** np.arange(order)
    assert found == pytest.approx(growing_gains(order, n), rel=1e-12, abs=0)


@pytest.mark.parametrize("n", range(3, 30))
def test_growing_memory_gains_of_al_wagih(n):
    """M2 with its samples counted from one: alpha = 2(2n - 1)/(n(n + 1)), beta = 6/(n(n + 1)), n > 2."""
    track = run_filter(regular([0.0] * (n - 1) + [1.0]), Gains((0.001, 0.001)), start="expanding")
    assert track.smoothed[-1, 0] == pytest.approx(
        [2 * (2 * n - 1) / (n * (n + 1)), 6 / (n * (n + 1))], rel=1e-12, abs=0
    )


@pytest.mark.parametrize("order", ORDERS)
def test_expanding_memory_hands_over_when_its_gain_has_fallen(plain_track, order):
    """From the switch on it is the steady filter, resumed from the last least squares state."""
    gains = GAINS[order]
    z = np.random.default_rng(2).normal(size=80).cumsum()
    track = run_filter(regular(z), gains, start="expanding")
    switch = gap_free_switch(order, gains.values[0])
    assert order < switch < 40
    predicted, smoothed = plain_track(z[switch:], [1.0] * (80 - switch), gains.values, track.smoothed[switch - 1, 0])
    assert track.predicted[switch:, 0] == pytest.approx(predicted, rel=1e-11, abs=1e-12)
    assert track.smoothed[switch:, 0] == pytest.approx(smoothed, rel=1e-11, abs=1e-12)
    # One sample earlier it was still least squares.
    last = fitted(np.arange(switch) * 1.0, z[:switch], order - 1, order)
    assert track.smoothed[switch - 1, 0] == pytest.approx(last, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("n", [4, 9, 20])
@pytest.mark.parametrize("excess", [-1e-6, 1e-6])
def test_expanding_memory_hands_over_at_the_first_gain_not_above_alpha(order, n, excess):
    """With alpha just below the growing gain of sample n, that sample is still least squares; just above, no more."""
    alpha = growing_gains(order, n)[0] * (1 + excess)
    z = np.zeros(n + 1)
    z[n] = 1.0
    track = run_filter(regular(z), Gains((alpha, *GAINS[order].values[1:])), start="expanding")
    expected = growing_gains(order, n) if excess < 0 else [alpha, *GAINS[order].values[1:]]
    assert track.smoothed[n, 0] == pytest.approx(expected, rel=1e-10, abs=0)


@pytest.mark.parametrize("order", ORDERS)
@given(coefficients=st.lists(st.floats(-10, 10), min_size=4, max_size=4))
def test_expanding_memory_is_exact_on_the_motion_it_models(order, coefficients):
    times = np.arange(40) * 0.5
    states = moving(coefficients[:order], times)
    track = run_filter(regular(states[:, 0], 0.5), GAINS[order], start="expanding")
    assert track.smoothed[order - 1 :, 0] == pytest.approx(states[order - 1 :], rel=1e-8, abs=1e-7)


@pytest.mark.parametrize("order", ORDERS)
def test_expanding_memory_with_a_gain_of_one_starts_with_the_first_measurement(order):
    gains = Gains((1.0, *GAINS[order].values[1:]))
    z = regular(np.random.default_rng(3).normal(size=20))
    expanding, first = (run_filter(z, gains, start=start) for start in ("expanding", "first"))
    assert np.array_equal(expanding.smoothed, first.smoothed)


@pytest.mark.parametrize(("order", "count"), [(order, count) for order in ORDERS for count in range(1, order)])
def test_expanding_memory_with_few_measurements_carries_its_polynomial_on(order, count):
    z = np.full(8, np.nan)
    z[:count] = [3.0, 5.0, 9.0][:count]
    track = run_filter(regular(z), GAINS[order], start="expanding")
    carried = moving(fitted(np.arange(count) * 1.0, z[:count], count - 1, order), range(1, 9 - count))
    assert track.smoothed[count:, 0] == pytest.approx(carried, rel=1e-12, abs=1e-12)
    assert np.array_equal(track.predicted[count:], track.smoothed[count:])
    assert track.missing == 8 - count


# What a start needs ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("start", "needed"), [("first", 1), ("two-point", 2), ("three-point", 3), ("expanding", 1)])
def test_a_start_needs_its_measurements_on_every_axis(start, needed):
    assert STARTS[start].points == needed
    z = np.ones((6, 2))
    z[needed - 1 :, 1] = np.nan
    with pytest.raises(InputError) as caught:
        run_filter(regular(z), GAINS[3], start=start)
    assert caught.value.field == "positions"
    assert str(needed) in caught.value.rule
    assert caught.value.received == needed - 1


@pytest.mark.parametrize(("start", "needed"), [("first", 1), ("two-point", 2), ("three-point", 3), ("expanding", 1)])
def test_a_start_is_content_with_exactly_what_it_needs(start, needed):
    z = np.full((6, 1), np.nan)
    z[1 : 1 + needed] = 1.0
    track = run_filter(regular(z), GAINS[3], start=start)
    assert track.smoothed[-1, 0, 0] == pytest.approx(1, rel=1e-14, abs=0)
    assert np.isnan(track.smoothed[0]).all()


def test_three_points_make_no_sense_for_order_two():
    with pytest.raises(InputError, match="^start must not be 'three-point' for a filter of order 2"):
        run_filter(regular([1, 2, 3, 4]), GAINS[2], start="three-point")
