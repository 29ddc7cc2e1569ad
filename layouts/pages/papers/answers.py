"""What the Papers page answers: a table recomputed, a figure redrawn, a proof carried out; and tables as files."""

from __future__ import annotations

import asyncio
import csv
import io
from collections.abc import Mapping
from functools import lru_cache
from time import perf_counter
from typing import Any

from dash import ClientsideFunction, Dash, Input, Output, dcc, html, set_props
from dash.development.base_component import Component
from fastapi import FastAPI
from fastapi.responses import PlainTextResponse, Response

from layouts.components import GRAPH_CONFIG
from layouts.figures.papers import chart_figure, illustration_figure
from layouts.pages.papers.tables import cell_content
from layouts.pages.papers.view import place
from layouts.theme import THEMES
from tracker_core import InputError
from tracker_core.checks import check_choice
from tracker_core.papers import NAMES, SEEDS, Outcome, Paper, Table, papers, prove, reproduce

FIRST = 2
"""Runs of the first answer about a table."""

AT_ONCE = 0.4
"""Seconds after which an answer about a table takes no more runs; they come with the next."""

MOST = 16
"""Runs that are taken between two looks at the clock."""

COLUMNS = (
    "row", "column", "printed", "recomputed", "low", "high", "coverage", "runs", "difference_percent", "verdict",
    "reason",
)  # fmt: skip


def register(app: Dash) -> None:
    """Attach the page's callbacks and the tables as files."""
    app.clientside_callback(
        ClientsideFunction("papers", "begin"), Output("papers-begun", "data"), Input("papers-beginning", "data")
    )
    app.clientside_callback(
        ClientsideFunction("papers", "finish"),
        Output("papers-answered", "data"),
        Input("papers-answer", "data"),
        prevent_initial_call=True,
    )

    @app.callback(Output("papers-answer", "data"), Input("papers-request", "data"), prevent_initial_call=True)
    async def update(request: dict[str, Any]) -> dict[str, Any]:
        try:
            children, rest = await asyncio.to_thread(answer, request)
        except InputError as error:
            return {"seq": request.get("seq"), "part": request.get("part"), "error": str(error)}
        if children is not None:
            set_props(place(str(request["part"])), {"children": children})
        return rest

    _add_files(app.server)


def _add_files(server: FastAPI) -> None:
    @server.get("/papers/{paper}/table-{table}.csv")
    async def table_file(paper: str, table: str, seeds: str | None = None) -> Response:
        try:
            text = await asyncio.to_thread(table_csv, paper, table, seeds)
        except InputError as error:
            return PlainTextResponse(f"{error}\n", status_code=404 if error.field in ("paper", "table") else 400)
        headers = {"Content-Disposition": f'attachment; filename="{paper}-table-{table}.csv"'}
        return Response(text, media_type="text/csv; charset=utf-8", headers=headers)


def answer(request: Mapping[str, Any]) -> tuple[Component | list[Component] | None, dict[str, Any]]:
    """What a part of a document came to.

    Args:
        request: `seq` of the request, `paper`, `part` ("table-5", "figure-8", "erratum-3"), `theme`; for a table how
            many `runs` there are already, and how many are `wanted` in the end.

    Returns:
        What is to stand in the place of a figure or a proof, and the rest of the answer: `seq`, `part`; for a table its
        `cells` (Dash would take seconds to put hundreds of components there), `runs` taken and `wanted`.

    Raises:
        InputError: for a part that there is not, or a number of runs out of range.
    """
    paper = papers()[check_choice("paper", request.get("paper"), NAMES)]
    kind, _, name = str(request.get("part")).partition("-")
    theme = check_choice("theme", request.get("theme"), THEMES)
    rest = {"seq": request.get("seq"), "part": request["part"]}
    if kind == "table":
        return None, rest | _table(paper, paper.table(name), request)
    if kind == "figure":
        check_choice("part", name, [figure.name for figure in paper.figures])
        return _figure(paper.name, name, theme), rest
    check_choice("part", kind, ("erratum",))
    check_choice("part", name, [str(erratum.number) for erratum in paper.errata])
    return _proof(paper.name, int(name), theme), rest


def _table(paper: Paper, table: Table, request: Mapping[str, Any]) -> dict[str, Any]:
    if not table.seeds:
        outcomes = reproduce(paper, table)
        return {"cells": [cell_content(outcome) for outcome in outcomes], "runs": 0, "wanted": 0}
    wanted = int(SEEDS.check("seeds", table.seeds if request.get("wanted") is None else request["wanted"]))
    runs = min(wanted, int(SEEDS.check("seeds", request.get("runs") or FIRST)))
    begun, step = perf_counter(), FIRST
    outcomes = reproduce(paper, table, runs)
    while runs < wanted and (before := perf_counter()) < begun + AT_ONCE:
        runs = min(wanted, runs + step)
        outcomes = reproduce(paper, table, runs)
        # What is remembered goes fast, and says nothing about what is not: the step stays small.
        step = min(2 * step, MOST) if perf_counter() < before + AT_ONCE / 4 else 1
    return {"cells": [cell_content(outcome) for outcome in outcomes], "runs": runs, "wanted": wanted}


@lru_cache(maxsize=200)
def _figure(paper: str, name: str, theme: str) -> Component:
    found = papers()[paper]
    figure = next(figure for figure in found.figures if figure.name == name)
    return dcc.Graph(figure=illustration_figure(found, figure, theme), config=GRAPH_CONFIG, className="plot")


@lru_cache(maxsize=200)
def _proof(paper: str, number: int, theme: str) -> list[Component]:
    proof = prove(papers()[paper].errata[number - 1].proof)
    lines = [html.Tr([html.Th(label, scope="row"), html.Td(value)]) for label, value in proof.lines]
    verdict = "The numbers prove it." if proof.holds else "The numbers do not prove it."
    parts: list[Component] = [
        html.P(proof.formula, className="proof-formula"),
        html.Table(html.Tbody(lines)),
        html.P(verdict, className="proof-verdict", **{"data-tone": "good" if proof.holds else "bad"}),
    ]
    if proof.chart is not None:
        graph = dcc.Graph(figure=chart_figure(proof.chart, theme), config=GRAPH_CONFIG, className="plot")
        label = f"{proof.chart.title}."
        parts.append(html.Div(graph, className="plot-frame", role="figure", **{"aria-label": label}))
    return parts


def table_csv(paper: str, table: str, seeds: str | None) -> str:
    """A table as CSV, both numbers of every cell in a row of its own.

    Raises:
        InputError: for a document or a table that there is not, or a number of runs out of range.
    """
    found = papers()[check_choice("paper", paper, NAMES)]
    outcomes = reproduce(found, found.table(table), None if seeds is None else int(SEEDS.check("seeds", seeds)))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    writer.writerows(_csv_row(outcome) for outcome in outcomes)
    return text.getvalue()


def _csv_row(outcome: Outcome) -> list[Any]:
    runs = outcome.estimate
    found = [runs.low, runs.high, runs.coverage, runs.runs] if runs else [""] * 4
    percent = "" if outcome.difference is None else 100 * outcome.difference
    return [
        outcome.row, outcome.column, outcome.printed, outcome.value, *found, percent, outcome.said, outcome.reason,
    ]  # fmt: skip
