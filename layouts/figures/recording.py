"""A recording: its path with what was marked in it, its intervals, and its innovations."""

from __future__ import annotations

from typing import Any

import numpy as np

from layouts.figures.common import META, Figure, chosen, drawn, packed, padded_range, xy
from layouts.figures.track import PATH_MOVING, path_figure, refused
from layouts.shown import Shown, seen_key, target_key
from layouts.theme import SCORES, layout, tokens
from tracker_core.experiment import Experiment
from tracker_core.measured import recorded
from tracker_core.metrics import distances
from tracker_core.recordings import Recorded
from tracker_core.recordings.timing import LONG
from tracker_core.types import FloatArray

MARKED_PATH_MOVING = PATH_MOVING
INTERVALS_MOVING = (META,)
INNOVATION_MOVING = (META, *xy(0), *chosen(1), ("layout", "yaxis", "range"))


def recording_of(experiment: Experiment) -> Recorded | None:
    """The recording that is run; None where the target is simulated."""
    if experiment.data is None or experiment.reading is None:
        return None
    return recorded(experiment.data, experiment.reading)


def marked_path_figure(shown: Shown) -> Figure:
    """The path, with the positions that the sensor held."""
    figure = path_figure(shown)
    figure["data"].append(_held(shown))
    return figure


def _held(shown: Shown) -> dict[str, Any]:
    """Where the sensor repeated itself: at the position that it repeats; each bears its sample."""
    found, x, y, places = recording_of(shown.settings.experiment), np.empty(0), np.empty(0), np.empty(0, dtype=np.int64)
    if found is not None:
        places = np.flatnonzero(found.held[: shown.result.experiment.samples])
        places = places[drawn(len(places))]
        there = filled(found.positions)[places]
        x, y = (found.times[places], there[:, 0]) if len(found.axes) == 1 else (there[:, 0], there[:, 1])
    return {
        "type": "scatter", "mode": "markers", "x": packed(x, "f8"), "y": packed(y, "f8"), "name": "Held",
        "customdata": packed(places, "i4"),
        "marker": {"symbol": "diamond-open", "size": 8, "color": tokens(shown.theme)["counterpart"]},
        "showlegend": bool(len(x)),
    }  # fmt: skip


def filled(positions: FloatArray) -> FloatArray:
    """Positions (n, n_axes) with the last one known in the place of a missing one."""
    known = ~np.isnan(positions).any(axis=1)
    last = np.maximum.accumulate(np.where(known, np.arange(len(positions)), 0))
    return positions[last]


def intervals_figure(shown: Shown) -> Figure:
    """The time from every row to the next, gaps marked, and the usual interval."""
    found, theme = recording_of(shown.settings.experiment), shown.theme
    t = tokens(theme)
    times, steps, nominal = np.zeros(1), np.zeros(0), 1.0
    if found is not None:
        times, nominal = found.times[found.lines > 0], found.nominal
        steps = np.diff(times)
    gap = steps > LONG * nominal
    usual = np.flatnonzero(~gap)
    usual = usual[drawn(len(usual))]
    ends = [float(times[0]), float(times[-1])]
    data: list[Figure] = [
        {
            "type": "scatter", "mode": "markers", "x": packed(times[1:][usual], "f8"), "y": packed(steps[usual]),
            "marker": {"size": 4, "color": t["observed"]}, "name": "Interval",
        },
        {
            "type": "scatter", "mode": "markers", "x": packed(times[1:][gap], "f8"), "y": packed(steps[gap]),
            "marker": {"size": 8, "symbol": "triangle-up", "color": t["bad"]}, "name": "Gap",
            "showlegend": bool(gap.any()),
        },
        {
            "type": "scatter", "mode": "lines", "x": ends, "y": [nominal, nominal], "hoverinfo": "skip",
            "line": {"color": t["truth"], "width": 1.5, "dash": "dot"}, "name": "Usual",
        },
    ]  # fmt: skip
    return _over_time(shown, data, "interval (s)", times, [0.0, 1.1 * float(steps.max(initial=nominal))])


def innovation_figure(shown: Shown) -> Figure:
    """How far every measurement lay from its prediction: with a gate in standard deviations, and the gate."""
    result, theme = shown.result, shown.theme
    t, times = tokens(theme), result.truth.times
    far, unit = distances(result.track.innovation), "m"
    if result.gate is not None and result.track.spread is not None:
        with np.errstate(invalid="ignore", over="ignore"):
            far, unit = distances(result.track.innovation / result.track.spread), "σ"
    width = result.gate.width if result.gate is not None and unit == "σ" else None
    gone = result.track.rejected
    believed = far[np.isfinite(far) & (~gone if gone is not None else True)]
    usual = 1.3 * float(np.quantile(believed, 0.99)) if believed.size else 1.0
    top = max(usual, 1.5 * (width or 0.0)) or 1.0
    rows = drawn(len(times))
    ends = [] if width is None else [float(times[0]), float(times[-1])]
    data = [
        {
            "type": "scatter", "mode": "markers", "x": packed(times[rows], "f8"),
            "y": packed(np.where(far <= 1e4 * top, far, np.nan)[rows]),
            "marker": {"size": 4, "color": t[SCORES["innovation"]]}, "name": "Innovation",
        },
        refused(shown, times, np.minimum(far, 0.97 * top)) | {"showlegend": width is not None},
        {
            "type": "scatter", "mode": "lines", "x": ends, "y": [width] * len(ends), "hoverinfo": "skip",
            "showlegend": width is not None,
            "line": {"color": t["bad"], "width": 1.5, "dash": "dash"}, "name": "Gate",
        },
    ]  # fmt: skip
    return _over_time(shown, data, f"innovation ({unit})", times, [0.0, top])


def _over_time(shown: Shown, data: list[Figure], title: str, times: FloatArray, reach: list[float]) -> Figure:
    return {
        "data": data,
        "layout": layout(
            shown.theme,
            uirevision=target_key(shown),
            meta=shown.meta,
            legend={"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
            margin={"l": 56, "r": 12, "t": 34, "b": 40},
            xaxis={"title": {"text": "time (s)"}, "range": padded_range(times, 0.02)},
            yaxis={"title": {"text": title}, "range": reach},
        ),
    }


def intervals_key(shown: Shown) -> str:
    """What the intervals follow from."""
    return target_key(shown)


def innovation_key(shown: Shown) -> str:
    """What the innovations are shown beside."""
    experiment = shown.settings.experiment
    return f"{seen_key(shown)}|{experiment.gate}|{experiment.design}|{experiment.order}"
