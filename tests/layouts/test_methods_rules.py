"""The rules of the page where a method chooses the gains: menus, hand-overs, its parameters, links and pins."""

import json
import math
from urllib.parse import parse_qsl

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layouts.controls import controls_of, resolve
from layouts.desk import answer
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pins import pin_of
from layouts.rules import design_title, index_design, presets
from layouts.state import Settings, View, from_query, to_query
from layouts.text import change_text
from tracker_core import CONVENTIONS, DESIGNS, METRICS, SCENARIOS, STARTS, Experiment, run_experiment
from tracker_core.adaptive import METHODS, PARAMETERS
from tracker_core.fields import FIELDS, NOISE_LEVELS
from tracker_core.manoeuvre import MANOEUVRES
from tracker_core.merits import MERITS, merits
from tracker_core.noise import NOISES

GAINS = ("alpha", "beta", "gamma", "eta")
NAMES = [name for name in METHODS if name not in DESIGNS]
SERVED = [(name, order) for name in NAMES for order in METHODS[name].orders]
ON_EVERY_METHOD = pytest.mark.parametrize(("method", "order"), SERVED)
SHORT = {"scenario": "jeong-ship", "samples": 60}
MANUAL = {"design": "manual", "order": 4, "alpha": 0.5, "beta": 0.2, "gamma": 0.05, "eta": 0.005}

GIVEN = {
    "fixed_alpha": 0.2, "weight": 0.3, "criterion": "mean-absolute", "window": 11, "step": 3, "levels": 7, "grid": 3,
    "grid_eta": 2, "refinements": 2, "members": 5, "memory": 7.5, "shortest": 2.5, "longest": 50.0,
    "objective": "velocity", "end_points": "middle", "ties": "last", "bound": "triangle", "parabola": "printed",
}  # fmt: skip
"""Of every parameter a value that is no method's default."""


def move(controls, **moved):
    """What a hand does: some controls moved, the others as they stand."""
    return resolve({**controls, **moved}, list(moved))


def told(method):
    """Parameters of a method, none of them the default."""
    return {name: GIVEN[name] for name in METHODS[method].parameters}


def used(experiment, sample, axis):
    """The gains that corrected a sample of an axis, written in the convention of the run."""
    gains = run_experiment(experiment).selection.gains[sample, axis]
    return tuple(float(gain) for gain in gains / CONVENTIONS[experiment.convention].factors[: len(gains)])


# Design and order --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("before", [2, 3, 4])
@pytest.mark.parametrize("method", NAMES)
def test_choosing_a_method_takes_an_order_that_it_serves(controls_for, method, before):
    got = move(controls_for(**SHORT, design="fading-memory", order=before, xi=0.6), design=method)
    experiment, orders = got.settings.experiment, METHODS[method].orders
    assert experiment.design == got.controls["design"] == method
    assert experiment.order == got.controls["order"] == (before if before in orders else orders[0])
    assert got.note == ("" if before in orders else f"{METHODS[method].title} is a filter of order {orders[0]}.")
    # It begins with its own defaults: as a link would that says no more than its name.
    assert experiment.parameters() == METHODS[method].defaults(experiment.interval)
    assert experiment.xi is None


@pytest.mark.parametrize(
    ("method", "order", "after"), [(m, o, n) for m, o in SERVED for n in (2, 3, 4) if n not in METHODS[m].orders]
)
def test_an_order_that_a_method_does_not_serve_leaves_its_gains_as_manual_ones(controls_for, method, order, after):
    controls = controls_for(View(axis=1, at=20), **SHORT, design=method, order=order)
    got = move(controls, order=after)
    experiment = got.settings.experiment
    assert (experiment.design, experiment.order) == ("manual", after)
    assert experiment.gains().values == tuple(controls[name] for name in GAINS[:after])
    assert got.note == f"{METHODS[method].title} has no order {after}; the design is now Manual."


@pytest.mark.parametrize(("method", "order"), [pair for pair in SERVED if len(METHODS[pair[0]].orders) > 1])
def test_an_order_that_a_method_serves_keeps_it_and_its_parameters(controls_for, method, order):
    controls = controls_for(**SHORT, design=method, order=order, **told(method))
    for other in METHODS[method].orders:
        got = move(controls, order=other)
        assert (got.settings.experiment.design, got.settings.experiment.order, got.note) == (method, other, "")
        assert got.settings.experiment.parameters() == told(method)


# A hand on what the method computes --------------------------------------------------------------------------------


@pytest.mark.parametrize("convention", ["normalised", "half"])
@ON_EVERY_METHOD
def test_the_sliders_show_the_gains_of_the_sample_and_axis_looked_at(controls_for, method, order, convention):
    for axis, at in ((0, 20), (1, 45)):
        controls = controls_for(View(axis=axis, at=at), **SHORT, design=method, order=order, convention=convention)
        experiment = resolve(controls, []).settings.experiment
        assert [controls[name] for name in GAINS[:order]] == pytest.approx(used(experiment, at, axis), rel=1e-14)
        moved = move(controls, at=31, axis="x").controls
        assert [moved[name] for name in GAINS[:order]] == pytest.approx(used(experiment, 30, 0), rel=1e-14)


@ON_EVERY_METHOD
def test_a_hand_on_a_gain_takes_over_the_gains_that_were_shown(controls_for, method, order):
    controls = controls_for(View(axis=1, at=20), **SHORT, design=method, order=order, convention="taylor")
    for moved in GAINS[:order]:
        got = move(controls, **{moved: 0.123})
        experiment = got.settings.experiment
        assert (experiment.design, experiment.order, experiment.convention) == ("manual", order, "taylor")
        assert experiment.gains().values == tuple(0.123 if n == moved else controls[n] for n in GAINS[:order])
        assert experiment.parameters() == {}
        assert got.note == f"You moved {FIELDS[moved].symbol}: the design is now Manual."


@ON_EVERY_METHOD
def test_other_hands_take_a_method_over_too(controls_for, method, order):
    controls = controls_for(View(axis=1, at=20), **SHORT, design=method, order=order, convention="half")
    shown = [controls[name] for name in GAINS[:order]]
    dragged = move(controls, point="alpha-beta 0.4 0.3").settings.experiment
    assert (dragged.design, dragged.gains().values) == ("manual", (0.4, 0.3, *shown[2:]))
    held = "  ".join(["0.5 0", "0.4 0", "0.3 0", "0.2 0"][:order])
    pulled = move(controls, pole=f"0 0.6 0 {held}").settings.experiment
    poles = [0.6, 0.4, 0.3, 0.2][:order]
    assert (pulled.design, pulled.order) == ("manual", order)
    # The determinant of the filter's matrix, the product of its poles, is 1 - alpha.
    assert pulled.alpha == pytest.approx(1 - math.prod(poles), rel=1e-13)
    faded = move(controls, xi=0.3)
    assert (faded.settings.experiment.design, faded.settings.experiment.xi) == ("fading-memory", 0.3)
    assert faded.note == "You moved ξ: the design is now Fading memory."
    steady = move(controls, tracking_index=0.7).settings.experiment
    assert (steady.design, steady.tracking_index) == (index_design(order), 0.7)
    knob = move(controls, responsiveness=0.5)
    assert knob.settings.experiment.design == "steady-kalman"
    assert knob.controls["responsiveness"] == pytest.approx(0.5, abs=1e-9)
    assert {e.order for e in (dragged, pulled, knob.settings.experiment, steady)} == {order}


def test_a_gain_that_the_order_lacks_takes_nothing_over(controls_for):
    got = move(controls_for(**SHORT, design="parallel-bank"), gamma=0.3)
    assert (got.settings.experiment.design, got.note) == ("parallel-bank", "")


# Start, objective, window ------------------------------------------------------------------------------------------


@ON_EVERY_METHOD
def test_expanding_memory_gives_way_to_two_points(controls_for, method, order):
    said = "Expanding memory is such a method itself: starting with two points."
    chosen = move(controls_for(**SHORT, start="expanding", design="fading-memory", order=order, xi=0.5), design=method)
    started = move(controls_for(**SHORT, design=method, order=order), start="expanding")
    for got in (chosen, started):
        assert got.settings.experiment.start == got.controls["start"] == "two-point"
        assert (got.settings.experiment.design, got.note) == (method, said)


@ON_EVERY_METHOD
@pytest.mark.parametrize("start", [name for name in STARTS if name != "expanding"])
def test_every_other_start_serves_a_method_of_its_order(controls_for, method, order, start):
    got = move(controls_for(**SHORT, design=method, order=order), start=start)
    serves = STARTS[start].least_order <= order
    assert got.settings.experiment.start == (start if serves else "two-point")
    assert (got.note == "") == serves


def test_an_objective_that_cannot_be_followed_is_replaced(controls_for):
    of_jerk = controls_for(**SHORT, design="sample-search", order=4, objective="jerk")
    got = move(of_jerk, order=3)
    assert got.settings.experiment.objective == got.controls["objective"] == "acceleration"
    assert got.note == "The true jerk is not known or followed here: the objective is acceleration."
    # Of the manoeuvring target of Singer nobody knows the jerk.
    got = move(of_jerk, scenario="singer")
    assert (got.settings.experiment.objective, got.settings.experiment.order) == ("acceleration", 4)
    assert "The true jerk is not known" in got.note
    got = move(of_jerk, samples=50)
    assert (got.settings.experiment.objective, got.note) == ("jerk", "")


@pytest.mark.parametrize(("scenario", "order"), [("jeong-ship", 3), ("singer", 3), ("singer", 4)])
@pytest.mark.parametrize("method", ["sample-search", "run-search"])
def test_an_objective_that_the_hand_chose_is_an_error_beside_it(controls_for, method, scenario, order):
    controls = controls_for(scenario=scenario, samples=60, design=method, order=order)
    got = move(controls, objective="jerk")
    assert (got.settings, [error.field for error in got.errors], got.note) == (None, ["objective"], "")
    assert got.controls == {**controls, "objective": "jerk"}


@pytest.mark.parametrize(
    ("start", "moved", "window"),
    [
        ({"scenario": "garg-constant-velocity"}, {"design": "moving-window"}, 5),
        ({"samples": 20}, {"design": "moving-window"}, 10),
        ({"samples": 3}, {"design": "moving-window"}, 2),
        ({"design": "moving-window", "window": 50}, {"scenario": "garg-accelerating"}, 5),
    ],
    ids=str,
)
def test_a_window_longer_than_the_run_of_a_method_just_chosen_is_cut(controls_for, start, moved, window):
    """The field is not on the page before the method is: an error beside it would not be seen."""
    got = move(controls_for(**start), **moved)
    assert got.settings.experiment.window == got.controls["window"] == window
    assert got.note.endswith(f"The window is longer than the run: W is now {window}.")
    assert move(controls_for(samples=21), design="moving-window").settings.experiment.window == 20


@pytest.mark.parametrize(
    ("snr", "level", "expected"),
    [(-10, "snr", 20), (0, "snr", 20), (1e6, "snr-decibel", 20), (300, "snr-decibel", 300), (0.5, "snr", 0.5)],
)
def test_a_ratio_left_from_the_other_way_of_giving_it_is_one_of_this(controls_for, snr, level, expected):
    other = {"snr": "snr-decibel", "snr-decibel": "snr"}[level]
    before = move(controls_for(samples=60), noise_level=other, snr=snr)
    if before.settings is None:
        before = move(controls_for(samples=60), noise_level=level, snr=snr)
    hidden = move(before.controls, noise_level="std")
    for controls in (before.controls, hidden.controls):
        got = move(controls, noise_level=level)
        assert (got.settings.experiment.noise_level, got.settings.experiment.snr) == (level, expected)
        changed = f"An SNR of {snr:g} means nothing here: it is now 20."
        assert got.note == (changed if expected != snr else "")
    wrong = move(before.controls, noise_level="snr", snr=-1)
    assert [error.field for error in wrong.errors] == ["snr"]


# Parameters --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", NAMES)
@pytest.mark.parametrize("before", NAMES)
def test_a_method_begins_at_its_own_defaults_but_for_what_was_given(controls_for, before, method):
    usual = move(controls_for(**SHORT, interval=0.2, design=before), design=method)
    assert usual.settings.experiment.parameters() == METHODS[method].defaults(0.2)
    shared = {name: value for name, value in told(before).items() if name in METHODS[method].parameters}
    told_ = controls_for(**SHORT, interval=0.2, design=before, **told(before))
    after = move(told_, design=method).settings.experiment
    # What follows the interval is not kept where the method before does not use it; here it does.
    assert {name: getattr(after, name) for name in shared} == shared
    rest = {name: value for name, value in METHODS[method].defaults(0.2).items() if name not in shared}
    assert after.parameters() == rest | shared


@ON_EVERY_METHOD
def test_every_parameter_reaches_its_method(controls_for, method, order):
    for name, value in told(method).items():
        got = move(controls_for(**SHORT, design=method, order=order), **{name: str(value)})
        expected = METHODS[method].defaults(3.0) | {name: value}
        assert got.settings.experiment.parameters() == expected
        assert (got.settings.experiment.design, got.errors, got.note) == (method, (), "")
        assert got.controls[name] == value


def test_an_empty_weight_is_searched_and_a_number_is_given(controls_for):
    searched = controls_for(**SHORT, design="linear-combination")
    assert searched["weight"] == ""
    assert resolve(searched, []).settings.experiment.weight is None
    got = move(searched, weight="0.3")
    assert (got.settings.experiment.weight, got.controls["weight"]) == (0.3, 0.3)
    assert run_experiment(got.settings.experiment).selection.found == {}
    for empty in ("", "  ", None):
        again = move(got.controls, weight=empty)
        assert again.settings.experiment.weight is None
        assert again.controls["weight"] == ""
        assert again.settings.experiment == resolve(searched, []).settings.experiment


@pytest.mark.parametrize("name", [name for name in PARAMETERS if name != "weight"])
@pytest.mark.parametrize("empty", ["", None])
def test_no_other_parameter_may_be_left_empty(controls_for, name, empty):
    method = next(method for method in NAMES if name in METHODS[method].parameters)
    controls = controls_for(**SHORT, design=method)
    got = move(controls, **{name: empty})
    assert (got.settings, [error.field for error in got.errors]) == (None, [name])


@pytest.mark.parametrize(
    ("oracle", "causal", "shared"),
    [
        ("parallel-bank", "parallel-bank-causal", {"members": 7}),
        ("linear-combination", "moving-window", {"fixed_alpha": 0.2, "criterion": "mean-absolute"}),
        ("sample-search", "run-search", {"grid": 3, "ties": "last", "bound": "triangle", "objective": "velocity"}),
    ],
)
def test_parameters_are_kept_between_methods_that_share_them(controls_for, oracle, causal, shared):
    controls = controls_for(**SHORT, design=oracle, **shared)
    there = move(controls, design=causal)
    assert {name: getattr(there.settings.experiment, name) for name in shared} == shared
    away = move(there.controls, design="fading-memory")
    assert {name: away.controls[name] for name in shared} == shared
    assert move(away.controls, design=oracle).settings.experiment == resolve(controls, []).settings.experiment


def test_defaults_follow_the_interval_until_they_are_given(controls_for):
    controls = controls_for(**SHORT, interval=3.0)
    assert (controls["memory"], controls["shortest"], controls["longest"]) == pytest.approx((30, 3.6, 72))
    moved = move(controls, interval=0.5).controls
    assert (moved["memory"], moved["shortest"], moved["longest"]) == pytest.approx((5, 0.6, 20))
    for method in NAMES:
        assert move(moved, design=method).settings.experiment.parameters() == METHODS[method].defaults(0.5)
    given_ = move(moved, design="critically-damped-bank", longest=33, memory=8).controls
    assert move(given_, interval=0.25).settings.experiment.longest == 33


@pytest.mark.parametrize("convention", CONVENTIONS)
@ON_EVERY_METHOD
def test_a_convention_leaves_a_method_as_it_is(controls_for, method, order, convention):
    controls = controls_for(View(at=20), **SHORT, design=method, order=order, **told(method))
    got = move(controls, convention=convention)
    before, after = (run_experiment(resolve(c, []).settings.experiment) for c in (controls, got.controls))
    np.testing.assert_array_equal(after.track.smoothed, before.track.smoothed)
    assert (got.settings.experiment.convention, got.errors, got.note) == (convention, (), "")
    factors = CONVENTIONS[convention].factors
    for name, factor in zip(GAINS[:order], factors, strict=False):
        assert got.controls[name] == pytest.approx(controls[name] / factor, rel=1e-14)


WRONG = [
    *((name, entry) for name in PARAMETERS for entry in ("abc", "nan", "-1e9", "1e30") if name != "weight"),
    ("weight", "2"), ("weight", "abc"), ("fixed_alpha", "0"), ("window", "60"), ("window", "61"), ("window", "2.5"),
    ("window", "1"), ("step", "0"), ("levels", "0"), ("grid", "0"), ("grid", "100"), ("grid", 1e9), ("members", "0"),
    ("members", 1e9), ("memory", "0"), ("shortest", "0"), ("longest", "3.5"), ("longest", "0"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "entry"), WRONG)
def test_a_bad_parameter_is_an_error_beside_it_and_moves_nothing_else(controls_for, request_for, name, entry):
    for method in (method for method in NAMES if name in METHODS[method].parameters):
        controls = controls_for(**SHORT, design=method)
        got = move(controls, **{name: entry})
        assert (got.settings, [error.field for error in got.errors], got.note) == (None, [name], "")
        assert got.controls == {**controls, name: entry}
        _, rest = answer(STABILITY, request_for(controls, {name: entry}))
        assert list(rest["errors"]) == [name]
        # Mended, everything is as it was.
        assert move(got.controls, **{name: controls[name]}).controls == controls


def test_the_shortest_member_is_no_longer_than_the_longest(controls_for):
    got = move(controls_for(**SHORT, design="critically-damped-bank"), shortest="100")
    assert [error.field for error in got.errors] == ["longest"]
    assert got.controls["shortest"] == "100"


# Runs of the papers, links, pins -----------------------------------------------------------------------------------


@pytest.mark.parametrize("key", [key for key, run in presets().items() if run.method is not None])
def test_a_run_of_a_paper_with_a_method_comes_back_from_its_controls(controls_for, key):
    loaded = move(controls_for(), preset=key)
    controls = json.loads(json.dumps(loaded.controls))
    again = resolve(controls, [])
    assert again.settings == Settings(presets()[key])
    assert again.controls == controls
    assert controls["preset"] == key
    assert from_query(dict(parse_qsl(to_query(again.settings)))) == (again.settings, [])
    changed = move(controls, seed=99)
    assert (changed.settings.experiment.design, changed.controls["preset"]) == (presets()[key].design, "")


def read(link):
    return from_query(dict(parse_qsl(link, strict_parsing=bool(link))))


@pytest.mark.parametrize("beside", [False, True])
@ON_EVERY_METHOD
def test_a_link_brings_a_method_back_with_all_it_was_told(method, order, beside):
    experiment = Experiment.from_dict({**SHORT, "design": method, "order": order, **told(method)})
    wanted = Settings(experiment, View(beside=beside, axis=1), (pin_of(2, experiment),))
    link = to_query(wanted)
    values = dict(parse_qsl(link))
    assert {name: values[name] for name in told(method)} == {name: str(value) for name, value in told(method).items()}
    assert values.get("beside") == ("on" if beside else None)
    assert read(link) == (wanted, [])
    pins = [[2, wanted.pins[0].text()]]
    assert resolve(json.loads(json.dumps(controls_of(wanted))), [], pins).settings == wanted
    assert wanted.pins[0].on(experiment) == experiment


@ON_EVERY_METHOD
def test_a_link_leaves_the_defaults_of_a_method_out(method, order):
    values = dict(parse_qsl(to_query(Settings(Experiment.from_dict({"design": method, "order": order})))))
    assert not set(values) & set(PARAMETERS)
    assert values["design"] == method


@pytest.mark.parametrize(("name", "entry"), [("memory", "0"), ("members", "x"), ("longest", "0.1"), ("grid", "1e9")])
def test_a_broken_parameter_in_a_link_falls_back_with_a_note(name, entry):
    method = next(method for method in NAMES[::-1] if name in METHODS[method].parameters)
    got, notes = read(f"design={method}&samples=60&{name}={entry}")
    assert got.experiment == Experiment.from_dict({"design": method, "samples": 60})
    assert len(notes) == 1
    assert notes[0].startswith(f"{name} must be ")
    assert notes[0].endswith("; the default is used.")


@pytest.mark.parametrize(
    "link",
    ["design=moving-window&samples=10", "design=growing-memory&members=3", "design=growing-memory&xi=0.5",
     "design=run-search&order=2", "design=parallel-bank&start=expanding", "design=fading-memory&members=3"],
)  # fmt: skip
def test_what_does_not_fit_a_method_in_a_link_is_left_out_with_a_note(link):
    got, notes = read(link)
    assert notes
    assert run_experiment(got.experiment).metrics.observation_rmse > 0
    assert read(to_query(got)) == (got, [])


@ON_EVERY_METHOD
def test_a_pinned_method_is_compared_with_on_both_pages(controls_for, request_for, method, order):
    pinned = Experiment.from_dict({**SHORT, "design": method, "order": order, **told(method)})
    pin = pin_of(1, pinned)
    controls = controls_for(**SHORT, design="fading-memory", order=order, xi=0.6)
    now, then = (run_experiment(e) for e in (resolve(controls, []).settings.experiment, pinned))
    sent = [[1, pin.text()]]
    _, rest = answer(EXPLORE, request_for(controls, pins=sent, want=["explore-path"]))
    name = "estimation_rmse"
    expected = change_text(METRICS[name], getattr(now.metrics, name), getattr(then.metrics, name))
    assert (rest["cards"][name][1:], rest["pins"]) == (list(expected), sent)
    _, rest = answer(STABILITY, request_for(controls, pins=sent, want=["stability-path"]))
    figures = [merits(result.gains, 3.0)["noise_gain"] for result in (now, then)]
    assert rest["cards"]["noise_gain"][1:] == list(change_text(MERITS["noise_gain"], *figures))
    assert read(rest["link"])[0].pins == (pin,)


# Anything ----------------------------------------------------------------------------------------------------------

JUNK: st.SearchStrategy = st.sampled_from(["", "0", "abc", "nan", "1e9", "-3", None, 10**400, 0.1, 2, 7, "0.5"])
ANY = {
    "design": st.sampled_from(["manual", *DESIGNS, *NAMES]),
    "order": st.sampled_from([2, 3, 4, "2", "3", "4", "5"]),
    "start": st.sampled_from([*STARTS, "middle"]),
    "scenario": st.sampled_from(list(SCENARIOS)),
    "noise": st.sampled_from(list(NOISES)),
    "noise_level": st.sampled_from(list(NOISE_LEVELS)),
    "snr": st.sampled_from([20, "-5", "0", 1e-300, 300, 1e30]),
    "manoeuvre": st.sampled_from(list(MANOEUVRES)),
    "samples": st.sampled_from([3, 12, 40, "2"]),
    "interval": st.sampled_from([1e-6, 0.1, 5, 1e6]),
    "convention": st.sampled_from(list(CONVENTIONS)),
    "objective": st.sampled_from(["position", "jerk", "snap"]),
    "end_points": st.sampled_from(["interior", "both", "upper"]),
    "bound": st.sampled_from(["exact", "triangle", "printed"]),
    "weight": st.sampled_from(["", None, "0.3", 2]),
    "alpha": st.sampled_from([0.4, 1.9, -1, "x"]),
    "xi": st.sampled_from([0.4, "1"]),
    "responsiveness": st.sampled_from([0, 0.6, 2]),
    "point": st.sampled_from(["alpha-beta 0.4 0.3", "gamma-eta 0.1 0.01", "alpha 1"]),
    "preset": st.sampled_from(["yu2017/gamma-0.2", "alwagih/m3-coloured", "alwagih/m5-white"]),
    "beside": st.sampled_from(["on", "off", "perhaps"]),
    "at": st.sampled_from([1, 3, 11, 900]),
    **{name: st.sampled_from([1, 2, 3, 5]) | JUNK for name, field in PARAMETERS.items() if field.kind != "choice"},
}


MIXTURES = st.lists(st.sampled_from(list(ANY)), max_size=5, unique=True).flatmap(
    lambda names: st.fixed_dictionaries({name: ANY[name] for name in names})
)


@settings(max_examples=60)
@given(before=MIXTURES, changed=st.lists(st.sampled_from(list(ANY)), max_size=4), method=ANY["design"])
def test_any_mixture_gives_settings_or_errors_and_then_both_pages(controls_for, request_for, before, changed, method):
    controls = {**controls_for(samples=40), "design": method, **before}
    got = resolve(controls, changed)
    assert (got.settings is None) == bool(got.errors)
    for desk in (EXPLORE, STABILITY):
        updates, rest = answer(desk, request_for(controls, changed=changed))
        assert rest["ok"] == (got.settings is not None)
        json.dumps(rest, allow_nan=False)
        if not rest["ok"]:
            assert rest["errors"]
            continue
        assert len(updates) == len(desk.plots) + len(desk.tables)
        again = resolve(json.loads(json.dumps(rest["controls"])), [])
        assert (again.settings, again.controls, again.note) == (got.settings, rest["controls"], "")


@pytest.mark.parametrize("method", NAMES)
def test_the_title_of_a_method_is_that_of_the_menu(method):
    assert design_title(method) == METHODS[method].title
