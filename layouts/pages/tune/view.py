"""The Tune page as it stands before anything has been computed."""

from __future__ import annotations

from functools import cache

from dash import html
from dash.development.base_component import Component

from layouts.components import filled_table, save_figure, study_row
from layouts.desk import stores
from layouts.filter_card import error_card, filter_card, status_row, target_card
from layouts.inputs import box_field, choice_field, parameter_field, select_field, switch_field
from layouts.pages.tune.answers import DESK
from layouts.pages.tune.content import PLOT
from layouts.pages.tune.numbers import TABLES
from layouts.pages.tune.rivals import HEAD
from layouts.prepared import prepared
from layouts.run_cards import run_card
from layouts.state import plane_name
from layouts.tuning import STUDIES
from tracker_core.fields import FIELDS
from tracker_core.region import PLANES
from tracker_core.tuning import OBJECTIVES, PARAMETERS
from tracker_core.types import ORDERS

HEADINGS = {
    "tracking": "Tracking: before the measurement", "estimation": "Estimation: after it",
    "innovation": "Innovation: needs no truth", "": "Without a run",
}  # fmt: skip
"""Over the objectives, by the error that they are made from."""

PLOT_LABEL = (
    "How good the filter is over what is varied, the best and the present one marked. Over two of three or four gains "
    "the designs' curves are projections: their other gains are not those of the plane."
)


def layout(**query: str) -> Component:
    """The page as a link describes it; what the link gets wrong is said above the study."""
    return html.Div(
        [*stores(DESK, query), *_parts()],
        id="tune",
        className="desk",
        **{"data-state": "busy", "data-method": ""},
    )


@cache
def _parts() -> tuple[Component, ...]:
    """What is the same for every visit."""
    return prepared(
        html.H1("Tune", className="visually-hidden"),
        html.Form(
            [filter_card("tune"), target_card("tune")],
            className="controls",
            **{"aria-label": "Filter, target and sensor"},
        ),
        status_row("tune"),
        run_card("tune"),
        _study_card(),
        error_card("tune", "The present filter's error"),
        html.Div(id="tune-live", className="visually-hidden", role="status"),
    )


def _study_card() -> Component:
    return html.Section(
        [
            html.Div(
                [
                    html.H2("Which gains are best?"),
                    choice_field("tune", "tune", "What is varied", list(STUDIES.items())),
                    switch_field(
                        "tune", "without_truth", "Without the truth",
                        "Tunes on what a tracker sees, the innovations, and says what not knowing the truth costs.",
                    ),
                ],
                className="study-head",
            ),
            html.P(id="tune-data-note", className="study-note"),
            html.Div(_fields(), className="study-fields"),
            html.Div(
                [html.Div(id=PLOT, className="plot"), save_figure("Which gains are best?")],
                role="figure",
                className="plot-frame",
                **{"aria-label": PLOT_LABEL},
            ),
            _results(),
            _numbers(),
            html.Div([html.Span(id="tune-runs", className="hint"), study_row("tune")], className="study-progress"),
        ],
        className="card study-card",
        **{"data-study": "", "aria-label": "Study"},
    )  # fmt: skip


def _results() -> Component:
    """What is said of the study beside its plot; it looks outdated while another question is refused."""
    said = [html.P(id="tune-best"), html.P(id="tune-cost", className="cost")]
    tools = [
        html.Button("Use this", id="tune-use", type="button", className="primary", hidden=True),
        html.Button("Use the cell", id="tune-cell", type="button", className="quiet", hidden=True),
    ]
    found = [html.Div(said, className="found-text"), html.Div(tools, className="found-tools")]
    return html.Div(
        [
            html.Div(found, className="study-found"),
            filled_table("tune-rivals", "The found gains and every design at its best", _head()),
        ],
        className="study-results",
    )


def _numbers() -> Component:
    """Opens to the table of what the plot shows; there is one for each kind of study."""
    tables = [filled_table(f"tune-{name}", caption, head) for name, (caption, head) in TABLES.items()]
    return html.Details([html.Summary("Numbers of the plot"), *tables], className="study-numbers")


def _head() -> list[str | Component]:
    *told, take = HEAD
    return [*told, html.Th(html.Span(take, className="visually-hidden"), scope="col")]


def _fields() -> list[Component]:
    planes = list(dict.fromkeys(plane for order in ORDERS for plane in PLANES[order]))
    titles = [(plane_name(plane), ", ".join(FIELDS[name].symbol for name in plane)) for plane in planes]
    parameters = [(name, f"{p.symbol.replace('_', '')}  {p.title}".replace("_", "")) for name, p in PARAMETERS.items()]
    return [
        select_field(
            "tune", "tune_for", "Tune for", "The number that should be as small as it can be, mean over the runs.",
            [(name, objective.title) for name, objective in OBJECTIVES.items()],
            [HEADINGS[objective.kind] for objective in OBJECTIVES.values()],
        ),
        select_field(
            "tune", "against", "Against", "What is varied: a gain with the others held, or what a design is made from.",
            parameters,
        ),
        box_field("tune", "from", "From", "The first value; empty for the usual one."),
        box_field("tune", "to", "To", "The last value; empty for the usual one."),
        box_field("tune", "points", "Values", "How many values are tried."),
        select_field("tune", "plane", "Plane", "The two gains that are varied; the others are held.", titles),
        box_field("tune", "cells", "Cells a side", "How many values of each of the two gains are tried."),
        box_field("tune", "budget", "Gain sets", "How many sets of gains are tried at most."),
        box_field("tune", "tune_runs", "Runs", "Every filter is run so often, with the seed of the run and the next."),
        parameter_field(
            "tune", "noise_weight", "Weight of the noise",
            "At 1 only the noise that is left counts, at 0 only the lag behind the target's manoeuvre.",
        ),
    ]  # fmt: skip
