"""Compare: the present filter among the pinned ones, on the same data and over many seeds."""

from __future__ import annotations

from dash import Dash

from layouts import answering
from layouts.pages.compare.answers import DESK
from layouts.pages.compare.study import begin
from layouts.pages.compare.view import layout
from layouts.services import Services

PATH = "/compare"
NAME = "Compare"
TITLE = "Gainscope: filters side by side"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, services: Services) -> None:
    """Attach the page's callbacks, and the socket of its study."""
    answering.register(app, DESK, services)
    services.studies.attach(app.server, f"{PATH}/study", begin)
