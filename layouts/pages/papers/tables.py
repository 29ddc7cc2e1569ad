"""A table of a document on the page: every printed cell with the recomputed one and its verdict."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dash import html
from dash.development.base_component import Component

from layouts.components import typeset
from layouts.text import significant
from tracker_core.papers import ERRATUM, EXACT, OPEN, VERDICTS, WITHIN, Outcome, Table
from tracker_core.papers.printed import EMPTY, half_unit, number

MARKS = {EXACT: "✓", WITHIN: "≈", ERRATUM: "✗", OPEN: "?"}
"""What stands for a verdict beside its colour."""

KEYS = {EXACT: "exact", WITHIN: "within", ERRATUM: "erratum", OPEN: "open"}
"""What the style sheet calls it."""

FEW = 3
"""A reason of so many cells names them."""

PLAIN = 1e-4
"""Numbers below this are written with an exponent."""


def verdict_mark(verdict: str) -> Component:
    """The mark of a verdict, spelled out for who does not see it."""
    mark = [
        html.Span(MARKS[verdict], **{"aria-hidden": "true"}),
        html.Span(verdict, className="visually-hidden"),
    ]
    return html.Span(mark, className="verdict", **{"data-verdict": KEYS[verdict]})


def table_view(table: Table) -> Component:
    """What is printed, with room for the recomputed numbers; assets/papers.js puts `cell_content` there."""
    heads = [html.Th("", scope="col", rowSpan=2, **{"aria-label": "row"})]
    halves = []
    for column in table.columns:
        unit = f" ({column.unit})" if column.unit else ""
        heads.append(html.Th(typeset(f"{column.title}{unit}"), scope="colgroup", colSpan=2))
        halves += [html.Th("printed", scope="col", className="printed"), html.Th("recomputed", scope="col")]
    rows = []
    for row in table.rows:
        cells = [html.Th(typeset(row.title), scope="row")]
        for column, printed in zip(table.columns, row.cells, strict=True):
            place = {} if printed == EMPTY else {"data-cell": f"{row.name}|{column.name}"}
            kind = "found simulated" if table.seeds else "found"
            cells += [html.Td(printed, className="printed"), html.Td("…" if place else "", className=kind, **place)]
        rows.append(html.Tr(cells))
    return html.Table([html.Thead([html.Tr(heads), html.Tr(halves)]), html.Tbody(rows)], className="printed-table")


def cell_content(outcome: Outcome) -> dict[str, Any]:
    """What stands in a recomputed cell: which one, the number, the interval under it, the verdict, and why."""
    return {
        "cell": f"{outcome.row}|{outcome.column}",
        "text": value_text(outcome),
        "interval": _interval(outcome),
        "verdict": KEYS[outcome.verdict],
        "mark": _mark(outcome),
        "said": outcome.said,
        "why": ". ".join(part for part in (_difference(outcome), outcome.reason) if part),
    }


def _mark(outcome: Outcome) -> str:
    return MARKS[outcome.verdict] + ("" if outcome.erratum is None else str(outcome.erratum))


def reasons(table: Table, outcomes: Sequence[Outcome]) -> list[dict[str, Any]]:
    """Why cells are not exact, every reason once: its mark, what it says, and of which cells unless of many."""
    found: dict[tuple[str, str], list[Outcome]] = {}
    for outcome in outcomes:
        # What the document leaves out stands under the table.
        said = outcome.reason.removeprefix(table.left_out).strip() if outcome.verdict == OPEN else outcome.reason
        if said:
            found.setdefault((outcome.said, said), []).append(outcome)
    rows = {row.name: row.title for row in table.rows}
    columns = {column.name: column.title for column in table.columns}
    return [
        {
            "verdict": KEYS[group[0].verdict],
            "mark": _mark(group[0]),
            "said": group[0].said,
            "text": text,
            "where": ", ".join(f"{rows[o.row]}: {columns[o.column]}" for o in group) if len(group) <= FEW else "",
        }
        for (_, text), group in found.items()
    ]


def value_text(outcome: Outcome) -> str:
    """The recomputed number: as many digits as printed, or four where it is the median of runs."""
    if outcome.estimate is not None:
        return _measured(outcome.value, outcome.printed)
    if outcome.value == 0:
        return "0"
    if abs(float(number(outcome.printed))) < PLAIN:
        return _scientific(outcome.value)
    return f"{outcome.value:,.{_decimals(outcome.printed)}f}".replace("-", "−")


def _decimals(printed: str) -> int:
    return max(0, -int(half_unit(printed).as_tuple().exponent) - 1)


def _measured(value: float, printed: str) -> str:
    """Four digits, but none that is not printed."""
    if 0 < abs(value) < PLAIN:
        return _scientific(value)
    if value.is_integer():
        return f"{value:,.0f}".replace("-", "−")
    text = significant(value)
    shorter = f"{value:,.{_decimals(printed)}f}".replace("-", "−")
    return min(text, shorter, key=len) if _decimals(printed) else text


def _scientific(value: float) -> str:
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{mantissa}e{int(exponent)}".replace("-", "−")


def _interval(outcome: Outcome) -> str:
    found = outcome.estimate
    if found is None:
        return ""
    low, high = (_measured(end, outcome.printed) for end in (found.low, found.high))
    return f"{low} – {high}" if low != high else "all runs"


def _difference(outcome: Outcome) -> str:
    """How far the recomputed number is from the printed one."""
    if outcome.verdict == EXACT or outcome.difference is None:
        return VERDICTS[EXACT].rstrip(".") if outcome.verdict == EXACT else ""
    percent = 100 * outcome.difference
    return f"{'+' if percent >= 0 else '−'}{significant(abs(percent), 2)} % of the printed number"
