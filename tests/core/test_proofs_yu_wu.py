"""The proofs about Yu & Wu, by another calculation."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from math import sqrt

import numpy as np
import pytest

from tests.core.proof_checks import (
    TRANSITION,
    assert_close,
    cell,
    curve,
    keep,
    numbers,
    value,
    values,
)
from tracker_core.papers import papers
from tracker_core.papers.proofs import prove
from tracker_core.run import known_state, observe


@cache
def grid(order, factor):
    """Normalised gains at i/(m + 1) of eq. 10-12 and 21-24, ordered by level of gamma, alpha, beta, delta."""
    shares = [Fraction(i, 5) for i in range(1, 5)]
    deltas = [Fraction(i, 7) for i in range(1, 7)] if order == 4 else [Fraction(0)]
    sets = []
    for c, a, b, d in product(shares, shares, shares, deltas):
        alpha = 2 * a
        beta = b * factor * (4 - 2 * alpha)
        gamma = c * 4 * alpha * beta / (2 - alpha)
        delta = d * 24 * (2 - alpha)
        sets.append([float(gain) for gain in (alpha, beta, gamma / 2, delta / 6)[:order]])
    return np.array(sets)


def stable_sets(sets):
    largest = np.array([np.abs(np.linalg.eigvals(TRANSITION[len(g)] @ keep(g))).max() for g in sets])
    return largest < 1 - 1e-9, largest.max()


def test_yu_jury():
    name = "yu-jury"
    for order in (3, 4):
        for factor, title in ((Fraction(13, 6), "as printed"), (Fraction(1), "β < 4 − 2α")):
            stable, largest = stable_sets(grid(order, factor))
            of = {3: 64, 4: 384}[order]
            assert values(name, f"order {order}: stable of {of}, {title}") == [stable.sum()]
            if factor > 1:
                assert_close(values(name, "largest poles")[order - 3], largest, 2)
    # (z + 1/2)^4 from the paper's own eq. 20.
    a, b, c, d = 15 / 16, 81 / 32, 27 / 4, 243 / 8
    polynomial = [1, a + b + c / 4 + d / 36 - 4, 6 - 3 * a - 2 * b + d / 9, 3 * a + b - c / 4 + d / 36 - 4, 1 - a]
    assert polynomial == pytest.approx(np.poly([-0.5] * 4))
    assert values(name, "that δ") == [d, 24 * (2 - a)]


def searched(run, which, sets, ties, seeds):
    """Smoothed positions, (seeds, samples, axes), of the search of Yu & Wu for every seed and axis at once."""
    experiment = papers()["yu2017"].run(run).experiment if isinstance(run, str) else run
    observed = [observe(replace(experiment, seed=seed))[:2] for seed in seeds]
    true = np.array([truth.states for truth, _ in observed])
    measured = np.array([measurements.positions for _, measurements in observed])
    order, interval = sets.shape[1], experiment.interval
    scale = interval ** np.arange(order)
    start = known_state(replace(experiment, seed=1)).T * scale[:, None]
    state = np.repeat(start[:, None, :], len(seeds), axis=1)
    tried = sets if ties == "first" else sets[::-1]
    smoothed = []
    for k in range(measured.shape[1]):
        state = np.einsum("ij,jsa->isa", TRANSITION[order], state)
        e = measured[:, k] - state[0]
        error = np.abs((state[which] + np.multiply.outer(tried[:, which], e)) / scale[which] - true[:, k, :, which])
        state = state + tried[error.argmin(axis=0)].transpose(2, 0, 1) * e
        smoothed.append(state[0])
        if np.abs(state[0]).max() > 1e12:
            break
    return true[:, :, :, 0], measured, np.array(smoothed).swapaxes(0, 1)


@pytest.mark.parametrize("ties", ["first", "last"])
def test_yu_degenerate(ties):
    """Every seed by itself, so that one that diverges does not stop the others."""
    runs = [searched("delta-0.2", 3, grid(4, Fraction(1)), ties, [seed]) for seed in range(1, 6)]
    diverged = sum(smoothed.shape[1] < true.shape[1] for true, _, smoothed in runs)
    title = {"first": "order 4, jerk", "last": "the same, last"}[ties]
    assert values("yu-degenerate", title)[-1] == diverged
    gammas = [round(gain, 12) for gain in grid(3, Fraction(1))[:, 2]]
    most = max(gammas.count(gamma) for gamma in gammas)
    assert values("yu-degenerate", "different γ") == [len(set(gammas)), most]


def test_yu_degenerate_curve_is_the_distance_of_a_straight_line():
    shares, moved = curve("yu-degenerate", "γ")
    _, flat = curve("yu-degenerate", "α")
    # |a_p + c γ - a_o| with c = e/T²: two straight pieces, and at the share 1 the value of the flat curves.
    bends = np.abs(np.diff(moved, 2)) > 1e-9
    assert bends.sum() <= 2
    assert np.interp(1.0, shares, moved) == pytest.approx(flat[0], rel=1e-9)
    assert np.ptp(flat) == 0


def test_yu_oracle():
    gamma = np.array(grid(3, Fraction(1)))
    for sigma in (1, 50):
        true, measured, smoothed = searched(f"gamma-sigma-{sigma}", 2, gamma, "first", range(1, 21))
        raw, found = (np.median(np.sqrt(((one - true) ** 2).sum(axis=2).mean(axis=1))) for one in (measured, smoothed))
        assert_close(values("yu-oracle", f"σ = {sigma} m")[:2], [raw / sigma, found / sigma], 3)


def test_yu_oracle_of_order_four():
    sets = grid(4, Fraction(1))
    stable, _ = stable_sets(sets)
    true, _, smoothed = searched("delta-sigma-10", 2, sets[stable], "last", range(1, 21))
    rmse = np.median(np.sqrt(((smoothed - true) ** 2).sum(axis=2).mean(axis=1)))
    assert_close(values("yu-oracle", "σ = 10 m")[2], rmse / 10, 3)


def literal(g, eq6, eq8, steps):
    """Eq. 3-8 with T = 1, no noise, target at rest at 0, from a state off it: the largest state of every step."""
    x, v, a, before = 1.0, 0.3, -0.2, 0.1
    track = []
    for _ in range(steps):
        xp, vp, ap = x + v + a / 2, v + a, a
        e = 0 - xp
        x = xp + (0 if eq6 else g[0] * e)
        v = vp + g[1] * e
        a = (before if eq8 else ap) + g[2] * e
        before = ap
        track.append(max(abs(x), abs(v), abs(a)))
    return track


def test_yu_misprints():
    name = "yu-misprints"
    sets = grid(3, Fraction(1))[::7]
    assert all(literal(g, False, False, 3000)[-1] < 1e-6 for g in sets)
    assert all(literal(g, True, False, 300)[-1] > 1 for g in sets)
    assert all(literal(g, False, True, 300)[-1] > 1e-3 for g in sets)
    assert value(name, "sets that are stable") == "64 of 64"
    # Acceleration a, -a, a ... with velocity -a/2, a/2 ...: no position, no innovation, no correction.
    x, v, a = 0, Fraction(-1, 2), Fraction(1)
    assert x + v + a / 2 == 0
    assert v + a == -v
    assert values(name, "eq. 8: greatest")[-1] < 1e-12
    assert values(name, "eq. 6: product")[-1] == 1
    blind = [np.prod(np.linalg.eigvals(TRANSITION[3] @ keep((0, g[1], g[2])))) for g in sets]
    assert np.abs(blind) == pytest.approx(1)


def test_yu_digits():
    over, under = Fraction("1.4708") / 10**5, Fraction("2.5308") / 10**6
    assert value("yu-digits", "improvement recomputed") == f"{float(100 * (over / under - 1)):.1f} %"
    assert value("yu-digits", "improvement printed") == "418.2 %"


def test_yu_undefined():
    name = "yu-undefined"
    steps = ("0.2", "0.1", "0.05", "0.025", "0.0125")
    rows = [
        (100 / float(step), *(float(cell("yu2017", table, step, filt)) for table in "12"))
        for filt in ("gamma", "delta")
        for step in steps
    ]
    assert value(name, "rows in which L_max/√N") == f"{sum(m / n**0.5 > l2 for n, l2, m in rows)} of 10"
    assert value(name, "rows in which L2 > L_max²") == f"{sum(l2 > m * m for _, l2, m in rows)} of 10"
    assert value(name, "rows in which ‖e‖/N") == f"{sum(m / n <= l2 <= m / n**0.5 for n, l2, m in rows)} of 10"
    quiet = replace(
        papers()["yu2017"].run("gamma-0.0125").experiment,
        noise="white", noise_std=(1e-4,), manoeuvre="none", manoeuvre_std=None,
    )  # fmt: skip
    true, _, smoothed = searched(quiet, 2, grid(3, Fraction(1)), "first", range(1, 6))
    norms = np.sqrt(((smoothed - true) ** 2).sum(axis=(1, 2))) / true.shape[1]
    assert_close(values(name, "L2 with σ")[-2], np.median(norms), 8)
    power = np.mean(true[0, :, 0] ** 2)
    assert_close(values(name, "SNR = 5")[-2:], [sqrt(power / 5), sqrt(power / 10**0.5)], 0)


def test_yu_swapped():
    steps = ("0.2", "0.1", "0.05", "0.025", "0.0125")
    ratios = {
        (table, filt): [
            f"{float(Fraction(cell('yu2017', table, a, filt)) / Fraction(cell('yu2017', table, b, filt))):.2f}"
            for a, b in pairwise(steps)
        ]
        for table in "12"
        for filt in ("gamma", "delta")
    }
    columns = {
        (table, column): [cell("yu2017", table, step, column) for step in steps[1:]]
        for table in "34"
        for column in ("gamma-ratio", "delta-ratio")
    }
    assert columns["3", "gamma-ratio"] == ratios["1", "delta"]
    assert columns["3", "delta-ratio"] == ratios["2", "delta"]
    assert columns["4", "gamma-ratio"] == ratios["1", "gamma"]
    assert columns["4", "delta-ratio"] == ratios["2", "gamma"]
    assert value("yu-swapped", "table 3: δ's L2").startswith("16 of 16")
    assert value("yu-swapped", "L2 of γ") == ratios["1", "gamma"][0]


def test_yu_manoeuvre():
    t = Fraction(1, 5)
    pushes = {"eq. 1": (t**3 / 6, t**2 / 2, 1), "eq. 2": (t**2 / 2, t, 1), "eq. 3–5": (t**3 / 6, t**2 / 2, t)}
    for name, push in pushes.items():
        found = [line for line in prove("yu-manoeuvre").lines if line[0].startswith(name) and "adds" in line[0]]
        assert_close(numbers(found[0][1]), [float(part) for part in push], 6)
    # Var(w - w') = 2 Var(w); with 100,000 draws to a hundredth.
    assert_close(values("yu-manoeuvre", "variance left")[-1], 2.0, 1)


def test_yu_monotone():
    for table, column, falls in (("1", "improvement", 1), ("4", "gamma-ratio", 3)):
        steps = ("0.2", "0.1", "0.05", "0.025", "0.0125")[int(table) // 3 :]
        printed = [float(cell("yu2017", table, step, column)) for step in steps]
        assert sum(b < a for a, b in pairwise(printed)) == falls
        title = {"improvement": "improvement", "gamma-ratio": "first ratio"}[column]
        assert values("yu-monotone", f"table {table}, {title}")[0] == falls
