"""An aircraft that climbs in a coordinated turn: a helix.

Position from the centre of the turn: (R sin wt, -R cos wt, c t). The bank angle, the speed over ground V and gravity g
give the radius R = V^2/(g tan bank) and the turn rate w = V/R.
"""

from __future__ import annotations

from math import radians, tan

import numpy as np

from tracker_core.scenarios.base import Scenario
from tracker_core.types import FloatArray

SPEED = 180.0
CLIMB = 12.0
BANK = radians(25)
GRAVITY = 9.80665
START = (8_000.0, 4_000.0, 1_000.0)


def turn() -> tuple[float, float]:
    """Radius in m and turn rate in rad/s."""
    radius = SPEED**2 / (GRAVITY * tan(BANK))
    return radius, SPEED / radius


def motion(times: FloatArray) -> FloatArray:
    """States at the given times, shape (n, 3, 5)."""
    radius, rate = turn()
    states = np.zeros((len(times), 3, 5))
    for order in range(5):
        # Every differentiation is a factor and a quarter turn more of phase; -cos is a quarter turn less.
        for axis, turns in ((0, order), (1, order - 1)):
            states[:, axis, order] = radius * rate**order * np.sin(rate * times + turns * np.pi / 2)
    states[:, 2, 0] = CLIMB * times
    states[:, 2, 1] = CLIMB
    # The turn begins at the start, flying along x.
    states[:, :, 0] += (START[0], START[1] + radius, START[2])
    return states


SCENARIO = Scenario(
    name="climbing-turn",
    title="Climbing turn",
    axes=("x", "y", "z"),
    motion=motion,
    description="An aircraft at 180 m/s that climbs by 12 m/s in a turn with 25° of bank; its height is measured half "
    "as well.",
    source="A textbook target; radius V²/(g tan bank) = 7.1 km, 1.5°/s; start (8, 4, 1) km along x",
    defaults={
        "samples": 400,
        "interval": 1.0,
        "noise_std": (30.0, 30.0, 60.0),
        "order": 3,
        "design": "fading-memory",
        "xi": 0.8,
    },
)
