"""Targets that move as a polynomial of time: constant velocity, constant acceleration."""

from __future__ import annotations

import numpy as np

from tracker_core.scenarios.base import Scenario
from tracker_core.types import FloatArray


def polynomial(coefficients: tuple[tuple[float, ...], ...], times: FloatArray) -> FloatArray:
    """States of a target whose axes start with the given position, velocity, ... at time zero.

    Args:
        coefficients: per axis the state at time zero: position, velocity[, acceleration[, ...]], SI units.
        times: shape (n,), s.

    Returns:
        Shape (n, n_axes, 5).
    """
    states = np.zeros((len(times), len(coefficients), 5))
    for axis, start in enumerate(coefficients):
        for derivative in range(len(start)):
            value = np.zeros_like(times)
            # Horner's rule on the Taylor series of this derivative.
            for power in range(len(start) - 1, derivative, -1):
                value = (value + start[power]) * times / (power - derivative)
            states[:, axis, derivative] = value + start[derivative]
    return states


def _constant_velocity(times: FloatArray) -> FloatArray:
    return polynomial(((-12_000.0, 120.0), (9_000.0, -45.0)), times)


def _constant_acceleration(times: FloatArray) -> FloatArray:
    return polynomial(((0.0, 160.0, -1.5), (2_000.0, 20.0, 1.0)), times)


CONSTANT_VELOCITY = Scenario(
    name="constant-velocity",
    title="Constant velocity",
    axes=("x", "y"),
    motion=_constant_velocity,
    description="An aircraft in straight flight at 128 m/s, the target that every alpha-beta filter is exact for.",
    source="A textbook target; start (-12, 9) km, velocity (120, -45) m/s",
    defaults={"samples": 200, "interval": 1.0, "noise_std": (50.0,), "order": 2, "design": "fading-memory", "xi": 0.8},
)

CONSTANT_ACCELERATION = Scenario(
    name="constant-acceleration",
    title="Constant acceleration",
    axes=("x", "y"),
    motion=_constant_acceleration,
    description="An aircraft that accelerates by 1.8 m/s² throughout, so that an alpha-beta filter lags by a constant.",
    source="A textbook target; start (0, 2) km, velocity (160, 20) m/s, acceleration (-1.5, 1) m/s²",
    defaults={"samples": 200, "interval": 1.0, "noise_std": (50.0,), "order": 2, "design": "fading-memory", "xi": 0.8},
)
