"""The charts of proofs."""

from __future__ import annotations

from typing import Any

import numpy as np

from layouts.figures.common import Figure, packed
from layouts.figures.papers.look import frame, hover, titled
from layouts.theme import LINES, hollow, tokens
from tracker_core.papers.proof import Chart, Series

DASHES = ("solid", "8px 3px", "2px 2px", "6px 2px 2px 2px")
SYMBOLS = ("circle", "diamond", "square", "triangle-up")
REACH = 1.3
"""Of the z-plane to every side, at least."""


def chart_figure(chart: Chart, theme: str) -> Figure:
    """The chart of a proof."""
    data = [_circle(theme)] if chart.z_plane else []
    seen: dict[tuple[str, str], int] = {}
    for series in chart.series:
        again = seen.get((series.kind, series.role), 0)
        seen[series.kind, series.role] = again + 1
        data.append(_trace(chart, series, again, theme))
    x_axis, y_axis = titled(chart.x_title), titled(chart.y_title)
    if chart.z_plane:
        parts = [part for series in chart.series for part in (*series.x, *series.y) if not isinstance(part, str)]
        reach = max(REACH, 1.1 * max((abs(part) for part in parts), default=0.0))
        x_axis |= {"range": [-reach, reach]}
        y_axis |= {"range": [-reach, reach], "scaleanchor": "x"}
    elif chart.logarithmic:
        y_axis |= {"type": "log"}
    return {
        "data": data,
        "layout": frame(
            theme,
            xaxis=x_axis,
            yaxis=y_axis,
            barmode="group",
            uirevision=chart.title,
            meta={"chart": chart.title, "theme": theme},
        ),
    }


def _trace(chart: Chart, series: Series, again: int, theme: str) -> dict[str, Any]:
    """One series; `again` counts those of its kind and colour before it, from which it must be told apart."""
    colour = tokens(theme)[series.role]
    names = bool(series.x) and isinstance(series.x[0], str)
    said = f"{series.name}<br>%{{x}}<br>%{{y:.5~g}}<extra></extra>"
    trace: dict[str, Any] = {
        "type": "scatter", "name": series.name, "x": list(series.x) if names else packed(np.array(series.x), "f8"),
        "y": packed(np.array(series.y), "f8"),
        "hovertemplate": said if names else hover(series.name, chart.x_title, chart.y_title),
    }  # fmt: skip
    if series.kind == "bars":
        pattern = {"pattern": {"shape": "/", "fgcolor": tokens(theme)["surface"]}} if again else {}
        return trace | {"type": "bar", "marker": {"color": colour, **pattern}}
    if series.kind == "points":
        return trace | {"mode": "markers", "marker": _marker(chart, series, again, theme)}
    look = {"width": 2, **LINES.get(series.role, {})}
    return trace | {"mode": "lines", "line": look | ({"dash": DASHES[again % 4]} if again else {}) | {"color": colour}}


def _marker(chart: Chart, series: Series, again: int, theme: str) -> dict[str, Any]:
    colour = tokens(theme)[series.role]
    if chart.z_plane:
        symbol = ("x-thin", "cross-thin", "asterisk", "y-up")[again % 4]
        return {"symbol": symbol, "size": 12, "color": colour, "line": {"width": 3, "color": colour}}
    if series.role == "observed" and not again:
        return hollow(theme, 8)
    return {"symbol": SYMBOLS[again % 4], "size": 9, "color": colour}


def _circle(theme: str) -> dict[str, Any]:
    """The unit circle around the stable poles."""
    angle = np.linspace(0, 2 * np.pi, 181)
    t = tokens(theme)
    return {
        "type": "scatter", "mode": "lines", "name": "Unit circle", "x": packed(np.cos(angle)),
        "y": packed(np.sin(angle)), "line": {"color": t["region-line"], "width": 1.5}, "fill": "toself",
        "fillcolor": t["region"], "hoverinfo": "skip", "showlegend": False,
    }  # fmt: skip
