"""Singer's random manoeuvre target: an acceleration that lasts for a while, as pilots and evading ships make it.

The acceleration of every axis is a first-order Markov process, da/dt = -a/tau + white noise, of standard deviation
sigma at every time and correlation exp(-s/tau) over s seconds. The state (position, velocity, acceleration) goes from
sample to sample by

    x(k+1) = F x(k) + w(k),   w(k) ~ N(0, Q)

exactly, whatever the interval (Singer 1970, "Estimating optimal tracking filter performance for manned maneuvering
targets"). Such an acceleration is continuous but nowhere differentiable: the target has no jerk and no snap.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, expm1, factorial

import numpy as np

from tracker_core.checks import InputError
from tracker_core.scenarios.base import Scenario
from tracker_core.types import FloatArray

TAU = 20.0
RMS_ACCELERATION = 2.0
POSITION = (-20_000.0, 12_000.0)
VELOCITY = (200.0, -60.0)


def transition(interval: float, tau: float) -> FloatArray:
    """F over an interval: T >= 0 and the manoeuvre time constant tau > 0, both in s; shape (3, 3)."""
    theta = interval / tau
    return np.array(
        [
            [1.0, interval, tau**2 * _lag(theta)],
            [0.0, 1.0, -tau * expm1(-theta)],
            [0.0, 0.0, exp(-theta)],
        ]
    )


def covariance(interval: float, tau: float, rms: float) -> FloatArray:
    """Q over an interval: T >= 0 and tau > 0 in s, the standard deviation of the acceleration in m/s²; shape (3, 3)."""
    theta = interval / tau
    decay, e1, e2 = -expm1(-theta), exp(-theta), exp(-2 * theta)
    lag = _lag(theta)
    q11 = _positive(
        theta, 5, lambda n: 4 * n - 2**n,
        lambda: 1 - e2 + 2 * theta + 2 * theta**3 / 3 - 2 * theta**2 - 4 * theta * e1,
    )  # fmt: skip
    q13 = _positive(theta, 3, lambda n: 2 * n - 2**n, lambda: 1 - e2 - 2 * theta * e1)
    q22 = _positive(theta, 3, lambda n: 4 - 2**n, lambda: 4 * e1 - 3 - e2 + 2 * theta)
    q33 = -expm1(-2 * theta)
    units = np.array([tau**2, tau, 1.0]) * rms
    return np.outer(units, units) * np.array([[q11, lag**2, q13], [lag**2, q22, decay**2], [q13, decay**2, q33]])


def _lag(theta: float) -> float:
    """theta - 1 + exp(-theta): what an acceleration of 1 makes of the position."""
    return _positive(theta, 2, lambda _: 1, lambda: theta + expm1(-theta))


def _positive(theta: float, first: int, coefficient: Callable[[int], int], closed: Callable[[], float]) -> float:
    """A closed form in which everything below theta^first cancels; below theta = 1 its power series instead.

    The series is the sum of (-1)^n coefficient(n) theta^n/n! from `first` on.
    """
    if theta >= 1:
        return closed()
    # Smallest terms first. At theta = 1 the last one is 2^30/30! of 1.
    terms = ((-1) ** n * coefficient(n) / factorial(n) * theta**n for n in range(30, first - 1, -1))
    return sum(terms, start=0.0)


def motion(times: FloatArray, seed: int) -> FloatArray:
    """States at the given times, shape (n, 2, 5); jerk and snap are NaN.

    The stream of every axis is its own, and none of the measurement noise's. The acceleration at time zero is drawn
    first and the rest forwards from there. Before time zero the target flies with that acceleration: jerk 0, snap 0.

    Raises:
        InputError: for times that decrease.
    """
    if (np.diff(times) < 0).any():
        raise InputError("times", "must not decrease", f"{float(np.diff(times).min())} s between two")
    before = np.minimum(times, 0)
    steps = np.diff(np.maximum(times, 0), prepend=0.0)
    distinct, which = np.unique(steps, return_inverse=True)
    f = np.stack([transition(step, TAU) for step in distinct])[which]
    roots = np.stack([_root(step) for step in distinct])[which]
    states = np.full((len(times), 2, 5), np.nan)
    for axis in range(2):
        stream = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(axis, 2)))
        first = RMS_ACCELERATION * stream.standard_normal()
        draws = np.zeros((len(times), 1, 3))
        draws[steps > 0] = stream.standard_normal((int(np.count_nonzero(steps)), 1, 3))
        position, velocity, acceleration = _run(f, (roots * draws).sum(axis=2), POSITION[axis], VELOCITY[axis], first)
        states[:, axis, 0] = position + velocity * before + acceleration * before**2 / 2
        states[:, axis, 1] = velocity + acceleration * before
        states[:, axis, 2] = acceleration
    states[times < 0, :, 3:] = 0
    return states


def _root(step: float) -> FloatArray:
    """The Cholesky factor of Q; nothing is drawn where no time passes."""
    root = np.zeros((3, 3))
    if step > 0:
        root[:] = np.linalg.cholesky(covariance(step, TAU, RMS_ACCELERATION))
    return root


def _run(
    f: FloatArray, w: FloatArray, position: float, velocity: float, acceleration: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Positions, velocities and accelerations (n,) from F (n, 3, 3), w (n, 3) and the state at time zero."""
    from tracker_core import kernels  # compiled code is loaded when the first such target moves

    # F is triangular: the acceleration follows from w alone, the velocity sums that up, the position both.
    a: FloatArray = np.concatenate(([acceleration], w[:, 2]))
    kernels.autoregress(np.concatenate(([0.0], f[:, 2, 2])), a)
    v: FloatArray = np.cumsum(np.concatenate(([velocity], f[:, 1, 2] * a[:-1] + w[:, 1])))
    p: FloatArray = np.cumsum(np.concatenate(([position], f[:, 0, 1] * v[:-1] + f[:, 0, 2] * a[:-1] + w[:, 0])))
    return p[1:], v[1:], a[1:]


SCENARIO = Scenario(
    name="singer",
    title="Random manoeuvres (Singer)",
    axes=("x", "y"),
    random_motion=motion,
    description="An aircraft whose acceleration is random, 2 m/s² on every axis and forgotten after 20 s; every seed "
    "draws another flight.",
    source="Singer 1970, with τ = 20 s as for an evading aircraft, σ = 2 m/s²; start (-20, 12) km, velocity "
    "(200, -60) m/s",
    defaults={"samples": 300, "interval": 1.0, "noise_std": (50.0,), "order": 3, "design": "fading-memory", "xi": 0.8},
)
