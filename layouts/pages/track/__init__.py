"""3-D: the track in space and time, played, scrubbed, turned."""

from __future__ import annotations

from dataclasses import replace

from dash import Dash

from layouts import desk
from layouts.pages.track.answers import DESK, picture
from layouts.pages.track.view import layout
from layouts.services import Services

PATH = "/3d"
NAME = "3-D"
TITLE = "Gainscope: the track in three dimensions"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, services: Services) -> None:
    """Attach the page's callbacks."""
    show = replace(DESK, scene=lambda shown: services.scenes.show(shown.scene, picture(shown)))
    desk.register(app, show, services)
