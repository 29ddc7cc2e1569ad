"""Errors of many gain sets where samples lie anywhere, or only some of the truth is known: those of their tracks."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker_core import DESIGNS, Gains, InputError, Measurements, Truth, run_filter
from tracker_core.batch import FIGURES, KINDS, Runs, batch_errors, errors_of_runs
from tracker_core.metrics import measure
from tracker_core.starts import STARTS

XI = (0.3, 0.64, 0.9)


def scene(axes=2, samples=80, *, gaps=True, seed=0):
    """Times that are not evenly spaced, what was there, and what was measured, with gaps at the start and later."""
    rng = np.random.default_rng(seed)
    times = 100.0 + np.cumsum(rng.uniform(0.3, 3.0, samples))
    truth = 300 * np.sin(0.05 * times[:, None] + np.arange(axes)) + 20 * times[:, None]
    positions = truth + 5 * rng.standard_normal((samples, axes))
    if gaps:
        positions[0, -1] = np.nan
        positions[2] = positions[30:34] = np.nan
        positions[50, 0] = np.nan
    return times, truth, positions


def alone(measurements, truth, vector, start="two-point", state=None, limit=1e12):
    """Figures of one gain set by kind, from its track, as a table by kind and figure; NaN where it stops."""
    gains = Gains.normalised(vector)
    given_state = None if state is None else state[:, : gains.order]
    track = run_filter(measurements, gains, start=start, initial_state=given_state, limit=limit)
    if track.stopped_at is not None:
        return np.full((len(KINDS), len(FIGURES)), np.nan)
    known = None if truth is None else Truth(measurements.times, np.repeat(truth[:, :, None], 5, axis=2))
    found = measure(track, measurements, known, gains, stable=False)
    errors = track.innovation[~np.isnan(track.innovation).any(axis=1)]
    sizes = np.sqrt((errors**2).sum(axis=1))
    # The metrics have the total of the innovation alone.
    own = [sizes.sum(), np.sqrt((sizes**2).mean()), sizes.max(), np.sqrt((sizes**2).sum()) / len(sizes)]
    if truth is None:
        return np.array([own])
    assert own[0] == pytest.approx(found.innovation_total, rel=1e-12)
    table = [[getattr(found, f"{kind}_{figure}") for figure in FIGURES] for kind in KINDS[:2]]
    return np.array([*table, own], dtype=float)


def stacked(found, kinds=KINDS):
    """Shape (sets, kinds, figures) of the only run."""
    rows = [np.stack([found[kind].figures[name][:, 0] for name in FIGURES], axis=-1) for kind in kinds]
    return np.stack(rows, axis=1)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("gaps", [False, True], ids=["all-there", "gaps"])
@pytest.mark.parametrize("axes", [1, 3])
def test_every_set_has_the_errors_of_its_track(start, gaps, axes):
    times, truth, positions = scene(axes, gaps=gaps)
    orders = [order for order in (2, 3, 4) if order >= STARTS[start].least_order]
    sets = [DESIGNS["fading-memory"].gains(order, xi=xi) for xi in XI for order in orders]
    state = np.random.default_rng(4).normal(scale=30, size=(axes, 4)) if start == "known" else None
    runs = Runs(positions[None], truth[None], 1.0, times)
    found = stacked(errors_of_runs(runs, sets, start=start, initial_state=state))
    measurements = Measurements(times, positions, None)
    for row, vector in zip(found, sets, strict=True):
        np.testing.assert_allclose(row, alone(measurements, truth, vector, start, state), rtol=1e-12)


@settings(max_examples=60, deadline=None)
@given(
    steps=st.lists(st.floats(1e-3, 1e3), min_size=8, max_size=25),
    gone=st.sets(st.integers(3, 24), max_size=12),
    unknown=st.sets(st.integers(0, 24), max_size=20),
    order=st.sampled_from([2, 3, 4]),
    xi=st.floats(0.05, 0.95),
    start=st.sampled_from(["first", "two-point", "expanding"]),
    seed=st.integers(0, 1000),
)
def test_any_intervals_and_any_gaps(steps, gone, unknown, order, xi, start, seed):
    rng, samples = np.random.default_rng(seed), len(steps)
    truth = rng.normal(scale=100, size=(samples, 2))
    positions = truth + rng.standard_normal(truth.shape)
    positions[[i for i in gone if i < samples], 0] = np.nan
    truth[[i for i in unknown if i < samples - 2], 1] = np.nan
    measurements = Measurements(np.cumsum(steps), positions, None)
    vector = DESIGNS["fading-memory"].gains(order, xi=xi)
    runs = Runs(positions[None], truth[None], 1.0, measurements.times)
    found = stacked(errors_of_runs(runs, vector[None], start=start))[0]
    np.testing.assert_allclose(found, alone(measurements, truth, vector, start), rtol=1e-11)


@pytest.mark.parametrize("start", ["two-point", "expanding"])
def test_even_times_give_what_a_constant_interval_gives(start):
    _, truth, positions = scene()
    even = Runs(positions[None], truth[None], 0.5)
    sets = [DESIGNS["fading-memory"].gains(order, xi=xi) for xi in XI for order in (2, 3, 4)]
    side_by_side = stacked(errors_of_runs(even, sets, start=start))
    timed = replace(even, times=7 + 0.5 * np.arange(len(truth)))
    np.testing.assert_allclose(stacked(errors_of_runs(timed, sets, start=start)), side_by_side, rtol=1e-11)


@pytest.mark.parametrize("varying", [False, True], ids=["constant", "varying"])
def test_samples_whose_truth_nobody_knows_do_not_count(varying):
    times, truth, positions = scene()
    interval = None if varying else 1.5
    times = times if varying else 1.5 * np.arange(len(truth))
    partly = truth.copy()
    partly[:6], partly[20:40, 1], partly[77] = np.nan, np.nan, np.nan
    measurements = Measurements(times, positions, interval)
    sets = np.array([DESIGNS["fading-memory"].gains(3, xi=xi) for xi in XI])
    runs = Runs(positions[None], partly[None], 1.5, times if varying else None)
    for row, vector in zip(stacked(errors_of_runs(runs, sets)), sets, strict=True):
        np.testing.assert_allclose(row, alone(measurements, partly, vector), rtol=1e-12)
    # Where the target is known makes no difference to the innovations.
    fully = errors_of_runs(replace(runs, truth=truth[None]), sets)["innovation"].total
    np.testing.assert_allclose(errors_of_runs(runs, sets)["innovation"].total, fully, rtol=1e-12)


@pytest.mark.parametrize("varying", [False, True], ids=["constant", "varying"])
@pytest.mark.parametrize("nobody", ["none", "nan"])
def test_without_a_truth_there_are_innovations_alone(varying, nobody):
    times, truth, positions = scene()
    even = Measurements(1.5 * np.arange(len(truth)), positions, 1.5)
    measurements = Measurements(times, positions, None) if varying else even
    unknown = None if nobody == "none" else np.full_like(truth[None], np.nan)
    runs = Runs(positions[None], unknown, 1.5, times if varying else None)
    sets = np.array([DESIGNS["fading-memory"].gains(2, xi=xi) for xi in XI])
    found = stacked(errors_of_runs(runs, sets, kinds=["innovation"]), ["innovation"])
    for row, vector in zip(found, sets, strict=True):
        np.testing.assert_allclose(row, alone(measurements, None, vector), rtol=1e-12)
    with pytest.raises(InputError, match="kinds must be innovation alone where the truth is not known"):
        errors_of_runs(runs, sets)
    states = np.full((*positions.shape, 5), np.nan)
    assert list(batch_errors(measurements, Truth(times, states), sets)) == ["innovation"]


@pytest.mark.parametrize("start", ["two-point", "expanding"])
def test_a_set_that_goes_too_far_has_no_errors_and_spoils_no_other(start):
    times, truth, positions = scene()
    sets, limit = np.array([[0.5, 0.2], [1.9, 3.9], [0.5, 0.2]]), 1e6
    found = stacked(errors_of_runs(Runs(positions[None], truth[None], 1.0, times), sets, start=start, limit=limit))
    assert np.isnan(found[1]).all()
    assert np.array_equal(found[0], found[2])
    np.testing.assert_allclose(
        found[0], alone(Measurements(times, positions, None), truth, sets[0], start, limit=limit), rtol=1e-12
    )
    # What the start itself has left behind counts as well.
    near = errors_of_runs(Runs(positions[None], truth[None], 1.0, times), sets[:1], start=start, limit=10.0)
    assert np.isnan(stacked(near)).all()


def test_every_run_is_its_own():
    times, truth, positions = scene()
    several = np.stack([positions, positions + 3.0 * np.sin(times)[:, None]])
    sets = np.array([[0.5, 0.2], [0.3, 0.1]])
    together = errors_of_runs(Runs(several, truth[None], 1.0, times), sets)
    for run in range(2):
        one = errors_of_runs(Runs(several[[run]], truth[None], 1.0, times), sets)
        assert np.array_equal(
            stacked(one)[:, 0], np.stack([together["tracking"].figures[f][:, run] for f in FIGURES], 1)
        )


def test_both_ways_of_asking_agree():
    times, truth, positions = scene()
    states = np.repeat(truth[:, :, None], 5, axis=2)
    sets = np.array([[0.5, 0.2], [0.3, 0.1]])
    found = batch_errors(Measurements(times, positions, None), Truth(times, states), sets)
    other = errors_of_runs(Runs(positions[None], truth[None], 1.0, times), sets)
    assert np.array_equal(found["estimation"].rmse, other["estimation"].rmse[:, 0])


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (np.arange(79.0), r"times must have shape \(80,\) like the runs"),
        (np.full(80, np.nan), "times must be finite"),
        (np.zeros(80), "times must increase from sample to sample"),
    ],
)
def test_times_that_do_not_fit_are_refused(times, message):
    _, truth, positions = scene()
    with pytest.raises(InputError, match=message):
        errors_of_runs(Runs(positions[None], truth[None], 1.0, times), np.array([[0.5, 0.2]]))


def test_one_sample_has_no_interval():
    with pytest.raises(InputError, match="times must hold at least 2 samples"):
        errors_of_runs(Runs(np.zeros((1, 1, 1)), None, 1.0, np.zeros(1)), np.array([[0.5, 0.2]]), kinds=["innovation"])
