"""The printed tables: their structure, and their cells against computations of our own, without the recipes.

A cell that an erratum explains must differ from what is computed here by more than half a unit of its last digit; every
other derived cell must agree to half a unit.
"""

from collections import Counter
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise, product
from math import hypot

import pytest
from scipy.optimize import brentq

from tests.core.oracles import garg_filter
from tracker_core import InputError
from tracker_core.papers import NAMES, papers
from tracker_core.papers.printed import EMPTY, half_unit, number
from tracker_core.papers.recipes import DERIVED, SIMULATED

TABLES = [
    pytest.param(paper, table, id=f"{paper.name}-{table.name}") for paper in papers().values() for table in paper.tables
]
ERRATA = [
    pytest.param(paper, erratum, id=f"{paper.name}-{erratum.number}")
    for paper in papers().values()
    for erratum in paper.errata
]


def printed(paper, table, column):
    """The numbers of a column by row, exactly."""
    found = papers()[paper].table(table)
    cells = {row.name: found.printed(row.name, column) for row in found.rows}
    return {name: number(cell) for name, cell in cells.items() if cell != EMPTY}


# Numbers as printed ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value", "half"),
    [
        ("26,326", "26326", "0.5"),
        ("1,733.27", "1733.27", "0.005"),
        ("-2.3659", "-2.3659", "0.00005"),
        ("250", "250", "0.5"),
        ("4.2008e-003", "0.0042008", "5e-8"),
        ("4.4409 × 10⁻¹⁶", "4.4409e-16", "5e-21"),
        ("7.6163-04", "7.6163e-4", "5e-9"),
        ("10⁻³", "0.001", "0.0005"),
        ("10227", "10227", "0.5"),
    ],
)
def test_a_number_is_what_is_printed(text, value, half):
    assert number(text) == Decimal(value)
    assert half_unit(text) == Decimal(half)


def test_what_is_no_number_is_refused():
    with pytest.raises(InputError, match="^printed must be a number"):
        number(EMPTY)


# Structure ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("paper", "table"), TABLES)
def test_table_is_whole(paper, table):
    assert [other.name for other in paper.tables].count(table.name) == 1
    for parts in (table.columns, table.rows):
        assert max(Counter(part.name for part in parts).values()) == 1
    for row in table.rows:
        assert len(row.cells) == len(table.columns)
        for cell in row.cells:
            if cell != EMPTY:
                assert half_unit(cell) > 0


@pytest.mark.parametrize(("paper", "table"), TABLES)
def test_table_is_described_in_sentences(paper, table):
    assert table.title
    assert not table.title.endswith(".")
    assert table.note.endswith(".")
    assert not table.left_out or table.left_out.endswith(".")
    assert all(part.title for part in (*table.columns, *table.rows))


@pytest.mark.parametrize(("paper", "table"), TABLES)
def test_every_cell_has_a_recipe_and_its_run(paper, table):
    runs = {run.name for run in paper.runs}
    simulated = False
    for row in table.rows:
        assert row.run in {"", *runs}
        for column, cell in zip(table.columns, row.cells, strict=True):
            if cell == EMPTY:
                continue
            recipe = row.recipe or column.recipe
            assert recipe in DERIVED or recipe in SIMULATED
            simulated = simulated or recipe in SIMULATED
            if recipe in SIMULATED or recipe in ("target", "state", "next-prediction"):
                options = {**column.options, **row.options}
                assert (row.run or options["run"].format(row=row.name)) in runs
    assert (table.seeds > 0) == simulated
    assert bool(table.left_out) == simulated
    for variant in table.variants:
        assert set(variant) == {"name", "title", "change"}
        replace(paper.runs[0].experiment, **variant["change"])


@pytest.mark.parametrize(("paper", "erratum"), ERRATA)
def test_erratum_is_whole(paper, erratum):
    assert [other.proof for other in paper.errata].count(erratum.proof) == 1
    assert not erratum.title.endswith(".")
    for text in (erratum.claim, erratum.evidence, erratum.consequence):
        assert text.endswith(".")
    assert erratum.where
    assert set(erratum.runs) <= {run.name for run in paper.runs}
    assert len(set(erratum.cells)) == len(erratum.cells)
    for table, row, column in erratum.cells:
        assert paper.table(table).printed(row, column) != EMPTY
        assert paper.erratum(table, row, column) is erratum


def test_papers_have_their_tables_and_errata():
    counts = {name: (len(paper.tables), len(paper.errata)) for name, paper in papers().items()}
    assert counts == {
        "jeong2017": (7, 10),
        "njonjo2016": (2, 1),
        "yu2017": (4, 9),
        "alwagih": (6, 6),
        "garg2021": (3, 4),
    }


# Cells computed here -----------------------------------------------------------------------------------------------


def jeong():
    """Eq. 7-8, 9-13, 14-16 and 25-28 at the stated parameters, and the differences of table 6."""
    alpha = Fraction(86, 100)
    beta = alpha**2 / (2 - alpha)
    gamma = 2 * (2 * beta - alpha * (alpha + beta)) / alpha
    yield "1", "benedict-bordner", {"alpha": alpha, "beta": beta, "gamma": gamma}
    index = Decimal("0.2846")
    r = (4 + index - (8 * index + index**2).sqrt()) / 4
    alpha = 1 - r**2
    beta = 2 * (2 - alpha) - 4 * (1 - alpha).sqrt()
    yield "2", "gray-murray", {"alpha": alpha, "beta": beta, "gamma": beta**2 / (2 * alpha)}
    yield "3", "fading-memory", dict(zip(("alpha", "beta", "gamma"), order_3(Fraction(62, 100)), strict=True))
    alpha, beta, gamma, eta = order_4(Fraction(74, 100))
    yield "4", "jerk", {"alpha": alpha, "beta": beta, "gamma": gamma, "eta": eta / 6}
    improvement, percent = {}, {}
    for name in ("tracking", "estimation"):
        totals = printed("jeong2017", "6", name)
        improvement[name] = totals["order-3"] - totals["order-4"]
        percent[name] = 100 * improvement[name] / totals["order-3"]
    yield "6", "improvement", improvement
    yield "6", "improvement-percent", {"tracking": percent["tracking"]}
    deviation = Decimal("0.001").sqrt()
    yield "text", "process-deviation", {"value": deviation}
    yield "text", "tracking-index", {"value": 9 * deviation}
    yield "text", "damping", {"value": r}


def order_3(xi):
    return 1 - xi**3, (1 - xi) ** 2 * (1 + xi) * 3 / 2, (1 - xi) ** 3


def order_4(xi):
    """The fading-memory gains for gamma/T^2 and eta/T^3."""
    return 1 - xi**4, (1 - xi) ** 2 * (11 + 14 * xi + 11 * xi**2) / 6, 2 * (1 - xi) ** 3 * (1 + xi), (1 - xi) ** 4


def njonjo():
    """Where the ship of eq. 29-30 is at first."""
    a, b, w = ship_parameters()
    speed = hypot((12 + 5.6 + 27) * a * w + 10, 44 * b * w)
    yield "1", "target", {"x": 18 * a, "y": 20 * b, "speed": speed, "interval": 3, "samples": 1000}


def ship_parameters():
    """a, b and w of Jeong's eq. 29-30, from the first position and speed."""
    a, b = 573 / 18, 1038.4 / 20
    return a, b, brentq(lambda w: hypot(44.6 * a * w + 10, 44 * b * w) - 50.4, 0.001, 1, xtol=1e-15)


def yu():
    """Improvements and ratios of the errors of tables 1 and 2."""
    for source, copied in (("1", "3"), ("2", "4")):
        gamma, delta = (printed("yu2017", source, name) for name in ("gamma", "delta"))
        for row in gamma:
            yield source, row, {"improvement": 100 * (gamma[row] / delta[row] - 1)}
        yield copied, "0.2", {"gamma": gamma["0.2"], "delta": delta["0.2"]}
        for before, row in pairwise(gamma):
            ratios = {"gamma-ratio": gamma[before] / gamma[row], "delta-ratio": delta[before] / delta[row]}
            yield copied, row, {"gamma": gamma[row], "delta": delta[row], **ratios}


def differences(source, base, of, axis):
    """Of the RMSE of two of Al-Wagih's methods, experiment by experiment."""
    first, second = (printed("alwagih", source, name) for name in (base, of))
    return [first[f"{k}-{axis}"] - second[f"{k}-{axis}"] for k in range(1, 6)]


def alwagih():
    """Mean differences, and eq. 27."""
    for source, means, changes in (("1", "3", "5"), ("2", "4", "6")):
        for base, axis in product(("m1", "m2"), "xy"):
            found = {of: sum(differences(source, base, of, axis)) / 5 for of in ("m3", "m4", "m5")}
            yield means, f"{base}-{axis}", found
        base = printed("alwagih", source, "m1")
        for row in base:
            others = {of: printed("alwagih", source, of)[row] for of in ("m3", "m4", "m5")}
            yield changes, row, {of: 100 * (base[row] - other) / base[row] for of, other in others.items()}


RANGES = {
    "constant-velocity": "30171 30353 30756 30799 31018 31278 31276 31379 31748 32175",
    "constant-velocity-earlier": "30110 30265 30740 30750 31135 31015 31180 31610 31960 31865",
    "accelerating-earlier": "30160 30365 30890 31050 31785 32215 33130 34510 36010 37265",
}


def garg():
    """The listings in decimal numbers; the columns that a table prints."""
    straight, turning = ((40, "0.2", "0.1", "0"), (50, "0.5", "0.4", "0.1"))
    for name, setting, columns in (
        ("constant-velocity", straight, "x v"),
        ("constant-velocity-earlier", straight, "x next"),
        ("accelerating-earlier", turning, "x v a"),
    ):
        rows = garg_filter(map(Decimal, RANGES[name].split()), *map(Decimal, setting), Decimal)
        for k, row in enumerate(rows, 1):
            yield name, str(k), {column: row[column] for column in columns.split()}


COMPUTED = {
    (paper, table, row): values
    for paper, computed in (
        ("jeong2017", jeong), ("njonjo2016", njonjo), ("yu2017", yu), ("alwagih", alwagih), ("garg2021", garg)
    )
    for table, row, values in computed()
}  # fmt: skip


@pytest.mark.parametrize(("paper", "table", "row"), [pytest.param(*key, id="-".join(key)) for key in COMPUTED])
def test_row(paper, table, row):
    for column, value in COMPUTED[paper, table, row].items():
        cell = papers()[paper].table(table).printed(row, column)
        exact = Fraction(value)
        # Only what is computed in double precision may be off by its rounding.
        slack = Fraction(1e-12) * abs(exact) if isinstance(value, float) else 0
        differs = abs(exact - Fraction(number(cell))) > Fraction(half_unit(cell)) + slack
        assert differs == (papers()[paper].erratum(table, row, column) is not None), (column, cell, float(value))


def test_every_derived_cell_is_computed_here():
    derived = [
        (paper.name, table.name, row.name, column.name)
        for paper in papers().values()
        for table in paper.tables
        for row in table.rows
        for column, cell in zip(table.columns, row.cells, strict=True)
        if cell != EMPTY and (row.recipe or column.recipe) in DERIVED
    ]
    here = [(*key, column) for key, values in COMPUTED.items() for column in values]
    assert sorted(derived) == sorted(here)


# Equations ---------------------------------------------------------------------------------------------------------

COUNTED = {"jeong2017": 30, "njonjo2016": 12, "yu2017": 26, "alwagih": 27}
"""How many equations a document counts."""


@pytest.mark.parametrize(("name", "last"), COUNTED.items(), ids=list(COUNTED))
def test_every_equation_is_there_once(name, last):
    numbers: list[int] = []
    for equation in papers()[name].equations:
        first, _, final = equation.name.partition("–")
        numbers += range(int(first), int(final or first) + 1)
    assert numbers == list(range(1, last + 1))


@pytest.mark.parametrize("name", NAMES)
def test_equations_are_described_and_their_errata_exist(name):
    paper = papers()[name]
    for equation in paper.equations:
        assert equation.formula
        assert equation.what.endswith(".")
        assert equation.here.endswith(".")
        assert set(equation.errata) <= {erratum.number for erratum in paper.errata}
