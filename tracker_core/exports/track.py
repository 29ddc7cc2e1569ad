"""A run as a table: one row a sample."""

from __future__ import annotations

import csv
from math import isnan
from typing import TextIO

import numpy as np

from tracker_core.conventions import CONVENTIONS
from tracker_core.exports.cells import PIECE, cells
from tracker_core.run import Result
from tracker_core.types import GAIN_NAMES, STATE_NAMES, FloatArray, IntArray


def track_columns(result: Result) -> dict[str, FloatArray | IntArray]:
    """The columns of a run, each of shape (n_samples,), SI units; gains have none.

    `sample` counts from 1; then `time`; `rejected`, 1 where a gate refused the sample, if one watched; then per axis
    `x_true` if anybody knows it, `x_observed`, `x_predicted`, `x_smoothed`, and the further states as
    `x_velocity_predicted`, `x_velocity_smoothed`, ...; and where a method chose the gains, those of every sample in the
    convention of the run as `x_alpha`, `x_beta`, ...
    """
    columns: dict[str, FloatArray | IntArray] = {
        "sample": np.arange(1, len(result.truth.times) + 1),
        "time": result.truth.times,
    }
    if result.track.rejected is not None:
        columns["rejected"] = result.track.rejected.astype(np.int64)
    for i, axis in enumerate(result.scenario.axes):
        if not np.isnan(result.truth.positions[:, i]).all():
            columns[f"{axis}_true"] = result.truth.positions[:, i]
        columns[f"{axis}_observed"] = result.measurements.positions[:, i]
        for state in range(result.gains.order):
            name = axis if state == 0 else f"{axis}_{STATE_NAMES[state]}"
            columns[f"{name}_predicted"] = result.track.predicted[:, i, state]
            columns[f"{name}_smoothed"] = result.track.smoothed[:, i, state]
        if result.selection is not None:
            factors = CONVENTIONS[result.experiment.convention].factors
            for index, gain in enumerate(GAIN_NAMES[: result.gains.order]):
                columns[f"{axis}_{gain}"] = result.selection.gains[:, i, index] / factors[index]
    return columns


def write_track(result: Result, stream: TextIO) -> None:
    """Write the run as CSV: a header, then one row a sample; every digit, and empty cells for what is undefined."""
    columns = track_columns(result)
    csv.writer(stream, lineterminator="\n").writerow(columns)
    for start in range(0, len(result.truth.times), PIECE):
        piece = (cells(column[start : start + PIECE], _said) for column in columns.values())
        # Numbers need no quotation marks.
        stream.write("\n".join(map(",".join, zip(*piece, strict=True))) + "\n")


def _said(value: float) -> str:
    return "" if isnan(value) else repr(value)
