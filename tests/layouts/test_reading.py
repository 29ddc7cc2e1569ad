"""How a file is read, as controls: there and back, one field at a time, whatever comes in."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layouts.controls import controls_of, resolve
from layouts.reading import READING_FIELDS, fields_read, follow_reading, labels_read, reading_controls, reading_of
from layouts.state import Settings
from tracker_core import Experiment
from tracker_core.checks import InputError
from tracker_core.measured import SHELF, File
from tracker_core.recordings import DECIMALS, DELIMITERS, HELD, Reading
from tracker_core.recordings.clocks import CLOCKS
from tracker_core.recordings.units import ANGLES, LENGTHS

ROWS = range(40)


def shelf(text, name="log.csv"):
    return SHELF.keep(File(name, text.encode()))


def controls(data, **reading):
    values = {"data": data} | ({"reading": Reading(**reading).text() or "time:1"} if reading else {})
    return controls_of(Settings(Experiment.from_dict(values)))


@pytest.fixture
def plane():
    """t, x, y, z, id: two targets in turn."""
    rows = (f"{row},{2 * row},{3 * row % 17},{row * row},{'AB'[row % 2]}" for row in ROWS)
    return shelf("t,x,y,z,id\n" + "\n".join(rows) + "\n")


@st.composite
def readings(draw):
    frame = draw(st.sampled_from(["plane", "geographic", "polar"]))
    axes = draw(st.integers(1 if frame == "plane" else 2, 3))
    column = st.integers(2, 1000)
    at = tuple(draw(st.lists(column, min_size=axes, max_size=axes)))
    several = frame == "plane" and draw(st.booleans())
    units = tuple(draw(st.lists(st.sampled_from(list(LENGTHS)), min_size=axes, max_size=axes)) if several else ["m"])
    track = draw(st.just(0) | column)
    return Reading(
        delimiter=draw(st.sampled_from(list(DELIMITERS))),
        decimal=draw(st.sampled_from(list(DECIMALS))),
        header=draw(st.booleans()),
        time=draw(st.sampled_from([0, 1])),
        interval=draw(st.floats(1e-6, 1e6)),
        clock=draw(st.sampled_from(list(CLOCKS))),
        frame=frame,
        at=at,
        units=units if len({*units}) > 1 else units[:1],
        angle=draw(st.sampled_from(list(ANGLES))),
        truth=draw(st.sampled_from([(), at])),
        track=track,
        only=draw(st.text(min_size=1, max_size=9)) if track else "",
        held=draw(st.sampled_from(HELD)),
    )


@given(readings())
def test_controls_say_the_whole_reading(reading):
    said = reading_controls(reading)
    assert said.keys() == {*READING_FIELDS}
    assert reading_of(said, []) == reading
    assert fields_read(said).keys() <= said.keys()
    assert labels_read(said).keys() <= said.keys()


def test_what_a_file_is_read_by_stands_in_the_controls(plane):
    stands = controls(plane)
    assert {name: stands[name] for name in ("read_time", "read_at1", "read_at3", "read_frame", "read_clock")} == {
        "read_time": "1", "read_at1": "2", "read_at3": "4", "read_frame": "plane", "read_clock": "seconds",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("moved", "part"),
    [
        ({"read_at2": "4", "read_at3": "0"}, "at:2.4"),
        ({"read_at2": "0", "read_at3": "0"}, "at:2"),
        ({"read_units1": "km", "read_units2": "ft", "read_units3": "m"}, "units:km.ft.m"),
        ({"read_clock": "milliseconds"}, "clock:milliseconds"),
        ({"read_time": "0", "read_interval": "0.5"}, "time:0"),
        ({"read_frame": "polar"}, "frame:polar"),
        ({"read_track": "5"}, "track:5,only:A"),
        ({"read_held": "missing"}, "held:missing"),
        ({"read_truth1": "3", "read_truth2": "4", "read_truth3": "2"}, "truth:3.4.2"),
    ],
)
def test_one_field_changes_the_link_and_what_is_run(plane, moved, part):
    before = controls(plane, at=(2, 3, 4))
    resolution = resolve({**before, **moved}, list(moved))
    assert resolution.errors == ()
    assert part in resolution.settings.experiment.reading
    for name, value in moved.items():
        assert str(resolution.controls[name]) == value
    # Another reading is another target: its sensor is estimated anew.
    assert resolution.settings.experiment.noise == "recorded"


def test_a_track_brings_its_most_frequent_id_and_another_can_be_chosen(plane):
    chosen = resolve({**controls(plane), "read_track": "5"}, ["read_track"])
    assert chosen.controls["read_only"] == "A"
    assert chosen.settings.experiment.samples == 20
    other = resolve({**chosen.controls, "read_only": "B"}, ["read_only"])
    assert other.settings.experiment.reading.endswith("only:B")
    nobody = resolve({**chosen.controls, "read_only": "<b>C</b>"}, ["read_only"])
    assert [error.field for error in nobody.errors] == ["reading"]
    none = resolve({**other.controls, "read_track": "0"}, ["read_track"])
    assert "track" not in none.settings.experiment.reading
    assert none.controls["read_only"] == ""


def test_a_frame_takes_as_many_columns_as_it_needs():
    one = shelf("t,a,b\n" + "\n".join(f"{row},{40 + row / 1000},{row / 500}" for row in ROWS))
    stands = controls(one, at=(2,))
    moved = resolve({**stands, "read_frame": "geographic"}, ["read_frame"])
    assert moved.settings.experiment.target.axes == ("east", "north")
    assert [moved.controls[f"read_at{slot}"] for slot in (1, 2, 3)] == ["2", "3", "0"]
    # The columns of a truth are none in another frame.
    two = controls(one, at=(2, 3), truth=(2, 3))
    assert "truth" not in resolve({**two, "read_frame": "polar"}, ["read_frame"]).settings.experiment.reading


def test_what_cannot_be_read_is_refused_and_mended_step_by_step(plane):
    wrong = resolve({**controls(plane), "read_time": "5"}, ["read_time"])
    assert [error.field for error in wrong.errors] == ["reading"]
    assert wrong.controls["read_time"] == "5"
    # A second change counts beside the first one.
    still = resolve({**wrong.controls, "read_held": "missing"}, ["read_held"])
    assert [error.field for error in still.errors] == ["reading"]
    mended = resolve({**still.controls, "read_time": "1"}, ["read_time"])
    assert mended.errors == ()
    assert mended.settings.experiment.reading.endswith("held:missing")


def test_columns_that_contradict_each_other_are_refused_with_a_word(plane):
    wrong = resolve({**controls(plane), "read_at1": "1"}, ["read_at1"])
    assert wrong.errors[0].field == "reading"
    assert "must not name the column of the time" in wrong.errors[0].rule
    assert wrong.controls["read_at1"] == "1"


def test_a_file_whose_proposal_fails_can_be_read_by_hand():
    text = "when,what\n" + "\n".join(f"{'x' if row < 38 else row},{row}" for row in range(40))
    rest = "\n".join(f"{100 + row},{row * row},{row}" for row in range(30))
    data = shelf(f"{text}\n{rest}\n")
    refused = resolve({**controls_of(Settings(Experiment.from_dict({}))), "data": data}, ["data"])
    stands = refused.controls
    # Right or wrong, the controls say how it would be read.
    assert stands["read_time"] in map(str, range(10))
    opened = resolve({**stands, "read_time": "0", "read_at1": "2", "read_at2": "0"}, ["read_time", "read_at1"])
    assert opened.errors == ()
    assert opened.settings.experiment.reading.startswith("time:0")


def test_back_to_the_proposal(plane):
    changed = resolve({**controls(plane), "read_at2": "4", "read_at3": "0"}, ["read_at2", "read_at3"])
    back = resolve({**changed.controls, "reading": ""}, ["reading"])
    assert back.controls["read_at2"] == "3"
    assert back.settings.experiment == Experiment.from_dict({"data": plane})


def test_another_file_is_read_as_proposed_for_it(plane):
    other = shelf("a;b\n" + "\n".join(f"{row},5;{row * row}" for row in ROWS))
    moved = resolve({**controls(plane), "data": other}, ["data"])
    assert (moved.controls["read_delimiter"], moved.controls["read_decimal"]) == ("semicolon", "comma")
    assert moved.settings.experiment.data == other


def test_names_and_ids_stay_what_they_are():
    rows = "\n".join(f"{row},{row},{row * 2},{'<img src=x>' if row % 2 else '=1+1'}" for row in ROWS)
    data = shelf(f"<b>t</b>,x,y,id\n{rows}")
    moved = resolve({**controls(data), "read_track": "4"}, ["read_track"])
    moved = resolve({**moved.controls, "read_only": "<img src=x>"}, ["read_only"])
    assert moved.errors == ()
    assert moved.controls["read_only"] == "<img src=x>"
    again = Experiment.from_dict(moved.settings.experiment.to_dict(minimal=True))
    assert again == moved.settings.experiment


VALUES = st.one_of(st.none(), st.integers(), st.floats(), st.text(max_size=9), st.sampled_from(["0", "1", "yes", "km"]))


@given(st.dictionaries(st.sampled_from(READING_FIELDS), VALUES, max_size=6), st.data())
def test_whatever_comes_is_a_reading_or_refused(values, data):
    held = {"data": shelf("t,x,y\n1,2,3\n2,3,4\n3,4,5\n4,5,6\n"), **values}
    moved = data.draw(st.lists(st.sampled_from([*READING_FIELDS, "reading", "data", "xi"]), max_size=4, unique=True))
    refused = ""
    try:
        names = follow_reading(held, list(moved))
    except InputError as error:
        refused = error.field
    assert refused in ("", "reading", "data")
    if not refused and {*READING_FIELDS} & {*moved}:
        assert not {*READING_FIELDS} & {*names}
        assert Reading.from_text(held["reading"]) is not None
