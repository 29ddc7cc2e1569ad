"""Stability: take hold of the operating point or of a pole, see what the gains buy."""

from __future__ import annotations

from dataclasses import replace

from dash import Dash

from layouts import desk
from layouts.pages.stability.answers import DESK, picture
from layouts.pages.stability.view import layout
from layouts.services import Services

PATH = "/stability"
NAME = "Stability"
TITLE = "Gainscope: stability you can take hold of"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, services: Services) -> None:
    """Attach the page's callbacks."""
    show = replace(DESK, scene=lambda shown: services.scenes.show(shown.scene, picture(shown)))
    desk.register(app, show, services)
