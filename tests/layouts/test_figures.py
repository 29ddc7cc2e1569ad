"""Figures: each kind of data looks the same everywhere, and what is drawn is what was computed."""

import json
import math

import numpy as np
import orjson
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from layouts.figures import comparison, error, stability_map, track
from layouts.figures.common import (
    DRAWN_MARKERS,
    DRAWN_SAMPLES,
    SERIES,
    clipped,
    coordinates,
    drawn,
    grain,
    grained,
    moving,
    packed,
    padded_range,
    thinned,
    xy,
)
from layouts.figures.error import running_rms, window
from layouts.figures.track import CLOSE_UP_SAMPLES, close_up_rows
from layouts.shown import Shown
from layouts.state import Settings, View
from layouts.theme import THEMES, tokens
from tracker_core import SCENARIOS, Experiment, run_experiment

TITLES = {"True": "truth", "Observed": "observed", "Predicted": "predicted", "Smoothed": "smoothed"}
FLAT = {"design": "manual", "order": 2, "alpha": 0.5, "beta": 0.2}
WILD = {"design": "manual", "order": 2, "alpha": 1.9, "beta": 1.5}
SLUGGISH = {"design": "fading-memory", "order": 2, "xi": 0.95}
JERK = {"design": "fading-memory", "order": 4, "xi": 0.8}


def run(**values):
    return run_experiment(Experiment.from_dict(values))


def shown_of(result, view=None, theme="light"):
    return Shown(result, Settings(result.experiment, view or View()), theme, {"seq": 1})


def plots(result, view=None, theme="light"):
    """Every plot of a result by name."""
    shown = shown_of(result, view, theme)
    return {
        "path": track.path_figure(shown),
        "close-up": track.close_up_figure(shown),
        "axis": track.axis_figure(shown),
        "error": error.error_figure(shown),
        "stability": stability_map.small_map(shown),
    }


@given(
    values=st.lists(st.floats(-1e6, 1e6, width=32) | st.just(math.nan), max_size=20),
    dtype=st.sampled_from(["f4", "f8"]),
)
def test_a_packed_array_keeps_the_numbers_that_its_text_holds(values, dtype):
    """They are read off it where it was made; a browser, or who has it from there, has the text alone."""
    array = packed(np.array(values), dtype)
    sent = json.loads(orjson.dumps(array))
    assert set(sent) == {"dtype", "bdata"}
    np.testing.assert_array_equal(coordinates(array), np.array(values, dtype="f4"))
    np.testing.assert_array_equal(coordinates(sent), coordinates(array))


def series(figure):
    """The traces of the four kinds of data, by kind; the faint lines behind a running mean are none."""
    return {
        TITLES[trace["name"]]: trace
        for trace in figure["data"]
        if trace.get("name") in TITLES and trace.get("showlegend", True)
    }


def lines_of(figure):
    """The traces that have coordinates."""
    return [trace for trace in figure["data"] if "x" in trace]


def points(trace):
    return np.stack([coordinates(trace["x"]), coordinates(trace["y"])], axis=1)


def same(one, other):
    """Equal to the last bit, NaN included."""
    return orjson.dumps(one, option=orjson.OPT_SORT_KEYS) == orjson.dumps(other, option=orjson.OPT_SORT_KEYS)


# Looks -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scenario", ["jeong-ship", "garg-accelerating"])
@pytest.mark.parametrize("theme", THEMES)
def test_each_kind_of_data_looks_the_same_on_every_plot(theme, scenario):
    looks = {kind: set() for kind in SERIES}
    for name, figure in plots(run(scenario=scenario), theme=theme).items():
        for kind, trace in series(figure).items():
            if kind == "observed":
                marker = {key: value for key, value in trace["marker"].items() if key != "size"}
                looks[kind].add((trace["name"], trace["mode"], json.dumps(marker)))
            else:
                looks[kind].add((trace["name"], json.dumps(trace["line"])))
        if name in ("path", "close-up", "axis"):
            assert list(series(figure)) == list(SERIES)
    assert {kind: len(found) for kind, found in looks.items()} == dict.fromkeys(SERIES, 1)


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("plot", ["path", "close-up", "axis", "error"])
def test_lines_are_told_apart_without_colour(plot, theme):
    kinds = series(plots(run(), theme=theme)[plot])
    assert kinds["predicted"]["line"]["dash"] not in ("", "solid")
    assert kinds["smoothed"]["line"].get("dash", "solid") == "solid"
    widths = {kind: trace["line"]["width"] for kind, trace in kinds.items() if kind != "observed"}
    assert all(widths["smoothed"] > width for kind, width in widths.items() if kind != "smoothed")
    for kind, trace in kinds.items():
        colour = trace["marker"]["color"] if kind == "observed" else trace["line"]["color"]
        assert colour == tokens(theme)[kind]


@pytest.mark.parametrize("plot", ["path", "close-up", "axis"])
def test_measurements_are_hollow_and_never_joined(plot):
    observed = series(plots(run())[plot])["observed"]
    assert observed["mode"] == "markers"
    assert "line" not in observed
    assert observed["marker"]["symbol"].endswith("-open")


@pytest.mark.parametrize("theme", THEMES)
def test_a_running_mean_lies_before_faint_lines(theme):
    figure = plots(run(), theme=theme)["error"]
    faint = [trace for trace in figure["data"] if trace.get("name") in TITLES and not trace.get("showlegend", True)]
    assert [trace["name"] for trace in faint] == ["Predicted", "Smoothed"]
    for index, trace in enumerate(faint):
        assert figure["data"][index] is trace
        assert trace["line"]["width"] < series(figure)[TITLES[trace["name"]]]["line"]["width"]
    assert all(trace.get("visible") is False for trace in plots(run(samples=80))["error"]["data"][:2])


@pytest.mark.parametrize("theme", THEMES)
def test_every_plot_has_the_colours_of_its_theme(theme):
    other = set(tokens("dark" if theme == "light" else "light").values()) - set(tokens(theme).values())
    for figure in plots(run(), View(axis=1, quantity=1), theme).values():
        text = json.dumps(figure)
        assert figure["layout"]["template"]["layout"]["paper_bgcolor"] == tokens(theme)["surface"]
        assert [colour for colour in other if f'"{colour}"' in text] == []


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_every_axis_says_what_it_shows_and_in_which_unit(scenario):
    axes, result = SCENARIOS[scenario].axes, run(scenario=scenario, design="fading-memory", order=4, xi=0.8)
    for quantity, unit in enumerate(("m", "m/s", "m/s²", "m/s³")):
        for axis, name in enumerate(axes):
            figure = plots(result, View(axis=axis, quantity=quantity))["axis"]
            state = ("", " velocity", " acceleration", " jerk")[quantity]
            assert figure["layout"]["xaxis"]["title"]["text"] == "time (s)"
            assert figure["layout"]["yaxis"]["title"]["text"] == f"{name}{state} ({unit})"
    several = len(axes) > 1
    for figure in (plots(result)["path"], plots(result)["close-up"]):
        expected = (f"{axes[0]} (m)", f"{axes[1]} (m)") if several else ("time (s)", f"{axes[0]} (m)")
        assert tuple(figure["layout"][axis]["title"]["text"] for axis in ("xaxis", "yaxis")) == expected
        # A path in the plane is not distorted.
        assert figure["layout"]["yaxis"].get("scaleanchor") == ("x" if several else None)
    assert plots(result)["error"]["layout"]["yaxis"]["title"]["text"] == "distance to the truth (m)"
    titles = [plots(result)["stability"]["layout"][axis]["title"]["text"] for axis in ("xaxis", "yaxis")]
    assert titles == ["α", "β"]


# What is drawn -----------------------------------------------------------------------------------------------------


def assert_drawn(got, exact, span):
    """What is drawn is the run to a part in 131,000 of what is seen: a hundred times enlarged, less than a pixel."""
    np.testing.assert_array_equal(np.isnan(got), np.isnan(exact))
    assert np.all(np.isnan(exact) | (np.abs(got - exact) <= span * 2.0**-17 + np.spacing(np.abs(exact).astype("f4"))))


@given(
    values=st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=1, max_size=50),
    offset=st.sampled_from([0.0, 1e3, -1e9]),
    size=st.sampled_from([1e-300, 1e-3, 1.0, 1e5, 1e300]),
)
def test_nothing_is_rounded_by_more_than_half_a_grain(values, offset, size):
    with np.errstate(over="ignore", invalid="ignore"):
        values = np.array(values) % 1 * size + offset
    step = float(grain(values))
    finite = values[np.isfinite(values)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    drawn = grained(values, step)
    np.testing.assert_array_equal(np.isfinite(drawn), np.isfinite(values))
    if not span:
        assert math.isnan(step)
        np.testing.assert_array_equal(drawn, values)
        return
    assert 2**-17 < step / span <= 2**-16 or step < 1e-300
    assert np.all(np.abs(drawn - values)[np.isfinite(values)] <= step / 2)
    # What is drawn is drawn where it is.
    np.testing.assert_array_equal(grained(drawn, step), drawn)


@pytest.mark.parametrize("quantity", [0, 1, 2])
@pytest.mark.parametrize("axis", [0, 1])
def test_the_lines_are_the_run(axis, quantity):
    result = run(samples=120)
    view = View(axis=axis, quantity=quantity)
    path, states = series(plots(result, view)["path"]), series(plots(result, view)["axis"])
    times = result.truth.times.astype("f4")
    everywhere = np.ptp(np.concatenate((result.truth.positions, result.measurements.positions)), axis=0)
    low, high = plots(result, view)["axis"]["layout"]["yaxis"]["range"]
    for kind, values in (
        ("truth", result.truth.states),
        ("predicted", result.track.predicted),
        ("smoothed", result.track.smoothed),
    ):
        assert_drawn(points(path[kind]), values[:, :, 0], everywhere)
        np.testing.assert_array_equal(points(states[kind])[:, 0], times)
        span = high - low if quantity else everywhere[axis]
        assert_drawn(points(states[kind])[:, 1], values[:, axis, quantity], span)
    assert_drawn(points(path["observed"]), result.measurements.positions, everywhere)
    assert states["observed"]["visible"] is (quantity == 0)


@pytest.mark.parametrize("factor", [1, 2, 5, 10, 20, 50, 100])
@pytest.mark.parametrize("scenario", ["jeong-ship", "garg-accelerating"])
def test_exaggeration_multiplies_deviations_from_the_truth_and_nothing_else(scenario, factor):
    result, rows = run(scenario=scenario, samples=10), slice(None)
    view = View(exaggerate=factor)
    truth = result.truth.positions
    wanted = {
        "truth": truth,
        "observed": result.measurements.positions,
        "predicted": result.track.predicted[:, :, 0],
        "smoothed": result.track.smoothed[:, :, 0],
    }
    everywhere = np.ptp(np.concatenate((truth, wanted["observed"])), axis=0)
    for name, span in (("path", everywhere), ("close-up", 0.0)):
        for kind, trace in series(plots(result, view)[name]).items():
            got = points(trace)[rows]
            assert_drawn(got if truth.shape[1] > 1 else got[:, 1:], truth + factor * (wanted[kind] - truth), span)
    # Numbers are not drawings: the other plots do not change.
    for name in ("axis", "error", "stability"):
        assert same(plots(result, view)[name], plots(result)[name])


@given(samples=st.integers(1, 200_000), data=st.data())
@example(samples=3, data=None)
@example(samples=30, data=None)
@example(samples=31, data=None)
def test_the_close_up_always_holds_the_cursor(samples, data):
    cursors = [0, samples // 2, samples - 1] if data is None else [data.draw(st.integers(0, samples - 1))]
    for cursor in cursors:
        rows = range(samples)[close_up_rows(samples, cursor)]
        assert cursor in rows
        assert len(rows) == min(samples, CLOSE_UP_SAMPLES + 1)
        if CLOSE_UP_SAMPLES // 2 <= cursor < samples - CLOSE_UP_SAMPLES // 2 - 1:
            assert cursor == rows[len(rows) // 2]


@pytest.mark.parametrize("at", [0, 10, 100, 198, 199])
@pytest.mark.parametrize("scenario", ["jeong-ship", "constant-velocity"])
def test_the_ring_marks_the_sample_looked_at(scenario, at):
    result = run(scenario=scenario, samples=200, start="known")
    figures = plots(result, View(at=at))
    ring, smoothed = points(figures["close-up"]["data"][4]), points(series(figures["close-up"])["smoothed"])
    first = figures["close-up"]["layout"]["meta"]["first"]
    np.testing.assert_array_equal(ring[0], smoothed[at - first])
    np.testing.assert_array_equal(points(figures["path"]["data"][4])[0], points(series(figures["path"])["truth"])[at])
    for name, index in (("axis", 4), ("error", 5)):
        assert points(figures[name]["data"][index])[:, 0].tolist() == [np.float32(result.truth.times[at])] * 2


@pytest.mark.parametrize("samples", [3, 80, 81, 1000, 5000, 5001, 12_345])
@pytest.mark.parametrize("design", [{"gate": 1.5}, {"design": "growing-memory"}], ids=["constant", "method"])
def test_a_point_knows_which_sample_it_is(samples, design):
    """What a click on a plot is turned into: its own number, else first + number of the point * every."""
    result = run(samples=samples, scenario="garg-constant-velocity", noise="white", noise_std=100, **design)
    times, shown = result.truth.times, shown_of(result, View(at=samples - 1))
    figures = plots(result, View(at=samples - 1)) | {"gains": comparison.gains_overlay(shown)}
    del figures["stability"]
    own = set()
    for figure in figures.values():
        meta = figure["layout"]["meta"]
        for trace in figure["data"]:
            if trace.get("hoverinfo") == "skip" or trace.get("visible") is False:
                continue
            x, numbers = coordinates(trace["x"]), trace.get("customdata")
            if numbers is None:
                step = meta["every_marker"] if trace["mode"] == "markers" else meta["every"]
                numbers = packed(meta["first"] + step * np.arange(len(x)), "i4")
            elif len(x):
                own.add(trace["name"])
            np.testing.assert_array_equal(x, times[coordinates(numbers).astype(int)].astype("f4"))
    # Of a constant gain a few points are drawn, and of the measurements those that were not believed.
    assert own == ({"Present", *(["Not believed"] if samples > 3 else [])} if "gate" in design else set())


@given(samples=st.integers(3, 200_000))
def test_few_enough_points_are_drawn_of_any_run(samples):
    assert len(range(samples)[drawn(samples)]) <= DRAWN_SAMPLES
    assert len(range(samples)[thinned(samples)]) <= DRAWN_MARKERS
    assert samples > DRAWN_SAMPLES or drawn(samples).step == 1
    assert samples > DRAWN_MARKERS or thinned(samples).step == 1


def test_the_longest_run_gives_small_figures():
    result = run(samples=200_000)
    for figure in plots(result).values():
        for trace in lines_of(figure):
            assert len(points(trace)) <= DRAWN_SAMPLES
            assert trace["mode"] != "markers" or len(points(trace)) <= DRAWN_MARKERS
        assert len(orjson.dumps(figure)) < 400_000
    # Thinned, not cut off: what is drawn reaches to the end.
    assert points(plots(result)["path"]["data"][0]).shape == (5000, 2)
    np.testing.assert_allclose(
        coordinates(plots(result)["axis"]["data"][0]["x"])[-1], result.truth.times[-1], rtol=1e-3
    )


# What stays while the gains move -----------------------------------------------------------------------------------

FILTERS = [{"xi": 0.2}, {"xi": 0.95}, FLAT, WILD, SLUGGISH, JERK]


@pytest.mark.parametrize("scenario", ["jeong-ship", "constant-acceleration", "garg-accelerating"])
@pytest.mark.parametrize("gains", FILTERS, ids=str)
def test_the_path_stays_where_it_is_while_the_gains_move(scenario, gains):
    usual = {"scenario": scenario, "order": 3, "design": "fading-memory", "xi": 0.6}
    before = plots(run(**usual))["path"]
    after = plots(run(**({"order": 3, "design": "fading-memory"} | gains), scenario=scenario))["path"]
    assert same(before["layout"], after["layout"])
    for kind in ("truth", "observed"):
        assert same(series(before)[kind], series(after)[kind])


@pytest.mark.parametrize("quantity", [0, 1, 2])
def test_the_axes_of_a_state_stay_where_they_are_while_the_gains_move(quantity):
    view = View(axis=1, quantity=quantity)
    layouts = [plots(run(xi=xi), view)["axis"]["layout"] for xi in (0.1, 0.6, 0.95)]
    assert layouts[0] == layouts[1] == layouts[2]


@pytest.mark.parametrize("gains", FILTERS, ids=str)
def test_no_zoom_is_lost_while_the_gains_move(gains):
    view = View(axis=1, quantity=1, at=40)
    kept = [
        {name: figure["layout"]["uirevision"] for name, figure in plots(run(**more), view).items()}
        for more in (
            {"order": 3, "design": "fading-memory", "xi": 0.6},
            {"order": 3, "design": "fading-memory"} | gains,
        )
    ]
    assert kept[0] == kept[1]


@pytest.mark.parametrize(
    ("view", "changed"),
    [
        (View(axis=1), {"axis"}),
        (View(quantity=1), {"axis"}),
        (View(at=3), {"close-up"}),
        (View(exaggerate=5), {"close-up"}),
    ],
)
def test_another_view_gets_a_zoom_of_its_own(view, changed):
    result = run()
    before, after = plots(result), plots(result, view)
    assert {
        name for name in before if before[name]["layout"]["uirevision"] != after[name]["layout"]["uirevision"]
    } == changed
    for target in ({"samples": 300}, {"interval": 2}, {"scenario": "constant-velocity"}):
        other = plots(run(**target))
        kept = {name for name in before if before[name]["layout"]["uirevision"] == other[name]["layout"]["uirevision"]}
        assert kept == {"stability"}


@pytest.mark.parametrize(
    "plot",
    [
        "path",
        "close-up",
        "axis",
        "error",
    ],
)
@pytest.mark.parametrize("gains", [WILD, {**WILD, "order": 3, "gamma": 1.0}], ids=str)
def test_a_diverging_run_does_not_spoil_the_axes(plot, gains):
    result = run(**gains)
    assert result.track.stopped_at is not None
    layout = plots(result)[plot]["layout"]
    for axis in ("xaxis", "yaxis"):
        low, high = layout[axis]["range"]
        assert -1e5 < low < high < 1e5


def test_what_is_drawn_of_a_diverging_run_can_be_written_in_32_bits():
    for figure in plots(run(**WILD)).values():
        for trace in lines_of(figure):
            assert not np.isinf(points(trace)).any()


# The error ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("samples", [60, 200])
def test_the_error_is_the_distance_to_the_truth(samples):
    result = run(samples=samples)
    data = plots(result)["error"]["data"]
    deviation = result.track.smoothed[:, :, 0] - result.truth.positions
    expected = np.array([math.hypot(*row) for row in deviation])
    assert_drawn(coordinates(data[1]["y"]), expected, plots(result)["error"]["layout"]["yaxis"]["range"][1])
    assert (data[1].get("visible", True) is False) == (samples == 60)
    raw = result.measurements.positions - result.truth.positions
    level = math.sqrt(sum(math.hypot(*row) ** 2 for row in raw) / samples)
    np.testing.assert_allclose(coordinates(data[4]["y"]), [level, level], rtol=1e-6)
    assert data[4]["name"] == "Measurement RMSE"


def test_the_lines_of_a_short_run_are_the_errors_themselves():
    data = plots(run(samples=60))["error"]["data"]
    assert data[0]["y"] == data[2]["y"]
    assert data[1]["y"] == data[3]["y"]


@given(
    values=st.lists(st.floats(0, 1e3) | st.just(math.nan), min_size=1, max_size=60),
    half=st.integers(0, 40),
)
def test_the_running_rms_is_that_of_a_plain_loop(values, half):
    got = running_rms(np.array(values), 2 * half + 1)
    for i, mean in enumerate(got):
        near = [value for value in values[max(0, i - half) : i + half + 1] if not math.isnan(value)]
        if near:
            assert mean == pytest.approx(math.sqrt(sum(v * v for v in near) / len(near)), rel=1e-6, abs=1e-4)
        else:
            assert math.isnan(mean)


@given(samples=st.integers(3, 200_000))
def test_the_window_is_odd_and_a_fortieth_of_the_run(samples):
    width = window(samples)
    assert width % 2 == 1
    assert width == 1 if samples <= 80 else abs(width - samples / 40) <= 1


@pytest.mark.parametrize(
    "values",
    [
        {"noise": "none"},
        {"noise": "none", "scenario": "constant-velocity", "order": 2, "design": "fading-memory", "xi": 0.5},
        {"noise_std": 0},
        {"noise_std": 1e9},
        {"noise_std": 1e-300},
        {"samples": 3},
        {"samples": 3, "start": "three-point"},
        {"interval": 1e-6},
        {"interval": 1e6, "scenario": "constant-acceleration"},
        {"xi": 0},
        {"xi": 0.999999},
        {"scenario": "garg-accelerating", "samples": 3},
    ],
    ids=str,
)
@pytest.mark.parametrize("theme", THEMES)
def test_an_extreme_run_is_drawn_all_the_same(values, theme):
    for figure in plots(run(**values), theme=theme).values():
        for axis in ("xaxis", "yaxis"):
            low, high = figure["layout"][axis]["range"]
            assert math.isfinite(low)
            assert math.isfinite(high)
            assert low < high


# The stability map -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("gains", "stable", "region"),
    [
        (FLAT, True, True),
        (WILD, False, True),
        (JERK, True, True),
        ({"xi": 0.5}, True, True),
        ({"design": "manual", "order": 3, "alpha": 0.5, "beta": 0.2, "gamma": -0.1}, False, False),
        ({"design": "manual", "order": 3, "alpha": 0.5, "beta": 0.2, "gamma": 0.5}, False, True),
        ({"design": "manual", "order": 4, "alpha": 0.5, "beta": 0.2, "gamma": 0.1, "eta": -0.1}, False, False),
    ],
    ids=str,
)
@pytest.mark.parametrize("theme", THEMES)
def test_the_operating_point_says_whether_it_is_stable(gains, stable, region, theme):
    result = run(**gains)
    figure = plots(result, theme=theme)["stability"]
    border, curve, printed, *places, trail, point = figure["data"]
    assert [point["x"], point["y"]] == [[value] for value in result.gains.vector[:2].tolist()]
    look = ("circle", tokens(theme)["good"]) if stable else ("x", tokens(theme)["bad"])
    assert (point["marker"]["symbol"], point["marker"]["color"]) == look
    assert (len(points(border)) > 0) == region
    assert len(points(trail)) == 0
    order = result.gains.order
    said = [note["text"] for note in figure["layout"]["annotations"]]
    if not region:
        assert said == [f"no α, β is stable with this {'γ' if order == 3 else 'γ, η'}"]
    else:
        assert said == (["underdamped", "overdamped", "alternating"] if order == 2 else [])
    assert (len(points(curve)) > 0) == (order == 2)
    assert (len(points(printed)) > 0) == (order > 2 and min(result.gains.vector[2:]) > 0)
    assert [place["visible"] for place in places] == [False, False]


def test_the_dotted_curve_is_critical_damping():
    alpha, beta = points(plots(run(**FLAT))["stability"]["data"][1]).T.astype(float)
    # A double root: the discriminant of z² + (α + β − 2) z + 1 − α vanishes.
    np.testing.assert_allclose((alpha + beta - 2) ** 2, 4 * (1 - alpha), atol=1e-6)


# Parts -------------------------------------------------------------------------------------------------------------


@given(values=st.lists(st.floats(width=32, allow_nan=True)))
def test_packed_numbers_come_back(values):
    np.testing.assert_array_equal(coordinates(packed(np.array(values))), np.array(values, dtype="f4"))


def test_typed_arrays_are_as_plotly_reads_them():
    assert packed(np.array([1.0, -2.0])) == {"dtype": "f4", "bdata": "AACAPwAAAMA="}


@given(values=st.lists(st.floats(-1e30, 1e30) | st.just(math.nan)), margin=st.floats(0.01, 0.5))
def test_a_range_shows_every_finite_value(values, margin):
    low, high = padded_range(np.array(values), margin)
    assert low < high
    assert all(low <= value <= high for value in values if math.isfinite(value))


@given(values=st.lists(st.floats(allow_nan=True, allow_infinity=True)), limit=st.floats(0, 1e6))
def test_nothing_beyond_the_limit_is_drawn(values, limit):
    got = clipped(np.array(values), limit)
    for value, shown in zip(values, got.tolist(), strict=True):
        assert shown == value if abs(value) <= limit else math.isnan(shown)


def test_moving_parts_are_taken_by_their_path():
    figure = {"data": [{"x": 1, "y": 2}, {"x": 3, "y": 4}], "layout": {"meta": {"seq": 5}}}
    assert moving(figure, (("layout", "meta"), *xy(1))) == [
        (("layout", "meta"), {"seq": 5}),
        (("data", 1, "x"), 3),
        (("data", 1, "y"), 4),
    ]


def test_a_figure_does_not_depend_on_which_was_made_before():
    result = run()
    first = {name: orjson.dumps(figure) for name, figure in plots(result).items()}
    plots(run(**WILD), View(axis=1, quantity=1, exaggerate=5, at=3), "dark")
    assert {name: orjson.dumps(figure) for name, figure in plots(result).items()} == first
