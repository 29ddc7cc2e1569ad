"""How good a track is: totals, RMSE, greatest errors, L2, noise reduction, lag; jointly and per axis.

The error of a sample is the Euclidean distance to the truth (jointly) or the absolute difference (per axis).
Samples at which an error is not defined (before the start, missing, after a stop) do not count.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite, sqrt

import numpy as np

from tracker_core.analysis import steady_lag
from tracker_core.conventions import Gains
from tracker_core.types import BoolArray, FloatArray, Measurements, Track, Truth


@dataclass(frozen=True, slots=True)
class Metric:
    """One figure of merit, in words.

    Attributes:
        title: for cards and tables.
        unit: SI symbol; empty for a pure number.
        sentence: what it is, plainly.
        formula: how it is computed.
        lower_is_better: whether a smaller number is the better one.
    """

    title: str
    unit: str
    sentence: str
    formula: str
    lower_is_better: bool = True


METRICS: dict[str, Metric] = {
    "tracking_total": Metric(
        "Tracking error, total", "m", "Distances between predicted and true position, added up over the run.",
        "Σ ‖predicted − true‖"),
    "estimation_total": Metric(
        "Estimation error, total", "m", "Distances between smoothed and true position, added up over the run.",
        "Σ ‖smoothed − true‖"),
    "innovation_total": Metric(
        "Innovation, total", "m", "Distances between measured and predicted position, added up; needs no truth.",
        "Σ ‖observed − predicted‖"),
    "tracking_rmse": Metric(
        "Tracking RMSE", "m", "Root mean square distance between predicted and true position.",
        "√(Σ ‖predicted − true‖² / N)"),
    "estimation_rmse": Metric(
        "Estimation RMSE", "m", "Root mean square distance between smoothed and true position.",
        "√(Σ ‖smoothed − true‖² / N)"),
    "observation_rmse": Metric(
        "Measurement RMSE", "m", "Root mean square distance between measured and true position: what no filter gives.",
        "√(Σ ‖observed − true‖² / N)"),
    "tracking_max": Metric(
        "Greatest tracking error", "m", "The largest distance between predicted and true position.",
        "max ‖predicted − true‖"),
    "estimation_max": Metric(
        "Greatest estimation error", "m", "The largest distance between smoothed and true position.",
        "max ‖smoothed − true‖"),
    "tracking_l2": Metric(
        "Tracking L2", "m", "Euclidean norm of all tracking errors divided by their number, as Yu & Wu use it.",
        "√(Σ ‖predicted − true‖²) / N"),
    "estimation_l2": Metric(
        "Estimation L2", "m", "Euclidean norm of all estimation errors divided by their number, as Yu & Wu use it.",
        "√(Σ ‖smoothed − true‖²) / N"),
    "noise_reduction": Metric(
        "Noise reduction", "%", "How much of the measurement error the filter removes; negative: worse than raw.",
        "100 (1 − estimation RMSE / measurement RMSE)", lower_is_better=False),
    "lag": Metric(
        "Steady lag", "m", "How far the smoothed position would trail a steady manoeuvre as strong as this target's "
        "(RMS of the first derivative the filter does not model), or lead it where α > 1; none where that comes in "
        "impulses.",
        "|1 − α| T^m D / g_last, D the RMS m-th derivative of the truth with its random pushes, m the order"),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Metrics:
    """The figures of merit of one track.

    Attributes:
        tracking_total ... lag: as METRICS describes them under the same names, m, but noise_reduction in percent;
            None where undefined (no truth, no prediction, unstable gains).
    """

    tracking_total: float | None
    estimation_total: float | None
    innovation_total: float | None
    tracking_rmse: float | None
    estimation_rmse: float | None
    observation_rmse: float | None
    tracking_max: float | None
    estimation_max: float | None
    tracking_l2: float | None
    estimation_l2: float | None
    noise_reduction: float | None
    lag: float | None

    def to_dict(self) -> dict[str, float | None]:
        """Plain numbers by name."""
        return {item.name: getattr(self, item.name) for item in fields(self)}


def distances(difference: FloatArray) -> FloatArray:
    """Euclidean length over the axes, shape (n_samples,); NaN where any axis is NaN."""
    if difference.shape[1] == 1:
        return np.abs(difference[:, 0])
    return np.sqrt(np.einsum("ij,ij->i", difference, difference))


def manoeuvre_strength(truth: Truth, order: int, pushes: float = 0.0) -> float:
    """The root mean square of the first derivative that a filter does not model, over all axes together, m/s^order.

    Args:
        truth: what the target did; NaN makes it NaN.
        order: of the filter.
        pushes: root mean square of what is not in the truth's states, in each axis: see `manoeuvre.held_std`.
    """
    manoeuvre = truth.states[:, :, order]
    return sqrt(float(np.einsum("ij,ij", manoeuvre, manoeuvre)) / len(manoeuvre) + manoeuvre.shape[1] * pushes**2)


def measure(
    track: Track, measurements: Measurements, truth: Truth | None, gains: Gains, *, stable: bool, pushes: float = 0.0
) -> Metrics:
    """Joint figures of merit of a track.

    What a gate refused does not count among the innovations, but among the errors of the measurements: those of the
    filter have to be compared with what there was.

    Args:
        track: what the filter made.
        measurements: what it saw.
        truth: what was there, or None if nobody knows; error figures are then None.
        gains: of the filter, for the lag.
        stable: whether the gains are stable; there is no lag to speak of where they are not.
        pushes: as for `manoeuvre_strength`.
    """
    lag = None
    if truth is not None and stable and measurements.interval is not None:
        lag = abs(steady_lag(gains, measurements.interval, manoeuvre_strength(truth, gains.order, pushes)))
        lag = lag if isfinite(lag) else None
    predicted, smoothed = track.predicted[:, :, 0], track.smoothed[:, :, 0]
    known = None if truth is None else truth.positions
    return _figures(predicted, smoothed, measurements.positions, known, lag, track.rejected)


def measure_axes(
    track: Track, measurements: Measurements, truth: Truth | None, gains: Gains, *, stable: bool, pushes: float = 0.0
) -> tuple[Metrics, ...]:
    """The same per axis, as if each were a track of its own."""
    return tuple(
        measure(
            Track(
                predicted=track.predicted[:, [axis]],
                smoothed=track.smoothed[:, [axis]],
                innovation=track.innovation[:, [axis]],
                missing=track.missing,
                stopped_at=track.stopped_at,
                limit=track.limit,
                rejected=track.rejected,
                spread=None if track.spread is None else track.spread[:, [axis]],
            ),
            Measurements(measurements.times, measurements.positions[:, [axis]], measurements.interval),
            None if truth is None else Truth(truth.times, truth.states[:, [axis]]),
            gains,
            stable=stable,
            pushes=pushes,
        )
        for axis in range(measurements.positions.shape[1])
    )


def _figures(
    predicted: FloatArray, smoothed: FloatArray, observed: FloatArray, true: FloatArray | None, lag: float | None,
    rejected: BoolArray | None,
) -> Metrics:  # fmt: skip
    believed = observed if rejected is None else np.where(rejected[:, None], np.nan, observed)
    innovation = _summary(believed, predicted)
    tracking, estimation, raw = (_summary(what, true) for what in (predicted, smoothed, observed))
    reduction = None
    if estimation.rms is not None and raw.rms:
        reduction = 100 * (1 - estimation.rms / raw.rms)
    return Metrics(
        tracking_total=tracking.total,
        estimation_total=estimation.total,
        innovation_total=innovation.total,
        tracking_rmse=tracking.rms,
        estimation_rmse=estimation.rms,
        observation_rmse=raw.rms,
        tracking_max=tracking.greatest,
        estimation_max=estimation.greatest,
        tracking_l2=tracking.l2,
        estimation_l2=estimation.l2,
        noise_reduction=reduction,
        lag=lag,
    )


@dataclass(frozen=True, slots=True)
class _Summary:
    total: float | None = None
    rms: float | None = None
    greatest: float | None = None
    l2: float | None = None


def _summary(positions: FloatArray, reference: FloatArray | None) -> _Summary:
    """The errors between two sets of positions, (n_samples, n_axes), where both are defined."""
    if reference is None:
        return _Summary()
    errors = distances(positions - reference)
    errors = errors[~np.isnan(errors)]
    if not errors.size:
        return _Summary()
    with np.errstate(over="ignore"):
        squares = float(errors @ errors)
    return _Summary(
        total=float(errors.sum()),
        rms=sqrt(squares / errors.size),
        greatest=float(errors.max()),
        l2=sqrt(squares) / errors.size,
    )
