"""What a filter is worth before it has seen a sample: the figures of merit that follow from the gains alone."""

from __future__ import annotations

from contextlib import suppress
from math import isfinite

from tracker_core.checks import InputError
from tracker_core.conventions import Gains
from tracker_core.fields import INTERVAL
from tracker_core.metrics import Metric
from tracker_core.optimal import distance_from_optimal
from tracker_core.poles import damping_ratio, poles
from tracker_core.responses import lag_coefficient, predicted_variance, smoothed_variance, steady_variance, step_figures
from tracker_core.stability import is_stable

MERITS: dict[str, Metric] = {
    "noise_gain": Metric(
        "Noise gain", "", "Variance of the smoothed position per variance of the measurements: 1 removes nothing.",
        "P₀₀ of P = A P Aᵀ + K Kᵀ, A = (I − K H) F"),
    "predicted_noise_gain": Metric(
        "Noise gain, predicted", "", "Variance of the predicted position per variance of the measurements.",
        "P₀₀ of F P Fᵀ"),
    "unit_lag": Metric(
        "Lag per unit", "m", "How far the smoothed position trails a steady manoeuvre of one unit, or leads it where "
        "α > 1: 1 m/s² for order 2, 1 m/s³ for order 3, 1 m/s⁴ for order 4.",
        "|1 − α| T^m / g_last, m the order"),
    "overshoot": Metric(
        "Overshoot", "%", "How far the smoothed position shoots past a step of the measured position.",
        "100 (max response − 1)"),
    "settling": Metric(
        "Settling time", "s", "Time after which the response to a step stays within 2 % of it.",
        "n T, n the samples until |1 − response| stays below 0.02"),
    "damping": Metric(
        "Damping ratio", "", "Of the slowest pole: 1 comes back without oscillating, near 0 rings for long.",
        "ζ = −ln|z| / √(ln²|z| + arg²z)", lower_is_better=False),
    "spectral_radius": Metric(
        "Largest pole", "", "Magnitude of the slowest pole: what is left of an error after one sample, in the end.",
        "max |z|"),
    "optimal_distance": Metric(
        "From optimal", "%", "How much more error variance these gains cost than the best gains of this order, on the "
        "manoeuvre that suits them best.",
        "min over Λ of P⁻₀₀(g, Λ) / P⁻₀₀(optimal, Λ) − 1"),
}  # fmt: skip


def merits(gains: Gains, interval: float) -> dict[str, float | None]:
    """The figures of merit by name, as MERITS describes them; None where the gains are not stable or it overflows.

    Args:
        gains: any set.
        interval: T, s.

    Raises:
        InputError: for an interval outside that of an experiment.
    """
    interval = INTERVAL.check("interval", interval)
    slowest = poles(gains)[0]
    figures: dict[str, float | None] = dict.fromkeys(MERITS)
    figures["spectral_radius"] = abs(slowest)
    if not is_stable(gains):
        return figures
    vector = gains.vector
    overshoot, settling = (float(value) for value in step_figures(vector))
    figures |= {
        "unit_lag": abs(float(lag_coefficient(vector))) * interval**gains.order,
        "overshoot": 100 * overshoot,
        "settling": settling * interval,
        "damping": damping_ratio(slowest),
    }
    # Rounding may hide that gains are stable.
    with suppress(InputError):
        figures["noise_gain"] = steady_variance(gains, smoothed_variance)
        figures["predicted_noise_gain"] = steady_variance(gains, predicted_variance)
        figures["optimal_distance"] = distance_from_optimal(gains).percent
    return {name: value if value is not None and isfinite(value) else None for name, value in figures.items()}
