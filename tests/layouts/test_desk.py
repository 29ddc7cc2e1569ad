"""What every page with plots and sliders does: figures, the parts of them that moved, lines, errors."""

import copy
import json
from dataclasses import replace
from urllib.parse import parse_qsl

import numpy as np
import orjson
import pytest
from dash import Patch, no_update
from hypothesis import example, given, settings
from hypothesis import strategies as st

from layouts.controls import controls_of, resolve
from layouts.desk import answer, beginning, live_answer
from layouts.figures.common import coordinates, moving_traces
from layouts.live import framed
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pages.track.answers import DESK as TRACK
from layouts.rules import presets
from layouts.state import Limits, Settings, View, from_query
from layouts.theme import THEMES
from tracker_core import DESIGNS, SCENARIOS, Experiment

DESKS = (EXPLORE, STABILITY, TRACK)
ON_EVERY_PAGE = pytest.mark.parametrize("desk", DESKS, ids=lambda desk: desk.page)
WILD = {"design": "manual", "order": 2, "alpha": 1.9, "beta": 1.5}
# Everything that is computed only while no slider moves.
RICH = View(beside=True, exaggerate=5, background="lag", input="ramp")
LIMITS = Limits(limit_noise=0.4, limit_lag=50.0)


def patched(figure, patch):
    """The figure after a Patch, as dash-renderer applies it."""
    figure = copy.deepcopy(figure)
    for operation in patch.to_plotly_json()["operations"]:
        assert operation["operation"] == "Assign"
        *way, last = operation["location"]
        part = figure
        for step in way:
            part = part[step]
        assert last in part
        part[last] = operation["params"]["value"]
    return figure


def shown_after(figure, update):
    """What the browser shows after an update of a plot."""
    if update is no_update:
        return figure
    return patched(figure, update) if isinstance(update, Patch) else update


def written(value):
    """As it goes over the wire; two equal ones are equal to the last bit, NaN included."""
    return orjson.dumps(value, option=orjson.OPT_SORT_KEYS)


def ask(desk, request_for, controls, moved=None, **more):
    """The plots of an answer by name, and the rest of it."""
    updates, rest = answer(desk, request_for(controls, moved, **more))
    assert len(updates) == len(desk.plots) + len(desk.tables)
    return dict(zip(desk.plots, updates, strict=False)), rest


def lines_of(figure):
    """The traces of a figure that have coordinates."""
    return [trace for trace in figure["data"] if "x" in trace]


# Where a page begins -----------------------------------------------------------------------------------------------


@ON_EVERY_PAGE
@pytest.mark.parametrize(
    "query",
    [
        {},
        {"scenario": "garg-accelerating", "seed": "3"},
        {"order": "3", "xi": "0.5", "axis": "y", "plane": "beta-gamma", "background": "lag", "limit_lag": "3.5"},
        {"samples": "2", "colour": "red", "limit_noise": "-1", "pin": "seed=x"},
    ],
    ids=str,
)
def test_a_page_begins_as_the_link_says(desk, query):
    data = beginning(desk, query)
    wanted, notes = from_query(query)
    assert data["controls"] == controls_of(wanted)
    assert data["notes"] == notes
    assert (Experiment.from_dict(data["pin"]) if data["pin"] else None) == wanted.pin
    # The script sends them back as its first question.
    assert resolve(json.loads(json.dumps(data["controls"])), [], data["pin"]).settings == wanted


@ON_EVERY_PAGE
def test_every_plot_and_table_of_a_page_is_asked_for(desk):
    data = beginning(desk, {})
    assert sorted([*data["often"], *data["inTurn"]]) == sorted(desk.plots)
    # The script takes one of the others with every change.
    assert data["often"]
    assert data["inTurn"]
    assert data["tables"] == list(desk.tables)
    assert data["page"] == desk.page


@ON_EVERY_PAGE
@given(wanted=st.from_type(Settings))
@settings(max_examples=25)
def test_the_link_of_an_answer_begins_the_same_page(request_for, desk, wanted):
    values = wanted.experiment.to_dict() | {"samples": min(wanted.experiment.samples, 50)}
    wanted = replace(wanted, experiment=Experiment.from_dict(values), view=replace(wanted.view, at=None))
    pin = wanted.pin.to_dict() if wanted.pin else None
    rest, _ = live_answer(desk, request_for(controls_of(wanted), pin=pin))
    again = beginning(desk, dict(parse_qsl(rest["link"])))
    assert (again["controls"], again["pin"], again["notes"]) == (rest["controls"], pin, [])


# The first answer and those that follow ----------------------------------------------------------------------------


@ON_EVERY_PAGE
def test_the_first_answer_draws_everything(controls_for, request_for, desk):
    drawn, rest = ask(desk, request_for, controls_for())
    for figure in drawn.values():
        assert isinstance(figure, dict)
        assert figure["data"]
        assert figure["layout"]["meta"]["seq"] == rest["seq"] == 7
        assert figure["layout"]["meta"]["gains"] == rest["gains"]
        assert figure["layout"]["meta"]["stable"] is True
    assert rest["ok"]
    assert set(rest["drawn"]) == set(desk.plots)
    assert rest["experiment"] == Experiment.from_dict({}).to_dict()


@ON_EVERY_PAGE
@pytest.mark.parametrize("theme", THEMES)
def test_every_figure_is_drawn_in_the_theme_of_the_page(controls_for, request_for, desk, theme):
    drawn, _ = ask(desk, request_for, controls_for(), theme=theme)
    assert {figure["layout"]["meta"]["theme"] for figure in drawn.values()} == {theme}


@pytest.mark.parametrize("theme", [None, "", "sepia", 5, ["dark"]])
def test_without_a_known_theme_it_is_the_light_one(controls_for, request_for, theme):
    drawn, _ = ask(TRACK, request_for, controls_for(), theme=theme)
    assert {figure["layout"]["meta"]["theme"] for figure in drawn.values()} == {"light"}


MOVEMENTS = {
    "alpha": 0.33, "xi": 0.33, "tracking_index": 0.33, "fixed_alpha": 0.33, "members": 7, "grid": 3,
}  # fmt: skip


def movement(run):
    """A move of what the run's design is computed from; of alpha where it is computed from nothing."""
    name = next((name for name in MOVEMENTS if getattr(run, name) is not None), "alpha")
    return {name: MOVEMENTS[name]}


STEPS = {
    "order 2": ({"order": 2, "design": "fading-memory", "xi": 0.7}, {"xi": 0.4}),
    "order 3": ({}, {"xi": 0.9}),
    "order 4": ({"order": 4, "design": "fading-memory", "xi": 0.7}, {"xi": 0.85}),
    "another order": ({"order": 4, "design": "fading-memory", "xi": 0.7}, {"order": 2}),
    "another design": ({}, {"design": "gray-murray"}),
    "by hand": ({}, {"alpha": 0.4}),
    "by the knob": ({}, {"responsiveness": 0.3}),
    "a point": ({}, {"point": "alpha-beta 0.4 0.3"}),
    "a pole": ({"order": 2, "design": "fading-memory", "xi": 0.5}, {"pole": "0 0.3 0.4  0.5 0  0.5 0"}),
    "another start": ({"samples": 40}, {"start": "expanding"}),
    "another convention": ({}, {"convention": "half"}),
    "into instability": ({"order": 2, "design": "manual", "alpha": 0.5, "beta": 0.3}, {"beta": 3.8}),
    "out of instability": (WILD, {"beta": 0.1}),
    "unstable at order 3": ({"order": 3, "design": "manual", "alpha": 0.5, "beta": 0.3, "gamma": 0.1}, {"gamma": -1}),
    "unstable at order 4": ({"order": 4, "design": "fading-memory", "xi": 0.7}, {"eta": 5}),
    "unstable but short": ({"order": 2, "design": "manual", "alpha": 0.5, "beta": 0.3, "samples": 6}, {"beta": 3.5}),
    "sluggish": ({"order": 2, "design": "fading-memory", "xi": 0.5}, {"xi": 0.999}),
    "short": ({"samples": 60}, {"xi": 0.3}),
    "three samples": ({"samples": 3}, {"xi": 0.3}),
    "thinned": ({"samples": 12_000}, {"xi": 0.3}),
    "without noise": ({"noise": "none"}, {"xi": 0.3}),
    "one axis": ({"scenario": "constant-acceleration"}, {"xi": 0.3}),
    "a method beside its counterpart": ({"design": "parallel-bank"}, {"members": 5}),
    "an oracle instead of gains": (
        {"order": 2, "design": "fading-memory"},
        {"design": "parallel-bank"},
    ),
    "gains instead of an oracle": ({"design": "parallel-bank"}, {"design": "fading-memory"}),
    "a method that corrects nothing": (
        {"design": "growing-memory", "order": 3, "samples": 3, "noise": "none"},
        {"start": "three-point"},
    ),
    "a method instead of gains": ({"order": 2, "design": "fading-memory"}, {"design": "moving-window"}),
    "gains instead of a method": ({"order": 2, "design": "growing-memory"}, {"beta": 0.4}),
    **{key: (run.to_dict(), movement(run)) for key, run in presets().items()},
}


@ON_EVERY_PAGE
@pytest.mark.parametrize(("start", "moved"), STEPS.values(), ids=STEPS)
def test_patches_make_the_full_figures(controls_for, request_for, desk, start, moved):
    controls = controls_for(RICH, LIMITS, **start)
    first, rest = ask(desk, request_for, controls)
    updates, again = ask(desk, request_for, controls, moved, drawn=rest["drawn"])
    full, _ = ask(desk, request_for, controls, moved)
    for plot in desk.plots:
        assert isinstance(updates[plot], Patch) == (rest["drawn"][plot] == again["drawn"][plot]), plot
        assert written(shown_after(first[plot], updates[plot])) == written(full[plot]), plot


@pytest.mark.parametrize("quantity", [1, 2])
@pytest.mark.parametrize("moved", [{"xi": 0.1}, {"alpha": 0.9}, {"beta": 3.9}], ids=str)
def test_patches_make_the_full_plot_of_every_state(controls_for, request_for, quantity, moved):
    controls = controls_for(View(quantity=quantity, axis=1))
    first, rest = ask(EXPLORE, request_for, controls)
    updates, _ = ask(EXPLORE, request_for, controls, moved, drawn=rest["drawn"])
    full, _ = ask(EXPLORE, request_for, controls, moved)
    assert isinstance(updates["explore-time"], Patch)
    assert written(patched(first["explore-time"], updates["explore-time"])) == written(full["explore-time"])


@pytest.mark.parametrize(
    "view",
    [
        View(plane=("alpha", "gamma"), background="noise"),
        View(plane=("beta", "gamma"), background="lag", input="parabola"),
    ],
    ids=str,
)
def test_patches_make_the_full_map_of_every_plane(controls_for, request_for, view):
    controls = controls_for(view, Limits(limit_overshoot=30.0))
    for moved in ({"xi": 0.2}, {"gamma": -0.5}, {"limit_overshoot": "5"}):
        first, rest = ask(STABILITY, request_for, controls)
        updates, _ = ask(STABILITY, request_for, controls, moved, drawn=rest["drawn"])
        full, _ = ask(STABILITY, request_for, controls, moved)
        assert isinstance(updates["stability-map"], Patch)
        assert written(patched(first["stability-map"], updates["stability-map"])) == written(full["stability-map"])


CHANGES = st.fixed_dictionaries(
    {},
    optional={
        "scenario": st.sampled_from(list(SCENARIOS)),
        "samples": st.integers(3, 120),
        "interval": st.sampled_from([1, 3, 0.5]),
        "noise": st.sampled_from(["white", "none"]),
        "noise_std": st.sampled_from(["10", "20"]),
        "seed": st.integers(1, 2),
        "order": st.sampled_from([2, 3, 4]),
        "xi": st.floats(0, 0.95),
        # As many digits as a slider gives.
        "alpha": st.integers(100, 2000).map(lambda step: step / 1000),
        "beta": st.integers(-1000, 4000).map(lambda step: step / 1000),
        "point": st.sampled_from(["alpha-beta 0.5 0.4", "beta-gamma 0.3 0.02", "gamma-eta 0.1 0.01"]),
        "responsiveness": st.sampled_from([0, 0.4, 1]),
        "design": st.sampled_from(list(DESIGNS)),
        "convention": st.sampled_from(["normalised", "half"]),
        "start": st.sampled_from(["known", "first", "two-point", "expanding"]),
        "axis": st.sampled_from(["x", "y"]),
        "quantity": st.sampled_from(["position", "velocity"]),
        "exaggerate": st.sampled_from(["1", "10"]),
        "at": st.integers(1, 9),
        "plane": st.sampled_from(["alpha-beta", "alpha-gamma", "gamma-eta"]),
        "background": st.sampled_from(["none", "noise", "lag"]),
        "input": st.sampled_from(["step", "ramp", "parabola"]),
        "limit_noise": st.sampled_from(["", "0.3"]),
        "limit_lag": st.sampled_from(["", "9", "-9"]),
        "theme": st.sampled_from(list(THEMES)),
    },
)


@ON_EVERY_PAGE
@settings(max_examples=40)
@given(data=st.data())
def test_after_any_changes_the_page_shows_what_a_new_page_would(controls_for, request_for, desk, data):
    """Over several answers, errors among them: patches and keys together never leave a plot behind."""
    usual = controls_for(samples=100)
    controls, shown, keys, theme = usual, dict.fromkeys(desk.plots), {}, "light"
    for _ in range(data.draw(st.integers(2, 5))):
        moved = data.draw(CHANGES)
        theme = moved.pop("theme", theme)
        updates, rest = ask(desk, request_for, controls, moved, drawn=keys, theme=theme)
        json.dumps(rest, allow_nan=False)
        controls = rest["controls"]
        if not rest["ok"]:
            assert all(update is no_update for update in updates.values())
            controls = {**controls, **{name: usual[name] for name in rest["errors"] if name in usual}}
            continue
        shown = {plot: shown_after(shown[plot], update) for plot, update in updates.items()}
        keys |= rest["drawn"]
        fresh, _ = ask(desk, request_for, controls, theme=theme)
        for plot, figure in shown.items():
            assert written(figure) == written(fresh[plot]), plot


EVERYTHING = {plot for desk in DESKS for plot in desk.plots}
MAPS = {"explore-stability", "stability-map"}
RESPONSES = {"stability-response", "stability-frequency"}
PATHS = {"explore-path", "stability-path", "track-path"}
TARGET = EVERYTHING - MAPS - RESPONSES - {"stability-poles", "explore-gains"}


@pytest.mark.parametrize(
    ("moved", "anew"),
    [
        ({"xi": 0.5}, set()),
        ({"xi": 0.95}, {"stability-response"}),
        ({"alpha": 0.5}, set()),
        ({"point": "alpha-beta 0.6 0.3"}, set()),
        ({"responsiveness": 0.7}, set()),
        ({"design": "gray-murray"}, set()),
        ({"convention": "taylor"}, set()),
        ({"start": "first"}, set()),
        # At the middle of the run its gains are small already, and their response long.
        ({"design": "growing-memory"}, {*MAPS, "explore-gains", "stability-response"}),
        ({"noise": "coloured"}, TARGET),
        ({"manoeuvre": "jerk-pulses"}, TARGET),
        ({"noise_level": "snr"}, TARGET),
        ({"limit_noise": "0.5"}, set()),
        ({"order": 2}, MAPS),
        ({"plane": "beta-gamma"}, {"stability-map"}),
        ({"background": "noise"}, {"stability-map"}),
        ({"input": "ramp"}, {"stability-response"}),
        ({"axis": "y"}, {"explore-time"}),
        ({"quantity": "velocity"}, {"explore-time"}),
        ({"at": 30}, {"explore-close-up"}),
        ({"exaggerate": "10"}, PATHS | {"explore-close-up"}),
        ({"seed": 2}, TARGET),
        ({"noise": "none"}, TARGET),
        ({"noise_std": "11"}, TARGET),
        ({"interval": 2}, TARGET | RESPONSES),
        ({"samples": 300}, TARGET),
        ({"scenario": "constant-velocity"}, TARGET | RESPONSES),
        ({"theme": "dark"}, EVERYTHING),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else f"{len(value)}-plots",
)
@ON_EVERY_PAGE
def test_a_plot_is_drawn_anew_where_more_than_the_gains_moved(controls_for, request_for, desk, moved, anew):
    controls, plots = controls_for(), set(desk.plots)
    _, rest = ask(desk, request_for, controls)
    theme = moved.get("theme", "light")
    hand = {name: value for name, value in moved.items() if name != "theme"}
    updates, _ = ask(desk, request_for, controls, hand, drawn=rest["drawn"], theme=theme)
    assert {plot for plot, update in updates.items() if not isinstance(update, Patch)} == anew & plots
    # The short way sends no lines for those, and says so.
    text, arrays = live_answer(
        desk, request_for(controls, hand, drawn=rest["drawn"], theme=theme, want=list(desk.plots))
    )
    assert set(text["outdated"]) == anew & plots
    assert set(text["lines"]) == plots - anew
    assert len(arrays) == 2 * sum(len(traces) for traces in text["lines"].values())


@ON_EVERY_PAGE
def test_only_what_is_wanted_is_drawn(controls_for, request_for, desk):
    one = list(desk.plots)[-1]
    drawn, rest = ask(desk, request_for, controls_for(), want=[one, "no-such-plot"])
    assert {plot for plot, update in drawn.items() if update is not no_update} == {one}
    assert set(rest["drawn"]) == {one}


# The short way -----------------------------------------------------------------------------------------------------


def read_frame(message):
    """The text and the numbers of a message, as desk.js takes it apart."""
    length = int.from_bytes(message[:4], "little")
    assert length % 4 == 0
    return json.loads(message[4 : 4 + length]), np.frombuffer(message[4 + length :], dtype="<f4")


@ON_EVERY_PAGE
@pytest.mark.parametrize(("start", "moved"), STEPS.values(), ids=STEPS)
def test_the_lines_sent_live_are_those_of_the_figures(controls_for, request_for, desk, start, moved):
    controls = controls_for(RICH, LIMITS, **start)
    _, rest = ask(desk, request_for, controls)
    full, slow = ask(desk, request_for, controls, moved)
    question = request_for(controls, moved, drawn=rest["drawn"], want=list(desk.plots))
    text, numbers = read_frame(framed(*live_answer(desk, question)))
    at = 0
    assert text["outdated"] == [plot for plot in desk.plots if rest["drawn"][plot] != slow["drawn"][plot]]
    assert list(text["lines"]) == [plot for plot in desk.plots if plot not in text["outdated"]]
    for plot, traces in text["lines"].items():
        assert [index for index, _ in traces] == moving_traces(desk.plots[plot].moving)
        for index, length in traces:
            for axis in ("x", "y"):
                np.testing.assert_array_equal(numbers[at : at + length], coordinates(full[plot]["data"][index][axis]))
                at += length
    assert at == len(numbers)
    # And all the readouts are the same, but for what takes long.
    shared = {name: value for name, value in text.items() if name not in ("lines", "outdated")}
    expected = {name: value for name, value in slow.items() if name != "drawn"} | {"offer": None}
    assert shared == json.loads(json.dumps(expected))


@ON_EVERY_PAGE
def test_lines_are_sent_for_the_wanted_plots_only(controls_for, request_for, desk):
    controls = controls_for()
    first, *_, last = desk.plots
    _, rest = ask(desk, request_for, controls)
    for want, expected in [([first, last], [first, last]), (None, []), ([], []), (["no-such-plot"], [])]:
        text, _ = live_answer(desk, request_for(controls, {"xi": 0.5}, drawn=rest["drawn"], want=want))
        assert list(text["lines"]) == expected


@ON_EVERY_PAGE
def test_before_anything_is_drawn_everything_is_outdated(controls_for, request_for, desk):
    text, arrays = live_answer(desk, request_for(controls_for(), want=list(desk.plots)))
    assert (text["lines"], text["outdated"], arrays) == ({}, list(desk.plots), [])


# Errors ------------------------------------------------------------------------------------------------------------


@ON_EVERY_PAGE
@pytest.mark.parametrize(
    ("moved", "field", "message"),
    [
        ({"samples": "2"}, "samples", "n must be a whole number >= 3 and <= 200,000, got “2”."),
        ({"alpha": "abc"}, "alpha", "α must be a finite number >= -1,000 and <= 1,000, got “abc”."),
        ({"xi": "1"}, "xi", "ξ must be a finite number >= 0 and < 1, got “1”."),
        ({"noise_std": "1,2,3"}, "noise_std",
         "σ must be one number, or 2 for the axes x, y, got “[1.0, 2.0, 3.0]”."),
        ({"noise": "recorded"}, "noise",
         "Noise must not be 'recorded': nothing was recorded for 'jeong-ship', got “recorded”."),
        ({"limit_lag": "0"}, "limit_lag", "Greatest lag must be a finite number > 0 and <= 1e+09, got “0”."),
        ({"responsiveness": "2"}, "responsiveness",
         "responsiveness must be a finite number >= 0 and <= 1, got “2”."),
    ],
)  # fmt: skip
def test_an_error_leaves_every_plot_as_it_is_and_stands_beside_its_field(
    controls_for, request_for, desk, moved, field, message
):
    question = request_for(controls_for(), moved, want=[*desk.plots, *desk.tables])
    updates, rest = answer(desk, question)
    assert all(update is no_update for update in updates)
    assert rest["errors"] == {field: message}
    assert (rest["ok"], rest["seq"]) == (False, 7)
    assert rest["controls"][field] == moved[field]
    assert live_answer(desk, question) == (rest, [])
    json.dumps(rest, allow_nan=False)


# Anything at all ---------------------------------------------------------------------------------------------------


@ON_EVERY_PAGE
@settings(max_examples=40)
@given(wanted=st.from_type(Settings))
@example(wanted=Settings(Experiment.from_dict({"interval": 1e6, "scenario": "constant-acceleration", "order": 4})))
@example(
    wanted=Settings(
        Experiment.from_dict({"design": "manual", "order": 3, "alpha": 1, "beta": 0.5, "gamma": 0.1}),
        View(plane=("beta", "gamma"), background="lag"),
    )
)
@example(
    wanted=Settings(
        Experiment.from_dict({"design": "manual", "order": 2, "alpha": 1, "beta": 2}), View(input="parabola")
    )
)
def test_any_settings_are_answered_in_json_and_drawn(request_for, desk, wanted):
    """Every scenario, design, start and magnitude, short enough to be quick."""
    values = wanted.experiment.to_dict() | {"samples": min(wanted.experiment.samples, 200)}
    wanted = replace(wanted, experiment=Experiment.from_dict(values), view=replace(wanted.view, at=None))
    pin = wanted.experiment.to_dict()
    question = request_for(controls_of(wanted), pin=pin, want=[*desk.plots, *desk.tables])
    updates, rest = answer(desk, question)
    json.dumps(rest, allow_nan=False)
    assert rest["ok"]
    for figure in updates[: len(desk.plots)]:
        json.dumps(figure, allow_nan=False)
        for trace in lines_of(figure):
            for axis in ("x", "y"):
                assert not np.isinf(coordinates(trace[axis])).any()
    text, arrays = live_answer(desk, question | {"drawn": rest["drawn"]})
    json.dumps(text, allow_nan=False)
    assert all(array.dtype == np.float32 for array in arrays)


@ON_EVERY_PAGE
def test_the_longest_run_is_answered_in_bounded_size(controls_for, request_for, desk):
    controls = controls_for(RICH, LIMITS, samples=200_000)
    drawn, rest = ask(desk, request_for, controls)
    for figure in drawn.values():
        assert all(len(coordinates(trace[axis])) <= 5_000 for trace in lines_of(figure) for axis in ("x", "y"))
    assert sum(len(orjson.dumps(figure)) for figure in drawn.values()) < 1_000_000
    question = request_for(controls, {"xi": 0.5}, drawn=rest["drawn"], want=list(desk.plots))
    assert len(framed(*live_answer(desk, question))) < 1_000_000
    assert len(json.dumps(rest)) < 10_000
