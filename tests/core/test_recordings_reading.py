"""The description of how a file is read: its text and itself are inverse, and it refuses what it does not know."""

import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core.checks import InputError
from tracker_core.recordings import DECIMALS, DELIMITERS, FRAMES, HELD, Reading
from tracker_core.recordings.clocks import CLOCKS
from tracker_core.recordings.units import ANGLES, LENGTHS


@st.composite
def readings(draw):
    frame = draw(st.sampled_from(sorted(FRAMES)))
    fewest, most = FRAMES[frame]
    axes = draw(st.integers(fewest, most))
    column = st.integers(2, 1000)
    columns = st.lists(column, min_size=axes, max_size=axes).map(tuple)
    track = draw(st.integers(0, 1000))
    units = draw(st.integers(1, 1) if frame != "plane" else st.sampled_from([1, axes]))
    return Reading(
        delimiter=draw(st.sampled_from(sorted(DELIMITERS))),
        decimal=draw(st.sampled_from(sorted(DECIMALS))),
        header=draw(st.booleans()),
        time=draw(st.integers(0, 1)),
        interval=draw(st.floats(1e-6, 1e6)),
        clock=draw(st.sampled_from(sorted(CLOCKS))),
        frame=frame,
        at=draw(columns),
        units=tuple(draw(st.sampled_from(sorted(LENGTHS))) for _ in range(units)),
        angle=draw(st.sampled_from(sorted(ANGLES))),
        truth=draw(st.one_of(st.just(()), columns)),
        track=track,
        only=draw(st.text(st.characters(exclude_categories=["Cs"]), min_size=1 if track else 0, max_size=100)),
        held=draw(st.sampled_from(HELD)),
    )


@given(readings())
def test_text_is_inverse(reading):
    assert Reading.from_text(reading.text()) == reading


@given(readings())
def test_text_fits_a_link(reading):
    assert set(reading.text()) <= set(string.ascii_letters + string.digits + ":,.%_-~+")
    assert len(reading.text()) <= 2_000


def test_the_default_has_no_text():
    assert Reading().text() == ""
    assert Reading.from_text("") == Reading()


def test_text_holds_what_differs():
    reading = Reading(clock="iso", frame="geographic", at=(3, 4, 5), units=("ft",), track=2, only="A,é:<b>")
    assert reading.text() == "clock:iso,frame:geographic,at:3.4.5,units:ft,track:2,only:A%2C%C3%A9%3A%3Cb%3E"


def test_axes_are_named_after_the_frame():
    assert Reading(at=(2,)).axes == ("x",)
    assert Reading(at=(2, 3, 4)).axes == ("x", "y", "z")
    assert Reading(frame="geographic").axes == ("east", "north")
    assert Reading(frame="polar", at=(2, 3, 4)).axes == ("east", "north", "up")


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("clock", "reading"),
        ("colour:red", "reading"),
        ("clock:iso,clock:hms", "reading"),
        ("clock:sundial", "clock"),
        ("delimiter:;", "delimiter"),
        ("header:perhaps", "header"),
        ("time:-1", "time"),
        ("time:1.5", "time"),
        ("time:1e9", "time"),
        ("interval:0", "interval"),
        ("interval:nan", "interval"),
        ("interval:1e30", "interval"),
        ("at:", "at"),
        ("at:1.2.3.4,time:0", "at"),
        ("at:0.2", "at"),
        ("at:1001", "at"),
        ("at:a.b", "at"),
        ("at:1.2", "at"),
        ("frame:geographic,at:2", "at"),
        ("units:mile", "units"),
        ("units:m.m.m", "units"),
        ("frame:polar,units:m.m", "units"),
        ("angle:grad", "angle"),
        ("truth:4", "truth"),
        ("truth:1.4", "at"),
        ("track:3", "only"),
        ("only:" + "a" * 101, "only"),
        ("held:perhaps", "held"),
        ("only:" + "a" * 3000, "reading"),
        (None, "reading"),
        (7, "reading"),
    ],
)
def test_refused(text, field):
    with pytest.raises(InputError) as refused:
        Reading.from_text(text)
    assert refused.value.field == field


@given(st.text(st.sampled_from(":,.%09atimeclokhdr-"), max_size=60))
def test_any_text_is_read_or_refused(text):
    try:
        reading = Reading.from_text(text)
    except InputError:
        return
    assert Reading.from_text(reading.text()) == reading
