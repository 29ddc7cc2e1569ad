"""The proofs about Jeong, Njonjo & Pan, by another calculation."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from tests.core.proof_checks import (
    TRANSITION,
    assert_close,
    cell,
    curve,
    fading,
    kalata,
    keep,
    numbers,
    ship,
    value,
    values,
)


def test_jeong_zero_gamma():
    name, alpha = "jeong-zero-gamma", Fraction(43, 50)
    beta = alpha**2 / (2 - alpha)
    assert 2 * beta == alpha * (alpha + beta)
    assert value(name, "γ at α = 43/50") == "0"
    assert_close(values(name, "γ at α = 0.86")[-1], 2.0**-51, 20)
    assert_close(values(name, "γ printed")[-1], 2.0**-51, 20)
    # A gain of 2^-51 per sample may add up to 1,000 samples squared of it, times the innovations.
    assert values(name, "farthest")[-1] < 1000**3 * 2.0**-51 * 100


def test_jeong_precedence():
    name = "jeong-precedence"
    alpha, beta = Fraction("0.5277"), Fraction("0.1956")
    assert value(name, "β²/2·α") == f"{float(beta**2 / 2 * alpha):.4f}"
    assert value(name, "β²/(2α), eq. 13") == f"{float(beta**2 / (2 * alpha)):.4f}"
    for gamma in (0.0101, 0.0363):
        median = np.median(ship((0.5277, 0.1956, 2 * gamma))[0])
        assert_close(values(name, f"total tracking error with γ = {gamma}")[0], median, 0)


def test_jeong_xi():
    for xi in (Fraction("0.64"), Fraction("0.62")):
        gains = (1 - xi**3, Fraction(3, 2) * (1 - xi) ** 2 * (1 + xi), (1 - xi) ** 3)
        assert_close(values("jeong-xi", f"at ξ = {float(xi)}"), [float(gain) for gain in gains], 4)


def test_jeong_doubled_gain():
    name = "jeong-doubled-gain"
    proper = fading(0.64, 3)
    doubled = proper * (1, 1, 2)
    magnitudes = sorted(np.abs(np.linalg.eigvals(TRANSITION[3] @ keep(doubled))), reverse=True)
    assert_close(values(name, "their magnitudes"), magnitudes, 3)
    as_run, designed = ship(doubled), ship(proper)
    assert_close(values(name, "total tracking"), [np.median(as_run[0]), np.median(designed[0])], 0)
    assert_close(values(name, "total estimation"), [np.median(as_run[2]), np.median(designed[2])], 0)


@pytest.mark.parametrize(
    ("reading", "factors", "poles"),
    [
        ("γ/2T², η/6T³ (eq. 23–24)", (1, 1, 1 / 2, 1 / 36), "0.996, 0.878, 0.551 ± 0.198i"),
        ("2γ/T², 6η/T³", (1, 1, 2, 1), "0.960, 0.775 ± 0.380i, 0.419"),
        ("γ/T², 6η/T³ (fading memory)", (1, 1, 1, 1), "0.740, 0.740, 0.740, 0.740"),
    ],
)
def test_jeong_conventions(reading, factors, poles):
    name = "jeong-conventions"
    roots = np.linalg.eigvals(TRANSITION[4] @ keep(fading(0.74, 4) * factors))
    _, imaginary = curve(name, reading)
    assert_close(np.sort(np.abs(imaginary)), np.sort(np.abs(roots.imag)), 2)
    assert value(name, f"poles, {reading}") == poles
    real = [numbers(part)[0] for part in poles.split(", ")]
    assert_close(sorted(set(real)), sorted({round(root, 3) for root in roots.real}), 2)
    best = values(name, f"best ξ, {reading}")[0]
    around = [np.median(ship(fading(best + step, 4) * factors, 5)[0]) for step in (-0.01, 0, 0.01)]
    assert around[1] == min(around)


def test_jeong_differences():
    name = "jeong-differences"
    assert value(name, "tracking: 19,622") == f"{19622 - 17859:,} m"
    assert value(name, "estimation: 10,653") == f"{10653 - 10227} m"
    assert_close(values(name, "what is left"), [1763 - 1733.27 - 1, 426 - 419.49 - 1], 2)


def test_jeong_gray_murray(steady_kalman):
    name, index = "jeong-gray-murray", 0.2846
    drive = index * np.array([1 / 2, 1, 1])
    best = steady_kalman(np.outer(drive, drive))
    theirs = np.array(kalata(index))
    assert_close(values(name, "α, β, γ: Gray"), best, 4)
    assert_close(values(name, "α, β, γ: eq. 10–13")[-3:], theirs, 4)
    titles = ("Gray & Murray", "eq. 10–13, γ/T²", "eq. 10–13, 2γ/T²")
    for title, g in zip(titles, (best, theirs, theirs * (1, 1, 2)), strict=True):
        f, q = TRANSITION[3], np.outer(drive, drive)
        p = solve_discrete_lyapunov(keep(g) @ f, keep(g) @ q @ keep(g).T + np.outer(g, g))
        smoothed, predicted = values(name, f"variances, smoothed; predicted: {title}")[-2:]
        assert_close(smoothed, p[0, 0], 3)
        assert_close(predicted, (f @ p @ f.T + q)[0, 0], 2)
    totals = [np.median(ship(g)[0]) for g in (best, theirs * (1, 1, 2))]
    assert_close(values(name, "the ship"), totals, 0)


def test_jeong_tracking_total():
    error, innovation, _ = ship((0.86, 0.86**2 / 1.14))
    for what, totals in (("error against the truth", error), ("innovation", innovation)):
        found = values("jeong-tracking-total", f"{what}, started from two")
        assert_close(found, [totals.min(), np.median(totals), totals.max()], 0)


def test_jeong_worst():
    name = "jeong-worst"
    assert float(cell("jeong2017", "5", "gray-murray", "estimation").replace(",", "")) == 11_693
    assert values(name, "estimation error printed, Gray–Murray") == [11_693]
    assert values(name, "estimation error printed, Benedict–Bordner") == [11_677]
    alpha, beta, gamma = kalata(0.2846)
    assert_close(values(name, "recomputed, Gray–Murray")[0], np.median(ship((alpha, beta, 2 * gamma))[2]), 0)
    assert_close(values(name, "recomputed, Benedict–Bordner")[0], np.median(ship((0.86, 0.86**2 / 1.14))[2]), 0)


def test_jeong_one_search():
    name = "jeong-one-search"
    process, forward = curve(name, "σ_w² searched, σ_v² = 1")
    sensor, backward = curve(name, "σ_v² searched, σ_w² = 10⁻³")
    assert list(sensor) == [-3 - decade for decade in process]
    assert backward == pytest.approx(forward, rel=1e-9)
    for decade in (-3, 0):
        alpha, beta, gamma = kalata(9 * 10 ** (decade / 2))
        expected = np.median(ship((alpha, beta, 2 * gamma), 10)[1])
        assert forward[list(process).index(decade)] == pytest.approx(expected, rel=1e-9)
    alpha, beta, gamma = kalata(9 * sqrt(10**-2.5))
    assert_close(values(name, "half a decade")[-1], np.median(ship((alpha, beta, 2 * gamma))[0]), 0)
    assert_close(values(name, "σ_w for the same")[-1], 10 * sqrt(1e-3), 3)
