"""Files to recordings: every rule of what is left out, moved, missing or kept, and that it is counted and listed."""

import gzip
import importlib.util
import io
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import Experiment, run_experiment
from tracker_core.checks import InputError
from tracker_core.exports import write_track
from tracker_core.recordings import KINDS, Reading, bounds, look, read

ROOT = Path(__file__).parents[2]


def rows_of(*rows):
    return "\n".join(rows).encode()


def table(*rows, names="t,x,y", **reading):
    return read(rows_of(names, *rows), Reading(**reading))


def listed(found, kind):
    return [(finding.line, finding.text) for finding in found.findings if finding.kind == kind]


def positions(found):
    """Lists with None for what is missing, to be compared."""
    return [[None if math.isnan(value) else value for value in row] for row in found.positions.tolist()]


# What is in a table --------------------------------------------------------------------------------------------------


def test_a_plain_table():
    found = table("10,1,2", "10.5,3,4", "11,5,6")
    assert found.times.tolist() == [0, 0.5, 1]
    assert found.positions.tolist() == [[1, 2], [3, 4], [5, 6]]
    assert (found.interval, found.nominal, found.axes, found.truth) == (0.5, 0.5, ("x", "y"), None)
    assert (found.lines.tolist(), found.rows, found.others, found.measured) == ([2, 3, 4], 3, 0, 3)
    assert (found.counts, found.findings, found.origin) == ({}, (), "")


@pytest.mark.parametrize(
    ("data", "reading"),
    [
        ("t;x;y\n0;1,5;2\n1;3;4,25\n2;5;-6e-1\n", Reading(delimiter="semicolon", decimal="comma")),
        ("0\t1.5\t2\n1\t3\t4.25\n2\t5\t-0.6", Reading(delimiter="tab", header=False)),
        ("  0  1.5 2\n1   3\t4.25   \n\n2 5 -.6\n", Reading(delimiter="space", header=False)),
        ("t|x|y\r\n0|1.5|2\r\n1|3|4.25\r\n2|5|-0.6\r\n", Reading(delimiter="pipe")),
        ("t,x,y\r0,1.5,2\r1,3,4.25\r2,5,-0.6\r", Reading()),
        ('"t","x","y"\n"0","1.5", "2"\n1,3,4.25\n2,5,"-0.6"\n', Reading()),
        ('t,x,y\n0,"1,5","2"\n1,"3","4,25"\n2,5,"-0,6"\n', Reading(decimal="comma")),
        ("# log\n% of\n\n// me\nt,x,y\n0,1.5,2\n  # more\n1,3,4.25\n2,5,-0.6\n", Reading()),
        ("sep=;\nt;x;y\n0;1.5;2\n1;3;4.25\n2;5;-0.6\n", Reading(delimiter="semicolon")),
        ("n,y,t,x\na,2,0,1.5\nb,4.25,1,3\nc,-0.6,2,5\n", Reading(time=3, at=(4, 2))),
        ('t,place\n0,1.5 2\n1,"(3, 4.25)"\n2,5;-0.6\n', Reading(at=(2, 2))),
        ("t,x [km],y [m]\n0,.0015,2\n1,.003,4.25\n2,.005,-0.6\n", Reading(units=("km", "m"))),
    ],
)
def test_layouts(data, reading):
    expected = [[1.5, 2], [3, 4.25], [5, -0.6]]
    for coded in (data.encode(), data.encode("utf-8-sig"), data.encode("utf-16"), gzip.compress(data.encode())):
        found = read(coded, reading)
        assert found.positions == pytest.approx(np.array(expected), abs=1e-12)
        assert found.times.tolist() == [0, 1, 2]
        assert found.counts == {}


@pytest.mark.parametrize(("unit", "metres"), [("m", 1), ("km", 1000), ("ft", 0.3048), ("NM", 1852)])
def test_units(unit, metres):
    found = table("0,1,-2", "1,2,0", "2,3,5", units=(unit,))
    assert found.positions == pytest.approx(metres * np.array([[1, -2], [2, 0], [3, 5]]), rel=1e-15)


def test_truth_is_read_alike_and_may_be_unknown():
    found = table(
        "0,1,2,3,4", "1,1,2,,4", "2,1,2,3,abc", "4,1,2,1e99,4", names="t,x,y,a,b", truth=(4, 5), units=("km",)
    )
    expected = [[3000, 4000], [math.nan, 4000], [3000, math.nan], [math.nan, math.nan], [math.nan, 4000]]
    assert np.array_equal(found.truth, expected, equal_nan=True)
    assert listed(found, "truth") == [(4, "y: abc"), (5, "out of range")]


def test_latin_letters_are_read_and_said():
    found = read("t,x,Höhe\n0,1,2\n1,3,4\n2,5,6\n".encode("latin-1"), Reading())
    assert found.measured == 3
    assert listed(found, "encoding") == [(0, "read as Latin-1")]


def test_one_track_of_several():
    rows = ["0,a,1", "1, b ,2", "2,a,3", "3,<b>x</b>,4", "4,a,5", "5,,6"]
    found = table(*rows, names="t,id,x", at=(3,), track=2, only="a")
    assert (found.positions[:, 0].tolist(), found.rows, found.others) == ([1, 3, 5], 6, 3)
    assert found.lines.tolist() == [2, 4, 6]
    with pytest.raises(InputError, match="only must be the id of a track in this file, got 'c'"):
        table(*rows, names="t,id,x", at=(3,), track=2, only="c")


def test_rows_before_the_names_and_short_rows():
    found = read(b"my log\nof today,1\nt,x,y\n0,1,2\n1,3\n2\n3,5,6\n,\n4,7,8\n", Reading())
    assert listed(found, "before") == [(1, "my log"), (2, "of today, 1")]
    assert listed(found, "short") == [(5, "2 of 3 columns"), (6, "1 of 3 columns"), (8, "2 of 3 columns")]
    assert listed(found, "empty") == [(5, "y"), (6, "x and y")]
    assert listed(found, "time") == [(8, "empty")]
    assert positions(found) == [[1, 2], [3, None], [None, None], [5, 6], [7, 8]]


# Cells ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("cell", "kind"),
    [
        ("", "empty"), (" ", "empty"), ("nan", "empty"), ("NaN", "empty"), ("NULL", "empty"), ("-", "empty"),
        ("N/A", "empty"), ("None", "empty"),
        ("abc", "position"), ("=1+1", "position"), ("#VALUE!", "position"), ("1_000", "position"),
        ("0x10", "position"), ("<b>1</b>", "position"), ("12 m", "position"), ("--5", "position"),
        ("1\0", "position"), ("1.2.3", "position"),
        ("inf", "beyond"), ("-Infinity", "beyond"), ("1e400", "beyond"), ("1.1e9", "beyond"), ("9" * 400, "beyond"),
    ],
)  # fmt: skip
def test_a_position_that_is_none(cell, kind):
    found = table("0,1,1", f"1,{cell},2", "2,3,3", "3,4,4")
    assert positions(found) == [[1, 1], [None, 2], [3, 3], [4, 4]]
    assert found.counts == {kind: 1}
    assert [line for line, _ in listed(found, kind)] == [3]


def test_the_reason_holds_what_was_received_as_it_is_and_clipped():
    found = table("0,1,1", "1,<b>'&=HYPERLINK(1),2", "2,3," + "z" * 500, "3,4,4")
    (_, first), (_, second) = listed(found, "position")
    assert first == "x: <b>'&=HYPERLINK(1)"
    assert second == "y: " + "z" * 76 + "…"


@pytest.mark.parametrize("cell", ["", "abc", "nan", "inf", "1e12", "12:00", "=1"])
def test_a_row_without_a_time_is_left_out(cell):
    found = table("0,1,1", f"{cell},2,2", "2,3,3", "3,4,4", "4,5,5")
    assert found.lines.tolist() == [2, 0, 4, 5, 6]
    assert listed(found, "time") == [(3, cell or "empty")]


@pytest.mark.parametrize(
    ("row", "text"),
    [
        ("91,10", "latitude 91"), ("-90.001,10", "latitude -90.001"), ("48,361", "longitude 361"),
        ("91,181", "latitude 91"), ("0,0", "latitude 0, longitude 0"),
    ],
)  # fmt: skip
def test_no_place_on_earth(row, text):
    found = table("0,48,11", f"1,{row}", "2,48.1,11", "3,48.2,11", frame="geographic")
    assert listed(found, "beyond") == [(3, text)]
    assert np.isnan(found.positions[1]).all()


def test_latitude_and_longitude_zero_is_a_place_for_those_who_live_there():
    found = table("0,0.001,0", "1,0,0", "2,-0.001,0", frame="geographic")
    assert found.counts == {}
    assert found.positions[1, 1] == pytest.approx(-110.574, abs=1e-3)


def test_a_range_is_not_negative():
    assert listed(table("0,-1,0", "1,1,0", "2,2,0", "3,3,0", frame="polar"), "beyond") == [(2, "range -1")]


# Rows ----------------------------------------------------------------------------------------------------------------


def test_rows_out_of_order_are_moved():
    found = table("0,0,0", "2,2,2", "1,1,1", "3,3,3", "0.5,9,9", "4,4,4")
    assert found.times.tolist() == [0, 0.5, 1, 2, 3, 4]
    assert found.lines.tolist() == [2, 6, 4, 3, 5, 7]
    assert listed(found, "order") == [(4, "1 s before a row above it"), (6, "2.5 s before a row above it")]


def test_of_rows_of_one_time_the_first_with_a_position_stays():
    found = table("0,0,0", "1,,", "1,1,1", "1,1,1", "1,7,7", "2,2,2", "2,2,2")
    assert found.positions.tolist() == [[0, 0], [1, 1], [2, 2]]
    assert listed(found, "duplicate") == [
        (3, "another position as in line 4"),
        (5, "same position as in line 4"),
        (6, "another position as in line 4"),
        (8, "same position as in line 7"),
    ]


def test_held_positions():
    rows = ["0,1,1", "1,1,1", "2,2,1", "3,,", "4,2,1", "5,2,1", "6,1,1", "7,3,"]
    missing = table(*rows, held="missing")
    assert listed(missing, "held") == [(3, "as in line 2"), (6, "as in line 4"), (7, "as in line 6")]
    assert [row[0] for row in positions(missing)] == [1, None, 2, None, None, None, 1, 3]
    kept = table(*rows, held="kept")
    assert kept.counts == missing.counts
    assert [row[0] for row in positions(kept)] == [1, 1, 2, None, 2, 2, 1, 3]
    assert kept.held.tolist() == missing.held.tolist() == [False, True, False, False, True, True, False, False]


def test_every_held_position_is_marked_also_beyond_those_that_are_listed():
    rows = [f"{k + 5 * (k > 2000)},{k // 2}" for k in range(4000)]
    found = table(*rows, names="t,x", at=(2,))
    assert len(found.times) == len(found.held) == 4005
    lines = found.lines[found.held]
    assert lines.tolist() == list(range(3, 4002, 2))
    assert found.counts["held"] == 2000


def test_gaps_hold_samples_where_the_interval_is_constant():
    found = table("0,0,0", "0.1,1,1", "0.2,2,2", "0.6,6,6", "0.7,7,7", "0.8,8,8", truth=(2, 3))
    assert found.interval == 0.1
    assert found.times == pytest.approx(np.arange(9) * 0.1, abs=1e-15)
    assert found.lines.tolist() == [2, 3, 4, 0, 0, 0, 5, 6, 7]
    expected = [[k, k] if k not in {3, 4, 5} else [math.nan, math.nan] for k in range(9)]
    assert np.array_equal(found.positions, expected, equal_nan=True)
    assert np.array_equal(found.truth, expected, equal_nan=True)
    assert listed(found, "gap") == [(5, "0.4 s instead of 0.1 s")]


def test_a_gap_of_too_many_samples_is_left_as_it_is():
    found = table("0,0,0", "1,1,1", "2,2,2", f"{bounds.MOST_ROWS + 1},3,3", f"{bounds.MOST_ROWS + 2},4,4")
    assert found.interval is None
    assert len(found.times) == 5
    assert found.nominal == 1


def test_without_a_column_of_the_time():
    found = table("1,2", "3,4", "x,", "7,8", names="x,y", time=0, at=(1, 2), interval=0.25)
    assert found.times.tolist() == [0, 0.25, 0.5, 0.75]
    assert found.interval == 0.25
    assert found.lines.tolist() == [2, 3, 4, 5]


def test_findings_are_all_counted_and_the_first_listed():
    rows = [f"{k},{k},abc" for k in range(3000)]
    rows[2500] = "x,1,1"
    rows[2600] = "2600,1e99,1"
    found = table(*rows)
    assert found.counts == {"time": 1, "position": 2998, "beyond": 1, "gap": 1}
    assert len(found.findings) == bounds.MOST_LISTED
    assert listed(found, "time") == [(2502, "x")]
    assert [finding.line for finding in found.findings] == sorted(finding.line for finding in found.findings)
    assert set(found.counts) <= set(KINDS)


def test_a_mark_that_is_not_closed_costs_its_line_alone():
    rows = [f'{k},{k},{k},"note"' for k in range(100)]
    rows[40] = '40,40,"40,note'
    rows[70] = '70,70,70,"two\nlines"'
    rows[99] = '99,99,99,"open'
    found = table(*rows, names="t,x,y,n")
    assert listed(found, "quote") == [(42, '40,40,"40,note'), (102, '99,99,99,"open')]
    assert listed(found, "lines") == [(72, '2 lines: 70,70,70,"two')]
    assert found.lines.tolist() == [*range(2, 42), 0, *range(43, 73), *range(74, 102)]


# The whole -----------------------------------------------------------------------------------------------------------


REFUSED = [
    (b"", Reading(), "columns must be at least 3, as the reading says: check the delimiter"),
    (b"t;x;y\n1;2;3\n", Reading(), "columns must be at least 3, as the reading says: check the delimiter"),
    (b"t,x,y\n", Reading(), "rows must follow the names, got 'none'"),
    (b"t,x,y\n0,1,2\n1,2,3\n", Reading(), "rows must hold at least 3 with a time and a position, got '2 measu"),
    (b"t,x,y\na,1,2\nb,2,3\nc,3,3\n", Reading(), "(found most: no time, 3 times)"),
    (b"0" * (bounds.MOST_BYTES + 1), Reading(), "file must have at most 10,000,000 bytes: thin it out, or"),
    (b"1,2,3\n" * (bounds.MOST_ROWS + 1), Reading(), "rows must be at most 200,000: thin the file out or"),
    (b"\n" * (bounds.MOST_LINES + 1), Reading(), "lines must be at most 400,000: thin the file out"),
    (b"1," * 1001, Reading(), "columns must be at most 1,000: check the delimiter, or leave columns out"),
    (b"1,2," + b"x" * 10_001, Reading(), "cell must have at most 10,000 characters, got '10,001 in line 1"),
    (b"1" * 100_001, Reading(), "line 1 must have at most 100,000 characters: is this a table?"),
    (gzip.compress(b"0" * (bounds.MOST_UNPACKED + 1)), Reading(), "file must unpack to at most 40,000,000 bytes"),
    (gzip.compress(b"t,x,y\n0,1,2\n")[:-9], Reading(), "file must be a whole gzip file: pack it again"),
    (b"PK\3\4...", Reading(), "file must be a table as text (CSV): save or export it as one, got 'a ZIP"),
    (bytes(range(256)) * 10, Reading(), "file must be a table as text (CSV): save or export it as one"),
    (gzip.compress((b"," * 40 + b"\n") * 150_000), Reading(at=(2, 3)), "cells (rows times columns) must be at"),
    (b'1,"2,3\n' * 250, Reading(), "quotation marks must be closed but for 200 at most: check the delimiter"),
]  # fmt: skip


@pytest.mark.parametrize(("data", "reading", "message"), REFUSED, ids=[str(k) for k in range(len(REFUSED))])
def test_refused(data, reading, message):
    with pytest.raises(InputError) as refused:
        read(data, reading)
    assert message in str(refused.value)


EXPERIMENTS = [
    {"scenario": "garg-constant-velocity"},
    {"scenario": "garg-accelerating"},
    {"samples": 40, "order": 4, "xi": 0.7, "interval": 0.1234567},
    {"scenario": "climbing-turn"},
    {"scenario": "constant-velocity", "noise_std": "0.1,1e6", "interval": 1 / 3},
    {"scenario": "jeong-ship"},
]


@pytest.mark.parametrize("values", EXPERIMENTS, ids=str)
def test_what_is_written_is_read_back(values):
    result = run_experiment(Experiment.from_dict(values))
    stream = io.StringIO()
    write_track(result, stream)
    seen = look(stream.getvalue().encode())
    found = read(stream.getvalue().encode(), seen.reading)
    assert seen.format == "Gainscope track"
    assert found.axes == ("x", "y", "z")[: len(result.scenario.axes)]
    assert np.array_equal(found.positions, result.measurements.positions, equal_nan=True)
    assert np.array_equal(found.truth, result.truth.positions)
    assert found.interval == pytest.approx(result.measurements.interval, rel=1e-14)
    assert found.times == pytest.approx(result.truth.times - result.truth.times[0], rel=1e-13)


@given(st.lists(st.lists(st.floats(-1e8, 1e8), min_size=2, max_size=2), min_size=3, max_size=30), st.randoms())
def test_the_order_of_rows_does_not_matter(places, shuffle):
    rows = [f"{k},{x!r},{y!r}" for k, (x, y) in enumerate(places)]
    straight = table(*rows)
    shuffle.shuffle(rows)
    found = table(*rows)
    assert np.array_equal(found.positions, straight.positions)
    assert np.array_equal(found.positions, places)


# The recordings of the house -----------------------------------------------------------------------------------------


def made():
    spec = importlib.util.spec_from_file_location("make_recordings", ROOT / "scripts" / "recordings.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["good.csv", "irregular.csv", "dirty.csv"])
def test_the_recordings_are_those_that_the_script_makes(name):
    script = made()
    written = (script.TARGET / name).read_text(encoding="utf-8")
    assert written == script.RECORDINGS[name]()
    assert len(written) < 60_000


def recorded(name):
    data = (made().TARGET / name).read_bytes()
    seen = look(data)
    return seen, read(data, seen.reading)


def test_the_good_recording():
    seen, found = recorded("good.csv")
    assert (seen.format, seen.reading.text()) == ("t, x, y", "truth:4.5")
    assert (found.interval, len(found.times), found.counts) == (0.1, 400, {})
    assert np.std(found.positions - found.truth) == pytest.approx(5, rel=0.1)


def test_the_irregular_recording():
    seen, found = recorded("irregular.csv")
    assert seen.format == "MarineCadastre AIS"
    assert seen.reading.text() == "time:2,clock:iso,frame:geographic,at:3.4,track:1,only:211000101"
    assert seen.tracks == (("211000101", 300), ("211000202", 220))
    assert (found.interval, found.measured, found.others, found.axes) == (None, 300, 220, ("east", "north"))
    assert found.regularity.odd > 0.5
    assert found.start == "2024-05-04 06:30:12 UTC"


def test_the_dirty_recording():
    seen, found = recorded("dirty.csv")
    assert seen.format == "ADS-B log (lat/lon/alt)"
    assert seen.reading.text() == "frame:geographic,at:3.4.5,units:ft,held:missing"
    assert (found.interval, len(found.times), found.axes) == (1, 420, ("east", "north", "up"))
    assert found.counts == {
        "time": 1, "position": 3, "empty": 1, "beyond": 1, "order": 3, "duplicate": 5, "held": 23, "gap": 4,
    }  # fmt: skip
    assert found.positions[0] == pytest.approx([0, 0, 0], abs=1e-9)
    assert found.place == pytest.approx((48.32022, 11.40007, 6325 * 0.3048), rel=1e-12)
