"""Gray & Murray 1993: the steady Kalman filter of order 3 from the tracking index, in closed form."""

from math import cbrt, sqrt

from tracker_core.design.base import Design
from tracker_core.design.kalata import TRACKING_INDEX


def damping(tracking_index: float) -> float:
    """u = 1 - s, where s in (0, 1) solves s^3 + (L/2 - 3) s^2 + (L/2 + 3) s - 1 = 0.

    Cardano's formula gives s; it cancels digits away from L = 1. The same equation in u, u^3 = (L/2)(1 - u)(2 - u),
    does not, so that Newton steps on it bring them back.
    """
    half = tracking_index / 2
    b, c, d = half - 3, half + 3, -1.0
    p = c - b**2 / 3
    q = 2 * b**3 / 27 - b * c / 3 + d
    z = -cbrt((q + sqrt(max(q**2 + 4 * p**3 / 27, 0))) / 2)
    s = z - p / (3 * z) - b / 3 if z else 0.0
    u = 1 - s if 0 < s < 1 else 0.5
    for _ in range(60):
        step = (u**3 - half * (1 - u) * (2 - u)) / (3 * u**2 + half * (3 - 2 * u))
        u -= step
        if abs(step) <= 1e-16 * u:
            break
    return u


def order3(tracking_index: float) -> tuple[float, float, float]:
    """alpha = 1 - s^2, beta = 2(1 - s)^2, gamma = beta^2/(2 alpha)."""
    u = damping(tracking_index)
    alpha, beta = u * (2 - u), 2 * u**2
    return alpha, beta, beta**2 / (2 * alpha)


DESIGN = Design(
    name="gray-murray",
    title="Gray–Murray (exact)",
    parameters={"tracking_index": TRACKING_INDEX},
    formulas={3: order3},
    formula={3: "s³ + (Λ/2 − 3)s² + (Λ/2 + 3)s − 1 = 0,  α = 1 − s²,  β = 2(1 − s)²,  γ = β²/(2α)"},
    source="Gray & Murray 1993, IEEE Trans. Aerospace and Electronic Systems 29(3)",
    remark="Λ = σ_w T²/σ_v; the process noise is a step of acceleration at every sample.",
)
