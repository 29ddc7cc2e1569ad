"""Jeong, Njonjo & Pan 2017: the printed totals, and every figure that the errata state, by loops of our own."""

from decimal import Decimal
from fractions import Fraction
from functools import cache
from math import factorial, hypot, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.core.oracles import filter_poles, printed
from tracker_core.papers import papers
from tracker_core.papers.printed import half_unit, number


def order_3(xi):
    return 1 - xi**3, (1 - xi) ** 2 * (1 + xi) * 3 / 2, (1 - xi) ** 3


def order_4(xi):
    """The fading-memory gains for gamma/T^2 and eta/T^3."""
    return 1 - xi**4, (1 - xi) ** 2 * (11 + 14 * xi + 11 * xi**2) / 6, 2 * (1 - xi) ** 3 * (1 + xi), (1 - xi) ** 4


# Jeong's totals, by a loop over samples ----------------------------------------------------------------------------

RUNS = 100


def ship_parameters():
    """a, b and w of Jeong's eq. 29-30, from the first position and speed."""
    a, b = 573 / 18, 1038.4 / 20
    return a, b, brentq(lambda w: hypot(44.6 * a * w + 10, 44 * b * w) - 50.4, 0.001, 1, xtol=1e-15)


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


def test_jeong_zero_gamma_is_double_precision():
    alpha = 0.86
    beta = alpha / (2 - alpha) * alpha
    assert (4 / alpha) * beta - 2 * (alpha + beta) == 2.0**-51
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
