"""A table of a document on the page: every printed cell with the recomputed one and its verdict."""

from __future__ import annotations

from collections.abc import Sequence

from dash import html
from dash.development.base_component import Component

from layouts.text import significant
from tracker_core.papers import ERRATUM, EXACT, OPEN, VERDICTS, WITHIN, Outcome, Table
from tracker_core.papers.document import EMPTY, half_unit, number

MARKS = {EXACT: "✓", WITHIN: "≈", ERRATUM: "✗", OPEN: "?"}
"""What stands for a verdict beside its colour."""

KEYS = {EXACT: "exact", WITHIN: "within", ERRATUM: "erratum", OPEN: "open"}
"""What the style sheet calls it."""

PLAIN = 1e-4
"""Numbers below this are written with an exponent."""


def verdict_mark(verdict: str, erratum: int | None = None) -> Component:
    """The mark of a verdict, spelled out for who does not see it; that of an erratum leads to it."""
    said = verdict if erratum is None else f"{verdict} {erratum}"
    mark = [
        html.Span(MARKS[verdict] if erratum is None else f"{MARKS[verdict]}{erratum}", **{"aria-hidden": "true"}),
        html.Span(said, className="visually-hidden"),
    ]
    attributes = {"data-verdict": KEYS[verdict]}
    if erratum is None:
        return html.Span(mark, className="verdict", **attributes)
    return html.A(mark, href=f"#erratum-{erratum}", className="verdict", **attributes)


def table_view(table: Table, outcomes: Sequence[Outcome] | None) -> Component:
    """The table; without outcomes the printed cells alone, with room for the others."""
    found = {(outcome.row, outcome.column): outcome for outcome in outcomes or ()}
    heads = [html.Th("", scope="col", rowSpan=2, **{"aria-label": "row"})]
    halves = []
    for column in table.columns:
        unit = f" ({column.unit})" if column.unit else ""
        heads.append(html.Th(f"{column.title}{unit}", scope="colgroup", colSpan=2))
        halves += [html.Th("printed", scope="col", className="printed"), html.Th("recomputed", scope="col")]
    rows = []
    for row in table.rows:
        cells = [html.Th(row.title, scope="row")]
        for column, printed in zip(table.columns, row.cells, strict=True):
            cells.append(html.Td(printed, className="printed"))
            cells.append(_recomputed(printed, found.get((row.name, column.name))))
        rows.append(html.Tr(cells))
    return html.Table([html.Thead([html.Tr(heads), html.Tr(halves)]), html.Tbody(rows)], className="printed-table")


def _recomputed(printed: str, outcome: Outcome | None) -> Component:
    if printed == EMPTY:
        return html.Td("", className="found")
    if outcome is None:
        return html.Td([html.Div("…"), html.Div("", className="interval")], className="found")
    below = _interval(outcome)
    said = ". ".join(part for part in (_difference(outcome), outcome.reason) if part)
    return html.Td(
        [
            html.Div([f"{value_text(outcome)} ", verdict_mark(outcome.verdict, outcome.erratum)]),
            html.Div(below, className="interval") if below else None,
        ],
        className="found",
        title=said,
    )


def value_text(outcome: Outcome) -> str:
    """The recomputed number: as many digits as printed, or four where it is the median of runs."""
    if outcome.estimate is not None:
        return _measured(outcome.value)
    decimals = -int(half_unit(outcome.printed).as_tuple().exponent) - 1
    if outcome.value == 0:
        return "0"
    if abs(float(number(outcome.printed))) < PLAIN:
        return _scientific(outcome.value)
    return f"{outcome.value:,.{max(0, decimals)}f}".replace("-", "−")


def _measured(value: float) -> str:
    return _scientific(value) if 0 < abs(value) < PLAIN else significant(value)


def _scientific(value: float) -> str:
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{mantissa}e{int(exponent)}".replace("-", "−")


def _interval(outcome: Outcome) -> str:
    found = outcome.estimate
    return "" if found is None else f"{_measured(found.low)} – {_measured(found.high)}"


def _difference(outcome: Outcome) -> str:
    """How far the recomputed number is from the printed one."""
    if outcome.verdict == EXACT or outcome.difference is None:
        return VERDICTS[EXACT].rstrip(".") if outcome.verdict == EXACT else ""
    percent = 100 * outcome.difference
    return f"{'+' if percent >= 0 else '−'}{significant(abs(percent), 2)} % of the printed number"
