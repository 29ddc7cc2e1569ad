"""The stable region in the (alpha, beta) plane with the operating point."""

from __future__ import annotations

from typing import Any

import numpy as np

from layouts.figures.common import META, Figure, packed, xy
from layouts.theme import layout, tokens
from tracker_core import Result
from tracker_core.stability import region_slice

MOVING = (
    META,
    *xy(0, 1, 2),
    ("data", 2, "marker", "color"),
    ("data", 2, "marker", "symbol"),
    ("layout", "annotations"),
)


def stability_figure(result: Result, theme: str, meta: dict[str, Any]) -> Figure:
    """The triangle of order 2, or the slice through the present gamma and eta for orders 3 and 4.

    Args:
        result: the run.
        theme: "light" or "dark".
        meta: what the page knows of this drawing; put into the layout.
    """
    t = tokens(theme)
    alpha, beta = region_slice(result.gains)
    curve = _critical(result)
    point = result.gains.vector[:2]
    colour = t["good"] if result.verdict.stable else t["bad"]
    notes = [_note(2.0, 4.0, "stable inside", t["ink-soft"])] if alpha.size else []
    if not alpha.size:
        notes = [_note(2.0, 4.0, "no α, β is stable with this γ, η", t["bad"])]
    return {
        "data": [
            {
                "type": "scatter", "mode": "lines", "x": packed(alpha), "y": packed(beta), "fill": "toself",
                "fillcolor": t["region"], "line": {"color": t["region-line"], "width": 1.5}, "hoverinfo": "skip",
                "name": "Stable region",
            },
            {
                "type": "scatter", "mode": "lines", "x": packed(curve[0]), "y": packed(curve[1]), "hoverinfo": "skip",
                "line": {"color": t["ink-soft"], "width": 1, "dash": "dot"}, "name": "Critically damped",
            },
            {
                "type": "scatter", "mode": "markers", "x": [float(point[0])], "y": [float(point[1])],
                "marker": {
                    "size": 13, "color": colour, "symbol": "circle" if result.verdict.stable else "x",
                    "line": {"width": 2, "color": t["surface"]},
                },
                "name": "Present gains", "hovertemplate": "α %{x:.4g}<br>β %{y:.4g}<extra></extra>",
            },
        ],
        "layout": layout(
            theme,
            uirevision="stability",
            meta=meta,
            showlegend=False,
            annotations=notes,
            xaxis={"title": {"text": "α"}, "range": [-0.1, 2.1], "dtick": 0.5},
            yaxis={"title": {"text": "β"}, "range": [-0.2, 4.2], "dtick": 1},
        ),
    }  # fmt: skip


def _critical(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Critical damping of order 2: beta = 2 - alpha - 2 sqrt(1 - alpha); nothing for other orders."""
    if result.gains.order != 2:
        return np.empty(0), np.empty(0)
    alpha = np.linspace(0, 1, 80)
    return alpha, 2 - alpha - 2 * np.sqrt(1 - alpha)


def _note(x: float, y: float, text: str, colour: str) -> dict[str, Any]:
    return {
        "x": x, "y": y, "xanchor": "right", "yanchor": "top", "text": text, "showarrow": False,
        "font": {"color": colour, "size": 12},
    }  # fmt: skip
