"""The searches of Yu & Wu 2017: the choices of a plain loop, bit for bit; ties, the parabola, and the run."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tracker_core import Gains, Measurements, Truth, run_filter
from tracker_core.adaptive import METHODS
from tracker_core.adaptive.parameters import BOUNDS, END_POINTS
from tracker_core.adaptive.sample_search import candidates
from tracker_core.types import GAIN_NAMES, STATE_NAMES

SEARCH, RUN = METHODS["sample-search"], METHODS["run-search"]
ORDERS = [3, 4]


def scene(seed, samples=40, axes=1, interval=0.5):
    """A target that weaves, and noisy measurements of it."""
    times = np.arange(samples) * interval
    states = np.zeros((samples, axes, 5))
    for axis in range(axes):
        rate = 0.4 + 0.2 * axis
        for k in range(5):
            states[:, axis, k] = 100 * rate**k * np.sin(rate * times + k * np.pi / 2)
    noise = np.random.default_rng(seed).normal(size=(samples, axes)) * 10
    return Truth(times, states), Measurements(times, states[:, :, 0] + noise, interval)


# The search at every sample ----------------------------------------------------------------------------------------


def plain_search(z, t, truth, which, sets, last, state):
    """Gains and smoothed states of every sample: all sets are tried, one is kept."""
    order, gains, states = len(state), [], []
    for measured, target in zip(z, truth, strict=True):
        x = [*state, 0.0][:4]
        x = [x[0] + t * x[1] + t * t / 2 * x[2] + t * t / 2 * t / 3 * x[3],
             x[1] + t * x[2] + t * t / 2 * x[3], x[2] + t * x[3], x[3]][:order]  # fmt: skip
        e = measured - x[0]
        if not math.isnan(e):
            steps = [e, e / t, e / t / t, e / t / t / t]
            errors = [abs(x[which] + g[which] * steps[which] - target) for g in sets]
            least = min(errors)
            best = max(k for k in range(len(sets)) if errors[k] == least) if last else errors.index(least)
            gains.append(sets[best])
            x = [x[i] + sets[best][i] * steps[i] for i in range(order)]
        else:
            gains.append([math.nan] * order)
        state = x
        states.append(x)
    return gains, states


CHOICES = [
    pytest.param(order, end_points, bound, ties, id=f"{order}-{end_points}-{bound}-{ties}")
    for order in ORDERS
    for end_points in END_POINTS
    for bound in BOUNDS
    for ties in ("first", "last")
]


@pytest.mark.parametrize(("order", "end_points", "bound", "ties"), CHOICES)
@settings(max_examples=8)
@given(data=st.data())
def test_chooses_what_a_plain_loop_chooses_bit_for_bit(order, end_points, bound, ties, data):
    z = data.draw(arrays(float, 12, elements=st.floats(-1e3, 1e3) | st.just(math.nan)))
    objective = data.draw(st.sampled_from(STATE_NAMES[:order]))
    interval = data.draw(st.sampled_from([0.125, 0.7, 1.0, 3.0]))
    which = STATE_NAMES.index(objective)
    truth, _ = scene(data.draw(st.integers(0, 9)), 12, interval=interval)
    state = [1.0, -2.0, 0.5, 0.25][:order]
    selection = SEARCH.run(
        Measurements(truth.times, z[:, None], interval), order, truth=truth, start="known",
        initial_state=np.array([state]), limit=1e300, grid=4, grid_eta=3, end_points=end_points, bound=bound,
        ties=ties, objective=objective,
    )  # fmt: skip
    sets, _ = candidates(order, 4, 3, end_points, bound)
    gains, states = plain_search(
        z.tolist(), interval, truth.states[:, 0, which].tolist(), which, sets.tolist(), ties == "last", state
    )
    assert np.array_equal(selection.gains[:, 0], np.array(gains), equal_nan=True)
    assert np.array_equal(selection.track.smoothed[:, 0], np.array(states))


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("objective", STATE_NAMES)
def test_the_error_depends_on_one_gain_alone(order, objective):
    """All sets with the same value of that gain are equally good: the first or the last of them is taken."""
    which = STATE_NAMES.index(objective)
    if which >= order:
        return
    truth, measurements = scene(1, 60)
    sets, levels = candidates(order, 4, 6, "interior", "exact")
    place = {tuple(row): k for k, row in enumerate(sets.tolist())}
    for ties, pick in (("first", min), ("last", max)):
        used = SEARCH.run(measurements, order, truth=truth, ties=ties, objective=objective).gains[2:, 0]
        for row in used.tolist():
            same = [k for k in range(len(sets)) if sets[k, which] == row[which]]
            assert place[tuple(row)] == pick(same)
    # By level of gamma, alpha, beta, eta.
    ordered = levels[:, [2, 0, 1, 3][:order]].tolist()
    assert ordered == sorted(ordered)


@pytest.mark.parametrize("order", ORDERS)
def test_ties_do_not_change_what_the_objective_is_about(order):
    """Where the two rules part for the first time the acceleration is the same, other states are not."""
    truth, measurements = scene(5)
    first, last = (SEARCH.run(measurements, order, truth=truth, ties=ties) for ties in ("first", "last"))
    parted = 2 + int((first.gains[2:, 0] != last.gains[2:, 0]).any(axis=1).argmax())
    one, other = (selection.track.smoothed[parted, 0] for selection in (first, last))
    assert one[2] == other[2]
    assert (one != other).any()


# The parabola ------------------------------------------------------------------------------------------------------


def vertex(points):
    """Where the parabola through three points is least, from its coefficients."""
    (x1, f1), (x2, f2), (x3, f3) = points
    a, b, _ = np.linalg.solve(np.array([[x * x, x, 1.0] for x in (x1, x2, x3)]), np.array([f1, f2, f3]))
    return -b / (2 * a)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("bound", ["exact", "triangle"])
@pytest.mark.parametrize("objective", ["position", "velocity", "acceleration"])
def test_the_parabola_moves_the_one_gain_that_matters(order, bound, objective):
    """Sample by sample, from the prediction that the run itself made."""
    which = STATE_NAMES.index(objective)
    truth, measurements = scene(order, 60)
    selection = SEARCH.run(measurements, order, truth=truth, bound=bound, objective=objective, parabola="printed")
    sets, levels = candidates(order, 4, 6, "interior", bound)
    place = {tuple(row): k for k, row in enumerate(levels.tolist())}
    stop = selection.track.stopped_at or 60
    moved = 0
    for i in range(2, stop):
        e, base = selection.track.innovation[i, 0], selection.track.predicted[i, 0, which]
        error = np.abs(base + sets[:, which] * (e / 0.5**which) - truth.states[i, 0, which])
        best = int(error.argmin())
        expected = sets[best].copy()
        beside = [levels[best].tolist() for _ in range(2)]
        beside[0][which] -= 1
        beside[1][which] += 1
        if all(tuple(row) in place for row in beside):
            low, high = (place[tuple(row)] for row in beside)
            if error[best] <= min(error[low], error[high]):
                expected[which] = vertex([(sets[k, which], error[k]) for k in (low, best, high)])
                moved += 1
        assert selection.gains[i, 0] == pytest.approx(expected, rel=1e-9, abs=0)
    assert moved > 0 or (order, bound) == (4, "exact")


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("which", [0, 1], ids=["alpha", "beta"])
def test_a_parabola_in_another_gain_would_be_flat(order, which):
    """Eq. 25-26 in alpha or beta: the error of the acceleration is that of gamma, which may be kept while they move."""
    truth, measurements = scene(2)
    selection = SEARCH.run(measurements, order, truth=truth)
    used = selection.gains[10, 0]
    e, base = selection.track.innovation[10, 0], selection.track.predicted[10, 0]
    errors = []
    for shift in (-0.1, 0.0, 0.1):
        gains = used.copy()
        gains[which] += shift
        state = base + gains * e / 0.5 ** np.arange(order)
        errors.append(abs(state[2] - truth.states[10, 0, 2]))
    assert errors[0] == errors[1] == errors[2]


# The search for the run --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("objective", ["position", "velocity", "acceleration"])
@pytest.mark.parametrize("bound", BOUNDS)
def test_the_run_is_searched_as_by_brute_force(order, objective, bound):
    which = STATE_NAMES.index(objective)
    truth, measurements = scene(order, 50, axes=2)
    measurements.positions[[9, 10], 1] = np.nan
    options = {"grid": 2, "grid_eta": 2, "bound": bound, "end_points": "middle"}
    selection = RUN.run(measurements, order, truth=truth, objective=objective, **options)
    sets, _ = candidates(order, 2, 2, "middle", bound)
    errors = []
    for gains in sets.tolist():
        track = run_filter(measurements, Gains(tuple(gains)))
        error = track.smoothed[2:, :, which] - truth.states[2:, :, which]
        errors.append(np.inf if track.stopped_at is not None else (error**2).sum())
    best = int(np.argmin(errors))
    assert sorted(errors)[1] > errors[best] * (1 + 1e-9)
    assert [selection.found[name][0] for name in GAIN_NAMES[:order]] == sets[best].tolist()
    track = run_filter(measurements, Gains(tuple(sets[best].tolist())))
    assert np.array_equal(selection.track.smoothed, track.smoothed, equal_nan=True)
    assert (selection.gains[2:, 0] == sets[best]).all()


def test_ties_of_a_run_are_broken_by_rule():
    """Where all is still every set is as good as any other."""
    truth = Truth(np.arange(20.0), np.zeros((20, 1, 5)))
    measurements = Measurements(truth.times, np.zeros((20, 1)), 1.0)
    sets, _ = candidates(3, 4, 6, "interior", "exact")
    for ties, place in (("first", 0), ("last", -1)):
        for method in (RUN, SEARCH):
            gains = method.run(measurements, 3, truth=truth, ties=ties).gains
            assert (gains[2:, 0] == sets[place]).all()
