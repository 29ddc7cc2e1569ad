"""Data: a recording in, what was found in it, a filter that suits it, and all of it out again."""

from __future__ import annotations

from dash import Dash

from layouts import answering
from layouts.pages.data.answers import DESK
from layouts.pages.data.suggesting import begin
from layouts.pages.data.view import layout
from layouts.services import Services

PATH = "/data"
NAME = "Data"
TITLE = "Gainscope: your own recording in, your tuned filter out"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, services: Services) -> None:
    """Attach the page's callbacks and its suggestion."""
    answering.register(app, DESK, services)
    services.studies.attach(app.server, f"/{DESK.page}/study", begin)
