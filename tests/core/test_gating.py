"""The outlier gate: against a plain loop, the filter without the refused samples, and simulated models."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import (
    DESIGNS,
    STARTS,
    Gains,
    Gate,
    InputError,
    Measurements,
    model_covariance,
    optimal_gains,
    run_filter,
)
from tracker_core.consistency import default_gate, reject_probability
from tracker_core.gating import DOUBT, PATIENCE

ORDERS = [2, 3, 4]
GAINS = {2: Gains((0.3, 0.06)), 3: Gains((0.4, 0.1, 0.012)), 4: Gains((0.5, 0.16, 0.03, 0.003))}
UNSTABLE = {2: Gains((0.5, 3.8)), 3: Gains((0.5, 0.3, 1.0)), 4: Gains((0.7, 0.3, 0.1, 0.5))}
CASES = [(order, start) for order in ORDERS for start in STARTS if order >= STARTS[start].least_order]
NOISE = {2: [1 / 2, 1], 3: [1 / 2, 1, 1], 4: [1 / 6, 1 / 2, 1, 1]}


def recording(seed, samples=120, axes=2, *, outliers=0.1, gaps=0.1, irregular=False):
    """Noise of standard deviation 1 with holes and outliers in it; the first samples are clean."""
    draw = np.random.default_rng(seed)
    z = draw.normal(size=(samples, axes))
    z[5:][draw.random((samples - 5, axes)) < gaps] = np.nan
    wild = np.flatnonzero(draw.random(samples - 5) < outliers) + 5
    z[wild, draw.integers(axes, size=len(wild))] += draw.choice([-1, 1], len(wild)) * draw.uniform(20, 90, len(wild))
    if irregular:
        return Measurements(np.cumsum(draw.uniform(0.8, 1.2, samples)), z, None)
    return Measurements(np.arange(samples) * 0.5, z, 0.5)


def options(order, start, axes=2):
    state = np.random.default_rng(order).normal(size=(axes, order)) / 10 ** np.arange(order)
    return {"start": start, "initial_state": state if start == "known" else None}


def gate(width=4.0, tracking_index=0.05, interval=0.5, sensor_std=(1.0,)):
    return Gate(width, sensor_std, tracking_index, interval)


def same(one, other):
    return np.array_equal(one, other, equal_nan=True)


def plain_gate(measurements, gains, wanted, state, covariance):
    """The formulas as they are written, for a state that is known one interval before the first sample."""
    g, order = gains.vector, gains.order
    z, std = measurements.positions, np.array(wanted.stds(measurements.positions.shape[1]))
    step, unit = measurements.interval, np.eye(order)
    steps = np.r_[np.diff(measurements.times)[:1], np.diff(measurements.times)] if step is None else [step] * len(z)
    x, p = np.array(state), [np.array(covariance) for _ in std]
    rejected, spread, smoothed, refused = [], [], [], 0
    for measured, t in zip(z, steps, strict=True):
        f = [[t ** (j - i) / math.factorial(j - i) if j >= i else 0 for j in range(order)] for i in range(order)]
        f, k = np.array(f), g / t ** np.arange(order)
        units = [t**2, t] if order == 2 else t ** np.arange(order - 1.0, -1, -1)
        power = wanted.interval / t if order == 2 else t / wanted.interval
        drive = np.array(NOISE[order]) * units * wanted.tracking_index / wanted.interval ** (3 if order == 4 else 2)
        x, p = x @ f.T, [f @ one @ f.T + power * np.outer(drive, drive) for one in p]
        spread.append(std * np.sqrt([one[0, 0] + 1 for one in p]))
        e = measured - x[:, 0]
        seen = ~np.isnan(e)
        rejected.append(np.sqrt(((e / spread[-1])[seen] ** 2).sum()) > wanted.width)
        refused = refused + 1 if rejected[-1] else 0 if seen.any() else refused
        for axis in range(len(std)):
            if rejected[-1]:
                p[axis] *= DOUBT if refused >= PATIENCE else 1
            elif seen[axis]:
                keep = unit - np.outer(k, unit[0])
                x[axis] += k * e[axis]
                p[axis] = keep @ p[axis] @ keep.T + np.outer(k, k)
        smoothed.append(x.copy())
    return np.array(rejected), np.array(spread), np.array(smoothed)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("irregular", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_equals_the_plain_loop(order, irregular, seed):
    measurements = recording(seed, irregular=irregular)
    given_state = options(order, "known")["initial_state"]
    wanted = gate(3.0, 0.01, 0.7, (1.0, 1.5))
    track = run_filter(measurements, GAINS[order], start="known", initial_state=given_state, gate=wanted)
    rejected, spread, smoothed = plain_gate(measurements, GAINS[order], wanted, given_state, np.zeros((order, order)))
    assert rejected.any()
    assert same(track.rejected, rejected)
    assert track.spread == pytest.approx(spread, rel=1e-12)
    assert np.abs(track.smoothed - smoothed).max() <= 1e-12 * np.abs(smoothed).max()


@pytest.mark.parametrize(("order", "start"), CASES)
@pytest.mark.parametrize("irregular", [False, True])
@given(seed=st.integers(0, 10**6), width=st.floats(1, 30), index=st.floats(0, 5))
def test_is_the_filter_that_never_saw_what_was_refused(order, start, irregular, seed, width, index):
    """To the last bit; what is refused keeps its innovation, and is not counted as missing."""
    seen = recording(seed, irregular=irregular)
    given_options = options(order, start)
    gated = run_filter(seen, GAINS[order], gate=gate(width, index), **given_options)
    left = np.where(gated.rejected[:, None], np.nan, seen.positions)
    bare = run_filter(Measurements(seen.times, left, seen.interval), GAINS[order], **given_options)
    assert same(gated.predicted, bare.predicted)
    assert same(gated.smoothed, bare.smoothed)
    assert same(gated.believed, bare.innovation)
    assert same(gated.innovation, seen.positions - gated.predicted[:, :, 0])
    assert gated.missing == np.isnan(seen.positions)[~np.isnan(gated.smoothed[:, :, 0])].sum()


@pytest.mark.parametrize(("order", "start"), CASES)
@pytest.mark.parametrize("irregular", [False, True])
def test_a_gate_that_refuses_nothing_changes_no_bit(order, start, irregular):
    seen = recording(3, outliers=0, irregular=irregular)
    gated = run_filter(seen, GAINS[order], gate=gate(100.0), **options(order, start))
    bare = run_filter(seen, GAINS[order], **options(order, start))
    assert not gated.rejected.any()
    for name in ("predicted", "smoothed", "innovation"):
        assert same(getattr(gated, name), getattr(bare, name))
    assert (gated.missing, gated.stopped_at) == (bare.missing, bare.stopped_at)
    assert bare.rejected is bare.spread is None
    assert bare.believed is bare.innovation


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("start", ["two-point", "expanding"])
@pytest.mark.parametrize("tracking_index", [0.0, 0.1, 3.0])
def test_the_spread_settles_at_the_model_covariance(order, start, tracking_index):
    track = run_filter(
        recording(1, 600, gaps=0, outliers=0), GAINS[order], start=start, gate=gate(100.0, tracking_index)
    )
    steady = model_covariance(GAINS[order], tracking_index).innovation
    assert track.spread[-1] ** 2 == pytest.approx(steady, rel=1e-12)


def test_the_covariance_of_the_start():
    """Two points: position and velocity as they are measured."""
    z = np.random.default_rng(0).normal(size=(5, 1))
    t, index = 0.5, 0.2
    track = run_filter(Measurements(np.arange(5) * t, z, t), GAINS[2], gate=gate(4.0, index, t, (2.0,)))
    f, drive = np.array([[1, t], [0, 1]]), index / t**2 * np.array([t**2 / 2, t])
    p = f @ np.array([[1, 1 / t], [1 / t, 2 / t**2]]) @ f.T + np.outer(drive, drive)
    assert track.spread[2, 0] == pytest.approx(2 * math.sqrt(p[0, 0] + 1), rel=1e-14)
    assert np.isnan(track.spread[:2]).all()


def polynomial(times, z, order, now):
    """Least squares over all measurements: the state at a time and its covariance, for a sensor of variance 1."""
    design = np.array([[(t - now) ** j / math.factorial(j) for j in range(order)] for t in times])
    covariance = np.linalg.inv(design.T @ design)
    return covariance @ design.T @ z, covariance


class Beside:
    """An axis whose start took derivatives for zero, as the formulas are written; least squares each time anew."""

    def __init__(self, gains, std, points):
        self.g, self.order, self.std, self.points = gains.vector, gains.order, std, points
        self.times, self.z, self.x, self.p, self.ended = [], [], None, None, False

    def predict(self, now, t, variance):
        """The state, and the standard deviation of its innovation where that is known."""
        order = range(self.order)
        f = np.array([[t ** (c - r) / math.factorial(c - r) if c >= r else 0 for c in order] for r in order])
        units = [t**2, t] if self.order == 2 else t ** np.arange(self.order - 1.0, -1, -1)
        self.x = None if self.x is None else f @ self.x
        if self.p is None:
            return np.nan
        drive = np.array(NOISE[self.order]) * units
        self.p = f @ self.p @ f.T + variance * np.outer(drive, drive)
        self.fit, self.fit_p = polynomial(self.times, self.z, self.order, now)
        off = 0 if self.ended else self.fit[0] - self.x[0]
        return math.sqrt(self.std**2 * (self.p[0, 0] + 1) + off**2)

    def correct(self, now, t, z):
        k = own = self.g / t ** np.arange(self.order)
        if self.p is not None:
            if not self.ended:
                own = self.fit_p[:, 0] / (self.fit_p[0, 0] + 1)
            if own[0] <= self.g[0] and not self.ended:
                miss = (self.fit - self.x) / self.std
                self.p, own, self.ended = self.p + np.outer(miss, miss), k, True
            keep = np.eye(self.order) - np.outer(own, np.eye(self.order)[0])
            self.p = keep @ self.p @ keep.T + np.outer(own, own)
        self.times.append(now)
        self.z.append(z)
        if self.x is not None:
            self.x = self.x + k * (z - self.x[0])
        elif len(self.z) == self.points:
            self.x = np.r_[polynomial(self.times, self.z, self.points, now)[0], np.zeros(self.order - self.points)]
        if len(self.z) == self.order:
            self.p = polynomial(self.times, self.z, self.order, now)[1]


def loop_beside(measurements, gains, wanted, points):
    """What is rejected, the spread, and the smoothed states."""
    z, times, order = measurements.positions, measurements.times, gains.order
    axes = [Beside(gains, std, points) for std in wanted.stds(z.shape[1])]
    scale = (wanted.tracking_index / wanted.interval ** (3 if order == 4 else 2)) ** 2
    rejected, spread, smoothed, refused = [], np.empty(z.shape), np.full((*z.shape, order), np.nan), 0
    for i, now in enumerate(times):
        t = times[max(i, 1)] - times[max(i, 1) - 1]
        power = wanted.interval / t if order == 2 else t / wanted.interval
        spread[i] = [axis.predict(now, t, scale * power) for axis in axes]
        e = z[i] - [np.nan if axis.x is None else axis.x[0] for axis in axes]
        rejected.append(not np.isnan(spread[i]).any() and np.nansum((e / spread[i]) ** 2) > wanted.width**2)
        refused = refused + 1 if rejected[-1] else 0 if not np.isnan(e).all() else refused
        for number, axis in enumerate(axes):
            if rejected[-1]:
                axis.p = axis.p * (DOUBT if refused >= PATIENCE else 1)
            elif not np.isnan(z[i, number]):
                axis.correct(now, t, z[i, number])
            if axis.x is not None:
                smoothed[i, number] = axis.x
    return np.array(rejected), spread, smoothed


BESIDE = [("first", 1), ("two-point", 2), ("three-point", 3)]


@pytest.mark.parametrize(("order", "start", "points"), [(o, *s) for o in ORDERS for s in BESIDE if s[1] < o])
@pytest.mark.parametrize("irregular", [False, True])
def test_a_start_that_leaves_something_at_zero_is_judged_by_least_squares_beside_it(order, start, points, irregular):
    for seed in range(3):
        seen = recording(seed, 60, irregular=irregular)
        seen.positions[:, 1] += 7 * seen.times - 0.4 * seen.times**2
        wanted = gate(3.0, 0.01, 0.7, (1.0, 1.5))
        track = run_filter(seen, GAINS[order], start=start, gate=wanted)
        rejected, spread, smoothed = loop_beside(seen, GAINS[order], wanted, points)
        assert rejected.any()
        assert same(track.rejected, rejected)
        assert track.spread == pytest.approx(spread, rel=1e-8, nan_ok=True)
        begun = ~np.isnan(smoothed)
        np.testing.assert_allclose(track.smoothed[begun], smoothed[begun], rtol=1e-8, atol=1e-8)


def test_a_gate_may_refuse_nothing_and_tell_its_spread():
    seen = recording(3)
    track = run_filter(seen, GAINS[2], start="first", gate=gate(math.inf))
    assert not track.rejected.any()
    assert np.isfinite(track.spread[10:]).all()
    assert same(track.smoothed, run_filter(seen, GAINS[2], start="first").smoothed)


def test_a_sensor_without_any_noise_to_speak_of_leaves_numbers():
    """Nothing overflows where a start is wrong by more standard deviations than can be squared."""
    z = 1e3 * np.arange(40.0)[:, None] ** 2
    track = run_filter(
        Measurements(np.arange(40.0), z, 1.0), GAINS[3], start="first", gate=gate(4.0, 0.1, 1.0, (1e-200,))
    )
    assert np.isfinite(track.spread[3:]).all()
    assert np.isfinite(track.smoothed[3:]).all()


@pytest.mark.parametrize("order", ORDERS)
def test_least_squares_expects_what_it_makes(order):
    """On a target that keeps its highest derivative the variance is that of a polynomial extrapolated by one sample."""
    slow = Gains.normalised(optimal_gains(order, 1e-4))
    track = run_filter(recording(2, 20, gaps=0, outliers=0), slow, start="expanding", gate=gate(100.0, 0.0))
    times = np.arange(20.0)
    for n in range(order, 20):
        design = np.vander(times[:n] - times[n], order)
        last = np.linalg.inv(design.T @ design)[-1, -1]
        assert track.spread[n, 0] ** 2 == pytest.approx(1 + last, rel=1e-9)


# How often, and for how long ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(("width", "axes"), [(1.5, 1), (2.5, 2), (3.0, 3)])
def test_right_measurements_are_refused_as_often_as_foretold(order, width, axes):
    """On the model itself, just after the start, before refusals could have changed anything."""
    index, runs, draw = 0.3, 4000, np.random.default_rng(order)
    drive = index * np.array(NOISE[order])
    state, z = np.zeros((runs, axes, order)), []
    f = [[1 / math.factorial(j - i) if j >= i else 0 for j in range(order)] for i in range(order)]
    for _ in range(3):
        state = state @ np.array(f).T + draw.normal(size=(runs, axes, 1)) * drive
        z.append(state[:, :, 0] + draw.normal(size=(runs, axes)))
    first = [
        run_filter(
            Measurements(np.arange(3.0), run, 1.0), GAINS[order], start="known", initial_state=np.zeros((axes, order)),
            gate=gate(width, index, 1.0),
        ).rejected[0]
        for run in np.array(z).transpose(1, 0, 2)
    ]  # fmt: skip
    expected = reject_probability(width, axes)
    assert abs(np.mean(first) - expected) < 4 * math.sqrt(expected * (1 - expected) / runs)


@pytest.mark.parametrize("order", ORDERS)
def test_a_steady_filter_refuses_as_often_as_foretold(order):
    draw, n, width = np.random.default_rng(7), 60_000, 3.5
    gains = Gains.normalised(optimal_gains(order, 0.1))
    drive = 0.1 * np.array(NOISE[order])
    f = np.array([[1 / math.factorial(j - i) if j >= i else 0 for j in range(order)] for i in range(order)])
    # The model as seen by its own filter: innovations are white, whatever the target does.
    x, xs = np.zeros(order), []
    for w in draw.normal(size=n):
        x = f @ x + drive * w
        # What the filter knows of the target does not matter; taken off, the numbers stay small.
        xs.append(x[0])
    seen = Measurements(np.arange(float(n)), (np.array(xs) + draw.normal(size=n))[:, None], 1.0)
    track = run_filter(seen, gains, gate=gate(width, 0.1, 1.0), limit=1e300)
    expected = reject_probability(width, 1)
    assert abs(track.rejected.mean() - expected) < 5 * math.sqrt(expected / n)


@pytest.mark.parametrize(("order", "start"), CASES)
@pytest.mark.parametrize("size", [1e3, 1e6])
@pytest.mark.parametrize("tracking_index", [0.0, 0.1])
def test_the_gate_opens_again_after_a_jump(order, start, size, tracking_index):
    """A target that jumps, or begins to move, is followed after a few samples, even where the model denies it."""
    for motion in (np.ones(300), np.arange(300.0)):
        z = np.random.default_rng(4).normal(size=(400, 1))
        z[100:, 0] += size * motion
        track = run_filter(
            Measurements(np.arange(400.0), z, 1.0), GAINS[order], gate=gate(4.0, tracking_index, 1.0),
            **options(order, start, 1),
        )  # fmt: skip
        assert track.rejected[101:103].all()
        assert track.rejected.sum() < 60
        assert not track.rejected[-100:].any()
        assert np.abs(track.innovation[-100:]).max() < 6


@pytest.mark.parametrize(("order", "start"), CASES)
@pytest.mark.parametrize("size", [30, 1e3, 1e6])
def test_an_outlier_in_the_start_does_not_lock_the_track_out(order, start, size):
    for sample in range(order):
        z = np.random.default_rng(5).normal(size=(400, 1))
        z[sample] += size
        track = run_filter(
            Measurements(np.arange(400.0), z, 1.0), GAINS[order], gate=gate(4.0, 0.1, 1.0), **options(order, start, 1)
        )
        assert track.rejected.sum() < 80
        assert not track.rejected[-150:].any()
        assert np.abs(track.innovation[-100:]).max() < 6


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(("xi", "speed", "std", "interval"), [(0.9, 50, 10, 3), (0.95, 100, 20, 1), (0.6, 1e4, 1, 0.1)])
def test_no_speed_is_too_great_for_the_start_from_one_measurement(order, xi, speed, std, interval):
    """A target whose every derivative up to the filter's last is wrong in the start, without noise."""
    gains = Gains.normalised(DESIGNS["fading-memory"].gains(order, xi=xi))
    times = np.arange(1000) * interval
    z = sum(speed * interval * (times / interval) ** n / math.factorial(n) for n in range(1, order))
    usual = default_gate(gains, (std,), interval, 4.0)
    track = run_filter(Measurements(times, z[:, None], interval), gains, start="first", gate=usual)
    assert not track.rejected.any()
    # Once the start is forgotten the gate is that of the steady filter.
    steady = std * math.sqrt(model_covariance(gains, usual.tracking_index).innovation)
    assert track.spread[-1, 0] == pytest.approx(steady, rel=1e-6)


@pytest.mark.parametrize(("order", "start"), [(o, s) for o in ORDERS for s, points in BESIDE if points < o])
@pytest.mark.parametrize("xi", [0.5, 0.8, 0.95])
@pytest.mark.parametrize("speed", [0, 30, 1000])
def test_right_measurements_are_hardly_ever_refused_after_a_start(order, start, xi, speed):
    """Of 50 noisy targets over 60 samples as many as the model foretells, and ten more."""
    gains = Gains.normalised(DESIGNS["fading-memory"].gains(order, xi=xi))
    usual, times = default_gate(gains, (1.0,), 1.0, 3.5), np.arange(60.0)
    move = sum(speed * times**n / math.factorial(n) / 10 ** (n - 1) for n in range(1, order))
    noise = np.random.default_rng(order).normal(size=(50, 60))
    tracks = [run_filter(Measurements(times, (move + e)[:, None], 1.0), gains, start=start, gate=usual) for e in noise]
    refused = sum(int(track.rejected.sum()) for track in tracks)
    assert refused <= 50 * 60 * reject_probability(3.5, 1) + 10


@pytest.mark.parametrize("start", ["first", "two-point", "expanding"])
def test_an_outlier_soon_after_the_start_of_a_slow_target_is_refused(start):
    z = np.random.default_rng(2).normal(size=(60, 1))
    z[8] += 40
    gains = Gains.normalised(DESIGNS["fading-memory"].gains(2, xi=0.9))
    track = run_filter(
        Measurements(np.arange(60.0), z, 1.0), gains, start=start, gate=default_gate(gains, (1.0,), 1.0, 4.0)
    )
    assert np.flatnonzero(track.rejected).tolist() == [8]


def test_an_outlier_alone_costs_the_track_nothing():
    clean = recording(8, axes=1, gaps=0, outliers=0)
    wild = clean.positions.copy()
    wild[60] += 1000
    dirty = Measurements(clean.times, wild, clean.interval)
    track = run_filter(dirty, GAINS[3], gate=gate())
    assert np.flatnonzero(track.rejected).tolist() == [60]
    assert np.abs(track.smoothed[:, :, 0] - run_filter(clean, GAINS[3], gate=gate()).smoothed[:, :, 0])[2:].max() < 1


@pytest.mark.parametrize("order", ORDERS)
def test_refusals_widen_the_gate_from_the_third_in_a_row_on(order):
    """Each of them then multiplies the covariance; a gap between them changes nothing but time."""
    z = np.zeros((60, 1))
    z[40:] = 1e9
    z[43] = np.nan
    track = run_filter(Measurements(np.arange(60.0), z, 1.0), GAINS[order], gate=gate(4.0, 0.1, 1.0))
    assert track.rejected[[40, 41, 42, 44, 45]].all()
    assert not track.rejected[43]
    variances = track.spread[:, 0] ** 2 - 1
    growth = variances[41:47] / variances[40:46]
    # Third refusal at 42, then one at 44: what they multiply is seen at the sample after each.
    assert (growth[[2, 4]] > DOUBT).all()
    assert (growth[[0, 1, 3]] < DOUBT).all()


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("start", ["two-point", "first", "expanding"])
def test_unstable_gains_open_the_gate(order, start):
    gains = UNSTABLE[order]
    seen = recording(9, 4000, axes=2, outliers=0)
    gated = run_filter(seen, gains, start=start, gate=gate(8.0, 0.0))
    stop = gated.stopped_at
    assert stop is not None
    assert np.isfinite(gated.spread[stop]).all()
    assert np.isnan(gated.spread[stop + 1 :]).all()
    assert np.isnan(gated.smoothed[stop + 1 :]).all()
    assert not gated.rejected[stop + 1 :].any()


def test_all_axes_stop_with_the_first_of_them():
    z = np.column_stack((np.zeros(200), np.ones(200)))
    seen, unstable = Measurements(np.arange(200.0), z, 1.0), Gains((0.5, 3.6))
    both = {"start": "known", "initial_state": np.zeros((2, 2))}
    gated = run_filter(seen, unstable, gate=gate(100.0, 0.1, 1.0), **both)
    bare = run_filter(seen, unstable, **both)
    assert gated.stopped_at == bare.stopped_at is not None
    assert same(gated.smoothed, bare.smoothed)


@pytest.mark.parametrize("start", ["first", "two-point", "expanding"])
def test_the_start_may_pass_the_limit_too(start):
    z = np.column_stack((np.full(40, 200.0), np.full(40, 1.0)))
    z[0, 1] = np.nan
    seen = Measurements(np.arange(40.0), z, 1.0)
    gated = run_filter(seen, GAINS[2], start=start, limit=100.0, gate=gate(4.0, 0.1, 1.0))
    bare = run_filter(seen, GAINS[2], start=start, limit=100.0)
    assert gated.stopped_at == bare.stopped_at == 0
    assert same(gated.smoothed, bare.smoothed)


@pytest.mark.parametrize("start", ["first", "two-point", "expanding"])
def test_the_gate_waits_for_the_last_axis(start):
    """A sample that one axis needs for its start is not refused."""
    z = np.random.default_rng(0).normal(size=(40, 2))
    z[:20, 1] = np.nan
    z[10, 0] += 500
    z[30, 0] += 500
    track = run_filter(Measurements(np.arange(40.0), z, 1.0), GAINS[2], start=start, gate=gate(8.0, 0.1, 1.0))
    assert not track.rejected[:21].any()
    assert track.rejected[30]
    assert not np.isnan(track.spread[10, 0])
    assert np.isnan(track.spread[10, 1])


def test_an_axis_that_never_begins_leaves_the_gate_open():
    z = np.random.default_rng(0).normal(size=(40, 2))
    z[1:, 1] = np.nan
    z[30, 0] += 500
    track = run_filter(Measurements(np.arange(40.0), z, 1.0), GAINS[2], start="expanding", gate=gate())
    assert not track.rejected.any()


def test_a_sample_without_measurements_is_not_refused():
    z = np.full((30, 2), np.nan)
    z[:2] = 0
    track = run_filter(Measurements(np.arange(30.0), z, 1.0), GAINS[2], gate=gate(1.0, 0.0, 1.0))
    assert not track.rejected.any()
    assert (np.diff(track.spread[2:], axis=0) > 0).all()


@pytest.mark.parametrize("order", ORDERS)
def test_the_spread_of_equal_steps_does_not_depend_on_the_unit_of_time(order):
    one, other = (
        run_filter(Measurements(np.arange(60) * t, recording(1, 60).positions, t), GAINS[order], gate=gate(4.0, 0.2, t))
        for t in (0.25, 4.0)
    )
    assert one.spread == pytest.approx(other.spread, rel=1e-13, nan_ok=True)
    assert same(one.rejected, other.rejected)


# What a gate is made of --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"width": 0.99}, "width"),
        ({"width": 101}, "width"),
        ({"width": math.nan}, "width"),
        ({"sensor_std": ()}, "sensor_std"),
        ({"sensor_std": (1.0, 0.0)}, "sensor_std"),
        ({"sensor_std": (math.inf,)}, "sensor_std"),
        ({"tracking_index": -0.1}, "tracking_index"),
        ({"tracking_index": math.nan}, "tracking_index"),
        ({"interval": 0.0}, "interval"),
    ],
    ids=str,
)
def test_a_gate_that_cannot_be_is_refused(change, field):
    with pytest.raises(InputError) as caught:
        gate(**change)
    assert caught.value.field == field


def test_a_gate_for_other_axes_is_refused():
    with pytest.raises(InputError, match="must be one number, or one per axis"):
        run_filter(recording(0, axes=3), GAINS[2], gate=gate(sensor_std=(1.0, 2.0)))


def test_too_few_measurements_are_refused_as_without_a_gate():
    seen = Measurements(np.arange(5.0), np.array([[1.0], *[[np.nan]] * 4]), 1.0)
    with pytest.raises(InputError, match="at least 2 measurements"):
        run_filter(seen, GAINS[2], gate=gate())


@pytest.mark.parametrize("order", ORDERS)
def test_the_default_gate_stands_on_the_model_that_suits_the_gains(order):
    found = default_gate(Gains.normalised(optimal_gains(order, 0.3)), (2.0,), 4.0, 5.0)
    assert (found.width, found.sensor_std, found.interval) == (5.0, (2.0,), 4.0)
    assert found.tracking_index == pytest.approx(0.3, rel=1e-4)


@pytest.mark.parametrize("gains", [*UNSTABLE.values(), Gains((2.0, 0.0)), Gains((0.5, 0.0))], ids=str)
def test_the_default_gate_of_gains_that_suit_no_model_has_none(gains):
    assert default_gate(gains, (1.0,), 1.0, 4.0).tracking_index == 0


def test_deviations_may_be_a_number_a_list_or_an_array():
    for right in (5.0, [5.0], np.array([5.0]), (5.0,)):
        assert Gate(4.0, right, 0.1, 1.0) == Gate(4.0, (5.0,), 0.1, 1.0)
    for wrong in ("five", None, [], -1.0, [1.0, "x"]):
        with pytest.raises(InputError, match="^sensor_std must be"):
            Gate(4.0, wrong, 0.1, 1.0)
