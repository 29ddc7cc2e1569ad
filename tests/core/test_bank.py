"""Banks: M5 of Al-Wagih & Abdulla in hindsight and by past innovations, and the causal mixture."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tracker_core import DESIGNS, Gains, Measurements, run_filter
from tracker_core.adaptive import METHODS

HINDSIGHT, CAUSAL, MIXTURE = (
    METHODS[name] for name in ("parallel-bank", "parallel-bank-causal", "critically-damped-bank")
)
INTERVALS = [0.25, 1.0, 5.0]


def series(seed, samples=50, axes=1):
    draw = np.random.default_rng(seed)
    return draw.normal(size=(samples, axes)).cumsum(axis=0) * 30 + draw.normal(size=(samples, axes)) * 10


def regular(positions, interval=1.0):
    return Measurements(np.arange(len(positions)) * interval, positions, interval)


def measured_at(positions, interval):
    """Measurements at a constant interval, or at others where there is none; and the interval before each."""
    steps = np.full(len(positions), interval or 1.0)
    if interval is None:
        steps = np.random.default_rng(0).uniform(0.3, 3, len(positions))
        steps[0] = steps[1]
    return Measurements(np.cumsum(steps) - steps[0], positions, interval), steps.tolist()


def alphas_of(members):
    """The middles of equal parts of (0, 1)."""
    return [(2 * k + 1) / (2 * members) for k in range(members)]


# M5: one member speaks ---------------------------------------------------------------------------------------------


def plain_bank(z, steps, members, memory):
    """From two points: predicted and smoothed positions and the speaker of every sample; no memory means hindsight."""
    states = [(z[1], (z[1] - z[0]) / steps[1])] * members
    past, speaker, out = [], 0, []
    for measured, t, now in zip(z[2:], steps[2:], np.cumsum(steps)[2:], strict=True):
        states = [(x + t * v, v) for x, v in states]
        ahead, seen = states, not math.isnan(measured)
        if seen:
            e = [measured - x for x, _ in states]
            past = [*(past if memory else []), (now, np.square(e))]
            powers = sum(math.exp((then - now) / memory) * e_then if memory else e_then for then, e_then in past)
            gains = [(alpha, alpha**2 / (2 - alpha)) for alpha in alphas_of(members)]
            states = [(x + a * r, v + b / t * r) for (x, v), (a, b), r in zip(states, gains, e, strict=True)]
            best = min(range(members), key=powers.__getitem__)
        predicted = ahead[best if seen and memory is None else speaker][0]
        speaker = best if seen else speaker
        out.append((predicted, states[speaker][0], speaker if seen else -1))
    return np.array(out).T


@pytest.mark.parametrize("hindsight", [True, False], ids=["hindsight", "causal"])
@pytest.mark.parametrize("interval", [*INTERVALS, None])
@pytest.mark.parametrize("members", [1, 4, 20])
def test_equals_a_loop_over_a_bank(hindsight, interval, members):
    """At constant intervals and at others, over gaps too: the window fades with the time that goes by."""
    z = series(members)
    z[[6, 7, 30, *range(35, 42)], 0] = np.nan
    seen, steps = measured_at(z, interval)
    memory = None if hindsight else 3.0
    selection = HINDSIGHT.run(seen, members=members) if hindsight else CAUSAL.run(seen, members=members, memory=memory)
    predicted, smoothed, speakers = plain_bank(z[:, 0].tolist(), steps, members, memory)
    scale = np.nanmax(np.abs(z))
    assert np.abs(selection.track.predicted[2:, 0, 0] - predicted).max() <= 1e-12 * scale
    assert np.abs(selection.track.smoothed[2:, 0, 0] - smoothed).max() <= 1e-12 * scale
    weights = selection.weights()[2:, 0]
    seen = speakers >= 0
    assert np.isnan(weights[~seen]).all()
    assert np.array_equal(weights[seen], np.eye(members)[speakers[seen].astype(int)])
    assert np.array_equal(selection.gains[2:, 0][seen], selection.members[speakers[seen].astype(int)])


@pytest.mark.parametrize("members", [1, 2, 20])
def test_members_are_spread_over_the_alphas(members):
    found = HINDSIGHT.run(regular(series(1)), members=members).members
    assert found[:, 0] == pytest.approx(alphas_of(members), rel=1e-15, abs=0)
    assert found[:, 1] == pytest.approx(found[:, 0] ** 2 / (2 - found[:, 0]), rel=1e-15, abs=0)


@pytest.mark.parametrize("method", [HINDSIGHT, CAUSAL], ids=lambda method: method.name)
def test_a_bank_of_one_is_its_member_to_the_last_bit(method):
    z = series(2, axes=2)
    z[[9, 10], 1] = np.nan
    track = method.run(regular(z, 0.5), members=1).track
    alone = run_filter(regular(z, 0.5), Gains((0.5, 0.25 / 1.5)))
    assert np.array_equal(track.predicted, alone.predicted, equal_nan=True)
    assert np.array_equal(track.smoothed, alone.smoothed, equal_nan=True)


@pytest.mark.parametrize("seed", range(3))
def test_in_hindsight_the_nearest_prediction_speaks(seed):
    measurements = regular(series(seed))
    selection = HINDSIGHT.run(measurements, members=7)
    misses = np.stack(
        [run_filter(measurements, Gains(tuple(gains))).innovation[2:, 0] for gains in selection.members.tolist()]
    )
    speakers = selection.weights()[2:, 0].argmax(axis=1)
    assert np.array_equal(np.abs(selection.track.innovation[2:, 0]), np.abs(misses).min(axis=0))
    assert np.array_equal(speakers, np.abs(misses).argmin(axis=0))
    assert len(set(speakers.tolist())) > 3


@pytest.mark.parametrize("seed", range(3))
def test_hindsight_never_misses_by_more_than_any_causal_choice(seed):
    measurements = regular(series(seed))
    one, other = (method.run(measurements, members=7).track.innovation[2:] for method in (HINDSIGHT, CAUSAL))
    assert (np.abs(one) <= np.abs(other)).all()


# The mixture -------------------------------------------------------------------------------------------------------


def morrison(order, xi):
    """The fading-memory gains, all poles at xi."""
    return {
        2: (1 - xi**2, (1 - xi) ** 2),
        3: (1 - xi**3, 1.5 * (1 - xi) ** 2 * (1 + xi), (1 - xi) ** 3),
        4: (
            1 - xi**4,
            (1 - xi) ** 2 * (11 + 14 * xi + 11 * xi**2) / 6,
            2 * (1 - xi) ** 3 * (1 + xi),
            (1 - xi) ** 4,
        ),
    }[order]


def plain_members(order, members, shortest, longest, interval):
    """Gains of the bank: this order and the one below, time constants in geometric progression."""
    taus = [shortest * (longest / shortest) ** (k / max(1, members - 1)) for k in range(members)]
    return [morrison(low, math.exp(-interval / tau)) for low in range(max(2, order - 1), order + 1) for tau in taus]


def mixed(plain_track, z, steps, gains, state, memory):
    """Predicted and smoothed states (n, axes, order), weights (n, K): every member for itself, then the mean."""
    order, (n, axes) = max(map(len, gains)), z.shape
    predicted, smoothed = np.zeros((2, len(gains), n, axes, order))
    for k, g in enumerate(gains):
        for axis in range(axes):
            predicted[k, :, axis, : len(g)], smoothed[k, :, axis, : len(g)] = plain_track(
                z[:, axis], steps, g, state[axis, : len(g)]
            )
    squares = np.nansum((z - predicted[..., 0]) ** 2, axis=2)
    seen = ~np.isnan(z).all(axis=1)
    weights, times = np.empty((n, len(gains))), np.cumsum(steps)
    for i in range(n):
        fading = np.where(seen[: i + 1], np.exp((times[: i + 1] - times[i]) / memory), 0.0)
        power, length = squares[:, : i + 1] @ fading, fading.sum()
        weights[i] = (power / power.min()) ** (-length / 2) if length else 1.0
        # Without a measurement nothing is known better than before.
        weights[i] = weights[i] / weights[i].sum() if seen[i] or i == 0 else weights[i - 1]
    before = np.vstack((np.full(len(gains), 1 / len(gains)), weights[:-1]))
    return (
        np.einsum("ik,kiar->iar", before, predicted),
        np.einsum("ik,kiar->iar", weights, smoothed),
        weights,
    )


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("interval", [*INTERVALS, None])
@pytest.mark.parametrize("members", [1, 5])
def test_equals_the_mean_of_its_members(plain_track, order, interval, members):
    z = series(order, axes=2)
    z[[4, 5], 0] = z[[5, 20], 1] = z[30:34] = np.nan
    seen, steps = measured_at(z, interval)
    nominal = float(np.median(steps))
    state = np.random.default_rng(order).normal(size=(2, order))
    told = {"members": members, "shortest": 1.3 * nominal, "longest": 30 * nominal, "memory": 6 * nominal}
    selection = MIXTURE.run(seen, order, start="known", initial_state=state, **told)
    gains = plain_members(order, members, told["shortest"], told["longest"], nominal)
    padded = np.array([[*g, *[0.0] * (order - len(g))] for g in gains])
    assert selection.members == pytest.approx(padded, rel=1e-11, abs=0)
    predicted, smoothed, weights = mixed(plain_track, z, steps, gains, state, told["memory"])
    assert np.abs(selection.weights() - weights[:, None, :]).max() <= 1e-11
    for found, expected in ((selection.track.predicted, predicted), (selection.track.smoothed, smoothed)):
        assert (np.abs(found - expected) <= 1e-11 * np.abs(expected).max(axis=(0, 1))).all()
    used = np.where(np.isnan(z)[:, :, None], np.nan, (weights @ padded)[:, None, :])
    assert selection.gains == pytest.approx(used, rel=1e-10, abs=0, nan_ok=True)


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("start", ["first", "two-point"])
def test_weights_are_shares(order, start):
    z = series(order, 200, axes=2)
    z[50:60] = np.nan
    selection = MIXTURE.run(regular(z), order, start=start)
    weights = selection.weights()[2:]
    assert weights.shape[2] == len(selection.members) == (12 if order == 2 else 24)
    assert (weights >= 0).all()
    assert weights.sum(axis=2) == pytest.approx(1, rel=1e-14, abs=0)
    assert np.array_equal(weights[:, 0], weights[:, 1])
    assert np.array_equal(weights[48:58], weights[[47] * 10])


def test_a_bank_of_one_mixes_nothing():
    z = series(2, axes=2)
    track = MIXTURE.run(regular(z, 0.5), 2, members=1, shortest=3).track
    gains = DESIGNS["fading-memory"].gains(2, xi=math.exp(-0.5 / 3))
    alone = run_filter(regular(z, 0.5), Gains(tuple(gains.tolist())))
    assert np.array_equal(track.predicted, alone.predicted, equal_nan=True)
    assert np.array_equal(track.smoothed, alone.smoothed, equal_nan=True)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_members_that_are_equally_right_count_alike(order):
    """Nothing moves and nothing is wrong: no innovation at all."""
    weights = MIXTURE.run(regular(np.zeros((50, 2))), order, start="first").weights()[1:]
    assert weights == pytest.approx(1 / weights.shape[2], rel=1e-15, abs=0)


@pytest.mark.parametrize("order", [3, 4])
def test_without_noise_the_fastest_member_that_fits_wins(order):
    """A motion of the filter's own order: from rest the fast ones have forgotten the start first."""
    times = np.arange(60.0)[:, None]
    selection = MIXTURE.run(regular(5 * times ** (order - 1)), order, start="first")
    assert selection.weights()[-1, 0].argmax() == 12
    assert selection.track.smoothed[-1, 0, 0] == pytest.approx(5 * 59.0 ** (order - 1), rel=1e-9)


# Bounded input, bounded output -------------------------------------------------------------------------------------

LENGTH = 200


@cache
def gains_of_default_bank(order):
    return plain_members(order, 12, 1.2, 24.0, 1.0)


@pytest.fixture(scope="session")
def bounds(plain_track):
    """For inputs in [-1, 1] and the start at the first of them: the largest |predicted| and |smoothed| positions."""

    @cache
    def of(order):
        worst = np.zeros(2)
        for g in gains_of_default_bank(order):
            ones = [1.0] * LENGTH
            impulse = plain_track([1.0, *[0.0] * (LENGTH - 1)], ones, g, [0.0] * len(g))
            start = plain_track([0.0] * LENGTH, ones, g, [1.0, *[0.0] * (len(g) - 1)])
            sums = [np.abs(one[:, 0]).sum() + np.abs(two[:, 0]).max() for one, two in zip(impulse, start, strict=True)]
            worst = np.maximum(worst, sums)
        return worst

    return of


def assert_bounded(z, order, limits):
    track = MIXTURE.run(regular(z), order, start="first").track
    for states, limit in zip((track.predicted, track.smoothed), limits, strict=True):
        assert np.nanmax(np.abs(states[:, :, 0])) <= limit * (1 + 1e-9)
        assert not np.isnan(states[1:]).any()


@pytest.mark.parametrize("order", [2, 3, 4])
@settings(max_examples=50)
@given(data=st.data())
def test_bounded_for_every_bounded_input(bounds, order, data):
    samples, axes = data.draw(st.integers(2, LENGTH)), data.draw(st.integers(1, 2))
    elements = data.draw(st.sampled_from([st.floats(-1, 1), st.sampled_from([-1.0, 1.0])]))
    assert_bounded(data.draw(arrays(float, (samples, axes), elements=elements)), order, bounds(order))


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("period", [1, 2, 3, 5, 8, 13, 21, 34, 55])
def test_bounded_for_square_waves(bounds, order, period):
    wave = np.where(np.arange(LENGTH) // period % 2 == 0, 1.0, -1.0)
    assert_bounded(np.stack((wave, np.roll(wave, period // 2)), axis=1), order, bounds(order))


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("member", [0, 3, 6, 9, 11])
def test_bounded_for_the_input_that_is_worst_for_a_member(plain_track, bounds, order, member):
    """The signs of its impulse response, backwards."""
    g = gains_of_default_bank(order)[-12:][member]
    _, response = plain_track([1.0, *[0.0] * (LENGTH - 1)], [1.0] * LENGTH, g, [0.0] * order)
    worst = np.where(response[::-1, 0] >= 0, 1.0, -1.0)[:, None]
    assert_bounded(worst, order, bounds(order))
    alone = run_filter(regular(worst), Gains(g), start="first").smoothed
    assert abs(alone[-1, 0, 0]) > 1.05
