"""3-D: the track in space and time, played, scrubbed, turned."""

from __future__ import annotations

from dash import Dash

from layouts import answering
from layouts.pages.track.answers import DESK
from layouts.pages.track.view import layout
from layouts.services import Services

PATH = "/3d"
NAME = "3-D"
TITLE = "Gainscope: the track in three dimensions"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, services: Services) -> None:
    """Attach the page's callbacks."""
    answering.register(app, DESK, services)
