"""Stability of a filter with constant gains: Jury's test, the exact regions, and what has been printed for them.

All formulas are in normalised gains g0 ... g3 and do not depend on the sampling interval.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from tracker_core.conventions import Gains
from tracker_core.poles import characteristic_polynomial, poles
from tracker_core.types import FloatArray

Number = TypeVar("Number", float, FloatArray)
"""One formula serves a single filter, in plain numbers, and many, in arrays."""

INEQUALITIES: dict[int, tuple[str, ...]] = {
    2: ("α > 0", "2 − α > 0", "β > 0", "4 − 2α − β > 0"),
    3: ("α > 0", "2 − α > 0", "β > 0", "4 − 2α − β > 0", "γ > 0", "2αβ − γ(2 − α) > 0"),
    4: (
        "η > 0",
        "γ > 0",
        "4α − γ > 0",
        "3β − η > 0",
        "48 + η − 24α − 12β > 0",
        "6αβγ + 3αγ² + αγη − 6α²η − 6γ² > 0",
    ),
}
"""The exact stable region of each order."""


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


def region_margins(vectors: FloatArray) -> FloatArray:
    """The left-hand sides of the inequalities in INEQUALITIES, for many gain sets at once.

    Args:
        vectors: normalised gains, shape (..., order).

    Returns:
        Shape (..., number of inequalities); all of a row are positive exactly where its gains are stable.
    """
    return np.stack(margins(*np.moveaxis(np.asarray(vectors, dtype=np.float64), -1, 0)), axis=-1)


def margins(*g: Number) -> tuple[Number, ...]:
    """The left-hand sides of the inequalities in INEQUALITIES.

    Args:
        g: two, three or four normalised gains, each a number or an array of one shape.
    """
    g0, g1 = g[:2]
    if len(g) == 2:
        return g0, 2 - g0, g1, 4 - 2 * g0 - g1
    g2 = g[2]
    if len(g) == 3:
        return g0, 2 - g0, g1, 4 - 2 * g0 - g1, g2, 2 * g0 * g1 - g2 * (2 - g0)
    g3 = g[3]
    roof = 6 * g0 * g1 * g2 + 3 * g0 * (g2 * g2) + g0 * g2 * g3 - 6 * (g0 * g0) * g3 - 6 * (g2 * g2)
    return g3, g2, 4 * g0 - g2, 3 * g1 - g3, 48 + g3 - 24 * g0 - 12 * g1, roof


def stable(vectors: FloatArray) -> NDArray[np.bool_]:
    """Whether every pole lies inside the unit circle: normalised gains (..., order) to shape (...)."""
    return np.all(region_margins(vectors) > 0, axis=-1)


def is_stable(gains: Gains) -> bool:
    """Whether every pole lies inside the unit circle, by the exact region."""
    return all(margin > 0 for margin in margins(*gains.to("normalised").values))


def region_conditions(gains: Gains) -> tuple[Condition, ...]:
    """The exact stable region of the order as inequalities (Jury's test, simplified)."""
    found = margins(*gains.to("normalised").values)
    return tuple(Condition(*pair) for pair in zip(INEQUALITIES[gains.order], found, strict=True))


def jury_table(polynomial: FloatArray) -> tuple[Condition, ...]:
    """Jury's table of a real polynomial of any degree >= 1, leading coefficient positive.

    Args:
        polynomial: coefficients, highest power first, shape (degree + 1,).

    Returns:
        One condition per line of the test. All hold exactly when every root lies inside the unit circle
        (Jury 1964, Theory and Application of the z-Transform Method).
    """
    rows = _jury_rows(np.asarray(polynomial, dtype=np.float64))
    degree = len(rows[0]) - 1
    texts = ["p(1) > 0", "p(−1) > 0" if degree % 2 == 0 else "−p(−1) > 0", f"|a₀| < a{_subscript(degree)}"]
    texts += [
        f"|{letter}₀| > |{letter}{_subscript(len(row) - 1)}|"
        for letter, row in zip(map(chr, range(ord("b"), ord("b") + degree)), rows[1:], strict=False)
    ]
    numbers = [rows[0]] * 3 + rows[1:]
    return tuple(
        Condition(text, margin, tuple(row.tolist()))
        for text, margin, row in zip(texts, jury_margins(polynomial).tolist(), numbers, strict=True)
    )


def jury_margins(polynomials: FloatArray) -> FloatArray:
    """By how much each line of Jury's table holds, for many polynomials of one degree.

    Args:
        polynomials: coefficients, highest power first, shape (..., degree + 1).

    Returns:
        Shape (..., lines), lines in the order of `jury_table`; negative where one fails.
    """
    first, *rest = _jury_rows(np.asarray(polynomials, dtype=np.float64))
    degree = first.shape[-1] - 1
    signs = np.where(np.arange(degree + 1) % 2 == degree % 2, 1.0, -1.0)
    margins = [first.sum(axis=-1), (signs * first).sum(axis=-1), first[..., -1] - np.abs(first[..., 0])]
    return np.stack([*margins, *(np.abs(row[..., 0]) - np.abs(row[..., -1]) for row in rest)], axis=-1)


def _jury_rows(polynomials: FloatArray) -> list[FloatArray]:
    """The rows of Jury's table, lowest power first, from coefficients with the highest first, (..., degree + 1)."""
    rows = [polynomials[..., ::-1]]
    for _ in range(polynomials.shape[-1] - 3):
        row = rows[-1]
        rows.append(row[..., :1] * row[..., :-1] - row[..., -1:] * row[..., :0:-1])
    return rows


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


def printed_conditions(gains: Gains) -> tuple[Condition, ...]:
    """The bounds that Yu & Wu 2017 print for orders 3 (eq. 10-12) and 4 (eq. 21-24); empty for order 2.

    In their convention, "half". At order 3 they hold for all stable gains, and for unstable ones too, by the factor
    13/6 where 1 is right; at order 4 they neither contain the stable region nor lie in it.
    """
    if gains.order == 2:
        return ()
    alpha, beta, gamma, *delta = gains.to("half").values
    conditions = [
        Condition("α > 0", alpha),
        Condition("2 − α > 0", 2 - alpha),
        Condition("β > 0", beta),
        Condition("13/6 (4 − 2α) − β > 0", 13 / 6 * (4 - 2 * alpha) - beta),
        Condition("γ > 0", gamma),
        Condition("4αβ − γ(2 − α) > 0", 4 * alpha * beta - gamma * (2 - alpha)),
    ]
    if delta:
        conditions += [Condition("δ > 0", delta[0]), Condition("24(2 − α) − δ > 0", 24 * (2 - alpha) - delta[0])]
    return tuple(conditions)
