"""Explore: drag a slider, watch the filter track."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

from dash import ClientsideFunction, Dash, Input, Output

from layouts import live
from layouts.pages.explore.answers import NUMBERS, PLOTS, answer, live_answer
from layouts.pages.explore.view import layout

PATH = "/"
NAME = "Explore"
TITLE = "Gainscope: drag the gains, watch the filter track"
LONG_RUN = 10_000
"""Runs of more samples than this leave the event loop to others."""

__all__ = ["NAME", "PATH", "TITLE", "layout", "register"]


def register(app: Dash) -> None:
    """Attach the page's callbacks."""
    app.clientside_callback(
        ClientsideFunction("explore", "begin"),
        Output("explore-begun", "data"),
        Input("explore-beginning", "data"),
    )
    app.clientside_callback(
        ClientsideFunction("explore", "finish"),
        Output("explore-answered", "data"),
        Input("explore-answer", "data"),
        prevent_initial_call=True,
    )

    @app.callback(
        *[Output(plot, "figure") for plot in PLOTS],
        Output(NUMBERS, "children"),
        Output("explore-answer", "data"),
        Input("explore-request", "data"),
        prevent_initial_call=True,
    )
    async def update(request: dict[str, Any]) -> tuple[Any, ...]:
        updates, rest = await asyncio.to_thread(answer, request) if _is_long(request) else answer(request)
        return *updates, rest

    live.attach(app.server, "/explore/live", live_answer, _is_long)


def _is_long(request: Mapping[str, Any]) -> bool:
    return any(_samples(request.get(part)) > LONG_RUN for part in ("controls", "pin"))


def _samples(described: Any) -> float:
    try:
        return float(described["samples"])
    except (KeyError, TypeError, ValueError, OverflowError):
        return 0
