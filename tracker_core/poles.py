"""Characteristic polynomial and poles of a filter with constant gains, and the gains that place given poles.

All formulas are in normalised gains and do not depend on the sampling interval. With u = 1 - z for every pole z and
e_k the k-th elementary symmetric polynomial of the u, the gains are linear in the e_k; near z = 1, where good filters
have their poles, no digits cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot, isfinite, log

import numpy as np

from tracker_core.checks import InputError
from tracker_core.conventions import Gains
from tracker_core.types import ORDERS, FloatArray

SNAP = 0.01
"""A pole no further than this from the real axis counts as real while a hand moves it."""

CLUSTER = 1e-3
"""Equal poles of a polynomial are computed this far apart at most (four of them; fewer are closer)."""

DAMPING = ("underdamped", "critically damped", "overdamped", "alternating")


def characteristic_polynomial(gains: Gains) -> FloatArray:
    """Coefficients of det(zI - F(I - KH)) at T = 1, highest power first, shape (order + 1,)."""
    g = gains.vector
    if gains.order == 2:
        return np.array([1.0, g[0] + g[1] - 2, 1 - g[0]])
    if gains.order == 3:
        return np.array([1.0, g[0] + g[1] + g[2] / 2 - 3, 3 - 2 * g[0] - g[1] + g[2] / 2, g[0] - 1])
    return np.array(
        [
            1.0,
            g[0] + g[1] + g[2] / 2 + g[3] / 6 - 4,
            6 - 3 * g[0] - 2 * g[1] + 2 * g[3] / 3,
            3 * g[0] + g[1] - g[2] / 2 + g[3] / 6 - 4,
            1 - g[0],
        ]
    )


def poles(gains: Gains) -> tuple[complex, ...]:
    """Roots of the characteristic polynomial, largest magnitude first.

    A root of multiplicity m is known to about the m-th root of the rounding error: four equal poles to 1e-4. Their
    errors are symmetric, so that `gains_from_poles` gives the gains back all the same.
    """
    roots = np.roots(characteristic_polynomial(gains))
    # Where a gain of 1 lowers the degree, the missing roots lie at zero.
    padded = [complex(root) for root in roots] + [0j] * (gains.order - len(roots))
    return tuple(sorted(padded, key=lambda root: (-abs(root), -root.imag)))


def gains_from_poles(roots: Sequence[complex]) -> FloatArray:
    """The gains that place the poles.

    Args:
        roots: two, three or four numbers, closed under conjugation.

    Returns:
        Normalised gains, shape (order,).

    Raises:
        InputError: for another number of poles, one that is not finite, or one without its conjugate.
    """
    if len(roots) not in ORDERS:
        raise InputError("poles", "must be 2, 3 or 4 numbers", len(roots))
    values = [complex(root) for root in roots]
    if not all(isfinite(value.real) and isfinite(value.imag) for value in values):
        raise InputError("poles", "must be finite numbers", roots)
    sums = symmetric_sums([1 - value for value in values])
    scale = max(1.0, *(abs(value) ** len(values) for value in values))
    if any(abs(value.imag) > 1e-9 * scale for value in sums):
        raise InputError("poles", "must come in conjugate pairs", roots)
    return gains_from_offsets([1 - value for value in values])


def gains_from_offsets(offsets: Sequence[complex]) -> FloatArray:
    """The gains that place poles at 1 - u for the given u, which are closed under conjugation; shape (order,)."""
    # Sums that an order does not have are zero, and one formula serves all.
    e1, e2, e3, e4, *_ = (*(value.real for value in symmetric_sums(offsets)), 0.0, 0.0)
    return np.array([e1 - e2 + e3 - e4, e2 - 1.5 * e3 + 11 / 6 * e4, e3 - 2 * e4, e4])[: len(offsets)]


def symmetric_sums(values: Sequence[complex]) -> list[complex]:
    """Elementary symmetric polynomials e_1 ... e_n of n values: the coefficients of the product of (1 + u x)."""
    sums = [1 + 0j]
    for value in values:
        sums = [left + value * right for left, right in zip([*sums, 0j], [0j, *sums], strict=True)]
    return sums[1:]


def move_pole(roots: Sequence[complex], index: int, target: complex) -> tuple[complex, ...]:
    """The poles after a hand has dragged one of them.

    The conjugate of a complex pole follows as its mirror image; a pair brought to the real axis (within SNAP) becomes
    two equal real poles. A real pole moves along the axis alone; pulled off it, it takes the nearest other real pole
    along as its conjugate, and stays on the axis where there is none. All other poles stay, but that real ones lose
    what rounding has given them of an imaginary part.

    Args:
        roots: the poles as the hand took hold, closed under conjugation.
        index: which of them is held.
        target: where the hand has brought it.

    Returns:
        The poles in the same order, closed under conjugation.
    """
    values = [complex(root) for root in roots]
    held = values[index]
    others = [i for i in range(len(values)) if i != index]
    real = [i for i in others if abs(values[i].imag) <= SNAP]
    on_axis = abs(target.imag) <= SNAP
    if abs(held.imag) > SNAP:
        partner = min(others, key=lambda i: abs(values[i] - held.conjugate()))
    elif on_axis or not real:
        partner = None
    else:
        partner = min(real, key=lambda i: abs(values[i] - held))
    placed = complex(target.real) if on_axis or (partner is None) else target
    for i in real:
        values[i] = complex(values[i].real)
    values[index] = placed
    if partner is not None:
        values[partner] = placed.conjugate()
    return tuple(values)


def damping_ratio(pole: complex) -> float:
    """zeta = -ln|z| / sqrt(ln^2 |z| + arg^2 z): 1 on the positive real axis, 0 on the unit circle, negative outside."""
    if pole == 0:
        return 1.0
    decay, angle = log(abs(pole)), atan2(pole.imag, pole.real)
    return -decay / hypot(decay, angle) if decay or angle else 0.0


def damping_class(gains: Gains) -> str:
    """How the filter comes back: one of DAMPING.

    Underdamped where a pair of poles is complex; critically damped where all are equal; alternating where all are
    real and one is negative, so that part of the response changes sign at every sample; else overdamped. Order 2 is
    decided by the discriminant (g0 + g1 - 2)^2 - 4(1 - g0); above it poles count as equal within their scatter.
    """
    roots = poles(gains)
    if gains.order == 2:
        g0, g1 = gains.vector.tolist()
        discriminant, scale = (g0 + g1 - 2) ** 2 - 4 * (1 - g0), (g0 + g1 - 2) ** 2 + 4 * abs(1 - g0)
        equal = abs(discriminant) <= 1e-9 * scale
        pair = discriminant < 0 and not equal
    else:
        centre = sum(roots) / len(roots)
        equal = max(abs(root - centre) for root in roots) <= CLUSTER
        pair = not equal and any(abs(root.imag) > CLUSTER for root in roots)
    if pair:
        return "underdamped"
    if min(root.real for root in roots) < -CLUSTER:
        return "alternating"
    return "critically damped" if equal else "overdamped"
