"""The distance to the truth over time; where nobody knows it, the distance to the measurements."""

from __future__ import annotations

from math import floor, log10

import numpy as np

from layouts.figures.common import META, Figure, chosen, drawn, grain, grained, padded_range, trace, xy
from layouts.figures.track import refused
from layouts.shown import Shown, beside_key, seen_key, target_key
from layouts.theme import layout, tokens
from tracker_core import Result
from tracker_core.metrics import METRICS, distances
from tracker_core.types import FloatArray

MOVING = (META, *xy(0, 1, 2, 3, 5, 6), *chosen(7), ("layout", "yaxis", "range"))
SHORT_RUN = 80
"""Runs of up to so many samples are shown sample by sample, longer ones as a running RMS as well."""


def error_figure(shown: Shown) -> Figure:
    """Distance of prediction and smoothed position from the truth against time, with the level of the measurements.

    Where nobody knows the truth, their distance from the measurements.
    """
    result, view, theme = shown.result, shown.view, shown.theme
    times, known = result.truth.times, result.truth.known
    truth = result.truth.positions if known else result.measurements.positions
    rows = drawn(len(times))
    raw = distances(result.measurements.positions - truth)
    errors = {
        "predicted": distances(result.track.predicted[:, :, 0] - truth),
        "smoothed": distances(result.track.smoothed[:, :, 0] - truth),
    }
    crosses = errors["predicted"]
    if not known and result.track.rejected is not None:
        # A measurement that is not believed is nothing to be near to.
        errors = {kind: np.where(result.track.rejected, np.nan, values) for kind, values in errors.items()}
    level = float(np.sqrt(np.nanmean(raw**2))) if known else float(np.sqrt(np.sum(np.square(result.noise_std))))
    top = _scale(level, errors["predicted"])
    width = window(len(times))
    cursor = float(times[view.cursor(len(times))])
    data = []
    step = grain(np.array((0.0, top)))
    for kind in errors:
        faint = trace(kind, times[rows], grained(visible(errors[kind], top), step)[rows], theme, showlegend=False)
        faint["line"] = {"color": tokens(theme)[f"{kind}-faint"], "width": 1}
        data.append(faint if width > 1 else faint | {"visible": False})
    for kind, values in errors.items():
        smooth = running_rms(visible(values, top), width)
        data.append(trace(kind, times[rows], grained(smooth, step)[rows], theme))
    data += [
        {
            "type": "scatter", "mode": "lines", "x": [float(times[0]), float(times[-1])], "y": [level, level],
            "line": {"color": tokens(theme)["observed"], "width": 2, "dash": "dot"},
            "name": METRICS["observation_rmse"].title if known else "σ, assumed", "hoverinfo": "skip",
        },
        {
            "type": "scatter", "mode": "lines", "x": [cursor, cursor], "y": [0, 100 * top],
            "line": {"color": tokens(theme)["marker"], "width": 1.5}, "hoverinfo": "skip", "showlegend": False,
        },
    ]  # fmt: skip
    if shown.beside is None:
        data.append(trace("counterpart", np.empty(0), np.empty(0), theme, showlegend=False))
    else:
        beside = running_rms(visible(distances(shown.beside.track.smoothed[:, :, 0] - truth), top), width)
        data.append(trace("counterpart", times[rows], grained(beside, step)[rows], theme, showlegend=True))
    data.append(refused(shown, times, np.minimum(crosses, 0.97 * top)))
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=target_key(shown),
            meta=shown.meta | {"first": 0, "every": rows.step, "every_marker": rows.step},
            legend={"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
            margin={"l": 56, "r": 12, "t": 34, "b": 40},
            xaxis={"title": {"text": "time (s)"}, "range": padded_range(times, 0.02)},
            yaxis={"title": {"text": f"distance to the {'truth' if known else 'measurement'} (m)"}, "range": [0, top]},
        ),
    }


def title(result: Result) -> str:
    """What the distances are called: an error is one from the truth."""
    return "Error" if result.truth.known else "Residual"


def error_key(shown: Shown) -> str:
    """What the errors are shown beside."""
    return f"{seen_key(shown)}|{beside_key(shown)}"


def window(samples: int) -> int:
    """Length of the running RMS for a run: odd, about a fortieth of it; 1 for short runs."""
    return 1 if samples <= SHORT_RUN else samples // 80 * 2 + 1


def running_rms(values: FloatArray, width: int) -> FloatArray:
    """Root mean square over a centred window of `width` samples, shape as given; NaN only where all are NaN."""
    if width == 1:
        return values
    known = np.isfinite(values)
    sums, counts = (
        np.concatenate(([0.0], np.cumsum(part))) for part in (np.where(known, values, 0.0) ** 2, known.astype(float))
    )
    last = np.minimum(np.arange(len(values)) + width // 2 + 1, len(values))
    first = np.maximum(np.arange(len(values)) - width // 2, 0)
    count = counts[last] - counts[first]
    mean = np.maximum(sums[last] - sums[first], 0) / np.maximum(count, 1)
    return np.where(count > 0, np.sqrt(mean), np.nan)


def _scale(level: float, tracking: FloatArray) -> float:
    """The top of the axis: a round number, so that it seldom moves while the gains do."""
    finite = tracking[np.isfinite(tracking)]
    noise = 4 * level
    high = int(0.98 * (finite.size - 1))
    usual = 1.1 * float(np.partition(finite, high)[high]) if finite.size else 0.0
    wanted = max(noise, min(usual, 50 * noise or usual)) or 1.0
    power = 10.0 ** floor(log10(wanted))
    return next(step * power for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if step * power >= wanted * (1 - 1e-9))


def visible(values: FloatArray, top: float) -> FloatArray:
    """Values for drawing: far above the top of the axis nothing is."""
    return np.where(values <= 1e4 * top, values, np.nan)
