"""Every figure that the errata of Yu & Wu, Al-Wagih & Abdulla and Garg state, computed anew."""

from dataclasses import replace
from decimal import Decimal
from functools import cache
from itertools import pairwise, product
from math import factorial, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

from tracker_core import run_experiment
from tracker_core.papers import papers
from tracker_core.papers.printed import EMPTY, half_unit, number


def printed(paper, table, column):
    """The numbers of a column by row, exactly."""
    found = papers()[paper].table(table)
    cells = {row.name: found.printed(row.name, column) for row in found.rows}
    return {name: number(cell) for name, cell in cells.items() if cell != EMPTY}


def radius(gains):
    """The largest modulus among the poles of gains for 1, 1/T, 1/T^2, 1/T^3."""
    return np.abs(filter_poles(gains)).max()


def filter_poles(gains):
    order = len(gains)
    transition = [[1 / factorial(j - i) if j >= i else 0 for j in range(order)] for i in range(order)]
    return np.linalg.eigvals((np.eye(order) - np.outer(gains, np.eye(order)[0])) @ np.array(transition))


# Yu & Wu -------------------------------------------------------------------------------------------------------------


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


def test_yu_equation_6_as_printed_is_never_stable():
    """The position takes no part of the innovation; velocity and acceleration do."""
    for alpha, beta, gamma in yu_sets(3, 1):
        step = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]])
        meant, misprinted = (np.eye(3) - np.outer([share, beta, gamma], [1, 0, 0]) for share in (alpha, 0))
        assert np.abs(np.linalg.eigvals(meant @ step)).max() < 1
        assert np.linalg.det(misprinted @ step) == pytest.approx(1, rel=1e-12)


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


# Al-Wagih & Abdulla --------------------------------------------------------------------------------------------------


def differences(source, base, of, axis):
    """Of the RMSE of two of Al-Wagih's methods, experiment by experiment."""
    first, second = (printed("alwagih", source, name) for name in (base, of))
    return [first[f"{k}-{axis}"] - second[f"{k}-{axis}"] for k in range(1, 6)]


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


def change(source, row, of):
    """Eq. 27."""
    base, other = (printed("alwagih", source, name)[row] for name in ("m1", of))
    return 100 * (base - other) / base


def test_alwagih_percentages_that_are_cut_off():
    wrong = [cell for cell in papers()["alwagih"].errata[2].cells if cell[0] in "56"]
    near, cut = [], []
    for table, row, column in wrong:
        exact = change({"5": "1", "6": "2"}[table], row, column)
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
        ("m5-causal-coloured", (15.6, 18.6)),
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
    assert np.mean([float(change("1", f"{k}-y", method)) for k in range(1, 6)]) == pytest.approx(mean, abs=0.05)
    base = alwagih_errors("m1-white")
    assert np.median(100 * (1 - alwagih_errors(f"{method}-white") / base), axis=0)[1] == pytest.approx(median, abs=0.05)


@pytest.mark.parametrize(("alpha", "beta"), [(1.5, 0.5), (1.2, 1.0), (1.9, 0.1)])
def test_alwagih_beyond_one_a_pole_is_negative_and_the_filter_stable(alpha, beta):
    roots = np.sort(filter_poles((alpha, beta)).real)
    assert np.abs(roots).max() < 1
    assert roots[0] < 0 < roots[1]
    if alpha == 1.5:
        assert roots == pytest.approx([-(0.5**0.5), 0.5**0.5])


# Garg ----------------------------------------------------------------------------------------------------------------


RANGES = {
    "accelerating-earlier": "30160 30365 30890 31050 31785 32215 33130 34510 36010 37265",
    "accelerating": "30221 30453 30906 30999 31368 31978 32526 33379 34698 36275",
}


def garg_filter(ranges, speed, alpha, beta, gamma):
    """The second listing, row by row: smoothed state and predicted range."""
    t = 5.0
    x, v, a = 30_000.0, speed, 0.0
    rows = []
    for z in ranges:
        before = x + v * t + a * t * t / 2
        v = v + a * t
        x = before + alpha * (z - before)
        v = v + beta * (z - before) / t
        a = a + 2 * gamma * (z - before) / t / t
        rows.append({"x": x, "v": v, "a": a, "before": before})
    return rows


def test_garg_start():
    for speed, wanted in ((50, [30205, 30387.5, 30721]), (40, [30180, 30362.5, 30713.5])):
        ranges = [float(z) for z in RANGES["accelerating-earlier"].split()]
        rows = garg_filter(ranges, speed, 0.5, 0.4, 0.1)
        assert [row["x"] for row in rows[:3]] == pytest.approx(wanted, rel=1e-12)


def aircraft(times, onset):
    return 30_000 + 50 * times + 4 * np.maximum(times - onset, 0) ** 2


@pytest.mark.parametrize(
    ("alpha", "smoothed", "predicted"), [(0.5, 600, 1200), (0.8, 75, 375), (0.95, 11.6, 233), (0.99, 2.1, 206)]
)
def test_garg_lag(alpha, smoothed, predicted):
    truth = aircraft(5.0 * np.arange(1, 401), 20)
    last = garg_filter(truth, 50.0, alpha, alpha**2 / (2 - alpha), 0.0)[-1]
    assert truth[-1] - last["x"] == pytest.approx(smoothed, abs=0.05)
    assert truth[-1] - last["before"] == pytest.approx(predicted, abs=0.5)


def garg_rmse(name, onset, alpha=0.5, beta=0.4, gamma=0.1):
    ranges = [float(z) for z in RANGES[name].split()]
    truth = aircraft(5.0 * np.arange(1, 11), onset)
    rows = garg_filter(ranges, 50.0, alpha, beta, gamma)
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
        smoothed = np.array([row["x"] for row in garg_filter(truth, 50.0, 0.5, 0.4, gamma)])
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
