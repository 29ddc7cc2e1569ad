"""The printed tables: their structure, and their cells against computations of our own, without the recipes.

A cell that an erratum explains must differ from what is computed here by more than half a unit of its last digit; every
other derived cell must agree to half a unit.
"""

from collections import Counter
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from math import factorial, hypot, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

from tracker_core import InputError, run_experiment
from tracker_core.papers import papers
from tracker_core.papers.document import EMPTY, half_unit, number
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
        "alwagih": (6, 5),
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
    "accelerating": "30221 30453 30906 30999 31368 31978 32526 33379 34698 36275",
}


def garg_filter(ranges, speed, alpha, beta, gamma, number_type=Decimal):
    """The second listing, row by row: smoothed state, predicted range, and range predicted next."""
    t = number_type(5)
    x, v, a = number_type(30000), speed, number_type(0)
    rows = []
    for z in ranges:
        before = x + v * t + a * t * t / 2
        v = v + a * t
        x = before + alpha * (z - before)
        v = v + beta * (z - before) / t
        a = a + 2 * gamma * (z - before) / t / t
        rows.append({"x": x, "v": v, "a": a, "before": before, "next": x + v * t + a * t * t / 2})
    return rows


def garg():
    """The listings in decimal numbers; the columns that a table prints."""
    straight, turning = ((40, "0.2", "0.1", "0"), (50, "0.5", "0.4", "0.1"))
    for name, setting, columns in (
        ("constant-velocity", straight, "x v"),
        ("constant-velocity-earlier", straight, "x next"),
        ("accelerating-earlier", turning, "x v a"),
    ):
        rows = garg_filter(map(Decimal, RANGES[name].split()), *map(Decimal, setting))
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


# Jeong's totals, by a loop over samples ----------------------------------------------------------------------------

RUNS = 100


@cache
def ship():
    """Truth, shape (1000, 1, 2), and measurements of RUNS runs with 10 m of noise, shape (1000, RUNS, 2)."""
    a, b, w = ship_parameters()
    t = 3.0 * np.arange(1000)
    s, c = (lambda k: np.sin(k * w * t)), (lambda k: np.cos(k * w * t))
    x = a * (10 * s(1.2) + 7 * c(0.99) + 8 * s(0.7) + 6 * c(2) + 9 * s(3) + 5 * c(3)) + 10 * t
    y = b * (20 * c(0.3) + 22 * s(2))
    truth = np.stack((x, y), axis=1)[:, None]
    return truth, truth + np.random.default_rng(5).normal(0, 10, (1000, RUNS, 2))


@cache
def totals(gains, two_point):
    """Tracking, estimation and innovation totals of RUNS runs; the gains are for 1, 1/T, 1/T^2, 1/T^3."""
    truth, seen = ship()
    order = len(gains)
    transition = np.array(
        [[3.0 ** (j - i) / factorial(j - i) if j >= i else 0 for j in range(order)] for i in range(order)]
    )
    gain = np.array(gains, dtype=float) / 3.0 ** np.arange(order)
    begin = 2 if two_point else 1
    state = np.zeros((RUNS, 2, order))
    state[..., 0] = seen[begin - 1]
    if two_point:
        state[..., 1] = (seen[1] - seen[0]) / 3
    found = np.zeros((3, RUNS))
    found[1] = np.hypot(*np.moveaxis(seen[:begin] - truth[:begin], 2, 0)).sum(axis=0)
    for k in range(begin, 1000):
        state = state @ transition.T
        innovation = seen[k] - state[..., 0]
        tracking = state[..., 0] - truth[k]
        state = state + innovation[..., None] * gain
        for total, error in zip(found, (tracking, state[..., 0] - truth[k], innovation), strict=True):
            np.add(total, np.hypot(*error.T), out=total)
    return dict(zip(("tracking", "estimation", "innovation"), found, strict=True))


def as_run(gains):
    """With 2 gamma/T^2."""
    return tuple(float(gain) * (2 if k == 2 else 1) for k, gain in enumerate(gains))


INDEX = 0.2846
DAMPING = (4 + INDEX - sqrt(8 * INDEX + INDEX**2)) / 4
KALATA = (1 - DAMPING**2, 2 * (1 - DAMPING) ** 2)
GAINS = {
    "benedict-bordner": (0.86, 0.86**2 / 1.14),
    "gray-murray": as_run((*KALATA, KALATA[1] ** 2 / (2 * KALATA[0]))),
    "fading-memory": as_run(order_3(0.64)),
    "order-3": as_run(order_3(0.64)),
    "order-4": as_run(order_4(0.74)),
}

TOTALS = [
    ("jeong2017", "5", "benedict-bordner"),
    ("jeong2017", "5", "gray-murray"),
    ("jeong2017", "5", "fading-memory"),
    ("jeong2017", "6", "order-3"),
    ("jeong2017", "6", "order-4"),
    ("njonjo2016", "optima", "order-3"),
    ("njonjo2016", "optima", "order-4"),
]


def between(values, total):
    """Whether a total lies among those of runs with either start."""
    return min(v.min() for v in values) <= total <= max(v.max() for v in values)


@pytest.mark.parametrize("column", ["tracking", "estimation"])
@pytest.mark.parametrize(("paper", "table", "row"), [pytest.param(*key, id="-".join(key)) for key in TOTALS])
def test_totals(paper, table, row, column):
    """Printed totals are those of a run with one of two starts, but for the one that is an innovation."""
    found = [totals(GAINS[row], two_point)[column] for two_point in (True, False)]
    total = float(printed(paper, table, column)[row])
    assert between(found, total) == (papers()[paper].erratum(table, row, column) is None)


# What the errata say -----------------------------------------------------------------------------------------------


def radius(gains):
    """The largest modulus among the poles of gains for 1, 1/T, 1/T^2, 1/T^3."""
    return np.abs(filter_poles(gains)).max()


def filter_poles(gains):
    order = len(gains)
    transition = [[1 / factorial(j - i) if j >= i else 0 for j in range(order)] for i in range(order)]
    return np.linalg.eigvals((np.eye(order) - np.outer(gains, np.eye(order)[0])) @ np.array(transition))


def test_jeong_zero_gamma_is_double_precision():
    alpha = 0.86
    beta = alpha**2 / (2 - alpha)
    assert 2 * (2 * beta / alpha - alpha - beta) == -(2.0**-51)
    assert f"{2.0**-51:.4e}" == "4.4409e-16"


def test_jeong_precedence():
    alpha, beta = Decimal("0.5277"), Decimal("0.1956")
    assert abs(beta**2 / 2 * alpha - number("0.0101")) <= half_unit("0.0101")
    misprinted = totals((*KALATA, 2 * 0.0101), True)["tracking"]
    assert np.median(misprinted) == pytest.approx(42_000, abs=150)
    for two_point, median in ((True, 20_000), (False, 21_700)):
        assert np.median(totals(GAINS["gray-murray"], two_point)["tracking"]) == pytest.approx(median, abs=150)


def test_jeong_xi():
    for column, gain in zip(("alpha", "beta", "gamma"), order_3(Fraction(64, 100)), strict=True):
        cell = papers()["jeong2017"].table("3").printed("fading-memory", column)
        assert abs(Fraction(number(cell)) - gain) <= Fraction(half_unit(cell))


def test_jeong_doubled_gain():
    assert np.abs(filter_poles(order_3(0.64)) - 0.64).max() < 1e-4
    doubled = filter_poles(GAINS["fading-memory"])
    assert sorted(np.abs(doubled).round(3)) == [0.404, 0.806, 0.806]
    assert max(doubled, key=np.imag) == pytest.approx(0.747 + 0.304j, abs=6e-4)
    for gains, median in ((order_3(0.64), 24_110), (GAINS["fading-memory"], 18_490)):
        assert np.median(totals(gains, True)["tracking"]) == pytest.approx(median, abs=150)


HALVED = [1, 1, 1 / 2, 1 / 36]
"""Eq. 23-24 as printed, with eta of eq. 28, against gains for gamma/T^2 and eta/T^3."""


def test_jeong_conventions():
    four = np.array(order_4(0.74))
    assert np.abs(filter_poles(four) - 0.74).max() < 1e-3
    for scale, wanted, total in (
        (HALVED, [0.551 - 0.198j, 0.551 + 0.198j, 0.878, 0.996], 28_700),
        ([1, 1, 2, 1], [0.419, 0.775 - 0.380j, 0.775 + 0.380j, 0.960], 17_700),
    ):
        assert np.sort_complex(filter_poles(four * scale)) == pytest.approx(np.array(wanted), abs=6e-4)
        assert np.median(totals(tuple(four * scale), True)["tracking"]) == pytest.approx(total, abs=150)


@pytest.mark.parametrize(("scale", "best"), [(HALVED, [0.63, 0.64]), ([1, 1, 2, 1], [0.73, 0.74])])
def test_jeong_best_xi_of_a_convention(scale, best):
    grid = [0.6 + 0.01 * k for k in range(18)]
    medians = [np.median(totals(tuple(np.array(order_4(xi)) * scale), True)["tracking"]) for xi in grid]
    assert round(grid[int(np.argmin(medians))], 2) in best


def test_jeong_differences_are_no_rounding():
    errors = [abs(number(cell) - value) for cell, value in (("1,733.27", 1763), ("419.49", 426))]
    assert errors == [Decimal("29.73"), Decimal("6.51")]
    assert min(errors) > 1


def test_jeong_gray_murray_is_not_the_solution():
    """The Riccati equation of its model, iterated: Q from accelerations that jump by Lambda."""
    f, g = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]]), INDEX * np.array([0.5, 1, 1])

    def predicted(gains):
        """Variance of the predicted position; None takes the best gain at every step."""
        p = np.eye(3)
        for _ in range(2000):
            p = f @ p @ f.T + np.outer(g, g)
            variance, gain = p[0, 0], p[:, 0] / (p[0, 0] + 1) if gains is None else np.array(gains)
            left = np.eye(3) - np.outer(gain, [1, 0, 0])
            p = left @ p @ left.T + np.outer(gain, gain)
        return gain, variance

    best, least = predicted(None)
    assert best == pytest.approx([0.7316, 0.4645, 0.1474], abs=5e-5)
    assert least == pytest.approx(2.73, abs=5e-3)
    paper = (*KALATA, KALATA[1] ** 2 / (2 * KALATA[0]))
    assert predicted(paper)[1] == pytest.approx(8.56, abs=5e-3)
    assert predicted(as_run(paper))[1] == pytest.approx(7.03, abs=5e-3)
    assert np.median(totals(tuple(best), True)["tracking"]) == pytest.approx(18_500, abs=150)


def test_jeong_first_total_is_the_innovation():
    first, second = (totals(GAINS["benedict-bordner"], two_point) for two_point in (True, False))
    assert np.median(first["tracking"]) == pytest.approx(23_300, abs=150)
    assert max(first["tracking"].max(), second["tracking"].max()) < 26_326 - 1_500
    assert np.median(first["innovation"]) == pytest.approx(26_440, abs=150)
    assert abs(26_326 - np.median(first["innovation"])) < first["innovation"].std()


def test_jeong_worst_in_estimation():
    estimation = printed("jeong2017", "5", "estimation")
    assert max(estimation, key=estimation.get) == "gray-murray"
    for two_point, medians in ((True, (11_500, 11_220)), (False, (12_250, 11_230))):
        for name, median in zip(("gray-murray", "benedict-bordner"), medians, strict=True):
            assert np.median(totals(GAINS[name], two_point)["estimation"]) == pytest.approx(median, abs=100)


def test_jeong_half_a_decade_further():
    index = 9 * 10**-1.25
    r = (4 + index - sqrt(8 * index + index**2)) / 4
    alpha, beta = 1 - r**2, 2 * (1 - r) ** 2
    further = np.median(totals(as_run((alpha, beta, beta**2 / (2 * alpha))), True)["tracking"])
    assert further == pytest.approx(17_700, abs=150)
    assert further < np.median(totals(GAINS["fading-memory"], True)["tracking"])


def yu_sets(order, factor):
    """Gains for 1, 1/T, 1/T^2, 1/T^3 at i/5 of the ranges of alpha, beta and gamma, i/7 of that of delta."""
    for i, j, k in product(range(1, 5), repeat=3):
        alpha = 2 * i / 5
        beta = factor * (4 - 2 * alpha) * j / 5
        gamma = 4 * alpha * beta / (2 - alpha) * k / 5
        for n in range(1, 7) if order == 4 else (0,):
            yield (alpha, beta, gamma / 2, 24 * (2 - alpha) * n / 7 / 6)[:order]


@pytest.mark.parametrize(
    ("order", "factor", "size", "stable"), [(3, 13 / 6, 64, 32), (3, 1, 64, 64), (4, 13 / 6, 384, 40), (4, 1, 384, 44)]
)
def test_yu_bounds(order, factor, size, stable):
    found = [radius(gains) for gains in yu_sets(order, factor)]
    assert len(found) == size
    assert sum(r < 1 for r in found) == stable
    if (order, factor) == (3, 13 / 6):
        assert max(found) == pytest.approx(4.52, abs=5e-3)
        assert radius((0.4, 5.547, 4.437 / 2)) == pytest.approx(4.52, abs=5e-3)


def test_yu_sets_have_sixteen_gammas():
    assert len({round(gains[2], 12) for gains in yu_sets(3, 13 / 6)}) == 16


def test_yu_equation_8_as_printed_is_never_stable():
    """a_s(k) = a_s(k-2) + ...: one pole is -1 for every set of gains."""
    for alpha, beta, gamma in yu_sets(3, 13 / 6):
        seen = np.array([1, 1, 0.5, 0])
        step = np.array([[1, 1, 0.5, 0], [0, 1, 1, 0], [0, 0, 0, 1], [0, 0, 1, 0.0]])
        recursion = step - np.outer([alpha, beta, gamma, 0], seen)
        assert np.abs(np.linalg.eigvals(recursion) + 1).min() < 1e-9


def test_yu_l2_is_no_rms_and_no_mean_square():
    ratios = []
    for name in ("gamma", "delta"):
        norm, greatest = (printed("yu2017", table, name) for table in "12")
        ratios += [float(greatest[row]) / sqrt(100 / float(row)) / float(norm[row]) for row in norm]
    assert len(ratios) == 10
    assert min(ratios) == pytest.approx(3.91, abs=5e-3)
    assert float(norm["0.0125"] / greatest["0.0125"] ** 2) == pytest.approx(5.72, abs=5e-3)


SEEDS = range(1, 21)


@cache
def yu_runs(run, **change):
    return [run_experiment(replace(papers()["yu2017"].run(run).experiment, seed=seed, **change)) for seed in SEEDS]


def test_yu_ties_decide():
    """Order 4 at T = 0.2 s, the jerk as objective, beta < 4 - 2 alpha."""
    first, last = (yu_runs("delta-0.2", objective="jerk", bound="triangle", ties=ties) for ties in ("first", "last"))
    assert all(result.track.stopped_at is not None for result in first)
    assert np.median([result.metrics.estimation_l2 for result in last]) == pytest.approx(2.0e-3, abs=5e-5)


@pytest.mark.parametrize(
    ("sigma", "gamma", "delta", "bank"), [(1, 0.95, 6.6, 0.73), (10, 0.89, 6.9, 0.59), (50, 0.89, 6.7, 0.49)]
)
def test_yu_oracles_against_the_raw_measurement(sigma, gamma, delta, bank):
    """Medians of the RMSE over that of the measurement."""
    runs = {name: yu_runs(f"{name}-sigma-{sigma}") for name in ("gamma", "delta")}
    causal = runs["delta"][0].experiment.counterpart()
    runs["bank"] = [run_experiment(replace(causal, seed=seed)) for seed in SEEDS]
    for name, wanted in (("gamma", gamma), ("delta", delta), ("bank", bank)):
        found = [result.metrics.estimation_rmse / result.metrics.observation_rmse for result in runs[name]]
        assert np.median(found) == pytest.approx(wanted, abs=0.005 if wanted < 1 else 0.05)


@pytest.mark.parametrize(("name", "wanted"), [("gamma", 1.7e-6), ("delta", 1.1e-5)])
def test_yu_with_a_tenth_of_a_millimetre_of_noise(name, wanted):
    """At T = 0.0125 s, without manoeuvre noise."""
    change = {"noise": "white", "noise_level": "std", "noise_std": (1e-4,), "manoeuvre": "none", "manoeuvre_std": None}
    experiment = replace(papers()["yu2017"].run(f"{name}-0.0125").experiment, **change)
    found = [run_experiment(replace(experiment, seed=seed)).metrics.estimation_l2 for seed in range(1, 6)]
    assert np.median(found) == pytest.approx(wanted, rel=0.04)


def test_yu_noise_five_to_one():
    positions = yu_runs("gamma-sigma-1")[0].truth.positions[:, 0]
    power = np.mean(positions**2)
    assert sqrt(power / 5) == pytest.approx(2_500, rel=0.02)
    assert sqrt(power / 10**0.5) == pytest.approx(3_200, rel=0.02)


def test_yu_larger_error_falls_by_less():
    gamma, delta = (printed("yu2017", "1", name)["0.025"] for name in ("gamma", "delta"))
    assert float(100 * (1 - delta / gamma)) == pytest.approx(82.8, abs=0.05)


@pytest.mark.parametrize(
    ("table", "column", "source", "of"),
    [
        ("3", "gamma-ratio", "1", "delta"),
        ("3", "delta-ratio", "2", "delta"),
        ("4", "gamma-ratio", "1", "gamma"),
        ("4", "delta-ratio", "2", "gamma"),
    ],
)
def test_yu_ratios_belong_elsewhere(table, column, source, of):
    ratios, errors = printed("yu2017", table, column), printed("yu2017", source, of)
    for before, row in pairwise(errors):
        cell = papers()["yu2017"].table(table).printed(row, column)
        assert abs(errors[before] / errors[row] - ratios[row]) <= half_unit(cell)


def test_yu_improvement_is_not_monotone():
    for table in "12":
        improvement = list(printed("yu2017", table, "improvement").values())
        assert improvement[1] < improvement[0]
        assert min(improvement[2:]) > max(improvement[:2])


ABSOLUTE = [
    ("3", "m1-x", "m3"), ("3", "m2-x", "m3"), ("3", "m2-x", "m4"), ("4", "m1-x", "m3"), ("4", "m2-x", "m3"),
    ("4", "m2-x", "m4"), ("4", "m2-y", "m3"),
]  # fmt: skip


@pytest.mark.parametrize(("table", "row", "column"), [pytest.param(*key, id="-".join(key)) for key in ABSOLUTE])
def test_alwagih_means_of_absolute_differences(table, row, column):
    found = differences({"3": "1", "4": "2"}[table], *row.split("-")[:1], column, row[-1])
    cell = papers()["alwagih"].table(table).printed(row, column)
    assert abs(sum(map(abs, found)) / 5 - number(cell)) <= half_unit(cell)


def test_alwagih_four_cells_in_y_fit_each_other():
    """One shift of M3's mean and one of M4's explain two cells each."""
    means = {(base, of): sum(differences("1", base, of, "y")) / 5 for base in ("m1", "m2") for of in ("m3", "m4")}
    cells = {(base, of): printed("alwagih", "3", of)[f"{base}-y"] for base, of in means}
    three = [means["m1", "m3"] - cells["m1", "m3"], cells["m2", "m3"] + means["m2", "m3"]]
    four = [means["m1", "m4"] - cells["m1", "m4"], means["m2", "m4"] - cells["m2", "m4"]]
    for shifts, wanted in ((three, Decimal("0.0871")), (four, Decimal("-0.1709"))):
        assert all(abs(shift - wanted) <= Decimal("0.0001") for shift in shifts)


def test_alwagih_percentages_that_are_cut_off():
    wrong = [cell for cell in papers()["alwagih"].errata[2].cells if cell[0] in "56"]
    near, cut = [], []
    for table, row, column in wrong:
        exact = Decimal(COMPUTED["alwagih", table, row][column])
        cell = number(papers()["alwagih"].table(table).printed(row, column))
        if abs(exact - cell) < Decimal("0.00025"):
            near.append(cell)
            cut += [cell] * (exact.quantize(Decimal("0.0001"), rounding="ROUND_DOWN") == cell)
    assert (len(wrong), len(near), len(cut)) == (10, 7, 6)


@pytest.mark.parametrize(
    ("table", "column", "mean"),
    [
        ("1", "m2", 63.2),
        ("1", "m3", 66.6),
        ("1", "m4", 271.8),
        ("2", "m2", 86.2),
        ("2", "m3", 86.5),
        ("2", "m4", 277.3),
    ],
)
def test_alwagih_means_in_y(table, column, mean):
    errors = printed("alwagih", table, column)
    assert float(sum(errors[f"{k}-y"] for k in range(1, 6)) / 5) == pytest.approx(mean, abs=0.05)


@cache
def alwagih_errors(run):
    """Tracking RMSE of both axes, a row per seed."""
    experiment = papers()["alwagih"].run(run).experiment
    results = [run_experiment(replace(experiment, seed=seed)) for seed in SEEDS]
    return np.array([[metrics.tracking_rmse for metrics in result.axis_metrics()] for result in results])


@pytest.mark.parametrize(
    ("run", "medians"),
    [
        ("m5-white", (13.1, 14.3)),
        ("m5-causal-white", (10.6, 14.8)),
        ("m5-coloured", (13.9, 15.1)),
        ("m5-causal-coloured", (15.6, 18.7)),
    ],
)
def test_alwagih_bank_with_and_without_hindsight(run, medians):
    assert np.median(alwagih_errors(run), axis=0) == pytest.approx(np.array(medians), abs=0.06)


@pytest.mark.parametrize(
    ("colour", "table", "printed_ratio", "ratio"), [("white", "1", 4.7, 3.9), ("coloured", "2", 3.4, 4.0)]
)
def test_alwagih_m1_against_m2_in_y(colour, table, printed_ratio, ratio):
    first, second = ([printed("alwagih", table, name)[f"{k}-y"] for k in range(1, 6)] for name in ("m1", "m2"))
    assert float(sum(first) / sum(second)) == pytest.approx(printed_ratio, abs=0.05)
    found = alwagih_errors(f"m1-{colour}")[:, 1] / alwagih_errors(f"m2-{colour}")[:, 1]
    assert np.median(found) == pytest.approx(ratio, abs=0.05)


@pytest.mark.parametrize(("method", "mean", "median"), [("m3", 77.7, 74.7), ("m4", 9.1, 6.8), ("m5", 93.9, 95.1)])
def test_alwagih_percentages_are_alike(method, mean, median):
    exact = [float(COMPUTED["alwagih", "5", f"{k}-y"][method]) for k in range(1, 6)]
    assert np.mean(exact) == pytest.approx(mean, abs=0.05)
    base = alwagih_errors("m1-white")
    assert np.median(100 * (1 - alwagih_errors(f"{method}-white") / base), axis=0)[1] == pytest.approx(median, abs=0.05)


@pytest.mark.parametrize(("alpha", "beta"), [(1.5, 0.5), (1.2, 1.0), (1.9, 0.1)])
def test_alwagih_beyond_one_a_pole_is_negative_and_the_filter_stable(alpha, beta):
    roots = np.sort(filter_poles((alpha, beta)).real)
    assert np.abs(roots).max() < 1
    assert roots[0] < 0 < roots[1]
    if alpha == 1.5:
        assert roots == pytest.approx([-(0.5**0.5), 0.5**0.5])


def test_garg_start():
    for speed, wanted in ((50, [30205, 30387.5, 30721]), (40, [30180, 30362.5, 30713.5])):
        ranges = [float(z) for z in RANGES["accelerating-earlier"].split()]
        rows = garg_filter(ranges, speed, 0.5, 0.4, 0.1, float)
        assert [row["x"] for row in rows[:3]] == pytest.approx(wanted, rel=1e-12)


def aircraft(times, onset):
    return 30_000 + 50 * times + 4 * np.maximum(times - onset, 0) ** 2


@pytest.mark.parametrize(
    ("alpha", "smoothed", "predicted"), [(0.5, 600, 1200), (0.8, 75, 375), (0.95, 11.6, 233), (0.99, 2.1, 206)]
)
def test_garg_lag(alpha, smoothed, predicted):
    truth = aircraft(5.0 * np.arange(1, 401), 20)
    last = garg_filter(truth, 50.0, alpha, alpha**2 / (2 - alpha), 0.0, float)[-1]
    assert truth[-1] - last["x"] == pytest.approx(smoothed, abs=0.05)
    assert truth[-1] - last["before"] == pytest.approx(predicted, abs=0.5)


def garg_rmse(name, onset, alpha=0.5, beta=0.4, gamma=0.1):
    ranges = [float(z) for z in RANGES[name].split()]
    truth = aircraft(5.0 * np.arange(1, 11), onset)
    rows = garg_filter(ranges, 50.0, alpha, beta, gamma, float)
    return np.sqrt(np.mean((np.array([row["x"] for row in rows]) - truth) ** 2))


def test_garg_estimate_near_one_is_the_measurement():
    truth = aircraft(5.0 * np.arange(1, 11), 20)
    raw = np.sqrt(np.mean((np.array(RANGES["accelerating"].split(), dtype=float) - truth) ** 2))
    assert raw == pytest.approx(115, abs=0.5)
    assert garg_rmse("accelerating", 20, 0.95, 0.95**2 / 1.05, 0) == pytest.approx(114, abs=0.5)


@pytest.mark.parametrize(
    ("name", "onset", "best", "figures"),
    [
        ("accelerating", 20, 0.263, {0.1: 176.5, 0.263: 146.0, 0.1333: 164}),
        ("accelerating-earlier", 15, 0.28, {0.1: 151.7, 0.28: 78.4, 0.1333: 134}),
    ],
)
def test_garg_larger_gamma_over_ten_samples(name, onset, best, figures):
    for gamma, wanted in figures.items():
        assert garg_rmse(name, onset, gamma=gamma) == pytest.approx(wanted, abs=0.5)
    grid = np.arange(0.1, 1, 0.001)
    assert grid[np.argmin([garg_rmse(name, onset, gamma=gamma) for gamma in grid])] == pytest.approx(best, abs=1e-9)
    assert garg_rmse(name, onset, alpha=0.8) == pytest.approx({20: 121, 15: 127}[onset], abs=0.5)


def test_garg_larger_gamma_is_unstable():
    assert radius((0.5, 0.4, 2 * 0.1333)) < 1 < radius((0.5, 0.4, 2 * 0.1334))
    assert radius((0.5, 0.4, 2 * 0.263)) == pytest.approx(1.14, abs=5e-3)
    assert radius((0.8, 0.4, 2 * 0.1)) < 1
    truth = aircraft(5.0 * np.arange(1, 41), 20)
    for gamma, wanted in ((0.1, 78), (0.263, 3_250)):
        smoothed = np.array([row["x"] for row in garg_filter(truth, 50.0, 0.5, 0.4, gamma, float)])
        assert np.sqrt(np.mean((smoothed - truth) ** 2)) == pytest.approx(wanted, rel=6e-3)


def test_garg_alpha_one_half():
    """Kalata's damping parameter r is sqrt(1/2) there; for three states the steady Riccati gain."""
    index = brentq(lambda at: (4 + at - sqrt(8 * at + at**2)) / 4 - sqrt(0.5), 0.01, 1)
    assert index == pytest.approx(0.243, abs=5e-4)
    assert index < 1 * 5**2 / 100
    f, g, p = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]]), 0.0416 * np.array([0.5, 1, 1]), np.eye(3)
    for _ in range(5000):
        p = f @ p @ f.T + np.outer(g, g)
        gain = p[:, 0] / (p[0, 0] + 1)
        p = p - np.outer(gain, p[0])
    assert gain[0] == pytest.approx(0.5, abs=2e-4)
