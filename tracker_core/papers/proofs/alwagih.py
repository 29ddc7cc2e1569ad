"""Al-Wagih & Abdulla: hindsight, the target, the tables and the region."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from tracker_core.conventions import Gains
from tracker_core.papers.document import papers
from tracker_core.papers.printed import number
from tracker_core.papers.proof import Chart, Proof
from tracker_core.papers.proofs.common import (
    agree,
    bars,
    cell,
    exact,
    experiment_of,
    listed,
    metres,
    plain,
    plane,
    pole_list,
    pole_series,
    printed,
    results,
)
from tracker_core.poles import poles
from tracker_core.responses import time_response
from tracker_core.run import Result
from tracker_core.stability import is_stable
from tracker_core.types import FloatArray

PAPER = "alwagih"
METHODS = ("m1", "m2", "m3", "m4", "m5")
COLOURS = {"white": "1", "coloured": "2"}
"""Noise, and the table that reports it."""


def hindsight() -> Proof:
    """M5 knows the measurement that its prediction is compared with."""
    names = (*METHODS, "m5-causal")
    runs = {name: results(experiment_of(PAPER, f"{name}-white")) for name in names}
    errors = {name: _errors(group) for name, group in runs.items()}
    sigma = runs["m5"][0].noise_std[0]
    nearest = {name: min(_innovations(runs[name])) for name in ("m5", "m5-causal")}
    related = {name: _correlation(runs[name]) for name in ("m5", "m5-causal")}
    coloured = {name: _errors(results(experiment_of(PAPER, f"{name}-coloured"))) for name in ("m5", "m5-causal")}
    titles = dict(zip(names, ("M1", "M2", "M3", "M4", "M5", "M5 causal"), strict=True))
    return Proof(
        "no prediction is nearer to a measurement with white noise than σ, in the mean square; medians of 20 seeds",
        (
            ("σ of the measurements", metres(sigma)),
            ("RMS distance of M5's prediction to the measurement, x or y, the smaller", metres(nearest["m5"], 1)),
            ("the same distance, M5 by past innovations", metres(nearest["m5-causal"], 1)),
            ("correlation of M5's error with the noise of the same sample", plain(related["m5"], 2)),
            ("the same correlation, M5 by past innovations", plain(related["m5-causal"], 2)),
            ("RMSE in x, y, white noise: M5; by past innovations", _pair(errors)),
            ("RMSE in x, y, coloured noise: M5; by past innovations", _pair(coloured)),
        ),
        holds=nearest["m5"] < sigma < nearest["m5-causal"]
        and related["m5"] > 0.5
        and abs(related["m5-causal"]) < 0.1
        and bool(experiment_of(PAPER, "m5-white").hindsight)
        and not experiment_of(PAPER, "m5-causal-white").hindsight,
        chart=Chart(
            "RMSE of the prediction, white noise",
            "",
            "RMSE, m",
            tuple(
                bars(axis, role, {titles[name]: float(errors[name][i]) for name in names})
                for i, (axis, role) in enumerate((("x", "observed"), ("y", "predicted")))
            ),
        ),
    )


def _errors(runs: Sequence[Result]) -> FloatArray:
    """Median of the prediction's RMSE per axis."""
    return np.median(_rmse(runs), axis=0)


def _rmse(runs: Sequence[Result]) -> FloatArray:
    """Of the prediction, shape (runs, axes)."""
    return np.array([[axis.tracking_rmse for axis in result.axis_metrics()] for result in runs])


def _innovations(runs: Sequence[Result]) -> list[float]:
    """RMS distance of prediction and measurement per axis, all runs together."""
    return [float(v) for v in np.sqrt(np.nanmean([result.track.innovation**2 for result in runs], axis=(0, 1)))]


def _correlation(runs: Sequence[Result]) -> float:
    """Of the prediction's error and the measurement's, all runs and both axes together."""
    true = np.array([result.truth.positions for result in runs])
    error = np.array([result.track.predicted[:, :, 0] for result in runs]) - true
    noise = np.array([result.measurements.positions for result in runs]) - true
    known = ~np.isnan(error)
    return float(np.corrcoef(error[known], noise[known])[0, 1])


def _pair(errors: dict[str, FloatArray]) -> str:
    return "; ".join(f"{listed(errors[name], 1)} m" for name in ("m5", "m5-causal"))


def target() -> Proof:
    """Ours is another target of the same character: rankings agree, metres need not."""
    lines, same = [], {}
    ratios = []
    for colour in COLOURS:
        runs = {name: _rmse(results(experiment_of(PAPER, f"{name}-{colour}"))) for name in METHODS}
        ours = {name: values.mean(axis=0) for name, values in runs.items()}
        theirs = {name: np.array([_mean(colour, name, axis) for axis in "xy"]) for name in METHODS}
        for i, axis in enumerate("xy"):
            ranks = [_ranked({name: v[name][i] for name in METHODS}) for v in (theirs, ours)]
            same[colour, axis] = ranks[0] == ranks[1]
            lines.append((f"{colour}, {axis}: from least to greatest RMSE, printed; ours", _ranks(ranks)))
        ratios += [theirs["m1"][1] / theirs["m2"][1], float(np.median(runs["m1"][:, 1] / runs["m2"][:, 1]))]
        gains = [
            [_mean_change(colour, name) for name in METHODS[2:]],
            [float(np.median(100 * (1 - runs[name] / runs["m1"])[:, 1])) for name in METHODS[2:]],
        ]
        lines.append((f"{colour}, y: change from M1 by M3, M4, M5, printed; ours", _percents(gains)))
    lines.append(("RMSE in y, M1 over M2: white printed, ours; coloured printed, ours", listed(ratios, 1)))
    return Proof(
        "mean RMSE of the five sets of tables 1 and 2, and of 20 seeds on our target; eq. 27 and ratios: our medians",
        tuple(lines),
        holds=all(same[colour, "y"] for colour in COLOURS) and same["white", "x"] and bool(min(ratios) > 3),
    )


def _mean_change(colour: str, method: str) -> float:
    """Mean of eq. 27 in y, from the printed errors."""
    pairs = [[printed(PAPER, COLOURS[colour], f"{k}-y", name) for name in ("m1", method)] for k in range(1, 6)]
    return float(np.mean([100 * (one - other) / one for one, other in pairs]))


def _mean(colour: str, method: str, axis: str) -> float:
    return float(sum(exact(PAPER, COLOURS[colour], f"{k}-{axis}", method) for k in range(1, 6)) / 5)


def _ranked(errors: dict[str, float]) -> list[str]:
    """From the least; those that differ by rounding in the order of METHODS."""
    return sorted(errors, key=lambda name: round(errors[name], 6))


def _ranks(ranks: Sequence[Sequence[str]]) -> str:
    return "; ".join(" ".join(name.upper() for name in order) for order in ranks)


def _percents(rows: Sequence[Sequence[float]]) -> str:
    return "; ".join(f"{listed(row, 1)} %" for row in rows)


@dataclass(frozen=True, slots=True)
class _Cell:
    table: str
    row: str
    column: str
    found: Decimal

    @property
    def text(self) -> str:
        return cell(PAPER, self.table, self.row, self.column)

    @property
    def title(self) -> str:
        name, axis = self.row.split("-")
        return f"{name.upper()}−{self.column.upper()} {axis} ({self.table})"

    @property
    def without_signs(self) -> Decimal:
        """Of tables 3 and 4: the mean of the differences' magnitudes."""
        base, axis = self.row.split("-")
        source = {"3": "1", "4": "2"}[self.table]
        pairs = [[exact(PAPER, source, f"{k}-{axis}", name) for name in (base, self.column)] for k in range(1, 6)]
        return Decimal(sum(abs(one - other) for one, other in pairs)) / 5


def _derived() -> list[_Cell]:
    """Tables 3 to 6 from tables 1 and 2, exactly."""
    cells = []
    for averages, changes, source in (("3", "5", "1"), ("4", "6", "2")):
        for method in METHODS[2:]:
            for axis in "xy":
                rows = [f"{k}-{axis}" for k in range(1, 6)]
                values = {name: [exact(PAPER, source, row, name) for row in rows] for name in ("m1", "m2", method)}
                for base in ("m1", "m2"):
                    mean = (sum(values[base]) - sum(values[method])) / 5
                    cells.append(_Cell(averages, f"{base}-{axis}", method, Decimal(mean)))
                for row, one, other in zip(rows, values["m1"], values[method], strict=True):
                    cells.append(_Cell(changes, row, method, 100 * (one - other) / one))
    return cells


def tables() -> Proof:
    """Which cells of tables 3 to 6 do not follow from tables 1 and 2."""
    cells = _derived()
    wrong = [item for item in cells if not agree(item.text, item.found)]
    stated = next(set(erratum.cells) for erratum in papers()[PAPER].errata if erratum.proof == "alwagih-tables")
    flipped = [item for item in wrong if float(item.text) * float(item.found) < 0]
    shown = [item for item in wrong if item.table in "34" and abs(float(item.text) / float(item.found) - 1) > 0.05]
    explained = sum(agree(item.text, item.without_signs) for item in wrong if item.table in "34")
    count = {table: sum(item.table == table for item in wrong) for table in "3456"}
    every = {table: sum(item.table == table for item in cells) for table in "3456"}
    return Proof(
        "tables 3 and 4: mean difference of RMSE; tables 5 and 6: eq. 27; both from the numbers of tables 1 and 2",
        (
            *((f"table {table}: cells that do not follow", f"{count[table]} of {every[table]}") for table in "3456"),
            ("of these in tables 3 and 4: means of magnitudes", f"{explained} of {count['3'] + count['4']}"),
            *((f"sign, {item.title}: printed; found", f"{item.text}; {plain(item.found, 4)} m") for item in flipped),
            ("greatest difference of tables 5 and 6: printed; found", _worst(wrong)),
        ),
        holds={(item.table, item.row, item.column) for item in wrong} == stated
        and len(flipped) == 2
        and explained == 7
        and all(item.row == "m2-y" and item.column == "m3" for item in flipped),
        chart=Chart(
            "Averages of tables 3 and 4 that are off by more than 5 %",
            "methods, axis (table)",
            "difference of RMSE, m",
            (
                bars("printed", "bad", {item.title: float(item.text) for item in shown}),
                bars("recomputed", "smoothed", {item.title: float(item.found) for item in shown}),
            ),
        ),
    )


def _worst(wrong: Sequence[_Cell]) -> str:
    item = max((item for item in wrong if item.table in "56"), key=lambda item: abs(number(item.text) - item.found))
    return f"{item.text} %; {plain(item.found, 4)} %"


def region() -> Proof:
    """Beyond alpha = 1 the filter is stable, with one positive and one negative pole."""
    sets = [
        Gains((alpha, share * (4 - 2 * alpha)))
        for alpha in np.arange(105, 200, 5) / 100
        for share in np.arange(5, 100, 5) / 100
    ]
    roots = [poles(gains) for gains in sets]
    opposite = [all(abs(z.imag) == 0 for z in pair) and pair[0].real * pair[1].real < 0 for pair in roots]
    products = max(abs((pair[0] * pair[1]).real - (1 - g.values[0])) for pair, g in zip(roots, sets, strict=True))
    # Triangles with the corner (2, 0).
    whole, beyond = 2 * 4 / 2, 1 * 2 / 2
    example = Gains((1.6, 0.2))
    error = 1 - time_response(example, 0, 40).smoothed
    changes = int((np.diff(np.sign(error[:12])) != 0).sum())
    return Proof(
        "poles of z² + (α + β − 2)z + (1 − α) for 1 < α < 2, 0 < β < 4 − 2α: their product is 1 − α < 0",
        (
            ("sets of the grid with 1 < α < 2 that are stable", f"{sum(map(is_stable, sets))} of {len(sets)}"),
            ("their largest pole", plain(max(abs(pair[0]) for pair in roots), 3)),
            ("sets with two real poles of opposite signs", f"{sum(opposite)} of {len(sets)}"),
            ("share of the stable triangle that eq. 21 leaves out", f"{plain(100 * beyond / whole)} %"),
            ("poles at α = 1.6, β = 0.2", pole_list(poles(example))),
            ("their product, and 1 − α", listed(((poles(example)[0] * poles(example)[1]).real, 1 - 1.6), 3)),
            ("changes of sign of the step response's error in its first 12 samples", str(changes)),
        ),
        holds=all(map(is_stable, sets)) and all(opposite) and products < 1e-12 and changes >= 5,
        chart=plane(
            "Poles for 1 < α < 2",
            pole_series("the larger of each set", "predicted", (pair[0] for pair in roots)),
            pole_series("the other", "smoothed", (pair[1] for pair in roots)),
            pole_series("α = 1.6, β = 0.2", "marker", poles(example)),
        ),
    )


def ranking() -> Proof:
    """By the printed tables M4 is worse than M3 in y, and M3 worse than M2."""
    lines, holds = [], []
    means = {(colour, name, axis): _mean(colour, name, axis) for colour in COLOURS for name in METHODS for axis in "xy"}
    for colour in COLOURS:
        second, third, fourth = (means[colour, name, "y"] for name in ("m2", "m3", "m4"))
        lines += [
            (f"{colour}, y: mean RMSE of M2, M3, M4", f"{listed((second, third, fourth), 4)} m"),
            (f"{colour}, y: M4 over M3", plain(fourth / third, 2)),
            (f"{colour}, y: M2 − M3, which is said to be positive", metres(second - third, 4)),
        ]
        holds.append(fourth > 3 * third and second < third)
    return Proof(
        "means of tables 1 and 2 over the five sets",
        tuple(lines),
        holds=all(holds),
        chart=Chart(
            "Mean RMSE in y, as printed",
            "",
            "RMSE, m",
            tuple(
                bars(f"{colour} noise", role, {name.upper(): means[colour, name, "y"] for name in METHODS})
                for colour, role in (("white", "observed"), ("coloured", "predicted"))
            ),
        ),
    )
