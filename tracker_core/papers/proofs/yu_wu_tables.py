"""Yu & Wu 2017: what is wrong with the tables, and what they rule out."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import sqrt

from tracker_core.noise import std_from_snr
from tracker_core.papers.proof import Chart, Proof
from tracker_core.papers.proofs.common import (
    agree,
    cell,
    exact,
    experiment_of,
    line,
    median,
    metres,
    plain,
    power,
    printed,
)
from tracker_core.run import observe

PAPER = "yu2017"
STEPS = ("0.2", "0.1", "0.05", "0.025", "0.0125")
"""Sampling intervals, s: the rows of every table."""

DURATION = 100.0


def swapped_digits() -> Proof:
    """Table 1's improvement at T = 0.025 s has two digits swapped."""
    found = {}
    for table in ("1", "2"):
        for step in STEPS:
            over, under = (exact(PAPER, table, step, column) for column in ("gamma", "delta"))
            found[table, step] = 100 * (over / under - 1)
    differ = [key for key, value in found.items() if not agree(cell(PAPER, *key, "improvement"), value)]
    return Proof(
        "100 (γ/δ − 1) of every row of tables 1 and 2",
        (
            (
                "L2 of γ and of δ at T = 0.025 s in table 1",
                " and ".join(f"{power(printed(PAPER, '1', '0.025', c), 4)} m" for c in ("gamma", "delta")),
            ),
            ("improvement recomputed", f"{plain(found['1', '0.025'], 1)} %"),
            ("improvement printed", f"{cell(PAPER, '1', '0.025', 'improvement')} %"),
            ("improvements that agree to the last digit", f"{len(found) - len(differ)} of {len(found)}"),
        ),
        holds=differ == [("1", "0.025")],
    )


def undefined() -> Proof:
    """What the printed errors rule out: RMS, mean square, and any noise with SNR = 5."""
    rows = [
        (float(step), printed(PAPER, "1", step, name), printed(PAPER, "2", step, name))
        for name in ("gamma", "delta")
        for step in STEPS
    ]
    no_rms = [greatest / sqrt(DURATION / step) > l2 for step, l2, greatest in rows]
    no_square = [l2 > greatest**2 for _, l2, greatest in rows]
    norm_over_n = [greatest * step / DURATION <= l2 <= greatest / sqrt(DURATION / step) for step, l2, greatest in rows]
    quiet = [
        replace(
            experiment_of(PAPER, f"{name}-0.0125"),
            noise="white",
            noise_std=(1e-4,),
            manoeuvre="none",
            manoeuvre_std=None,
        )
        for name in ("gamma", "delta")
    ]
    positions = observe(quiet[0])[0].positions
    sigma = [std_from_snr(positions, 5.0, decibel=decibel)[0] for decibel in (False, True)]
    found = [median(run, "estimation_l2", range(1, 6)) for run in quiet]
    there = [printed(PAPER, "1", "0.0125", name) for name in ("gamma", "delta")]
    return Proof(
        "a norm e of N = 100 s/T errors: max/√N ≤ RMS ≤ max, mean square ≤ max², max/N ≤ ‖e‖/N ≤ max/√N",
        (
            ("rows in which L_max/√N > L2: L2 is no RMS", f"{sum(no_rms)} of {len(rows)}"),
            ("rows in which L2 > L_max²: L2 is no mean square", f"{sum(no_square)} of {len(rows)}"),
            ("the greatest excess, δ at T = 0.0125 s: L2/L_max²", plain(there[1] / rows[-1][2] ** 2, 1)),
            ("rows in which ‖e‖/N is possible", f"{sum(norm_over_n)} of {len(rows)}"),
            ("SNR = 5: σ of x, as a ratio of powers; in dB", "; ".join(metres(value) for value in sigma)),
            ("L2 with σ = 0.1 mm alone, T = 0.0125 s: γ oracle; δ oracle", _lengths(found)),
            ("L2 printed there: γ; δ", _lengths(there)),
        ),
        holds=all(no_rms)
        and any(no_square)
        and all(norm_over_n)
        and min(sigma) > 1000
        and 3 * found[0] > there[0]
        and found[1] > 10 * there[1],
    )


def _lengths(values: list[float]) -> str:
    return "; ".join(f"{power(value)} m" for value in values)


SWAPPED = {
    ("3", "gamma-ratio"): ("1", "delta"),
    ("3", "delta-ratio"): ("2", "delta"),
    ("4", "gamma-ratio"): ("1", "gamma"),
    ("4", "delta-ratio"): ("2", "gamma"),
}
"""A column of ratios, and the table and the column whose ratios it prints."""


def swapped_columns() -> Proof:
    """The ratios of tables 3 and 4 stand in each other's places."""
    place = {"3": "1", "4": "2"}
    there = here = 0
    for (table, column), (source, name) in SWAPPED.items():
        for before, after in pairwise(STEPS):
            text = cell(PAPER, table, after, column)
            there += agree(text, _ratio(source, name, before, after))
            here += agree(text, _ratio(place[table], column.removesuffix("-ratio"), before, after))
    first = ("0.2", "0.1")
    return Proof(
        "the error at one T over that at the next, of the four columns of tables 1 and 2",
        (
            ("table 3 beside γ, T = 0.1 s, printed", cell(PAPER, "3", "0.1", "gamma-ratio")),
            ("L2 of γ, ratio", plain(_ratio("1", "gamma", *first), 2)),
            ("L2 of δ, ratio", plain(_ratio("1", "delta", *first), 2)),
            ("table 3: δ's L2 and δ's L_max; table 4: γ's L2 and γ's L_max", f"{there} of 16 cells agree"),
            ("as the columns are headed", f"{here} of 16 cells agree"),
        ),
        holds=there == 16 and here < 8,
    )


def _ratio(table: str, column: str, before: str, after: str) -> float:
    return float(exact(PAPER, table, before, column) / exact(PAPER, table, after, column))


def monotone() -> Proof:
    """The improvements and ratios do not grow steadily as the step shrinks."""
    columns = [("1", "improvement"), ("2", "improvement"), *SWAPPED]
    values = {
        (table, column): [printed(PAPER, table, step, column) for step in STEPS[table in "34" :]]
        for table, column in columns
    }
    falls = {key: sum(after < before for before, after in pairwise(v)) for key, v in values.items()}
    names = {"improvement": "improvement, %", "gamma-ratio": "first ratio", "delta-ratio": "second ratio"}
    return Proof(
        "each printed column from T = 0.2 s (ratios: 0.1 s) down to 0.0125 s",
        tuple(
            (
                f"table {table}, {names[column]}: falls",
                f"{falls[table, column]} of {len(v) - 1} times ({' → '.join(f'{value:g}' for value in v)})",
            )
            for (table, column), v in values.items()
        ),
        holds=min(falls.values()) >= 1,
        chart=Chart(
            "The printed ratios from step to step",
            "sampling interval reached, s",
            "ratio",
            tuple(
                line(f"table {table}, {names[column]}", role, map(float, STEPS[1:]), values[table, column])
                for (table, column), role in zip(
                    SWAPPED, ("predicted", "smoothed", "observed", "counterpart"), strict=True
                )
            ),
        ),
    )
