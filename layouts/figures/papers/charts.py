"""The charts of proofs."""

from __future__ import annotations

from typing import Any

import numpy as np

from layouts.figures.common import Figure, packed
from layouts.figures.papers.look import LEGEND, frame, hover, log_axis, titled
from layouts.text import subscripts
from layouts.theme import LINES, hollow, tokens
from tracker_core.papers.proof import Chart, Series

DASHES = ("solid", "8px 3px", "2px 2px", "6px 2px 2px 2px")
SYMBOLS = ("circle", "diamond", "square", "triangle-up")
MARKED = range(4, 13)
"""Of lines of so few points, every one is marked; of fewer they are the ends."""

MANY = 30
"""More points than this are dots."""

REACH = 1.3
"""Of the z-plane to every side, at least."""


def chart_figure(chart: Chart, theme: str) -> Figure:
    """The chart of a proof."""
    crowded = any(series.kind == "points" and len(series.x) > MANY for series in chart.series)
    data = [_circle(theme)] if chart.z_plane else []
    numbers = [part for series in chart.series for part in (*series.x, *series.y) if not isinstance(part, str)]
    seen: dict[tuple[str, str], int] = {}
    for series in chart.series:
        again = seen.get((series.kind, series.role), 0)
        seen[series.kind, series.role] = again + 1
        data.append(_trace(chart, series, again, theme))
    # Names under bars take the room that they need.
    x_axis, y_axis = titled(typeset(chart.x_title), automargin=True), titled(typeset(chart.y_title))
    if chart.z_plane:
        reach = max(REACH, 1.1 * max(map(abs, numbers), default=0.0))
        x_axis |= {"range": [-reach, reach], "constrain": "domain"}
        y_axis |= {"range": [-reach, reach], "scaleanchor": "x"}
    elif chart.logarithmic:
        heights = [value for series in chart.series for value in series.y if value > 0]
        y_axis = log_axis(typeset(chart.y_title), 0.8 * min(heights), 1.25 * max(heights))
    return {
        "data": data,
        "layout": frame(
            theme,
            xaxis=x_axis,
            yaxis=y_axis,
            barmode="group",
            # Dots are to be seen in the legend.
            legend=LEGEND | ({"itemsizing": "constant"} if crowded else {}),
            uirevision=chart.title,
            meta={"chart": chart.title, "theme": theme},
        ),
    }


def typeset(text: str) -> str:
    """The text with plotly's subscripts."""
    return "".join(f"<sub>{piece}</sub>" if low else piece for piece, low in subscripts(text))


def _trace(chart: Chart, series: Series, again: int, theme: str) -> dict[str, Any]:
    """One series; `again` counts those of its kind and colour before it, from which it must be told apart."""
    colour = tokens(theme)[series.role]
    name = typeset(series.name)
    words = [str(x).replace(", ", ",<br>") for x in series.x if isinstance(x, str)]
    said = hover(name, typeset(chart.x_title), typeset(chart.y_title))
    trace: dict[str, Any] = {
        "type": "scatter", "name": name, "x": words or packed(np.array(series.x), "f8"),
        "y": packed(np.array(series.y), "f8"), "hovertemplate": said.replace("%{x:.5~g}", "%{x}") if words else said,
    }  # fmt: skip
    if series.kind == "bars":
        pattern = {"pattern": {"shape": "/", "fgcolor": tokens(theme)["surface"]}} if again else {}
        return trace | {"type": "bar", "marker": {"color": colour, **pattern}}
    if series.kind == "points":
        return trace | {"mode": "markers", "marker": _marker(chart, series, again, theme)}
    look = {"width": 2, **LINES.get(series.role, {})}
    if len(series.x) in MARKED:
        trace["marker"] = {"size": 6, "color": colour}
    mode = "lines+markers" if "marker" in trace else "lines"
    return trace | {"mode": mode, "line": look | ({"dash": DASHES[again % 4]} if again else {}) | {"color": colour}}


def _marker(chart: Chart, series: Series, again: int, theme: str) -> dict[str, Any]:
    colour = tokens(theme)[series.role]
    if len(series.x) > MANY:
        return {"symbol": "circle", "size": 4, "color": colour, "opacity": 0.6}
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
