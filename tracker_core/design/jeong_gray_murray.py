"""What Jeong, Njonjo & Pan 2017 call the Gray-Murray filter: Kalata's alpha and beta, with a gamma added."""

from tracker_core.design import kalata
from tracker_core.design.base import Design


def order3(tracking_index: float) -> tuple[float, float, float]:
    """Kalata's order-2 gains with gamma = beta^2/(2 alpha)."""
    alpha, beta = kalata.order2(tracking_index)
    return alpha, beta, beta**2 / (2 * alpha)


def order3_as_run(tracking_index: float) -> tuple[float, float, float]:
    """The same numbers with that gamma put into a filter that applies 2 gamma/T^2."""
    alpha, beta, gamma = order3(tracking_index)
    return alpha, beta, 2 * gamma


DESIGN = Design(
    name="jeong-gray-murray",
    title="Gray–Murray of Jeong (approximate)",
    parameters={"tracking_index": kalata.TRACKING_INDEX},
    formulas={3: order3},
    formula={3: "α, β by Kalata from Λ,  γ = β²/(2α)"},
    source="Jeong, Njonjo & Pan 2017, eq. 9-13",
    remark="Not the optimum of order 3: its α and β are those of order 2. The exact Gray–Murray filter is.",
)

AS_RUN = Design(
    name="jeong-gray-murray-as-run",
    title="Gray–Murray of Jeong, as run",
    parameters={"tracking_index": kalata.TRACKING_INDEX},
    formulas={3: order3_as_run},
    formula={3: "α, β by Kalata from Λ,  γ = β²/(2α), applied as 2γ/T²"},
    source="Jeong, Njonjo & Pan 2017, eq. 9-13 put into eq. 6",
    remark="The acceleration gain is twice that of the design equations; reproduces the paper's table 5.",
)
