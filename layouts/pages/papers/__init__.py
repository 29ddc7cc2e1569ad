"""Papers: the source documents, printed beside recomputed."""

from __future__ import annotations

from dash import Dash

from layouts.pages.papers import answers
from layouts.pages.papers.view import layout
from layouts.services import Services

PATH = "/papers"
NAME = "Papers"
TITLE = "Gainscope: the papers, run live"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, services: Services) -> None:
    """Attach the page's callbacks and the tables as files."""
    answers.register(app, services.work)
