"""How good a track is where nobody knows the truth: what its innovations, and its path itself, give away.

The innovations of a filter that fits its target and its sensor have no mean, are as large as the model says, and know
nothing of one another (Kailath 1968; Mehra 1970). What a filter should smooth away shows in the second differences of
the path. None of these is an error: a filter may have small ones and still trail its target.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, hypot, inf, log, sqrt

import numpy as np

from tracker_core.checks import POSITIVE, Domain, InputError
from tracker_core.consistency import (
    Consistency,
    ModelCovariance,
    average,
    believed_share,
    innovation_squared,
    model_covariance,
)
from tracker_core.conventions import Gains
from tracker_core.metrics import Metric, distances
from tracker_core.poles import poles
from tracker_core.types import BoolArray, FloatArray, Measurements, Track
from tracker_core.whiteness import Whiteness, joint_whiteness, mean_and_error, whiteness

LAGS = Domain(1, 1000, whole=True)
SKIP = Domain(0, whole=True)

_REST = 0.05
_GREATEST_SHARE = 5

EVIDENCE: dict[str, Metric] = {
    "innovation_rmse": Metric(
        "Innovation RMSE", "m", "Root mean square distance between measured and predicted position; needs no truth.",
        "√(Σ ‖observed − predicted‖² / N)"),
    "innovation_bias": Metric(
        "Innovation bias", "m", "Length of the mean innovation: how far the filter trails on average.",
        "‖Σ (observed − predicted)‖ / N"),
    "nis": Metric(
        "NIS", "", "Average squared innovation over the variance that the model gives it; the number of axes where "
        "noise and manoeuvre are as assumed, more where they are underrated.",
        "Σ e² / S / N, S = σ² (P⁻₀₀ + 1)"),
    "whiteness": Metric(
        "Whiteness, p", "", "How likely uncorrelated innovations are to look as correlated as these; "
        "below 0.05 the filter leaves something to be predicted.",
        "P(χ² > n (n + 2) Σ r_k² / m_k)", lower_is_better=False),
    "smoothness": Metric(
        "Jerkiness", "m/s²", "Root mean square acceleration along the smoothed positions: what noise is left, "
        "and what the target really does.",
        "√(Σ ‖x(k+1) − 2 x(k) + x(k−1)‖² / N) / T²"),
    "rejected": Metric(
        "Rejected", "%", "Share of the measured samples that the gate has not believed.",
        "100 rejected / measured"),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a track shows without a truth, of all axes together or of one; None where something is not defined.

    Attributes:
        count: innovations that were counted: measured, predicted and not rejected; a sample of several axes where all
            of them are.
        rmse, greatest: of their lengths, m.
        bias: length of their mean after the start, m; of one axis with its sign.
        bias_error: its standard error, m, which minds that innovations may be correlated.
        nis: average of the normalised innovation squared after the start, and where it lies if the model is right;
            that its gains make the innovations correlated all the same is allowed for, and so is what a gate refused.
        whiteness: of the innovations after the start.
        smoothness: root mean square acceleration along the smoothed positions, m/s^2.
        roughness: the same along the measured positions of the same samples.
        rejected: share of the measured samples that the gate refused, 0 to 1.
        axes: the same of every axis; empty in that of an axis.
    """

    count: int
    rmse: float | None
    greatest: float | None
    bias: float | None
    bias_error: float | None
    nis: Consistency | None
    whiteness: Whiteness | None
    smoothness: float | None
    roughness: float | None
    rejected: float
    axes: tuple[Evidence, ...] = ()

    @property
    def smoother(self) -> float | None:
        """How many times smoother the path is than the measurements."""
        return self.roughness / self.smoothness if self.roughness is not None and self.smoothness else None

    def to_dict(self) -> dict[str, float | None]:
        """Plain numbers by name, as EVIDENCE describes them."""
        return {
            "innovation_rmse": self.rmse,
            "innovation_bias": self.bias,
            "nis": None if self.nis is None else self.nis.mean,
            "whiteness": None if self.whiteness is None else self.whiteness.probability,
            "smoothness": self.smoothness,
            "rejected": 100 * self.rejected,
        }


def examine(
    track: Track,
    measurements: Measurements,
    gains: Gains,
    *,
    sensor_std: tuple[float, ...] | None = None,
    tracking_index: float | None = None,
    spread: FloatArray | None = None,
    width: float = inf,
    skip: int | None = None,
    lags: int | None = None,
) -> Evidence:
    """What a track shows without a truth, jointly and per axis.

    Args:
        track: what the filter made; samples that its gate rejected do not count.
        measurements: what it saw.
        gains: of the filter.
        sensor_std: one for all axes or one per axis, m; there is no NIS without it, nor where one of them is 0.
        tracking_index: of the model, at the interval of the measurements; no NIS without it.
        spread: standard deviation of every innovation on the model, shape (n_samples, n_axes), m, which NIS and
            whiteness measure by; None for the steady one, which is right at a constant interval without gaps alone.
        width: of the gate, which kept larger innovations from being counted: if those were right, NIS is smaller by as
            much, so the interval that holds it begins lower.
        skip: samples at the start that bias, NIS and whiteness leave out; by default those after which 5 % are left
            of what the filter was started with, a fifth of all at most.
        lags: of the autocorrelations; by default 20, or a fifth of the innovations.

    Raises:
        InputError: for numbers outside their domains.
    """
    samples, count = track.innovation.shape
    rejected: BoolArray = np.zeros(samples, dtype=bool) if track.rejected is None else track.rejected
    innovation = track.believed
    begin = _settled(gains, samples) if skip is None else int(SKIP.check("skip", skip))
    late = innovation[begin:]
    lags = None if lags is None else int(LAGS.check("lags", lags))
    model = _model(gains, sensor_std, tracking_index, count)
    level, normalised = late, None
    if spread is not None:
        level = late / spread[begin:]
        normalised = level**2
    elif model is not None and sensor_std is not None:
        normalised = innovation_squared(late, model.innovation) / np.square(sensor_std)
    correlation = 0.0 if model is None else model.correlation
    share = believed_share(width, count) if width < inf else 1.0
    observed = np.where(rejected[:, None], np.nan, measurements.positions)
    paths = _accelerations(measurements, track.smoothed[:, :, 0], observed)

    def evidence(axes: slice, white: Whiteness | None, parts: tuple[Evidence, ...]) -> Evidence:
        lengths = distances(innovation[:, axes])
        lengths = lengths[~np.isnan(lengths)]
        nis = None
        if normalised is not None:
            squares = normalised[:, axes].sum(axis=1)
            nis = average(squares, len(range(count)[axes]), correlation=correlation)
            nis = replace(nis, low=share * nis.low)
        path, raw = (_rms(distances(accelerations[:, axes])) for accelerations in paths)
        measured = ~np.isnan(measurements.positions[:, axes]).all(axis=1)
        bias, error = mean_and_error(late[:, axes.start], lags) if not parts else _joint_mean(parts)
        return Evidence(
            count=len(lengths),
            rmse=_rms(lengths),
            greatest=float(lengths.max()) if lengths.size else None,
            bias=bias,
            bias_error=error,
            nis=nis if nis is not None and nis.count else None,
            whiteness=white,
            smoothness=path,
            roughness=raw,
            rejected=float((rejected & measured).sum() / max(1, measured.sum())),
            axes=parts,
        )

    each = [whiteness(level[:, axis], lags) for axis in range(count)]
    parts = tuple(evidence(slice(axis, axis + 1), each[axis], ()) for axis in range(count))
    return evidence(slice(0, count), joint_whiteness(each), parts)


def _joint_mean(parts: tuple[Evidence, ...]) -> tuple[float | None, float | None]:
    """Length of a mean whose parts are known, and the root of the sum of the squares of their errors."""
    if len(parts) == 1:
        return parts[0].bias, parts[0].bias_error
    means, errors = [part.bias for part in parts], [part.bias_error for part in parts]
    known, sure = [mean for mean in means if mean is not None], [error for error in errors if error is not None]
    return hypot(*known) if len(known) == len(parts) else None, hypot(*sure) if len(sure) == len(parts) else None


def _settled(gains: Gains, samples: int) -> int:
    """Samples after which little is left of a start."""
    slowest = abs(poles(gains)[0])
    fifth = samples // _GREATEST_SHARE
    if not slowest < 1:
        return fifth
    return min(fifth, ceil(log(_REST) / log(slowest)) if slowest > 0 else gains.order)


def _model(
    gains: Gains, sensor_std: tuple[float, ...] | None, tracking_index: float | None, axes: int
) -> ModelCovariance | None:
    """What the gains make of the model; None where there is none, or where they are not stable."""
    if sensor_std is None or tracking_index is None or 0 in sensor_std:
        return None
    if len(sensor_std) not in {1, axes}:
        raise InputError("sensor_std", f"must be one number, or {axes}", sensor_std)
    for std in sensor_std:
        POSITIVE.check("sensor_std", std)
    try:
        return model_covariance(gains, tracking_index)
    except InputError as error:
        if error.field == "gains":
            return None
        raise


def _accelerations(measurements: Measurements, *paths: FloatArray) -> list[FloatArray]:
    """Second divided differences, doubled, of paths (n, axes) where all of them are known; m/s^2."""
    if len(measurements.times) < 3:
        return [np.full((0, path.shape[1]), np.nan) for path in paths]
    if measurements.interval is not None:
        found = [np.diff(path, 2, axis=0) / measurements.interval**2 for path in paths]
    else:
        steps = np.diff(measurements.times)[:, None]
        wide = (steps[1:] + steps[:-1]) / 2
        found = [np.diff(np.diff(path, axis=0) / steps, axis=0) / wide for path in paths]
    unknown = np.logical_or.reduce([np.isnan(path) for path in found])
    return [np.where(unknown, np.nan, path) for path in found]


def _rms(lengths: FloatArray) -> float | None:
    """Root mean square of what is known."""
    known = lengths[~np.isnan(lengths)]
    with np.errstate(over="ignore"):
        return sqrt(float(known @ known) / known.size) if known.size else None
