"""Printed beside recomputed: a verdict for every cell of every table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from math import floor, isfinite
from typing import Any

from tracker_core.checks import Domain, InputError
from tracker_core.papers.document import Erratum, Paper, Table
from tracker_core.papers.printed import half_unit, number
from tracker_core.papers.recipes import DERIVED, SIMULATED, Cell, cells

EXACT, WITHIN, ERRATUM, OPEN = "exact", "within interval", "erratum", "not determined"
VERDICTS: dict[str, str] = {
    EXACT: "Recomputed, or printed elsewhere in the document, it agrees to half a unit of the last digit.",
    WITHIN: "The printed number lies where another of our runs would fall.",
    ERRATUM: "The document is wrong here; the erratum says why.",
    OPEN: "The document leaves out what the number depends on.",
}
"""Every verdict, and what it means."""

LEVEL = 0.9
"""Probability with which another run falls into an interval, where there are runs enough."""

SEEDS = Domain(1, 1000, whole=True)
ROUNDING = 1e-12
"""Relative error of what is computed in double precision, for numbers that lie on the half of a unit."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """What runs over several seeds came to.

    Attributes:
        median: of the runs.
        low, high: another run lies between them with the probability `coverage`.
        coverage: as said; below LEVEL where there are fewer than nineteen runs.
        runs: how many.
    """

    median: float
    low: float
    high: float
    coverage: float
    runs: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """One cell, printed and recomputed.

    Attributes:
        row, column: where it stands.
        printed: as printed.
        value: recomputed; the median of the runs where noise is involved.
        estimate: of the runs; None for what does not depend on noise.
        difference: of the recomputed from the printed number, relative to the printed one; None where that is zero.
        verdict: a key of VERDICTS.
        erratum: number of the erratum that explains the cell; None for none.
        reason: why it is not exact, or which table it repeats, in a sentence or two; else empty.
    """

    row: str
    column: str
    printed: str
    value: float
    estimate: Estimate | None
    difference: float | None
    verdict: str
    erratum: int | None
    reason: str

    @property
    def said(self) -> str:
        """The verdict as it is shown."""
        return f"{ERRATUM} {self.erratum}" if self.verdict == ERRATUM else self.verdict

    def to_dict(self) -> dict[str, Any]:
        """Plain values by name."""
        return {**asdict(self), "said": self.said}


def estimate(values: Iterable[float]) -> Estimate:
    """The median of some runs, and where another one would fall, whatever their distribution.

    Of n independent runs sorted, another one lies between the k-th least and the k-th greatest with the probability
    (n + 1 - 2k)/(n + 1). The greatest k is taken that leaves LEVEL.

    Raises:
        InputError: without runs, or where one came to no number.
    """
    ordered = sorted(values)
    if not ordered or not all(map(isfinite, ordered)):
        raise InputError("values", "must be finite numbers, at least one", ordered)
    n = len(ordered)
    k = max(1, floor((n + 1) * (1 - LEVEL) / 2 * (1 + ROUNDING)))
    middle = (ordered[(n - 1) // 2] + ordered[n // 2]) / 2
    return Estimate(middle, ordered[k - 1], ordered[-k], max(0.0, (n + 1 - 2 * k) / (n + 1)), n)


def reproduce(paper: Paper, table: Table, seeds: int | None = None) -> list[Outcome]:
    """Recompute a table.

    Args:
        paper: the document.
        table: one of its tables.
        seeds: how many runs, of the seeds 1, 2, ..., a simulated cell is recomputed from; by default as the table
            says. What was run before is remembered.

    Raises:
        InputError: unless seeds is a whole number from 1 to 1,000.
    """
    runs = int(SEEDS.check("seeds", table.seeds or 1 if seeds is None else seeds))
    return [_outcome(cell, runs) for cell in cells(paper, table)]


def prepare(paper: Paper, table: Table, seed: int) -> None:
    """Run what the simulated cells of a table need with one seed, in every variant; `reproduce` finds it remembered."""
    for cell in cells(paper, table):
        if cell.recipe in SIMULATED and seed <= cell.told("seeds", seed):
            for change in ({}, *(variant["change"] for variant in table.variants)):
                SIMULATED[cell.recipe](cell, change, seed)


def _outcome(cell: Cell, runs: int) -> Outcome:
    printed = float(number(cell.printed))
    found = None if cell.recipe in DERIVED else _simulate(cell, runs, {})
    value = DERIVED[cell.recipe](cell) if found is None else found.median
    verdict, reason = _judge(cell, value, found, runs)
    erratum = _erratum(cell) if verdict == ERRATUM else None
    return Outcome(
        row=cell.row.name,
        column=cell.column.name,
        printed=cell.printed,
        value=value,
        estimate=found,
        difference=(value - printed) / abs(printed) if printed else None,
        verdict=verdict,
        erratum=None if erratum is None else erratum.number,
        reason=reason,
    )


def _judge(cell: Cell, value: float, found: Estimate | None, runs: int) -> tuple[str, str]:
    """The verdict on a cell, and the reason for it."""
    if found is None and agrees(value, cell.printed):
        return EXACT, f"Repeats table {cell.option('table')}." if cell.recipe == "copy" else ""
    erratum = _erratum(cell)
    if erratum is not None:
        return ERRATUM, f"{erratum.title}."
    if found is not None and cell.table.comparable and _holds(found, cell.printed):
        said = f"Interval of {found.runs} runs, into which another one falls with {100 * found.coverage:.0f} %."
        return WITHIN, f"{said} {cell.table.caveat}".strip()
    return OPEN, " ".join([cell.table.left_out, *_elsewhere(cell, runs)]).strip()


def _erratum(cell: Cell) -> Erratum | None:
    return cell.paper.erratum(cell.table.name, cell.row.name, cell.column.name)


def agrees(value: float, printed: str) -> bool:
    """Whether a number is the printed one to half a unit of its last digit."""
    half = float(half_unit(printed))
    return abs(value - float(number(printed))) <= half + ROUNDING * abs(value)


def _holds(found: Estimate, printed: str) -> bool:
    value, half = float(number(printed)), float(half_unit(printed))
    return found.low - half <= value <= found.high + half


def _simulate(cell: Cell, runs: int, change: dict[str, Any]) -> Estimate:
    recipe = SIMULATED[cell.recipe]
    runs = min(runs, cell.told("seeds", runs))
    return estimate(recipe(cell, change, seed) for seed in range(1, runs + 1))


def _elsewhere(cell: Cell, runs: int) -> list[str]:
    """Which of the settings that the document leaves open would explain a cell."""
    if cell.recipe not in SIMULATED:
        return []
    found = [(variant["title"], _simulate(cell, runs, variant["change"])) for variant in cell.table.variants]
    return [
        f"With {title}: {other.low:,.5g} to {other.high:,.5g}, which holds the printed number."
        for title, other in found
        if _holds(other, cell.printed)
    ]


def count(outcomes: Iterable[Outcome]) -> dict[str, int]:
    """How many cells have each verdict, in the order of VERDICTS."""
    found = Counter(outcome.verdict for outcome in outcomes)
    return {verdict: found[verdict] for verdict in VERDICTS}
