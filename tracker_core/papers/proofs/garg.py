"""Garg 2021: the start of the listing, and what its observations say."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tracker_core.analysis import steady_lag
from tracker_core.conventions import Gains
from tracker_core.design import DESIGNS
from tracker_core.filters import run_filter
from tracker_core.papers.proof import Chart, Proof
from tracker_core.papers.proofs.common import (
    agree,
    cell,
    experiment_of,
    line,
    listed,
    metres,
    plain,
    printed,
    with_gains,
)
from tracker_core.responses import variance_reduction
from tracker_core.run import run_experiment
from tracker_core.scenarios.garg import INTERVAL, RANGE
from tracker_core.stability import assess, is_stable

PAPER = "garg2021"
ACCELERATION = 8.0
"""Of the aircraft, m/s^2."""

ROWS = tuple(str(i) for i in range(1, 11))


def start() -> Proof:
    """Only a start with 50 m/s gives the example's table."""
    run = experiment_of(PAPER, "accelerating-earlier")
    measurements = run_experiment(run).measurements
    texts = [cell(PAPER, "accelerating-earlier", row, "x") for row in ROWS]
    found = {
        speed: run_filter(
            measurements, run.gains(), start="known", initial_state=np.array([[RANGE, speed, 0.0]])
        ).smoothed[:, 0, 0]
        for speed in (40.0, 50.0)
    }
    same = {
        speed: sum(agree(text, float(x)) for text, x in zip(texts, track, strict=True))
        for speed, track in found.items()
    }
    table = np.array([printed(PAPER, "accelerating-earlier", row, "x") for row in ROWS])
    return Proof(
        "the α-β-γ listing on the ranges of the earlier edition, started with 40 and with 50 m/s",
        (
            ("first three positions of the example's table", f"{', '.join(texts[:3])} m"),
            ("started with 50 m/s", f"{listed(found[50.0][:3], 1)} m"),
            ("started with 40 m/s, as listed", f"{listed(found[40.0][:3], 1)} m"),
            ("positions that agree, 50 m/s", f"{same[50.0]} of 10"),
            ("positions that agree, 40 m/s", f"{same[40.0]} of 10"),
        ),
        holds=same == {40.0: 0, 50.0: 10},
        chart=Chart(
            "Smoothed position minus the example's table",
            "sample",
            "difference, m",
            (
                line("started with 40 m/s", "bad", range(1, 11), found[40.0] - table),
                line("started with 50 m/s", "smoothed", range(1, 11), found[50.0] - table),
            ),
        ),
    )


ALPHAS = (0.5, 0.8, 0.95, 0.99)


def lag() -> Proof:
    """Near alpha = 1 the smoothed position hardly lags; the prediction does."""
    run = experiment_of(PAPER, "accelerating")
    lines, smoothed, ahead, agree = [], [], [], []
    for alpha in ALPHAS:
        gains = _benedict_bordner(alpha)
        theory = [steady_lag(gains, INTERVAL, ACCELERATION, predicted=predicted) for predicted in (False, True)]
        agree.append(np.allclose(theory, _measured_lag(gains), rtol=1e-9))
        smoothed.append(theory[0])
        ahead.append(theory[1])
        lines.append((f"α = {alpha}: smoothed; predicted", f"{metres(theory[0], 1)}; {metres(theory[1], 1)}"))
    slow = [steady_lag(Gains((alpha, 0.1)), INTERVAL, ACCELERATION) for alpha in ALPHAS]
    recorded = run_experiment(with_gains(run, _benedict_bordner(0.95))).metrics
    curve = np.arange(40, 100) / 100
    both = [
        [steady_lag(_benedict_bordner(float(a)), INTERVAL, ACCELERATION, predicted=p) for a in curve]
        for p in (False, True)
    ]
    return Proof(
        "steady lags (1 − α)T²A/β and T²A/β, T = 5 s, A = 8 m/s², β = α²/(2 − α); on the recorded ranges, RMSE",
        (
            *lines,
            ("smoothed with β = 0.1, α = 0.5 … 0.99", f"{listed(slow, 0)} m"),
            (
                "recorded, α = 0.95: smoothed; predicted; measured",
                "; ".join(
                    metres(value or 0.0, 1)
                    for value in (recorded.estimation_rmse, recorded.tracking_rmse, recorded.observation_rmse)
                ),
            ),
        ),
        holds=all(agree)
        and smoothed == sorted(smoothed, reverse=True)
        and smoothed[-1] < 0.01 * ahead[-1] * 1.01
        and min(ahead) > 200
        and (recorded.estimation_rmse or np.inf) < (recorded.observation_rmse or 0) < (recorded.tracking_rmse or 0),
        chart=Chart(
            "Steady lag at 8 m/s², β of Benedict and Bordner",
            "α",
            "lag, m",
            (line("smoothed", "smoothed", curve, both[0]), line("predicted", "predicted", curve, both[1])),
        ),
    )


def _benedict_bordner(alpha: float) -> Gains:
    return Gains.normalised(DESIGNS["benedict-bordner"].gains(2, alpha=alpha))


def _measured_lag(gains: Gains) -> list[float]:
    """Of a run without noise, long after the acceleration has begun: smoothed and predicted position, m."""
    quiet = with_gains(replace(experiment_of(PAPER, "accelerating"), noise="none", samples=120), gains)
    result = run_experiment(quiet)
    true = float(result.truth.states[-1, 0, 0])
    return [true - float(states[-1, 0, 0]) for states in (result.track.smoothed, result.track.predicted)]


def precision() -> Proof:
    """What decides alpha is the tracking index, not the sensor alone."""
    two, three = (_index_of_a_half(design, order) for design, order in (("kalata", 2), ("gray-murray", 3)))
    cases = {
        "precise sensor (1 m), steady target (σ_w = 0.001 m/s²)": _alpha(0.001, 1.0),
        "precise sensor (1 m), manoeuvring target (σ_w = 8 m/s²)": _alpha(8.0, 1.0),
        "poor sensor (100 m), steady target (σ_w = 0.001 m/s²)": _alpha(0.001, 100.0),
        "poor sensor (100 m), manoeuvring target (σ_w = 8 m/s²)": _alpha(8.0, 100.0),
    }
    values = list(cases.values())
    still = [float(variance_reduction(_kalata_with(alpha)).smoothed[0]) for alpha in (0.1, 0.3, 0.5, 0.7, 0.9)]
    indices = np.geomspace(1e-3, 100, 101)
    curve = [float(DESIGNS["kalata"].gains(2, tracking_index=float(index))[0]) for index in indices]
    return Proof(
        "α of the optimal filter (Kalata) from Λ = σ_w T²/σ_v, T = 5 s",
        (
            ("Λ at which α = 0.5: α-β; α-β-γ", f"{plain(two, 4)}; {plain(three, 4)}"),
            *((f"α: {name}", plain(alpha, 3)) for name, alpha in cases.items()),
            ("no manoeuvre: noise variance left at α = 0.1, 0.3, 0.5, 0.7, 0.9", listed(still, 3)),
        ),
        holds=values[0] < 0.5 < values[3] and values[2] < values[0] < values[1] and still == sorted(still),
        chart=Chart(
            "Optimal α of the α-β filter",
            "log₁₀ Λ",
            "α",
            (
                line("Kalata", "smoothed", np.log10(indices), curve),
                line("α = 0.5", "marker", (-3, float(np.log10(two)), 2), (0.5, 0.5, 0.5)),
            ),
        ),
    )


def _index_of_a_half(design: str, order: int) -> float:
    """Where alpha passes 1/2, by bisection."""
    low, high = 1e-6, 1e3
    for _ in range(100):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if DESIGNS[design].gains(order, tracking_index=middle)[0] < 0.5 else (low, middle)
    return low


def _alpha(process_std: float, sensor_std: float) -> float:
    return float(DESIGNS["kalata"].gains(2, tracking_index=process_std * INTERVAL**2 / sensor_std)[0])


def _kalata_with(alpha: float) -> Gains:
    return Gains((alpha, 2 * (2 - alpha) - 4 * (1 - alpha) ** 0.5))


def third_gain() -> Proof:
    """A larger gamma does help on the ten ranges, past the border of stability."""
    alpha, beta, gamma = experiment_of(PAPER, "accelerating").gains().values
    # 2 gamma (2 - alpha) = 2 alpha beta
    border = alpha * beta / (2 - alpha)
    gammas = [k / 100 for k in range(51)]
    within = max(g for g in gammas if g < border)
    editions = {"accelerating": "later", "accelerating-earlier": "earlier"}
    found = {run: {g: _third(run, gamma=g) for g in gammas} for run in editions}
    best = {run: min((_third(run, gamma=k / 1000), k / 1000) for k in range(200, 320)) for run in editions}
    last = best["accelerating"][1]
    longer = [_third("accelerating", gamma=g, noise="none", samples=40) for g in (gamma, last)]
    quicker = {run: _third(run, alpha=0.8) for run in editions}
    return Proof(
        "RMSE of the smoothed position on the ten ranges of both editions, α = 0.5, β = 0.4, γ from 0 to 0.5",
        (
            ("γ below which the filter is stable, αβ/(2 − α)", plain(border, 4)),
            *(
                (
                    f"{title} ranges, γ = {gamma}; {within}; {best[run][1]}, the best",
                    _lengths(found[run][gamma], found[run][within], best[run][0]),
                )
                for run, title in editions.items()
            ),
            (f"largest pole at γ = {last}", plain(assess(Gains((alpha, beta, last), "taylor")).spectral_radius, 3)),
            (f"forty samples without noise, γ = {gamma}; {last}", _lengths(*longer)),
            ("α = 0.8 and γ = 0.1, stable: later; earlier ranges", _lengths(*quicker.values())),
        ),
        holds=all(found[run][gamma] > found[run][within] > best[run][0] for run in editions)
        and all(g > border for _, g in best.values())
        and not is_stable(Gains((alpha, beta, last), "taylor"))
        and longer[1] > 10 * longer[0]
        and is_stable(Gains((0.8, beta, gamma), "taylor"))
        and all(quicker[run] < found[run][within] for run in editions),
        chart=Chart(
            "RMSE of the smoothed position against γ",
            "γ",
            "RMSE, m",
            (
                line("later ranges", "smoothed", gammas, found["accelerating"].values()),
                line("earlier ranges", "predicted", gammas, found["accelerating-earlier"].values()),
                line("border of stability", "bad", (border, border), (0.0, max(found["accelerating"].values()))),
            ),
        ),
    )


def _third(run: str, **changes: Any) -> float:
    """RMSE of the smoothed position, m; infinite where there is none."""
    value = run_experiment(replace(experiment_of(PAPER, run), **changes)).metrics.estimation_rmse
    return np.inf if value is None else value


def _lengths(*values: float) -> str:
    return "; ".join(metres(value, 1) for value in values)
