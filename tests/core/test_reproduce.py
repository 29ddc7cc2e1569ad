"""Printed beside recomputed: the verdicts, one id a printed row, and what they rest on."""

from __future__ import annotations

import json
from dataclasses import replace
from decimal import Decimal
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import InputError, run_experiment
from tracker_core.__main__ import main
from tracker_core.papers import ERRATUM, EXACT, NAMES, OPEN, VERDICTS, WITHIN, count, papers, prepare, reproduce
from tracker_core.papers.printed import EMPTY, half_unit, number
from tracker_core.papers.recipes import DERIVED, SIMULATED, cells
from tracker_core.papers.reproduce import LEVEL, agrees, estimate

ROWS = [(p.name, t.name, r.name) for p in papers().values() for t in p.tables for r in t.rows]
EXACT_OR_ERRATUM = [
    *(("jeong2017", name) for name in "1234"),
    *(("alwagih", name) for name in "3456"),
    *(("garg2021", table.name) for table in papers()["garg2021"].tables),
]
DERIVED_COLUMNS = {
    ("yu2017", "1"): {"improvement"},
    ("yu2017", "2"): {"improvement"},
    ("yu2017", "3"): {"gamma-ratio", "delta-ratio"},
    ("yu2017", "4"): {"gamma-ratio", "delta-ratio"},
}


@cache
def outcomes(paper, table):
    """Every outcome of a table, by row and column."""
    found = papers()[paper]
    return {(each.row, each.column): each for each in reproduce(found, found.table(table))}


@pytest.mark.parametrize(("paper", "table", "row"), ROWS, ids=["-".join(ids) for ids in ROWS])
def test_every_cell_of_a_row_has_the_verdict_that_it_deserves(paper, table, row):
    document = papers()[paper]
    found, printed_row = document.table(table), document.table(table).row(row)
    for column, printed in zip(found.columns, printed_row.cells, strict=True):
        if printed == EMPTY:
            assert (row, column.name) not in outcomes(paper, table)
            continue
        outcome = outcomes(paper, table)[row, column.name]
        erratum = document.erratum(table, row, column.name)
        # An independent reading of "half a unit of the last printed digit".
        digits = Decimal(str(outcome.value)) - number(printed)
        close = abs(digits) <= half_unit(printed) + Decimal("1e-12") * abs(number(printed))
        assert outcome.printed == printed
        if outcome.verdict == EXACT:
            assert close
            assert outcome.estimate is None
            assert erratum is None, f"erratum {erratum.number} explains a cell that is right"
        elif outcome.verdict == ERRATUM:
            assert outcome.erratum == erratum.number
            assert not (close and outcome.estimate is None)
        elif outcome.verdict == WITHIN:
            runs = outcome.estimate
            assert (
                runs.low - float(half_unit(printed)) <= float(number(printed)) <= runs.high + float(half_unit(printed))
            )
            assert found.comparable
        else:
            assert outcome.verdict == OPEN
            assert outcome.estimate is not None, "a number that follows from others is exact or wrong"
            assert found.left_out, "what the document leaves out is said"


@pytest.mark.parametrize(("paper", "table"), EXACT_OR_ERRATUM, ids=["-".join(ids) for ids in EXACT_OR_ERRATUM])
def test_what_follows_from_formulas_or_other_cells_is_exact_or_an_erratum(paper, table):
    assert {outcome.verdict for outcome in outcomes(paper, table).values()} <= {EXACT, ERRATUM}


@pytest.mark.parametrize(("paper", "table"), DERIVED_COLUMNS, ids=["-".join(ids) for ids in DERIVED_COLUMNS])
def test_derived_columns_of_yu_and_wu_are_exact_or_errata(paper, table):
    found = {o.verdict for (_, column), o in outcomes(paper, table).items() if column in DERIVED_COLUMNS[paper, table]}
    assert found <= {EXACT, ERRATUM}


def test_differences_of_jeongs_table_6_are_exact_or_errata():
    found = {row: outcome.verdict for (row, _), outcome in outcomes("jeong2017", "6").items()}
    assert {found[row] for row in ("improvement", "improvement-percent")} <= {EXACT, ERRATUM}


def test_seven_of_jeongs_eight_totals_lie_within_six_percent():
    totals = {("5", row) for row in ("benedict-bordner", "gray-murray", "fading-memory")} | {("6", "order-4")}
    found = {
        (table, row, column): outcomes("jeong2017", table)[row, column]
        for table, row in totals
        for column in ("tracking", "estimation")
    }
    far = {place: each for place, each in found.items() if abs(each.difference) > 0.06}
    assert list(far) == [("5", "benedict-bordner", "tracking")]
    assert [each.verdict for each in far.values()] == [ERRATUM]


@pytest.mark.parametrize(
    ("row", "value", "margin"), [("alpha", 0.84, 0.02), ("xi-3", 0.62, 0.02), ("xi-4", 0.74, 0.02)]
)
def test_searches_with_the_two_point_start_find_the_optima(row, value, margin):
    assert outcomes("jeong2017", "text")[row, "value"].value == pytest.approx(value, abs=margin + 1e-12)


def test_the_search_over_decades_finds_the_printed_variance():
    assert outcomes("jeong2017", "text")["process-variance", "value"].value == 1e-3


def test_no_cell_of_table_6_is_left_open():
    assert OPEN not in {outcome.verdict for outcome in outcomes("jeong2017", "6").values()}


def test_the_numbers_of_yu_and_wu_are_those_of_the_reconstruction():
    table = papers()["yu2017"].table("1")
    outcome = outcomes("yu2017", "1")["0.2", "gamma"]
    (experiment,) = [cell.experiment() for cell in cells(papers()["yu2017"], table) if cell.printed == outcome.printed]
    runs = [run_experiment(replace(experiment, seed=seed)).metrics.estimation_l2 for seed in range(1, 21)]
    assert outcome.value == pytest.approx(np.median(runs), rel=1e-12)
    assert (outcome.estimate.low, outcome.estimate.high) == (min(runs), max(runs))


# The documents' texts ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_every_recipe_is_one(name):
    paper = papers()[name]
    for table in paper.tables:
        for cell in cells(paper, table):
            assert cell.recipe in DERIVED | SIMULATED, (table.name, cell.row.name, cell.column.name)
            assert (cell.recipe in SIMULATED) <= (table.seeds > 0)


@pytest.mark.parametrize(("paper", "table"), [("yu2017", "2"), ("alwagih", "1")])
def test_what_is_prepared_is_remembered(paper, table, monkeypatch):
    document = papers()[paper]
    for seed in range(1, 4):
        prepare(document, document.table(table), seed)
    monkeypatch.setattr("tracker_core.papers.recipes.run_experiment", None)
    assert reproduce(document, document.table(table), 3)


def test_counts_add_up():
    for paper in papers().values():
        found = [each for table in paper.tables for each in reproduce(paper, table)]
        assert list(count(found)) == list(VERDICTS)
        assert sum(count(found).values()) == len(found) > 0


# Numbers as printed ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("printed", "value", "half"),
    [
        ("26,326", "26326", "0.5"),
        ("4.4409 × 10⁻¹⁶", "4.4409e-16", "5e-21"),
        ("7.6163-04", "7.6163e-4", "5e-9"),
        ("4.2008e-003", "4.2008e-3", "5e-8"),
        ("-2.3659", "-2.3659", "0.00005"),
        ("9", "9", "0.5"),
        ("10⁻³", "1e-3", "5e-4"),
    ],
)
def test_printed_numbers_are_read(printed, value, half):
    assert number(printed) == Decimal(value)
    assert half_unit(printed) == Decimal(half)


@given(st.integers(-(10**9), 10**9), st.integers(0, 6))
def test_a_number_agrees_with_its_own_rounding_and_not_with_the_next(digits, decimals):
    printed = f"{Decimal(digits).scaleb(-decimals):f}"
    unit = float(2 * half_unit(printed))
    value = float(number(printed))
    assert agrees(value, printed)
    assert agrees(value + 0.499 * unit, printed)
    assert not agrees(value + 0.51 * unit, printed)
    assert not agrees(value - 0.51 * unit, printed)


@pytest.mark.parametrize("printed", ["", "–", "a", "1.2.3", "1e", "1 2"])
def test_what_is_no_number_is_refused(printed):
    with pytest.raises(InputError, match="printed must be a number"):
        number(printed)


# The interval ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 5, 18, 19, 20, 38, 39, 40, 59, 99, 100, 199])
def test_interval_is_the_narrowest_of_its_level(n):
    found = estimate(range(n))
    k = int(found.low) + 1
    assert (found.high, found.median, found.runs) == (n - k, (n - 1) / 2, n)
    assert found.coverage == pytest.approx(max(0, (n + 1 - 2 * k) / (n + 1)))
    assert found.coverage >= LEVEL - 1e-12 or k == 1
    assert (n + 1 - 2 * (k + 1)) / (n + 1) < LEVEL - 1e-12


def test_interval_holds_another_run_as_often_as_it_says():
    random = np.random.default_rng(5)
    draws = random.exponential(size=(4000, 21)) ** 3
    held = [found.low <= row[-1] <= found.high for row in draws for found in [estimate(row[:-1].tolist())]]
    coverage = estimate(range(20)).coverage
    assert np.mean(held) == pytest.approx(coverage, abs=4 * np.sqrt(coverage * (1 - coverage) / len(held)))


@pytest.mark.parametrize("values", [[], [1.0, float("nan")], [float("inf")]])
def test_no_interval_without_numbers(values):
    with pytest.raises(InputError, match="values must be finite numbers"):
        estimate(values)


# The command -------------------------------------------------------------------------------------------------------


def test_command_prints_every_cell_with_its_verdict(capsys):
    assert main(["reproduce", "yu2017", "--table", "1", "--seeds", "3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    (line,) = [line for line in lines if line.startswith("0.025") and "418.2" in line]
    assert "481.16" in line
    assert line.endswith("erratum 5")
    assert lines[-1].startswith("yu2017    15 cells")


def test_command_speaks_json(capsys):
    assert main(["reproduce", "alwagih", "--table", "3", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    rows = found["papers"]["alwagih"]["tables"]["3"]
    assert len(rows) == 12
    assert sum(found["counts"].values()) == 12
    (flipped,) = [row for row in rows if (row["row"], row["column"]) == ("m2-y", "m3")]
    assert flipped["value"] == pytest.approx(-3.4251, abs=5e-5)
    assert flipped["said"] == "erratum 3"


def test_command_counts_every_document(capsys):
    assert main(["reproduce", "--seeds", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [*NAMES, "all"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["reproduce", "nobody"], "paper must be one of jeong2017"),
        (["reproduce", "yu2017", "--table", "9"], "table must be one of 1, 2, 3, 4"),
        (["reproduce", "--table", "1"], "table must be left out where no document is named"),
        (["reproduce", "yu2017", "--seeds", "0"], "seeds must be a whole number >= 1 and <= 1,000"),
        (["reproduce", "yu2017", "--seeds", "1e9"], "seeds must be a whole number"),
    ],
)
def test_command_refuses(arguments, message, capsys):
    assert main(arguments) == 2
    assert message in capsys.readouterr().err
