"""Noise from measurements: simulated targets whose noise is known, outliers, and the ends of what can be told."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from tracker_core import (
    SCENARIOS,
    Experiment,
    Gains,
    InputError,
    Measurements,
    identification,
    run_experiment,
    run_filter,
)
from tracker_core.design.kalata import TRACKING_INDEX
from tracker_core.identification import identify, measured_std
from tracker_core.likelihood import LOWEST, MOST_SAMPLES, likelihood
from tracker_core.optimal import optimal_gains

ORDERS = [2, 3, 4]
NAN = math.nan


def recorded(z, interval=1.0, steps=None):
    z = np.asarray(z, dtype=float)
    z = z[:, None] if z.ndim == 1 else z
    if steps is None:
        return Measurements(np.arange(len(z)) * interval, z, interval)
    return Measurements(np.cumsum(steps) * interval, z, None)


# Simulated targets -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tracking_index", [0.03, 0.4])
@pytest.mark.parametrize("kind", ["regular", "gaps", "irregular"])
def test_noise_that_was_put_in_is_found(pushed_target, order, tracking_index, kind):
    """Within four standard errors: 1/sqrt(2n) of sigma, made 1.5 times larger by what the index takes of it."""
    draw = np.random.default_rng(17 * order)
    n, interval = 3000, 0.5
    std = np.array([3.0, 20.0])
    steps = draw.uniform(0.3, 1.7, n) if kind == "irregular" else np.ones(n)
    z = pushed_target(order, steps, tracking_index, 1.0, draw, axes=2) * std
    if kind == "gaps":
        z[draw.random(n) < 0.1] = NAN
        z[1000:1030, 1] = NAN
    found = identify(recorded(z, interval, steps if kind == "irregular" else None), order, interval=interval)
    assert found.interval == interval
    assert found.sensor_std == pytest.approx(std, rel=4 * 1.5 / math.sqrt(2 * n))
    low, high = np.log(found.index_interval)
    error = (high - low) / 2 / 1.96
    assert abs(math.log(found.tracking_index / tracking_index)) < 4 * error
    assert error < 0.12
    scale = interval ** (2 if order < 4 else 3)
    assert np.array(found.process_std) * scale / std == pytest.approx(tracking_index, rel=4 * error + 0.1)
    assert found.rejected == 0
    assert not found.crowded
    assert found.manoeuvre_found
    assert found.noise_found
    assert found.suggested_index == found.tracking_index


@pytest.mark.parametrize("order", ORDERS)
def test_the_interval_holds_the_true_index_as_often_as_it_says(pushed_target, order):
    draw = np.random.default_rng(order)
    held = 0
    for _ in range(200):
        z = pushed_target(order, np.ones(120), 0.3, 2.0, draw)
        low, high = identify(recorded(z), order, robust=False).index_interval
        held += low <= 0.3 <= high
    # 190 are expected, give or take three; fewer than 176 or more than 199 would have a probability below 1e-4.
    assert 176 <= held <= 199


@pytest.mark.parametrize("order", ORDERS)
def test_the_ends_of_the_interval_are_where_the_likelihood_ratio_says(pushed_target, order):
    z = pushed_target(order, np.ones(250), 0.2, 2.0, np.random.default_rng(order), axes=2)
    found = identify(recorded(z), order, robust=False)
    values = likelihood(recorded(z), order).values
    at = np.log([found.tracking_index, *found.index_interval])
    top, low, high = values(at, np.array([True, True]))
    assert top == pytest.approx(found.log_likelihood, rel=1e-12)
    assert [2 * (top - low), 2 * (top - high)] == pytest.approx([chi2.ppf(0.95, 1)] * 2, abs=1e-3)
    assert found.aic == pytest.approx(6 - 2 * top, rel=1e-12)
    assert found.count == 2 * 246
    assert found.bic == pytest.approx(3 * math.log(found.count) - 2 * top, rel=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_gains_of_the_estimate_predict_better_than_their_neighbours(pushed_target, order):
    measurements = recorded(pushed_target(order, np.ones(5_000), 0.1, 2.0, np.random.default_rng(order)))
    found = identify(measurements, order)
    assert found.gains.tolist() == optimal_gains(order, found.tracking_index).tolist()
    missed = [
        np.nanmean(run_filter(measurements, Gains.normalised(gains)).innovation[100:] ** 2)
        for gains in (optimal_gains(order, factor * found.tracking_index) for factor in (0.6, 1.0, 1.7))
    ]
    assert missed[1] == min(missed)


@settings(max_examples=25)
@given(scale=st.floats(1e-4, 1e4), shift=st.floats(-1e5, 1e5), interval=st.floats(0.01, 100))
def test_units_change_the_numbers_and_not_the_filter(pushed_target, scale, shift, interval):
    z = pushed_target(2, np.ones(80), 0.3, 1.0, np.random.default_rng(5))
    one = identify(recorded(z), 2)
    other = identify(recorded(scale * (z + shift), interval), 2)
    assert other.tracking_index == pytest.approx(one.tracking_index, rel=1e-4)
    assert other.sensor_std == pytest.approx(scale * np.array(one.sensor_std), rel=1e-4)
    assert other.process_std == pytest.approx(scale * np.array(one.process_std) / interval**2, rel=1e-4)


def test_an_index_belongs_to_its_interval(pushed_target):
    """The same measurements, counted in intervals twice as long: pushes of constant power."""
    draw = np.random.default_rng(6)
    steps = draw.uniform(0.5, 1.5, 500)
    z = pushed_target(3, steps, 0.2, 1.0, draw)
    one, other = (identify(recorded(z, 1.0, steps), 3, interval=interval) for interval in (1.0, 2.0))
    assert other.sensor_std == pytest.approx(one.sensor_std, rel=1e-6)
    assert other.process_std == pytest.approx(np.sqrt(2) * np.array(one.process_std), rel=1e-6)
    assert other.log_likelihood == pytest.approx(one.log_likelihood, rel=1e-9)


def test_of_very_many_samples_blocks_are_used(pushed_target):
    z = pushed_target(2, np.ones(25_000), 0.3, 2.0, np.random.default_rng(0))
    found = identify(recorded(z), 2)
    assert found.samples == MOST_SAMPLES
    assert found.sensor_std == pytest.approx([2.0], rel=0.04)
    assert found.set_aside.shape == (25_000,)


# Outliers ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("irregular", [False, True])
def test_outliers_hardly_move_the_estimate(pushed_target, order, irregular):
    """One measurement in twenty is wrong by fifty sigma."""
    draw = np.random.default_rng(order)
    steps = draw.uniform(0.3, 1.7, 1500) if irregular else np.ones(1500)
    z = pushed_target(order, steps, 0.2, 3.0, draw, axes=2)
    bad = draw.random(1500) < 0.05
    dirty = z.copy()
    dirty[bad] += 150 * draw.choice([-1, 1], (bad.sum(), 2))
    clean, found, fooled = (
        identify(recorded(values, 1.0, steps if irregular else None), order, robust=robust, interval=1.0)
        for values, robust in ((z, False), (dirty, True), (dirty, False))
    )
    assert found.sensor_std == pytest.approx(clean.sensor_std, rel=0.05)
    assert found.tracking_index == pytest.approx(clean.tracking_index, rel=0.1)
    assert not (bad & ~found.set_aside).any()
    assert (found.set_aside & ~bad).sum() <= 2
    assert found.rejected == found.set_aside.sum()
    assert fooled.sensor_std[0] > 5 * clean.sensor_std[0]


@pytest.mark.parametrize("name", [name for name in SCENARIOS if not name.startswith("garg")])
@pytest.mark.parametrize("order", [2, 3])
def test_manoeuvres_are_no_outliers(name, order):
    """Turns and steps of the acceleration, which no order of the model foresees."""
    found = identify(run_experiment(Experiment.from_dict({"scenario": name})).measurements, order)
    assert found.rejected == 0


def test_first_and_last_measurements_are_judged_too(pushed_target):
    z = pushed_target(3, np.ones(600), 0.05, 5.0, np.random.default_rng(3), axes=2)
    bad = [0, 5, 598]
    z[bad] += 300
    found = identify(recorded(z), 3)
    assert set(bad) <= set(np.flatnonzero(found.set_aside).tolist())
    assert found.rejected <= len(bad) + 1
    assert found.sensor_std == pytest.approx([5, 5], rel=0.1)


def test_wrong_measurements_side_by_side_are_found(pushed_target):
    z = pushed_target(2, np.ones(600), 0.3, 5.0, np.random.default_rng(3))
    z[100:103] += 80
    found = identify(recorded(z), 2)
    assert np.flatnonzero(found.set_aside).tolist() == [100, 101, 102]


def test_measurements_in_coarse_steps_are_no_outliers():
    t = np.arange(600.0)
    draw = np.random.default_rng(3)
    z = np.c_[10 * t + draw.normal(0, 3, 600), np.clip(3 * t, 0, 900)]
    found = identify(recorded(7.62 * np.round(z / 7.62)), 2)
    assert not found.crowded
    assert found.rejected == 0


def test_where_too_many_look_wrong_none_is_set_aside(pushed_target, monkeypatch):
    z = pushed_target(2, np.ones(600), 0.1, 1.0, np.random.default_rng(3))
    z[::25] += 100
    assert identify(recorded(z), 2).rejected == 24
    monkeypatch.setattr(identification, "MOST_SET_ASIDE", 23 / 600)
    found, fooled = identify(recorded(z), 2), identify(recorded(z), 2, robust=False)
    assert found.crowded
    assert found.rejected == 0
    assert (found.sensor_std, found.tracking_index) == (fooled.sensor_std, fooled.tracking_index)


# The ends of what can be told --------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
def test_a_target_that_does_not_manoeuvre(order):
    draw = np.random.default_rng(7)
    t = np.arange(400.0)
    found = identify(recorded(3 * t + draw.normal(0, 2, 400)), order)
    assert not found.manoeuvre_found
    assert found.index_interval[0] == TRACKING_INDEX.low
    assert found.noise_found
    assert found.sensor_std == pytest.approx([2], rel=0.15)
    assert found.suggested_index == found.index_interval[1] < 0.01
    assert found.gains.tolist() == optimal_gains(order, found.suggested_index).tolist()


def test_no_manoeuvre_at_all_is_the_end_of_the_domain():
    found = identify(recorded(np.random.default_rng(3).normal(size=600)), 2)
    assert found.tracking_index == TRACKING_INDEX.low == pytest.approx(math.exp(LOWEST))


@pytest.mark.parametrize("order", ORDERS)
def test_a_path_that_the_filter_follows_exactly(order):
    t = np.arange(200.0)
    found = identify(recorded(np.c_[t ** (order - 1), np.full(200, 3e6)]), order)
    assert found.sensor_std == found.process_std == (0.0, 0.0)
    assert found.log_likelihood is found.aic is found.bic is None
    assert found.index_interval == (TRACKING_INDEX.low, TRACKING_INDEX.high)
    assert found.count == found.rejected == 0
    assert not found.manoeuvre_found
    assert not found.noise_found
    assert np.isfinite(found.gains).all()


def test_an_axis_without_noise_leaves_the_others_alone(pushed_target):
    z = pushed_target(2, np.ones(300), 0.2, 2.0, np.random.default_rng(1))
    alone, beside = identify(recorded(z), 2), identify(recorded(np.c_[z, np.full(300, 7.0)]), 2)
    assert beside.sensor_std == (*alone.sensor_std, 0.0)
    assert beside.tracking_index == alone.tracking_index
    assert beside.bic == alone.bic


def test_a_smooth_path_without_noise():
    t = np.arange(400) / 20
    found = identify(recorded(1000 * np.c_[np.cos(t), np.sin(t)]), 3)
    assert not found.noise_found
    assert found.manoeuvre_found
    assert found.index_interval[1] == TRACKING_INDEX.high
    assert max(found.sensor_std) < 1e-3


@pytest.mark.parametrize("order", ORDERS)
@given(data=st.data())
@settings(max_examples=40)
def test_no_measurements_break_it(order, data):
    number = st.one_of(st.floats(-1e9, 1e9), st.sampled_from([0.0, 1.0, 1e-300, NAN]))
    z = np.array(data.draw(st.lists(number, min_size=12, max_size=40)))
    steps = np.array(data.draw(st.lists(st.floats(1e-3, 300), min_size=len(z), max_size=len(z))))
    try:
        found = identify(recorded(z, 1.0, steps), order)
    except InputError as error:
        # Too few, or too far apart.
        if error.field != "positions":
            raise
        return
    numbers = (*found.sensor_std, *found.process_std, *found.index_interval, *found.gains)
    assert np.isfinite(numbers).all()
    assert found.log_likelihood is None or math.isfinite(found.log_likelihood)
    assert found.index_interval[0] <= found.tracking_index <= found.index_interval[1]


# The quick estimate ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["regular", "gaps", "irregular"])
def test_third_differences_tell_the_noise(kind):
    draw = np.random.default_rng(2)
    n, std = 20_000, np.array([2.0, 30.0])
    steps = draw.uniform(0.3, 1.7, n) if kind == "irregular" else np.ones(n)
    t = np.cumsum(steps)
    z = np.c_[5 * t, 0.01 * t**2] + std * draw.standard_normal((n, 2))
    z[draw.random(n) < 0.02] += 1e4
    if kind == "gaps":
        z[draw.random((n, 2)) < 0.2] = NAN
    found = measured_std(recorded(z, 0.5, steps if kind == "irregular" else None))
    # The median of neighbours that share measurements, and one in twelve of them with an outlier.
    assert found == pytest.approx(std, rel=0.12)


def test_a_series_is_even_where_its_steps_are():
    """Not where it takes as many seconds as it has steps: a fast target moves far in a second that is longer."""
    draw = np.random.default_rng(3)
    inner = np.sort(np.arange(1, 300) + draw.uniform(-0.3, 0.3, 299))
    t = np.concatenate(([0.0], inner, [300.0]))
    z = 250 * t + 3 * draw.standard_normal(301)
    measured = Measurements(t, z[:, None], None)
    assert measured_std(measured)[0] == pytest.approx(3, rel=0.3)


def test_third_differences_by_hand():
    assert measured_std(recorded([0, 0, 0, 1.0]))[0] == pytest.approx(1 / math.sqrt(20) / 0.6744897501960817)
    # 1, 2 and 4 apart: weights one over the products of the distances.
    weights = np.array([-1 / (1 * 3 * 7), 1 / (1 * 2 * 6), -1 / (3 * 2 * 4), 1 / (7 * 6 * 4)])
    expected = abs(weights[3]) / np.sqrt((weights**2).sum()) / 0.6744897501960817
    assert measured_std(recorded([0, 0, 0, 1.0], 1.0, [1, 1, 2, 4]))[0] == pytest.approx(expected)
    assert measured_std(recorded([0, NAN, 0, 0, NAN, NAN, NAN, 1.0]))[0] == pytest.approx(
        measured_std(recorded([0, 0, 0, 1.0], 1.0, [1, 2, 1, 4]))[0]
    )


@pytest.mark.parametrize("z", [[], [1.0, 2.0, 4.0], [NAN] * 9, [1, NAN, 2, NAN, 7], [5.0] * 50], ids=str)
def test_third_differences_of_too_little_are_nothing(z):
    assert measured_std(recorded(z)) == (0.0,)


def test_polynomials_have_no_noise():
    t = np.cumsum(np.random.default_rng(0).uniform(0.5, 1.5, 500))
    assert measured_std(Measurements(t, np.c_[7e6 - 11.3 * t, 0.1 * t**2], None)) == (0.0, 0.0)
