"""What scenes show: which pictures are accepted, what of them is drawn, and where it lies in the box."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layouts.scenes import RegionPicture, TrackPicture
from layouts.scenes.pictures import DRAWN_SAMPLES, SERIES, TRAIL_SAMPLES
from layouts.scenes.region import BOX, REACH, _places
from layouts.scenes.stage import Axis, Pin, channels, joined, mixed, round_step
from layouts.scenes.track import FLAT, HEIGHT, box_of, points_of
from layouts.theme import THEMES, tokens
from tracker_core.checks import InputError


def track(samples=50, axes=2, *, seed=1, scale=1e4, **changed):
    rng = np.random.default_rng(seed)
    values = {
        "key": "run",
        "times": np.arange(samples) * 2.0,
        "truth": scale * rng.normal(size=(samples, axes)),
        "cursor": samples // 2,
    }
    values |= {name: values["truth"] + rng.normal(size=(samples, axes)) for name in SERIES[1:]}
    return TrackPicture(**values | changed)


# Refusals ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changed", "field"),
    [
        ({"gains": (0.5, 0.5)}, "gains"),
        ({"gains": (0.5, 0.5, 0.1, 0.1)}, "gains"),
        ({"gains": (math.nan, 0.5, 0.1)}, "alpha"),
        ({"gains": (0.5, math.inf, 0.1)}, "beta"),
        ({"gains": (0.5, 0.5, "x")}, "gamma"),
        ({"theme": "blue"}, "theme"),
    ],
)
def test_a_region_that_cannot_be_drawn_is_refused(changed, field):
    with pytest.raises(InputError) as refused:
        RegionPicture(**{"gains": (0.5, 0.5, 0.1), "stable": True, **changed})
    assert refused.value.field == field


@pytest.mark.parametrize(
    ("changed", "field"),
    [
        ({"times": np.zeros((50, 1))}, "times"),
        ({"times": np.empty(0)}, "times"),
        ({"times": np.full(50, np.nan)}, "times"),
        ({"truth": np.zeros((49, 2))}, "truth"),
        ({"observed": np.zeros(50)}, "observed"),
        ({"predicted": np.zeros((50, 3))}, "predicted"),
        ({"smoothed": np.zeros((50, 1))}, "smoothed"),
        ({"cursor": 50}, "cursor"),
        ({"cursor": -1}, "cursor"),
        ({"names": ("x",)}, "names"),
        ({"theme": ""}, "theme"),
        ({"refused": np.zeros(49, dtype=bool)}, "refused"),
        ({"refused": np.zeros((50, 2), dtype=bool)}, "refused"),
    ],
)
def test_a_track_that_cannot_be_drawn_is_refused(changed, field):
    with pytest.raises(InputError) as refused:
        track(**changed)
    assert refused.value.field == field


@pytest.mark.parametrize("axes", [0, 4])
def test_a_track_has_one_to_three_axes(axes):
    with pytest.raises(InputError, match="truth must have the shape"):
        track(truth=np.zeros((50, axes)))


# What is drawn -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("samples", [1, 2, DRAWN_SAMPLES, DRAWN_SAMPLES + 1, 10 * DRAWN_SAMPLES])
def test_no_more_is_drawn_than_can_be_seen(samples):
    picture = track(samples)
    drawing = picture.thinned()
    assert len(drawing.times) <= DRAWN_SAMPLES
    assert drawing.times[0] == picture.times[0]
    step = math.ceil(samples / DRAWN_SAMPLES)
    np.testing.assert_array_equal(drawing.times, picture.times[::step])
    for name in SERIES:
        np.testing.assert_array_equal(drawing.series[name], getattr(picture, name)[::step])


@pytest.mark.parametrize("every", [1, 7, 9_999])
def test_what_a_gate_refused_is_drawn_however_little_else_is(every):
    refused = np.arange(20_000) % every == 0
    picture = track(20_000, refused=refused)
    drawing, gone = picture.thinned(), np.flatnonzero(refused)
    step = math.ceil(len(gone) / DRAWN_SAMPLES)
    np.testing.assert_array_equal(drawing.refused_times, picture.times[gone[::step]])
    np.testing.assert_array_equal(drawing.refused, picture.observed[gone[::step]])
    assert track(refused=None).thinned().refused.shape == (0, 2)


@pytest.mark.parametrize("cursor", [0, 5, TRAIL_SAMPLES, 12_345])
def test_the_cursor_is_where_it_is_however_little_is_drawn(cursor):
    picture = track(20_000, cursor=cursor, trail=True)
    drawing = picture.thinned()
    assert drawing.cursor_time == picture.times[cursor]
    np.testing.assert_array_equal(drawing.cursor["smoothed"], picture.smoothed[cursor])
    np.testing.assert_array_equal(drawing.cursor["observed"], picture.observed[cursor])
    assert len(drawing.trail) == min(cursor, TRAIL_SAMPLES) + 1
    np.testing.assert_array_equal(drawing.trail[-1], picture.smoothed[cursor])
    assert len(track(20_000, cursor=cursor).thinned().trail) == 0


def test_what_is_remembered_does_not_hold_the_run():
    drawing = track(20_000, trail=True, refused=np.ones(20_000, dtype=bool)).thinned()
    arrays = [drawing.times, *drawing.series.values(), *drawing.cursor.values(), drawing.trail, drawing.trail_times]
    arrays += [drawing.refused, drawing.refused_times]
    assert all(array.base is None for array in arrays)


def test_a_line_is_the_same_when_its_numbers_are():
    before = track(predicted=np.where(np.arange(50)[:, None] < 3, np.nan, 1.0) * np.ones((50, 2))).thinned()
    again = track(predicted=np.where(np.arange(50)[:, None] < 3, np.nan, 1.0) * np.ones((50, 2))).thinned()
    other = track().thinned()
    assert before.same_line(again, "predicted")
    assert not before.same_line(other, "predicted")
    assert before.same_line(other, "smoothed")


@pytest.mark.parametrize("changed", [{"key": "another"}, {"theme": "dark"}, {"names": ("a", "b")}, {"axes": 3}])
def test_another_run_needs_another_scene(changed):
    assert track().thinned().still != track(**changed).thinned().still
    assert track().thinned().still == track(cursor=3, smoothed=np.zeros((50, 2))).thinned().still


# The box -----------------------------------------------------------------------------------------------------------


@given(st.floats(1e-12, 1e12))
def test_a_round_step_is_the_next_of_1_2_5(step):
    got = round_step(step)
    assert step * (1 - 1e-9) <= got <= 2.5 * step * (1 + 1e-9)
    leading = got / 10.0 ** math.floor(math.log10(got) + 1e-9)
    assert min(abs(leading - one) for one in (1, 2, 5, 10)) < 1e-9


@given(st.floats(-1e6, 1e6), st.floats(1, 1e9), st.sampled_from([1.0, 1e3]))
def test_ticks_are_few_round_numbers_within_the_axis(low, span, unit):
    axis = Axis("x", low, low + span, 1.0, unit)
    ticks = axis.ticks() / unit
    assert 2 <= len(ticks) <= 6
    slack = 1e-8 * span + 1e-12 * abs(low)
    assert (ticks * unit >= axis.low - slack).all()
    assert (ticks * unit <= axis.high + slack).all()
    step = round_step(span / unit / 5)
    np.testing.assert_allclose(ticks / step, np.round(ticks / step), atol=1e-6, rtol=1e-12)


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6), st.floats(0.1, 2))
def test_an_axis_runs_from_end_to_end_about_the_middle(low, span, size):
    axis = Axis("x", low, low + span, size)
    np.testing.assert_allclose(axis.place(np.array([axis.low, axis.high])), [-size / 2, size / 2], rtol=1e-6)
    assert axis.place_one(low + span / 3) == axis.place(np.array([low + span / 3]))[0]


def test_a_minus_sign_is_one():
    axis = Axis("x", -2e4, 2e4, 1.0, 1e3)
    assert [axis.text(tick) for tick in axis.ticks()] == ["−20", "−10", "0", "10", "20"]


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e7])
def test_truth_and_measurements_lie_in_a_box_of_about_unit_size(axes, scale):
    drawing = track(axes=axes, scale=scale).thinned()
    box = box_of(drawing)
    for name in ("truth", "observed"):
        points = points_of(box, drawing.times, drawing.series[name])
        assert (np.abs(points) <= np.array([axis.size / 2 for axis in box]) * (1 + 1e-5)).all()
    assert 0.8 <= max(axis.size for axis in box) <= 1.5


@pytest.mark.parametrize("axes", [2, 3])
def test_x_and_y_are_on_one_scale(axes):
    """A circle stays one, however long or high the track is."""
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    circle = np.stack((3000 + 500 * np.cos(angle), -200 + 500 * np.sin(angle), 1e-3 * angle), axis=1)[:, :axes]
    drawing = track(100, axes=axes, truth=circle, **dict.fromkeys(SERIES[1:], circle)).thinned()
    points = points_of(box_of(drawing), drawing.times, drawing.series["truth"])
    radii = np.linalg.norm(points[:, :2] - points[:, :2].mean(axis=0), axis=1)
    np.testing.assert_allclose(radii, radii[0], rtol=1e-5)
    width, depth, _ = box_of(drawing)
    assert width.size / (width.high - width.low) == pytest.approx(depth.size / (depth.high - depth.low), rel=1e-12)


def test_time_is_the_height_of_a_plane_track():
    drawing = track().thinned()
    time = box_of(drawing)[2]
    assert (time.title, time.low, time.high, time.size) == ("time (s)", 0.0, 98.0, HEIGHT)
    heights = points_of(box_of(drawing), drawing.times, drawing.series["smoothed"])[:, 2]
    np.testing.assert_allclose(heights, np.linspace(-HEIGHT / 2, HEIGHT / 2, 50), atol=1e-6)


def test_a_height_of_little_is_stretched_and_says_so_in_its_numbers():
    low = np.stack((np.linspace(0, 1e5, 50), np.linspace(0, 1e5, 50), np.linspace(0, 100, 50)), axis=1)
    box = box_of(track(axes=3, truth=low, **dict.fromkeys(SERIES[1:], low)).thinned())
    assert box[2].size == FLAT
    assert [axis.title for axis in box] == ["x (km)", "y (km)", "z (m)"]


def test_one_axis_lies_flat_against_time():
    drawing = track(axes=1, names=("range",)).thinned()
    assert [axis.title for axis in box_of(drawing)] == ["time (s)", "range (km)", ""]
    assert (points_of(box_of(drawing), drawing.times, drawing.series["truth"])[:, 2] == 0).all()


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_a_target_that_stands_still_for_one_sample_has_a_box(axes):
    drawing = track(1, axes=axes, cursor=0, **dict.fromkeys(SERIES, np.zeros((1, axes)))).thinned()
    for axis in box_of(drawing):
        assert axis.high > axis.low
        assert axis.size > 0


def test_a_run_that_diverges_does_not_spoil_the_picture():
    wild = np.cumprod(np.full((50, 2), 10.0), axis=0)
    drawing, calm = track(predicted=wild).thinned(), track().thinned()
    assert box_of(drawing) == box_of(calm)
    points = points_of(box_of(drawing), drawing.times, drawing.series["predicted"])
    finite = np.isfinite(points).all(axis=1)
    assert not finite.all()
    assert np.abs(points[finite]).max() < 10


# Lines and colours -------------------------------------------------------------------------------------------------


def test_a_line_is_broken_where_a_point_is_missing():
    points = np.arange(18, dtype=np.float32).reshape(6, 3)
    points[2, 1] = np.nan
    segments = joined(points)
    np.testing.assert_array_equal(segments, [[points[0], points[1]], [points[3], points[4]], [points[4], points[5]]])


@pytest.mark.parametrize("count", [0, 1])
def test_a_line_of_nothing_is_a_segment_without_length(count):
    segments = joined(np.ones((count, 3), dtype=np.float32))
    assert segments.shape == (1, 2, 3)
    np.testing.assert_array_equal(segments[:, 0], segments[:, 1])


def test_a_pin_is_a_closed_ball_with_rods():
    pin = Pin(0.5, (0, 1))
    vertices = pin.vertices((1.0, 2.0, 3.0), (1.0, 2.0, 0.0))
    ball, rod = vertices[:-6], vertices[-6:]
    np.testing.assert_allclose(np.linalg.norm(ball - [1, 2, 3], axis=1), 0.5, rtol=1e-6)
    np.testing.assert_allclose([rod[:3].mean(axis=0)[2], rod[3:].mean(axis=0)[2]], [3, 0], atol=1e-3)
    assert pin.faces.max() == len(vertices) - 1
    # The area of a sphere, so no triangle is missing or there twice.
    corners = vertices[pin.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    assert area[:-6].sum() == pytest.approx(4 * np.pi * 0.5**2, rel=0.05)


def test_a_pin_at_no_place_is_not_seen():
    assert not Pin(0.5, (0, 1)).vertices((np.nan, 0.0, 0.0), (0.0, 0.0, 0.0)).any()


@given(st.tuples(*[st.floats(-1e9, 1e9)] * 3))
def test_gains_far_outside_are_drawn_at_the_border(gains):
    where, foot, left, front = _places(RegionPicture(gains, stable=False))
    for place, gain, axis in zip(where, gains, BOX, strict=True):
        assert abs(place) <= axis.size * (0.5 + REACH) + 1e-12
        if axis.low <= gain <= axis.high:
            assert place == pytest.approx(axis.place_one(gain), abs=1e-12)
    assert foot[:2] == where[:2]
    assert foot[2] == left[2] == front[2] == -BOX[2].size / 2
    assert (left[1], front[0]) == (where[1], where[0])


@pytest.mark.parametrize("theme", THEMES)
def test_the_colours_are_those_of_the_page(theme):
    names = ["truth", "observed", "predicted", "smoothed", "good", "bad", "region-line", "surface", "marker", "line"]
    for name in names:
        red, green, blue = channels(tokens(theme)[name])
        assert tokens(theme)[name] == f"#{red:02x}{green:02x}{blue:02x}"
    assert mixed((255, 0, 10), (0, 0, 30), 1) == (255, 0, 10)
    assert mixed((255, 0, 10), (0, 0, 30), 0) == (0, 0, 30)
