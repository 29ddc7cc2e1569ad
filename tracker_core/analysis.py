"""What the gains buy, without a run: steady-state properties of a filter with constant gains."""

from __future__ import annotations

import numpy as np

from tracker_core.conventions import Gains


def steady_lag(gains: Gains, interval: float, derivative: float, *, predicted: bool = False) -> float:
    """Steady position error under a constant input of the first derivative that the filter does not model.

    Order 2 lags behind an acceleration, order 3 behind a jerk, order 4 behind a snap. By the final-value theorem the
    prediction lags by T^m D / g[m-1] and the smoothed position by (1 - g0) of that, for order m.

    Args:
        gains: a stable set.
        interval: T, s.
        derivative: D, the m-th time derivative of the position, m/s^m.
        predicted: for the prediction instead of the smoothed position.

    Returns:
        The lag in m, with the sign of truth minus estimate; infinite where it is beyond the range of numbers.
    """
    g = gains.vector
    share = 1.0 if predicted else float(1 - g[0])
    if share == 0:
        return 0.0
    with np.errstate(over="ignore"):
        return float(share * (np.float64(interval) ** gains.order * derivative / g[-1]))
