"""The proofs of the errata: each holds, each is used, and its numbers come out of another calculation as well.

The other calculations are textbook loops over many seeds at once, exact fractions, eigenvalues of matrices written
down here, Riccati and Lyapunov equations. Truth, measurements and printed cells are the core's.
"""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from math import isfinite, sqrt
from statistics import mean

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov
from scipy.stats import ttest_rel

from tracker_core import InputError
from tracker_core.papers import NAMES, papers
from tracker_core.papers.proofs import PROOFS, prove
from tracker_core.run import known_state, observe

TRANSITION = {
    2: np.array([[1.0, 1], [0, 1]]),
    3: np.array([[1, 1, 1 / 2], [0, 1, 1], [0, 0, 1]]),
    4: np.array([[1, 1, 1 / 2, 1 / 6], [0, 1, 1, 1 / 2], [0, 0, 1, 1], [0, 0, 0, 1]]),
}


def numbers(text):
    """The numbers in a text: thousands grouped, true minus signs, powers of ten."""
    found = re.findall(r"(−?[\d,]*\d(?:\.\d+)?)(?: × 10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?", text)
    raised = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    return [
        float(value.replace("−", "-").replace(",", "")) * 10.0 ** int(power.translate(raised) or 0)
        for value, power in found
    ]


def value(name, label):
    """The value of the one line whose label begins so, as text."""
    (text,) = [text for title, text in prove(name).lines if title.startswith(label)]
    return text


def values(name, label):
    return numbers(value(name, label))


def curve(name, title):
    """x and y of one series of the chart."""
    (series,) = [series for series in prove(name).chart.series if series.name == title]
    return series.x, np.array(series.y)


def cell(paper, table, row, column):
    return papers()[paper].table(table).printed(row, column)


def assert_close(found, expected, decimals):
    """Numbers that a line prints with so many decimals are those expected."""
    assert found == pytest.approx(expected, rel=1e-9, abs=0.5000001 * 10.0**-decimals)


# The registry ------------------------------------------------------------------------------------------------------


def test_every_erratum_has_a_proof_and_every_proof_an_erratum():
    assert [name for paper in NAMES for name in proofs_of(paper)] == list(PROOFS)


def proofs_of(paper):
    return [erratum.proof for erratum in papers()[paper].errata]


def test_an_unknown_proof_is_refused():
    with pytest.raises(InputError, match="^proof must be one of jeong-zero-gamma"):
        prove("jeong-perpetual-motion")


@pytest.mark.parametrize("name", PROOFS)
def test_proof_holds_and_can_be_shown(name):
    proof = prove(name)
    assert proof.holds is True
    assert prove(name) is proof
    assert 3 <= len(proof.lines) <= 8
    assert "\n" not in proof.formula
    assert len({title for title, _ in proof.lines}) == len(proof.lines)
    for title, text in proof.lines:
        assert title
        assert text
        # The minus sign is a minus sign.
        assert not re.search(r"-\d|\bnan\b|\binf\b", title + text)
    for series in proof.chart.series if proof.chart else ():
        assert len(series.x) == len(series.y) > 0
        assert all(isfinite(y) for y in series.y)
        assert series.kind in {"line", "points", "bars"}
        assert series.role in {"truth", "observed", "predicted", "smoothed", "counterpart", "marker", "bad"}


# Another filter ----------------------------------------------------------------------------------------------------


@cache
def seen(paper, run, seeds):
    """True and measured positions of every seed, shape (seeds, samples, axes), and the interval."""
    experiment = papers()[paper].run(run).experiment
    pairs = [observe(replace(experiment, seed=seed))[:2] for seed in range(1, seeds + 1)]
    true, measured = (np.array([pair[i].positions for pair in pairs]) for i in (0, 1))
    return true, measured, experiment.interval


def filtered(g, z, interval):
    """Predicted and smoothed positions from the third sample on, started from two points; derivatives times T^i."""
    state = np.zeros((len(g), *z[:, 0].shape))
    state[0], state[1] = z[:, 1], z[:, 1] - z[:, 0]
    predicted, smoothed = [], []
    for measured in z[:, 2:].swapaxes(0, 1):
        state = np.einsum("ij,j...->i...", TRANSITION[len(g)], state)
        predicted.append(state[0])
        state = state + np.multiply.outer(np.asarray(g), measured - state[0])
        smoothed.append(state[0])
    return np.array(predicted).swapaxes(0, 1), np.array(smoothed).swapaxes(0, 1)


def total(one, other):
    return np.sqrt(((one - other) ** 2).sum(axis=2)).sum(axis=1)


def ship(g, seeds=100):
    """Totals of the ship for every seed: tracking, innovation, and estimation, in which the start counts."""
    true, measured, interval = seen("jeong2017", "benedict-bordner", seeds)
    predicted, smoothed = filtered(g, measured, interval)
    started = total(measured[:, :2], true[:, :2])
    ahead, behind = total(predicted, true[:, 2:]), total(smoothed, true[:, 2:])
    return ahead, total(predicted, measured[:, 2:]), behind + started


def fading(xi, order):
    """Normalised gains with every pole at xi, from the polynomial (z - xi)^order: the gains are linear in it."""
    step = np.array([np.poly(TRANSITION[order] @ keep(unit)) for unit in np.eye(order)])
    base = np.poly(TRANSITION[order])
    return np.linalg.solve((step - base)[:, 1:].T, (np.poly([xi] * order) - base)[1:])


def keep(g):
    """I - K H."""
    matrix = np.eye(len(g))
    matrix[:, 0] -= g
    return matrix


def kalata(index):
    """Eq. 10-12 of Jeong et al., and eq. 13's gamma."""
    r = (4 + index - sqrt(8 * index + index**2)) / 4
    alpha = 1 - r**2
    beta = 2 * (2 - alpha) - 4 * sqrt(1 - alpha)
    return alpha, beta, beta**2 / (2 * alpha)


# Jeong, Njonjo & Pan -----------------------------------------------------------------------------------------------


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


# Yu & Wu -----------------------------------------------------------------------------------------------------------


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


# Al-Wagih & Abdulla ------------------------------------------------------------------------------------------------


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


# Garg --------------------------------------------------------------------------------------------------------------


def aircraft(run, g, state, steps=None):
    """Predicted and smoothed positions on the recorded ranges, or others; g as eq. 2 gamma/T^2 writes them."""
    truth, measurements, _ = observe(papers()["garg2021"].run(run).experiment)
    z = measurements.positions[:, 0] if steps is None else steps
    state, predicted, smoothed = list(state) + [0.0] * (3 - len(state)), [], []
    a, b, c = (*g, 0.0)[:3]
    for measured in z:
        x, v, w = state[0] + 5 * state[1] + 12.5 * state[2], state[1] + 5 * state[2], state[2]
        e = measured - x
        predicted.append(x)
        state = [x + a * e, v + b * e / 5, w + 2 * c * e / 25]
        smoothed.append(state[0])
    return truth.positions[:, 0], np.array(predicted), np.array(smoothed)


def test_garg_start():
    for speed in (40.0, 50.0):
        _, _, smoothed = aircraft("accelerating-earlier", (0.5, 0.4, 0.1), (30_000.0, speed))
        assert_close(values("garg-start", f"started with {speed:g}"), smoothed[:3], 1)
    # 30,000 + 5 · 50 = 30,250 is predicted, 30,160 measured.
    assert values("garg-start", "started with 50")[0] == (30_250 + 30_160) / 2


def test_garg_lag():
    times = 5.0 * np.arange(1, 400)
    for alpha in (0.5, 0.8, 0.95, 0.99):
        beta = alpha**2 / (2 - alpha)
        z = 30_000 + 4 * times**2
        _, predicted, smoothed = aircraft("accelerating", (alpha, beta), (30_000.0, 0.0), z)
        assert_close(values("garg-lag", f"α = {alpha}:"), [z[-1] - smoothed[-1], z[-1] - predicted[-1]], 1)
    true, predicted, smoothed = aircraft("accelerating", (0.95, 0.95**2 / 1.05), (30_000.0, 50.0))
    found = [np.sqrt(np.mean((one - true) ** 2)) for one in (smoothed, predicted)]
    assert_close(values("garg-lag", "recorded, α = 0.95")[:2], found, 1)


def test_garg_precision(steady_kalman):
    name = "garg-precision"
    for place, order in enumerate((2, 3)):
        drive = values(name, "Λ at which")[place] * np.array([1 / 2, 1, 1])[:order]
        assert steady_kalman(np.outer(drive, drive))[0] == pytest.approx(0.5, abs=1e-3)
    drive = np.array([25 / 2, 5.0])
    for sensor, title in ((1.0, "precise sensor"), (100.0, "poor sensor")):
        for process, target in ((0.001, "steady"), (8.0, "manoeuvring")):
            gains = steady_kalman(process**2 * np.outer(drive, drive), sensor**2, 5.0)
            (found,) = [text for label, text in prove(name).lines if title in label and target in label]
            assert_close(numbers(found)[-1], gains[0], 3)
    for alpha, left in zip((0.1, 0.3, 0.5, 0.7, 0.9), values(name, "no manoeuvre")[-5:], strict=True):
        g = np.array([alpha, 2 * (2 - alpha) - 4 * sqrt(1 - alpha)])
        p = solve_discrete_lyapunov(keep(g) @ TRANSITION[2], np.outer(g, g))
        assert_close(left, p[0, 0], 3)


def test_garg_gamma():
    name = "garg-gamma"
    for run, title in (("accelerating", "later"), ("accelerating-earlier", "earlier")):
        (label,) = [label for label, _ in prove(name).lines if label.startswith(f"{title} ranges")]
        found = []
        for gamma in numbers(label):
            true, _, smoothed = aircraft(run, (0.5, 0.4, gamma), (30_000.0, 50.0))
            found.append(np.sqrt(np.mean((smoothed - true) ** 2)))
        assert_close(values(name, f"{title} ranges"), found, 1)
        best = numbers(label)[-1]
        for beside in (best - 0.002, best + 0.002):
            true, _, smoothed = aircraft(run, (0.5, 0.4, beside), (30_000.0, 50.0))
            assert np.sqrt(np.mean((smoothed - true) ** 2)) > found[-1]
    poles = np.abs(np.linalg.eigvals(TRANSITION[3] @ keep((0.5, 0.4, 2 * 0.263))))
    assert_close(values(name, "largest pole")[-1], poles.max(), 3)
    border = np.abs(np.linalg.eigvals(TRANSITION[3] @ keep((0.5, 0.4, 2 * 0.2 / 1.5))))
    assert border.max() == pytest.approx(1)
    assert_close(values(name, "γ below")[-1], 0.2 / 1.5, 4)
