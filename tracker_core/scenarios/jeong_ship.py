"""The manoeuvring ship of Jeong, Njonjo & Pan 2017, eq. 29-30.

    X = a [10 sin 1.2wt + 7 cos .99wt + 8 sin .7wt + 6 cos 2wt + 9 sin 3wt + 5 cos 3wt] + 10 t
    Y = b [20 cos .3wt + 22 sin 2wt]

The paper prints neither a, b nor w, but the first position (573, 1038.4) m and the first speed 50.4 m/s, and these
three numbers fix them: X(0) = (7 + 6 + 5) a, Y(0) = 20 b, and the speed at 0 is that of
(X', Y') = ((12 + 5.6 + 27) a w + 10, 44 b w). t is in seconds, sampled every 3 s.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from tracker_core.scenarios.base import Scenario
from tracker_core.types import FloatArray

FIRST_POSITION = (573.0, 1038.4)
FIRST_SPEED = 50.4
DRIFT = 10.0

# Amplitude, multiple of w, and whether a sine (else a cosine).
X_TERMS = (
    (10.0, 1.2, True), (7.0, 0.99, False), (8.0, 0.7, True), (6.0, 2.0, False), (9.0, 3.0, True), (5.0, 3.0, False),
)  # fmt: skip
Y_TERMS = ((20.0, 0.3, False), (22.0, 2.0, True))

_Terms = tuple[tuple[float, float, bool], ...]


def parameters() -> tuple[float, float, float]:
    """a (m), b (m) and w (rad/s) from what the paper prints.

    The speed condition is a quadratic equation in w; its positive root is taken.
    """
    a = FIRST_POSITION[0] / sum(amplitude for amplitude, _, sine in X_TERMS if not sine)
    b = FIRST_POSITION[1] / sum(amplitude for amplitude, _, sine in Y_TERMS if not sine)
    slope_x = a * sum(amplitude * multiple for amplitude, multiple, sine in X_TERMS if sine)
    slope_y = b * sum(amplitude * multiple for amplitude, multiple, sine in Y_TERMS if sine)
    square, linear = slope_x**2 + slope_y**2, DRIFT * slope_x
    w = (-linear + sqrt(linear**2 + square * (FIRST_SPEED**2 - DRIFT**2))) / square
    return a, b, w


def _derivative(terms: _Terms, w: float, times: FloatArray, order: int) -> FloatArray:
    """The `order`-th time derivative of a sum of sines and cosines."""
    total = np.zeros_like(times)
    for amplitude, multiple, sine in terms:
        rate = multiple * w
        # A cosine, and every differentiation, is a quarter turn more of phase.
        turns = order + (0 if sine else 1)
        total += amplitude * rate**order * np.sin(rate * times + turns * np.pi / 2)
    return total


def motion(times: FloatArray) -> FloatArray:
    """States at the given times, shape (n, 2, 5)."""
    a, b, w = parameters()
    states = np.empty((len(times), 2, 5))
    for order in range(5):
        states[:, 0, order] = a * _derivative(X_TERMS, w, times, order)
        states[:, 1, order] = b * _derivative(Y_TERMS, w, times, order)
    states[:, 0, 0] += DRIFT * times
    states[:, 0, 1] += DRIFT
    return states


SCENARIO = Scenario(
    name="jeong-ship",
    title="Manoeuvring ship (Jeong)",
    axes=("x", "y"),
    motion=motion,
    description="A fast ship on a winding course, 30 m/s on average and 53 m/s at most, seen by radar every 3 s.",
    source="Jeong, Njonjo & Pan 2017, eq. 29-30; a, b and w follow from the printed first position and speed",
    defaults={"samples": 1000, "interval": 3.0, "noise_std": (10.0,)},
)
