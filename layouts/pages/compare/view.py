"""The Compare page as it stands before anything has been computed."""

from __future__ import annotations

import json
from functools import cache

from dash import html
from dash.development.base_component import Component

from layouts.comparing import CHOICES, FIGURE_TITLES, PRESENT
from layouts.components import filled_table, numbers_card, plot_card, save_figure, study_row, tip
from layouts.desk import stores
from layouts.filter_card import axis_field, close_up_card, exaggerate_field, filter_card, status_row, target_card
from layouts.inputs import box_field, error_line, select_field
from layouts.pages.compare.answers import DESK, NUMBERS
from layouts.prepared import prepared
from layouts.theme import PIN_LOOKS
from tracker_core.batch import KINDS

RUNS = (20, 100, 1_000, 10_000, 100_000, 1_000_000)
OVER_SEEDS = "Over many seeds"


def layout(**query: str) -> Component:
    """The page as a link describes it; what the link gets wrong is said above the list."""
    return html.Div(
        [*stores(DESK, query), *_parts()],
        id="compare",
        className="desk",
        **{"data-state": "busy", "data-method": ""},
    )


@cache
def _parts() -> tuple[Component, ...]:
    """What is the same for every visit."""
    return prepared(
        html.H1("Compare", className="visually-hidden"),
        html.Form(
            [filter_card("compare"), target_card("compare")],
            className="controls",
            **{"aria-label": "Filter, target and sensor"},
        ),
        status_row("compare"),
        _filters_card(),
        *_plots(),
        _metrics_card(),
        _study_card(),
        numbers_card(NUMBERS, "gains and errors of every filter"),
        html.Div(id="compare-live", className="visually-hidden", role="status"),
    )


def _filters_card() -> Component:
    head = html.Div(
        [
            html.H2("Filters"),
            html.Span(id="compare-data", className="hint"),
            html.Button("Pin the present filter", id="compare-pin", type="button", className="quiet"),
        ],
        className="card-head",
    )
    empty = html.Div(
        [
            html.P("Pin filters, here or on any page, and move the present one against up to six of them."),
            html.Button("Pin three to begin with", type="button", className="primary", **{"data-pinning": "start"}),
        ],
        id="compare-empty",
        className="filters-empty",
        hidden=True,
    )
    return html.Section(
        [
            head,
            empty,
            html.Ul([_filter(slot) for slot in CHOICES], className="filters", **{"aria-label": "Compared filters"}),
            error_line("compare", "reference"),
        ],
        className="card filters-card",
    )


def _filter(slot: int) -> Component:
    """One line of the list; assets/compare.js fills it in and shows it while there is such a filter."""
    name = (
        html.Div([html.Strong("Present"), html.Span(className="filter-own-name hint")], className="filter-name")
        if slot == PRESENT
        else html.Div(className="filter-name", **{"data-slot": str(slot)})
    )
    buttons = [
        html.Button(text, type="button", className="quiet",
                    **{"data-pinning": action, "data-slot": str(slot), "aria-label": f"{spoken} {slot}"})
        for action, text, spoken in (("use", "Use", "Make the present filter of pin"), ("remove", "×", "Remove pin"))
    ]  # fmt: skip
    return html.Li(
        [
            swatch(slot),
            name,
            html.Div(
                [
                    html.Div(className="filter-gains"),
                    html.Div(className="filter-design hint"),
                    html.Div(className="filter-problem"),
                ]
            ),
            html.Label(
                [
                    html.Span(
                        className="placeholder",
                        **{
                            "data-input": "radio",
                            "data-id": f"compare-reference-{slot}",
                            "data-control": "reference",
                            "data-value": str(slot),
                            "data-label": "Reference",
                        },
                    ),
                    "reference",
                    html.Span(
                        " the present filter" if slot == PRESENT else f" pin {slot}", className="visually-hidden"
                    ),
                ],
                htmlFor=f"compare-reference-{slot}",
                className="filter-reference",
            ),
            html.Div([] if slot == PRESENT else buttons, className="filter-tools"),
        ],
        id=f"compare-filter-{slot}",
        hidden=slot != PRESENT,
        **{"data-of-slot": str(slot)},
    )


def swatch(slot: int) -> Component:
    """How a filter is drawn: assets/compare.js draws its line and marker."""
    dash, marker = PIN_LOOKS.get(slot, ("", ""))
    return html.Span(className="swatch", **{"data-look": str(slot), "data-dash": dash, "data-marker": marker})


def _plots() -> list[Component]:
    return [
        plot_card(
            "compare-path", "Path", "The smoothed path of every filter, over the true and the observed one.",
            [tip("smoothed", "What each filter makes of every position once it has been measured.", "hint"),
             exaggerate_field("compare")],
        ),
        close_up_card("compare", "Thirty samples around the chosen one with every filter's estimates."),
        plot_card(
            "compare-error", "Error", "One error of every filter over time.",
            [select_field("compare", "compared", "Error", "Which error is shown over time.",
                          [(kind, kind) for kind in KINDS])],
        ),
        plot_card(
            "compare-gains", "Gains", "Every gain of every filter over time, a row for each; constant ones are level.",
            [axis_field("compare", "Of methods that choose their gains: for which coordinate.")],
        ),
    ]  # fmt: skip


def _head() -> list[Component]:
    """A column for every filter there can be; those that are not there are hidden."""
    return [
        html.Th(
            [swatch(slot), html.Span("Present" if slot == PRESENT else "", **_heading(slot))],
            scope="col", hidden=slot != PRESENT, **{"data-of-slot": str(slot)},
        )
        for slot in CHOICES
    ]  # fmt: skip


def _heading(slot: int) -> dict[str, str]:
    return {} if slot == PRESENT else {"data-heading": str(slot)}


def _metrics_card() -> Component:
    return html.Section(
        [
            html.Div([html.H2("This run"), _difference_tip()], className="card-head"),
            html.P(id="compare-counted", className="study-note"),
            filled_table("compare-metrics", "Every metric of every filter in the run shown", ["Metric", *_head()]),
        ],
        className="card compare-table",
        **{"aria-label": "Metrics of this run"},
    )


def _difference_tip() -> Component:
    return tip(
        "change from the reference", "Below each number: its difference to the reference, and in percent.", "hint"
    )


def _study_card() -> Component:
    counts = [
        html.Button(
            f"{count:,}", type="button", className="quiet",
            **{"data-controls": json.dumps({"runs": count}), "aria-label": f"{count:,} runs"},
        )
        for count in RUNS
    ]  # fmt: skip
    figure = select_field("compare", "figure", "Metric", "Whose differences are drawn.", list(FIGURE_TITLES.items()))
    return html.Section(
        [
            html.Div([html.H2(OVER_SEEDS), figure], className="card-head"),
            html.P(id="compare-chance", className="formula short"),
            html.Div(
                [
                    box_field("compare", "runs", "Runs", "How often everything is run, each time with the next seed."),
                    html.Div(counts, className="counts", role="group", **{"aria-label": "Usual numbers of runs"}),
                ],
                className="runs field-over-seeds",
            ),
            html.Div(study_row("compare"), className="field-over-seeds"),
            html.Div(
                [
                    html.Div(
                        [html.Div(id="compare-forest", className="plot"), save_figure(OVER_SEEDS)],
                        role="figure",
                        className="plot-frame forest",
                        **{"aria-label": "Difference of every filter to the reference, with its interval."},
                    ),
                    html.P(id="compare-runs-text", className="formula short"),
                    filled_table("compare-over-runs", "Every metric over all runs", ["Metric", *_head()]),
                ],
                className="study-results field-over-seeds",
            ),
        ],
        className="card compare-table",
        **{"data-study": "", "aria-label": "Over many seeds"},
    )
