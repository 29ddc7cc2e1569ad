"""Gain conventions: what the numbers alpha, beta, gamma, eta multiply.

Inside, every gain is *normalised*: the innovation e corrects derivative i by g[i] e / T^i. Authors write the
third and fourth gain differently; the numbers are converted here, once, and nowhere else.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tracker_core.checks import Domain, InputError, check_choice
from tracker_core.types import GAIN_NAMES, ORDERS, FloatArray

GAIN = Domain(-1000, 1000)
"""What a user may give as a gain: far beyond anything stable."""

WRITTEN = Domain(-1e9, 1e9)
"""What a gain may be in any convention: keeps its powers finite."""


@dataclass(frozen=True, slots=True)
class Convention:
    """One way of writing the gains.

    Attributes:
        name: key in the registry.
        title: for menus.
        terms: what multiplies the innovation in the acceleration and in the jerk correction.
        factors: normalised gain divided by written gain, for alpha, beta, gamma, eta.
        used_by: where it is found.
    """

    name: str
    title: str
    terms: tuple[str, str]
    factors: tuple[float, float, float, float]
    used_by: str


CONVENTIONS: dict[str, Convention] = {
    c.name: c
    for c in (
        Convention("normalised", "γ/T², η/T³", ("γ/T²", "η/T³"), (1, 1, 1, 1), "Kalata; Gray & Murray"),
        Convention("taylor", "2γ/T², 6η/T³", ("2γ/T²", "6η/T³"), (1, 1, 2, 6), "Brookner's g-h-k; Garg; Jeong eq. 6"),
        Convention(
            "half", "γ/2T², η/6T³", ("γ/2T²", "η/6T³"), (1, 1, 1 / 2, 1 / 6), "Bar-Shalom; Yu & Wu; Jeong eq. 23-24"
        ),
    )
}


@dataclass(frozen=True, slots=True)
class Gains:
    """A gain vector in a stated convention; two, three or four gains make a filter of that order.

    Attributes:
        values: alpha, beta[, gamma[, eta]] as written in `convention`, dimensionless; any sequence of numbers is taken.
        convention: a name in CONVENTIONS.

    Raises:
        InputError: for a number of gains other than 2 to 4, a gain outside WRITTEN, or an unknown convention.
    """

    values: tuple[float, ...]
    convention: str = "normalised"

    def __post_init__(self) -> None:
        if len(self.values) not in ORDERS:
            raise InputError("gains", "must be 2, 3 or 4 numbers", self.values)
        # Whatever they came as, they are plain numbers here: equal gains are equal, and can be remembered.
        values = tuple(WRITTEN.check(name, value) for name, value in zip(GAIN_NAMES, self.values, strict=False))
        object.__setattr__(self, "values", values)
        check_choice("convention", self.convention, CONVENTIONS)

    @classmethod
    def normalised(cls, g: Sequence[float] | FloatArray) -> Gains:
        """Gains from a normalised vector of length 2 to 4."""
        return cls(tuple(g))

    @property
    def order(self) -> int:
        """Number of states of the filter per axis."""
        return len(self.values)

    @property
    def vector(self) -> FloatArray:
        """The normalised gain vector g, shape (order,)."""
        return np.array(self.to("normalised").values, dtype=np.float64)

    def to(self, convention: str) -> Gains:
        """The same filter, its gains written in another convention.

        Exact for gamma; for eta to one unit in the last place, since a sixth has no finite binary form.
        """
        if convention == self.convention:
            return self
        check_choice("convention", convention, CONVENTIONS)
        values = tuple(rewrite(value, i, self.convention, convention) for i, value in enumerate(self.values))
        # Checked as they were given; in other words they may be larger.
        other = object.__new__(Gains)
        object.__setattr__(other, "values", values)
        object.__setattr__(other, "convention", convention)
        return other


def rewrite(value: float, index: int, source: str, target: str) -> float:
    """One gain rewritten: `index` 0 to 3 for alpha to eta, from convention `source` to `target`."""
    ratio = CONVENTIONS[source].factors[index] / CONVENTIONS[target].factors[index]
    whole = round(max(ratio, 1 / ratio))
    # Multiplying or dividing by the whole number keeps the rounding to one operation.
    if math.isclose(ratio, whole):
        return value * whole
    return value / whole
