"""Figures of merit: against sums in plain Python over tracks with holes in them."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tracker_core import METRICS, Gains, Measurements, Metrics, Track, Truth
from tracker_core.metrics import distances, measure, measure_axes

GAINS = Gains((0.5, 0.2))
POSITION = st.floats(-1e4, 1e4)
HOLES = POSITION | st.just(math.nan)


def states(positions, derivatives=0):
    """Positions of shape (n, axes) with zeros for the derivatives."""
    positions = np.asarray(positions, dtype=float)
    return np.concatenate((positions[..., None], np.zeros((*positions.shape, derivatives))), axis=2)


def bundle(predicted, smoothed, observed, true, interval=1.0):
    predicted, smoothed, observed = (np.asarray(part, dtype=float) for part in (predicted, smoothed, observed))
    times = np.arange(len(observed)) * (interval or 1.0)
    track = Track(states(predicted, 1), states(smoothed, 1), observed - predicted, 0, None, 1e12)
    truth = None if true is None else Truth(times, states(true, 4))
    return track, Measurements(times, observed, interval), truth


def plain_errors(one, other):
    """Euclidean distances, sample by sample, where every axis of both is there."""
    found = [math.dist(p, q) for p, q in zip(one.tolist(), other.tolist(), strict=True)]
    return [d for d in found if not math.isnan(d)]


def plain_metrics(predicted, smoothed, observed, true):
    def figures(errors):
        if not errors:
            return None, None, None, None
        squares = math.fsum(e * e for e in errors)
        count = len(errors)
        return math.fsum(errors), math.sqrt(squares / count), max(errors), math.sqrt(squares) / count

    tracking, estimation = (figures(plain_errors(part, true)) for part in (predicted, smoothed))
    raw = figures(plain_errors(observed, true))[1]
    reduced = raw and estimation[1] is not None
    return {
        "tracking_total": tracking[0],
        "estimation_total": estimation[0],
        "innovation_total": figures(plain_errors(observed, predicted))[0],
        "tracking_rmse": tracking[1],
        "estimation_rmse": estimation[1],
        "observation_rmse": raw,
        "tracking_max": tracking[2],
        "estimation_max": estimation[2],
        "tracking_l2": tracking[3],
        "estimation_l2": estimation[3],
        "noise_reduction": 100 * (1 - estimation[1] / raw) if reduced else None,
    }


def assert_equal(found, expected):
    """Metric by metric: undefined in both, or the same to twelve digits (of its hundred, for the percentage)."""
    for name, value in expected.items():
        if value is None:
            assert found[name] is None, name
        else:
            least = 1e-10 if name == "noise_reduction" else 1e-150
            assert found[name] == pytest.approx(value, rel=1e-12, abs=least), name


def test_every_metric_is_described():
    assert list(METRICS) == [field.name for field in dataclasses.fields(Metrics)]


@pytest.mark.parametrize("name", METRICS)
def test_metric_has_words_unit_and_formula(name):
    metric = METRICS[name]
    assert metric.title
    assert metric.sentence.endswith((".", ")."))
    assert metric.formula
    assert metric.unit == ("%" if name == "noise_reduction" else "m")
    assert metric.lower_is_better == (name != "noise_reduction")


@given(data=st.data())
def test_metrics_are_the_plain_sums(data):
    shape = data.draw(st.tuples(st.integers(1, 12), st.integers(1, 3)))
    predicted, smoothed, observed = (data.draw(arrays(float, shape, elements=HOLES)) for _ in range(3))
    true = data.draw(arrays(float, shape, elements=POSITION))
    found = measure(*bundle(predicted, smoothed, observed, true), GAINS, stable=True).to_dict()
    assert found["lag"] == 0
    assert_equal(found, plain_metrics(predicted, smoothed, observed, true))


def test_metrics_by_hand():
    """A 3-4-5 triangle, a hit and a hole."""
    predicted = [[3, 4], [0, 0], [math.nan, 0]]
    smoothed = [[0, 2], [0, 0], [0, 1]]
    observed = [[6, 8], [0, 0], [0, 0]]
    metrics = measure(*bundle(predicted, smoothed, observed, np.zeros((3, 2))), GAINS, stable=True)
    assert metrics.tracking_total == 5
    assert metrics.tracking_rmse == math.sqrt(25 / 2)
    assert metrics.tracking_max == 5
    assert metrics.tracking_l2 == 5 / 2
    assert metrics.estimation_total == 3
    assert metrics.estimation_rmse == math.sqrt(5 / 3)
    assert metrics.estimation_max == 2
    assert metrics.estimation_l2 == pytest.approx(math.sqrt(5) / 3, rel=1e-15, abs=0)
    assert metrics.innovation_total == 5
    assert metrics.observation_rmse == math.sqrt(100 / 3)
    assert metrics.noise_reduction == pytest.approx(100 * (1 - math.sqrt(5 / 100)), rel=1e-14, abs=0)


@given(data=st.data())
def test_axes_are_measured_each_for_itself(data):
    shape = (8, data.draw(st.integers(1, 3)))
    predicted, smoothed, observed = (data.draw(arrays(float, shape, elements=HOLES)) for _ in range(3))
    true = data.draw(arrays(float, shape, elements=POSITION))
    per_axis = measure_axes(*bundle(predicted, smoothed, observed, true), GAINS, stable=True)
    assert len(per_axis) == shape[1]
    for axis, metrics in enumerate(per_axis):
        part = [array[:, [axis]] for array in (predicted, smoothed, observed, true)]
        assert_equal(metrics.to_dict(), plain_metrics(*part))


@given(data=st.data())
def test_squares_of_the_axes_add_up(data):
    true = data.draw(arrays(float, (10, 2), elements=POSITION))
    smoothed = data.draw(arrays(float, (10, 2), elements=POSITION))
    parts = bundle(true, smoothed, true, true)
    joint = measure(*parts, GAINS, stable=True).estimation_rmse
    axes = [metrics.estimation_rmse for metrics in measure_axes(*parts, GAINS, stable=True)]
    assert joint == pytest.approx(math.hypot(*axes), rel=1e-12, abs=1e-150)


def test_without_a_truth_only_the_innovation_remains():
    metrics = measure(*bundle([[1.0], [2.0]], [[1.0], [2.0]], [[2.0], [4.0]], None), GAINS, stable=True).to_dict()
    assert metrics.pop("innovation_total") == 3
    assert set(metrics.values()) == {None}


def test_without_noise_there_is_nothing_to_reduce():
    true = np.ones((4, 1))
    metrics = measure(*bundle(true + 1, true + 1, true, true), GAINS, stable=True)
    assert metrics.observation_rmse == 0
    assert metrics.noise_reduction is None


def test_a_filter_worse_than_its_sensor_reduces_negatively():
    true = np.zeros((4, 1))
    assert measure(*bundle(true, true + 3, true + 2, true), GAINS, stable=True).noise_reduction == -50


@pytest.mark.parametrize(("gains", "derivative"), [((0.2, 0.1), 2), ((0.5, 0.4, 0.1), 3), ((0.5, 0.4, 0.1, 0.01), 4)])
def test_lag_is_that_under_the_rms_of_the_first_unmodelled_derivative(gains, derivative):
    track, measurements, truth = bundle(np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 2)), 5.0)
    # Lengths 5 and 13 over the axes: the root mean square is sqrt((25 + 169)/2).
    truth.states[:, :, derivative] = [[3, 4], [5, 12]]
    lag = measure(track, measurements, truth, Gains(gains), stable=True).lag
    expected = (1 - gains[0]) * 5**derivative * math.sqrt(97) / gains[-1]
    assert lag == pytest.approx(expected, rel=1e-14, abs=0)
    assert measure(track, measurements, truth, Gains(gains), stable=False).lag is None
    varying = Measurements(measurements.times, measurements.positions, None)
    assert measure(track, varying, truth, Gains(gains), stable=True).lag is None


def test_distances_are_euclidean_and_keep_holes():
    assert distances(np.array([[3.0, -4.0], [0.0, math.nan]])).tolist()[0] == 5
    assert math.isnan(distances(np.array([[0.0, math.nan]]))[0])
    assert distances(np.array([[-2.0], [0.5]])).tolist() == [2, 0.5]
    assert distances(np.array([[2.0, 3.0, -6.0]])).tolist() == [7]


def test_what_a_gate_refused_counts_among_the_errors_but_not_among_the_innovations():
    predicted, observed = np.array([[1.0], [1.0], [2.0]]), np.array([[2.0], [51.0], [4.0]])
    track, measurements, truth = bundle(predicted, predicted, observed, np.zeros((3, 1)))
    gated = dataclasses.replace(track, rejected=np.array([False, True, False]), spread=np.ones((3, 1)))
    metrics = measure(gated, measurements, truth, GAINS, stable=True)
    assert metrics.innovation_total == 3
    assert metrics.observation_rmse == math.sqrt((4 + 51**2 + 16) / 3)
    assert metrics.tracking_total == 4
    assert measure_axes(gated, measurements, truth, GAINS, stable=True) == (metrics,)
    others = dataclasses.replace(metrics, innovation_total=53)
    assert measure(track, measurements, truth, GAINS, stable=True) == others


def test_a_truth_that_is_not_a_number_is_none():
    parts = bundle([[1.0], [2.0]], [[1.0], [2.0]], [[2.0], [4.0]], np.full((2, 1), math.nan))
    parts[2].states[:] = math.nan
    assert measure(*parts, GAINS, stable=True) == measure(*parts[:2], None, GAINS, stable=True)
