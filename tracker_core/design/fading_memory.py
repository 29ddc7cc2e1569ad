"""The fading-memory (discounted least squares) polynomial filters: every pole at xi.

1 - xi^n is written as a product, which keeps its digits near xi = 1.
"""

from tracker_core.checks import Domain
from tracker_core.design.base import Design

XI = Domain(0, 1, high_open=True)


def order2(xi: float) -> tuple[float, float]:
    """Discounted least squares of a straight line."""
    return (1 - xi) * (1 + xi), (1 - xi) ** 2


def order3(xi: float) -> tuple[float, float, float]:
    """Discounted least squares of a parabola."""
    return (1 - xi) * (1 + xi + xi**2), 1.5 * (1 - xi) ** 2 * (1 + xi), (1 - xi) ** 3


def order4(xi: float) -> tuple[float, float, float, float]:
    """Discounted least squares of a cubic."""
    return (
        (1 - xi) * (1 + xi) * (1 + xi**2),
        (1 - xi) ** 2 * (11 + 14 * xi + 11 * xi**2) / 6,
        2 * (1 - xi) ** 3 * (1 + xi),
        (1 - xi) ** 4,
    )


DESIGN = Design(
    name="fading-memory",
    title="Fading memory",
    parameters={"xi": XI},
    formulas={2: order2, 3: order3, 4: order4},
    formula={
        2: "α = 1 − ξ²,  β = (1 − ξ)²",
        3: "α = 1 − ξ³,  β = 3/2 (1 − ξ)²(1 + ξ),  γ = (1 − ξ)³",
        4: "α = 1 − ξ⁴,  β = (1 − ξ)²(11 + 14ξ + 11ξ²)/6,  γ = 2(1 − ξ)³(1 + ξ),  η = (1 − ξ)⁴",
    },
    source="Morrison 1969; Brookner 1998, table 1.2-2; Jeong et al. 2017, eq. 14-16 and 25-28",
    remark="Critically damped: every pole lies at ξ.",
)
