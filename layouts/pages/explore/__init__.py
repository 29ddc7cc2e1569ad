"""Explore: drag a slider, watch the filter track."""

from __future__ import annotations

from dash import Dash

from layouts import answering
from layouts.pages.explore.answers import DESK
from layouts.pages.explore.view import layout
from layouts.services import Services

PATH = "/"
NAME = "Explore"
TITLE = "Gainscope: drag the gains, watch the filter track"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, services: Services) -> None:
    """Attach the page's callbacks."""
    answering.register(app, DESK, services)
