"""The Data page as it stands before a recording is loaded."""

from __future__ import annotations

from functools import cache

from dash import html
from dash.development.base_component import Component

from layouts.components import filled_table, numbers_card, plot_card, study_row
from layouts.desk import stores
from layouts.filter_card import status_row
from layouts.inputs import box_field
from layouts.pages.data.answers import DESK, NUMBERS
from layouts.pages.data.reading_card import reading_card
from layouts.prepared import prepared
from layouts.run_cards import run_card
from tracker_core.fields import FIELDS

EXAMPLES = {
    "good": ("A target in a plane", "Ten samples a second, x and y in metres, the truth beside them."),
    "irregular": ("A ship's AIS", "Latitude and longitude of two vessels, at intervals that vary."),
    "dirty": ("An aircraft's landing", "ADS-B once a second, with outliers, held positions, gaps and broken rows."),
}
"""Made recordings that are served with the page."""

EMPTY = (
    "Load a log of positions over time: a text table (CSV, TSV, gzip too) with a column of time and one to three of "
    "position, as axes, as latitude and longitude, or as range and bearing. Columns, units and times are proposed and "
    "can be changed, whatever is wrong is listed by line, and every page then works on your data."
)

SUGGESTION = (
    "Noise of the sensor and of the manoeuvre, as the innovations tell them, and the filter that is best for them."
)

TAKEN = (
    ("zip", "export.zip", "Everything, one zip", "Track, metrics, experiment, and the filter as code."),
    ("track", "export/track.csv", "Track, CSV", "One row a sample: measured, predicted, smoothed."),
    ("track-json", "export/track.json", "Track, JSON", "The same by column; null where there is nothing."),
    ("metrics", "export/metrics.json", "Metrics, JSON", "Every figure of the run, jointly and per axis."),
    ("experiment", "export/experiment.json", "Experiment, JSON", "What the run follows from."),
    ("findings", "export/findings.csv", "Findings, CSV", "What was found in the file, by line."),
)  # fmt: skip
"""What can be taken home: name, address, title, what it is."""


def layout(**query: str) -> Component:
    """The page as a link describes it; what the link gets wrong is said above the plots."""
    return html.Div(
        [*stores(DESK, query), *_parts()],
        id="data",
        className="desk",
        **{"data-state": "busy", "data-method": "", "data-recording": "none"},
    )


@cache
def _parts() -> tuple[Component, ...]:
    """What is the same for every visit."""
    return prepared(
        html.H1("Data", className="visually-hidden"),
        html.Form([_load_card(), reading_card()], className="controls", **{"aria-label": "Recording"}),
        status_row("data"),
        _file_card(),
        _found_card(),
        _suggestion_card(),
        _take_card(),
        run_card("data"),
        plot_card(
            "data-path", "Path", "The path as measured, predicted and smoothed, with what the gate has not "
            "believed and where the sensor held its position.",
        ),
        plot_card("data-intervals", "Intervals", "The time from every row to the next, over time."),
        plot_card(
            "data-innovation", "Innovation", "How far every measurement lay from its prediction, over time; where "
            "there is a gate, in standard deviations and beside it.",
        ),
        numbers_card(NUMBERS, "intervals and innovations"),
        html.Div(id="data-live", className="visually-hidden", role="status"),
    )  # fmt: skip


def _load_card() -> Component:
    keep = [
        _keep_choice("store", "On this server", checked=True),
        _keep_choice("browser", "In this browser only", checked=False),
    ]
    return html.Section(
        [
            html.H2("Load a recording"),
            html.P(EMPTY, className="load-words"),
            html.Div(
                [
                    html.Label("Choose a file, or drop one here", htmlFor="data-file", className="file-label"),
                    html.Div(id="data-file-place", className="placeholder"),
                    html.Div(id="data-terms", className="hint"),
                ],
                id="data-drop",
                className="drop",
            ),
            html.Fieldset([html.Legend("Keep it"), *keep], className="keep"),
            html.Div(
                [
                    html.Progress(id="data-progress", max=1, value=0, hidden=True, **{"aria-label": "Upload"}),
                    html.Div(id="data-said", role="status", className="said"),
                    html.Div(id="data-data-error", className="field-error", role="alert"),
                ],
                className="load-state",
            ),
            html.Div(
                [
                    html.H3("Examples"),
                    html.Ul([_example(name, *words) for name, words in EXAMPLES.items()], className="examples"),
                ],
                className="load-examples",
            ),
            html.Div(
                [html.H3("In this browser"), html.Ul(id="data-browser-list", className="in-browser")],
                id="data-browser",
                hidden=True,
            ),
        ],
        className="card load-card",
    )


def _keep_choice(value: str, title: str, *, checked: bool) -> Component:
    """One of the places; assets/data.js puts the button in."""
    place = {"keep": value, "checked": "yes" if checked else "no"}
    return html.Div(
        [
            html.Span(className="placeholder", **{f"data-{name}": said for name, said in place.items()}),
            html.Label(title, htmlFor=f"data-keep-{value}"),
        ],
        className="keep-choice",
    )


def _example(name: str, title: str, sentence: str) -> Component:
    return html.Li(
        [
            html.Button(title, type="button", className="quiet", **{"data-example": f"{name}.csv"}),
            html.Span(sentence, className="hint"),
        ]
    )


def _file_card() -> Component:
    return html.Section(
        [
            html.Div(
                [html.H2(id="data-name"), html.Span(id="data-format", className="hint")], className="card-head"
            ),
            html.Div(
                html.Table(
                    [
                        html.Caption("The first rows, and what is read from which column"),
                        html.Thead(id="data-preview-head"),
                        html.Tbody(id="data-preview"),
                    ]
                ),
                className="table-frame preview",
                tabIndex=0,
                role="region",
                **{"aria-label": "The first rows of the file"},
            ),
            html.Div(id="data-preview-left", className="hint"),
        ],
        className="card file-card",
        **{"aria-label": "The file"},
    )  # fmt: skip


def _found_card() -> Component:
    return html.Section(
        [
            html.H2("What was found"),
            html.P(id="data-found-text"),
            html.Div(
                [
                    filled_table("data-facts", "Of the recording", ["What", "As read"]),
                    filled_table("data-counts", "Out of the ordinary", ["What", "Times", "What is done"]),
                ],
                className="found-tables",
            ),
            html.Details(
                [
                    html.Summary("By line, with the reason"),
                    filled_table("data-findings", "The first findings", ["Line", "What", "Reason"]),
                ],
                className="found-lines",
            ),
        ],
        className="card found-card",
        **{"aria-label": "What was found"},
    )


def _suggestion_card() -> Component:
    gate, noise = FIELDS["gate"], FIELDS["noise_std"]
    return html.Section(
        [
            html.Div([html.H2("Tune for me"), html.Span(SUGGESTION, className="hint")], className="card-head"),
            html.Div(
                [
                    html.Div(
                        [
                            html.P(id="data-why", className="why"),
                            html.Div(
                                [
                                    html.Button("Use this filter", id="data-use", type="button", className="primary",
                                                hidden=True),
                                    html.Span(id="data-taken", className="hint", role="status"),
                                ],
                                className="use-row",
                            ),
                        ],
                        className="why-part",
                    ),
                    filled_table("data-estimates", "Estimated noise", ["Axis", "Sensor σ", "Manoeuvre σw"]),
                ],
                className="study-results suggestion",
            ),
            html.Div(
                [
                    box_field("data", "noise_std", "Sensor σ in use", noise.sentence, noise.unit),
                    box_field("data", "gate", gate.title, gate.sentence, gate.unit),
                ],
                className="in-use",
            ),
            html.P(id="data-gate-text", className="hint"),
            study_row("data"),
        ],
        className="card suggestion-card",
        **{"data-study": "", "aria-label": "Tune for me"},
    )  # fmt: skip


def _take_card() -> Component:
    rows = [
        html.Li(
            [
                html.Button(title, type="button", className="primary" if name == "zip" else "quiet",
                            **{"data-take": address}),
                html.Span(sentence, className="hint"),
            ]
        )
        for name, address, title, sentence in TAKEN
    ]  # fmt: skip
    return html.Section(
        [
            html.H2("Take it home"),
            html.Ul(rows, className="taken"),
            html.P(
                "The figures of every page but Papers are saved as SVG or PNG by the button in their corner.",
                className="hint",
            ),
            html.Div(id="data-take-said", role="status", className="said"),
            html.Div(id="data-take-error", role="alert", className="field-error"),
        ],
        className="card take-card",
        **{"aria-label": "Take it home"},
    )
