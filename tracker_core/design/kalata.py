"""Kalata 1984: the steady Kalman filter of order 2 from the tracking index."""

from math import sqrt

from tracker_core.checks import Domain
from tracker_core.design.base import Design

TRACKING_INDEX = Domain(1e-12, 1e6)
"""Below it the gains are nothing, above it alpha is 1 to the last digit."""


def damping(tracking_index: float) -> float:
    """u = 1 - r, where r = (4 + L - sqrt(8L + L^2))/4, in the form that keeps its digits at small L."""
    return 2 * tracking_index / (sqrt(8 * tracking_index + tracking_index**2) + tracking_index)


def order2(tracking_index: float) -> tuple[float, float]:
    """alpha = 1 - r^2, beta = 2(2 - alpha) - 4 sqrt(1 - alpha) = 2(1 - r)^2."""
    u = damping(tracking_index)
    return u * (2 - u), 2 * u**2


DESIGN = Design(
    name="kalata",
    title="Kalata",
    parameters={"tracking_index": TRACKING_INDEX},
    formulas={2: order2},
    formula={2: "r = (4 + Λ − √(8Λ + Λ²))/4,  α = 1 − r²,  β = 2(1 − r)²"},
    source="Kalata 1984, IEEE Trans. Aerospace and Electronic Systems AES-20, 174-182",
    remark="Λ = σ_w T²/σ_v; the process noise is an acceleration held over the interval.",
)
