"""Benedict & Bordner 1962: least noise for a given transient response to a ramp."""

from tracker_core.checks import Domain
from tracker_core.design.base import Design


def order2(alpha: float) -> tuple[float, float]:
    """beta = alpha^2/(2 - alpha); equals the steady Kalman filter with process noise diag(0, q) on velocity."""
    return alpha, alpha**2 / (2 - alpha)


DESIGN = Design(
    name="benedict-bordner",
    title="Benedict–Bordner",
    parameters={"alpha": Domain(0, 2, low_open=True, high_open=True)},
    formulas={2: order2},
    formula={2: "β = α² / (2 − α)"},
    source="Benedict & Bordner 1962, IRE Trans. Automatic Control AC-7, 27-32; Jeong et al. 2017, eq. 7",
)
