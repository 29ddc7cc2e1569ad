"""What the Papers page answers: a table recomputed, a figure redrawn, a proof carried out; and tables as files.

Every part has an address of its own. Dash's callbacks would put components where the page's script puts text and
plots, in many times the time.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from functools import lru_cache
from time import perf_counter
from typing import Any

import orjson
from dash import ClientsideFunction, Dash, Input, Output
from fastapi import FastAPI, Request
from fastapi.responses import Response

from layouts.figures.papers import chart_figure, illustration_figure
from layouts.figures.summary import summary_rows
from layouts.pages.papers.tables import cell_content, reasons
from layouts.theme import THEMES
from server.problem import problem
from server.work import NoAnswerError, Work
from tracker_core import InputError
from tracker_core.checks import check_choice
from tracker_core.papers import NAMES, SEEDS, Outcome, Paper, Table, papers, prepare, prove, reproduce

_REMEMBERED: dict[tuple[str, str], int] = {}
"""Of how many runs every table has been recomputed: those cost nothing any more."""

WORKERS = 2
"""Parts that are computed at a time."""

AT_ONCE = 0.4
"""Seconds after which an answer about a table takes no more runs; they come with the next."""

COLUMNS = (
    "row", "column", "printed", "recomputed", "low", "high", "coverage", "runs", "difference_percent", "verdict",
    "reason",
)  # fmt: skip


def register(app: Dash, work: Work) -> None:
    """Attach the page's beginning, and the addresses of its parts."""
    app.clientside_callback(
        ClientsideFunction("papers", "begin"), Output("papers-begun", "data"), Input("papers-beginning", "data")
    )
    _add_routes(app.server, work)


def _add_routes(server: FastAPI, work: Work) -> None:
    # Other pages and other users must not starve beside what is computed here.
    few = work.beside("papers", WORKERS)
    # A file comes in one piece, and a thousand runs take a minute: one after the other.
    one = work.beside("tables", 1)

    @server.get("/papers/{paper}/{part}.json")
    async def part(paper: str, part: str, request: Request) -> Response:
        try:
            found = await few.run(answer, paper, part, request.query_params)
        except InputError as error:
            return problem(error, _status(error))
        except NoAnswerError as error:
            return error.response()
        return Response(orjson.dumps(found), media_type="application/json")

    @server.get("/papers/{paper}/{table}.csv")
    async def table(paper: str, table: str, request: Request) -> Response:
        try:
            text = await one.run(table_csv, paper, table, request.query_params.get("seeds"))
        except InputError as error:
            return problem(error, _status(error))
        except NoAnswerError as error:
            return error.response()
        headers = {"Content-Disposition": f'attachment; filename="{paper}-{table}.csv"'}
        return Response(text, media_type="text/csv; charset=utf-8", headers=headers)


def _status(error: InputError) -> int:
    """Not found for what a document does not have, else a bad request."""
    return 404 if error.field in ("paper", "part") else 400


def answer(paper: str, part: str, options: Mapping[str, str]) -> dict[str, Any]:
    """What a part of a document came to.

    Args:
        paper: name of the document.
        part: "table-5", "figure-8" or "erratum-3".
        options: `theme`; for a table how many runs are `wanted` in the end.

    Returns:
        For a table its `cells`, the `reasons` of their verdicts, `runs` taken and `wanted`; a `figure` with `rows` of
        what it shows; or a `proof`.

    Raises:
        InputError: for a part that there is not, or a number of runs out of range.
    """
    document, kind, name = _named(paper, part)
    if kind == "table":
        return _table(document, document.table(name), options)
    theme = check_choice("theme", options.get("theme"), THEMES)
    return _figure(paper, name, theme) if kind == "figure" else {"proof": _proof(paper, int(name), theme)}


def _named(paper: str, part: str) -> tuple[Paper, str, str]:
    """The document, and kind and name of the part."""
    document = papers()[check_choice("paper", paper, NAMES)]
    parts = [
        *(f"table-{table.name}" for table in document.tables),
        *(f"figure-{figure.name}" for figure in document.figures),
        *(f"erratum-{erratum.number}" for erratum in document.errata),
    ]
    kind, _, name = check_choice("part", part, parts).partition("-")
    return document, kind, name


def _table(paper: Paper, table: Table, options: Mapping[str, str]) -> dict[str, Any]:
    if not table.seeds:
        return _content(paper.name, table.name, None) | {"runs": 0, "wanted": 0}
    wanted = int(SEEDS.check("wanted", table.seeds if options.get("wanted") is None else options["wanted"]))
    remembered = _REMEMBERED.get((paper.name, table.name), 0)
    begun, before = perf_counter(), min(wanted, remembered)
    runs = before
    # Every answer takes a run more, however slow the machine is: the page asks until it has all.
    while runs < wanted and (runs == before or perf_counter() < begun + AT_ONCE):
        runs += 1
        prepare(paper, table, runs)
    _REMEMBERED[paper.name, table.name] = max(runs, remembered)
    return _content(paper.name, table.name, runs) | {"runs": runs, "wanted": wanted}


@lru_cache(maxsize=200)
def _content(paper: str, name: str, runs: int | None) -> dict[str, Any]:
    """What stands in a table after so many runs: judging its cells takes long, and everyone asks for the same."""
    found = papers()[paper]
    table = found.table(name)
    outcomes = reproduce(found, table, runs)
    return {"cells": [cell_content(outcome) for outcome in outcomes], "reasons": reasons(table, outcomes)}


@lru_cache(maxsize=200)
def _figure(paper: str, name: str, theme: str) -> dict[str, Any]:
    found = papers()[paper]
    figure = illustration_figure(found, next(figure for figure in found.figures if figure.name == name), theme)
    return {"figure": figure, "rows": summary_rows(figure)}


@lru_cache(maxsize=200)
def _proof(paper: str, number: int, theme: str) -> dict[str, Any]:
    proof = prove(papers()[paper].errata[number - 1].proof)
    return {
        "formula": proof.formula,
        "lines": proof.lines,
        "holds": proof.holds,
        "label": "" if proof.chart is None else proof.chart.title,
        "figure": None if proof.chart is None else chart_figure(proof.chart, theme),
    }


def table_csv(paper: str, table: str, seeds: str | None) -> str:
    """A table as CSV, both numbers of every cell in a row of its own.

    Raises:
        InputError: for a document or a table that there is not, or a number of runs out of range.
    """
    found, kind, name = _named(paper, table)
    check_choice("part", kind, ("table",))
    outcomes = reproduce(found, found.table(name), None if seeds is None else int(SEEDS.check("seeds", seeds)))
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
