"""Yu & Wu 2017: what is wrong with the equations, the bounds and the objective."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

import numpy as np

from tracker_core.adaptive.sample_search import candidates
from tracker_core.conventions import Gains
from tracker_core.manoeuvre import MANOEUVRES
from tracker_core.papers.proof import Chart, Proof
from tracker_core.papers.proofs.common import (
    bars,
    compare,
    digits,
    experiment_of,
    line,
    listed,
    plain,
    plane,
    pole_list,
    pole_series,
    results,
)
from tracker_core.poles import poles
from tracker_core.run import run_experiment
from tracker_core.stability import is_stable, stable
from tracker_core.types import FloatArray

PAPER = "yu2017"
_TURNED = np.array([0, Fraction(-1, 2), 1, -1])
"""What eq. 8 as printed turns into its negative at every sample, whatever the gains: it predicts no position."""

GRID = (4, 6, "interior")
"""Levels of alpha, beta, gamma; of eta; and where they lie: i/(m + 1) of each range."""


def _sets(order: int, bound: str) -> FloatArray:
    """The paper's grid, normalised gains; "printed" is beta < 13/6 (4 - 2 alpha), "triangle" beta < 4 - 2 alpha."""
    return candidates(order, *GRID, bound)[0]


def jury() -> Proof:
    """The bounds of eq. 10-12 and 21-24 admit gains that diverge, and leave out stable ones."""
    counts = {(order, b): int(stable(_sets(order, b)).sum()) for order in (3, 4) for b in ("triangle", "printed")}
    admitted = {order: _sets(order, "printed") for order in (3, 4)}
    largest = {
        order: max((poles(Gains.normalised(g)) for g in sets), key=lambda z: abs(z[0]))
        for order, sets in admitted.items()
    }
    example = Gains((1.0, 4.0, 0.1), "half")
    roots = poles(example)
    # All four poles at -1/2.
    left_out = Gains((15 / 16, 81 / 32, 27 / 4, 243 / 8), "half")
    bound = 24 * (2 - left_out.values[0])
    return Proof(
        "poles of the 64 and 384 sets i/(m + 1) of the ranges, with β < 13/6 (4 − 2α) as printed and β < 4 − 2α",
        (
            ("order 3: stable of 64, as printed", f"{counts[3, 'printed']}"),
            ("order 3: stable of 64, β < 4 − 2α", f"{counts[3, 'triangle']}"),
            ("order 4: stable of 384, as printed", f"{counts[4, 'printed']}"),
            ("order 4: stable of 384, β < 4 − 2α", f"{counts[4, 'triangle']}"),
            ("poles at α = 1, β = 4, γ = 0.1, admitted by eq. 10–12", pole_list(roots)),
            ("largest poles in the printed grid, orders 3 and 4", listed((abs(largest[3][0]), abs(largest[4][0])), 2)),
            ("poles at α = 15/16, β = 81/32, γ = 27/4, δ = 243/8", pole_list(poles(left_out), 2)),
            ("that δ, and the bound 24(2 − α) of eq. 24", listed((left_out.values[3], bound), 3)),
        ),
        holds=counts[3, "triangle"] == 64
        and counts[3, "printed"] < 64
        and max(counts[4, "printed"], counts[4, "triangle"]) < 384
        and abs(roots[0]) > 1
        and is_stable(left_out)
        and left_out.values[3] > bound,
        chart=plane(
            "Poles of gains that eq. 10–12 admit",
            pole_series("the printed grid, order 3", "observed", (z for g in admitted[3] for z in _roots(g))),
            pole_series("α = 1, β = 4, γ = 0.1", "bad", roots),
        ),
    )


def _roots(vector: FloatArray) -> tuple[complex, ...]:
    return poles(Gains.normalised(vector))


SAMPLE = 250
"""At which the objective is looked at: the middle of the run."""


def degenerate() -> Proof:
    """The objective of order 3 depends on gamma alone, that of order 4 on delta alone."""
    result = run_experiment(experiment_of(PAPER, "gamma-0.2"))
    interval = result.experiment.interval
    before, e = result.track.predicted[SAMPLE, 0], float(result.track.innovation[SAMPLE, 0])
    true = float(result.truth.states[SAMPLE, 0, 2])
    middle = np.array([0.8, 0.96, 0.512])
    shares = np.linspace(0.2, 1.8, 17)

    def objective(g: FloatArray) -> float:
        """|a_s - a_o| after the correction with normalised gains."""
        return abs(float((before + g * e / interval ** np.arange(3))[2]) - true)

    curves = {
        name: [objective(middle * np.where(np.arange(3) == i, share, 1)) for share in shares]
        for i, name in enumerate("αβγ")
    }
    bends = {name: (y[12] - 2 * y[8] + y[4]) / (0.4 * middle[i]) ** 2 for i, (name, y) in enumerate(curves.items())}
    sets = _sets(3, "triangle")
    gammas, ties = np.unique(sets[:, 2], return_counts=True)
    diverged = {ties: _diverged(ties) for ties in ("first", "last")}
    return Proof(
        "|a_s − a_o| with a_s = a_p + γe/(2T²), and the same search with either rule for ties",
        (
            ("range of |a_s − a_o| while α runs from 0.2 to 1.8 of its value", f"{digits(np.ptp(curves['α']))} m/s²"),
            ("the same for β", f"{digits(np.ptp(curves['β']))} m/s²"),
            ("the same for γ", f"{digits(np.ptp(curves['γ']))} m/s²"),
            ("λ₁ of the parabola through three points of α", digits(bends["α"])),
            ("different γ among the 64 sets; sets that share one, at most", f"{len(gammas)}; {ties.max()}"),
            ("order 4, jerk objective: runs of 5 that diverge, first of tied sets taken", str(diverged["first"])),
            ("the same, last of tied sets taken", str(diverged["last"])),
        ),
        holds=np.ptp(curves["α"]) == np.ptp(curves["β"]) == bends["α"] == 0 < np.ptp(curves["γ"])
        and len(gammas) < 64
        and diverged == {"first": 5, "last": 0},
        chart=Chart(
            f"The objective at sample {SAMPLE}, one gain moved",
            "gain, of its value",
            "|a_s − a_o|, m/s²",
            tuple(
                line(name, role, shares, values)
                for (name, values), role in zip(curves.items(), ("observed", "predicted", "smoothed"), strict=True)
            ),
        ),
    )


def _diverged(ties: str) -> int:
    """Runs of order 4 that are stopped: the jerk objective of section 3, the grid with beta < 4 - 2 alpha."""
    run = replace(experiment_of(PAPER, "delta-0.2"), objective="jerk", bound="triangle", ties=ties)
    return sum(result.track.stopped_at is not None for result in results(run, range(1, 6)))


def oracle() -> Proof:
    """With measurement noise the search that knows the true acceleration loses to a bank that knows nothing."""
    rows: dict[int, tuple[float, ...]] = {}
    for sigma in (1, 10, 50):
        gamma, delta = (experiment_of(PAPER, f"{name}-sigma-{sigma}") for name in ("gamma", "delta"))
        causal = delta.counterpart() or delta
        found = np.median(compare([gamma, delta, causal], "observation_rmse", "estimation_rmse"), axis=2) / sigma
        rows[sigma] = (float(found[0, 0]), *map(float, found[:, 1]))
    titles = ("raw measurement", "γ oracle", "δ oracle", "bank (causal)")
    roles = ("observed", "predicted", "bad", "counterpart")
    gamma_run = experiment_of(PAPER, "gamma-sigma-10")
    return Proof(
        "RMSE of the smoothed position over σ, T = 0.2 s, medians of 20 seeds: raw, γ oracle, δ oracle, causal bank",
        (
            ("what the search needs", gamma_run.hindsight),
            *((f"σ = {sigma} m: {', '.join(titles)}", listed(values, 3)) for sigma, values in rows.items()),
            ("δ oracle against the raw measurement", f"{' – '.join(_range(v[2] / v[0] for v in rows.values()))} times"),
            ("bank against the γ oracle", f"{' – '.join(_range(v[3] / v[1] for v in rows.values()))} times"),
        ),
        holds=bool(gamma_run.hindsight)
        and all(
            0.8 * raw < gamma < raw and 5 * raw < delta and bank < gamma for raw, gamma, delta, bank in rows.values()
        ),
        chart=Chart(
            "RMSE of the smoothed position, in σ",
            "",
            "RMSE/σ",
            tuple(
                bars(title, role, {f"σ = {sigma} m": values[i] for sigma, values in rows.items()})
                for i, (title, role) in enumerate(zip(titles, roles, strict=True))
            ),
        ),
    )


def _range(values: Iterable[float]) -> tuple[str, str]:
    sorted_values = sorted(values)
    return plain(sorted_values[0], 2), plain(sorted_values[-1], 2)


def misprints() -> Proof:
    """Eq. 6 and eq. 8 as printed leave no stable gains."""
    sets = _sets(3, "triangle")
    blind, delayed = (
        np.array([step(g) for g in sets], dtype=np.float64) for step in (_eq6_as_printed, _eq8_as_printed)
    )
    eigenvalues = {"6": np.linalg.eigvals(blind), "8": np.linalg.eigvals(delayed)}
    least = {name: float(np.abs(values).max(axis=1).min()) for name, values in eigenvalues.items()}
    products = np.abs(eigenvalues["6"]).prod(axis=1)
    exact = (_eq8_as_printed(np.array([Fraction(gain) for gain in g])) for g in sets)
    left = max(np.abs(step @ _TURNED + _TURNED).max() for step in exact)
    return Proof(
        "eigenvalues of the recursion with eq. 6, and with eq. 8, as printed, over the 64 sets with β < 4 − 2α",
        (
            ("sets that are stable as the equations are meant", f"{int(stable(sets).sum())} of 64"),
            ("eq. 6: product of all poles (1 − α if x_o is meant)", plain(float(products.mean()), 6)),
            ("eq. 6: smallest of the largest poles", plain(least["6"], 4)),
            ("eq. 8: greatest entry of (A + I)·(0, −½, 1, −1) in fractions, zero where −1 is a pole", str(left)),
            ("eq. 8: smallest of the largest poles", plain(least["8"], 4)),
        ),
        holds=bool(stable(sets).all())
        and np.allclose(products, 1)
        and least["6"] > 1
        and left == 0
        and least["8"] > 1 - 1e-9,
        chart=plane(
            "Poles of the 64 sets",
            pole_series("as eq. 8 prints it", "bad", map(complex, eigenvalues["8"].ravel())),
            pole_series("as it is meant", "smoothed", (z for g in sets for z in _roots(g))),
        ),
    )


def _eq6_as_printed(g: FloatArray) -> FloatArray:
    """x_s = x_p + alpha n: the state after one step without noise, target at 0, T = 1."""
    predict = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]])
    return predict - np.outer([0, g[1], g[2]], predict[0])


def _eq8_as_printed(g: FloatArray) -> FloatArray:
    """a_s(k) = a_p(k-1) + ...: the state is x_s, v_s, a_s and the a_p before, which eq. 5 makes the a_s before that.

    Exact for gains that are fractions.
    """
    predict = np.array([[1, 1, Fraction(1, 2), 0], [0, 1, 1, 0], [0, 0, 0, 1]])
    corrected = predict - np.outer(g, predict[0])
    return np.vstack((corrected, [0, 0, 1, 0]))


def manoeuvre() -> Proof:
    """The manoeuvre noise enters in three ways, one of which is no motion; and a filter that adds it cannot be run."""
    inputs = {
        "eq. 1": lambda t: (t**3 / 6, t**2 / 2, 1.0),
        "eq. 2": MANOEUVRES["acceleration-jumps"].input_vector,
        "eq. 3–5, 13–15": MANOEUVRES["jerk-pulses"].input_vector,
    }
    pushes = {name: vector(0.2) for name, vector in inputs.items()}
    shrink = {name: _per_acceleration(vector(0.2)) / _per_acceleration(vector(0.1)) for name, vector in inputs.items()}
    stream = np.random.default_rng(1)
    unknown, guessed = stream.standard_normal((2, 100_000))
    doubled = float(np.var(unknown - guessed) / np.var(unknown))
    return Proof(
        "what w(k) = 1 adds to position, velocity and acceleration at T = 0.2 s; displacement per acceleration",
        (
            *((f"{name}: adds to x, v, a", ", ".join(digits(v) for v in push)) for name, push in pushes.items()),
            *(
                (f"{name}: displacement per acceleration, T = 0.2 s over T = 0.1 s", plain(ratio, 1))
                for name, ratio in shrink.items()
            ),
            ("variance left by a w of one's own draws, over that of leaving w out", plain(doubled, 2)),
        ),
        holds=abs(shrink["eq. 1"] - 4) > 1
        and all(abs(shrink[name] - 4) < 1e-9 for name in ("eq. 2", "eq. 3–5, 13–15"))
        and len(set(pushes.values())) == 3
        and doubled > 1.9,
    )


def _per_acceleration(push: tuple[float, ...]) -> float:
    """Of a motion it goes with the square of the interval."""
    return push[0] / push[2]
