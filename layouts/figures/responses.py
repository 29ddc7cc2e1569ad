"""What a filter makes of a step, a ramp and higher powers of the time, and of every frequency."""

from __future__ import annotations

from typing import Any

import numpy as np

from layouts.figures.common import META, NAMES, Figure, clipped, packed, xy
from layouts.shown import Shown
from layouts.state import INPUTS
from layouts.theme import layout, line, tokens
from tracker_core import Gains
from tracker_core.responses import frequency_response, step_figures, time_response
from tracker_core.stability import is_stable
from tracker_core.types import FloatArray

TIME_MOVING = (META, *xy(1, 2, 3, 4), ("layout", "yaxis2", "range"))
FREQUENCY_MOVING = (META, *xy(0, 1, 2, 3), ("layout", "annotations"))

SPANS = (30, 100, 300, 1_000)
"""Lengths of the time responses, samples."""

FREQUENCIES = 240
LOWEST = 1e-3
"""Lowest frequency drawn, cycles per sample."""

DECIBELS = (-45.0, 15.0)


def span(gains: Gains) -> int:
    """How many samples of a response are shown: enough to see it settle, in coarse steps."""
    if not is_stable(gains):
        return SPANS[0]
    # Infinite where it takes very long.
    wanted = 1.5 * float(step_figures(gains.vector)[1])
    return next((samples for samples in SPANS if samples >= wanted), SPANS[-1])


def time_key(shown: Shown) -> str:
    """What the time responses show beside the present gains."""
    return f"{shown.view.input}|{span(shown.result.gains)}|{shown.settings.experiment.interval!r}"


def time_figure(shown: Shown) -> Figure:
    """The response to the chosen input from rest above, what is missing to the input below."""
    gains, degree, interval = shown.result.gains, INPUTS.index(shown.view.input), shown.settings.experiment.interval
    samples, t = span(gains), tokens(shown.theme)
    response, unit = time_response(gains, degree, samples), interval**degree
    given, predicted, smoothed = (part * unit for part in (response.input, response.predicted, response.smoothed))
    times: FloatArray = np.arange(samples, dtype=np.float64) * interval
    high = float(given[-1])
    upper = (-0.1, 1.8) if degree == 0 else (-0.05 * high, 1.1 * high)
    errors = {"predicted": given - predicted, "smoothed": given - smoothed}
    reach = unit * error_reach(gains, degree, response.input - response.predicted)
    limit = 50 * max(high, reach)

    def curve(kind: str, y: FloatArray, below: bool = False) -> dict[str, Any]:
        place = {"yaxis": "y2", "xaxis": "x2", "showlegend": False} if below else {}
        return {
            "type": "scatter", "mode": "lines", "x": packed(times), "y": packed(clipped(y, limit)),
            "line": line(kind, shown.theme), "name": NAMES[kind] if kind != "truth" else "Input",
            **place,
        }  # fmt: skip

    return {
        "data": [
            curve("truth", given),
            curve("predicted", predicted),
            curve("smoothed", smoothed),
            curve("predicted", errors["predicted"], below=True),
            curve("smoothed", errors["smoothed"], below=True),
        ],
        "layout": layout(
            shown.theme,
            uirevision=time_key(shown),
            meta=shown.meta,
            margin={"l": 56, "r": 12, "t": 30, "b": 40},
            legend={"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
            xaxis={"range": [0, float(times[-1])], "anchor": "y", "showticklabels": False},
            yaxis={"title": {"text": "position (m)"}, "range": list(upper), "domain": [0.42, 1]},
            xaxis2={
                **_axis(shown), "title": {"text": "time (s)"}, "range": [0, float(times[-1])], "anchor": "y2",
            },
            yaxis2={
                **_axis(shown), "title": {"text": "input − response (m)"}, "range": [-reach, reach],
                "domain": [0, 0.34], "anchor": "x2", "zerolinecolor": t["line"],
            },
        ),
    }  # fmt: skip


def error_reach(gains: Gains, degree: int, error: FloatArray) -> float:
    """Half the height of the error's axis: a round number around what the prediction misses at most."""
    finite = np.abs(error[np.isfinite(error)])
    greatest = float(finite.max(initial=0.0))
    if degree < gains.order:
        # A filter of this order follows the input in the end: what matters is the beginning.
        greatest = min(greatest, 3.0**degree * 50)
    power = 10.0 ** np.floor(np.log10(max(greatest, 1e-3)))
    return float(next(step * power for step in (1.2, 2.5, 6, 12) if step * power >= greatest))


def _axis(shown: Shown) -> dict[str, Any]:
    """Second axes do not take their look from the template."""
    return dict(layout(shown.theme)["template"]["layout"]["xaxis"])


def frequency_key(shown: Shown) -> str:
    """What the frequency responses show beside the present gains."""
    return repr(shown.settings.experiment.interval)


def frequency_figure(shown: Shown) -> Figure:
    """Magnitude and phase from the measured to the predicted and to the smoothed position."""
    interval = shown.settings.experiment.interval
    frequency = np.geomspace(LOWEST, 0.5, FREQUENCIES)
    response, stable = frequency_response(shown.result.gains, frequency), shown.result.verdict.stable
    hertz = frequency / interval
    ends = [float(np.log10(hertz[0])), float(np.log10(hertz[-1]))]

    def curve(kind: str, y: FloatArray, below: bool = False) -> dict[str, Any]:
        place = {"yaxis": "y2", "xaxis": "x2", "showlegend": False} if below else {}
        return {
            "type": "scatter", "mode": "lines", "x": packed(hertz),
            "y": packed(y if stable else np.full_like(y, np.nan)),
            "line": line(kind, shown.theme), "name": NAMES[kind], **place,
        }  # fmt: skip

    return {
        "data": [
            curve("predicted", decibels(response.predicted)),
            curve("smoothed", decibels(response.smoothed)),
            curve("predicted", degrees(response.predicted), below=True),
            curve("smoothed", degrees(response.smoothed), below=True),
        ],
        "layout": layout(
            shown.theme,
            uirevision=frequency_key(shown),
            annotations=[] if stable else [_nothing(shown.theme)],
            meta=shown.meta,
            margin={"l": 56, "r": 12, "t": 30, "b": 40},
            legend={"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
            xaxis={"type": "log", "range": ends, "dtick": 1, "showticklabels": False, "anchor": "y"},
            yaxis={"title": {"text": "magnitude (dB)"}, "range": list(DECIBELS), "dtick": 15, "domain": [0.42, 1]},
            xaxis2={
                **_axis(shown), "type": "log", "range": ends, "title": {"text": "frequency (Hz)"}, "anchor": "y2",
                "dtick": 1, "tickformat": "~g",
            },
            yaxis2={
                **_axis(shown), "title": {"text": "phase (°)"}, "range": [-190, 100], "dtick": 90, "domain": [0, 0.34],
                "anchor": "x2",
            },
        ),
    }  # fmt: skip


def _nothing(theme: str) -> dict[str, Any]:
    """Said in place of a response that an unstable filter does not have."""
    return {
        "x": 0.5, "y": 0.7, "xref": "paper", "yref": "paper", "showarrow": False,
        "text": "unstable: there is no frequency response",
        "font": {"color": tokens(theme)["bad"], "size": 13},
    }  # fmt: skip


def decibels(response: np.ndarray) -> FloatArray:
    """Magnitude in dB, from -120 up."""
    return 20 * np.log10(np.maximum(np.abs(response), 1e-6))


def degrees(response: np.ndarray) -> FloatArray:
    """Phase in degrees without jumps, beginning near zero at the lowest frequency."""
    return np.degrees(np.unwrap(np.angle(response)))
