"""Al-Wagih & Abdulla: the paired t-test of section 7, carried out on the printed errors."""

from __future__ import annotations

from collections.abc import Iterable
from math import sqrt

import numpy as np

from tracker_core.papers.proof import Chart, Proof
from tracker_core.papers.proofs.alwagih import COLOURS, METHODS, PAPER
from tracker_core.papers.proofs.common import bars, digits, plain, printed

OLD, NEW = METHODS[:2], METHODS[2:]
SETS = range(1, 6)


def significance() -> Proof:
    """Many of the differences may be chance, and some that are not are losses."""
    tests = {
        f"{base.upper()}−{new.upper()} {axis} ({table})": _paired_t(table, base, new, axis)
        for table in COLOURS.values()
        for base in OLD
        for axis in "xy"
        for new in NEW
    }
    levels = {name: _two_sided(t) for name, t in tests.items()}
    chance = [name for name, p in levels.items() if p > 0.05]
    clear = [name for name, p in levels.items() if p < 0.001]
    losses = [name for name in clear if tests[name] < 0]
    return Proof(
        "t = √5·d̄/s of the five differences d of RMSE, and p = P(|t₄| > |t|), from the cells of tables 1 and 2",
        (
            ("differences, two old methods against three new, x and y, both tables", str(len(tests))),
            ("not significant at 5 %", f"{len(chance)} of {len(tests)}"),
            *(
                (f"p of these in {axis}", _listed(levels[name] for name in chance if f" {axis} " in name))
                for axis in "xy"
            ),
            ("significant at 0.1 %", f"{len(clear)} of {len(tests)}"),
            ("of these losses", "; ".join(f"{name}, t = {plain(tests[name])}" for name in losses)),
        ),
        holds=len(chance) >= len(tests) / 4 and len(clear) < len(tests) / 2 and len(losses) > 0,
        chart=Chart(
            "How probable chance alone makes such a difference",
            "methods, axis (table)",
            "p",
            (bars("differences with p > 0.05", "bad", {name: levels[name] for name in chance}),),
        ),
    )


def _listed(levels: Iterable[float]) -> str:
    return ", ".join(digits(level, 2) for level in sorted(levels))


def _paired_t(table: str, base: str, new: str, axis: str) -> float:
    """Mean difference over its standard error."""
    pairs = [[printed(PAPER, table, f"{k}-{axis}", name) for name in (base, new)] for k in SETS]
    differences = -np.diff(pairs, axis=1)[:, 0]
    return float(differences.mean() / (differences.std(ddof=1) / sqrt(len(SETS))))


def _two_sided(t: float) -> float:
    """P(|t₄| > |t|), Student's distribution with four degrees of freedom in closed form."""
    sine = abs(t) / sqrt(4 + t * t)
    return 1 - sine * (3 - sine * sine) / 2
