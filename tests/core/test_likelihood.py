"""The likelihood of a model: against the density of all measurements at once, and a short filter in numpy."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from scipy.stats import multivariate_normal

from tracker_core import InputError, Measurements, kernels
from tracker_core.likelihood import BLOCKS, HIGHEST, LOWEST, MOST_SAMPLES, SILENCE, WARM, likelihood

ORDERS = [2, 3, 4]
NAN = math.nan


def model(z, order, steps=None, interval=1.0):
    z = np.asarray(z, dtype=float)
    z = z[:, None] if z.ndim == 1 else z
    if steps is None:
        return likelihood(Measurements(np.arange(len(z)) * interval, z, interval), order)
    return likelihood(Measurements(np.cumsum(steps) * interval, z, None), order, interval)


def value(found, index, std):
    """Logarithm of the likelihood of one axis for a given noise."""
    squares, logs, _, count = found.sums(np.array([index]))[0, 0]
    return -(squares / std**2 + logs + count * math.log(2 * math.pi * std**2)) / 2


def contrasts(z, m, c, order):
    """Log density of what is left of measurements when M x_0, with any x_0, is taken out of them, unit Jacobian."""
    weights = np.eye(len(z))[order:]
    weights[:, :order] = -np.linalg.solve(m[:order].T, m[order:].T).T
    return multivariate_normal.logpdf(weights @ z, cov=weights @ c @ weights.T)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tracking_index", [0.01, 0.3, 5.0])
@pytest.mark.parametrize("irregular", [False, True])
def test_likelihood_is_the_density_of_all_measurements(pushed_target, joint_density, order, tracking_index, irregular):
    draw = np.random.default_rng(order)
    steps = draw.uniform(0.5, 2, 16) if irregular else np.ones(16)
    std = 3.0
    z = pushed_target(order, steps, tracking_index, std, draw)[:, 0]
    z[[6, 10, 11]] = NAN
    m, c = joint_density(order, steps, tracking_index)
    known = ~np.isnan(z)
    m, c, seen = m[known], std**2 * c[np.ix_(known, known)], z[known]
    # The first WARM say where the target is: the others are given those.
    expected = contrasts(seen, m, c, order)
    if order < WARM:
        expected -= contrasts(seen[:WARM], m[:WARM], c[:WARM, :WARM], order)
    found = model(z, order, steps if irregular else None)
    assert found.counts().tolist() == [len(seen) - WARM]
    assert value(found, tracking_index, std) == pytest.approx(expected, rel=1e-9, abs=1e-7)


def test_differences_of_a_straight_flight_are_what_the_density_is_of(pushed_target):
    """Order 2: second differences of equal steps have a covariance that can be written down."""
    z = pushed_target(2, np.ones(30), 0.5, 2.0, np.random.default_rng(1))[:, 0]
    d = np.eye(28, 30) - 2 * np.eye(28, 30, 1) + np.eye(28, 30, 2)
    # A push a held over one interval moves the second differences that end and begin with it by a/2 each.
    a = (np.eye(28, 29) + np.eye(28, 29, 1)) / 2
    cov = 4.0 * (d @ d.T + 0.25 * a @ a.T)
    sums = np.zeros((1, 1, 4))
    kernels.profile(z[None], np.ones(30, bool), np.ones(30), 2, np.array([0.5]), 100.0, 2, sums)
    squares, logs, _, count = sums[0, 0]
    assert count == 28
    found = -(squares / 4 + logs + count * math.log(2 * math.pi * 4)) / 2
    assert found == pytest.approx(multivariate_normal.logpdf(d @ z, cov=cov), rel=1e-11)


def plain_filter(z, steps, order, tracking_index, forward, push, prior=1e7):
    """A Kalman filter as a textbook prints it, with a vague start: innovations and variances."""
    x, p, found = np.zeros(order), prior * np.eye(order), []
    for measured, t in zip(z, steps, strict=True):
        f, g = forward(order, t), tracking_index * push(order, t)
        x, p = f @ x, f @ p @ f.T + np.outer(g, g)
        e, s = measured - x[0], p[0, 0] + 1
        found.append((e, s))
        k = p[:, 0] / s
        x, p = x + k * e, p - np.outer(k, p[0])
    return np.array(found)


@pytest.mark.parametrize("order", ORDERS)
def test_the_filter_is_that_of_a_textbook(pushed_target, order):
    def forward(order, t):
        return np.array([[t ** (j - i) / math.factorial(j - i) if j >= i else 0 for j in range(order)]
                         for i in range(order)])  # fmt: skip

    def push(order, t):
        if order == 2:
            return np.array([t**2 / 2, t]) / math.sqrt(t)
        return forward(order, t)[:, -1] * math.sqrt(t)

    draw = np.random.default_rng(order)
    steps = draw.uniform(0.5, 1.5, 300)
    z = pushed_target(order, steps, 0.2, 1.0, draw)[:, 0]
    e, s = plain_filter(z, steps, order, 0.2, forward, push)[WARM:].T
    squares, logs, plain, count = model(z, order, steps).sums(np.array([0.2]))[0, 0]
    assert count == len(e)
    # The vague start of the oracle is not quite one of nothing known.
    assert [squares, logs, plain] == pytest.approx([(e**2 / s).sum(), np.log(s).sum(), (e**2).sum()], rel=1e-4)


@given(
    order=st.sampled_from(ORDERS),
    slope=st.lists(st.floats(-100, 100), min_size=4, max_size=4),
    scale=st.floats(1e-3, 1e3),
    seed=st.integers(0, 50),
)
def test_polynomials_make_no_difference_and_units_only_theirs(pushed_target, order, slope, scale, seed):
    draw = np.random.default_rng(seed)
    steps = draw.uniform(0.5, 1.5, 40)
    z = pushed_target(order, steps, 0.3, 1.0, draw)[:, 0]
    t = np.cumsum(steps) / 40
    logs = np.log([0.01, 0.3, 5.0])
    live = np.array([True])
    one = model(z, order, steps).values(logs, live)
    moved = z + sum(c * t**k for k, c in enumerate(slope[:order]))
    assert model(moved, order, steps).values(logs, live) == pytest.approx(one, rel=1e-7, abs=1e-6)
    scaled = model(scale * z, order, steps).values(logs, live)
    assert scaled == pytest.approx(one - (40 - WARM) * math.log(scale), rel=1e-7, abs=1e-6)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("irregular", [False, True])
def test_deletions_are_what_the_others_say(pushed_target, joint_density, order, irregular):
    """Each measurement predicted from all others, by generalised least squares on the whole covariance."""
    draw = np.random.default_rng(order)
    steps = draw.uniform(0.5, 2, 13) if irregular else np.ones(13)
    z = pushed_target(order, steps, 0.4, 1.0, draw)[:, 0]
    z[6] = NAN
    used = np.ones(13, dtype=bool)
    used[8] = False
    m, c = joint_density(order, steps, 0.4)
    found = model(z, order, steps if irregular else None).believing(used).deletions(0.4)[0]
    assert np.isnan(found[6])
    for i in np.flatnonzero(~np.isnan(z)):
        rest = np.array([k for k in range(13) if k != i and used[k] and not np.isnan(z[k])])
        inverse = np.linalg.inv(c[np.ix_(rest, rest)])
        across = c[i, rest] @ inverse
        information = m[rest].T @ inverse @ m[rest]
        state = np.linalg.solve(information, m[rest].T @ inverse @ z[rest])
        left = m[i] - across @ m[rest]
        variance = c[i, i] - across @ c[i, rest] + left @ np.linalg.solve(information, left)
        expected = (z[i] - left @ state - across @ z[rest]) / math.sqrt(variance)
        assert found[i] == pytest.approx(expected, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("order", ORDERS)
def test_what_comes_first_is_judged_by_what_comes_later(pushed_target, joint_density, order):
    """Believed or not, a measurement lies as far from what the others say."""
    z = pushed_target(order, np.ones(25), 0.4, 1.0, np.random.default_rng(order))[:, 0]
    everything = model(z, order).deletions(0.4)[0]
    for i in (0, 1, order, 24):
        used = np.ones(25, dtype=bool)
        used[i] = False
        assert model(z, order).believing(used).deletions(0.4)[0, i] == pytest.approx(everything[i], rel=1e-6)


def test_what_is_not_believed_changes_nothing(pushed_target):
    z = pushed_target(3, np.ones(100), 0.1, 1.0, np.random.default_rng(0))[:, 0]
    used = np.ones(100, dtype=bool)
    used[[0, 40, 41, 99]] = False
    spoilt, holes = z.copy(), z.copy()
    spoilt[~used] = 1e6
    holes[~used] = NAN
    indices = np.array([0.01, 1.0])
    believed = model(spoilt, 3).believing(used).sums(indices)
    assert believed == pytest.approx(model(holes, 3).sums(indices), rel=1e-9)


def test_axes_are_on_their_own_whatever_is_measured_together(pushed_target):
    z = pushed_target(2, np.ones(60), 0.3, 2.0, np.random.default_rng(4), axes=3)
    z[10:14, 0] = z[10:14, 2] = z[30, 1] = NAN
    indices = np.array([0.05, 0.5])
    together = model(z, 2)
    assert together.groups == ((0, 2), (1,))
    for axis in range(3):
        alone = model(z[:, axis], 2).sums(indices)[:, 0]
        assert together.sums(indices)[:, axis] == pytest.approx(alone, rel=1e-12)


def test_after_a_long_silence_the_target_is_a_new_one(pushed_target):
    draw = np.random.default_rng(2)
    z = [pushed_target(2, np.ones(40), 0.3, 1.0, draw)[:, 0] for _ in range(2)]
    steps = np.ones(80)
    steps[40] = SILENCE + 1
    together = model(np.concatenate(z), 2, steps).sums(np.array([0.3]))
    apart = sum(model(part, 2).sums(np.array([0.3])) for part in z)
    assert together == pytest.approx(apart, rel=1e-9)
    steps[40] = SILENCE - 1
    assert model(np.concatenate(z), 2, steps).counts() == [76]


def test_silence_is_measured_by_how_often_a_target_is_seen():
    z = np.full(4000, NAN)
    z[::200] = np.random.default_rng(0).normal(size=20)
    assert model(z, 2).counts() == [20 - WARM]


@pytest.mark.parametrize("order", ORDERS)
def test_settled_gains_are_those_that_would_have_come(pushed_target, order):
    """Steps that differ in their last digit keep the filter from taking its gains for settled."""
    z = pushed_target(order, np.ones(400), 0.5, 1.0, np.random.default_rng(0))[:, 0]
    steps = np.where(np.arange(400) % 2, 1.0, np.nextafter(1.0, 2))
    indices = np.array([0.001, 0.5, 20.0])
    assert model(z, order, steps).sums(indices) == pytest.approx(model(z, order).sums(indices), rel=1e-10)


def test_of_very_many_samples_blocks_are_used(pushed_target):
    n = 3 * MOST_SAMPLES
    z = pushed_target(2, np.ones(n), 0.3, 1.0, np.random.default_rng(0))
    found = model(z, 2)
    assert found.rows.sum() == MOST_SAMPLES
    assert found.rows[0]
    assert found.rows[-1]
    assert found.counts() == [MOST_SAMPLES - BLOCKS * WARM]
    edges = np.flatnonzero(np.diff(found.rows.astype(int), prepend=0, append=0)).reshape(-1, 2)
    parts = sum(model(z[a:b], 2).sums(np.array([0.3])) for a, b in edges)
    assert found.sums(np.array([0.3])) == pytest.approx(parts, rel=1e-9)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("seed", range(3))
def test_the_peak_is_the_one_that_a_general_optimiser_finds(pushed_target, order, seed):
    draw = np.random.default_rng(seed)
    z = pushed_target(order, np.ones(300), 0.2, 2.0, draw, axes=2)
    found = model(z, order)
    profile = found.profile(np.array([True, True]))
    place, top = profile.peak(1e-8)
    best = minimize_scalar(
        lambda at: -profile.at(at), bounds=(LOWEST, HIGHEST), method="bounded", options={"xatol": 1e-9}
    )
    assert top == pytest.approx(-best.fun, abs=1e-6)
    assert place == pytest.approx(best.x, abs=1e-4)
    # With the sensor variance as a number of its own, the greatest likelihood is the same.
    std = found.sensor_std(math.exp(place))
    alone = sum(value(model(z[:, axis], order), math.exp(place), std[axis]) for axis in range(2))
    assert alone == pytest.approx(top, rel=1e-12)
    for factor in (0.99, 1.01):
        assert value(model(z[:, 0], order), math.exp(place), factor * std[0]) < value(
            model(z[:, 0], order), math.exp(place), std[0]
        )


@pytest.mark.parametrize(
    ("z", "order", "field"),
    [
        (np.zeros(9), 2, "positions"),
        (np.where(np.arange(30) < 9, 1.0, NAN), 2, "positions"),
        (np.zeros(30), 1, "order"),
        (np.zeros(30), 5, "order"),
        (np.full(30, 1e200), 2, "positions"),
        (np.full(30, math.inf), 2, "positions"),
        (np.full((30, 0), 1.0), 2, "positions"),
    ],
    ids=["nine", "nine-known", "order-1", "order-5", "huge", "infinite", "no-axis"],
)
def test_what_has_no_likelihood_is_refused(z, order, field):
    with pytest.raises(InputError) as caught:
        model(z, order)
    assert caught.value.field == field


def test_measurements_that_are_all_alone_are_refused():
    steps = np.where(np.arange(30) % 4, 1.0, 1e4)
    with pytest.raises(InputError, match="without long gaps"):
        model(np.zeros(30), 2, steps)
