"""The target of Yu & Wu 2017: nine segments of constant jerk, ten seconds each, after ten seconds without.

Position, velocity and acceleration are integrated exactly from segment to segment, for any interval.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from tracker_core.scenarios.base import Scenario
from tracker_core.types import FloatArray

SEGMENT = 10.0
JERKS = (
    (0.0, -2.0, 4.0, -4.0, 2.0, -2.0, 4.0, -2.0, 4.0, -4.0),
    (0.0, -1.0, 2.0, -2.0, 2.0, -2.0, 2.0, -2.0, 2.0, -1.0),
)
"""x and y, m/s^3. The paper prints the y of segment 7 as a second j_v."""

START = ((1_000.0, 200.0, 0.0), (-1_000.0, 200.0, 0.0))
"""Position, velocity and acceleration at time zero."""

JUST = 1e-9
"""A sample this part of a segment before a joint counts as on it: multiples of an interval are rounded."""


@cache
def knots() -> FloatArray:
    """Position, velocity and acceleration at the beginning of every segment, shape (segments, 2, 3)."""
    states = [np.array(START)]
    for jerk in zip(*JERKS, strict=True):
        states.append(_advance(states[-1], np.array(jerk), np.array(SEGMENT)))
    return np.stack(states[:-1])


def _advance(state: FloatArray, jerk: FloatArray, time: FloatArray) -> FloatArray:
    """Position, velocity and acceleration (..., 3) after some time of constant jerk (...)."""
    x, v, a = state[..., 0], state[..., 1], state[..., 2]
    return np.stack(
        (
            x + time * (v + time * (a / 2 + time * jerk / 6)),
            v + time * (a + time * jerk / 2),
            a + time * jerk,
        ),
        axis=-1,
    )


def motion(times: FloatArray) -> FloatArray:
    """States at the given times, shape (n, 2, 5)."""
    segment = np.clip(np.floor(times / SEGMENT + JUST), 0, len(JERKS[0]) - 1).astype(int)
    jerk = np.array(JERKS).T[segment]
    states = np.zeros((len(times), 2, 5))
    states[:, :, :3] = _advance(knots()[segment], jerk, (times - SEGMENT * segment)[:, None])
    states[:, :, 3] = jerk
    return states


SCENARIO = Scenario(
    name="yu-wu",
    title="Jerk segments (Yu & Wu)",
    axes=("x", "y"),
    motion=motion,
    description="A target whose jerk changes every ten seconds, up to 4 m/s³.",
    source="Yu & Wu 2017, section 4",
    first_sample=1,
    defaults={"samples": 500, "interval": 0.2, "noise_std": (10.0,), "start": "known", "xi": 0.8},
)
