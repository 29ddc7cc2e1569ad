"""Gains and errors of every filter in numbers."""

from __future__ import annotations

import numpy as np
from dash.development.base_component import Component

from layouts.components import table
from layouts.figures.comparison import ERROR_TITLES, errors_of
from layouts.figures.error import running_rms, window
from layouts.numbers import listed
from layouts.pinned import pinned_runs
from layouts.state import Settings
from layouts.text import significant
from tracker_core import CONVENTIONS, Result
from tracker_core.fields import FIELDS
from tracker_core.types import GAIN_NAMES, FloatArray

DIGITS = 4

Runs = list[tuple[str, Result]]
"""Name and run of every filter."""


def numbers(result: Result, settings: Settings) -> list[Component]:
    """The tables: every gain of every filter, and the error that is shown over time."""
    runs = [("Present", result), *((candidate.name, run) for candidate, run in pinned_runs(settings))]
    return [_gains(runs, settings), _errors(runs, settings)]


def _gains(runs: Runs, settings: Settings) -> Component:
    """In the present convention; a filter of a lower order has fewer."""
    order = max(run.experiment.order for _, run in runs)
    rows = []
    for name, run in runs:
        said = gain_texts(run, settings)
        rows.append([name, *said, *["–"] * (order - len(said))])
    return table("Gains", ["Filter", *(FIELDS[gain].symbol for gain in GAIN_NAMES[:order])], rows)


def gain_texts(run: Result, settings: Settings) -> list[str]:
    """Every gain; of a method the least and the greatest that it chose for the axis shown, and their median."""
    convention = settings.experiment.convention
    if run.selection is None:
        return [significant(value, DIGITS) for value in run.experiment.gains().to(convention).values]
    factors = np.array(CONVENTIONS[convention].factors)[: run.experiment.order]
    return [
        _range_text(gains[np.isfinite(gains)]) for gains in (run.selection.gains[:, settings.view.axis] / factors).T
    ]


def _range_text(values: FloatArray) -> str:
    if not values.size:
        return "–"
    least, middle, greatest = (significant(each, DIGITS) for each in np.quantile(values, (0, 0.5, 1)).tolist())
    return middle if least == greatest else f"{least} to {greatest}, median {middle}"


def _errors(runs: Runs, settings: Settings) -> Component:
    (_, present), kind = runs[0], settings.view.comparing.compared
    times = present.truth.times
    width, some = window(len(times)), listed(len(times))
    columns = [times, *(running_rms(errors_of(run, kind), width) for _, run in runs)]
    rows = zip(*(column[some].tolist() for column in columns), strict=True)
    said = "sample by sample" if width == 1 else f"running RMS of {width} samples"
    return table(
        f"Errors: {ERROR_TITLES[kind]}, {said}",
        ["time (s)", *(name for name, _ in runs)],
        [[significant(value, DIGITS) for value in row] for row in rows],
    )
