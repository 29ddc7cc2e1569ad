"""The parts that pages are put together from: terms, metrics, tables, cards."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dash import dcc, html
from dash.development.base_component import Component

from layouts.text import subscripts

GRAPH_CONFIG: Any = {
    "displaylogo": False,
    "responsive": True,
    "scrollZoom": False,
    # Nothing that is shown leaves this server for another.
    "modeBarButtonsToRemove": ["select2d", "lasso2d", "autoScale2d", "sendChartToCloud"],
    "plotlyServerURL": "",
}


def tip(text: str, sentence: str, role: str = "") -> Component:
    """A term that explains itself on hover, focus and tap; assets/tips.js shows the sentence."""
    return html.Span(
        text, className=f"tip {role}".strip(), tabIndex=0, **{"data-tip": sentence, "aria-description": sentence}
    )


def typeset(text: str) -> list[Component | str]:
    """A text whose subscripts stand below the line."""
    return [html.Sub(piece) if low else piece for piece, low in subscripts(text)]


def metric_card(name: str, title: str, sentence: str) -> Component:
    """A figure of merit, filled in by the page's script: value, and change since the last pin."""
    return html.Div(
        [
            tip(title, sentence, "metric-title"),
            html.Div("–", className="metric-value"),
            html.Div(className="metric-change"),
        ],
        className="metric",
        **{"data-metric": name},
    )


def table(caption: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> Component:
    """A table of numbers; the first cell of a row names it."""
    return html.Div(
        html.Table(
            [
                html.Caption(caption),
                html.Thead(html.Tr([html.Th(cell, scope="col") for cell in head])),
                html.Tbody(
                    [html.Tr([html.Th(row[0], scope="row"), *(html.Td(cell) for cell in row[1:])]) for row in rows]
                ),
            ]
        ),
        className="table-frame",
        tabIndex=0,
        role="region",
        **{"aria-label": caption},
    )


def filled_table(body_id: str, caption: str, head: Sequence[str | Component]) -> Component:
    """A table whose rows the page's script fills in with every answer; a heading may be a cell that is made already."""
    return html.Div(
        html.Table(
            [
                html.Caption(caption),
                html.Thead(html.Tr([html.Th(cell, scope="col") if isinstance(cell, str) else cell for cell in head])),
                html.Tbody(id=body_id),
            ]
        ),
        className="table-frame",
        tabIndex=0,
        role="region",
        **{"aria-label": caption},
    )


_NOTHING = "rgba(0,0,0,0)"

BEFORE = {
    "data": [],
    "layout": {
        "xaxis": {"visible": False}, "yaxis": {"visible": False},
        "paper_bgcolor": _NOTHING, "plot_bgcolor": _NOTHING,
        # About those of all plots: within plotly's own, which are wider, the first legend breaks and stays too low.
        "margin": {"l": 60, "r": 12, "t": 34, "b": 40},
    },
}  # fmt: skip
"""What a plot shows before there is an answer: axes would be drawn for nothing, and flash in another theme."""


def plot_card(
    graph_id: str, title: str, label: str, tools: Sequence[Component] = (), below: Sequence[Component] = ()
) -> Component:
    """A plot with its heading and its own controls.

    Args:
        graph_id: of the dcc.Graph.
        title: heading.
        label: what a screen reader is told that the plot shows.
        tools: controls in the heading.
        below: controls under the plot.
    """
    return html.Section(
        [
            html.Div([html.H2(title, id=f"{graph_id}-title"), *tools], className="card-head"),
            html.Div(
                [
                    dcc.Graph(id=graph_id, figure=BEFORE, config=GRAPH_CONFIG, className="plot"),
                    save_figure(title),
                ],
                role="figure",
                className="plot-frame",
                **{"aria-label": label},
            ),
            *below,
        ],
        className="card plot-card",
        id=f"{graph_id}-card",
        **{"aria-labelledby": f"{graph_id}-title"},
    )


def save_figure(title: str) -> Component:
    """Opens to the two ways in which the figure of a frame can be saved; assets/figures.js does it."""
    return html.Details(
        [
            html.Summary("⤓", title="Save the figure", **{"aria-label": f"Save the figure: {title}"}),
            html.Div(
                [
                    html.Button(kind.upper(), type="button", className="quiet", **{"data-save": kind})
                    for kind in ("svg", "png")
                ],
                className="save-kinds",
            ),
        ],
        className="save",
    )


def study_row(page: str) -> Component:
    """How far a page's study has come, and the button that stops it; assets/study.js fills it in.

    What changes several times a second is not read out; what is comes in quarters.
    """
    return html.Div(
        [
            html.Progress(id=f"{page}-study-bar", max=1, value=0, **{"aria-label": "Progress of the study"}),
            html.Span(id=f"{page}-study-text"),
            html.Span(id=f"{page}-study-said", className="visually-hidden", role="status"),
            html.Button("Stop", id=f"{page}-study-stop", type="button", className="quiet", hidden=True),
            html.Div(id=f"{page}-study-error", className="field-error", role="alert"),
        ],
        className="study-row",
    )


def numbers_card(place: str, said: str) -> Component:
    """Opens to the numbers behind the plots.

    Args:
        place: id of the element that the tables of a page (see `desk.Desk`) are put into.
        said: what they are of.
    """
    return html.Section(
        html.Details(
            [html.Summary(f"Numbers: {said}"), html.Div(id=place, className="numbers")],
            id=f"{place}-details",
            **{"data-tables": place},
        ),
        className="card numbers-card",
        **{"aria-label": "Numbers"},
    )


NO_SCENE = (
    "The scene has no connection: this server shows as many scenes as it can, or something on the way to it lets no "
    "WebSocket through. "
)


def scene_card(
    page: str, title: str, label: str, missing: str, tools: Sequence[Component] = (), below: Sequence[Component] = ()
) -> Component:
    """A scene in three dimensions; assets/scene.js puts it in when it comes into sight.

    Args:
        page: prefix of the ids.
        title: heading.
        label: what the scene shows.
        missing: what is said where the browser cannot draw it.
        tools: controls in the heading.
        below: controls under the scene.
    """
    return html.Section(
        [
            html.Div([html.H2(title, id=f"{page}-scene-title"), *tools], className="card-head"),
            html.Div(
                [NO_SCENE, html.Button("Try again", type="button", className="quiet", **{"data-part": "again"})],
                className="scene-resume",
                hidden=True,
                role="status",
                **{"data-part": "refused"},
            ),
            html.Div(className="scene", **{"data-scene": page, "data-title": label}),
            html.P(missing, className="scene-missing", hidden=True, role="status", **{"data-part": "missing"}),
            html.Div(
                [
                    "The scene was let go after ten minutes without use. ",
                    html.Button("Show it again", type="button", className="quiet", **{"data-part": "show"}),
                ],
                className="scene-resume",
                hidden=True,
                **{"data-part": "resume"},
            ),
            *below,
        ],
        className="card scene-card",
        id=f"{page}-scene-card",
        **{"aria-labelledby": f"{page}-scene-title"},
    )
