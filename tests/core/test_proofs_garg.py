"""The proofs about Garg, by another calculation."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from tests.core.proof_checks import (
    TRANSITION,
    assert_close,
    keep,
    numbers,
    values,
)
from tracker_core.papers import papers
from tracker_core.papers.proofs import prove
from tracker_core.run import observe


def aircraft(run, g, state, steps=None):
    """Predicted and smoothed positions on the recorded ranges, or others; g as eq. 2 gamma/T^2 writes them."""
    truth, measurements, _ = observe(papers()["garg2021"].run(run).experiment)
    z = measurements.positions[:, 0] if steps is None else steps
    state, predicted, smoothed = list(state) + [0.0] * (3 - len(state)), [], []
    a, b, c = (*g, 0.0)[:3]
    for measured in z:
        x, v, w = state[0] + 5 * state[1] + 12.5 * state[2], state[1] + 5 * state[2], state[2]
        e = measured - x
        predicted.append(x)
        state = [x + a * e, v + b * e / 5, w + 2 * c * e / 25]
        smoothed.append(state[0])
    return truth.positions[:, 0], np.array(predicted), np.array(smoothed)


def test_garg_start():
    for speed in (40.0, 50.0):
        _, _, smoothed = aircraft("accelerating-earlier", (0.5, 0.4, 0.1), (30_000.0, speed))
        assert_close(values("garg-start", f"started with {speed:g}"), smoothed[:3], 1)
    # 30,000 + 5 · 50 = 30,250 is predicted, 30,160 measured.
    assert values("garg-start", "started with 50")[0] == (30_250 + 30_160) / 2


def test_garg_lag():
    times = 5.0 * np.arange(1, 400)
    for alpha in (0.5, 0.8, 0.95, 0.99):
        beta = alpha**2 / (2 - alpha)
        z = 30_000 + 4 * times**2
        _, predicted, smoothed = aircraft("accelerating", (alpha, beta), (30_000.0, 0.0), z)
        assert_close(values("garg-lag", f"α = {alpha}:"), [z[-1] - smoothed[-1], z[-1] - predicted[-1]], 1)
    true, predicted, smoothed = aircraft("accelerating", (0.95, 0.95**2 / 1.05), (30_000.0, 50.0))
    found = [np.sqrt(np.mean((one - true) ** 2)) for one in (smoothed, predicted)]
    assert_close(values("garg-lag", "recorded, α = 0.95")[:2], found, 1)


def test_garg_precision(steady_kalman):
    name = "garg-precision"
    for place, order in enumerate((2, 3)):
        drive = values(name, "Λ at which")[place] * np.array([1 / 2, 1, 1])[:order]
        assert steady_kalman(np.outer(drive, drive))[0] == pytest.approx(0.5, abs=1e-3)
    drive = np.array([25 / 2, 5.0])
    for sensor, title in ((1.0, "precise sensor"), (100.0, "poor sensor")):
        for process, target in ((0.001, "steady"), (8.0, "manoeuvring")):
            gains = steady_kalman(process**2 * np.outer(drive, drive), sensor**2, 5.0)
            (found,) = [text for label, text in prove(name).lines if title in label and target in label]
            assert_close(numbers(found)[-1], gains[0], 3)
    for alpha, left in zip((0.1, 0.3, 0.5, 0.7, 0.9), values(name, "no manoeuvre")[-5:], strict=True):
        g = np.array([alpha, 2 * (2 - alpha) - 4 * sqrt(1 - alpha)])
        p = solve_discrete_lyapunov(keep(g) @ TRANSITION[2], np.outer(g, g))
        assert_close(left, p[0, 0], 3)


def test_garg_gamma():
    name = "garg-gamma"
    for run, title in (("accelerating", "later"), ("accelerating-earlier", "earlier")):
        (label,) = [label for label, _ in prove(name).lines if label.startswith(f"{title} ranges")]
        found = []
        for gamma in numbers(label):
            true, _, smoothed = aircraft(run, (0.5, 0.4, gamma), (30_000.0, 50.0))
            found.append(np.sqrt(np.mean((smoothed - true) ** 2)))
        assert_close(values(name, f"{title} ranges"), found, 1)
        best = numbers(label)[-1]
        for beside in (best - 0.002, best + 0.002):
            true, _, smoothed = aircraft(run, (0.5, 0.4, beside), (30_000.0, 50.0))
            assert np.sqrt(np.mean((smoothed - true) ** 2)) > found[-1]
    poles = np.abs(np.linalg.eigvals(TRANSITION[3] @ keep((0.5, 0.4, 2 * 0.263))))
    assert_close(values(name, "largest pole")[-1], poles.max(), 3)
    border = np.abs(np.linalg.eigvals(TRANSITION[3] @ keep((0.5, 0.4, 2 * 0.2 / 1.5))))
    assert border.max() == pytest.approx(1)
    assert_close(values(name, "γ below")[-1], 0.2 / 1.5, 4)
