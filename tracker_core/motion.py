"""The motion model between two samples: the state moves as a polynomial of time."""

from __future__ import annotations

from math import factorial

import numpy as np

from tracker_core.types import FloatArray


def transition(order: int, interval: float) -> FloatArray:
    """Transition matrix F over `interval`: F[i, j] = T^(j-i)/(j-i)! for j >= i, else 0.

    Args:
        order: number of states (position, velocity, ...).
        interval: T in s; may be negative (backwards in time).

    Returns:
        Array of shape (order, order).
    """
    matrix = np.zeros((order, order))
    for i in range(order):
        for j in range(i, order):
            matrix[i, j] = interval ** (j - i) / factorial(j - i)
    return matrix
