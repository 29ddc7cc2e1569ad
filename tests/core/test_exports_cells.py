"""Long columns as text, beside the standard library's own writers: not a byte is another, with orjson and without."""

import csv
import io
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tracker_core import Experiment, run_experiment
from tracker_core.exports import cells, track_columns, write_columns, write_track
from tracker_core.exports.cells import PIECE, PLAIN
from tracker_core.measured import SHELF, File

EDGES = [
    near
    for power in range(-323, 309)
    for edge in (float(f"1e{power}"), float(f"9.5e{power - 1}"))
    for near in (edge, np.nextafter(edge, 0), np.nextafter(edge, np.inf))
]
SPECIAL = [0.0, -0.0, math.nan, math.inf, -math.inf, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, 2.0**53]


@pytest.fixture(params=[True, False], ids=["orjson", "repr"], autouse=True)
def orjson(request, monkeypatch):
    """Whether the package is there."""
    if not request.param:
        monkeypatch.setattr(cells, "_orjson", lambda: None)
    assert (cells._orjson() is not None) == request.param


def all_kinds():
    """Every order of magnitude, its ends, and the bits of anything."""
    draw = np.random.default_rng(1)
    bits = draw.integers(0, 2**64, 20_000, dtype=np.uint64, endpoint=False).view(np.float64)
    usual = draw.normal(size=20_000) * 10.0 ** draw.uniform(-6, 18, 20_000)
    rounded = [round(value, int(digits)) for value, digits in zip(usual, draw.integers(0, 9, 20_000), strict=True)]
    return np.concatenate([EDGES, np.negative(EDGES), SPECIAL, PLAIN, bits, usual, rounded, np.arange(-500.0, 500)])


def said(value):
    return repr(value) if math.isfinite(value) else "?"


def expected(values):
    return [said(value) for value in values.tolist()]


def test_numbers_are_written_as_python_does():
    values = all_kinds()
    assert cells.cells(values, said) == expected(values)


@given(arrays(np.float64, st.integers(1, 30), elements=st.floats()))
def test_any_numbers_are(values):
    assert cells.cells(values, said) == expected(values)


@pytest.mark.parametrize(
    "column",
    [
        np.arange(10),
        np.arange(5, dtype=np.int32) - 2,
        np.array([2**62, -(2**63)]),
        np.arange(12.0).reshape(4, 3)[:, 1],
        np.linspace(0, 1, 9)[::-1],
        np.array([0.1, 1e-5], dtype=np.float32),
    ],
    ids=["whole", "short", "long", "strided", "backwards", "32 bits"],
)
def test_columns_of_every_kind(column):
    assert cells.cells(column, said) == list(map(repr, column.tolist()))


def csv_of(columns):
    """The table as the csv module writes it."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*(column.tolist() for column in columns.values()), strict=True):
        writer.writerow(["" if value != value else repr(value) for value in row])
    return stream.getvalue()


def json_of(columns):
    """The columns as the json module writes them, each on a line."""
    lines = (
        f"{json.dumps(name)}: {json.dumps([value if math.isfinite(value) else None for value in column.tolist()])}"
        for name, column in columns.items()
    )
    return "{\n" + ",\n".join(lines) + "\n}\n"


def with_gaps():
    rows = (f"{0.1 * row!r},{'' if row % 7 == 0 else math.sin(row / 9) * 10 ** (row % 9 - 6)!r}" for row in range(500))
    return {"data": SHELF.keep(File("gaps.csv", "\n".join(["t,x", *rows]).encode())), "order": 4, "xi": 0.7}


RUNS = {
    "one axis": lambda: {"scenario": "garg-accelerating"},
    "three axes": lambda: {"scenario": "climbing-turn", "samples": 300, "gate": 2, "order": 4, "xi": 0.8},
    "pieces": lambda: {"samples": 2 * PIECE + 1, "interval": 0.1},
    "unstable": lambda: {"samples": 200, "alpha": 0.5, "beta": 3.99},
    "stopped": lambda: {"samples": 200, "alpha": 1.9, "beta": 1.5},
    "tiny": lambda: {"samples": 60, "interval": 1e-6, "noise_std": 1e-9},
    "method": lambda: {"samples": 60, "design": "growing-memory"},
    "gaps": with_gaps,
}


@pytest.mark.parametrize("name", RUNS)
def test_tables_are_those_of_the_standard_library(name):
    result = run_experiment(Experiment.from_dict(RUNS[name]()))
    columns, table, lines = track_columns(result), io.StringIO(), io.StringIO()
    write_track(result, table)
    assert table.getvalue() == csv_of(columns)
    write_columns(columns, lines)
    assert lines.getvalue() == json_of(columns)


def test_infinity_is_null_in_json():
    columns, stream = {"a": np.array(SPECIAL), "b": np.arange(len(SPECIAL))}, io.StringIO()
    write_columns(columns, stream)
    assert stream.getvalue() == json_of(columns)
