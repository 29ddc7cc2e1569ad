"""Jeong, Njonjo & Pan 2017: what is wrong with the gains and the equations they are put into."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np

from tracker_core.consistency import model_covariance
from tracker_core.conventions import Gains
from tracker_core.design import DESIGNS
from tracker_core.experiment import Experiment
from tracker_core.papers.printed import number
from tracker_core.papers.proof import Chart, Proof
from tracker_core.papers.proofs.common import (
    HUNDRED,
    agree,
    bars,
    cell,
    compare,
    digits,
    experiment_of,
    listed,
    metres,
    plain,
    plane,
    pole_list,
    pole_series,
    power,
    printed,
    results,
    with_gains,
)
from tracker_core.poles import poles
from tracker_core.types import FloatArray

PAPER = "jeong2017"
FEW = range(1, 6)


def zero_gamma() -> Proof:
    """Eq. 8 with the beta of eq. 7 leaves no gamma."""
    alpha = Fraction(86, 100)
    rational = 2 * (2 * (alpha**2 / (2 - alpha)) / alpha - alpha - alpha**2 / (2 - alpha))
    others = [_third_gain(Fraction(k, 50)) for k in range(1, 100)]
    a = 0.86
    b = a / (2 - a) * a
    rounded = 4 / a * b - 2 * (a + b)
    plain_run = experiment_of(PAPER, "benedict-bordner")
    with_it = with_gains(plain_run, Gains((a, b, rounded), "taylor"))
    apart = max(
        float(np.nanmax(np.abs(one.track.smoothed[:, :, 0] - other.track.smoothed[:, :, 0])))
        for one, other in zip(results(plain_run, FEW), results(with_it, FEW), strict=True)
    )
    return Proof(
        "γ = 2(2β/α − α − β) with β = α²/(2 − α), in fractions and in floating point",
        (
            ("γ at α = 43/50 in fractions", str(rational)),
            ("greatest |γ| at α = 1/50, 2/50 … 99/50 in fractions", str(max(map(abs, others)))),
            ("γ at α = 0.86 in double precision, as (4/α)·β − 2(α + β)", power(rounded, 4)),
            ("2⁻⁵¹, two units in the last place of 1", power(2.0**-51, 4)),
            ("γ printed in table 1", cell(PAPER, "1", "benedict-bordner", "gamma")),
            ("farthest that this γ moves a smoothed position in 1,000 samples", f"{power(apart, 0)} m"),
        ),
        holds=rational == 0
        and not any(others)
        and rounded == 2.0**-51
        and agree(cell(PAPER, "1", "benedict-bordner", "gamma"), rounded)
        and apart < 1e-6,
    )


def _third_gain(alpha: Fraction) -> Fraction:
    beta = alpha**2 / (2 - alpha)
    return 2 * (2 * beta / alpha - alpha - beta)


def precedence() -> Proof:
    """Table 2's gamma is eq. 13 with its fraction read from left to right."""
    alpha, beta = (printed(PAPER, "2", "gray-murray", gain) for gain in ("alpha", "beta"))
    text, total = cell(PAPER, "2", "gray-murray", "gamma"), printed(PAPER, "5", "gray-murray", "tracking")
    wrong, right = beta**2 / 2 * alpha, beta**2 / (2 * alpha)
    run = experiment_of(PAPER, "gray-murray")
    gammas = (round(wrong, 4), round(right, 4))
    filters = [with_gains(run, Gains((alpha, beta, gamma), "taylor")) for gamma in gammas]
    (bad,), (good,) = compare(filters, "tracking_total", seeds=HUNDRED)
    medians = [float(np.median(totals)) for totals in (bad, good)]
    return Proof(
        "γ = β²/2·α from left to right and γ = β²/(2α), and the ship tracked with both (100 seeds)",
        (
            ("β²/2·α of table 2's α and β", plain(wrong, 4)),
            ("β²/(2α), eq. 13", plain(right, 4)),
            ("γ printed in table 2", text),
            (f"total tracking error with γ = {gammas[0]}, median", metres(medians[0])),
            (f"total tracking error with γ = {gammas[1]}, median", metres(medians[1])),
            ("total tracking error printed in table 5", metres(total)),
        ),
        holds=agree(text, wrong)
        and not agree(text, right)
        and bad.min() > 1.9 * total
        and abs(medians[1] / total - 1) < 0.1,
        chart=Chart(
            "Total tracking error of table 2's filter",
            "",
            "total, m",
            (
                bars("recomputed", "predicted", {f"γ = {g}": v for g, v in zip(gammas, medians, strict=True)}),
                bars("printed", "marker", {"table 5": total}),
            ),
        ),
    )


def discounting() -> Proof:
    """Table 3 is computed from another xi than the text gives."""
    texts = [cell(PAPER, "3", "fading-memory", gain) for gain in ("alpha", "beta", "gamma")]
    gains = {xi: DESIGNS["fading-memory"].gains(3, xi=xi) for xi in (0.64, 0.62)}
    same = {xi: [agree(*pair) for pair in zip(texts, map(float, vector), strict=True)] for xi, vector in gains.items()}
    behind = 1 - float(number(texts[0]))
    return Proof(
        "α = 1 − ξ³, β = 1.5(1 − ξ)²(1 + ξ), γ = (1 − ξ)³ at ξ = 0.62 and at 0.64",
        (
            ("α, β, γ printed in table 3", ", ".join(texts)),
            ("at ξ = 0.64", listed(gains[0.64], 4)),
            ("at ξ = 0.62, as section 4.3.3 and table 6 say", listed(gains[0.62], 4)),
            ("ξ = ∛(1 − α) of the printed α", plain(behind ** (1 / 3), 4)),
            ("printed gains that agree with ξ = 0.64", f"{sum(same[0.64])} of 3"),
            ("printed gains that agree with ξ = 0.62", f"{sum(same[0.62])} of 3"),
        ),
        holds=all(same[0.64]) and not any(same[0.62]),
    )


def doubled_gain() -> Proof:
    """Eq. 6 doubles the acceleration gain of eq. 16."""
    run = experiment_of(PAPER, "fading-memory")
    proper = Gains.normalised(DESIGNS["fading-memory"].gains(3, xi=0.64))
    roots, equal = poles(run.gains()), poles(proper)
    designed = with_gains(run, proper)
    metrics = ("tracking_total", "estimation_total")
    totals = dict(zip(metrics, np.median(compare([run, designed], *metrics, seeds=HUNDRED), axis=2).T, strict=True))
    return Proof(
        "poles of (α, β, 2γ) and of (α, β, γ), γ = (1 − ξ)³, ξ = 0.64 (medians of 100 seeds)",
        (
            ("poles with 2γ/T², as eq. 6 says", pole_list(roots)),
            ("their magnitudes", listed(map(abs, roots), 3)),
            ("poles with γ/T², as eq. 16 needs", listed((pole.real for pole in equal), 3)),
            *(
                (f"total {metric.removesuffix('_total')} error with 2γ/T²; with γ/T²", "; ".join(map(metres, pair)))
                for metric, pair in totals.items()
            ),
        ),
        holds=max(abs(pole - 0.64) for pole in equal) < 1e-4
        and min(abs(pole - 0.64) for pole in roots) > 0.1
        and all(as_run < as_designed for as_run, as_designed in totals.values()),
        chart=plane("Poles at ξ = 0.64", pole_series("2γ/T²", "bad", roots), pole_series("γ/T²", "smoothed", equal)),
    )


def conventions() -> Proof:
    """Eq. 27-28 are normalised gains, eta over six; eq. 23-24 divide them once more."""
    return _readings("γ/2T², η/6T³ (eq. 23–24)", "of eq. 23–28")


def fragment() -> Proof:
    """Eq. 11-12 of the fragment are the same gains; its eq. 7-8 cannot be read."""
    return _readings("γ/2T², η/6T³", "of eq. 7–8 with the gains of eq. 9–12")


def _readings(divided: str, of: str) -> Proof:
    """Three ways to apply the gains, of which the first divides them by two and six."""
    readings: dict[str, tuple[str, Callable[[FloatArray], FloatArray]]] = {
        divided: ("bad", lambda g: g * (1, 1, 1 / 2, 1 / 36)),
        "2γ/T², 6η/T³": ("predicted", lambda g: g * (1, 1, 2, 1)),
        "γ/T², 6η/T³ (fading memory)": ("smoothed", lambda g: g * (1, 1, 1, 1)),
    }
    found, best = {}, {}
    for name, (_, reading) in readings.items():
        found[name] = poles(Gains.normalised(reading(_fading(0.74))))
        best[name] = _best_xi(reading)
    filters = [_reading(reading, 0.74) for _, reading in list(readings.values())[:2]]
    at_printed = np.median(compare(filters, "tracking_total", seeds=HUNDRED), axis=2)[:, 0]
    spread = [max(abs(pole - 0.74) for pole in roots) for roots in found.values()]
    return Proof(
        f"poles at ξ = 0.74 of three readings {of}, and the ξ of the least total tracking error (5 seeds)",
        (
            *((f"poles, {name}", pole_list(roots)) for name, roots in found.items()),
            *((f"best ξ, {name}", plain(xi, 2)) for name, xi in best.items()),
            ("ξ printed as the best", cell(PAPER, "6", "order-4", "xi")),
            (f"total tracking error at ξ = 0.74: {divided}; 2γ/T², 6η/T³", "; ".join(map(metres, at_printed))),
        ),
        holds=spread[2] < 1e-3
        and min(spread[:2]) > 0.1
        and abs(best["2γ/T², 6η/T³"] - printed(PAPER, "6", "order-4", "xi")) < 0.03
        and best[divided] < 0.7,
        chart=plane(
            "Poles at ξ = 0.74", *(pole_series(name, readings[name][0], roots) for name, roots in found.items())
        ),
    )


def _fading(xi: float) -> FloatArray:
    """Normalised; eq. 28's eta is a sixth of the last one."""
    return DESIGNS["fading-memory"].gains(4, xi=xi)


def _best_xi(reading: Callable[[FloatArray], FloatArray]) -> float:
    """With the least median of the total tracking error, on a grid of 0.01."""
    grid = [k / 100 for k in range(60, 77)]
    totals = np.median(compare([_reading(reading, xi) for xi in grid], "tracking_total", seeds=FEW), axis=2)
    return grid[int(totals.argmin())]


def _reading(reading: Callable[[FloatArray], FloatArray], xi: float) -> Experiment:
    """The ship tracked with the gains that a reading makes of the design's."""
    return with_gains(experiment_of(PAPER, "jerk"), Gains.normalised(reading(_fading(xi))))


def gray_murray() -> Proof:
    """What the paper calls Gray-Murray is not the optimum for its tracking index."""
    index = experiment_of(PAPER, "gray-murray").tracking_index or 0.0
    names = ("gray-murray", "jeong-gray-murray", "jeong-gray-murray-as-run")
    gains = [DESIGNS[name].gains(3, tracking_index=index) for name in names]
    models = [model_covariance(Gains.normalised(vector), index) for vector in gains]
    variances = [float(model.smoothed[0, 0]) for model in models]
    ahead = [float(model.predicted[0, 0]) for model in models]
    run = experiment_of(PAPER, "gray-murray")
    filters = [replace(run, design=name) for name in (names[0], names[2])]
    ship = np.median(compare(filters, "tracking_total", seeds=HUNDRED), axis=2)[:, 0]
    kalata = DESIGNS["kalata"].gains(2, tracking_index=index)
    titles = ("Gray & Murray's equation", "eq. 10–13, γ/T²", "eq. 10–13, 2γ/T²")
    return Proof(
        f"steady variance of the position, per σ_v², on the model with increments of acceleration, Λ = {digits(index)}",
        (
            *((f"α, β, γ: {title}", listed(vector, 4)) for title, vector in zip(titles[:2], gains, strict=False)),
            ("α, β of Kalata's filter of order 2", listed(kalata, 4)),
            *(
                (f"variances, smoothed; predicted: {title}", f"{plain(smoothed, 3)}; {plain(predicted, 2)}")
                for title, smoothed, predicted in zip(titles, variances, ahead, strict=True)
            ),
            ("the ship, total tracking error: Gray & Murray's equation; as run", "; ".join(map(metres, ship))),
        ),
        holds=variances[0] < min(variances[1:])
        and ahead[0] < min(ahead[1:])
        and bool((gains[1][:2] == kalata).all())
        and float(abs(gains[0] - gains[1]).max()) > 0.1,
        chart=Chart(
            "Variance of the smoothed position",
            "",
            "per variance of the measurement",
            (bars("Λ = " + digits(index), "smoothed", dict(zip(titles, variances, strict=True))),),
        ),
    )
