"""Filters side by side: the same bits whatever fills the lanes, and the errors of every track alone."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker_core import DESIGNS, Gains, InputError, Measurements, run_filter
from tracker_core.adaptive.growing_memory import growing_gains
from tracker_core.batch import FIGURES, KINDS, Runs, errors_of_runs
from tracker_core.kernels.steps import LANES
from tracker_core.openings import opening
from tracker_core.starts import STARTS

INTERVAL = 0.7
SETS = [DESIGNS["fading-memory"].gains(order, xi=xi) for xi in (0.35, 0.6, 0.85) for order in (2, 3, 4)]
STARTS_OF_ALL = [name for name, start in STARTS.items() if start.least_order == 2]


def scene(count, axes=2, samples=50, *, own_truth=False, gaps="none", seed=0):
    """Runs of targets that weave; with gaps after the start, or at the start of some runs too."""
    rng = np.random.default_rng(seed)
    times = np.arange(samples) * INTERVAL
    phases = rng.uniform(0, 6, (count if own_truth else 1, 1, axes))
    truth = 300 * np.sin(0.2 * times[None, :, None] + phases) + 20 * times[None, :, None]
    positions = truth + 5 * rng.standard_normal((count, samples, axes))
    if gaps != "none":
        positions[::3, 20:24] = np.nan
        positions[1::2, 30, -1] = np.nan
    if gaps == "start":
        positions[::5, 0] = np.nan
        positions[2::5, 1:3, 0] = np.nan
    return Runs(positions, truth, INTERVAL)


def before(count, axes):
    """Initial states of every run."""
    return np.random.default_rng(9).normal(scale=10, size=(count, axes, 4))


def alone(runs, gains, start="two-point", state=None, limit=1e12):
    """Figures of one gain set in every run, shape (runs, kinds, figures), from its tracks."""
    rows = []
    for run, z in enumerate(runs.positions):
        measurements = Measurements(np.arange(len(z)) * runs.interval, z, runs.interval)
        given_state = None if state is None else state[run, :, : len(gains)]
        track = run_filter(measurements, Gains.normalised(gains), start=start, initial_state=given_state, limit=limit)
        true = runs.truth[run % len(runs.truth)]
        row = []
        for difference in (track.predicted[:, :, 0] - true, track.smoothed[:, :, 0] - true, track.innovation):
            errors = np.sqrt((difference**2).sum(axis=1))
            errors = errors[~np.isnan(errors)]
            if track.stopped_at is not None or not len(errors):
                row.append([np.nan] * 4)
                continue
            norm = np.sqrt((errors**2).sum())
            row.append([errors.sum(), norm / np.sqrt(len(errors)), errors.max(), norm / len(errors)])
        rows.append(row)
    return np.array(rows)


def stacked(found):
    """Shape (sets, runs, kinds, figures)."""
    return np.stack([np.stack([found[kind].figures[name] for name in FIGURES], axis=-1) for kind in KINDS], axis=2)


@pytest.mark.parametrize("gaps", ["none", "later", "start"])
@pytest.mark.parametrize("own_truth", [False, True], ids=["one-truth", "own-truths"])
@pytest.mark.parametrize("start", STARTS_OF_ALL)
def test_every_lane_has_the_errors_of_its_track(start, own_truth, gaps):
    runs = scene(12, own_truth=own_truth, gaps=gaps)
    state = before(12, 2) if start == "known" else None
    found = stacked(errors_of_runs(runs, SETS, start=start, initial_state=state))
    for row, gains in zip(found, SETS, strict=True):
        np.testing.assert_allclose(row, alone(runs, gains, start, state), rtol=1e-12)


@pytest.mark.parametrize("order", [3, 4])
@pytest.mark.parametrize("gaps", ["none", "start"])
def test_the_start_by_three_points(order, gaps):
    runs, sets = scene(6, gaps=gaps), [gains for gains in SETS if len(gains) == order]
    found = stacked(errors_of_runs(runs, sets, start="three-point"))
    for row, gains in zip(found, sets, strict=True):
        np.testing.assert_allclose(row, alone(runs, gains, "three-point"), rtol=1e-12)


@pytest.mark.parametrize("count", [1, LANES - 1, LANES, LANES + 1])
@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("gaps", ["none", "later", "start"])
def test_gain_sets_or_runs_in_the_lanes_give_the_same_bits(count, axes, gaps):
    """All runs at once put runs into the lanes, each for itself gain sets, and all gain sets there are."""
    runs = scene(count, axes, samples=41, gaps=gaps)
    together = stacked(errors_of_runs(runs, SETS, start="expanding"))
    for run in range(0, count, 7):
        one = replace(runs, positions=runs.positions[run : run + 1])
        assert np.array_equal(stacked(errors_of_runs(one, SETS, start="expanding"))[:, 0], together[:, run])


@pytest.mark.parametrize("count", [1, LANES - 1, LANES, LANES + 1, 3 * LANES])
def test_neighbours_do_not_matter(count):
    """A gain set has the same errors alone as among others."""
    runs, sets = scene(1), np.random.default_rng(3).uniform(0.05, 0.6, (count, 3))
    together = stacked(errors_of_runs(runs, sets))
    for index in {0, count // 2, count - 1}:
        assert np.array_equal(stacked(errors_of_runs(runs, sets[[index]]))[0], together[index], equal_nan=True)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("figure", FIGURES)
def test_what_is_asked_for_does_not_change_it(kind, figure):
    """In particular where several samples are taken at once: estimation errors without their sum."""
    runs = scene(3, gaps="later")
    found = errors_of_runs(runs, SETS, kinds=[kind], figures=[figure])
    assert set(found) == {kind}
    assert set(found[kind].figures) == {figure}
    assert np.array_equal(getattr(found[kind], figure), getattr(errors_of_runs(runs, SETS)[kind], figure))
    with pytest.raises(KeyError):
        _ = found[kind].total if figure != "total" else found[kind].rmse


def test_a_truth_of_every_run_that_is_the_same_is_one_truth():
    runs = scene(LANES + 3, gaps="start")
    same = replace(runs, truth=np.repeat(runs.truth, len(runs.positions), axis=0))
    assert np.array_equal(stacked(errors_of_runs(runs, SETS)), stacked(errors_of_runs(same, SETS)))


@pytest.mark.parametrize("many", [False, True], ids=["sets", "runs"])
@pytest.mark.parametrize("limit", [200.0, 700.0, 760.0, 1e3, 1e6, 1e12])
def test_a_position_beyond_the_limit_leaves_no_figure(limit, many):
    """Limits within reach of good filters, where every position decides, and out of it; one filter diverges."""
    runs = scene(LANES if many else 4, samples=45)
    sets = [*SETS[:2], np.array([1.9, 3.9])]
    found = stacked(errors_of_runs(runs, sets, limit=limit))
    for row, gains in zip(found, sets, strict=True):
        expected = alone(runs, gains, limit=limit)
        assert np.array_equal(np.isnan(row), np.isnan(expected))
        np.testing.assert_allclose(row, expected, rtol=1e-9)
    assert np.isnan(found[-1]).all()


def test_a_filter_that_overflows_stops():
    found = stacked(errors_of_runs(scene(2, samples=2_000), np.array([[0.5, 30.0], [0.5, 0.2]]), limit=1e300))
    assert np.isnan(found[0]).all()
    assert np.isfinite(found[1]).all()


def test_positions_too_great_to_be_added_up_pass_the_limit_and_no_check():
    found = errors_of_runs(Runs(np.full((2, 30, 1), 1e308), np.zeros((1, 30, 1)), 1.0), SETS)
    assert all(np.isnan(errors.rmse).all() for errors in found.values())


def test_innovations_need_no_truth():
    runs = scene(5, gaps="later")
    blind = errors_of_runs(replace(runs, truth=None), SETS, kinds=["innovation"])
    seeing = errors_of_runs(runs, SETS)["innovation"]
    assert all(np.array_equal(blind["innovation"].figures[name], seeing.figures[name]) for name in FIGURES)
    with pytest.raises(InputError, match="kinds must be innovation alone"):
        errors_of_runs(replace(runs, truth=None), SETS)


@settings(max_examples=25)
@given(
    scale=st.sampled_from([-4.0, 0.25, 2.0]), shift=st.floats(-100, 100), seed=st.integers(0, 99),
    start=st.sampled_from([name for name in STARTS_OF_ALL if name != "known"]),
)  # fmt: skip
def test_errors_follow_the_scale_and_not_the_place(scale, shift, seed, start):
    """The filter is linear, and does not know where the origin is."""
    runs = scene(3, samples=40, gaps="start", seed=seed)
    moved = Runs(scale * runs.positions + shift, scale * runs.truth + shift, INTERVAL)
    first, second = (stacked(errors_of_runs(some, SETS, start=start)) for some in (runs, moved))
    np.testing.assert_allclose(second, abs(scale) * first, rtol=1e-9)


# Refusals ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": np.zeros((3, 4))}, "positions must have shape"),
        ({"positions": np.full((2, 9, 1), np.inf)}, "positions must be finite or NaN"),
        ({"truth": np.zeros((3, 50, 2))}, "truth must have shape"),
        ({"truth": np.full((1, 50, 2), np.inf)}, "truth must be finite, or NaN where nobody knows it"),
        ({"truth": np.full((1, 50, 2), np.nan)}, "kinds must be innovation alone where the truth is not known"),
        ({"interval": 0.0}, "interval must be"),
        ({"positions": np.full((2, 50, 2), np.nan)}, "positions must hold at least 2 measurements"),
    ],
)
def test_runs_that_do_not_fit_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        errors_of_runs(replace(scene(2), **change), SETS)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"start": "three-point"}, "start must not be 'three-point' for a filter of order 2"),
        ({"start": "known"}, "initial_state must be given"),
        ({"start": "known", "initial_state": np.zeros((2, 3))}, "initial_state must have shape"),
        ({"start": "known", "initial_state": np.zeros((3, 2, 4))}, "initial_state must have shape"),
        ({"start": "known", "initial_state": np.full((2, 2, 4), np.nan)}, "initial_state must be finite"),
        ({"kinds": ["bias"]}, "kinds must be one of"),
        ({"figures": ["mean"]}, "figures must be one of"),
        ({"limit": 0}, "limit must be"),
    ],
)
def test_questions_that_make_no_sense_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        errors_of_runs(scene(2), SETS, **options)


# How filters start -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [2, 3, 4])
def test_an_expanding_memory_opens_with_the_gains_of_least_squares(order):
    """Those of a formula, up to the gain at which the filter takes over."""
    found = opening("expanding", order, np.ones(400, dtype=bool), 0.05)
    expected = growing_gains(order, np.arange(1, 401))
    length = int(np.argmax(expected[:, 0] <= 0.05))
    assert len(found.gains) == len(found.until) == length
    np.testing.assert_allclose(found.gains, expected[:length], rtol=1e-9)
    assert (np.diff(found.until[1:]) <= 0).all()
