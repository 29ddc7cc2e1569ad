"""The proofs about Al-Wagih & Abdulla, by another calculation."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from statistics import mean

import numpy as np
import pytest
from scipy.stats import ttest_rel

from tests.core.proof_checks import (
    assert_close,
    cell,
    seen,
    value,
    values,
)
from tracker_core.papers import papers
from tracker_core.papers.proofs import prove


def varied(gains, z):
    """Predicted positions from the third sample on with gains (alpha, beta) of every sample."""
    x, v = z[:, 1], z[:, 1] - z[:, 0]
    predicted = []
    for k, (alpha, beta) in enumerate(gains, 2):
        x = x + v
        predicted.append(x)
        e = z[:, k] - x
        x, v = x + alpha * e, v + beta * e
    return np.array(predicted).swapaxes(0, 1)


def test_alwagih_hindsight():
    name = "alwagih-hindsight"
    true, z, _ = seen("alwagih", "m5-white", 20)
    alphas = (np.arange(50) + 0.5) / 50
    bank = np.array([varied([(a, a * a / (2 - a))] * 198, z) for a in alphas])
    nearest = np.abs(bank - z[:, 2:]).argmin(axis=0)
    chosen = np.take_along_axis(bank, nearest[None], axis=0)[0]
    assert_close(values(name, "RMS distance of M5")[-1], np.sqrt(((chosen - z[:, 2:]) ** 2).mean(axis=(0, 1))).min(), 1)
    error, noise = (chosen - true[:, 2:]).ravel(), (z - true)[:, 2:].ravel()
    assert_close(values(name, "correlation of M5")[-1], np.corrcoef(error, noise)[0, 1], 2)
    rmse = np.median(np.sqrt(((chosen - true[:, 2:]) ** 2).mean(axis=1)), axis=0)
    assert_close(values(name, "RMSE in x, y, white")[:2], rmse, 1)


def test_alwagih_target():
    name = "alwagih-target"
    for colour, table in (("white", "1"), ("coloured", "2")):
        printed = [mean(float(cell("alwagih", table, f"{k}-y", m)) for k in range(1, 6)) for m in ("m1", "m2")]
        true, z, _ = seen("alwagih", f"m1-{colour}", 20)
        fixed = varied([(0.1, 0.01 / 1.9)] * 198, z)
        growing = varied([(2 * (2 * n - 1) / (n * (n + 1)), 6 / (n * (n + 1))) for n in range(3, 201)], z)
        rmse = [np.sqrt(((one - true[:, 2:]) ** 2)[:, :, 1].mean(axis=1)) for one in (fixed, growing)]
        expected = [printed[0] / printed[1], np.median(rmse[0] / rmse[1])]
        place = {"white": slice(0, 2), "coloured": slice(2, 4)}[colour]
        assert_close(values(name, "RMSE in y, M1 over M2")[place], expected, 1)
    methods = ("m1", "m2", "m3", "m4", "m5")
    order = sorted(methods, key=lambda m: sum(float(cell("alwagih", "1", f"{k}-x", m)) for k in range(1, 6)))
    assert value(name, "white, x").split("; ")[0] == " ".join(order).upper()


def test_alwagih_tables():
    counts = dict.fromkeys("3456", 0)
    for averages, changes, source in (("3", "5", "1"), ("4", "6", "2")):
        for method, axis in product(("m3", "m4", "m5"), "xy"):
            for base in ("m1", "m2"):
                rows = [Fraction(cell("alwagih", source, f"{k}-{axis}", base)) for k in range(1, 6)]
                others = [Fraction(cell("alwagih", source, f"{k}-{axis}", method)) for k in range(1, 6)]
                off = sum(rows) / 5 - sum(others) / 5 - Fraction(cell("alwagih", averages, f"{base}-{axis}", method))
                counts[averages] += abs(off) > Fraction(1, 20_000)
                if base == "m1":
                    for k, one, other in zip(range(1, 6), rows, others, strict=True):
                        text = cell("alwagih", changes, f"{k}-{axis}", method)
                        counts[changes] += abs(100 * (1 - other / one) - Fraction(text)) > Fraction(1, 20_000)
    for table, wrong in counts.items():
        assert values("alwagih-tables", f"table {table}")[-2] == wrong
    assert sum(counts.values()) == len(papers()["alwagih"].errata[2].cells)


def test_alwagih_region():
    name = "alwagih-region"
    alpha, beta = 1.6, 0.2
    roots = np.roots([1, alpha + beta - 2, 1 - alpha])
    assert_close(sorted(values(name, "poles at")), sorted(roots), 3)
    x = v = 0.0
    errors = []
    for _ in range(12):
        x += v
        e = 1 - x
        x, v = x + alpha * e, v + beta * e
        errors.append(1 - x)
    assert values(name, "changes of sign")[-1] == sum(a * b < 0 for a, b in pairwise(errors))
    largest = max(
        np.abs(np.roots([1, a + b - 2, 1 - a])).max()
        for a in np.arange(1.05, 1.96, 0.05)
        for b in np.arange(0.05, 0.96, 0.05) * (4 - 2 * a)
    )
    assert_close(values(name, "their largest")[-1], largest, 3)


def test_alwagih_ranking():
    for colour, table in (("white", "1"), ("coloured", "2")):
        second, third, fourth = (
            mean(Fraction(cell("alwagih", table, f"{k}-y", m)) for k in range(1, 6)) for m in ("m2", "m3", "m4")
        )
        assert_close(values("alwagih-ranking", f"{colour}, y: M4 over M3")[-1], float(fourth / third), 2)
        assert_close(values("alwagih-ranking", f"{colour}, y: M2 − M3")[-1], float(second - third), 4)


def test_alwagih_significance():
    levels, losses = {}, []
    for table, base, axis, new in product("12", ("m1", "m2"), "xy", ("m3", "m4", "m5")):
        pairs = [[float(cell("alwagih", table, f"{k}-{axis}", m)) for k in range(1, 6)] for m in (base, new)]
        test = ttest_rel(*pairs)
        levels[f"{base.upper()}−{new.upper()} {axis} ({table})"] = test.pvalue
        if test.pvalue < 1e-3 and test.statistic < 0:
            losses.append(f"{base.upper()}−{new.upper()} {axis} ({table}), t = −{-test.statistic:.0f}")
    chance = {name: p for name, p in levels.items() if p > 0.05}
    name = "alwagih-significance"
    assert values(name, "not significant") == [len(chance), 24]
    assert values(name, "significant") == [sum(p < 1e-3 for p in levels.values()), 24]
    for axis in "xy":
        p = sorted(p for test, p in chance.items() if f" {axis} " in test)
        assert values(name, f"p of these in {axis}") == pytest.approx(p, rel=0.05)
    assert dict(prove(name).lines)["of these losses"] == "; ".join(losses)
    (shown,) = prove(name).chart.series
    assert dict(zip(shown.x, shown.y, strict=True)) == pytest.approx(chance, rel=1e-9)
