"""What the page is sent: figures, the parts of them that moved, readouts, messages, tables."""

import copy
import json
import math
import re
from functools import partial

import numpy as np
import orjson
import pytest
from dash import Patch, no_update
from dash.development.base_component import Component
from hypothesis import example, given, settings
from hypothesis import strategies as st

from layouts import desk
from layouts.controls import controls_of, presets
from layouts.figures.common import coordinates, moving_traces
from layouts.live import framed
from layouts.pages.explore.answers import CARDS, DESK, NUMBERS
from layouts.readouts import formula_text, offers, owned
from layouts.state import Settings, View
from layouts.text import change_text, metric_text, significant
from tracker_core import DESIGNS, METRICS, SCENARIOS, Experiment, run_experiment
from tracker_core.fields import FIELDS

answer, live_answer = (partial(function, DESK) for function in (desk.answer, desk.live_answer))
PLOTS = {name: plot.moving for name, plot in DESK.plots.items()}
PATH, CLOSE_UP, AXIS, ERROR, STABILITY = PLOTS
WITHOUT_AXIS = [plot for plot in PLOTS if plot != AXIS]
WILD = {"design": "manual", "order": 2, "alpha": 1.9, "beta": 1.5, "gamma": 1.0, "eta": 0.1}


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


def shown_after(shown, updates):
    """What the browser shows after the updates of an answer."""
    after = []
    for figure, update in zip(shown, updates, strict=True):
        if update is no_update:
            after.append(figure)
        else:
            after.append(patched(figure, update) if isinstance(update, Patch) else update)
    return after


def written(value):
    """As it goes over the wire; two equal ones are equal to the last bit, NaN included."""
    return orjson.dumps(value, option=orjson.OPT_SORT_KEYS)


def ask(request_for, controls, moved=None, **more):
    """The plots of an answer by name, and the rest of it."""
    updates, rest = answer(request_for(controls, moved, **more))
    assert len(updates) == len(PLOTS) + 1
    return dict(zip(PLOTS, updates[:-1], strict=True)), rest


# The first answer and those that follow ----------------------------------------------------------------------------


def test_the_first_answer_draws_everything(controls_for, request_for):
    drawn, rest = ask(request_for, controls_for())
    for figure in drawn.values():
        assert isinstance(figure, dict)
        assert figure["data"]
        assert figure["layout"]["meta"]["seq"] == rest["seq"] == 7
        assert figure["layout"]["meta"]["gains"] == rest["gains"]
    assert rest["ok"]
    assert set(rest["drawn"]) == set(PLOTS)
    assert rest["experiment"] == Experiment.from_dict({}).to_dict()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_figure_is_drawn_in_the_theme_of_the_page(controls_for, request_for, theme):
    drawn, _ = ask(request_for, controls_for(), theme=theme)
    assert {figure["layout"]["meta"]["theme"] for figure in drawn.values()} == {theme}


@pytest.mark.parametrize("theme", [None, "", "sepia", 5, ["dark"]])
def test_without_a_known_theme_it_is_the_light_one(controls_for, request_for, theme):
    drawn, _ = ask(request_for, controls_for(), theme=theme)
    assert drawn[PATH]["layout"]["meta"]["theme"] == "light"


STEPS = {
    "order 2": ({"order": 2, "design": "fading-memory", "xi": 0.7}, {"xi": 0.4}),
    "order 3": ({}, {"xi": 0.9}),
    "order 4": ({"order": 4, "design": "fading-memory", "xi": 0.7}, {"xi": 0.85}),
    "another order": ({"order": 4, "design": "fading-memory", "xi": 0.7}, {"order": 2}),
    "another design": ({}, {"design": "gray-murray"}),
    "by hand": ({}, {"alpha": 0.4}),
    "another start": ({"samples": 40}, {"start": "expanding"}),
    "another convention": ({}, {"convention": "half"}),
    "into instability": ({"order": 2, "design": "manual", "alpha": 0.5, "beta": 0.3}, {"beta": 3.8}),
    "out of instability": ({k: v for k, v in WILD.items() if k not in ("gamma", "eta")}, {"beta": 0.1}),
    "unstable at order 3": ({"order": 3, "design": "manual", "alpha": 0.5, "beta": 0.3, "gamma": 0.1}, {"gamma": -1}),
    "unstable at order 4": ({"order": 4, "design": "fading-memory", "xi": 0.7}, {"eta": 5}),
    "unstable but short": ({"order": 2, "design": "manual", "alpha": 0.5, "beta": 0.3, "samples": 6}, {"beta": 3.5}),
    "short": ({"samples": 60}, {"xi": 0.3}),
    "three samples": ({"samples": 3}, {"xi": 0.3}),
    "thinned": ({"samples": 12_000}, {"xi": 0.3}),
    "without noise": ({"noise": "none"}, {"xi": 0.3}),
    "one axis": ({"scenario": "constant-acceleration"}, {"xi": 0.3}),
    **{
        key: (run.to_dict(), {next(n for n in ("alpha", "xi", "tracking_index") if getattr(run, n) is not None): 0.33})
        for key, run in presets().items()
    },
}


@pytest.mark.parametrize(("start", "moved"), STEPS.values(), ids=STEPS)
def test_patches_make_the_full_figures(controls_for, request_for, start, moved):
    controls = controls_for(View(exaggerate=5), **start)
    first, rest = ask(request_for, controls)
    patches, _ = ask(request_for, controls, moved, drawn=rest["drawn"])
    full, _ = ask(request_for, controls, moved)
    for plot in WITHOUT_AXIS:
        assert isinstance(patches[plot], Patch), plot
        assert written(patched(first[plot], patches[plot])) == written(full[plot]), plot


@pytest.mark.parametrize("quantity", [1, 2])
def test_patches_make_the_full_plot_against_time(controls_for, request_for, quantity):
    controls = controls_for(View(quantity=quantity))
    first, rest = ask(request_for, controls)
    patches, _ = ask(request_for, controls, {"xi": 0.1}, drawn=rest["drawn"])
    full, _ = ask(request_for, controls, {"xi": 0.1})
    assert written(patched(first[AXIS], patches[AXIS])) == written(full[AXIS])


def test_patches_make_the_full_plot_against_time_but_for_its_range(controls_for, request_for):
    controls = controls_for(View(quantity=1))
    first, rest = ask(request_for, controls)
    patches, _ = ask(request_for, controls, {"alpha": 0.9}, drawn=rest["drawn"])
    full, _ = ask(request_for, controls, {"alpha": 0.9})
    made = patched(first[AXIS], patches[AXIS])
    for figure in (made, full[AXIS]):
        del figure["layout"]["yaxis"]["range"]
    assert written(made) == written(full[AXIS])


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
        "alpha": st.floats(0.1, 2),
        "beta": st.floats(-1, 4),
        "design": st.sampled_from(list(DESIGNS)),
        "convention": st.sampled_from(["normalised", "half"]),
        "start": st.sampled_from(["known", "first", "two-point", "expanding"]),
        "axis": st.sampled_from(["x", "y"]),
        "quantity": st.sampled_from(["position", "velocity"]),
        "exaggerate": st.sampled_from(["1", "10"]),
        "at": st.integers(1, 9),
        "theme": st.sampled_from(["light", "dark"]),
    },
)


@settings(max_examples=60)
@given(data=st.data())
def test_after_any_changes_the_page_shows_what_a_new_page_would(controls_for, request_for, data):
    """Over several answers, errors among them: patches and keys together never leave a plot behind."""
    controls, shown, keys, theme = controls_for(samples=100), [None] * (len(PLOTS) + 1), {}, "light"
    for _ in range(data.draw(st.integers(2, 5))):
        moved = data.draw(CHANGES)
        theme = moved.pop("theme", theme)
        updates, rest = answer(request_for(controls, moved, drawn=keys, theme=theme))
        json.dumps(rest, allow_nan=False)
        controls = rest["controls"]
        if not rest["ok"]:
            assert all(update is no_update for update in updates)
            controls = {**controls, **{name: controls_for(samples=100)[name] for name in rest["errors"]}}
            continue
        shown, keys = shown_after(shown, updates), keys | rest["drawn"]
        fresh, _ = ask(request_for, controls, theme=theme)
        for plot, figure in zip(PLOTS, shown, strict=False):
            if plot in WITHOUT_AXIS:
                assert written(figure) == written(fresh[plot]), plot


EVERYTHING = set(PLOTS)
TARGET = EVERYTHING - {STABILITY}


@pytest.mark.parametrize(
    ("moved", "anew"),
    [
        ({"xi": 0.5}, set()),
        ({"alpha": 0.5}, set()),
        ({"order": 2}, set()),
        ({"design": "gray-murray"}, set()),
        ({"convention": "taylor"}, set()),
        ({"start": "first"}, set()),
        ({"axis": "y"}, {AXIS}),
        ({"quantity": "velocity"}, {AXIS}),
        ({"at": 30}, {CLOSE_UP}),
        ({"exaggerate": "10"}, {PATH, CLOSE_UP}),
        ({"seed": 2}, TARGET),
        ({"noise": "none"}, TARGET),
        ({"noise_std": "11"}, TARGET),
        ({"interval": 2}, TARGET),
        ({"samples": 300}, TARGET),
        ({"scenario": "constant-velocity"}, TARGET),
        ({"theme": "dark"}, EVERYTHING),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else f"{len(value)}-plots",
)
def test_a_plot_is_drawn_anew_where_more_than_the_gains_moved(controls_for, request_for, moved, anew):
    controls = controls_for()
    _, rest = ask(request_for, controls)
    theme = moved.get("theme", "light")
    hand = {name: value for name, value in moved.items() if name != "theme"}
    updates, _ = ask(request_for, controls, hand, drawn=rest["drawn"], theme=theme)
    assert {plot for plot, update in updates.items() if not isinstance(update, Patch)} == anew
    # The short way sends no lines for those, and says so.
    text, arrays = live_answer(request_for(controls, hand, drawn=rest["drawn"], theme=theme, want=list(PLOTS)))
    assert set(text["outdated"]) == anew
    assert set(text["lines"]) == EVERYTHING - anew
    assert len(arrays) == 2 * sum(len(traces) for traces in text["lines"].values())


def test_only_what_is_wanted_is_drawn(controls_for, request_for):
    drawn, rest = ask(request_for, controls_for(), want=[ERROR, "no-such-plot"])
    assert {plot for plot, update in drawn.items() if update is not no_update} == {ERROR}
    assert set(rest["drawn"]) == {ERROR}


# The short way -----------------------------------------------------------------------------------------------------


def read_frame(message):
    """The text and the numbers of a message, as desk.js takes it apart."""
    length = int.from_bytes(message[:4], "little")
    assert length % 4 == 0
    return json.loads(message[4 : 4 + length]), np.frombuffer(message[4 + length :], dtype="<f4")


@pytest.mark.parametrize(("start", "moved"), STEPS.values(), ids=STEPS)
def test_the_lines_sent_live_are_those_of_the_figures(controls_for, request_for, start, moved):
    controls = controls_for(**start)
    _, rest = ask(request_for, controls)
    full, slow = ask(request_for, controls, moved)
    question = request_for(controls, moved, drawn=rest["drawn"], want=list(PLOTS))
    text, numbers = read_frame(framed(*live_answer(question)))
    at = 0
    assert list(text["lines"]) == list(PLOTS)
    for plot, traces in text["lines"].items():
        assert [index for index, _ in traces] == moving_traces(PLOTS[plot])
        for index, length in traces:
            for axis in ("x", "y"):
                np.testing.assert_array_equal(numbers[at : at + length], coordinates(full[plot]["data"][index][axis]))
                at += length
    assert at == len(numbers)
    assert text["outdated"] == []
    # And all the readouts are the same.
    shared = {name: value for name, value in text.items() if name not in ("lines", "outdated")}
    assert shared == json.loads(json.dumps({name: value for name, value in slow.items() if name != "drawn"}))


def test_lines_are_sent_for_the_wanted_plots_only(controls_for, request_for):
    controls = controls_for()
    _, rest = ask(request_for, controls)
    for want, expected in [([PATH, ERROR], [PATH, ERROR]), (None, []), ([], []), (["no-such-plot"], [])]:
        text, _ = live_answer(request_for(controls, {"xi": 0.5}, drawn=rest["drawn"], want=want))
        assert list(text["lines"]) == expected


def test_before_anything_is_drawn_everything_is_outdated(controls_for, request_for):
    text, arrays = live_answer(request_for(controls_for(), want=list(PLOTS)))
    assert (text["lines"], text["outdated"], arrays) == ({}, list(PLOTS), [])


# Errors ------------------------------------------------------------------------------------------------------------


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
    ],
)  # fmt: skip
def test_an_error_leaves_every_plot_as_it_is_and_stands_beside_its_field(
    controls_for, request_for, moved, field, message
):
    question = request_for(controls_for(), moved, want=[*PLOTS, NUMBERS])
    updates, rest = answer(question)
    assert all(update is no_update for update in updates)
    assert rest["errors"] == {field: message}
    assert (rest["ok"], rest["seq"]) == (False, 7)
    assert rest["controls"][field] == moved[field]
    assert live_answer(question) == (rest, [])
    json.dumps(rest, allow_nan=False)


# Verdict, cards, pin -----------------------------------------------------------------------------------------------


STOPPED = "The run stopped at sample 41: a position passed 1e+12 m."


@pytest.mark.parametrize(
    ("gains", "text"),
    [
        ({"order": 2, "alpha": 1.9, "beta": 1.5},
         f"Unstable: 4 − 2α − β > 0 fails by 1.30 (normalised gains). {STOPPED}"),
        ({"order": 2, "alpha": -0.5, "beta": 0.1, "samples": 5}, "Unstable: α > 0 fails by 0.500 (normalised gains)."),
        ({"order": 2, "alpha": 2.5, "beta": -1.5, "samples": 5},
         "Unstable: 2 − α > 0 fails by 0.500, β > 0 fails by 1.50 (normalised gains)."),
        ({"order": 2, "alpha": 1, "beta": 2, "samples": 5}, "Unstable: 4 − 2α − β > 0 fails by 0 (normalised gains)."),
        ({"order": 3, "alpha": 0.5, "beta": 0.1, "gamma": 0.2, "samples": 5},
         "Unstable: 2αβ − γ(2 − α) > 0 fails by 0.200 (normalised gains)."),
        # Written as 2γ/T², γ = 0.1 is the same filter.
        ({"order": 3, "alpha": 0.5, "beta": 0.1, "gamma": 0.1, "convention": "taylor", "samples": 5},
         "Unstable: 2αβ − γ(2 − α) > 0 fails by 0.200 (normalised gains)."),
        ({"order": 4, "alpha": 0.5, "beta": 0.1, "gamma": 0.02, "eta": -0.25, "samples": 5},
         "Unstable: η > 0 fails by 0.250 (normalised gains)."),
    ],
)  # fmt: skip
def test_unstable_gains_are_told_by_the_inequality_that_fails(controls_for, request_for, gains, text):
    _, rest = ask(request_for, controls_for(design="manual", **gains))
    assert rest["tone"] == "bad"
    assert rest["texts"]["status"] == text


@pytest.mark.parametrize("order", [2, 3, 4])
def test_the_sample_where_the_run_stopped_is_the_first_beyond_the_limit(controls_for, request_for, order):
    controls = controls_for(
        **{k: v for k, v in WILD.items() if k not in ["gamma", "eta"][order - 2 :]} | {"order": order}
    )
    _, rest = ask(request_for, controls)
    result = run_experiment(Experiment.from_dict(rest["experiment"]))
    stop = int(re.search(r"stopped at sample ([\d,]+)", rest["texts"]["status"])[1].replace(",", ""))
    beyond = np.abs(result.track.smoothed[:, :, 0]).max(axis=1) > 1e12
    assert beyond[stop - 1]
    assert not beyond[: stop - 1].any()
    assert rest["cards"] == {name: ["–", "", ""] for name in CARDS}


def test_a_stable_run_that_leaves_the_world_is_told_too(controls_for, request_for):
    """The target itself passes the limit."""
    controls = controls_for(scenario="constant-acceleration", interval=1e6, samples=300)
    _, rest = ask(request_for, controls)
    assert rest["tone"] == "bad"
    assert rest["texts"]["status"].startswith("Stable: the largest pole has magnitude ")
    assert "The run stopped at sample " in rest["texts"]["status"]
    assert rest["cards"]["estimation_rmse"] == ["–", "", ""]


@pytest.mark.parametrize(
    ("xi", "text"),
    [
        (0, "Stable: the largest pole has magnitude 0."),
        (0.64, "Stable: the largest pole has magnitude 0.640."),
        (0.995, "Stable: the largest pole has magnitude 0.995."),
    ],
)
@pytest.mark.parametrize("order", [2, 3])
def test_a_stable_filter_is_told_by_its_largest_pole(controls_for, request_for, order, xi, text):
    _, rest = ask(request_for, controls_for(design="fading-memory", order=order, xi=xi))
    assert (rest["tone"], rest["texts"]["status"]) == ("good", text)


@pytest.mark.parametrize("xi", [0.99, 0.9999])
def test_the_pole_that_is_shown_is_the_pole(controls_for, request_for, xi):
    _, rest = ask(request_for, controls_for(design="fading-memory", order=4, xi=xi))
    if xi > 0.999:
        assert rest["texts"]["status"] == "Stable, barely: the largest pole is within 0.001 of the unit circle."
    else:
        assert float(rest["texts"]["status"].split()[-1].rstrip(".")) == pytest.approx(xi, abs=5e-4)


def test_the_cards_are_the_metrics_of_the_run(controls_for, request_for):
    _, rest = ask(request_for, controls_for())
    metrics = run_experiment(Experiment.from_dict({})).metrics.to_dict()
    assert rest["cards"] == {name: [metric_text(METRICS[name], metrics[name]), "", ""] for name in CARDS}
    assert set(CARDS) <= set(METRICS)
    assert not rest["pinned"]


def test_an_unstable_filter_that_was_not_stopped_has_no_lag(controls_for, request_for):
    _, rest = ask(request_for, controls_for(design="manual", order=2, alpha=1.9, beta=0.5, samples=5))
    assert rest["cards"]["lag"] == ["–", "", ""]
    assert rest["cards"]["tracking_rmse"][0] != "–"


@pytest.mark.parametrize("moved", [{"xi": 0.3}, {"xi": 0.9}, {"order": 4}, {"design": "gray-murray"}])
def test_cards_show_the_change_since_the_pin(controls_for, request_for, moved):
    pin = Experiment.from_dict({})
    _, rest = ask(request_for, controls_for(), moved, pin=pin.to_dict())
    now, then = (run_experiment(e).metrics.to_dict() for e in (Experiment.from_dict(rest["experiment"]), pin))
    assert rest["pinned"]
    for name, (value, change, tone) in rest["cards"].items():
        assert value == metric_text(METRICS[name], now[name])
        assert (change, tone) == change_text(METRICS[name], now[name], then[name])
        assert float(change.split()[0].replace("−", "-").replace(",", "")) == pytest.approx(
            now[name] - then[name], rel=0.051, abs=1e-9
        )
        improved = (now[name] < then[name]) == METRICS[name].lower_is_better
        assert tone == ("better" if improved else "worse")


def test_nothing_changed_since_the_pin(controls_for, request_for):
    _, rest = ask(request_for, controls_for(), pin=Experiment.from_dict({}).to_dict())
    assert {tuple(card[1:]) for card in rest["cards"].values()} == {("no change", "same")}
    assert rest["link"] == "pin=default"


def test_a_pin_of_another_target_is_compared_with_its_own_run(controls_for, request_for):
    pin = Experiment.from_dict({"scenario": "garg-accelerating"})
    _, rest = ask(request_for, controls_for(), pin=pin.to_dict())
    now, then = (run_experiment(e).metrics for e in (Experiment.from_dict({}), pin))
    assert rest["cards"]["lag"][1:] == list(change_text(METRICS["lag"], now.lag, then.lag))


def test_a_pin_that_was_stopped_is_compared_with_nothing(controls_for, request_for):
    pin = Experiment.from_dict({"design": "manual", "order": 2, "alpha": 1.9, "beta": 1.5})
    _, rest = ask(request_for, controls_for(), pin=pin.to_dict())
    assert {card[2] for card in rest["cards"].values()} <= {"", "same"}


# The other readouts ------------------------------------------------------------------------------------------------


@given(wanted=st.from_type(Settings))
@settings(max_examples=60)
@example(wanted=Settings(Experiment.from_dict({"interval": 1e6, "scenario": "constant-acceleration", "order": 4})))
def test_any_settings_are_answered_in_json_and_drawn(request_for, wanted):
    """Every scenario, design, start and magnitude, short enough to be quick."""
    values = wanted.experiment.to_dict() | {"samples": min(wanted.experiment.samples, 200)}
    wanted = Settings(Experiment.from_dict(values), View(axis=wanted.view.axis, quantity=wanted.view.quantity))
    pin = wanted.experiment.to_dict()
    question = request_for(controls_of(wanted), pin=pin, want=[*PLOTS, NUMBERS])
    updates, rest = answer(question)
    json.dumps(rest, allow_nan=False)
    assert rest["ok"]
    for figure in updates[:-1]:
        text = orjson.dumps(figure)
        assert b"Infinity" not in text
        for trace in figure["data"]:
            for axis in ("x", "y"):
                assert not np.isinf(coordinates(trace[axis])).any()
    text, arrays = live_answer(question | {"drawn": rest["drawn"]})
    json.dumps(text, allow_nan=False)
    assert all(array.dtype == np.float32 for array in arrays)


@pytest.mark.parametrize(
    ("values", "link"),
    [
        ({}, ""),
        ({"seed": 3}, "seed=3"),
        ({"scenario": "garg-accelerating", "seed": 3}, "scenario=garg-accelerating&seed=3"),
    ],
)
def test_the_link_is_that_of_the_settings(controls_for, request_for, values, link):
    _, rest = ask(request_for, controls_for(**values))
    assert rest["link"] == link


@pytest.mark.parametrize(("factor", "text"), [(1, ""), (20, "deviations × 20")])
def test_an_exaggeration_is_told(controls_for, request_for, factor, text):
    _, rest = ask(request_for, controls_for(View(exaggerate=factor)))
    assert rest["texts"]["scale"] == text


@pytest.mark.parametrize("samples", [3, 200, 4000, 200_000])
def test_the_cursor_is_told_in_words(controls_for, request_for, samples):
    _, rest = ask(request_for, controls_for(samples=samples), want=[])
    cursor = samples // 2
    assert rest["texts"]["at-text"] == f"{cursor + 1:,} of {samples:,}, {significant(cursor * 3.0)} s"
    assert rest["samples"] == samples


@pytest.mark.parametrize(
    ("values", "states"),
    [
        ({}, ["computed"] * 3 + ["unused", "free", "unused"]),
        ({"design": "manual", "order": 2, "alpha": 0.5, "beta": 0.1}, ["free"] * 2 + ["unused"] * 4),
        ({"design": "kalata", "order": 2, "tracking_index": 1}, ["computed"] * 2 + ["unused"] * 3 + ["free"]),
        ({"design": "simpson", "order": 3, "alpha": 0.5, "beta": 0.3}, ["free", "free", "computed"] + ["unused"] * 3),
    ],
)
def test_every_slider_knows_how_it_stands_to_the_design(values, states):
    names = ["alpha", "beta", "gamma", "eta", "xi", "tracking_index"]
    assert owned(Experiment.from_dict(values)) == dict(zip(names, states, strict=True))


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("order", [2, 3, 4])
def test_menus_offer_what_makes_an_experiment(scenario, order):
    base = {"scenario": scenario, "order": order, "design": "fading-memory", "xi": 0.5}
    offered = offers(Experiment.from_dict(base))
    assert offered["axis"] == list(SCENARIOS[scenario].axes)
    assert offered["quantity"] == ["position", "velocity", "acceleration", "jerk"][:order]
    for name in ("noise", "start"):
        for choice in FIELDS[name].choices:
            try:
                Experiment.from_dict({**base, name: choice})
                possible = True
            except ValueError:
                possible = False
            assert (choice in offered[name]) == possible


@pytest.mark.parametrize("design", ["manual", *DESIGNS])
def test_every_design_is_explained_by_its_formula(design):
    for order in DESIGNS[design].orders if design in DESIGNS else (2, 3, 4):
        names = DESIGNS[design].parameters if design in DESIGNS else ("alpha", "beta", "gamma", "eta")[:order]
        text = formula_text(Experiment.from_dict({"design": design, "order": order, **dict.fromkeys(names, 0.3)}))
        if design == "manual":
            assert text == "The gains are set by hand."
        else:
            assert text.startswith(DESIGNS[design].formula[order])
            assert text.endswith(DESIGNS[design].remark or ".")


@pytest.mark.parametrize(
    ("gains", "text"),
    [
        ({"order": 2, "alpha": 0.5, "beta": 0.1}, "triangle"),
        ({"order": 3, "alpha": 0.5, "beta": 0.1, "gamma": 0.01}, "slice at γ = 0.0100"),
        ({"order": 4, "alpha": 0.5, "beta": 0.1, "gamma": 0.01, "eta": 0.001}, "slice at γ = 0.0100, η = 0.00100"),
    ],
)
def test_the_map_says_which_slice_it_shows(controls_for, request_for, gains, text):
    _, rest = ask(request_for, controls_for(design="manual", **gains))
    assert rest["texts"]["slice"] == text


# Numbers -----------------------------------------------------------------------------------------------------------


def cells(component):
    """Caption, heading and rows of a table."""
    caption, head, body = component.children.children
    return (
        caption.children,
        [cell.children for cell in head.children.children],
        [[cell.children for cell in row.children] for row in body.children],
    )


def tables(request_for, controls):
    updates, rest = answer(request_for(controls, want=[NUMBERS]))
    assert all(update is no_update for update in updates[:-1])
    assert rest["drawn"] == {NUMBERS: ""}
    assert all(isinstance(table, Component) for table in updates[-1])
    return [cells(table) for table in updates[-1]]


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_metrics_are_listed_jointly_and_per_axis(controls_for, request_for, scenario):
    (caption, head, rows), _ = tables(request_for, controls_for(scenario=scenario))
    axes = SCENARIOS[scenario].axes
    result = run_experiment(Experiment.from_dict({"scenario": scenario}))
    assert caption == "Metrics"
    assert head == ["", "joint", *(axes if len(axes) > 1 else ())]
    assert len(rows) == len(METRICS)
    columns = [result.metrics.to_dict(), *(metrics.to_dict() for metrics in result.axis_metrics())]
    for row, (name, metric) in zip(rows, METRICS.items(), strict=True):
        assert row[0].startswith(metric.title)
        assert row[0].endswith(f"({metric.unit})")
        assert len(row) == len(head)
        for text, column in zip(row[1:], columns, strict=False):
            value = column[name]
            if value is None:
                assert text == "–"
            else:
                assert float(text.replace(",", "").replace("−", "-")) == pytest.approx(value, rel=1e-5)


@pytest.mark.parametrize(("samples", "at"), [(1000, None), (1000, 0), (1000, 999), (3, None), (31, 30)])
def test_the_samples_of_the_close_up_are_listed(controls_for, request_for, samples, at):
    _, (caption, head, rows) = tables(request_for, controls_for(View(at=at), samples=samples))
    result = run_experiment(Experiment.from_dict({"samples": samples}))
    assert caption == "Samples of the close-up (m, s)"
    assert len(rows) == min(31, samples)
    assert head[:2] == ["sample", "time"]
    assert not any("velocity" in name for name in head)
    column = head.index("x smoothed")
    for row in rows:
        index = int(row[0].replace(",", "")) - 1
        value = result.track.smoothed[index, 0, 0]
        if math.isnan(value):
            assert row[column] == "–"
        else:
            assert float(row[column].replace(",", "").replace("−", "-")) == pytest.approx(value, rel=1e-6)
    assert f"{(samples // 2 if at is None else at) + 1:,}" in [row[0] for row in rows]


def test_the_samples_of_a_long_way_can_be_told_apart(controls_for, request_for):
    _, (_, head, rows) = tables(request_for, controls_for(samples=20_000, interval=600))
    times = [row[head.index("time")] for row in rows]
    positions = [row[head.index("x true")] for row in rows]
    assert len(set(times)) == len(times)
    assert len(set(positions)) == len(positions)


def test_without_being_asked_for_the_numbers_are_not_sent(controls_for, request_for):
    updates, rest = answer(request_for(controls_for()))
    assert updates[-1] is no_update
    assert NUMBERS not in rest["drawn"]


# Long runs ---------------------------------------------------------------------------------------------------------


def test_the_longest_run_is_answered_in_bounded_size(controls_for, request_for):
    controls = controls_for(samples=200_000)
    drawn, rest = ask(request_for, controls)
    for figure in drawn.values():
        assert all(len(coordinates(trace[axis])) <= 5_000 for trace in figure["data"] for axis in ("x", "y"))
    assert sum(len(orjson.dumps(figure)) for figure in drawn.values()) < 1_000_000
    message = framed(*live_answer(request_for(controls, {"xi": 0.5}, drawn=rest["drawn"], want=list(PLOTS))))
    assert len(message) < 1_000_000
    assert len(json.dumps(rest)) < 10_000
