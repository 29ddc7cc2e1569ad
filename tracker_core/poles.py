"""Characteristic polynomial and poles of a filter with constant gains, and the gains that place given poles.

All formulas are in normalised gains and do not depend on the sampling interval. With u = 1 - z for every pole z and
e_k the k-th elementary symmetric polynomial of the u, the gains are linear in the e_k; near z = 1, where good filters
have their poles, no digits cancel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache, lru_cache
from itertools import chain
from math import atan2, fsum, hypot, isfinite, log
from typing import NamedTuple

import numpy as np

from tracker_core.checks import InputError
from tracker_core.conventions import Gains
from tracker_core.types import ORDERS, FloatArray

SNAP = 0.008
"""A pole brought as near as this to the real axis is put on it; near z = 1 a fifth of its distance from there."""

REAL = 2e-3
"""A pole whose imaginary part is no more of its distance from 1 than this is a real one, but for digits of gains."""

CLUSTER = 1e-3
"""Poles no farther apart than this may be equal ones, as a share of their distance from z = 1."""

ROUNDING = 8 * float(np.finfo(float).eps)
"""What rounding does to a polynomial and its derivatives, as a share of the terms that they are the sum of: gains that
place equal poles leave up to 3.4 epsilon."""

LARGEST = 1e12
"""No gains that can be written have a larger pole."""

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


def offset_polynomial(gains: Gains) -> FloatArray:
    """The characteristic polynomial in powers of z - 1, highest first, shape (order + 1,).

    Its coefficients are the symmetric sums of u = 1 - z, and sums of gains: no digits cancel.
    """
    g0, g1, g2, g3 = padded(gains.vector)
    sums = [1.0, g0 + g1 + g2 / 2 + g3 / 6, g1 + 3 / 2 * g2 + 7 / 6 * g3, g2 + 2 * g3, g3]
    return np.array(sums[: gains.order + 1])


@lru_cache(maxsize=64)
def poles(gains: Gains) -> tuple[complex, ...]:
    """Roots of the characteristic polynomial, largest magnitude first.

    Found around z = 1 or around z = 0, whichever is nearer to them, so that they keep their digits at either. Rounding
    parts m equal roots by its m-th root, four by 1e-4; what is an m-fold root but for the rounding of the gains is
    returned m times, and has all its digits.
    """
    g = gains.vector
    # The products of all |1 - z| and of all |z|.
    if abs(g[-1]) <= abs(1 - g[0]):
        centre, polynomial = 1.0, offset_polynomial(gains)
    else:
        centre, polynomial = 0.0, characteristic_polynomial(gains)
    found = _united([centre + root for root in _roots(polynomial)], gains)
    return tuple(sorted(found, key=lambda root: (-abs(root), -root.imag)))


def _roots(polynomial: FloatArray) -> list[complex]:
    """The roots of a polynomial with a leading 1, highest power first: the eigenvalues of its companion matrix."""
    degree = int(np.flatnonzero(polynomial)[-1])
    companion = np.eye(degree, k=-1)
    companion[:1] = -polynomial[1 : degree + 1]
    # Roots at 0 lower the degree.
    return [complex(root) for root in (*np.linalg.eigvals(companion), *[0.0] * (len(polynomial) - 1 - degree))]


def _united(roots: list[complex], gains: Gains) -> list[complex]:
    """The roots of the characteristic polynomial, those that are one root several times made equal."""
    groups: list[list[complex]] = []
    for root in roots:
        near = [group for group in groups if any(_may_be_equal(root, other) for other in group)]
        groups = [group for group in groups if group not in near] + [[root, *chain(*near)]]
    if len(groups) == len(roots):
        return roots
    around = _Around.of(gains, 1.0, offset_polynomial), _Around.of(gains, 0.0, characteristic_polynomial)
    return [root for group in groups for root in _repeated(group, around)]


def _may_be_equal(one: complex, other: complex) -> bool:
    return abs(one - other) <= CLUSTER * abs(1 - (one + other) / 2)


class _Around(NamedTuple):
    """The characteristic polynomial in powers of the distance from a centre, highest first.

    Attributes:
        centre: 1 or 0.
        polynomial: its coefficients.
        terms: the sizes of the terms that each of them is the sum of.
    """

    centre: float
    polynomial: FloatArray
    terms: FloatArray

    @classmethod
    def of(cls, gains: Gains, centre: float, write: Callable[[Gains], FloatArray]) -> _Around:
        """The polynomial of these gains, as `write` gives it."""
        constant, slopes = _parts(write, gains.order)
        return cls(centre, write(gains), np.abs(constant) + np.abs(gains.vector) @ np.abs(slopes))

    def refined(self, root: complex, times: int) -> complex:
        """A root of so many times, from nearby: it is a simple one of a derivative, and has all its digits there."""
        derivative = np.polyder(self.polynomial, times - 1)
        offset = complex(root - self.centre)
        for _ in range(3):
            slope = np.polyval(np.polyder(derivative), offset)
            if slope == 0:
                break
            offset -= complex(np.polyval(derivative, offset) / slope)
        return self.centre + offset

    def is_root(self, root: complex, times: int) -> bool:
        """Whether the polynomial and its lower derivatives vanish there, but for rounding."""
        offset = root - self.centre
        return all(
            abs(np.polyval(np.polyder(self.polynomial, n), offset))
            <= ROUNDING * np.polyval(np.polyder(self.terms, n), abs(offset))
            for n in range(times)
        )


def _repeated(group: list[complex], around: tuple[_Around, _Around]) -> list[complex]:
    """Roots near each other: as many as possible of them as one root, the others as they are."""
    others: list[complex] = []
    while len(group) > 1:
        # A group that is its own mirror image has a real mean, exactly.
        mean = complex(fsum(root.real for root in group), fsum(root.imag for root in group)) / len(group)
        root = around[0].refined(mean, len(group))
        if all(way.is_root(root, len(group)) for way in around):
            return [root] * len(group) + others
        farthest = max(abs(root - mean) for root in group)
        # With its mirror image, which is as far away.
        gone = [root for root in group if abs(root - mean) >= farthest * (1 - CLUSTER)]
        others += gone
        group = [root for root in group if root not in gone]
    return group + others


@cache
def _parts(write: Callable[[Gains], FloatArray], order: int) -> tuple[FloatArray, FloatArray]:
    """A polynomial whose coefficients are linear in the gains: its constant part, and what each gain adds to it."""
    constant = write(Gains((0.0,) * order))
    units = [Gains(tuple(row)) for row in np.eye(order).tolist()]
    return constant, np.array([write(unit) - constant for unit in units])


def padded(values: Iterable[float]) -> list[float]:
    """As many numbers as the highest order has, zeros after those given: one formula serves all orders."""
    return [*(float(value) for value in values), 0.0, 0.0][: max(ORDERS)]


def gains_from_poles(roots: Sequence[complex]) -> FloatArray:
    """The gains that place the poles.

    Args:
        roots: two, three or four numbers, closed under conjugation.

    Returns:
        Normalised gains, shape (order,).

    Raises:
        InputError: for another number of poles, one beyond LARGEST, or one without its conjugate.
    """
    if len(roots) not in ORDERS:
        raise InputError("poles", "must be 2, 3 or 4 numbers", len(roots))
    values = [complex(root) for root in roots]
    if not all(abs(value) <= LARGEST for value in values):
        raise InputError("poles", f"must be numbers of magnitude <= {LARGEST:g}", roots)
    sums = symmetric_sums([1 - value for value in values])
    scale = max(1.0, *(abs(value) ** len(values) for value in values))
    if any(abs(value.imag) > 1e-9 * scale for value in sums):
        raise InputError("poles", "must come in conjugate pairs", roots)
    return np.array(gains_from_offsets([1 - value for value in values]))


def gains_from_offsets(offsets: Sequence[complex]) -> tuple[float, ...]:
    """The gains that place poles at 1 - u for the given u, which are closed under conjugation."""
    e1, e2, e3, e4 = padded(value.real for value in symmetric_sums(offsets))
    return (e1 - e2 + e3 - e4, e2 - 1.5 * e3 + 11 / 6 * e4, e3 - 2 * e4, e4)[: len(offsets)]


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

    Raises:
        InputError: for a target that is not finite.
    """
    if not isfinite(abs(target)):
        raise InputError("target", "must be a finite number", target)
    values = [complex(root) for root in roots]
    held = values[index]
    others = [i for i in range(len(values)) if i != index]
    real = [i for i in others if is_real(values[i])]
    on_axis = abs(target.imag) <= min(SNAP, abs(1 - target) / 5)
    if not is_real(held):
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


def is_real(pole: complex) -> bool:
    """Whether a pole lies on the real axis, within what rounding does to equal ones."""
    return abs(pole.imag) <= REAL * abs(1 - pole)


def damping_ratio(pole: complex) -> float:
    """zeta = -ln|z| / sqrt(ln^2 |z| + arg^2 z): 1 on the positive real axis, 0 on the unit circle, negative outside."""
    if pole == 0:
        return 1.0
    decay, angle = log(abs(pole)), atan2(pole.imag, pole.real)
    return -decay / hypot(decay, angle) if decay or angle else 0.0


def damping_class(gains: Gains) -> str:
    """How the filter comes back: one of DAMPING.

    Underdamped where a pair of poles is complex; alternating where all are real and one is negative, so that part of
    the response changes sign at every sample; critically damped where all are equal; else overdamped. Order 2 is
    decided by the discriminant (g0 + g1 - 2)^2 - 4(1 - g0); above it poles count as equal within CLUSTER, so that gains
    which are written with a few digits do.
    """
    roots = poles(gains)
    if gains.order == 2:
        # In the u, so that small gains keep their digits.
        e1, e2 = offset_polynomial(gains)[1:].tolist()
        discriminant, scale = e1**2 - 4 * e2, e1**2 + 4 * abs(e2)
        equal = abs(discriminant) <= 1e-9 * scale
        pair = discriminant < 0 and not equal
    else:
        centre = sum(roots) / len(roots)
        equal = max(abs(root - centre) for root in roots) <= CLUSTER * abs(1 - centre)
        pair = not equal and any(abs(root.imag) > CLUSTER * abs(1 - root) for root in roots)
    if pair:
        return "underdamped"
    if min(root.real for root in roots) < -CLUSTER:
        return "alternating"
    return "critically damped" if equal else "overdamped"
