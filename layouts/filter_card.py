"""The controls that pages share: the filter with its gains, the target with its sensor, the verdict and the cards."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dash import dcc, html
from dash.development.base_component import Component

from layouts.components import metric_card, plot_card, tip
from layouts.inputs import (
    about,
    box,
    box_field,
    error_line,
    parameter_field,
    sample_cursor,
    select_field,
    slider,
    slider_field,
    switch_field,
)
from layouts.state import EXAGGERATIONS
from tracker_core import CONVENTIONS, DESIGNS, SCENARIOS, STARTS
from tracker_core.adaptive import METHODS
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.adaptive.parameters import TITLES
from tracker_core.design import MANUAL
from tracker_core.experiment import PARAMETERS
from tracker_core.fields import FIELDS, NOISE_LEVELS
from tracker_core.manoeuvre import MANOEUVRES
from tracker_core.measured import AXES, RECORDING
from tracker_core.metrics import Metric
from tracker_core.noise import NOISES
from tracker_core.papers import papers

KNOB_SENTENCE = (
    "One knob for the whole filter: it moves along the steady-state Kalman filters, from the smoothest to the most "
    "responsive. Below it stands how much more error variance the present gains cost than the best of them."
)

CHOOSING = "Around the sample chosen below; a click on a point of a path, or of a plot over time, chooses another."

ORDER_TITLES = [("2", "2  α-β"), ("3", "3  α-β-γ"), ("4", "4  α-β-γ-η")]

SLIDERS: dict[str, dict[str, Any]] = {
    # Where a gain is written larger, its slider reaches as much further: `factors` follow the convention.
    "alpha": {"low": 0, "high": 2, "curve": 1},
    "beta": {"low": 0, "high": 4, "curve": 2},
    "gamma": {"low": 0, "high": 4, "curve": 3, "factors": {c.name: c.factors[2] for c in CONVENTIONS.values()}},
    "eta": {"low": 0, "high": 4, "curve": 4, "factors": {c.name: c.factors[3] for c in CONVENTIONS.values()}},
    "responsiveness": {"low": 0, "high": 1, "curve": 1},
    "xi": {"low": 0, "high": 0.999, "curve": 1},
    "tracking_index": {"low": 1e-4, "high": 100, "curve": "log"},
    "fixed_alpha": {"low": 0.005, "high": 1, "curve": 2},
    "weight": {"low": 0, "high": 1, "curve": 1},
    "window": {"low": 2, "high": 200, "curve": 2, "whole": True},
    "step": {"low": 1, "high": 100, "curve": 2, "whole": True},
    "levels": {"low": 1, "high": 100, "curve": 1, "whole": True},
    "grid": {"low": 1, "high": 20, "curve": 1, "whole": True},
    "grid_eta": {"low": 1, "high": 20, "curve": 1, "whole": True},
    "refinements": {"low": 0, "high": 5, "curve": 1, "whole": True},
    "members": {"low": 1, "high": 60, "curve": 1, "whole": True},
    "memory": {"low": 0.05, "high": 1_000, "curve": "log"},
    "shortest": {"low": 0.005, "high": 100, "curve": "log"},
    "longest": {"low": 0.1, "high": 1_000, "curve": "log"},
}
"""What the sliders span (normalised gains), and how: a power of the travel, or its logarithm."""


def _field(name: str) -> tuple[str, str, str]:
    field = FIELDS[name]
    title = f"{field.title} {field.symbol}" if field.symbol in ("n", "T", "σ", "ρ", "σ_w") else field.title
    return name, title, field.sentence


def filter_card(page: str) -> Component:
    """Paper's run, order, convention, design, the smooth-responsive knob and the gains."""
    runs = [(f"{paper.name}/{run.name}", run.title) for paper in papers().values() for run in paper.runs]
    headings = [paper.title for paper in papers().values() for _ in paper.runs]
    return html.Section(
        [
            html.H2("Filter"),
            select_field(
                page, "preset", "Run from a paper", "One click loads a paper's run with all its settings.",
                [("", "–"), *runs], ["", *headings],
            ),
            html.Div(
                [
                    select_field(page, *_field("order"), ORDER_TITLES),
                    select_field(
                        page, *_field("convention"),
                        [(c.name, c.title) for c in CONVENTIONS.values()],
                    ),
                ],
                className="pair",
            ),
            select_field(page, *_field("design"), *design_menu()),
            html.P(id=f"{page}-formula", className="formula"),
            html.P(id=f"{page}-oracle", className="oracle"),
            switch_field(
                page, "beside", "Causal counterpart beside it",
                "Runs the causal method of the same idea on the same measurements and shows both.",
            ),
            _method_fields(page),
            html.P(id=f"{page}-found", className="formula found"),
            html.Div(
                [
                    html.Label("Smooth", htmlFor=f"{page}-responsiveness-slider", className="tip"),
                    slider(page, "responsiveness", "Smooth to responsive, along the optimal filters"),
                    html.Span("Responsive", className="end", **{"aria-hidden": "true"}),
                    html.Div(id=f"{page}-distance", className="hint distance"),
                    about(page, "responsiveness", KNOB_SENTENCE),
                    error_line(page, "responsiveness"),
                ],
                className="knob",
            ),
            html.Div(
                [
                    slider_field(page, name, FIELDS[name].symbol, FIELDS[name].title, FIELDS[name].sentence)
                    for name in PARAMETERS
                ],
                className="gains",
            ),
        ],
        className="card",
    )  # fmt: skip


def design_menu() -> tuple[list[tuple[str, str]], list[str]]:
    """Every design and method by name and title, and the heading of each; those in hindsight carry a mark."""
    options, headings = [(MANUAL, "Manual")], [""]
    for design in DESIGNS.values():
        options.append((design.name, design.title))
        headings.append("Constant gains")
    for method in METHODS.values():
        if method.name not in DESIGNS:
            oracle = bool(method.hindsight(method.defaults(1.0)))
            options.append((method.name, f"◆ {method.title}" if oracle else method.title))
            headings.append("◆ In hindsight: oracles" if oracle else "Chosen as it runs")
    return options, headings


def _method_fields(page: str) -> Component:
    """What methods are told; the page's script shows those of the present one."""
    fields = []
    for name, field in METHOD_PARAMETERS.items():
        if field.kind == "choice":
            fields.append(select_field(page, name, field.title, field.sentence, list(TITLES[name].items())))
        else:
            symbol = f"{field.title} {field.symbol}".strip() if field.symbol not in field.title else field.title
            fields.append(parameter_field(page, name, symbol, field.sentence, field.unit))
    return html.Div(fields, className="method", role="group", **{"aria-label": "Parameters of the method"})


def target_card(page: str) -> Component:
    """Target, samples, interval, noise, seed and start."""
    return html.Section(
        [
            html.H2("Target and sensor"),
            select_field(
                page, *_field("scenario"),
                [*((s.name, s.title) for s in SCENARIOS.values()), (RECORDING, "Your own recording")],
            ),
            html.P(id=f"{page}-description", className="formula"),
            html.Div(
                [
                    dcc.Link("Load a file, or read it in another way", href="/data", id=f"{page}-load",
                             className="page-link carries"),
                    error_line(page, "data"),
                    error_line(page, "reading"),
                ],
                className="field load",
            ),
            html.Div(
                [
                    box_field(page, *_field("samples")),
                    box_field(page, *_field("interval"), FIELDS["interval"].unit),
                ],
                className="pair",
            ),
            html.Div(
                [
                    select_field(page, *_field("noise"), [(name, noise.title) for name, noise in NOISES.items()]),
                    select_field(page, *_field("manoeuvre"), [(m.name, m.title) for m in MANOEUVRES.values()]),
                    select_field(page, *_field("noise_level"), list(NOISE_LEVELS.items())),
                    box_field(page, *_field("noise_std"), FIELDS["noise_std"].unit),
                    box_field(page, *_field("snr")),
                    box_field(page, *_field("noise_correlation")),
                    box_field(page, *_field("manoeuvre_std"), None),
                    box_field(page, *_field("gate"), FIELDS["gate"].unit),
                ],
                className="pair",
            ),
            html.P(id=f"{page}-level", className="formula level"),
            html.Div(
                [
                    _seed_field(page),
                    select_field(page, *_field("start"), [(s.name, s.title) for s in STARTS.values()]),
                ],
                className="pair",
            ),
        ],
        className="card",
    )  # fmt: skip


def _seed_field(page: str) -> Component:
    """The seed, and the next one at a press of a button."""
    draw = {"aria-label": "Draw new noise: next seed"}
    button = html.Button("New", id=f"{page}-new-seed", type="button", className="quiet", **draw)
    return html.Div(
        [
            html.Label("Seed", htmlFor=f"{page}-seed", className="tip"),
            html.Div([box(page, "seed", "Seed"), button], className="with-button"),
            about(page, "seed", FIELDS["seed"].sentence),
            error_line(page, "seed"),
        ],
        className="field field-seed",
    )


def status_row(page: str) -> Component:
    """Verdict, notes, and the way back into the stable region."""
    return html.Div(
        [
            html.Div(
                [
                    html.Span(id=f"{page}-status"),
                    html.Button(id=f"{page}-offer", type="button", className="quiet offer", hidden=True),
                ],
                id=f"{page}-verdict",
                className="status",
            ),
            html.Div(id=f"{page}-note", className="note"),
        ],
        className="status-row",
    )


def metrics_card(
    page: str, cards: Mapping[str, str], metrics: Mapping[str, Metric], instead: Component | None = None
) -> Component:
    """Figures of merit with their change since the last pin.

    Args:
        page: prefix of the ids.
        cards: title by name of the metric.
        metrics: what they are.
        instead: what is shown where nobody knows the truth; None where the figures need none.
    """
    return html.Section(
        [
            html.Div(metric_cards(cards, metrics), className="metrics" + (" field-with-truth" if instead else "")),
            instead,
            html.Div(
                [
                    html.Button("Pin", id=f"{page}-pin", type="button", className="quiet",
                                **{"aria-label": "Pin this filter: show every metric's change from here"}),
                    html.Button("Unpin", id=f"{page}-unpin", type="button", className="quiet", hidden=True,
                                **{"aria-label": "Unpin the filter that was pinned last"}),
                    html.Div(id=f"{page}-since", className="since"),
                ],
                className="metric-tools",
            ),
        ],
        className="card metrics-card",
        **{"aria-label": "Metrics"},
    )  # fmt: skip


def metric_cards(cards: Mapping[str, str], metrics: Mapping[str, Metric]) -> list[Component]:
    """A card for each figure of merit: title by name, and what they are."""
    return [
        metric_card(name, title, f"{metrics[name].sentence} {metrics[name].formula}") for name, title in cards.items()
    ]


def exaggerate_field(page: str) -> Component:
    """How much larger deviations from the truth are drawn."""
    return select_field(
        page, "exaggerate", "Deviations",
        "Draws every deviation from the truth this many times larger, in path and close-up.",
        [(factor, "to scale" if factor == "1" else f"× {factor}") for factor in EXAGGERATIONS],
    )  # fmt: skip


def axis_field(page: str, sentence: str) -> Component:
    """Which coordinate is shown; the page's script offers those of the present target."""
    axes = dict.fromkeys([*(axis for scenario in SCENARIOS.values() for axis in scenario.axes), *AXES])
    return select_field(page, "axis", "Axis", sentence, [(axis, axis) for axis in axes])


def close_up_card(page: str, label: str) -> Component:
    """Some thirty samples around the chosen one, and the slider that chooses it."""
    return plot_card(
        f"{page}-close-up", "Close-up", label,
        [
            html.Span(id=f"{page}-scale", className="hint"),
            tip("30 samples", CHOOSING, "hint"),
        ],
        [sample_cursor(page, "Sample in the close-up")],
    )  # fmt: skip


def error_card(page: str, title: str = "Error") -> Component:
    """The distances over time; the page's script titles them anew where nobody knows the truth."""
    return plot_card(
        f"{page}-error", title,
        "Distance of prediction and smoothed position over time from the truth, or else from the measurements.",
    )  # fmt: skip
