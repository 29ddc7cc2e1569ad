"""Stability: take hold of the operating point or of a pole, see what the gains buy."""

from __future__ import annotations

from dash import Dash

from layouts import answering
from layouts.pages.stability.answers import DESK
from layouts.pages.stability.view import layout
from layouts.services import Services

PATH = "/stability"
NAME = "Stability"
TITLE = "Gainscope: stability you can take hold of"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, services: Services) -> None:
    """Attach the page's callbacks."""
    answering.register(app, DESK, services)
