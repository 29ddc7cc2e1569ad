"""Stable gains without a border: every point of the space of as many dimensions as the order is a stable gain set.

The coordinates are u_k = artanh(r_k) of the reflection coefficients r_k in (-1, 1) of the characteristic polynomial.
The step-up recursion (Levinson 1947; Markel & Gray 1976, Linear Prediction of Speech, section 5.3) makes a polynomial
with all roots in the unit disc from every such set, and every such polynomial is made from one set.

Good filters have their poles near z = 1, where the coefficients of powers of z differ by rounding alone. The recursion
is therefore carried out in powers of w = z - 1, on the sum S and the difference D of the polynomial P and its reverse
Q(z) = z^k P(1/z). From S = 2, D = 0 it becomes

    S <- (1 + r) (S + w (S + D)/2),   D <- (1 - r) (D + w (S + D)/2),   P = (S + D)/2:

sums of products of positive numbers, so that no digits cancel wherever the poles lie.
"""

from __future__ import annotations

from math import comb

import numpy as np

from tracker_core.conventions import Gains
from tracker_core.poles import offset_polynomial
from tracker_core.types import FloatArray

_GAINS_OF_SUMS = np.array(
    [[1, -1, 1, -1], [0, 1, -3 / 2, 11 / 6], [0, 0, 1, -2], [0, 0, 0, 1]],
)
"""From the symmetric sums of the poles' distances 1 - z to normalised gains: see `poles.gains_from_offsets`."""


def gains_at(places: FloatArray) -> FloatArray:
    """The stable gains at places.

    Args:
        places: artanh of the reflection coefficients, shape (..., order); beyond about 300 gains become zero.

    Returns:
        Normalised gains, shape (..., order).
    """
    places = np.asarray(places, dtype=np.float64)
    order = places.shape[-1]
    # Coefficients of w^0 ... w^order.
    total, difference = (np.zeros((*places.shape[:-1], order + 1)) for _ in range(2))
    total[..., 0] = 2.0
    with np.errstate(over="ignore"):
        # 1 + tanh u and 1 - tanh u, each to its last digit.
        plus, minus = (2 / (1 + np.exp(-2 * sign * places)) for sign in (1, -1))
    for k in range(order):
        carried = np.zeros_like(total)
        carried[..., 1:] = (total + difference)[..., :-1] / 2
        total, difference = plus[..., k, None] * (total + carried), minus[..., k, None] * (difference + carried)
    sums = ((total + difference) / 2)[..., order - 1 :: -1]
    return sums @ _GAINS_OF_SUMS[:order, :order].T


def place_of(gains: Gains) -> FloatArray:
    """Where gains lie: the inverse of `gains_at`, by the step-down recursion, shape (order,).

    Not finite, or NaN, for gains that are not stable or so near the border that rounding hides on which side they are.
    """
    sums = offset_polynomial(gains)
    order = gains.order
    # S and D from P: coefficients that cancel do so as whole numbers.
    reverse = np.zeros((order + 1, order + 1))
    for j in range(order + 1):
        for i in range(order + 1 - j):
            reverse[j + i, order - j] += (-1) ** j * comb(order - j, i)
    forward = np.eye(order + 1)[::-1]
    total, difference = (forward + reverse) @ sums, (forward - reverse) @ sums
    place = np.empty(order)
    with np.errstate(divide="ignore", invalid="ignore"):
        for k in range(order, 0, -1):
            plus, minus = total[k], difference[k]
            place[k - 1] = np.log(plus / minus) / 2
            above, below = total / plus, difference / minus
            carried = np.append(0.0, (above - below)[:-1]) / 2
            total, difference = _shortened(above + carried), _shortened(below - carried)
    return place


def _shortened(polynomial: FloatArray) -> FloatArray:
    """The quotient by 1 + w of a polynomial that it divides; coefficients of w^0 upwards."""
    quotient = polynomial[:-1].copy()
    for k in range(1, len(quotient)):
        quotient[k] -= quotient[k - 1]
    return quotient
