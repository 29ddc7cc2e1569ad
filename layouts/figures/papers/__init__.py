"""The figures of papers drawn anew, and the charts of proofs."""

from __future__ import annotations

from dataclasses import dataclass

from layouts.figures.common import Figure
from layouts.figures.papers.alphabeta import initialisation, triangle
from layouts.figures.papers.charts import chart_figure
from layouts.figures.papers.look import Draw
from layouts.figures.papers.noise import noise
from layouts.figures.papers.paths import paths, tracks, trajectory
from layouts.figures.papers.searches import precision, search
from layouts.figures.papers.selection import bank, methods, rmse, window
from layouts.figures.papers.states import comparison, lags, stages, states
from tracker_core.papers import Paper
from tracker_core.papers.document import Illustration

__all__ = ["KINDS", "Kind", "chart_figure", "illustration_figure"]


@dataclass(frozen=True, slots=True)
class Kind:
    """A way to draw an illustration.

    Attributes:
        draw: makes the figure.
        height: that it is drawn for, px.
    """

    draw: Draw
    height: int = 340


KINDS: dict[str, Kind] = {
    "trajectory": Kind(trajectory, 260),
    "noise": Kind(noise),
    "search": Kind(search),
    "tracks": Kind(tracks, 420),
    "comparison": Kind(comparison, 400),
    "states": Kind(states, 400),
    "paths": Kind(paths, 440),
    "initialisation": Kind(initialisation),
    "triangle": Kind(triangle, 400),
    "window": Kind(window),
    "bank": Kind(bank, 380),
    "methods": Kind(methods, 420),
    "rmse": Kind(rmse, 400),
    "stages": Kind(stages, 460),
    "lags": Kind(lags, 400),
    "precision": Kind(precision),
}
"""How an illustration may be drawn, by its kind."""


def illustration_figure(paper: Paper, illustration: Illustration, theme: str) -> Figure:
    """A figure of a document, drawn from runs of this laboratory.

    Args:
        paper: the document, whose runs the options of the illustration name.
        illustration: one of its figures.
        theme: "light" or "dark".

    Returns:
        The figure; `height` of its layout is that of its kind, and `meta` says which one it is: figure, paper, theme.
    """
    kind = KINDS[illustration.kind]
    figure = kind.draw(paper, illustration.options, theme)
    figure["layout"] |= {
        "height": kind.height,
        "uirevision": f"{paper.name}|{illustration.name}",
        "meta": {"figure": illustration.name, "paper": paper.name, "theme": theme},
    }
    return figure
