"""The 3-D page as it stands before anything has been computed."""

from __future__ import annotations

from functools import cache

from dash import html
from dash.development.base_component import Component

from layouts.components import numbers_card, plot_card, scene_card
from layouts.desk import stores
from layouts.filter_card import error_card, filter_card, status_row, target_card
from layouts.inputs import sample_inputs, select_field
from layouts.pages.track.answers import DESK, NUMBERS
from layouts.prepared import prepared
from layouts.state import EXAGGERATIONS

SPEEDS = (("10", "run in 10 s"), ("20", "run in 20 s"), ("60", "run in a minute"), ("300", "run in 5 minutes"))

KEY = {
    "truth": "True", "observed": "Observed", "refused": "Not believed", "predicted": "Predicted",
    "smoothed": "Smoothed",
}  # fmt: skip
FIELDS = {"truth": "field-with-truth", "refused": "field-refused"}
"""What is not always there to be seen."""


def layout(**query: str) -> Component:
    """The page as a link describes it; what the link gets wrong is said above the scene."""
    return html.Div(
        [*stores(DESK, query), *_parts()],
        id="track",
        className="desk",
        **{"data-state": "busy"},
    )


@cache
def _parts() -> tuple[Component, ...]:
    """What is the same for every visit."""
    return prepared(
        html.H1("The track in three dimensions", className="visually-hidden"),
        html.Form(
            [filter_card("track"), target_card("track")],
            className="controls",
            **{"aria-label": "Filter, target and sensor"},
        ),
        status_row("track"),
        _scene(),
        plot_card("track-path", "Path", "The path of the target: true, observed, predicted and smoothed."),
        error_card("track"),
        numbers_card(NUMBERS, "every metric per axis, and the samples around the chosen one"),
        html.Div(id="track-live", className="visually-hidden", role="status"),
    )


def _scene() -> Component:
    exaggerate = select_field(
        "track", "exaggerate", "Deviations", "Draws every deviation from the truth this many times larger.",
        [(factor, "to scale" if factor == "1" else f"× {factor}") for factor in EXAGGERATIONS],
    )  # fmt: skip
    key = html.Ul(
        [html.Li(title, className=FIELDS.get(kind, ""), **{"data-kind": kind}) for kind, title in KEY.items()],
        className="scene-key",
    )
    player = html.Div(
        [
            html.Button("Play", type="button", className="quiet", **{"data-part": "play"}),
            html.Select(
                [html.Option(title, value=value, selected=value == "20") for value, title in SPEEDS],
                **{"data-part": "speed", "aria-label": "Speed"},
            ),
            *sample_inputs("track", "Sample"),
        ],
        className="player",
    )
    return scene_card(
        "track",
        "Track in 3-D",
        "The track in space and time; drag to turn, wheel to zoom.",
        "This browser offers no WebGL, so the scene cannot be drawn; path and error below show the same run.",
        [key, html.Span(id="track-scale", className="hint"), exaggerate],
        [player],
    )
