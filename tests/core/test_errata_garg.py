"""What the errata of Garg say, worked out without the recipes and the proofs."""

from math import sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.core.oracles import garg_filter, radius

RANGES = {
    "accelerating-earlier": "30160 30365 30890 31050 31785 32215 33130 34510 36010 37265",
    "accelerating": "30221 30453 30906 30999 31368 31978 32526 33379 34698 36275",
}


def test_garg_start():
    for speed, wanted in ((50, [30205, 30387.5, 30721]), (40, [30180, 30362.5, 30713.5])):
        ranges = [float(z) for z in RANGES["accelerating-earlier"].split()]
        rows = garg_filter(ranges, speed, 0.5, 0.4, 0.1)
        assert [row["x"] for row in rows[:3]] == pytest.approx(wanted, rel=1e-12)


def aircraft(times, onset):
    return 30_000 + 50 * times + 4 * np.maximum(times - onset, 0) ** 2


@pytest.mark.parametrize(
    ("alpha", "smoothed", "predicted"), [(0.5, 600, 1200), (0.8, 75, 375), (0.95, 11.6, 233), (0.99, 2.1, 206)]
)
def test_garg_lag(alpha, smoothed, predicted):
    truth = aircraft(5.0 * np.arange(1, 401), 20)
    last = garg_filter(truth, 50.0, alpha, alpha**2 / (2 - alpha), 0.0)[-1]
    assert truth[-1] - last["x"] == pytest.approx(smoothed, abs=0.05)
    assert truth[-1] - last["before"] == pytest.approx(predicted, abs=0.5)


def garg_rmse(name, onset, alpha=0.5, beta=0.4, gamma=0.1):
    ranges = [float(z) for z in RANGES[name].split()]
    truth = aircraft(5.0 * np.arange(1, 11), onset)
    rows = garg_filter(ranges, 50.0, alpha, beta, gamma)
    return np.sqrt(np.mean((np.array([row["x"] for row in rows]) - truth) ** 2))


def test_garg_estimate_near_one_is_the_measurement():
    truth = aircraft(5.0 * np.arange(1, 11), 20)
    raw = np.sqrt(np.mean((np.array(RANGES["accelerating"].split(), dtype=float) - truth) ** 2))
    assert raw == pytest.approx(115, abs=0.5)
    assert garg_rmse("accelerating", 20, 0.95, 0.95**2 / 1.05, 0) == pytest.approx(114, abs=0.5)


@pytest.mark.parametrize(
    ("name", "onset", "best", "figures"),
    [
        ("accelerating", 20, 0.263, {0.1: 176.5, 0.263: 146.0, 0.1333: 164}),
        ("accelerating-earlier", 15, 0.28, {0.1: 151.7, 0.28: 78.4, 0.1333: 134}),
    ],
)
def test_garg_larger_gamma_over_ten_samples(name, onset, best, figures):
    for gamma, wanted in figures.items():
        assert garg_rmse(name, onset, gamma=gamma) == pytest.approx(wanted, abs=0.5)
    grid = np.arange(0.1, 1, 0.001)
    assert grid[np.argmin([garg_rmse(name, onset, gamma=gamma) for gamma in grid])] == pytest.approx(best, abs=1e-9)
    assert garg_rmse(name, onset, alpha=0.8) == pytest.approx({20: 121, 15: 127}[onset], abs=0.5)


def test_garg_larger_gamma_is_unstable():
    assert radius((0.5, 0.4, 2 * 0.1333)) < 1 < radius((0.5, 0.4, 2 * 0.1334))
    assert radius((0.5, 0.4, 2 * 0.263)) == pytest.approx(1.14, abs=5e-3)
    assert radius((0.8, 0.4, 2 * 0.1)) < 1
    truth = aircraft(5.0 * np.arange(1, 41), 20)
    for gamma, wanted in ((0.1, 78), (0.263, 3_250)):
        smoothed = np.array([row["x"] for row in garg_filter(truth, 50.0, 0.5, 0.4, gamma)])
        assert np.sqrt(np.mean((smoothed - truth) ** 2)) == pytest.approx(wanted, rel=6e-3)


def test_garg_alpha_one_half():
    """Kalata's damping parameter r is sqrt(1/2) there; for three states the steady Riccati gain."""
    index = brentq(lambda at: (4 + at - sqrt(8 * at + at**2)) / 4 - sqrt(0.5), 0.01, 1)
    assert index == pytest.approx(0.243, abs=5e-4)
    assert index < 1 * 5**2 / 100
    f, g, p = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]]), 0.0416 * np.array([0.5, 1, 1]), np.eye(3)
    for _ in range(5000):
        p = f @ p @ f.T + np.outer(g, g)
        gain = p[:, 0] / (p[0, 0] + 1)
        p = p - np.outer(gain, p[0])
    assert gain[0] == pytest.approx(0.5, abs=2e-4)
