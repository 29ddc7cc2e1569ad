"""A target with the character of the one that Al-Wagih & Abdulla track, which they do not print.

x is nearly a constant velocity, with a slow weave; y is pushed hard in the first seconds, while a growing memory is
short and a filter with fixed small gains is already slow, and gently pulled back later.
"""

from __future__ import annotations

import numpy as np

from tracker_core.scenarios.base import Scenario
from tracker_core.types import FloatArray

SPEED = 150.0
WEAVE, PERIOD = 60.0, 115.0
PUSHES = ((0.0, 12.0, 12.0), (16.0, 33.0, -0.9))
"""Of y: begin and end, s, and acceleration, m/s^2."""


def motion(times: FloatArray) -> FloatArray:
    """States at the given times, shape (n, 2, 5)."""
    states = np.zeros((len(times), 2, 5))
    rate = 2 * np.pi / PERIOD
    for order in range(5):
        # Every differentiation is a factor and a quarter turn more of phase.
        states[:, 0, order] = WEAVE * rate**order * np.sin(rate * times + order * np.pi / 2)
    states[:, 0, 0] += SPEED * times
    states[:, 0, 1] += SPEED
    for begin, end, acceleration in PUSHES:
        pushed, coasted = np.clip(times - begin, 0, end - begin), np.maximum(times - end, 0)
        states[:, 1, 0] += acceleration * pushed * (pushed / 2 + coasted)
        states[:, 1, 1] += acceleration * pushed
        states[:, 1, 2] += np.where((times >= begin) & (times < end), acceleration, 0.0)
    return states


SCENARIO = Scenario(
    name="alwagih",
    title="Pushed target (after Al-Wagih)",
    axes=("x", "y"),
    motion=motion,
    description="x is nearly a constant velocity, y is accelerated by 12 m/s² for the first twelve seconds.",
    source="Gainscope, with the character of the ten data sets of Al-Wagih & Abdulla, whose target is not printed",
    defaults={
        "samples": 200,
        "interval": 1.0,
        "noise_std": (15.0,),
        "order": 2,
        "design": "benedict-bordner",
        "alpha": 0.1,
    },
)
