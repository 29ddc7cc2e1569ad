"""What the plots of a recording come to, in numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from dash.development.base_component import Component

from layouts.components import table
from layouts.figures.recording import recording_of
from layouts.state import Settings
from layouts.text import significant
from tracker_core import Result
from tracker_core.metrics import distances
from tracker_core.recordings import Recorded
from tracker_core.recordings.timing import LONG
from tracker_core.types import FloatArray

DIGITS = 5

SIZES: dict[str, Callable[[FloatArray], float]] = {
    "Root mean square": lambda values: float(np.sqrt(np.mean(values**2))),
    "Median size": lambda values: float(np.median(np.abs(values))),
    "95 % are smaller than": lambda values: float(np.quantile(np.abs(values), 0.95)),
    "Greatest": lambda values: float(np.abs(values).max()),
}


def numbers(result: Result, settings: Settings) -> list[Component]:
    """The tables: intervals, and innovations in metres and where there is a gate in standard deviations."""
    found = recording_of(settings.experiment)
    if found is None:
        return []
    believed, spread = result.track.believed, result.track.spread
    refused = 0 if result.track.rejected is None else int(result.track.rejected.sum())
    tables = [
        _intervals(found),
        _innovations("Innovations (m)", believed, refused, result.scenario.axes),
    ]
    if result.gate is not None and spread is not None:
        with np.errstate(invalid="ignore", over="ignore"):
            scaled = believed / spread
        tables.append(_innovations("Innovations (σ)", scaled, refused, result.scenario.axes))
    return tables


def _intervals(found: Recorded) -> Component:
    steps = np.diff(found.times[found.lines > 0])
    low, middle, high = np.quantile(steps, (0.05, 0.5, 0.95)).tolist()
    gaps = steps[steps > LONG * found.nominal]
    said = {
        "Usual": found.nominal, "Shortest": float(steps.min()), "5 % are shorter than": low, "Median": middle,
        "95 % are shorter than": high, "Longest": float(steps.max()), "All gaps together": float(gaps.sum()),
    }  # fmt: skip
    rows = [["Intervals", f"{len(steps):,}"], [f"Gaps, more than {LONG:g} times the usual", f"{len(gaps):,}"]]
    rows += [[f"{name} (s)", significant(value, DIGITS)] for name, value in said.items()]
    return table("Intervals between rows", ["", "value"], rows)


def _innovations(caption: str, values: FloatArray, refused: int, axes: Sequence[str]) -> Component:
    """Of every axis and of all together, what was believed, shape (n, n_axes), and how many samples were not."""
    seen = [column[np.isfinite(column)] for column in (*values.T, distances(values))]
    rows = [
        ["Believed", *(f"{len(column):,}" for column in seen)],
        ["Not believed", *(f"{refused:,}" for _ in seen)],
        ["Mean", *(significant(float(column.mean()), DIGITS) if column.size else "–" for column in seen[:-1]), "–"],
    ]
    for name, size in SIZES.items():
        rows.append([name, *(significant(size(column), DIGITS) if column.size else "–" for column in seen)])
    return table(caption, ["", *axes, "together"], rows)
