"""The figures of papers drawn anew, and the charts of proofs."""

from __future__ import annotations

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

__all__ = ["KINDS", "chart_figure", "illustration_figure"]

KINDS: dict[str, Draw] = {
    "trajectory": trajectory,
    "noise": noise,
    "search": search,
    "tracks": tracks,
    "comparison": comparison,
    "states": states,
    "paths": paths,
    "initialisation": initialisation,
    "triangle": triangle,
    "window": window,
    "bank": bank,
    "methods": methods,
    "rmse": rmse,
    "stages": stages,
    "lags": lags,
    "precision": precision,
}
"""How an illustration may be drawn, by its kind."""


def illustration_figure(paper: Paper, illustration: Illustration, theme: str) -> Figure:
    """A figure of a document, drawn from runs of this laboratory.

    Args:
        paper: the document, whose runs the options of the illustration name.
        illustration: one of its figures.
        theme: "light" or "dark".

    Returns:
        The figure; `meta` of its layout says which one it is: figure, paper and theme.
    """
    figure = KINDS[illustration.kind](paper, illustration.options, theme)
    figure["layout"] |= {
        "uirevision": f"{paper.name}|{illustration.name}",
        "meta": {"figure": illustration.name, "paper": paper.name, "theme": theme},
    }
    return figure
