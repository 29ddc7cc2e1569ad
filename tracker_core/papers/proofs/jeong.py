"""Jeong, Njonjo & Pan 2017: what is wrong with the totals and the searches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tracker_core.papers.printed import half_unit
from tracker_core.papers.proof import Chart, Proof
from tracker_core.papers.proofs.common import (
    HUNDRED,
    bars,
    cell,
    compare,
    decade,
    exact,
    experiment_of,
    line,
    listed,
    median,
    metres,
    plain,
    power,
    printed,
)
from tracker_core.types import FloatArray

PAPER = "jeong2017"
FILTERS = {"benedict-bordner": "Benedict–Bordner", "gray-murray": "Gray–Murray", "fading-memory": "fading memory"}


def differences() -> Proof:
    """The improvements that the text prints are not those of its table."""
    lines, apart = [], []
    for column, title in (("tracking", "tracking"), ("estimation", "estimation")):
        three, four = (exact(PAPER, "6", row, column) for row in ("order-3", "order-4"))
        text = cell(PAPER, "6", "improvement", column)
        found = three - four
        lines += [
            (f"{title}: {three:,} m − {four:,} m", metres(found)),
            (f"{title}: improvement printed in section 5.2", f"{text} m"),
        ]
        # What two totals rounded to whole metres may hide.
        apart.append(abs(found - exact(PAPER, "6", "improvement", column)) - 2 * half_unit("1"))
    return Proof(
        "differences of table 6's totals, and what section 5.2 prints for them",
        (
            *lines,
            ("what rounding to whole metres explains at most", metres(2 * half_unit("1"))),
            ("what is left unexplained", " and ".join(metres(value, 2) for value in apart)),
        ),
        holds=min(apart) > 0,
    )


def tracking_total() -> Proof:
    """The Benedict-Bordner tracking total of table 5 is a total of innovations."""
    total = printed(PAPER, "5", "benedict-bordner", "tracking")
    run = experiment_of(PAPER, "benedict-bordner")
    starts = {"two points": run, "the first sample": replace(run, start="first")}
    found = compare(list(starts.values()), "tracking_total", "innovation_total", seeds=HUNDRED)
    errors, innovations = (dict(zip(starts, totals, strict=True)) for totals in found.transpose(1, 0, 2))
    return Proof(
        "Σ‖predicted − true‖ and Σ‖observed − predicted‖ of the Benedict–Bordner filter, 100 seeds",
        (
            ("printed as the tracking error", metres(total)),
            *(
                (f"{what}, started from {name}: least – median – greatest", _span(values))
                for what, group in (("error against the truth", errors), ("innovation", innovations))
                for name, values in group.items()
            ),
        ),
        holds=all(v.max() < total for v in errors.values())
        and all(v.min() <= total <= v.max() for v in innovations.values()),
        chart=Chart(
            "Benedict–Bordner, α = 0.86: which total is printed",
            "",
            "total, m",
            (
                bars("error against the truth", "predicted", _medians(errors)),
                bars("innovation", "observed", _medians(innovations)),
                bars("printed", "marker", {"table 5": total}),
            ),
        ),
    )


def _span(values: FloatArray) -> str:
    return " – ".join(metres(value) for value in (values.min(), float(np.median(values)), values.max()))


def _medians(groups: dict[str, FloatArray]) -> dict[str, float]:
    return {f"from {name}": float(np.median(values)) for name, values in groups.items()}


def worst() -> Proof:
    """The text says that Benedict-Bordner is worst in both totals; the table says otherwise."""
    totals = {
        column: {name: printed(PAPER, "5", name, column) for name in FILTERS} for column in ("tracking", "estimation")
    }
    runs = [experiment_of(PAPER, name) for name in FILTERS]
    medians = np.median(compare(runs, "estimation_total", seeds=HUNDRED), axis=2)[:, 0]
    firsts = [replace(run, start="first") for run in runs[:2]]
    from_first = np.median(compare(firsts, "estimation_total", seeds=HUNDRED), axis=2)[:, 0]
    found = dict(zip(FILTERS, map(float, medians), strict=True))
    last = {column: max(values, key=values.__getitem__) for column, values in totals.items()}
    return Proof(
        "the greatest of each column of table 5, and the medians of the estimation totals over 100 seeds",
        (
            ("greatest tracking error in table 5", FILTERS[last["tracking"]]),
            ("greatest estimation error in table 5", FILTERS[last["estimation"]]),
            *((f"estimation error printed, {FILTERS[name]}", metres(v)) for name, v in totals["estimation"].items()),
            *((f"recomputed, {FILTERS[name]}", metres(v)) for name, v in list(found.items())[:2]),
            ("started from the first sample, the same two", "; ".join(map(metres, map(float, from_first)))),
        ),
        holds=last == {"tracking": "benedict-bordner", "estimation": "gray-murray"}
        and found["gray-murray"] > found["benedict-bordner"],
        chart=Chart(
            "Estimation error of table 5",
            "",
            "total, m",
            (
                bars("printed", "marker", {FILTERS[name]: value for name, value in totals["estimation"].items()}),
                bars("recomputed", "smoothed", {FILTERS[name]: value for name, value in found.items()}),
            ),
        ),
    )


PROCESS, DECADES = -3, range(-6, 3)
"""Exponent of the manoeuvre variance that figures 6 and 7 hold, and those that figures 4 and 5 run through."""


def one_search() -> Proof:
    """The searches over the two variances are one search over their quotient."""
    run = experiment_of(PAPER, "gray-murray")

    def total(process: int, sensor: int) -> float:
        """With both variances as powers of ten, Λ of eq. 9 from both standard deviations."""
        index = run.interval**2 * 10.0 ** (process / 2) / 10.0 ** (sensor / 2)
        return median(replace(run, tracking_index=index), "innovation_total", range(1, 11))

    over_process = {k: total(k, 0) for k in DECADES}
    over_sensor = {PROCESS - k: total(PROCESS, PROCESS - k) for k in DECADES}
    apart = max(abs(over_sensor[PROCESS - k] / value - 1) for k, value in over_process.items())
    best = [min(values, key=values.__getitem__) for values in (over_process, over_sensor)]
    noise = (run.noise_std or (0.0,))[0]
    finer = [replace(run, tracking_index=run.interval**2 * 10 ** (half / 4)) for half in (-6, -5)]
    totals = np.median(compare(finer, "tracking_total", seeds=HUNDRED), axis=2)[:, 0]
    pair = [replace(run, tracking_index=run.interval**2 * w / v).gains().values for w, v in ((1e-2, 1.0), (0.1, 10.0))]
    return Proof(
        "Λ = T²σ_w/σ_v (eq. 9), gains from Λ alone (eq. 10–13); total innovation over both variances, 10 seeds",
        (
            ("α, β, γ at σ_w, σ_v = 0.01 m/s², 1 m; 0.1 m/s², 10 m", "; ".join(listed(gains, 4) for gains in pair)),
            ("least total over σ_w², σ_v² = 1 m²: at", f"{decade(best[0])} m²/s⁴"),
            ("least total over σ_v², σ_w² = 10⁻³ m²/s⁴: at", f"{decade(best[1])} m²"),
            ("greatest difference between one curve and the other, mirrored", f"{power(100 * apart, 0)} %"),
            ("σ of the noise in the measurements, section 4.2", metres(noise)),
            ("σ_w for the same Λ with that noise", f"{plain(noise * 10 ** (PROCESS / 2), 3)} m/s²"),
            ("half a decade finer, total tracking error at σ_w² = 10⁻³; 10⁻²·⁵", "; ".join(map(metres, totals))),
        ),
        holds=apart < 1e-9
        and best == [PROCESS, 0]
        and bool(np.allclose(pair[0], pair[1], rtol=1e-12))
        and noise == 10
        and bool(totals[1] < totals[0]),
        chart=Chart(
            "One search, twice",
            "decade of the variance that is searched",
            "total innovation, m",
            (
                line("σ_w² searched, σ_v² = 1", "predicted", over_process, over_process.values()),
                line("σ_v² searched, σ_w² = 10⁻³", "counterpart", over_sensor, over_sensor.values()),
            ),
            logarithmic=True,
        ),
    )
