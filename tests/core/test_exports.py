"""Tracks as tables: what the columns are, and that no digit is lost on the way out."""

import csv
import dataclasses
import io
import json
import math
import subprocess
import sys
import zipfile

import numpy as np
import pytest

from tracker_core import Experiment, Gate, InputError, Truth, run_experiment, run_filter
from tracker_core.exports import (
    Part,
    run_parts,
    run_summary,
    track_columns,
    write_archive,
    write_columns,
    write_json,
    write_track,
)
from tracker_core.exports.cells import PIECE

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


def gated(result, gate):
    """The same result with a gate."""
    track = run_filter(result.measurements, result.gains, start=result.experiment.start, gate=gate)
    return dataclasses.replace(result, track=track, gate=gate)


def unknown(result):
    """The same result where nobody knows the truth."""
    return dataclasses.replace(result, truth=Truth(result.truth.times, np.full_like(result.truth.states, np.nan)))


GATE = Gate(1.5, (20.0,), 0.1, 1.0)


def test_what_a_gate_refused_has_a_column():
    result = gated(run({"samples": 60, "order": 2, "xi": 0.6, "start": "two-point"}), GATE)
    columns = track_columns(result)
    assert list(columns)[:4] == ["sample", "time", "rejected", "x_true"]
    assert result.track.rejected.any()
    assert columns["rejected"].tolist() == [int(value) for value in result.track.rejected]
    assert {line.split(",")[2] for line in written(result).splitlines()[1:]} == {"0", "1"}
    assert run_summary(result)["rejected"] == result.track.rejected.sum()


def test_a_truth_that_nobody_knows_has_no_column():
    result = unknown(run({"samples": 20, "order": 2, "xi": 0.6}))
    assert [name for name in track_columns(result) if name.endswith("_true")] == []
    assert [name for name in track_columns(result) if name.endswith("_observed")] == ["x_observed", "y_observed"]


# JSON --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("values", EXPERIMENTS, ids=str)
def test_json_of_the_track_round_trips_exactly(values):
    columns, stream = track_columns(run(values)), io.StringIO()
    write_json(columns, stream)
    read = json.loads(stream.getvalue(), parse_constant=pytest.fail)
    assert list(read) == list(columns)
    for name, cells in read.items():
        found = np.array([math.nan if cell is None else cell for cell in cells])
        assert np.array_equal(found, columns[name], equal_nan=True)


def test_json_knows_neither_nan_nor_infinity():
    stream = io.StringIO()
    write_json({"a": [math.nan, math.inf, -math.inf, 1.5], "b": (np.float64("nan"), np.int64(3)), "é": None}, stream)
    assert json.loads(stream.getvalue()) == {"a": [None, None, None, 1.5], "b": [None, 3], "é": None}
    assert "é" in stream.getvalue()


@pytest.mark.parametrize("rows", [0, 1, PIECE - 1, PIECE, PIECE + 1, 2 * PIECE + 7])
def test_long_columns_are_written_in_pieces_and_read_as_a_whole(rows):
    columns = {"a": np.arange(rows), 'é "b"': np.where(np.arange(rows) % 3, np.arange(rows) / 7, np.nan)}
    stream = io.StringIO()
    write_columns(columns, stream)
    read = json.loads(stream.getvalue())
    assert read["a"] == list(range(rows))
    assert read['é "b"'] == [row / 7 if row % 3 else None for row in range(rows)]


def test_no_columns_are_an_empty_object():
    stream = io.StringIO()
    write_columns({}, stream)
    assert json.loads(stream.getvalue()) == {}


# One zip -----------------------------------------------------------------------------------------------------------

CODE = ["filterpy_filter.py", "tuned_filter.c", "tuned_filter.h", "tuned_filter.m", "tuned_filter.py",
        "tuned_filter_test.m"]  # fmt: skip


def archived(parts):
    stream = io.BytesIO()
    write_archive(stream, parts)
    return stream.getvalue()


def opened(data):
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


def test_the_archive_holds_everything_and_says_what_it_is():
    result = run({"samples": 60, "order": 3, "xi": 0.6, "start": "expanding"})
    parts = opened(archived(run_parts(result, title="A title", origin="https://example.org/?order=3")))
    names = ["README.txt", "experiment.json", *(f"filter/{name}" for name in CODE), "metrics.json", "track.csv",
             "track.json"]  # fmt: skip
    assert list(parts) == names
    readme = parts["README.txt"].decode()
    for name in set(names) - {"README.txt"}:
        assert f"\n{name}\n    " in readme
    assert "A title\nhttps://example.org/?order=3\n" in readme
    assert parts["track.csv"].decode() == written(result)
    assert Experiment.from_dict(json.loads(parts["experiment.json"])) == result.experiment
    assert json.loads(parts["metrics.json"])["metrics"] == result.metrics.to_dict()


def test_the_code_in_the_archive_runs(tmp_path):
    result = run({"samples": 60, "order": 2, "xi": 0.6, "start": "two-point"})
    with zipfile.ZipFile(io.BytesIO(archived(run_parts(gated(result, GATE))))) as archive:
        archive.extractall(tmp_path)
    assert "WIDTH = 1.5" in (tmp_path / "filter" / "tuned_filter.py").read_text()
    done = subprocess.run(
        [sys.executable, "-I", "-S", "filter/tuned_filter.py"], cwd=tmp_path, check=True, capture_output=True, text=True
    )
    assert done.stdout.splitlines()[-1] == "equal"


def test_the_same_run_gives_the_same_bytes():
    result = run({"samples": 60, "order": 2, "xi": 0.6})
    parts = run_parts(result)
    assert archived(parts) == archived(run_parts(result)[::-1])
    assert archived(parts) != archived(run_parts(result, title="other"))


def test_the_archive_of_a_method_has_no_code_and_says_why():
    parts = opened(archived(run_parts(run({"design": "growing-memory", "samples": 40}))))
    assert [name for name in parts if name.startswith("filter/")] == []
    assert b"no code of the filter: its gains were chosen as it ran" in parts["README.txt"]


def test_more_parts_can_be_added_under_names_of_their_own():
    figure = Part("figures/path.svg", b"<svg/>", "The path.")
    assert opened(archived([figure]))["figures/path.svg"] == b"<svg/>"
    with pytest.raises(InputError, match="must have a name each"):
        archived([figure, figure])


def test_any_title_makes_a_readme_of_whole_lines():
    parts = run_parts(run({"samples": 20, "order": 2, "xi": 0.6}), title="a\nb\ud800", origin="\x00\r\n*/")
    lines = opened(archived(parts))["README.txt"].decode().splitlines()
    assert lines[1:4] == ["a b", "* /", ""]
