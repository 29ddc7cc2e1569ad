"""Steady lag: the closed form against a filter that has been running for long."""

import math

import numpy as np
import pytest

from tracker_core import Experiment, Gains, Measurements, run_experiment, run_filter
from tracker_core.analysis import steady_lag

# With poles near one half, what is left of the start after sixty samples is below the rounding error.
GAINS = {2: (0.7, 0.3), 3: (0.875, 0.5625, 0.125), 4: (0.9375, 0.8542, 0.375, 0.0625)}


@pytest.mark.parametrize("order", GAINS)
@pytest.mark.parametrize("interval", [0.5, 3.0])
@pytest.mark.parametrize("derivative", [4.0, -0.25])
def test_steady_lag_is_where_a_long_run_settles(order, interval, derivative):
    """Under a constant input of the first derivative that the filter does not model."""
    times = np.arange(-80, 41) * interval
    truth = derivative * times**order / math.factorial(order)
    track = run_filter(Measurements(times, truth[:, None], interval), Gains(GAINS[order]), start="two-point")
    gains = Gains(GAINS[order])
    predicted_lag = truth - track.predicted[:, 0, 0]
    smoothed_lag = truth - track.smoothed[:, 0, 0]
    # Near time zero the positions are small, so that no digits of the difference are lost.
    assert predicted_lag[80:85] == pytest.approx(
        steady_lag(gains, interval, derivative, predicted=True), rel=1e-10, abs=0
    )
    assert smoothed_lag[80:85] == pytest.approx(steady_lag(gains, interval, derivative), rel=1e-10, abs=0)


@pytest.mark.parametrize(
    ("gains", "interval", "derivative", "predicted", "smoothed"),
    [
        # T^2 A/beta and (1 - alpha) of it; T^3 J/g2 and (1 - alpha) of it; T^4 S/g3 and (1 - alpha) of it.
        (Gains((0.2, 0.1)), 5.0, 8.0, 2000.0, 1600.0),
        (Gains((0.5, 0.4, 0.1), "taylor"), 5.0, 0.3, 187.5, 93.75),
        (Gains((0.5, 0.4, 0.1, 0.01)), 2.0, 0.05, 80.0, 40.0),
    ],
    ids=["order-2", "order-3", "order-4"],
)
def test_steady_lag_by_hand(gains, interval, derivative, predicted, smoothed):
    assert steady_lag(gains, interval, derivative, predicted=True) == pytest.approx(predicted, rel=1e-14, abs=0)
    assert steady_lag(gains, interval, derivative) == pytest.approx(smoothed, rel=1e-14, abs=0)


@pytest.mark.parametrize("predicted", [False, True])
@pytest.mark.parametrize("derivative", [1.0, -1.0])
def test_the_lag_of_a_vanishing_gain_is_infinite(derivative, predicted):
    """Beta 1e-320 is stable, and its lag overflows: to infinity with its sign, without a warning."""
    lag = steady_lag(Gains((0.5, 1e-320)), 1.0, derivative, predicted=predicted)
    assert type(lag) is float
    assert lag == math.copysign(math.inf, derivative)


def test_an_infinite_lag_is_no_figure_of_merit():
    """JSON has no number for it."""
    result = run_experiment(Experiment.from_dict({"alpha": 0.5, "beta": 1e-320}))
    assert result.verdict.stable
    assert [metrics.lag for metrics in (result.metrics, *result.axis_metrics())] == [None] * 3


@pytest.mark.parametrize("order", GAINS)
def test_a_motion_that_the_filter_models_leaves_no_lag(order):
    times = np.arange(-80.0, 41)
    truth = times ** (order - 1)
    track = run_filter(Measurements(times, truth[:, None], 1.0), Gains(GAINS[order]), start="two-point")
    assert track.innovation[75:, 0] == pytest.approx(0, abs=1e-9)


def test_a_filter_that_follows_its_measurements_does_not_lag():
    assert steady_lag(Gains((1.0, 1e-320)), 1.0, 1.0) == 0.0
    assert steady_lag(Gains((0.5, 0.1)), 1e200, 1.0) == float("inf")
