"""The Papers page as it stands before anything has been run: everything that is printed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

from dash import dcc, html
from dash.development.base_component import Component

from layouts.components import GRAPH_CONFIG, filled_table, typeset
from layouts.figures.papers import KINDS
from layouts.figures.summary import HEAD
from layouts.pages.papers.tables import KEYS, table_view, verdict_mark
from layouts.prepared import prepared
from layouts.state import Settings, to_query
from layouts.text import error_text
from tracker_core import InputError
from tracker_core.checks import check_choice
from tracker_core.papers import NAMES, SEEDS, VERDICTS, Erratum, Illustration, Paper, Run, Table, papers

RUNS = (("", "as many as usual"), ("20", "20"), ("100", "100"), ("300", "300"), ("1000", "1,000"))


def layout(**query: str) -> Component:
    """The document that a link names, else the first; what the link gets wrong is said above it."""
    paper, seeds, notes = read(query)
    beginning = {
        "paper": paper.name,
        "seeds": seeds,
        "tables": {f"table-{table.name}": table.seeds for table in paper.tables},
        "config": GRAPH_CONFIG,
    }
    return html.Div(
        [
            dcc.Store(id="papers-beginning", data=beginning),
            dcc.Store(id="papers-begun"),
            html.H1("The papers, run live", className="visually-hidden"),
            _contents(paper),
            html.Div([_intro(paper, seeds, notes), *_parts(paper.name, seeds)], className="paper-parts"),
            # plotly comes with the first graph: it is loaded while the tables are computed.
            html.Div(dcc.Graph(figure={"data": [], "layout": {"meta": {}}}), hidden=True),
        ],
        id="papers",
        className="desk",
        **{"data-state": "busy", "data-paper": paper.name},
    )


@lru_cache(maxsize=8)
def _parts(name: str, seeds: int | None) -> tuple[Component, ...]:
    """Everything of a document but its head: the same for every visit."""
    paper = papers()[name]
    cards = _section("Tables", (_table(paper, table, seeds) for table in paper.tables))
    cards += _section("Figures", (_figure(paper, figure) for figure in paper.figures))
    cards += _section("Errata", (_erratum(paper, erratum) for erratum in paper.errata))
    cards += _section("Equations", (_equations(paper),))
    cards += _section("Runs", (_runs(paper),))
    return prepared(*cards)


def read(query: Mapping[str, Any]) -> tuple[Paper, int | None, list[str]]:
    """The document and the number of runs that a link asks for, and a sentence for everything that was not used."""
    name, seeds, notes = NAMES[0], None, []
    try:
        name = check_choice("paper", query.get("paper", NAMES[0]), NAMES)
    except InputError as error:
        notes.append(f"{error_text(error)} The first document is shown.")
    if query.get("seeds") is not None:
        try:
            seeds = int(SEEDS.check("seeds", query["seeds"]))
        except InputError as error:
            notes.append(f"{error_text(error)} The usual number is run.")
    return papers()[name], seeds, notes


def _section(title: str, cards: Iterable[Component]) -> list[Component]:
    found = list(cards)
    return [html.H2(title, className="section-title", id=title.lower()), *found] if found else []


def _contents(paper: Paper) -> Component:
    documents = [
        html.Li(
            dcc.Link(other.title, href=f"/papers?paper={other.name}", className="document"), **_current(other, paper)
        )
        for other in papers().values()
    ]
    parts = [
        ("Tables", [(f"table-{table.name}", table.name, table.title) for table in paper.tables]),
        ("Figures", [(f"figure-{figure.name}", figure.name, figure.title) for figure in paper.figures]),
        ("Errata", [(f"erratum-{erratum.number}", str(erratum.number), erratum.title) for erratum in paper.errata]),
    ]
    return html.Nav(
        [
            html.H2("Documents"),
            html.Ul(documents, className="documents"),
            *(
                html.Div([html.Span(title, className="hint"), html.Ul(_anchors(anchors), className="anchors")])
                for title, anchors in parts
                if anchors
            ),
        ],
        className="controls card contents",
        **{"aria-label": "Documents and their parts"},
    )


def _current(other: Paper, paper: Paper) -> dict[str, str]:
    return {"aria-current": "page"} if other.name == paper.name else {}


def _anchors(anchors: Sequence[tuple[str, str, str]]) -> list[Component]:
    return [html.Li(html.A(name.replace("-", " "), href=f"#{part}", title=title)) for part, name, title in anchors]


def _intro(paper: Paper, seeds: int | None, notes: list[str]) -> Component:
    legend = [
        html.Li(
            [
                verdict_mark(verdict),
                html.Span(verdict, className="verdict-name"),
                html.Span("–", className="verdict-count", **{"data-count": KEYS[verdict]}),
                html.Span(sentence, className="hint"),
            ]
        )
        for verdict, sentence in VERDICTS.items()
    ]
    chosen = "" if seeds is None else str(seeds)
    choices = RUNS if chosen in dict(RUNS) else (*RUNS, (chosen, f"{seeds:,}"))
    runs = html.Div(
        [
            html.Label("Runs per simulated cell", htmlFor="papers-seeds"),
            html.Select(
                [html.Option(title, value=value, selected=value == chosen) for value, title in choices],
                id="papers-seeds",
            ),
        ],
        className="field field-seeds",
    )
    return html.Section(
        [
            html.Div([html.H2(paper.title), runs], className="card-head"),
            html.P(paper.summary, className="summary"),
            html.P(paper.citation, className="hint citation"),
            *(html.P(note, className="field-error", role="alert") for note in notes),
            html.Ul(legend, className="verdicts", id="papers-verdicts"),
        ],
        className="card paper-card",
    )


def _head(part: str, title: str, tools: Sequence[Component] = ()) -> Component:
    link = html.A("Link", href=f"#{part}", className="copy", **{"aria-label": f"Copy a link to {title}"})
    return html.Div([html.H3(typeset(title)), *tools, link], className="card-head")


def _table(paper: Paper, table: Table, seeds: int | None) -> Component:
    part, heading = f"table-{table.name}", _heading("Table", table.name, table.title)
    asked = f"?seeds={seeds}" if seeds else ""
    tools = [
        html.Span(className="progress hint"),
        html.Button("Stop", type="button", className="quiet stop", hidden=True, **{"data-stop": part}),
        html.A("CSV", href=f"/papers/{paper.name}/{part}.csv{asked}", download=f"{paper.name}-{part}.csv"),
    ]
    return html.Section(
        [
            _head(part, heading, tools),
            html.P(typeset(table.note), className="hint"),
            html.Div(
                table_view(table),
                className="table-frame",
                tabIndex=0,
                role="region",
                **{"data-part": part, "aria-label": f"{heading}, printed and recomputed"},
            ),
            html.Ul(className="reasons hint"),
            html.P(typeset(f"Left open: {table.left_out}"), className="hint") if table.left_out else None,
            _links(paper, _run_names(table)),
        ],
        id=part,
        className="card paper-table",
    )


def _heading(kind: str, name: str, title: str) -> str:
    """What the document counts is named by its number, what it does not count by its title alone."""
    return f"{kind} {name}. {title}" if name[0].isdigit() else title


def _run_names(table: Table) -> list[str]:
    """The runs that a table reports, by its rows or by its columns."""
    rows = [row.run for row in table.rows]
    columns = [
        str(column.options.get("run", "")).format(row=row.name) for row in table.rows for column in table.columns
    ]
    return [name for name in rows + columns if name]


def _figure(paper: Paper, figure: Illustration) -> Component:
    part, heading = f"figure-{figure.name}", _heading("Figure", figure.name, figure.title)
    return html.Section(
        [
            _head(part, heading),
            html.Div(
                role="figure",
                className="plot-frame",
                style={"height": KINDS[figure.kind].height},
                **{"data-part": part, "aria-label": f"{figure.title}. {figure.note}"},
            ),
            html.P(typeset(figure.note), className="hint"),
            html.Details(
                [html.Summary("The figure in numbers"), filled_table(f"{part}-rows", f"Series of: {heading}", HEAD)],
                className="figure-numbers",
            ),
            _links(paper, figure.options.get("runs", ())),
        ],
        id=part,
        className="card plot-card paper-figure",
    )


def _erratum(paper: Paper, erratum: Erratum) -> Component:
    part = f"erratum-{erratum.number}"
    said = [("Printed", erratum.claim), ("Found", erratum.evidence), ("Therefore", erratum.consequence)]
    return html.Details(
        [
            html.Summary(
                [
                    html.Span(f"{erratum.number}", className="number"),
                    html.H3(typeset(erratum.title)),
                    html.Span(erratum.where, className="hint"),
                ]
            ),
            html.Div(
                [
                    html.Dl([html.Div([html.Dt(term), html.Dd(typeset(text))]) for term, text in said]),
                    html.Div(className="proof", **{"data-part": part}),
                ],
                className="erratum-body",
            ),
            _links(paper, erratum.runs),
        ],
        id=part,
        className="card erratum",
    )


def _equations(paper: Paper) -> Component:
    rows = [
        html.Tr(
            [
                html.Th(equation.name, scope="row"),
                html.Td(typeset(equation.formula), className="text formula-text"),
                html.Td(typeset(equation.what), className="text"),
                html.Td(
                    [*typeset(equation.here), *(html.A(f"erratum {n}", href=f"#erratum-{n}") for n in equation.errata)],
                    className="text",
                ),
            ]
        )
        for equation in paper.equations
    ]
    head = html.Thead(html.Tr([html.Th(cell, scope="col") for cell in ("Eq.", "Formula", "What it is", "Here")]))
    return _listing(head, rows, "Equations of the document")


def _listing(head: Component, rows: list[Component], label: str) -> Component:
    frame = html.Div(
        html.Table([head, html.Tbody(rows)]),
        className="table-frame",
        tabIndex=0,
        role="region",
        **{"aria-label": label},
    )
    return html.Section(frame, className="card paper-listing")


def _runs(paper: Paper) -> Component:
    rows = [
        html.Tr(
            [
                html.Th(run.title, scope="row"),
                html.Td(run.note, className="text"),
                html.Td(dcc.Link("Open in Explore", href=explore_link(run))),
            ]
        )
        for run in paper.runs
    ]
    head = html.Thead(html.Tr([html.Th(cell, scope="col") for cell in ("Run", "What to look at", "")]))
    return _listing(head, rows, "Runs of the document")


def _links(paper: Paper, names: Iterable[str]) -> Component | None:
    """Ways into Explore, one a run."""
    runs = [paper.run(name) for name in dict.fromkeys(names)]
    if not runs:
        return None
    items = [html.Li(dcc.Link(run.title, href=explore_link(run))) for run in runs]
    return html.Div([html.Span("Open in Explore: ", className="hint"), html.Ul(items)], className="open-in")


def explore_link(run: Run) -> str:
    """The address of Explore with that run."""
    return f"/?{to_query(Settings(run.experiment))}"
