"""The recursion: against a textbook loop, and the laws that every linear filter with constant gains obeys."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tracker_core import Gains, InputError, Measurements, run_filter
from tracker_core.filters import STOP_LIMIT

# Stable, well away from the border, so that rounding does not grow over a run.
GAINS = {
    2: (0.5, 0.2),
    3: (0.6, 0.25, 0.05),
    4: (0.7001, 0.3085, 0.1224, 0.0046),
}
ORDERS = list(GAINS)
INTERVALS = [0.125, 1.0, 3.0]
POSITION = st.floats(-1e4, 1e4, allow_subnormal=False)


def series(seed, samples=80, axes=1):
    """A wandering target with noise."""
    draw = np.random.default_rng(seed)
    return draw.normal(size=(samples, axes)).cumsum(axis=0) * 30 + draw.normal(size=(samples, axes)) * 10


def regular(positions, interval=1.0):
    positions = np.asarray(positions, dtype=float)
    return Measurements(np.arange(len(positions)) * interval, positions, interval)


def stable_gains(order):
    """Gains of a filter whose poles all lie at xi: stable for every xi below 1 (Morrison's fading memory)."""
    formulas = {
        2: lambda xi: (1 - xi**2, (1 - xi) ** 2),
        3: lambda xi: (1 - xi**3, 1.5 * (1 - xi) ** 2 * (1 + xi), (1 - xi) ** 3),
        4: lambda xi: (
            1 - xi**4,
            (1 - xi) ** 2 * (11 + 14 * xi + 11 * xi**2) / 6,
            2 * (1 - xi) ** 3 * (1 + xi),
            (1 - xi) ** 4,
        ),
    }
    return st.floats(0, 0.9).map(lambda xi: Gains(formulas[order](xi)))


def known(order, axes=1):
    """The start from rest at the origin: the filter is then linear in its measurements."""
    return {"start": "known", "initial_state": np.zeros((axes, order))}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("interval", INTERVALS)
@pytest.mark.parametrize("seed", range(4))
def test_equals_the_textbook_loop(plain_track, order, interval, seed):
    z = series(seed, axes=2)
    z[[7, 30, 31, 32]] = np.nan
    state = np.random.default_rng(seed).normal(size=(2, order))
    track = run_filter(regular(z, interval), Gains(GAINS[order]), start="known", initial_state=state)
    for axis in range(2):
        predicted, smoothed = plain_track(z[:, axis], [interval] * len(z), GAINS[order], state[axis])
        for found, expected in ((track.predicted, predicted), (track.smoothed, smoothed)):
            scale = np.abs(expected).max(axis=0)
            assert (np.abs(found[:, axis] - expected).max(axis=0) <= 1e-12 * scale).all()


@pytest.mark.parametrize("order", ORDERS)
@given(data=st.data())
def test_equals_the_textbook_loop_for_any_gains_and_intervals(plain_track, order, data):
    z = data.draw(arrays(float, 25, elements=POSITION | st.just(math.nan)))
    steps = data.draw(arrays(float, 25, elements=st.floats(0.5, 2)))
    gains = data.draw(stable_gains(order))
    times = np.cumsum(steps)
    steps = np.concatenate((np.diff(times)[:1], np.diff(times)))
    # A long gap is bridged by a polynomial, which may go beyond the usual limit.
    track = run_filter(Measurements(times, z[:, None], None), gains, limit=1e300, **known(order))
    predicted, smoothed = plain_track(z, steps, gains.values, [0.0] * order)
    scale = 1e-12 * max(1.0, np.abs(smoothed).max())
    assert np.abs(track.predicted[:, 0] - predicted).max() <= scale
    assert np.abs(track.smoothed[:, 0] - smoothed).max() <= scale


@pytest.mark.parametrize("order", ORDERS)
@given(data=st.data())
def test_is_linear_in_the_measurements(order, data):
    column = arrays(float, (25, 1), elements=POSITION)
    z, w = data.draw(column), data.draw(column)
    a, b = data.draw(st.floats(-3, 3)), data.draw(st.floats(-3, 3))
    gains = data.draw(stable_gains(order))
    of = {
        name: run_filter(regular(positions), gains, **known(order)).smoothed
        for name, positions in (("z", z), ("w", w), ("both", a * z + b * w))
    }
    size = 1 + np.abs(a * of["z"]).max() + np.abs(b * of["w"]).max()
    assert np.abs(of["both"] - (a * of["z"] + b * of["w"])).max() <= 1e-12 * size


@pytest.mark.parametrize("order", ORDERS)
@given(delay=st.integers(1, 10), seed=st.integers(0, 99))
def test_is_shift_invariant(order, delay, seed):
    """A delayed input gives the same output, delayed, to the last bit."""
    z = series(seed, 40)
    late = np.concatenate((np.zeros((delay, 1)), z))
    track, delayed = (run_filter(regular(p), Gains(GAINS[order]), **known(order)) for p in (z, late))
    assert not delayed.smoothed[:delay].any()
    assert np.array_equal(delayed.smoothed[delay:], track.smoothed)
    assert np.array_equal(delayed.innovation[delay:], track.innovation)


@pytest.mark.parametrize("order", ORDERS)
@given(seed=st.integers(0, 99), data=st.data())
def test_rides_along_with_a_motion_that_it_models(order, seed, data):
    """Adding a polynomial of degree order - 1 to measurements and state adds the same to the track."""
    motion = np.array(data.draw(st.lists(st.floats(-5, 5), min_size=order, max_size=order)))
    times = np.arange(30) * 0.5
    states = np.zeros((30, order))
    for i in range(order):
        states[:, i] = sum(motion[j] * times ** (j - i) / math.factorial(j - i) for j in range(i, order))
    before = [sum(motion[j] * (-0.5) ** (j - i) / math.factorial(j - i) for j in range(i, order)) for i in range(order)]
    z = series(seed, 30)
    still = run_filter(regular(z, 0.5), Gains(GAINS[order]), **known(order))
    moving = run_filter(
        regular(z + states[:, :1], 0.5), Gains(GAINS[order]), start="known", initial_state=np.array([before])
    )
    assert moving.smoothed[:, 0] == pytest.approx(still.smoothed[:, 0] + states, rel=1e-11, abs=1e-10)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("scale", [0.25, 8.0])
def test_gains_do_not_depend_on_the_unit_of_time(order, scale):
    """With a power of two as the new unit, bit for bit: derivative i is scaled by 1/unit^i."""
    z = series(5)
    one, other = (run_filter(regular(z, t), Gains(GAINS[order]), **known(order)) for t in (1.0, scale))
    assert np.array_equal(one.smoothed, other.smoothed * scale ** np.arange(order))


@pytest.mark.parametrize("order", ORDERS)
@given(cut=st.integers(1, 59), seed=st.integers(0, 99))
def test_batch_equals_streaming(order, cut, seed):
    """Stopping after any sample and resuming from the smoothed state changes no bit."""
    z = series(seed, 60, axes=2)
    z[[20, 21, 40], 1] = np.nan
    gains = Gains(GAINS[order])
    whole = run_filter(regular(z, 3.0), gains, **known(order, 2))
    head = run_filter(regular(z[:cut], 3.0), gains, **known(order, 2))
    tail = run_filter(regular(z[cut:], 3.0), gains, start="known", initial_state=head.smoothed[-1])
    for name in ("predicted", "smoothed", "innovation"):
        joined = np.concatenate((getattr(head, name), getattr(tail, name)))
        assert np.array_equal(joined, getattr(whole, name), equal_nan=True)
    assert head.missing + tail.missing == whole.missing


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("start", ["first", "two-point", "expanding"])
def test_axes_are_independent(order, start):
    z = series(8, axes=3)
    z[4:6, 1] = np.nan
    together = run_filter(regular(z), Gains(GAINS[order]), start=start)
    for axis in range(3):
        alone = run_filter(regular(z[:, [axis]]), Gains(GAINS[order]), start=start)
        assert np.array_equal(together.smoothed[:, [axis]], alone.smoothed, equal_nan=True)
        assert np.array_equal(together.predicted[:, [axis]], alone.predicted, equal_nan=True)


@pytest.mark.parametrize("order", ORDERS)
def test_every_axis_has_the_same_filter(order):
    z = np.repeat(series(9), 3, axis=1)
    track = run_filter(regular(z), Gains(GAINS[order]), start="two-point")
    assert np.array_equal(track.smoothed[:, 0], track.smoothed[:, 2], equal_nan=True)


@pytest.mark.parametrize("order", ORDERS)
def test_a_gap_is_bridged_by_prediction(order):
    z = series(2, axes=2)
    z[10:14, 0] = np.nan
    track = run_filter(regular(z), Gains(GAINS[order]), **known(order, 2))
    assert np.array_equal(track.smoothed[10:14, 0], track.predicted[10:14, 0])
    assert np.isnan(track.innovation[10:14, 0]).all()
    assert not np.isnan(track.smoothed).any()
    assert track.missing == 4
    # Without a correction for four samples, the state has moved as the model moves it.
    times = np.arange(1, 5)[:, None]
    powers = times ** np.arange(order) / [math.factorial(i) for i in range(order)]
    assert track.predicted[10:14, 0, 0] == pytest.approx(powers @ track.smoothed[9, 0], rel=1e-13, abs=0)


@pytest.mark.parametrize("order", ORDERS)
def test_an_axis_without_measurements_coasts(order):
    state = np.ones((1, order))
    track = run_filter(regular(np.full((5, 1), np.nan)), Gains(GAINS[order]), start="known", initial_state=state)
    assert track.missing == 5
    assert np.array_equal(track.smoothed, track.predicted)
    assert track.smoothed[-1, 0, 0] == pytest.approx(
        sum(5**i / math.factorial(i) for i in range(order)), rel=1e-14, abs=0
    )


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("start", ["first", "two-point", "expanding", "known"])
@pytest.mark.parametrize("interval", [0.25, 1.0, 2.0])
def test_equidistant_times_equal_a_constant_interval(order, start, interval):
    """Bit for bit where the times themselves are exact in binary."""
    z = series(4, axes=2)
    z[9, 0] = np.nan
    given_state = known(order, 2)["initial_state"] if start == "known" else None
    constant = regular(z, interval)
    varying = Measurements(constant.times, z, None)
    one, other = (
        run_filter(m, Gains(GAINS[order]), start=start, initial_state=given_state) for m in (constant, varying)
    )
    assert np.array_equal(one.predicted, other.predicted, equal_nan=True)
    assert np.array_equal(one.smoothed, other.smoothed, equal_nan=True)


@pytest.mark.parametrize("order", ORDERS)
def test_the_first_interval_counts_as_the_one_before_the_first_sample(order):
    times = np.array([10.0, 10.5, 13.0])
    track = run_filter(
        Measurements(times, np.zeros((3, 1)), None), Gains(GAINS[order]), start="known",
        initial_state=np.array([[0.0, 1.0, *[0.0] * (order - 2)]]),
    )  # fmt: skip
    assert track.predicted[0, 0, 0] == 0.5


@pytest.mark.parametrize("order", ORDERS)
def test_innovation_is_measured_minus_predicted(order):
    z = series(6, axes=2)
    track = run_filter(regular(z), Gains(GAINS[order]), start="two-point")
    assert np.array_equal(track.innovation, z - track.predicted[:, :, 0], equal_nan=True)
    assert np.isnan(track.innovation[:2]).all()


@pytest.mark.parametrize("order", ORDERS)
def test_shapes_are_time_first(order):
    track = run_filter(regular(series(1, 12, axes=3)), Gains(GAINS[order]))
    assert track.predicted.shape == track.smoothed.shape == (12, 3, order)
    assert track.innovation.shape == (12, 3)
    assert (track.missing, track.stopped_at, track.limit) == (0, None, STOP_LIMIT)


def test_the_measurements_are_not_touched():
    z = series(1)
    z.setflags(write=False)
    kept = z.copy()
    run_filter(regular(z), Gains(GAINS[2]), start="expanding")
    assert np.array_equal(z, kept)


# The run stops where a smoothed position passes the limit ----------------------------------------------------------

UNSTABLE = [(1.9, 1.5), (0.5, 3.5), (0.5, -0.5), (0.5, 0.3, 1.0), (0.5, 0.4, -0.2), (0.7, 0.3, 0.1, 0.5)]


@pytest.mark.parametrize("g", UNSTABLE, ids=str)
@pytest.mark.parametrize("limit", [1e3, 1e9, STOP_LIMIT])
def test_an_unstable_filter_stops_where_a_plain_loop_does(plain_track, g, limit):
    z = series(11, 3000, axes=1)
    track = run_filter(regular(z), Gains(g), limit=limit, **known(len(g)))
    _, smoothed = plain_track(z[:, 0], [1.0] * len(z), g, [0.0] * len(g), limit)
    stop = track.stopped_at
    assert stop == len(smoothed) - 1 < len(z) - 1
    assert abs(track.smoothed[stop, 0, 0]) > limit
    assert (np.abs(track.smoothed[:stop, 0, 0]) <= limit).all()
    assert np.isnan(track.smoothed[stop + 1 :]).all()
    assert np.isnan(track.predicted[stop + 1 :]).all()
    assert np.isnan(track.innovation[stop + 1 :]).all()
    assert track.limit == limit


def test_all_axes_stop_with_the_first_of_them():
    z = np.column_stack((np.zeros(200), np.ones(200)))
    track = run_filter(regular(z), Gains((0.5, 3.6)), **known(2, 2))
    alone = run_filter(regular(z[:, 1:]), Gains((0.5, 3.6)), **known(2))
    assert track.stopped_at == alone.stopped_at is not None
    assert not track.smoothed[: track.stopped_at + 1, 0].any()
    assert np.isnan(track.smoothed[track.stopped_at + 1 :]).all()


def test_the_limit_itself_is_still_admitted():
    z = np.full((3, 1), 100.0)
    assert run_filter(regular(z), Gains((1.0, 0.0)), limit=100.0, **known(2)).stopped_at is None
    assert run_filter(regular(z), Gains((1.0, 0.0)), limit=math.nextafter(100, 0), **known(2)).stopped_at == 0


@pytest.mark.parametrize("start", ["first", "two-point", "expanding"])
def test_the_start_may_pass_the_limit_too(start):
    track = run_filter(regular(np.full((40, 1), 200.0)), Gains(GAINS[2]), start=start, limit=100.0)
    assert track.stopped_at == 0


def test_samples_missing_after_a_stop_are_not_counted():
    z = np.ones((400, 1))
    z[-5:] = np.nan
    track = run_filter(regular(z), Gains((0.5, 3.6)), **known(2))
    assert track.stopped_at is not None
    assert track.missing == 0


@pytest.mark.parametrize("origin", [0.0, 1.7e9])
def test_times_that_are_rounded_lie_on_the_interval(origin):
    """Stamps in seconds since 1970 have some 2e-7 s of rounding."""
    z = np.arange(50.0)[:, None]
    times = origin + np.arange(50) * 1e-5
    found = run_filter(Measurements(times, z, 1e-5), Gains((0.5, 0.2)))
    assert np.array_equal(found.smoothed, run_filter(regular(z, 1e-5), Gains((0.5, 0.2))).smoothed, equal_nan=True)


# Bad input ---------------------------------------------------------------------------------------------------------

GOOD = np.zeros((5, 1))
TIMES = np.arange(5.0)


@pytest.mark.parametrize(
    ("measurements", "options", "field"),
    [
        pytest.param(Measurements(TIMES, GOOD, 0.0), {}, "interval", id="interval-zero"),
        pytest.param(Measurements(TIMES, GOOD, -1.0), {}, "interval", id="interval-negative"),
        pytest.param(Measurements(TIMES, GOOD, math.nan), {}, "interval", id="interval-nan"),
        pytest.param(Measurements(TIMES, GOOD, math.inf), {}, "interval", id="interval-infinite"),
        pytest.param(Measurements(TIMES, GOOD + np.inf, 1.0), {}, "positions", id="positions-infinite"),
        pytest.param(Measurements(TIMES, np.zeros(5), 1.0), {}, "positions", id="positions-without-axes"),
        pytest.param(Measurements(TIMES, np.zeros((5, 0)), 1.0), {}, "positions", id="no-axis"),
        pytest.param(Measurements(TIMES[:4], GOOD, 1.0), {}, "times", id="times-too-few"),
        pytest.param(Measurements(TIMES[::-1], GOOD, None), {}, "times", id="times-backwards"),
        pytest.param(Measurements(TIMES * 0, GOOD, None), {}, "times", id="times-equal"),
        pytest.param(Measurements(TIMES[::-1], GOOD, 1.0), {}, "times", id="times-backwards-at-an-interval"),
        pytest.param(Measurements(TIMES, GOOD, 0.5), {}, "times", id="times-at-another-interval"),
        pytest.param(Measurements(np.array([0, 1, 2, 7, 8.0]), GOOD, 1.0), {}, "times", id="times-with-a-gap"),
        pytest.param(Measurements(TIMES * np.nan, GOOD, None), {}, "times", id="times-nan"),
        pytest.param(Measurements(np.array([0, 1, 2, 3, np.inf]), GOOD, None), {}, "times", id="times-infinite"),
        pytest.param(Measurements(TIMES[:1], GOOD[:1], None), {"start": "first"}, "times", id="one-time-no-interval"),
        pytest.param(Measurements(TIMES, GOOD * np.nan, 1.0), {"start": "first"}, "positions", id="all-missing"),
        pytest.param(Measurements(TIMES, GOOD, 1.0), {"start": "third"}, "start", id="unknown-start"),
        pytest.param(Measurements(TIMES, GOOD, 1.0), {"start": "three-point"}, "start", id="three-point-order-2"),
        pytest.param(Measurements(TIMES, GOOD, 1.0), {"start": "known"}, "initial_state", id="known-without-state"),
        pytest.param(
            Measurements(TIMES, GOOD, 1.0), {"start": "first", "initial_state": np.zeros((1, 2))}, "initial_state",
            id="state-without-known",
        ),
        pytest.param(
            Measurements(TIMES, GOOD, 1.0), {"start": "known", "initial_state": np.zeros((1, 3))}, "initial_state",
            id="state-of-another-order",
        ),
        pytest.param(
            Measurements(TIMES, GOOD, 1.0), {"start": "known", "initial_state": np.array([[0, math.nan]])},
            "initial_state", id="state-not-finite",
        ),
        pytest.param(Measurements(TIMES, GOOD, 1.0), {"limit": 0.0}, "limit", id="limit-zero"),
        pytest.param(Measurements(TIMES, GOOD, 1.0), {"limit": math.inf}, "limit", id="limit-infinite"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(measurements, options, field):
    with pytest.raises(InputError) as caught:
        run_filter(measurements, Gains((0.5, 0.2)), **options)
    assert caught.value.field == field
    assert caught.value.rule.startswith("must")
    assert field in str(caught.value)
