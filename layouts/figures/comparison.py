"""Several filters in one plot: paths, close-up, errors and gains, the present filter bold among the pinned ones."""

from __future__ import annotations

from html import escape
from typing import Any, NamedTuple

import numpy as np

from layouts.figures.common import (
    META,
    Figure,
    chosen,
    clipped,
    drawn,
    packed,
    padded_range,
    round_up,
    thinned,
    trace,
    xy,
)
from layouts.figures.error import running_rms, visible, window
from layouts.figures.track import axes_of, close_up_rows, plane_of, positions, reach, refused, whereabouts
from layouts.pinned import pinned_runs
from layouts.shown import Shown, seen_key, target_key
from layouts.theme import hollow, layout, pin_line, pin_marker, tokens
from tracker_core import CONVENTIONS, Result
from tracker_core.fields import FIELDS
from tracker_core.metrics import METRICS, distances
from tracker_core.types import GAIN_NAMES, FloatArray, IntArray

PATH_MOVING = (META, *xy(2, 3), *chosen(4))
CLOSE_UP_MOVING = (META, *xy(2, 3), *chosen(4))
ERROR_MOVING = (META, *xy(1, 2), ("layout", "yaxis", "range"))
GAINS_MOVING = (META, *chosen(0, 1, 2, 3), *(("layout", f"yaxis{number}", "range") for number in ("", 2, 3, 4)))

ERROR_TITLES = {
    "tracking": "predicted to true (m)",
    "estimation": "smoothed to true (m)",
    "innovation": "measured to predicted (m)",
}
LEVELS = 12
"""Points of the line of a constant gain at most, so that it bears markers."""

LEAST = 1e-12
"""What is less than this is drawn as nothing."""


def overlay(slot: int, name: str, x: FloatArray, y: FloatArray, theme: str, **more: Any) -> Figure:
    """The line of a pinned filter; plotly would take its name for HTML."""
    return {
        "type": "scatter", "mode": "lines+markers", "name": escape(name, quote=False), "x": packed(x), "y": packed(y),
        "line": pin_line(slot, theme), "marker": pin_marker(slot, theme), "showlegend": False, **more,
    }  # fmt: skip


def _runs(shown: Shown) -> list[tuple[int, str, Result]]:
    """Slot, name and run of every pinned filter; none while a slider moves, which moves none of them."""
    if shown.live:
        return []
    return [(candidate.slot, candidate.name, result) for candidate, result in pinned_runs(shown.settings)]


def _present(x: FloatArray, y: FloatArray, theme: str, **more: Any) -> Figure:
    return trace("smoothed", x, y, theme, name="Present", **more)


def _exaggerated(shown: Shown, result: Result) -> FloatArray:
    smoothed = result.track.smoothed[:, :, 0]
    if shown.view.exaggerate == 1 or not result.truth.known:
        return smoothed
    truth = shown.result.truth.positions
    return truth + shown.view.exaggerate * (smoothed - truth)


def path_overlay(shown: Shown) -> Figure:
    """The smoothed path of every filter over truth and measurements; the user's zoom is kept while the target is."""
    result, view, theme = shown.result, shown.view, shown.theme
    series, samples = positions(result, view), len(result.truth.times)
    rows, some = drawn(samples), thinned(samples)
    limit = reach(np.concatenate((series["truth"], series["observed"])))
    truth, observed, present = (
        plane_of(result, clipped(series[kind], limit), rows) for kind in ("truth", "observed", "smoothed")
    )
    cursor = view.cursor(samples)
    here = plane_of(result, whereabouts(series), slice(cursor, cursor + 1))
    t = tokens(theme)
    data = [
        trace("truth", *truth, theme, showlegend=result.truth.known),
        trace("observed", *plane_of(result, series["observed"], some), theme, marker=hollow(theme, 4)),
        _present(*present, theme),
        {
            "type": "scatter", "mode": "markers", "x": [float(here[0][0])], "y": [float(here[1][0])],
            "marker": {"symbol": "square-open", "size": 16, "color": t["marker"], "line": {"width": 2}},
            "hoverinfo": "skip", "showlegend": False,
        },
        refused(shown, *plane_of(result, series["observed"], slice(None))),
    ]  # fmt: skip
    for slot, name, run in _runs(shown):
        data.append(overlay(slot, name, *plane_of(result, clipped(_exaggerated(shown, run), limit), rows), theme))
    still = [np.concatenate((truth[i], observed[i])) for i in (0, 1)]
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=target_key(shown),
            meta=shown.meta | {"first": 0, "every": rows.step, "every_marker": some.step},
            legend={"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
            margin={"l": 60, "r": 12, "t": 34, "b": 40},
            **axes_of(result, padded_range(still[0]), padded_range(still[1])),
        ),
    }


def close_up_overlay(shown: Shown) -> Figure:
    """Some thirty samples around the one looked at, every filter's estimate of each."""
    result, view, theme = shown.result, shown.view, shown.theme
    series, samples = positions(result, view), len(result.truth.times)
    cursor = view.cursor(samples)
    rows = close_up_rows(samples, cursor)
    limit = reach(np.concatenate((series["truth"], series["observed"])))
    truth, observed, present = (
        plane_of(result, clipped(series[kind], limit), rows) for kind in ("truth", "observed", "smoothed")
    )
    here = [part[np.isfinite(part)] for part in plane_of(result, series["smoothed"], slice(cursor, cursor + 1))]
    t = tokens(theme)
    data = [
        trace("truth", *truth, theme, mode="lines+markers", marker={"size": 4, "color": t["truth"]}),
        trace("observed", *observed, theme, marker=hollow(theme, 8)),
        _present(*present, theme, mode="lines+markers", marker={"size": 5, "color": t["smoothed"]}),
        {
            "type": "scatter", "mode": "markers", "x": here[0].tolist(), "y": here[1].tolist(),
            "marker": {"symbol": "circle-open", "size": 13, "color": t["marker"], "line": {"width": 2}},
            "name": "This sample", "hoverinfo": "skip",
        },
        refused(shown, *observed, rows),
    ]  # fmt: skip
    for slot, name, run in _runs(shown):
        line_of = plane_of(result, clipped(_exaggerated(shown, run), limit), rows)
        data.append(overlay(slot, name, *line_of, theme, marker=pin_marker(slot, theme, 6) | {"maxdisplayed": 0}))
    for part, plane in zip(data, (truth, observed, present), strict=False):
        part["x"], part["y"] = (packed(values, "f8") for values in plane)
    places = plane_of(result, whereabouts(series), rows)
    ranges = [padded_range(np.concatenate((truth[i], observed[i], places[i])), 0.1) for i in (0, 1)]
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=f"{target_key(shown)}|{cursor}|{view.exaggerate}",
            meta=shown.meta | {"first": rows.start, "every": 1, "every_marker": 1},
            showlegend=False,
            margin={"l": 60, "r": 12, "t": 34, "b": 40},
            **axes_of(result, ranges[0], ranges[1]),
        ),
    }


def errors_of(result: Result, kind: str) -> FloatArray:
    """One error of every sample, m, shape (n_samples,): of KINDS; NaN where a gate has not believed it, or no truth is.

    Innovations that a filter refused are none of its errors.
    """
    predicted, smoothed = result.track.predicted[:, :, 0], result.track.smoothed[:, :, 0]
    if kind == "innovation":
        sizes, refused = distances(result.measurements.positions - predicted), result.track.rejected
        return sizes if refused is None else np.where(refused, np.nan, sizes)
    return distances((predicted if kind == "tracking" else smoothed) - result.truth.positions)


def error_overlay(shown: Shown) -> Figure:
    """One error of every filter over time, as a running RMS, with the level of the measurements.

    Where nobody knows the truth that is the size of the innovation, with what the sensor is said to have of it.
    """
    result, theme, kind = shown.result, shown.theme, shown.view.comparing.compared
    times, known = result.truth.times, result.truth.known
    rows, width = drawn(len(times)), window(len(times))
    raw = distances(result.measurements.positions - result.truth.positions)
    level = float(np.sqrt(np.nanmean(raw**2) if known else np.sum(np.square(result.noise_std))))
    curves = [running_rms(errors_of(run, kind), width)[rows] for _, _, run in _runs(shown)]
    present = running_rms(errors_of(result, kind), width)[rows]
    top = error_top(level, [present, *curves])
    cursor = float(times[shown.view.cursor(len(times))])
    t = tokens(theme)
    data: list[Figure] = [
        {
            "type": "scatter", "mode": "lines", "x": [float(times[0]), float(times[-1])], "y": [level, level],
            "line": {"color": t["observed"], "width": 2, "dash": "dot"},
            "name": METRICS["observation_rmse"].title if known else "σ, assumed", "hoverinfo": "skip",
            "visible": kind != "innovation" or not known,
        },
        _present(times[rows], visible(present, top), theme),
        {
            "type": "scatter", "mode": "lines", "x": [cursor, cursor], "y": [0, 100 * top],
            "line": {"color": t["marker"], "width": 1.5}, "hoverinfo": "skip", "showlegend": False,
        },
    ]  # fmt: skip
    for (slot, name, _), curve in zip(_runs(shown), curves, strict=True):
        data.append(overlay(slot, name, times[rows], visible(curve, top), theme))
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=f"{target_key(shown)}|{kind}",
            meta=shown.meta | {"first": 0, "every": rows.step, "every_marker": rows.step},
            legend={"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
            margin={"l": 56, "r": 12, "t": 34, "b": 40},
            xaxis={"title": {"text": "time (s)"}, "range": padded_range(times, 0.02)},
            yaxis={"title": {"text": ERROR_TITLES[kind]}, "range": [0, top]},
        ),
    }


def error_top(level: float, curves: list[FloatArray]) -> float:
    """The top of the axis over errors: all but the worst are seen, and a filter that diverges spoils nothing."""
    finite = [curve[np.isfinite(curve)] for curve in curves]
    usual = max((float(np.quantile(part, 0.99)) for part in finite if part.size), default=0.0)
    wanted = max(1.3 * level, min(1.1 * usual, 20 * level or 1.1 * usual))
    return round_up(wanted) if wanted > LEAST else 1.0


class GainLines(NamedTuple):
    """The gains of a run over time.

    Attributes:
        times: of the points, s, shape (points,).
        gains: in the present convention, shape (points, order).
        samples: which ones the points are, shape (points,); None where they follow from the plot's own steps.
    """

    times: FloatArray
    gains: FloatArray
    samples: IntArray | None

    def line(self, index: int) -> dict[str, Any]:
        """What is drawn of one gain, and where; nothing of one that the filter has not."""
        used = index < self.gains.shape[1]
        y = self.gains[:, index] if used else np.full_like(self.times, np.nan)
        samples = None if self.samples is None else packed(self.samples, "i4")
        return {"x": self.times, "y": y, "customdata": samples}


def gain_lines(shown: Shown, result: Result) -> GainLines:
    """The gains of a run: a constant one at a few samples, evenly spread over the time."""
    order, times = result.experiment.order, result.truth.times
    factors = np.array(CONVENTIONS[shown.settings.experiment.convention].factors)[:order]
    if result.selection is None:
        constant = result.experiment.gains().vector / factors
        samples = np.unique(np.searchsorted(times, np.linspace(times[0], times[-1], LEVELS)))
        return GainLines(times[samples], np.tile(constant, (len(samples), 1)), samples)
    rows = drawn(len(times))
    return GainLines(times[rows], result.selection.gains[rows, shown.view.axis] / factors, None)


def gains_overlay(shown: Shown) -> Figure:
    """Every gain of every filter, one row per gain: constant ones are horizontal lines."""
    theme, times = shown.theme, shown.result.truth.times
    present = gain_lines(shown, shown.result)
    runs = [(slot, name, gain_lines(shown, run)) for slot, name, run in _runs(shown)]
    every_gain = [lines.gains for lines in (present, *(lines for _, _, lines in runs))]
    rows = max(gains.shape[1] for gains in every_gain)
    data = [
        _present(theme=theme, showlegend=False, **present.line(index), **_row(index, rows))
        for index in range(len(GAIN_NAMES))
    ]
    for slot, name, lines in runs:
        of_slot = range(lines.gains.shape[1])
        data += [overlay(slot, name, theme=theme, **lines.line(i), **_row(i, rows)) for i in of_slot]
    every = drawn(len(times)).step
    axes = {}
    for index, name in enumerate(GAIN_NAMES):
        values = [gains[:, index] for gains in every_gain if index < gains.shape[1]]
        axes[f"yaxis{index + 1 if index else ''}"] = {
            "title": {"text": FIELDS[name].symbol},
            "range": _gain_range(np.concatenate([np.zeros(1), *values])),
            "domain": [1 - (index + 0.86) / rows, 1 - index / rows] if index < rows else [0, 1e-3],
            "visible": index < rows,
            "nticks": 4,
        }
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=f"{target_key(shown)}|{shown.view.axis}|{rows}",
            meta=shown.meta | {"first": 0, "every": every, "every_marker": every},
            showlegend=False,
            margin={"l": 56, "r": 12, "t": 8, "b": 40},
            xaxis={
                "title": {"text": "time (s)"},
                "range": padded_range(times, 0.02),
                "anchor": f"y{rows}",
            },
            **axes,
        ),
    }


def _row(index: int, rows: int) -> dict[str, Any]:
    """The axis that a gain is drawn over; a gain that no filter has is not drawn."""
    if index >= rows:
        return {"visible": False}
    symbol = FIELDS[GAIN_NAMES[index]].symbol
    return {"yaxis": f"y{index + 1 if index else ''}", "hovertemplate": f"{symbol} %{{y:.4g}}"}


def _gain_range(values: FloatArray) -> list[float]:
    finite = values[np.isfinite(values)]
    low, high = float(finite.min(initial=0.0)), float(finite.max(initial=0.0))
    top = round_up(high) if high > LEAST else 0.0
    bottom = -round_up(-low) if -low > LEAST else 0.0
    pad = 0.05 * (top - bottom) or 0.05
    return [bottom - pad, top + pad]


def pins_key(shown: Shown) -> str:
    """Which filters are pinned."""
    return "|".join(f"{pin.slot}:{pin.text()}" for pin in shown.settings.pins)


def path_key(shown: Shown) -> str:
    """What the path shows beside the present filter."""
    return f"{seen_key(shown)}|{shown.view.exaggerate}|{pins_key(shown)}"


def close_up_key(shown: Shown) -> str:
    """What the close-up shows beside the present filter."""
    return f"{path_key(shown)}|{shown.view.at}"


def error_key(shown: Shown) -> str:
    """What the errors are shown beside."""
    return f"{seen_key(shown)}|{shown.view.comparing.compared}|{pins_key(shown)}"


def gains_key(shown: Shown) -> str:
    """What the gains are shown beside."""
    experiment = shown.settings.experiment
    return f"{seen_key(shown)}|{shown.view.axis}|{experiment.order}|{experiment.convention}|{pins_key(shown)}"
