"""The Explore page as it stands before anything has been computed."""

from __future__ import annotations

from functools import cache

from dash import html
from dash.development.base_component import Component

from layouts.components import filled_table, numbers_card, plot_card, tip
from layouts.desk import stores
from layouts.filter_card import (
    axis_field,
    close_up_card,
    error_card,
    exaggerate_field,
    filter_card,
    status_row,
    target_card,
)
from layouts.inputs import select_field
from layouts.pages.explore.answers import COMPARED, DESK, NUMBERS
from layouts.prepared import prepared
from layouts.run_cards import run_card
from tracker_core.types import STATE_NAMES


def layout(**query: str) -> Component:
    """The page as a link describes it; what the link gets wrong is said above the plots."""
    return html.Div(
        [*stores(DESK, query), *_parts()],
        id="explore",
        className="desk",
        **{"data-state": "busy", "data-method": ""},
    )


@cache
def _parts() -> tuple[Component, ...]:
    """What is the same for every visit."""
    return prepared(
        html.H1("Explore", className="visually-hidden"),
        _controls(),
        status_row("explore"),
        run_card("explore"),
        *_plots(),
        numbers_card(NUMBERS, "every metric per axis, and the samples of the close-up"),
        html.Div(id="explore-live", className="visually-hidden", role="status"),
    )


def _controls() -> Component:
    return html.Form(
        [
            filter_card("explore"),
            target_card("explore"),
        ],
        className="controls",
        **{"aria-label": "Filter, target and sensor"},
    )


def _plots() -> list[Component]:
    return [
        plot_card(
            "explore-path", "Path", "The path of the target: true, observed, predicted and smoothed.",
            [exaggerate_field("explore")],
        ),
        close_up_card("explore", "Thirty samples of the path around the chosen one."),
        plot_card(
            "explore-gains", "Gains over time", "The gains that the method chose for the axis shown, against time.",
            [tip("per axis", "Of the axis chosen under Over time.", "hint")],
        ),
        _compared_card(),
        plot_card(
            "explore-time", "Over time", "One state of one axis against time.",
            [
                axis_field("explore", "Which coordinate is shown."),
                select_field("explore", "quantity", "State", "Which state of it is shown.",
                             [(state, state) for state in STATE_NAMES]),
            ],
        ),
        error_card("explore"),
        plot_card(
            "explore-stability", "Stability", "The stable region of alpha and beta with the present gains in it.",
            [html.Span(id="explore-slice", className="hint")],
        ),
    ]  # fmt: skip


def _compared_card() -> Component:
    """Filled in where a method looks in hindsight."""
    return html.Section(
        [
            html.P(id="explore-compared-text", className="compared-text"),
            filled_table("explore-compared", "Distance to the truth: RMSE, and the greatest", ["", *COMPARED.values()]),
        ],
        className="card compared-card",
        **{"aria-label": "The oracle beside its causal counterpart and the raw measurement"},
    )
