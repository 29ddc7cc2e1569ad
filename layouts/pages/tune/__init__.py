"""Tune: which gains are best, how certain that is, and what it costs not to know the truth."""

from __future__ import annotations

from dash import Dash

from layouts import answering
from layouts.pages.tune.answers import DESK
from layouts.pages.tune.content import begin
from layouts.pages.tune.view import layout
from layouts.services import Services

PATH = "/tune"
NAME = "Tune"
TITLE = "Gainscope: tune a filter and know how certain it is"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, services: Services) -> None:
    """Attach the page's callbacks and its studies."""
    answering.register(app, DESK, services)
    services.studies.attach(app.server, f"/{DESK.page}/study", begin)
