"""The Explore page as it stands before anything has been computed."""

from __future__ import annotations

from typing import Any

from dash import dcc, html
from dash.development.base_component import Component

from layouts.components import (
    box,
    box_field,
    error_line,
    metric_card,
    plot_card,
    select_field,
    slider,
    slider_field,
    tip,
)
from layouts.controls import controls_of
from layouts.pages.explore.answers import CARDS, NUMBERS
from layouts.state import EXAGGERATIONS, from_query
from tracker_core import CONVENTIONS, DESIGNS, METRICS, SCENARIOS, STARTS
from tracker_core.design import MANUAL
from tracker_core.experiment import PARAMETERS
from tracker_core.fields import FIELDS
from tracker_core.noise import NOISES
from tracker_core.papers import papers
from tracker_core.types import STATE_NAMES


def layout(**query: str) -> Component:
    """The page as a link describes it; what the link gets wrong is said above the plots."""
    settings, notes = from_query({name: str(value) for name, value in query.items()})
    beginning = {
        "controls": controls_of(settings),
        "pin": settings.pin.to_dict() if settings.pin else None,
        "notes": notes,
        "sliders": SLIDERS,
    }
    return html.Div(
        [
            dcc.Store(id="explore-beginning", data=beginning),
            dcc.Store(id="explore-begun"),
            dcc.Store(id="explore-request"),
            dcc.Store(id="explore-answer"),
            dcc.Store(id="explore-answered"),
            html.H1("Explore", className="visually-hidden"),
            _controls(),
            _status(),
            _metrics(),
            *_plots(),
            _numbers_card(),
            html.Div(id="explore-live", className="visually-hidden", role="status"),
        ],
        id="explore",
        className="explore",
    )


ORDER_TITLES = [("2", "2  α-β"), ("3", "3  α-β-γ"), ("4", "4  α-β-γ-η")]

SLIDERS: dict[str, dict[str, Any]] = {
    # Where a gain is written larger, its slider reaches as much further: `factors` follow the convention.
    "alpha": {"low": 0, "high": 2, "curve": 1},
    "beta": {"low": 0, "high": 4, "curve": 2},
    "gamma": {"low": 0, "high": 4, "curve": 3, "factors": {c.name: c.factors[2] for c in CONVENTIONS.values()}},
    "eta": {"low": 0, "high": 4, "curve": 4, "factors": {c.name: c.factors[3] for c in CONVENTIONS.values()}},
    "xi": {"low": 0, "high": 0.999, "curve": 1},
    "tracking_index": {"low": 1e-4, "high": 100, "curve": "log"},
}
"""What the sliders span (normalised gains), and how: a power of the travel, or its logarithm."""


def _controls() -> Component:
    return html.Form(
        [
            _filter_card(),
            _target_card(),
        ],
        className="controls",
        **{"aria-label": "Filter, target and sensor", "data-page": "explore"},
    )


def _field(name: str) -> tuple[str, str, str]:
    field = FIELDS[name]
    title = f"{field.title} {field.symbol}" if field.symbol in ("n", "T", "σ") else field.title
    return name, title, field.sentence


def _filter_card() -> Component:
    runs = [(f"{paper.name}/{run.name}", run.title) for paper in papers().values() for run in paper.runs]
    headings = [paper.title for paper in papers().values() for _ in paper.runs]
    return html.Section(
        [
            html.H2("Filter"),
            select_field(
                "explore", "preset", "Run from a paper", "One click loads a paper's run with all its settings.",
                [("", "–"), *runs], ["", *headings],
            ),
            html.Div(
                [
                    select_field("explore", *_field("order"), ORDER_TITLES),
                    select_field(
                        "explore", *_field("convention"),
                        [(c.name, c.title) for c in CONVENTIONS.values()],
                    ),
                ],
                className="pair",
            ),
            select_field(
                "explore", *_field("design"), [(MANUAL, "Manual"), *((d.name, d.title) for d in DESIGNS.values())]
            ),
            html.P(id="explore-formula", className="formula"),
            html.Div(
                [
                    slider_field("explore", name, FIELDS[name].symbol, FIELDS[name].title, FIELDS[name].sentence)
                    for name in PARAMETERS
                ],
                className="gains",
            ),
        ],
        className="card",
    )  # fmt: skip


def _target_card() -> Component:
    return html.Section(
        [
            html.H2("Target and sensor"),
            select_field("explore", *_field("scenario"), [(s.name, s.title) for s in SCENARIOS.values()]),
            html.P(id="explore-description", className="formula"),
            html.Div(
                [
                    box_field("explore", *_field("samples")),
                    box_field("explore", *_field("interval"), FIELDS["interval"].unit),
                ],
                className="pair",
            ),
            html.Div(
                [
                    select_field("explore", *_field("noise"), [(name, noise.title) for name, noise in NOISES.items()]),
                    box_field("explore", *_field("noise_std"), FIELDS["noise_std"].unit),
                ],
                className="pair",
            ),
            html.Div(
                [
                    html.Div(
                        [
                            html.Label(
                                "Seed", htmlFor="explore-seed", className="tip", **{"data-tip": FIELDS["seed"].sentence}
                            ),
                            html.Div(
                                [
                                    box("explore", "seed", "Seed"),
                                    html.Button("New", id="explore-new-seed", type="button", className="quiet",
                                                **{"aria-label": "Draw new noise: next seed"}),
                                ],
                                className="with-button",
                            ),
                            error_line("explore", "seed"),
                        ],
                        className="field",
                    ),
                    select_field("explore", *_field("start"), [(s.name, s.title) for s in STARTS.values()]),
                ],
                className="pair",
            ),
        ],
        className="card",
    )  # fmt: skip


def _status() -> Component:
    return html.Div(
        [
            html.Div(id="explore-status", className="status"),
            html.Div(id="explore-note", className="note"),
        ],
        className="status-row",
    )


def _metrics() -> Component:
    cards = [
        metric_card(name, title, f"{METRICS[name].sentence} {METRICS[name].formula}") for name, title in CARDS.items()
    ]
    return html.Section(
        [
            html.Div(cards, className="metrics"),
            html.Div(
                [
                    html.Button("Pin", id="explore-pin", type="button", className="quiet",
                                **{"aria-label": "Pin this filter: show every metric's change from here"}),
                    html.Button("Unpin", id="explore-unpin", type="button", className="quiet", hidden=True),
                ],
                className="metric-tools",
            ),
        ],
        className="card metrics-card",
        **{"aria-label": "Metrics"},
    )  # fmt: skip


def _plots() -> list[Component]:
    cursor = html.Div(
        [
            html.Label("Sample", htmlFor="explore-at-slider"),
            slider("explore", "at", "Sample in the close-up"),
            html.Output(id="explore-at-text"),
        ],
        className="cursor",
    )  # fmt: skip
    exaggerate = select_field(
        "explore", "exaggerate", "Deviations",
        "Draws every deviation from the truth this many times larger, in path and close-up.",
        [(factor, "to scale" if factor == "1" else f"× {factor}") for factor in EXAGGERATIONS],
    )  # fmt: skip
    axes = list(dict.fromkeys(axis for scenario in SCENARIOS.values() for axis in scenario.axes))
    return [
        plot_card(
            "explore-path", "Path", "The path of the target: true, observed, predicted and smoothed.", [exaggerate]
        ),
        plot_card(
            "explore-close-up", "Close-up", "Thirty samples of the path around the chosen one.",
            [
                html.Span(id="explore-scale", className="hint"),
                tip("30 samples", "Around the sample chosen below; click on any plot to choose another.", "hint"),
            ],
            [cursor],
        ),
        plot_card(
            "explore-time", "Over time", "One state of one axis against time.",
            [
                select_field("explore", "axis", "Axis", "Which coordinate is shown.", [(axis, axis) for axis in axes]),
                select_field("explore", "quantity", "State", "Which state of it is shown.",
                             [(state, state) for state in STATE_NAMES]),
            ],
        ),
        plot_card("explore-error", "Error", "Distance of prediction and smoothed position from the truth over time."),
        plot_card(
            "explore-stability", "Stability", "The stable region of alpha and beta with the present gains in it.",
            [html.Span(id="explore-slice", className="hint")],
        ),
    ]  # fmt: skip


def _numbers_card() -> Component:
    return html.Section(
        html.Details(
            [
                html.Summary("Numbers: every metric per axis, and the samples of the close-up"),
                html.Div(id=NUMBERS, className="numbers"),
            ],
            id="explore-numbers-details",
        ),
        className="card numbers-card",
        **{"aria-label": "Numbers"},
    )
