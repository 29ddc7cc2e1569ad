"""The critically damped alpha-beta filter: both poles real and equal."""

from math import sqrt

from tracker_core.checks import Domain
from tracker_core.design.base import Design


def order2(alpha: float) -> tuple[float, float]:
    """beta = 2 - alpha - 2 sqrt(1 - alpha), written as (1 - sqrt(1 - alpha))^2 to keep its digits at small alpha."""
    root = sqrt(1 - alpha)
    return alpha, (alpha / (1 + root)) ** 2


DESIGN = Design(
    name="critically-damped",
    title="Critically damped",
    parameters={"alpha": Domain(0, 1, low_open=True)},
    formulas={2: order2},
    formula={2: "β = 2 − α − 2√(1 − α)"},
    source="Double root of z² + (α + β − 2)z + 1 − α; the fading-memory filter of order 2, Brookner 1998, 1.2",
)
