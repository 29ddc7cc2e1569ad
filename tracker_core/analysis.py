"""What the gains buy, without a run: steady-state properties of a filter with constant gains."""

from __future__ import annotations

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
        The lag in m, with the sign of truth minus estimate.
    """
    g = gains.vector
    lag = interval**gains.order * derivative / float(g[-1])
    return lag if predicted else (1 - float(g[0])) * lag
