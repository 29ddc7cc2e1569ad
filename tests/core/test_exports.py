"""Tracks as tables: what the columns are, and that no digit is lost on the way out."""

import csv
import io
import math

import numpy as np
import pytest

from tracker_core import Experiment, run_experiment
from tracker_core.exports import track_columns, write_track

EXPERIMENTS = [
    {"scenario": "garg-constant-velocity"},
    {"scenario": "garg-accelerating"},
    {"samples": 40, "order": 4, "xi": 0.7, "start": "expanding"},
    {"scenario": "constant-velocity", "start": "first", "noise_std": "0.1,1e9"},
    {"samples": 200, "alpha": 0.5, "beta": 3.5},
]


def run(values):
    return run_experiment(Experiment.from_dict(values))


def written(result):
    stream = io.StringIO()
    write_track(result, stream)
    return stream.getvalue()


def test_columns_of_one_axis():
    assert list(track_columns(run({"scenario": "garg-accelerating"}))) == [
        "sample", "time",
        "range_true", "range_observed", "range_predicted", "range_smoothed",
        "range_velocity_predicted", "range_velocity_smoothed",
        "range_acceleration_predicted", "range_acceleration_smoothed",
    ]  # fmt: skip


def test_columns_of_two_axes():
    names = list(track_columns(run({"order": 2, "xi": 0.5})))
    assert names[2:8] == [
        "x_true",
        "x_observed",
        "x_predicted",
        "x_smoothed",
        "x_velocity_predicted",
        "x_velocity_smoothed",
    ]
    assert names[8:] == [name.replace("x_", "y_", 1) for name in names[2:8]]


def test_columns_of_four_states_end_with_the_jerk():
    assert list(track_columns(run({"order": 4, "xi": 0.5})))[-1] == "y_jerk_smoothed"


@pytest.mark.parametrize("values", EXPERIMENTS, ids=str)
def test_columns_are_the_result(values):
    result = run(values)
    columns = track_columns(result)
    axis = result.scenario.axes[-1]
    assert columns["sample"].tolist() == list(range(1, result.experiment.samples + 1))
    assert np.array_equal(columns["time"], result.truth.times)
    assert np.array_equal(columns[f"{axis}_true"], result.truth.positions[:, -1])
    assert np.array_equal(columns[f"{axis}_observed"], result.measurements.positions[:, -1])
    assert np.array_equal(columns[f"{axis}_predicted"], result.track.predicted[:, -1, 0], equal_nan=True)
    assert np.array_equal(columns[f"{axis}_velocity_smoothed"], result.track.smoothed[:, -1, 1], equal_nan=True)


@pytest.mark.parametrize("values", EXPERIMENTS, ids=str)
def test_csv_round_trips_exactly(values):
    result = run(values)
    header, *rows = csv.reader(io.StringIO(written(result)))
    columns = track_columns(result)
    assert header == list(columns)
    assert len(rows) == result.experiment.samples
    for name, cells in zip(header, zip(*rows, strict=True), strict=True):
        read = np.array([float(cell) if cell else math.nan for cell in cells])
        assert np.array_equal(read, columns[name], equal_nan=True)


def test_csv_is_plain():
    """A header, one line a sample, whole sample numbers, empty cells before the filter predicts."""
    text = written(run({"scenario": "garg-constant-velocity", "start": "two-point"}))
    lines = text.split("\n")
    assert lines[0] == (
        "sample,time,range_true,range_observed,range_predicted,range_smoothed,"
        "range_velocity_predicted,range_velocity_smoothed"
    )
    assert lines[1] == "1,5.0,30200.0,30171.0,,30171.0,,"
    assert len(lines) == 12
    assert lines[-1] == ""
    assert "nan" not in text
