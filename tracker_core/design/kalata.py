"""Kalata 1984: the steady Kalman filter of order 2 from the tracking index."""

from math import sqrt

from tracker_core.checks import Domain
from tracker_core.design.base import Design

TRACKING_INDEX = Domain(0, 1e6, low_open=True)
"""Beyond the upper end alpha is 1 to the last digit and the formulas lose theirs."""


def damping(tracking_index: float) -> float:
    """r = (4 + L - sqrt(8L + L^2))/4, in the form without cancellation: 4/(4 + L + sqrt(8L + L^2))."""
    return 4 / (4 + tracking_index + sqrt(8 * tracking_index + tracking_index**2))


def order2(tracking_index: float) -> tuple[float, float]:
    """alpha = 1 - r^2, beta = 2(2 - alpha) - 4 sqrt(1 - alpha) = 2(1 - r)^2."""
    r = damping(tracking_index)
    return 1 - r**2, 2 * (1 - r) ** 2


DESIGN = Design(
    name="kalata",
    title="Kalata",
    parameters={"tracking_index": TRACKING_INDEX},
    formulas={2: order2},
    formula={2: "r = (4 + Λ − √(8Λ + Λ²))/4,  α = 1 − r²,  β = 2(1 − r)²"},
    source="Kalata 1984, IEEE Trans. Aerospace and Electronic Systems AES-20, 174-182",
    remark="Λ = σ_w T²/σ_v; the process noise is an acceleration held over the interval.",
)
