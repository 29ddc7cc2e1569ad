"""Stability of a filter with constant gains: characteristic polynomial, Jury's test, exact regions.

All formulas are in normalised gains g0 ... g3 and do not depend on the sampling interval.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker_core.conventions import Gains
from tracker_core.types import FloatArray


@dataclass(frozen=True, slots=True)
class Condition:
    """One strict inequality of a stability test.

    Attributes:
        text: the inequality, as a reader would write it.
        margin: the side that must be positive; negative by how much it fails.
        numbers: the row of the Jury table it was read from; empty for a closed-form inequality.
    """

    text: str
    margin: float
    numbers: tuple[float, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the inequality is satisfied."""
        return self.margin > 0


@dataclass(frozen=True, slots=True)
class Verdict:
    """What is known of the stability of one gain set.

    Attributes:
        gains: the gain set.
        stable: whether every pole lies inside the unit circle; the border itself counts as unstable.
        spectral_radius: the largest magnitude of a pole, from eigenvalues.
        poles: complex, shape (order,), largest magnitude first.
        conditions: the exact region of this order as inequalities; `stable` is their conjunction.
    """

    gains: Gains
    stable: bool
    spectral_radius: float
    poles: tuple[complex, ...]
    conditions: tuple[Condition, ...]

    @property
    def jury(self) -> tuple[Condition, ...]:
        """The rows of the general Jury table; they come to the same verdict."""
        return jury_table(characteristic_polynomial(self.gains))


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

    A root of multiplicity m is known to about the m-th root of the rounding error: four equal poles to 1e-4.
    """
    roots = np.roots(characteristic_polynomial(gains))
    # Where a gain of 1 lowers the degree, the missing roots lie at zero.
    padded = [complex(root) for root in roots] + [0j] * (gains.order - len(roots))
    return tuple(sorted(padded, key=lambda root: (-abs(root), -root.imag)))


def region_conditions(gains: Gains) -> tuple[Condition, ...]:
    """The exact stable region of the order as inequalities (Jury's test, simplified)."""
    g = gains.vector
    triangle = Condition("4 − 2α − β > 0", float(4 - 2 * g[0] - g[1]))
    if gains.order == 2:
        return (
            Condition("α > 0", float(g[0])),
            Condition("2 − α > 0", float(2 - g[0])),
            Condition("β > 0", float(g[1])),
            triangle,
        )
    if gains.order == 3:
        return (
            Condition("α > 0", float(g[0])),
            Condition("2 − α > 0", float(2 - g[0])),
            Condition("β > 0", float(g[1])),
            triangle,
            Condition("γ > 0", float(g[2])),
            Condition("2αβ − γ(2 − α) > 0", float(2 * g[0] * g[1] - g[2] * (2 - g[0]))),
        )
    product = 6 * g[0] * g[1] * g[2] + 3 * g[0] * g[2] ** 2 + g[0] * g[2] * g[3]
    return (
        Condition("η > 0", float(g[3])),
        Condition("γ > 0", float(g[2])),
        Condition("4α − γ > 0", float(4 * g[0] - g[2])),
        Condition("3β − η > 0", float(3 * g[1] - g[3])),
        Condition("48 + η − 24α − 12β > 0", float(48 + g[3] - 24 * g[0] - 12 * g[1])),
        Condition("6αβγ + 3αγ² + αγη − 6α²η − 6γ² > 0", float(product - 6 * g[0] ** 2 * g[3] - 6 * g[2] ** 2)),
    )


def jury_table(polynomial: FloatArray) -> tuple[Condition, ...]:
    """Jury's table of a real polynomial of any degree >= 1, leading coefficient positive.

    Args:
        polynomial: coefficients, highest power first, shape (degree + 1,).

    Returns:
        One condition per line of the test. All hold exactly when every root lies inside the unit circle
        (Jury 1964, Theory and Application of the z-Transform Method).
    """
    row = np.asarray(polynomial, dtype=np.float64)[::-1]
    degree = len(row) - 1
    signs = np.where(np.arange(degree + 1) % 2 == degree % 2, 1.0, -1.0)
    conditions = [
        Condition("p(1) > 0", float(row.sum()), tuple(row.tolist())),
        Condition("p(−1) > 0" if degree % 2 == 0 else "−p(−1) > 0", float((signs * row).sum()), tuple(row.tolist())),
        Condition(f"|a₀| < a{_subscript(degree)}", float(row[-1] - abs(row[0])), tuple(row.tolist())),
    ]
    for letter in map(chr, range(ord("b"), ord("b") + degree - 2)):
        row = row[0] * row[:-1] - row[-1] * row[:0:-1]
        conditions.append(
            Condition(
                f"|{letter}₀| > |{letter}{_subscript(len(row) - 1)}|",
                float(abs(row[0]) - abs(row[-1])),
                tuple(row.tolist()),
            )
        )
    return tuple(conditions)


def _subscript(number: int) -> str:
    return str(number).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))


def assess(gains: Gains) -> Verdict:
    """Poles and verdict for one gain set."""
    conditions = region_conditions(gains)
    roots = poles(gains)
    return Verdict(
        gains=gains,
        stable=all(condition.holds for condition in conditions),
        spectral_radius=abs(roots[0]),
        poles=roots,
        conditions=conditions,
    )


def beta_bounds(gains: Gains, alpha: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The open interval of normalised beta that is stable at each alpha, with the given gamma and eta.

    Args:
        gains: their order, gamma and eta are used; alpha and beta are not.
        alpha: any shape, inside (max(0, g2/4), 2) for the result to mean anything.

    Returns:
        Lower and upper bound; no beta is stable where the lower one is not below the upper one.
    """
    g = gains.vector
    high = 4 - 2 * alpha
    if gains.order == 2:
        return np.zeros_like(alpha), high
    if gains.order == 3:
        return g[2] * (2 - alpha) / (2 * alpha), high
    curve = alpha * g[3] / g[2] + g[2] / alpha - g[2] / 2 - g[3] / 6
    return np.maximum(curve, g[3] / 3), high + g[3] / 12


def alpha_bounds(gains: Gains) -> tuple[float, float]:
    """The open interval of alpha for which some beta is stable, with the given gamma and eta.

    The two bounds on beta meet where (eta/gamma + 2) alpha^2 - (4 + gamma/2 + eta/4) alpha + gamma = 0, and that
    factors: alpha = gamma/4 and alpha = 4 gamma/(eta + 2 gamma). The second is 2 for order 3.

    Args:
        gains: their order, gamma and eta are used; alpha and beta are not.

    Returns:
        Lower and upper bound; no alpha is stable where the lower one is not below the upper one.
    """
    g = gains.vector
    if gains.order == 2:
        return 0.0, 2.0
    eta = g[3] if gains.order == 4 else 0.0
    if g[2] <= 0 or (gains.order == 4 and eta <= 0):
        return 0.0, 0.0
    return float(g[2] / 4), float(4 * g[2] / (eta + 2 * g[2]))


def region_slice(gains: Gains, points: int = 200) -> tuple[FloatArray, FloatArray]:
    """Border of the stable region in the (alpha, beta) plane through the given gamma and eta.

    Args:
        gains: their order, gamma and eta are used; alpha and beta are not.
        points: samples along the lower and along the upper border.

    Returns:
        Normalised alpha and beta of a closed polygon; both empty where no (alpha, beta) is stable.
    """
    left, right = alpha_bounds(gains)
    if left >= right:
        return np.empty(0), np.empty(0)
    # Closer samples where the border bends, towards the ends.
    alpha = left + (right - left) * (1 - np.cos(np.linspace(0, np.pi, points))) / 2
    low, high = beta_bounds(gains, alpha)
    # The bounds meet at both ends, exactly but for rounding.
    high = np.maximum(low, high)
    return np.concatenate((alpha, alpha[::-1], alpha[:1])), np.concatenate((low, high[::-1], low[:1]))
