"""Oracles that several test files share: textbook forms, none of which calls the code under test."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import settings
from scipy.linalg import solve_discrete_are

# Repeatable runs: the same examples every time, and no limit on how long the compiler may take on the first.
settings.register_profile("core", derandomize=True, deadline=None, max_examples=100, print_blob=True)
settings.load_profile("core")


def transition_matrix(order, interval):
    """F, entry by entry from the Taylor series."""
    return np.array(
        [[interval ** (j - i) / math.factorial(j - i) if j >= i else 0.0 for j in range(order)] for i in range(order)]
    )


@pytest.fixture(scope="session")
def plain_track():
    """The recursion as a textbook prints it: one axis, plain Python numbers, lists of states out.

    `steps` holds the interval before each sample. With a limit, the run ends after the sample that passes it.
    """

    def track(z, steps, g, state, limit=math.inf):
        order, x = len(g), list(state)
        predicted, smoothed = [], []
        for measured, t in zip(z, steps, strict=True):
            x = [sum(t ** (j - i) / math.factorial(j - i) * x[j] for j in range(i, order)) for i in range(order)]
            predicted.append(x)
            if not math.isnan(measured):
                e = measured - x[0]
                x = [x[i] + g[i] / t**i * e for i in range(order)]
            smoothed.append(x)
            if abs(x[0]) > limit:
                break
        return np.array(predicted), np.array(smoothed)

    return track


@pytest.fixture(scope="session")
def closed_loop():
    """F (I - K H) at T = 1 for one gain vector, or for many at once: shape (..., order, order)."""

    def matrix(g):
        g = np.asarray(g, dtype=float)
        order = g.shape[-1]
        keep = np.broadcast_to(np.eye(order), (*g.shape, order)).copy()
        keep[..., :, 0] -= g
        return transition_matrix(order, 1.0) @ keep

    return matrix


@pytest.fixture(scope="session")
def steady_kalman():
    """Normalised steady Kalman gains from the discrete Riccati equation, for a process covariance over interval T."""

    def gains(process, sensor_variance=1.0, interval=1.0):
        order = len(process)
        h = np.eye(order)[:, :1]
        p = solve_discrete_are(transition_matrix(order, interval).T, h, process, [[sensor_variance]])
        return p[:, 0] / (p[0, 0] + sensor_variance) * interval ** np.arange(order)

    return gains
