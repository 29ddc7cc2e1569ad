"""The pages that there are, in the order in which they are navigated."""

from __future__ import annotations

from dash import Dash, register_page

from layouts.pages import compare, data, explore, learn, papers, stability, track, tune
from layouts.services import Services

PAGES = (explore, stability, tune, compare, data, track, papers, learn)


def register(app: Dash, services: Services) -> None:
    """Put all pages into the application, with what they answer."""
    for order, page in enumerate(PAGES):
        register_page(page.__name__, path=page.PATH, name=page.NAME, title=page.TITLE, order=order, layout=page.layout)
        page.register(app, services)
