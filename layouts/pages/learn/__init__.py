"""Learn: six short lessons that ask before they show."""

from __future__ import annotations

from dash import ClientsideFunction, Dash, Input, Output

from layouts.pages.learn.view import layout
from layouts.services import Services

PATH = "/learn"
NAME = "Learn"
TITLE = "Gainscope: six lessons on fixed-gain filters"

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash, _services: Services) -> None:
    """Attach the page's beginning; all else happens in the browser."""
    app.clientside_callback(
        ClientsideFunction("learn", "begin"), Output("learn-begun", "data"), Input("learn-beginning", "data")
    )
