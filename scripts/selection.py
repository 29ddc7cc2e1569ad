"""Writes docs/selection-figures.md, what the selection methods came to: `python scripts/selection.py`."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from scripts.reference import table  # noqa: E402
from tracker_core import Experiment, Metrics, run_experiment  # noqa: E402
from tracker_core.papers import papers  # noqa: E402
from tracker_core.papers.printed import number  # noqa: E402

TARGET = ROOT / "docs" / "selection-figures.md"
SETS = range(1, 6)
SEEDS = range(1, 21)
INTERVALS = ("0.2", "0.1", "0.05", "0.025", "0.0125")
METHODS = ("m1", "m2", "m3", "m4", "m5", "m5-causal")
TITLES = ("M1", "M2", "M3", "M4", "M5", "M5c")


def figures() -> str:
    """The whole page."""
    runs = {f"{paper.name}/{run.name}": run.experiment for paper in papers().values() for run in paper.runs}
    cells = {interval: _yu_wu(runs, interval) for interval in INTERVALS}
    parts = [
        "# What the selection methods came to",
        "",
        "Written by `scripts/selection.py`; [what the methods are](selection.md).",
        "",
        "## Ten data sets after Al-Wagih & Abdulla: RMSE of the prediction, m",
        "",
        "Seeds 1 to 5 with white and with coloured noise (AR(1), ρ = 0.45), σ = 15 m. M1 to M5 as in the paper, M5c is",
        "M5 by past innovations.",
        "",
    ]
    for colour in ("white", "coloured"):
        parts += table(["noise", "set", "axis", *TITLES], _ten(runs, colour))
    parts += [
        "Change of the RMSE against M1, percent of it, mean of the five sets (eq. 27; positive is better):",
        "",
        *table(["noise", "axis", *TITLES[1:]], _changes(runs)),
        "## Yu & Wu: the reconstruction",
        "",
        "The cells of tables 1 and 2, printed and found, stand in [the papers, recomputed](papers.md).",
        f"Root mean square of log10(found/printed) over the twenty cells: {_distance(cells):.3f}.",
        "",
        "## The same oracles with measurement noise: RMSE of the smoothed position in σ, medians of seeds 1 to 20",
        "",
        "T = 0.2 s, no manoeuvre noise; the raw measurement of two axes has √2 σ.",
        "",
        *table(
            ["σ, m", "raw", "γ oracle", "δ oracle", "bank of critically damped filters (causal)"],
            [_noisy(runs, sigma) for sigma in (1, 10, 50)],
        ),
    ]
    return "\n".join(parts)


def _axes(experiment: Experiment, seed: int) -> list[float]:
    return [float(m.tracking_rmse or np.nan) for m in run_experiment(replace(experiment, seed=seed)).axis_metrics()]


def _ten(runs: dict[str, Experiment], colour: str) -> list[list[str]]:
    rows = []
    for seed in SETS:
        values = np.array([_axes(runs[f"alwagih/{name}-{colour}"], seed) for name in METHODS])
        rows += [[colour, str(seed), axis, *(f"{v:.1f}" for v in values[:, i])] for i, axis in enumerate("xy")]
    return rows


def _changes(runs: dict[str, Experiment]) -> list[list[str]]:
    rows = []
    for colour in ("white", "coloured"):
        values = np.array([[_axes(runs[f"alwagih/{name}-{colour}"], seed) for seed in SETS] for name in METHODS])
        change = (100 * (values[0] - values) / values[0]).mean(axis=1)
        rows += [[colour, axis, *(f"{v:.1f}" for v in change[1:, i])] for i, axis in enumerate("xy")]
    return rows


def _metrics(experiment: Experiment) -> list[Metrics]:
    return [run_experiment(replace(experiment, seed=seed)).metrics for seed in SEEDS]


def _yu_wu(runs: dict[str, Experiment], interval: str) -> list[float]:
    """Gamma L2, delta L2, gamma Lmax, delta Lmax, found."""
    found = {name: _metrics(runs[f"yu2017/{name}-{interval}"]) for name in ("gamma", "delta")}
    return [
        float(np.median([getattr(metrics, figure) for metrics in found[name]]))
        for figure in ("estimation_l2", "estimation_max")
        for name in ("gamma", "delta")
    ]


def _printed(interval: str) -> list[float]:
    """The same, printed."""
    tables = papers()["yu2017"].tables
    return [float(number(table.printed(interval, name))) for table in tables[:2] for name in ("gamma", "delta")]


def _distance(cells: dict[str, list[float]]) -> float:
    ratios = [np.log10(np.array(cells[interval]) / _printed(interval)) for interval in INTERVALS]
    return float(np.sqrt(np.mean(np.square(ratios))))


def _noisy(runs: dict[str, Experiment], sigma: int) -> list[str]:
    oracles = [runs[f"yu2017/{name}-sigma-{sigma}"] for name in ("gamma", "delta")]
    bank = oracles[1].counterpart()
    found = [_metrics(experiment) for experiment in (*oracles, *([bank] if bank else ()))]
    raw = float(np.median([metrics.observation_rmse for metrics in found[0]]))
    cells = [float(np.median([metrics.estimation_rmse for metrics in group])) for group in found]
    return [str(sigma), *(f"{cell / sigma:.3f}" for cell in (raw, *cells))]


if __name__ == "__main__":
    TARGET.write_text(figures(), encoding="utf-8")
