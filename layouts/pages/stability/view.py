"""The Stability page as it stands before anything has been computed."""

from __future__ import annotations

from functools import cache

from dash import html
from dash.development.base_component import Component

from layouts.components import filled_table, numbers_card, plot_card, scene_card
from layouts.desk import stores
from layouts.filter_card import filter_card, metrics_card, status_row
from layouts.inputs import box_field, sample_cursor, select_field
from layouts.pages.stability.answers import CARDS, DESK, NUMBERS
from layouts.prepared import prepared
from layouts.state import BACKGROUNDS, INPUTS, plane_name
from layouts.text import LABELS
from tracker_core.fields import FIELDS
from tracker_core.merits import MERITS
from tracker_core.region import PLANES
from tracker_core.types import ORDERS

BACKGROUND_TITLES = {"none": "plain", "noise": "noise gain", "lag": "lag"}
LIMITS = {
    "limit_noise": ("", "Variance of the smoothed position per variance of the measurements, at most."),
    "limit_lag": ("m", "Lag of the smoothed position under one unit of manoeuvre (m/s², m/s³, m/s⁴), at most."),
    "limit_overshoot": ("%", "Overshoot of the response to a step, at most."),
    "limit_settling": ("s", "Time until the response to a step stays within 2 %, at most."),
}


def layout(**query: str) -> Component:
    """The page as a link describes it; what the link gets wrong is said above the plots."""
    return html.Div(
        [*stores(DESK, query), *_parts()],
        id="stability",
        className="desk",
        **{"data-state": "busy", "data-method": ""},
    )


@cache
def _parts() -> tuple[Component, ...]:
    """What is the same for every visit."""
    return prepared(
        html.H1("Stability", className="visually-hidden"),
        html.Form(
            [filter_card("stability"), _limits_card()],
            className="controls",
            **{"aria-label": "Filter and limits"},
        ),
        status_row("stability"),
        metrics_card("stability", CARDS, MERITS),
        *_plots(),
        _tests_card(),
        scene_card(
            "stability",
            "The region of order 3",
            "The stable region in alpha, beta, gamma with the present gains; drag to turn, wheel to zoom.",
            "This browser offers no WebGL, so the region cannot be drawn in three dimensions; the map above shows "
            "its slice through the present gains.",
            [html.Span(id="stability-space", className="hint")],
        ),
        plot_card("stability-path", "Path", "The path of the target: true, observed, predicted and smoothed."),
        numbers_card(NUMBERS, "poles, variance of every state, consistency of the run, responses"),
        html.Div(id="stability-live", className="visually-hidden", role="status"),
    )


def _limits_card() -> Component:
    boxes = [box_field("stability", name, LABELS[name], sentence, unit) for name, (unit, sentence) in LIMITS.items()]
    return html.Section(
        [
            html.H2("Limits"),
            html.P("What exceeds a limit is shaded in the map. Empty: no limit.", className="formula short"),
            html.Div(boxes[:2], className="pair"),
            html.Div(boxes[2:], className="pair"),
        ],
        className="card",
    )


def _plots() -> list[Component]:
    planes = list(dict.fromkeys(plane for order in ORDERS for plane in PLANES[order]))
    titles = [(plane_name(plane), "-".join(FIELDS[name].symbol for name in plane)) for plane in planes]
    return [
        plot_card(
            "stability-map", "Stable region", "The stable region in a plane of two gains with the present gains in it.",
            [
                html.Span(id="stability-slice", className="hint"),
                select_field("stability", "plane", "Plane", "The two gains that the map is drawn over.", titles),
                select_field(
                    "stability", "background", "Background", "What the colours of the map show.",
                    [(name, BACKGROUND_TITLES[name]) for name in BACKGROUNDS],
                ),
            ],
            [sample_cursor("stability", "Sample whose gains are shown")],
        ),
        plot_card(
            "stability-poles", "Poles", "The poles of the filter in the z-plane; stable inside the unit circle.",
            [html.Span(id="stability-damping", className="hint")],
        ),
        plot_card(
            "stability-response", "Response", "The filter's answer to a power of the time, and what is missing.",
            [select_field("stability", "input", "Input", "What the measured position does from time zero on.",
                          [(name, name) for name in INPUTS])],
        ),
        plot_card(
            "stability-frequency", "Frequency response",
            "Magnitude and phase from the measured to the predicted and smoothed position.",
        ),
    ]  # fmt: skip


def _tests_card() -> Component:
    return html.Section(
        [
            html.H2("Why it is stable, or not"),
            html.Div(
                [
                    filled_table(
                        "stability-conditions", "The exact region (normalised gains)", ["inequality", "margin", ""]
                    ),
                    filled_table("stability-jury", "Jury's table", ["condition", "row of the table", "margin", ""]),
                    filled_table(
                        "stability-printed", "As Yu & Wu print it (γ/2T², δ/6T³; δ is η)", ["inequality", "margin", ""]
                    ),
                ],
                className="tests",
            ),
        ],
        className="card tests-card",
    )
