"""What the errata of Yu & Wu say, worked out without the recipes and the proofs."""

from dataclasses import replace
from functools import cache
from itertools import pairwise, product
from math import sqrt

import numpy as np
import pytest

from tests.core.oracles import printed, radius
from tracker_core import run_experiment
from tracker_core.papers import papers
from tracker_core.papers.printed import half_unit


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
