"""How a search goes: the best score after every generation, and what the designs come to."""

from __future__ import annotations

from typing import Any

import numpy as np

from layouts.figures.common import Figure, packed, padded_range
from layouts.figures.papers.look import LEGEND, titled
from layouts.figures.stability_map import CURVE_DASHES
from layouts.figures.tuning.look import kind_of, name_of
from layouts.theme import layout, tokens
from tracker_core.tuning import SearchOutcome

FEW = 20
"""Generations that there is room for from the beginning."""

REACH = 2.0
"""Of designs that are more than so many times as bad as the found gains the plot makes no room for."""


def search_figure(outcome: SearchOutcome, theme: str) -> Figure:
    """The search as it stands."""
    search, t = outcome.search, tokens(theme)
    history = np.array(outcome.history)
    generations = np.arange(1.0, len(history) + 1)
    last = float(max(FEW, len(history)))
    title = name_of(search.objective)
    data: list[dict[str, Any]] = [
        {
            "type": "scatter", "mode": "lines", "name": "Best found so far", "x": packed(generations),
            "y": packed(history, "f8"), "line": {"color": t[kind_of(search.objective)], "width": 2.5, "shape": "hv"},
            "hovertemplate": "%{y:.5~g} m after %{x} generations<extra></extra>",
        }
    ]  # fmt: skip
    for index, rival in enumerate(outcome.rivals):
        look = {"color": t[f"curve-{index % 4 + 1}"], "width": 1.75, "dash": CURVE_DASHES[1:][index % 5]}
        data.append(
            {
                "type": "scatter", "mode": "lines", "name": rival.title, "x": [0, last], "y": [rival.score] * 2,
                "line": look, "hovertemplate": f"{rival.title} %{{y:.5~g}} m<extra></extra>",
            }
        )  # fmt: skip
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision=f"{search.experiment.order}|{search.objective}|{search.experiment.scenario}",
            meta={"study": "search", "theme": theme, "tried": outcome.tried},
            showlegend=True,
            legend=LEGEND,
            margin={"l": 64, "r": 16, "t": 34, "b": 48},
            xaxis=titled("generation", range=[0, last]),
            yaxis=_score_axis(outcome, f"{title}, mean of the runs (m)"),
        ),
    }


def _score_axis(outcome: SearchOutcome, title: str) -> dict[str, Any]:
    scores = np.array([*outcome.history, *(rival.score for rival in outcome.rivals)])
    scores = scores[np.isfinite(scores) & (scores > 0)]
    if not scores.size:
        return titled(title, range=[0, 1])
    low = float(scores.min())
    near = scores[scores <= REACH * low]
    return titled(title, range=padded_range(near, 0.08))
