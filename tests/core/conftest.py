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


@pytest.fixture(scope="session")
def spectral_radius():
    """The largest magnitude of an eigenvalue, of one matrix or of many."""
    return largest_eigenvalue


def largest_eigenvalue(matrices):
    return np.abs(np.linalg.eigvals(matrices)).max(axis=-1)


# Boxes that hold the whole stable region of each order and a margin around it.
BOXES = {
    2: [(-0.5, 2.5), (-1, 5)],
    3: [(-0.5, 2.5), (-1, 5), (-1, 9)],
    4: [(-0.5, 2.5), (-1, 6), (-1, 9), (-1, 17)],
}


def coefficients(roots):
    """Of the polynomials with the given roots, shape (n, order), without the leading one."""
    polynomial = np.ones((len(roots), 1), dtype=complex)
    for root in roots.T:
        zero = np.zeros((len(roots), 1))
        polynomial = np.hstack((polynomial, zero)) - root[:, None] * np.hstack((zero, polynomial))
    return polynomial[:, 1:].real


def random_poles(order, count, radius, draw):
    """Poles uniform in a disc, shape (count, order); a third of the draws have two real ones in place of a pair."""
    pairs = order // 2
    upper = radius * np.sqrt(draw.random((count, pairs))) * np.exp(1j * np.pi * draw.random((count, pairs)))
    roots = np.concatenate((upper, upper.conj()), axis=1)
    real = draw.random(count) < 1 / 3
    roots[real, 0], roots[real, pairs] = draw.uniform(-radius, radius, (2, real.sum()))
    if order == 3:
        roots = np.concatenate((roots, draw.uniform(-radius, radius, (count, 1))), axis=1)
    return roots


@pytest.fixture(scope="session")
def gains_with_poles(closed_loop):
    """The gains that place poles: the characteristic polynomial is affine in the gains, so solve for them."""

    def gains(roots):
        corners = np.concatenate((np.zeros((1, roots.shape[1])), np.eye(roots.shape[1])))
        base, *others = coefficients(np.linalg.eigvals(closed_loop(corners)))
        return (coefficients(roots) - base) @ np.linalg.inv(np.array(others) - base)

    return gains


@pytest.fixture(scope="session")
def random_gains(gains_with_poles):
    """Gain sets around the border: a quarter uniform in a box, the rest with poles uniform in a disc of radius 1.2."""

    def gains(order, draws, seed):
        draw = np.random.default_rng(seed)
        low, high = np.array(BOXES[order]).T
        boxed = draw.uniform(low, high, (draws // 4, order))
        return np.concatenate((boxed, gains_with_poles(random_poles(order, draws - len(boxed), 1.2, draw))))

    return gains


@pytest.fixture(scope="session")
def stable_gains(gains_with_poles):
    """Gain sets whose poles are uniform in a disc within the unit circle."""

    def gains(order, draws, seed, radius=0.95):
        return gains_with_poles(random_poles(order, draws, radius, np.random.default_rng(seed)))

    return gains


def push_input(order, t):
    """What a push adds to the state at the end of the time t that it acts for, or at which it comes."""
    return {
        2: np.array([t**2 / 2, t]), 3: np.array([t**2 / 2, t, 1.0]), 4: np.array([t**3 / 6, t**2 / 2, t, 1.0])
    }[order] * math.sqrt(1 / t if order == 2 else t)  # fmt: skip


@pytest.fixture(scope="session")
def pushed_target():
    """Measurements (n, axes) of targets on the model of an order; steps in the interval that the index belongs to."""

    def measured(order, steps, tracking_index, std, draw, axes=1):
        pushes, noise = draw.standard_normal((2, len(steps), axes))
        state = 10 * draw.standard_normal((order, axes))
        found = np.empty((len(steps), axes))
        for i, t in enumerate(steps):
            if i:
                state = transition_matrix(order, t) @ state
                state += np.outer(push_input(order, t), tracking_index * std * pushes[i])
            found[i] = state[0] + std * noise[i]
        return found

    return measured


@pytest.fixture(scope="session")
def joint_density():
    """Of measurements at given steps: M and C, if they are M x_0 plus normal errors with covariance C, unit noise."""

    def matrices(order, steps, tracking_index):
        n = len(steps)
        flow = [np.eye(order)]
        for t in steps[1:]:
            flow.append(transition_matrix(order, t) @ flow[-1])
        influence = np.zeros((n, n))
        for j in range(1, n):
            effect = tracking_index * push_input(order, steps[j])
            for i in range(j, n):
                if i > j:
                    effect = transition_matrix(order, steps[i]) @ effect
                influence[i, j] = effect[0]
        return np.array([matrix[0] for matrix in flow]), np.eye(n) + influence @ influence.T

    return matrices
