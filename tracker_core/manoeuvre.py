"""Manoeuvre noise: random pulses that push a target off its motion, and of which the filter knows nothing.

The deviation d = (position, velocity, acceleration) of every axis begins at zero with the first sample and follows

    d(k+1) = F d(k) + G w(k),   w(k) white, Gaussian, zero mean

with the transition matrix F of constant acceleration. A model is its G, a function of the interval T.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np

from tracker_core.checks import POSITIVE, Domain, check_choice
from tracker_core.types import FloatArray

MANOEUVRE_STD = Domain(low=0)
"""Standard deviations of w, in its unit."""


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """One way in which a random manoeuvre enters the motion.

    Attributes:
        name: key in the registry.
        title: for menus.
        formula: G and w as they are printed; empty where nothing manoeuvres.
        unit: SI symbol of w; empty where nothing manoeuvres.
        input_vector: G as a function of T in s: what w = 1 adds to position, velocity and acceleration.
        held: which derivative of the position w is, for the interval over which it acts: 2 an acceleration, 3 a jerk;
            None where it is a change of one.
        highest: the highest derivative that there is; those above it come in impulses, whose mean square is infinite.
    """

    name: str
    title: str
    formula: str
    unit: str
    input_vector: Callable[[float], tuple[float, float, float]]
    held: int | None = None
    highest: int = 4


MANOEUVRES: dict[str, Manoeuvre] = {
    m.name: m
    for m in (
        Manoeuvre("none", "None", "", "", lambda _: (0.0, 0.0, 0.0)),
        # An acceleration that is held for one interval: the model behind the tracking index (Kalata 1984).
        Manoeuvre(
            "acceleration-pulses",
            "Acceleration held for one interval",
            "G = (T²/2, T, 0), w an acceleration",
            "m/s²",
            lambda t: (t**2 / 2, t, 0.0),
            held=2,
            highest=2,
        ),
        # An acceleration that stays: Yu & Wu, eq. 2.
        Manoeuvre(
            "acceleration-jumps",
            "Jumps of the acceleration",
            "G = (T²/2, T, 1), w a change of the acceleration",
            "m/s²",
            lambda t: (t**2 / 2, t, 1.0),
            highest=2,
        ),
        # A jerk that is held for one interval: Yu & Wu, eq. 13-15.
        Manoeuvre(
            "jerk-pulses",
            "Jerk held for one interval",
            "G = (T³/6, T²/2, T), w a jerk",
            "m/s³",
            lambda t: (t**3 / 6, t**2 / 2, t),
            held=3,
            highest=3,
        ),
    )
}


def wander(name: str, samples: int, axes: int, interval: float, std: float, seed: int) -> FloatArray:
    """How far the manoeuvres carry a target from its motion.

    The states are the model's after the pulse: the acceleration of "acceleration-pulses" is 0 at every sample,
    although w(k) acts between two of them, and jerk and snap are 0 throughout: see `held_std`.

    Args:
        name: in MANOEUVRES.
        samples: how many, >= 1; the deviation of the first is zero.
        axes: how many; each draws from a stream of its own, which is none of the measurement noise's.
        interval: T, s.
        std: standard deviation of w, in its unit, the same for every axis.
        seed: whole number >= 0. The same seed gives the same bits, and a longer run begins with the shorter one.

    Returns:
        Shape (samples, axes, 5): what is to be added to position, velocity, acceleration, jerk and snap, SI units.

    Raises:
        InputError: for an unknown name, an interval or a standard deviation outside its domain.
    """
    model = MANOEUVRES[check_choice("manoeuvre", name, MANOEUVRES)]
    t = POSITIVE.check("interval", interval)
    scale = MANOEUVRE_STD.check("manoeuvre_std", std)
    deviation = np.zeros((samples, axes, 5))
    g = model.input_vector(t)
    if not any(g):
        return deviation
    for axis in range(axes):
        stream = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(axis, 1)))
        w = scale * stream.standard_normal(samples - 1)
        # F is triangular: the acceleration sums up w alone, the velocity that and w, the position all three.
        acceleration = _summed(g[2] * w)
        velocity = _summed(t * acceleration[:-1] + g[1] * w)
        deviation[:, axis, 0] = _summed(t * velocity[:-1] + t**2 / 2 * acceleration[:-1] + g[0] * w)
        deviation[:, axis, 1] = velocity
        deviation[:, axis, 2] = acceleration
    return deviation


def held_std(name: str, derivative: int, std: float) -> float:
    """The root mean square over time of what pushes add to a derivative of the position and `wander` does not show.

    Args:
        name: in MANOEUVRES.
        derivative: 2 for the acceleration, and so on.
        std: standard deviation of w, in its unit.

    Returns:
        That of w, where it is this derivative for an interval each; infinite for a derivative that comes in impulses;
        0 for one that the states show, and where nothing pushes.

    Raises:
        InputError: for an unknown name or a standard deviation outside its domain.
    """
    model = MANOEUVRES[check_choice("manoeuvre", name, MANOEUVRES)]
    std = MANOEUVRE_STD.check("manoeuvre_std", std)
    if derivative > model.highest:
        return inf if std else 0.0
    return std if model.held == derivative else 0.0


def _summed(increments: FloatArray) -> FloatArray:
    """A state from zero on, one sample longer than its increments."""
    return np.concatenate(([0.0], np.cumsum(increments)))
