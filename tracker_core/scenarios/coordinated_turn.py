"""An aircraft that flies straight, turns about, flies back, and turns away: arcs and straight legs at constant speed.

A leg begins at p with the heading h and turns at the rate w, which is 0 where it is straight. After s seconds the
aircraft has flown a chord of length V s sinc(w s/2) in the direction h + w s/2.
"""

from __future__ import annotations

from math import pi, radians

import numpy as np

from tracker_core.scenarios.base import Scenario
from tracker_core.types import FloatArray

SPEED = 120.0
RATE = radians(3)
START = (-8_000.0, 3_000.0)

JOINTS = (60.0, 120.0, 180.0, 210.0)
"""Times at which a leg ends and the next begins, s: two turns at the standard rate, by 180 and by 90 degrees."""

_RATES = np.array((0.0, RATE, 0.0, -RATE, 0.0))


def _chords(headings: FloatArray, rates: FloatArray, since: FloatArray) -> FloatArray:
    """The way from the beginning of a leg, shape (n, 2), m: sinc makes a straight leg of it where the rate is 0."""
    middle = headings + rates * since / 2
    length = SPEED * since * np.sinc(rates * since / (2 * pi))
    return np.stack((length * np.cos(middle), length * np.sin(middle)), axis=1)


def _legs() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Time (n,), heading (n,) and position (n, 2) at the beginning of every leg; the first is counted from zero."""
    begins = np.array((0.0, *JOINTS))
    lengths = np.diff(begins)
    headings = np.concatenate(([0.0], np.cumsum(_RATES[:-1] * lengths)))
    ways = _chords(headings[:-1], _RATES[:-1], lengths)
    return begins, headings, np.array(START) + np.concatenate((np.zeros((1, 2)), np.cumsum(ways, axis=0)))


def motion(times: FloatArray) -> FloatArray:
    """States at the given times, shape (n, 2, 5); at a joint those of the leg that begins there."""
    begins, headings, positions = _legs()
    leg = np.searchsorted(JOINTS, times, side="right")
    since, rate = times - begins[leg], _RATES[leg]
    states = np.empty((len(times), 2, 5))
    states[:, :, 0] = positions[leg] + _chords(headings[leg], rate, since)
    heading = headings[leg] + rate * since
    for order in range(1, 5):
        # Every differentiation of the velocity is a factor and a quarter turn; sin is a quarter turn less than cos.
        for axis, turns in ((0, order - 1), (1, order - 2)):
            states[:, axis, order] = SPEED * rate ** (order - 1) * np.cos(heading + turns * pi / 2)
    return states


SCENARIO = Scenario(
    name="coordinated-turn",
    title="Straight legs and coordinated turns",
    axes=("x", "y"),
    motion=motion,
    description="An aircraft at 120 m/s that flies straight, turns about at the standard rate of 3°/s, flies back and "
    "turns away by 90° to the other side.",
    source="A textbook target; turns at 60 s and 180 s of radius V/ω = 2.3 km, ω = 3°/s; start (-8, 3) km along x",
    defaults={"samples": 270, "interval": 1.0, "noise_std": (50.0,), "order": 3, "design": "fading-memory", "xi": 0.8},
)
