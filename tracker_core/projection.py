"""The way back into the stable region: the nearest gains whose poles lie within a circle.

The polynomials with all roots in the unit disc are the image of the box [-1, 1]^order of reflection coefficients under
the step-up recursion, and gains are affine in the coefficients of the polynomial.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from tracker_core.poles import gains_from_poles
from tracker_core.types import FloatArray

_SWEEPS, _ALL_STARTS, _KEPT_STARTS = 300, 12, 6
_LEAPS = np.array([0.0, 1.0, 3.0, 10.0, 30.0, 100.0])


def nearest_within(target: FloatArray, radius: float) -> FloatArray:
    """The gains nearest to the target, by Euclidean distance, whose poles all lie within a radius.

    The squared distance is a parabola in each reflection coefficient, so that it is minimised by turns exactly, from
    many starts; where turns progress slowly, leaps along their sum help.

    Args:
        target: normalised gains outside, shape (order,).
        radius: greatest magnitude of a pole.

    Returns:
        Normalised gains, shape (order,).
    """
    order = len(target)
    powers = np.power(radius, np.arange(1.0, order + 1))
    base, matrix = _gains_of_coefficients(order)
    reflections = np.array(list(product((-0.9, -0.3, 0.3, 0.9), repeat=order)))
    best = _miss(reflections, powers, base, matrix, target)
    for sweep in range(_SWEEPS):
        if sweep == _ALL_STARTS:
            reflections = reflections[np.argsort(best)[:_KEPT_STARTS]]
            best = _miss(reflections, powers, base, matrix, target)
        before, came_from = best, reflections.copy()
        for k in range(order):
            ends = []
            for end in (-1.0, 1.0):
                reflections[:, k] = end
                ends.append(_residual(reflections, powers, base, matrix, target))
            middle, slope = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2
            steep = np.einsum("ij,ij->i", slope, slope)
            wanted = -np.einsum("ij,ij->i", slope, middle) / np.where(steep > 0, steep, 1.0)
            reflections[:, k] = np.clip(wanted, -1, 1)
        leaps = np.clip(reflections + _LEAPS[:, None, None] * (reflections - came_from), -1, 1)
        misses = _miss(leaps.reshape(-1, order), powers, base, matrix, target).reshape(len(_LEAPS), -1)
        farthest, start = np.argmin(misses, axis=0), np.arange(len(reflections))
        reflections, best = leaps[farthest, start], misses[farthest, start]
        if np.max(before - best) <= 1e-13 * float(best.min()):
            break
    chosen = reflections[int(np.argmin(best))][None]
    return _residual(chosen, powers, base, matrix, np.zeros(order))[0]


def scaled_poles(vector: FloatArray, factor: float) -> FloatArray:
    """The gains whose poles are those of normalised gains times a factor, shape (order,)."""
    base, matrix = _gains_of_coefficients(len(vector))
    coefficients = np.linalg.solve(matrix.T, vector - base)
    return base + (coefficients * np.power(factor, np.arange(1.0, len(vector) + 1))) @ matrix


def _gains_of_coefficients(order: int) -> tuple[FloatArray, FloatArray]:
    """Gains as an affine map of the coefficients of z^order + c1 z^(order-1) + ...: base + c @ matrix."""
    at_zero = gains_from_poles([0j] * order)
    rows = []
    for k in range(1, order + 1):
        # The polynomial z^(order-k) (z^k - 1) has c_k = -1.
        roots = [np.exp(2j * np.pi * i / k) for i in range(k)] + [0j] * (order - k)
        rows.append(at_zero - gains_from_poles(roots))
    return at_zero, np.array(rows)


def _coefficients(reflections: FloatArray) -> FloatArray:
    """Step-up recursion: coefficients c1 ... of the polynomials with the given reflections, shape (n, order)."""
    polynomial = np.empty((len(reflections), 0))
    for k in range(reflections.shape[1]):
        last = reflections[:, k : k + 1]
        polynomial = np.hstack((polynomial + last * polynomial[:, ::-1], last))
    return polynomial


def _residual(
    reflections: FloatArray, powers: FloatArray, base: FloatArray, matrix: FloatArray, target: FloatArray
) -> FloatArray:
    return base + (_coefficients(reflections) * powers) @ matrix - target


def _miss(*arguments: FloatArray) -> FloatArray:
    residual = _residual(*arguments)
    return np.einsum("ij,ij->i", residual, residual)
