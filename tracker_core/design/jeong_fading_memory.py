"""The fading-memory gains as Jeong, Njonjo & Pan 2017 ran them: with twice the acceleration gain."""

from tracker_core.design import fading_memory
from tracker_core.design.base import Design


def order3(xi: float) -> tuple[float, float, float]:
    """gamma of eq. 16 put into eq. 6, which applies 2 gamma/T^2."""
    alpha, beta, gamma = fading_memory.order3(xi)
    return alpha, beta, 2 * gamma


def order4(xi: float) -> tuple[float, float, float, float]:
    """gamma of eq. 27 applied as 2 gamma/T^2; eta of eq. 28 applied as 6 eta/T^3, which is the design's own."""
    alpha, beta, gamma, eta = fading_memory.order4(xi)
    return alpha, beta, 2 * gamma, eta


AS_RUN = Design(
    name="jeong-fading-memory-as-run",
    title="Fading memory of Jeong, as run",
    parameters={"xi": fading_memory.XI},
    formulas={3: order3, 4: order4},
    formula={
        3: "α = 1 − ξ³,  β = 3/2 (1 − ξ)²(1 + ξ),  γ = (1 − ξ)³ applied as 2γ/T²",
        4: "α = 1 − ξ⁴,  β = (1 − ξ)²(11 + 14ξ + 11ξ²)/6,  γ = 2(1 − ξ)³(1 + ξ) applied as 2γ/T²,  η = (1 − ξ)⁴",
    },
    source="Jeong, Njonjo & Pan 2017, eq. 14-16 and 25-28 put into eq. 6; Njonjo et al. 2016",
    remark="The acceleration gain is twice that of the fading-memory filter, so the poles are no longer equal.",
)
