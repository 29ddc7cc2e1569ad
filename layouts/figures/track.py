"""The path, its close-up around one sample, and one state of one axis against time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from layouts.figures.common import (
    META,
    SERIES,
    Figure,
    chosen,
    clipped,
    drawn,
    grain,
    grained,
    packed,
    padded_range,
    thinned,
    trace,
    xy,
)
from layouts.figures.remembered import of_target
from layouts.shown import Shown, beside_key, seen_key, target_key
from layouts.state import View
from layouts.theme import hollow, layout, tokens
from tracker_core import Result
from tracker_core.types import STATE_NAMES, FloatArray

CLOSE_UP_SAMPLES = 30
UNITS = ("m", "m/s", "m/s²", "m/s³")

PATH_MOVING = (META, *xy(2, 3, 4, 5), *chosen(6))
CLOSE_UP_MOVING = (META, *xy(0, 1, 2, 3, 4, 5), *chosen(6), ("layout", "xaxis", "range"), ("layout", "yaxis", "range"))
AXIS_MOVING = (META, *xy(2, 3, 4), *chosen(5))


def positions(result: Result, view: View) -> dict[str, FloatArray]:
    """The four series, deviations from the truth exaggerated as the view asks."""
    return positions_of(result, view.exaggerate)


def positions_of(result: Result, exaggerate: float) -> dict[str, FloatArray]:
    """The four series, deviations from the truth so many times larger."""
    truth = result.truth.positions
    series = {
        "truth": truth,
        "observed": result.measurements.positions,
        "predicted": result.track.predicted[:, :, 0],
        "smoothed": result.track.smoothed[:, :, 0],
    }
    # Where nobody knows the truth there is nothing to deviate from.
    if exaggerate != 1 and result.truth.known:
        series = {name: truth + exaggerate * (values - truth) for name, values in series.items()}
    return series


def plane_of(result: Result, positions: FloatArray, rows: slice) -> tuple[FloatArray, FloatArray]:
    """Horizontal and vertical coordinate: x and y, or time and the only axis."""
    if positions.shape[1] == 1:
        return result.truth.times[rows], positions[rows, 0]
    return positions[rows, 0], positions[rows, 1]


def _titles(result: Result) -> tuple[str, str]:
    axes = result.scenario.axes
    return ("time (s)", f"{axes[0]} (m)") if len(axes) == 1 else (f"{axes[0]} (m)", f"{axes[1]} (m)")


def reach(values: FloatArray) -> float:
    """A magnitude well outside the picture."""
    return 100 * float(np.abs(values[np.isfinite(values)]).max(initial=1.0))


def axes_of(result: Result, x_range: list[float], y_range: list[float]) -> dict[str, Any]:
    """The axes of a path: on equal scales where there is more than one."""
    x_title, y_title = _titles(result)
    y_axis: dict[str, Any] = {"title": {"text": y_title}, "range": y_range}
    if len(result.scenario.axes) > 1:
        y_axis["scaleanchor"] = "x"
    return {"xaxis": {"title": {"text": x_title}, "range": x_range}, "yaxis": y_axis}


def path_figure(shown: Shown) -> Figure:
    """The whole path: x against y on equal scales, or the only axis against time.

    As long as the target stays the same, the user's zoom is kept.
    """
    result, view, theme, key = shown.result, shown.view, shown.theme, target_key(shown)
    series, still = positions(result, view), _still(result, view.exaggerate)
    rows, limit, step = drawn(len(result.truth.times)), still.limit, position_grain(result)
    shown_as = {kind: grained(clipped(series[kind], limit), step) for kind in ("predicted", "smoothed")}
    shown_as |= {"truth": still.truth, "observed": still.observed}
    planes = {kind: plane_of(result, shown_as[kind], rows) for kind in SERIES}
    cursor = view.cursor(len(result.truth.times))
    here = plane_of(result, grained(whereabouts(series), step), slice(cursor, cursor + 1))
    t = tokens(theme)
    some = thinned(len(result.truth.times))
    data = [trace(kind, *planes[kind], theme) for kind in SERIES]
    data[1] = trace("observed", *plane_of(result, shown_as["observed"], some), theme, marker=hollow(theme, 4))
    data.append(
        {
            "type": "scatter", "mode": "markers", "x": [float(here[0][0])], "y": [float(here[1][0])],
            "marker": {"symbol": "square-open", "size": 16, "color": t["marker"], "line": {"width": 2}},
            "name": "Close-up", "hoverinfo": "skip", "showlegend": False,
        }
    )  # fmt: skip
    data.append(_counterpart(shown, rows, limit))
    data.append(refused(shown, *plane_of(result, series["observed"], slice(None))))
    data[0]["showlegend"] = result.truth.known
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=key,
            meta=shown.meta | {"first": 0, "every": rows.step, "every_marker": some.step},
            legend={"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
            margin={"l": 60, "r": 12, "t": 34, "b": 40},
            **axes_of(result, *still.ranges),
        ),
    }


class Still(NamedTuple):
    """What of a path does not move while the gains do.

    Attributes:
        limit: a magnitude well outside the picture, m.
        truth: the true positions as they are drawn, shape (n_samples, n_axes).
        observed: the same of the measured ones.
        ranges: of both axes of the picture; they are those of truth and measurements.
    """

    limit: float
    truth: FloatArray
    observed: FloatArray
    ranges: tuple[list[float], list[float]]


@of_target
def _still(result: Result, exaggerate: float) -> Still:
    truth, observed = (positions_of(result, exaggerate)[kind] for kind in ("truth", "observed"))
    limit, step = reach(np.concatenate((truth, observed))), position_grain(result)
    truth, observed = (grained(clipped(values, limit), step) for values in (truth, observed))
    rows = drawn(len(result.truth.times))
    planes = [plane_of(result, values, rows) for values in (truth, observed)]
    x_range, y_range = (padded_range(np.concatenate([plane[i] for plane in planes])) for i in (0, 1))
    return Still(limit, truth, observed, (x_range, y_range))


@of_target
def position_grain(result: Result) -> FloatArray:
    """The step to which the positions of a run are drawn where it is drawn whole, m, shape (n_axes,)."""
    return grain(np.concatenate((result.truth.positions, result.measurements.positions)))


def whereabouts(series: dict[str, FloatArray]) -> FloatArray:
    """The best that is known of where the target was, shape (n_samples, n_axes); it depends on the filter nowhere else.

    The truth, or else what was measured, or else what the filter made of it.
    """
    places = np.where(np.isnan(series["truth"]), series["observed"], series["truth"])
    return np.where(np.isnan(places), series["smoothed"], places)


def refused(shown: Shown, x: FloatArray, y: FloatArray, rows: slice = slice(None)) -> Figure:
    """The measurements that the gate did not believe, of those that are shown; each bears its sample."""
    gone, samples = shown.result.track.rejected, np.arange(len(shown.result.truth.times))[rows]
    some = np.zeros(len(x), dtype=bool) if gone is None else gone[rows]
    return {
        "type": "scatter", "mode": "markers", "x": packed(x[some], "f8"), "y": packed(y[some], "f8"),
        "customdata": packed(samples[some], "i4"),
        "marker": {"symbol": "x-thin", "size": 9, "line": {"width": 2, "color": tokens(shown.theme)["bad"]}},
        "name": "Not believed", "showlegend": bool(some.any()),
    }  # fmt: skip


def _counterpart(shown: Shown, rows: slice, limit: float) -> Figure:
    """The smoothed path of the causal counterpart, where it is wanted beside a run in hindsight."""
    x = y = np.empty(0)
    if shown.beside is not None:
        truth = shown.result.truth.positions
        deviation = shown.beside.track.smoothed[:, :, 0] - truth
        x, y = plane_of(shown.result, clipped(truth + shown.view.exaggerate * deviation, limit), rows)
    return trace("counterpart", x, y, shown.theme, showlegend=shown.beside is not None)


def close_up_rows(samples: int, cursor: int) -> slice:
    """The samples of the close-up: some thirty, the chosen one in their middle where the run allows it."""
    first = max(0, min(cursor - CLOSE_UP_SAMPLES // 2, samples - CLOSE_UP_SAMPLES - 1))
    return slice(first, first + CLOSE_UP_SAMPLES + 1)


def close_up_figure(shown: Shown) -> Figure:
    """Some thirty samples around the one looked at, so that metres show on a path of kilometres."""
    result, view, theme, key = shown.result, shown.view, shown.theme, target_key(shown)
    series = positions(result, view)
    samples = len(result.truth.times)
    cursor = view.cursor(samples)
    rows = close_up_rows(samples, cursor)
    limit = _still(result, view.exaggerate).limit
    planes = {kind: plane_of(result, clipped(series[kind], limit), rows) for kind in SERIES}
    ranges = [padded_range(np.concatenate([planes[kind][i] for kind in ("truth", "observed")]), 0.1) for i in (0, 1)]
    here = [part[np.isfinite(part)] for part in plane_of(result, series["smoothed"], slice(cursor, cursor + 1))]
    data = [
        trace("truth", *planes["truth"], theme),
        trace("observed", *planes["observed"], theme),
        trace("predicted", *planes["predicted"], theme),
        trace("smoothed", *planes["smoothed"], theme),
        {
            "type": "scatter", "mode": "markers", "x": here[0].tolist(), "y": here[1].tolist(),
            "marker": {"symbol": "circle-open", "size": 13, "color": tokens(theme)["marker"], "line": {"width": 2}},
            "name": "This sample", "hoverinfo": "skip",
        },
    ]  # fmt: skip
    for part, kind in zip(data, SERIES, strict=False):
        part["x"], part["y"] = (packed(values, "f8") for values in planes[kind])
    data.append(_counterpart(shown, rows, limit))
    data.append(refused(shown, *planes["observed"], rows))
    data[0]["mode"] = data[2]["mode"] = data[3]["mode"] = "lines+markers"
    data[0]["marker"] = {"size": 4, "color": tokens(theme)["truth"]}
    data[1]["marker"] = hollow(theme, 8)
    data[2]["marker"] = {"size": 4, "color": tokens(theme)["predicted"]}
    data[3]["marker"] = {"size": 5, "color": tokens(theme)["smoothed"]}
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=f"{key}|{cursor}|{view.exaggerate}",
            meta=shown.meta | {"first": rows.start, "every": 1, "every_marker": 1},
            showlegend=False,
            margin={"l": 60, "r": 12, "t": 34, "b": 40},
            **axes_of(result, ranges[0], ranges[1]),
        ),
    }


def axis_figure(shown: Shown) -> Figure:
    """One state of one axis against time: true, predicted, smoothed, and observed where it is the position."""
    result, view, theme, key = shown.result, shown.view, shown.theme, target_key(shown)
    times = result.truth.times
    rows, some = drawn(len(times)), thinned(len(times))
    truth = result.truth.states[:, view.axis, view.quantity]
    observed = result.measurements.positions[:, view.axis] if view.quantity == 0 else np.full_like(truth, np.nan)
    predicted = result.track.predicted[:, view.axis, view.quantity]
    smoothed = result.track.smoothed[:, view.axis, view.quantity]
    low_high = _axis_range(result, view, truth, observed, smoothed)
    limit = 100 * max(map(abs, low_high))
    # Of positions the numbers are those of the path, which are sent once.
    step = grain(np.array(low_high)) if view.quantity else position_grain(result)[view.axis]
    truth, observed = grained(truth, step), grained(observed, step)
    predicted, smoothed = (grained(clipped(values, limit), step) for values in (predicted, smoothed))
    data = [
        trace("truth", times[rows], truth[rows], theme),
        trace("observed", times[some], observed[some], theme, visible=view.quantity == 0, marker=hollow(theme, 4)),
        trace("predicted", times[rows], predicted[rows], theme),
        trace("smoothed", times[rows], smoothed[rows], theme),
    ]
    cursor = float(times[view.cursor(len(times))])
    data.append(
        {
            "type": "scatter", "mode": "lines", "x": [cursor, cursor], "y": low_high,
            "line": {"color": tokens(theme)["marker"], "width": 1.5}, "hoverinfo": "skip",
        }
    )  # fmt: skip
    data.append(refused(shown, times, observed))
    name = (
        f"{result.scenario.axes[view.axis]} {STATE_NAMES[view.quantity]}"
        if view.quantity
        else result.scenario.axes[view.axis]
    )
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=f"{key}|{view.axis}|{view.quantity}",
            meta=shown.meta | {"first": 0, "every": rows.step, "every_marker": some.step},
            showlegend=False,
            xaxis={"title": {"text": "time (s)"}, "range": padded_range(times, 0.02)},
            yaxis={"title": {"text": f"{name} ({UNITS[view.quantity]})"}, "range": low_high},
        ),
    }


def _axis_range(
    result: Result, view: View, truth: FloatArray, observed: FloatArray, smoothed: FloatArray
) -> list[float]:
    """What the axis of a state spans: as long as the truth is known, or the measurements are looked at, it stays."""
    error = result.measurements.positions[:, view.axis] - result.truth.positions[:, view.axis]
    if np.isnan(truth).all():
        if view.quantity == 0:
            return padded_range(observed, 0.08)
        finite = smoothed[np.isfinite(smoothed)]
        # What the start has left behind does not count.
        return padded_range(np.quantile(finite, (0.01, 0.99)), 0.3) if finite.size else padded_range(finite)
    # What an error of the measurements makes of this state, whatever the gains: the axis must not move with them.
    spread = float(np.sqrt(np.nanmean(error**2))) / result.experiment.interval**view.quantity
    return padded_range(np.concatenate((truth - spread, truth + spread, observed)), 0.08)


def path_key(shown: Shown) -> str:
    """What the path shows beside the filter."""
    return f"{seen_key(shown)}|{shown.view.exaggerate}|{beside_key(shown)}"


def close_up_key(shown: Shown) -> str:
    """What the close-up shows beside the filter."""
    return f"{seen_key(shown)}|{shown.view.exaggerate}|{shown.view.at}|{beside_key(shown)}"


def axis_key(shown: Shown) -> str:
    """What the plot against time shows beside the filter."""
    return f"{seen_key(shown)}|{shown.view.axis}|{shown.view.quantity}"
