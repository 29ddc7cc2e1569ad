"""Simpson 1963, Neal & Benedict 1967: the optimisation condition of the third-order tracker."""

from tracker_core.checks import Domain
from tracker_core.design.base import Design


def order3(alpha: float, beta: float) -> tuple[float, float, float]:
    """The third gain that satisfies 2 beta - alpha (alpha + beta + gamma/2) = 0."""
    return alpha, beta, 2 * (2 * beta / alpha - alpha - beta)


DESIGN = Design(
    name="simpson",
    title="Simpson",
    parameters={"alpha": Domain(1e-4, 2, high_open=True), "beta": Domain(0, 1000, low_open=True)},
    formulas={3: order3},
    formula={3: "2β − α(α + β + γ/2) = 0"},
    source="Simpson 1963, IEEE Trans. Automatic Control AC-8, 182-183; Jeong et al. 2017, eq. 8",
    remark="With the Benedict–Bordner β the condition gives γ = 0, and a smaller β a negative γ: "
    "a stable filter needs β > α² / (2 − α).",
)
