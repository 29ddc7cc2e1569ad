"""The rules of the page: what one movement of a hand does to all controls."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from layouts import questions
from layouts.controls import SPARE_GAINS, controls_of, preset_of, resolve
from layouts.pinning import ACTIONS, Action
from layouts.pins import SLOTS, read_pin
from layouts.rules import design_title, index_design, presets
from layouts.state import LIMIT_FIELDS, Limits, Settings, View
from tracker_core import CONVENTIONS, DESIGNS, SCENARIOS, Experiment, Gains
from tracker_core.fields import FIELDS

GAINS = ["alpha", "beta", "gamma", "eta"]
PARAMETERS = [*GAINS, "xi", "tracking_index"]
DESIGN_ORDERS = [(name, order) for name, design in DESIGNS.items() for order in design.orders]
SYMBOLS = {"alpha": "α", "beta": "β", "gamma": "γ", "eta": "η", "xi": "ξ", "tracking_index": "Λ"}


def move(controls, **moved):
    """What a hand does: some controls moved, the others as they stand."""
    return resolve({**controls, **moved}, list(moved))


def sent(wanted):
    """The pins of settings as a page sends them."""
    return [(pin.slot, pin.text()) for pin in wanted.pins]


def design_controls(controls_for, design, order, **more):
    """Controls of a design at an order, its parameters where the sliders stand by themselves."""
    takes = DESIGNS[design].parameters if design in DESIGNS else GAINS[:order]
    return controls_for(design=design, order=order, **{name: SPARE_GAINS[name] for name in takes}, **more)


# Nothing moved -----------------------------------------------------------------------------------------------------


@given(wanted=st.from_type(Settings))
@example(wanted=Settings(Experiment.from_dict({"noise_std": [1 / 3, 1e9]})))
def test_controls_describe_the_settings_they_were_made_from(wanted):
    if wanted.view.at == wanted.experiment.samples // 2:
        wanted = replace(wanted, view=replace(wanted.view, at=None))
    controls = json.loads(json.dumps(controls_of(wanted)))
    got = resolve(controls, [], sent(wanted))
    assert got.settings == wanted
    assert got.controls == controls
    assert (got.errors, got.note) == ((), "")


def test_what_is_no_pin_is_let_go(controls_for):
    pins = [
        (1, "xi:7"),
        (2, ""),
        (4, "kalata"),
        (4, "fading-memory"),
    ]
    got = resolve(controls_for(), [], pins)
    assert got.settings == Settings(Experiment.from_dict({}), pins=(read_pin(4, "kalata"),))


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_a_spare_gain_is_the_same_filter_in_every_convention(controls_for, order, convention):
    controls = controls_for(design="kalata", order=2, tracking_index=0.1, convention=convention)
    moved = resolve({**controls, "order": order, "design": "manual"}, ["order", "design"])
    wanted = [controls["alpha"], controls["beta"], SPARE_GAINS["gamma"], SPARE_GAINS["eta"]][:order]
    np.testing.assert_array_max_ulp(moved.settings.experiment.gains().vector, np.array(wanted), 1)


# A hand on a slider ------------------------------------------------------------------------------------------------


COMPUTED = [
    (design, order, gain)
    for design, order in DESIGN_ORDERS
    for gain in GAINS[:order]
    if gain not in DESIGNS[design].parameters
]


@pytest.mark.parametrize(("design", "order", "gain"), COMPUTED)
def test_moving_a_gain_that_the_design_computes_makes_it_manual(controls_for, design, order, gain):
    controls = design_controls(controls_for, design, order)
    got = move(controls, **{gain: 0.123})
    experiment = got.settings.experiment
    assert (experiment.design, experiment.order) == ("manual", order)
    # The other gains stay where the design had put them.
    assert experiment.gains().values == tuple(0.123 if name == gain else controls[name] for name in GAINS[:order])
    assert got.note == f"You moved {SYMBOLS[gain]}: the design is now Manual."


@pytest.mark.parametrize(
    ("design", "order", "name"), [(d, o, name) for d, o in DESIGN_ORDERS for name in DESIGNS[d].parameters]
)
def test_moving_what_the_design_reads_keeps_it(controls_for, design, order, name):
    got = move(design_controls(controls_for, design, order), **{name: 0.321})
    assert got.settings.experiment.design == design
    assert getattr(got.settings.experiment, name) == 0.321
    assert got.note == ""


@pytest.mark.parametrize("order", [2, 3, 4])
def test_moving_a_manual_gain_keeps_the_others(controls_for, order):
    controls = design_controls(controls_for, "manual", order)
    for name in GAINS[:order]:
        got = move(controls, **{name: 0.123})
        assert got.settings.experiment == replace(Experiment.from_dict(dict_of(controls)), **{name: 0.123})
        assert got.note == ""


def dict_of(controls):
    """The fields of manual controls that say the experiment."""
    used = {"scenario", "samples", "interval", "noise", "noise_level", "noise_std", "manoeuvre", "seed", "start"}
    used |= {"order", "convention", "design", *GAINS[: controls["order"]]}
    return {name: controls[name] for name in used}


@pytest.mark.parametrize(("design", "order"), [*DESIGN_ORDERS, ("manual", 2), ("manual", 3), ("manual", 4)])
def test_moving_xi_means_fading_memory(controls_for, design, order):
    got = move(design_controls(controls_for, design, order), xi=0.3)
    experiment = got.settings.experiment
    has_it = design in DESIGNS and "xi" in DESIGNS[design].parameters
    assert experiment.design == (design if has_it else "fading-memory")
    assert (experiment.order, experiment.xi) == (order, 0.3)
    assert got.note == ("" if has_it else "You moved ξ: the design is now Fading memory.")


@pytest.mark.parametrize(
    ("design", "order", "expected"),
    [
        ("fading-memory", 2, "kalata"),
        ("fading-memory", 3, "gray-murray"),
        ("benedict-bordner", 2, "kalata"),
        ("critically-damped", 2, "kalata"),
        ("simpson", 3, "gray-murray"),
        ("jeong-fading-memory-as-run", 3, "gray-murray"),
        ("manual", 2, "kalata"),
        ("manual", 3, "gray-murray"),
        ("kalata", 2, "kalata"),
        ("gray-murray", 3, "gray-murray"),
        ("jeong-gray-murray", 3, "jeong-gray-murray"),
        ("jeong-gray-murray-as-run", 3, "jeong-gray-murray-as-run"),
        ("manual", 4, "steady-kalman"),
        ("fading-memory", 4, "steady-kalman"),
        ("jeong-fading-memory-as-run", 4, "steady-kalman"),
        ("steady-kalman", 2, "steady-kalman"),
        ("steady-kalman", 3, "steady-kalman"),
        ("steady-kalman", 4, "steady-kalman"),
    ],
)
def test_moving_the_tracking_index_means_the_kalman_filter_of_that_order(controls_for, design, order, expected):
    got = move(design_controls(controls_for, design, order), tracking_index=0.7)
    experiment = got.settings.experiment
    assert (experiment.design, experiment.order, experiment.tracking_index) == (expected, order, 0.7)
    assert got.note == ("" if expected == design else f"You moved Λ: the design is now {DESIGNS[expected].title}.")


def test_every_order_has_its_design_from_a_tracking_index():
    for order in (2, 3, 4):
        design = DESIGNS[index_design(order)]
        assert order in design.orders
        assert list(design.parameters) == ["tracking_index"]
    assert index_design(5) is None


@pytest.mark.parametrize(
    ("design", "order", "moved", "expected"),
    [
        ("fading-memory", 3, {"xi": 0.4, "alpha": 0.3}, "manual"),
        ("fading-memory", 3, {"xi": 0.4, "tracking_index": 0.2}, "gray-murray"),
        ("kalata", 2, {"beta": 0.3, "xi": 0.4}, "fading-memory"),
        ("kalata", 2, {"xi": 0.4, "beta": 0.3}, "manual"),
        ("fading-memory", 3, {"alpha": 0.3, "xi": 0.4}, "fading-memory"),
        ("fading-memory", 3, {"tracking_index": 0.2, "xi": 0.4}, "fading-memory"),
        ("fading-memory", 2, {"alpha": 0.3, "design": "kalata"}, "kalata"),
        ("fading-memory", 2, {"design": "kalata", "alpha": 0.3}, "manual"),
        ("kalata", 2, {"alpha": 0.3, "responsiveness": 0.5}, "steady-kalman"),
        ("kalata", 2, {"responsiveness": 0.5, "alpha": 0.3}, "manual"),
        ("kalata", 2, {"responsiveness": 0.5, "design": "fading-memory"}, "fading-memory"),
        ("kalata", 2, {"alpha": 0.5, "beta": 0.3}, "manual"),
        ("simpson", 3, {"alpha": 0.4, "beta": 0.5, "gamma": 0.1}, "manual"),
        ("manual", 4, {"alpha": 0.4, "eta": 0.001}, "manual"),
    ],
)
def test_two_hands_before_an_answer_end_in_one_design(controls_for, design, order, moved, expected):
    got = move(design_controls(controls_for, design, order), **moved)
    experiment = got.settings.experiment
    assert (experiment.design, got.controls["design"]) == (expected, expected)
    assert all(getattr(experiment, name) in (None, value) for name, value in moved.items() if name in PARAMETERS)
    # Said once, and only where nobody chose it.
    last = list(moved)[-1]
    if expected == design or last in ("design", "responsiveness"):
        assert got.note == ""
    else:
        symbols = [SYMBOLS[name] for name in moved if name in SYMBOLS]
        assert got.note in [f"You moved {symbol}: the design is now {design_title(expected)}." for symbol in symbols]


@pytest.mark.parametrize(
    ("design", "order", "name"),
    [
        ("fading-memory", 2, "gamma"),
        ("fading-memory", 3, "eta"),
        ("manual", 2, "gamma"),
        ("manual", 3, "eta"),
        ("kalata", 2, "eta"),
    ],
)
def test_a_gain_beyond_the_order_only_stays_where_it_was_put(controls_for, design, order, name):
    controls = design_controls(controls_for, design, order)
    got = move(controls, **{name: 0.0123})
    assert got.settings.experiment == resolve(controls, []).settings.experiment
    assert got.controls == {**controls, name: 0.0123}
    assert got.note == ""


def test_unused_sliders_stay(controls_for):
    controls = {**controls_for(), "eta": 0.0077, "tracking_index": 2.5}
    got = move(controls, xi=0.4)
    assert (got.controls["eta"], got.controls["tracking_index"]) == (0.0077, 2.5)
    got = move(got.controls, alpha=0.3)
    assert (got.controls["eta"], got.controls["tracking_index"], got.controls["xi"]) == (0.0077, 2.5, 0.4)
    got = move(got.controls, order=4)
    assert got.settings.experiment.eta == 0.0077


@pytest.mark.parametrize("junk", ["abc", "", None, "nan", 1e9, True])
def test_an_unused_slider_without_a_number_falls_back(controls_for, junk):
    got = resolve({**controls_for(), "eta": junk, "tracking_index": junk}, [])
    assert got.errors == ()
    assert got.controls["eta"] == SPARE_GAINS["eta"]
    assert got.controls["tracking_index"] == SPARE_GAINS["tracking_index"]


# Order and design --------------------------------------------------------------------------------------------------

AFTER = {
    "fading-memory": {2: "fading-memory", 3: "fading-memory", 4: "fading-memory"},
    "jeong-fading-memory-as-run": {2: "manual", 3: "jeong-fading-memory-as-run", 4: "jeong-fading-memory-as-run"},
    "benedict-bordner": {2: "benedict-bordner", 3: "manual", 4: "manual"},
    "critically-damped": {2: "critically-damped", 3: "manual", 4: "manual"},
    "simpson": {2: "manual", 3: "simpson", 4: "manual"},
    "kalata": {2: "kalata", 3: "gray-murray", 4: "steady-kalman"},
    "gray-murray": {2: "kalata", 3: "gray-murray", 4: "steady-kalman"},
    "steady-kalman": {2: "steady-kalman", 3: "steady-kalman", 4: "steady-kalman"},
    "jeong-gray-murray": {2: "kalata", 3: "jeong-gray-murray", 4: "steady-kalman"},
    "jeong-gray-murray-as-run": {2: "kalata", 3: "jeong-gray-murray-as-run", 4: "steady-kalman"},
}


def test_the_table_of_orders_is_complete():
    assert set(AFTER) == set(DESIGNS)


@pytest.mark.parametrize("new", [2, 3, 4])
@pytest.mark.parametrize(("design", "order"), DESIGN_ORDERS)
def test_changing_the_order_keeps_the_design_or_its_counterpart(controls_for, design, order, new):
    controls = design_controls(controls_for, design, order)
    got = move(controls, order=str(new))
    experiment, expected = got.settings.experiment, AFTER[design][new]
    assert (experiment.order, experiment.design) == (new, expected)
    if expected == design:
        assert got.note == ""
    else:
        assert got.note == f"{DESIGNS[design].title} has no order {new}; the design is now {design_title(expected)}."
    if expected == "manual":
        assert list(experiment.gains().values) == [controls[name] for name in GAINS[:new]]
    else:
        read = [name for name in PARAMETERS if getattr(experiment, name) is not None]
        assert read == list(DESIGNS[expected].parameters)
        assert [getattr(experiment, name) for name in read] == [controls[name] for name in read]


@pytest.mark.parametrize("new", [2, 3, 4])
@pytest.mark.parametrize("order", [2, 3, 4])
def test_changing_the_order_of_manual_gains_keeps_them(controls_for, order, new):
    controls = design_controls(controls_for, "manual", order)
    experiment = move(controls, order=new).settings.experiment
    assert experiment.design == "manual"
    assert list(experiment.gains().values) == [controls[name] for name in GAINS[:new]]


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("order", [2, 3, 4])
def test_changing_the_design_brings_its_order(controls_for, design, order):
    got = move(design_controls(controls_for, "manual", order), design=design)
    experiment, orders = got.settings.experiment, DESIGNS[design].orders
    assert experiment.design == design
    if order in orders:
        assert (experiment.order, got.note) == (order, "")
    else:
        assert experiment.order == orders[0]
        assert got.note == f"{DESIGNS[design].title} is a filter of order {orders[0]}."


@pytest.mark.parametrize(("design", "order"), DESIGN_ORDERS)
def test_taking_a_design_over_by_hand_keeps_its_gains(controls_for, design, order):
    controls = design_controls(controls_for, design, order)
    got = move(controls, design="manual")
    assert got.settings.experiment.gains() == resolve(controls, []).settings.experiment.gains()
    assert got.note == ""


# Convention --------------------------------------------------------------------------------------------------------

PAIRS = [(a, b) for a in CONVENTIONS for b in CONVENTIONS if a != b]


@pytest.mark.parametrize(("written", "wanted"), PAIRS)
@pytest.mark.parametrize(
    ("design", "order"), [("manual", 2), ("manual", 3), ("manual", 4), ("fading-memory", 4), ("simpson", 3)]
)
def test_changing_the_convention_rewrites_the_numbers_and_leaves_the_filter(
    controls_for, design, order, written, wanted
):
    controls = design_controls(controls_for, design, order, convention=written)
    before = Gains(tuple(controls[name] for name in GAINS[:order]), written)
    got = move(controls, convention=wanted)
    after = got.settings.experiment.gains()
    assert after.convention == got.controls["written"] == got.controls["convention"] == wanted
    np.testing.assert_array_max_ulp(after.vector, before.vector, 1)
    assert got.settings.experiment.design == design
    assert got.note == ""
    # Alpha and beta mean the same everywhere; gamma and eta are other numbers.
    changed = [name for name in GAINS if got.controls[name] != controls[name]]
    assert changed == ["gamma", "eta"]


@given(
    gains=st.lists(st.floats(-160, 160, allow_subnormal=False), min_size=4, max_size=4),
    conventions=st.lists(st.sampled_from(list(CONVENTIONS)), min_size=2, max_size=6),
)
def test_any_number_of_conventions_later_the_filter_is_the_same(gains, conventions):
    described = {"design": "manual", "order": 4, "convention": conventions[0], **dict(zip(GAINS, gains, strict=True))}
    # Written in every convention the gains must stay numbers that are taken as gains at all.
    described["eta"] /= 36
    described["gamma"] /= 4
    experiment = Experiment.from_dict(described)
    controls = controls_of(Settings(experiment))
    for convention in conventions[1:]:
        controls = move(controls, convention=convention).controls
    got = resolve(controls, []).settings.experiment
    np.testing.assert_allclose(got.gains().vector, experiment.gains().vector, rtol=1e-15, atol=0)


@pytest.mark.parametrize("name", ["beta", "gamma"])
def test_a_bad_gain_is_left_as_it_came_when_the_convention_changes(controls_for, name):
    controls = design_controls(controls_for, "manual", 3)
    got = move({**controls, name: "abc"}, convention="taylor")
    assert [error.field for error in got.errors] == [name]
    assert got.controls[name] == "abc"
    # What was rewritten is not rewritten again when the bad entry is mended.
    mended = move(got.controls, **{name: 0.2})
    normalised = {"beta": 0.2, "gamma": 0.4}
    expected = [normalised[gain] if gain == name else controls[gain] for gain in GAINS[:3]]
    assert mended.settings.experiment.gains().vector.tolist() == expected


def test_a_gain_typed_as_text_is_rewritten_as_a_number(controls_for):
    got = move({**design_controls(controls_for, "manual", 3), "gamma": "0.3"}, convention="taylor")
    assert got.controls["gamma"] == 0.15


# Scenario, samples, presets ----------------------------------------------------------------------------------------

SENSOR = ["samples", "interval", "noise", "noise_std"]


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("before", ["jeong-ship", "garg-accelerating"])
def test_a_scenario_brings_its_sensor_and_leaves_the_filter(controls_for, before, scenario):
    controls = {
        **controls_for(scenario=before, seed=9, design="fading-memory", order=3, xi=0.5),
        "samples": 7,
        "exaggerate": "20",
        "at": 3,
    }
    got = move(controls, scenario=scenario)
    usual = Experiment.from_dict({"scenario": scenario})
    experiment = got.settings.experiment
    assert [getattr(experiment, name) for name in SENSOR] == [getattr(usual, name) for name in SENSOR]
    assert experiment.start == usual.start
    assert (experiment.seed, experiment.design, experiment.order, experiment.xi) == (9, "fading-memory", 3, 0.5)
    assert experiment.convention == controls["convention"]
    assert got.settings.view == View(exaggerate=20)


def test_a_scenario_mends_what_the_sensor_could_not_measure(controls_for):
    """Sensor entries that do not fit the new scenario, or nothing at all, are replaced."""
    controls = {**controls_for(), "samples": "abc", "noise_std": "1,2", "interval": -1}
    got = move(controls, scenario="garg-constant-velocity")
    assert got.errors == ()
    assert got.settings.experiment.noise == "recorded"
    assert got.settings.experiment.noise_std == (100.0,)


def test_an_unknown_scenario_is_an_error_and_brings_nothing(controls_for):
    got = move(controls_for(samples=77), scenario="moon")
    assert [error.field for error in got.errors] == ["scenario"]
    assert got.controls["samples"] == 77


@pytest.mark.parametrize("order", [3, 4])
def test_three_points_give_way_to_order_2(controls_for, order):
    controls = controls_for(design="fading-memory", order=order, xi=0.5, start="three-point")
    got = move(controls, order=2)
    assert got.settings.experiment.start == got.controls["start"] == "two-point"
    assert got.note == "Three points needs order 3: starting with two points."


def test_three_points_cannot_be_chosen_at_order_2(controls_for):
    got = move(controls_for(design="fading-memory", order=2, xi=0.5), start="three-point")
    assert got.settings.experiment.start == "two-point"
    assert "needs order 3" in got.note


def test_a_design_of_order_2_takes_three_points_away(controls_for):
    got = move(controls_for(start="three-point"), design="kalata")
    assert (got.settings.experiment.order, got.settings.experiment.start) == (2, "two-point")
    assert got.note == ("Kalata is a filter of order 2. Three points needs order 3: starting with two points.")


@pytest.mark.parametrize("start", ["known", "first", "two-point", "expanding"])
def test_every_other_start_serves_every_order(controls_for, start):
    got = move(controls_for(start=start), order=2)
    assert (got.settings.experiment.start, got.note) == (start, "")


@pytest.mark.parametrize("key", presets())
def test_a_preset_is_the_run_of_the_paper(controls_for, key):
    """Whatever stood in the controls before, wrong entries and other movements before it too."""
    before = controls_for(scenario="constant-velocity", seed=99, convention="half", design="manual", order=4,
                          alpha=1, beta=1, gamma=1, eta=1)  # fmt: skip
    junk = {"samples": "abc", "xi": None, "order": "9", "noise_std": "x", "axis": "q", "at": 10**9}
    for controls, more in [(before, []), ({**before, **junk}, []), (before, ["alpha", "order", "scenario"])]:
        got = resolve({**controls, "preset": key}, [*more, "preset"])
        assert got.settings == Settings(presets()[key])
        assert (got.errors, got.note) == ((), "")
        assert presets()[got.controls["preset"]] == presets()[key]


@pytest.mark.parametrize(
    "key",
    [*presets()],
)
def test_the_menu_shows_the_run_that_was_chosen(controls_for, key):
    assert move(controls_for(), preset=key).controls["preset"] == key


def test_presets_are_recognised(controls_for):
    run = presets()["garg2021/accelerating"]
    assert preset_of(run) == "garg2021/accelerating"
    assert preset_of(replace(run, seed=2)) == ""
    loaded = move(controls_for(), preset="garg2021/accelerating").controls
    assert move(loaded, alpha=0.4).controls["preset"] == ""
    assert move({**loaded, "alpha": 0.4}, alpha=0.5).controls["preset"] == "garg2021/accelerating"


@pytest.mark.parametrize("value", ["", "jeong2017/none", None, 5])
def test_no_preset_changes_nothing(controls_for, value):
    controls = controls_for(seed=5)
    got = move(controls, preset=value)
    assert got.controls == controls
    assert got.errors == ()


def test_the_cursor_goes_back_to_the_middle_when_the_samples_change(controls_for):
    controls = {**controls_for(), "at": 900}
    got = move(controls, samples=2000)
    assert (got.settings.view.at, got.controls["at"]) == (None, 1001)
    got = move(controls, samples=100)
    assert (got.settings.view.at, got.controls["at"]) == (None, 51)


@pytest.mark.parametrize(("at", "index"), [(900, 899), (1, 0), (1000, 999), ("17", 16), (501, None)])
def test_the_cursor_stays_when_something_else_moves(controls_for, at, index):
    got = move({**controls_for(), "at": at}, xi=0.5)
    assert got.settings.view.at == index
    assert got.controls["at"] == int(at)


@pytest.mark.parametrize(
    ("entry", "at"), [("0", None), (1001, None), ("here", None), ("1.5", None), ("900", 900), ("", 501)]
)
def test_a_sample_that_there_is_not_is_an_error_beside_its_field(controls_for, entry, at):
    got = move(controls_for(), at=entry)
    assert [error.field for error in got.errors] == ([] if at else ["at"])
    assert got.controls["at"] == (at or entry)


def test_a_sample_that_was_chosen_for_a_longer_run_is_none_of_a_shorter_one(controls_for):
    """Whoever is moved before the answer is there has not seen it."""
    got = move(controls_for(), samples=100, at=900)
    assert (got.errors, got.controls["at"]) == ((), 51)
    assert move(controls_for(), samples=100, at=90).controls["at"] == 90


@pytest.mark.parametrize(
    ("moved", "view"),
    [
        ({"axis": "y"}, View(axis=1)),
        ({"quantity": "acceleration"}, View(quantity=2)),
        ({"exaggerate": "50"}, View(exaggerate=50)),
        ({"at": 3}, View(at=2)),
        ({"plane": "beta-gamma"}, View(plane=("beta", "gamma"))),
        ({"background": "lag"}, View(background="lag")),
        ({"input": "parabola"}, View(input="parabola")),
        ({"input": "cubic"}, View(input="cubic")),
        ({"input": "quartic"}, View()),
        ({"plane": "gamma-eta"}, View()),
        ({"plane": "gamma-beta"}, View()),
        ({"background": "gold"}, View()),
        ({"input": "jerk"}, View()),
        ({"axis": "range"}, View()),
        ({"quantity": "jerk"}, View()),
        ({"exaggerate": "3"}, View()),
    ],
)
def test_the_view_follows_its_controls_or_stays_at_its_default(controls_for, moved, view):
    got = move(controls_for(), **moved)
    assert got.settings.view == view
    assert got.errors == ()


def test_a_state_that_a_lower_order_lacks_gives_way_to_the_position(controls_for):
    got = move({**controls_for(), "quantity": "acceleration"}, order=2)
    assert (got.settings.view.quantity, got.controls["quantity"]) == (0, "position")


def test_a_plane_that_a_lower_order_lacks_gives_way_to_the_first(controls_for):
    got = move({**controls_for(), "plane": "beta-gamma"}, order=2)
    assert (got.settings.view.plane, got.controls["plane"]) == (("alpha", "beta"), "alpha-beta")


def test_an_input_that_a_lower_order_does_not_lag_behind_gives_way_to_the_step(controls_for):
    got = move({**controls_for(), "input": "cubic"}, order=2)
    assert (got.settings.view.input, got.controls["input"]) == ("step", "step")


@pytest.mark.parametrize(
    "moved", [{"scenario": "constant-velocity"}, {"preset": "jeong2017/gray-murray"}, {"samples": "77"}], ids=str
)
def test_what_has_nothing_to_do_with_the_target_stays(controls_for, moved):
    view = View(exaggerate=20, plane=("beta", "gamma"), background="noise", input="ramp")
    limits = Limits(limit_noise=0.5, limit_settling=30.0)
    got = move({**controls_for(view, limits), "at": 5, "axis": "y"}, **moved)
    kept = replace(view, axis=1) if "samples" in moved else view
    assert (got.settings.view, got.settings.limits) == (kept, limits)
    assert {got.controls[name] for name in moved} == set(moved.values()) or got.controls["samples"] == 77


# Limits ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", LIMIT_FIELDS)
def test_a_limit_is_set_and_taken_away(controls_for, name):
    got = move(controls_for(), **{name: "2.5"})
    assert got.settings.limits == Limits(**{name: 2.5})
    assert got.controls[name] == 2.5
    got = move(got.controls, **{name: ""})
    assert got.settings.limits == Limits()
    assert got.controls[name] == ""


@pytest.mark.parametrize("entry", ["0", "-1", "nan", "inf", "1e10", "much", "1,5"])
@pytest.mark.parametrize("name", LIMIT_FIELDS)
def test_a_limit_that_is_none_is_an_error_beside_its_field(controls_for, name, entry):
    got = move(controls_for(), **{name: entry})
    assert (got.settings, [error.field for error in got.errors]) == (None, [name])
    assert got.controls == {**controls_for(), name: entry}


def test_wrong_limits_and_wrong_fields_are_all_named(controls_for):
    got = move(controls_for(), limit_noise="x", limit_lag="y", samples="z", limit_settling="3")
    assert {error.field for error in got.errors} == {"limit_noise", "limit_lag", "samples"}


# Entries that are wrong --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "entry"),
    [
        ("samples", "2"), ("samples", "abc"), ("samples", ""), ("samples", None), ("samples", 10**400),
        ("interval", "0"), ("interval", "1e9"), ("noise_std", "1,2,3"), ("noise_std", "-1"), ("noise_std", "1;2"),
        ("seed", "1.5"), ("seed", -1), ("order", 5), ("order", "three"), ("scenario", "moon"), ("noise", "recorded"),
        ("start", "middle"), ("convention", "mine"), ("design", "best"), ("xi", 1), ("xi", "1,5"), ("xi", ""),
        ("xi", None), ("alpha", "abc"), ("beta", 1001), ("gamma", "--1"),
    ],
)  # fmt: skip
def test_a_bad_entry_comes_back_as_it_came_with_an_error_beside_it(controls_for, name, entry):
    controls = controls_for()
    got = move(controls, **{name: entry})
    assert got.settings is None
    assert [error.field for error in got.errors] == [name]
    assert got.controls[name] == entry
    # Everything else stands as it stood, but that a hand on a gain is a hand on the design.
    changed = {key for key, value in got.controls.items() if controls[key] != value}
    assert changed == {name} | ({"design"} if name in GAINS else set())


def test_a_bad_order_leaves_the_design(controls_for):
    got = move(design_controls(controls_for, "kalata", 2), order="three")
    assert got.controls["design"] == "kalata"
    assert got.note == ""


def test_several_bad_entries_have_an_error_each(controls_for):
    got = resolve({**controls_for(), "samples": "x", "interval": "y", "xi": "z"}, ["xi"])
    assert {error.field for error in got.errors} == {"samples", "interval", "xi"}


def test_a_missing_control_takes_the_default(controls_for):
    controls = controls_for(seed=5)
    del controls["samples"]
    got = resolve(controls, [])
    assert got.settings.experiment == Experiment.from_dict({"seed": 5})
    assert got.controls == controls_of(got.settings)


def test_no_controls_at_all_are_the_default():
    assert resolve({}, []).settings == Settings(Experiment.from_dict({}))


# Anything that JSON can say ----------------------------------------------------------------------------------------

CONTROLS = sorted(questions.CONTROLS)
WORDS = st.sampled_from([
    *SCENARIOS, *DESIGNS, *CONVENTIONS, *presets(), "manual", "known", "three-point", "white", "recorded", "none", "x",
    "y", "range", "position", "jerk", "2", "3", "4", "0.5", "10,20", "", "nan", "-1", "beta-gamma", "lag", "ramp",
    "alpha-beta 0.5 0.2", "gamma-eta 0.1 0.01", "beta-gamma 1 nan", "1 0.3 0.1  0.5 0  0.4 0", "0 2 2 2 2",
    "2 0.9 0  0.5 0.1  0.5 -0.1  0.4 0", "0 0.3 -0.2  0.5 0.1  0.5 -0.1  0.4 0.2  0.4 -0.2",
])  # fmt: skip
NUMBERS = st.sampled_from([0, 1, 2, 3, 4, 5, 0.1, 0.5, 0.99, 1.5, -1, 1000, 3000, 1e-6, 1e300, -0.0])
ANYTHING = (
    st.none()
    | WORDS
    | NUMBERS
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=10)
)
NAMES = st.sampled_from(CONTROLS)
TEXTS = st.sampled_from(["fading-memory,xi:0.5", "moving-window,window:999", "kalata", "manual,alpha:1,beta:2,name:N"])
SOME_SLOT = st.sampled_from(SLOTS)


def assert_resolved(got):
    assert (got.settings is None) == bool(got.errors)
    json.dumps(got.controls)
    if got.settings is None:
        assert all(error.field and error.rule for error in got.errors)
        return
    # What is shown now is what it describes: nothing moves by itself the next time.
    again = resolve(json.loads(json.dumps(got.controls)), [])
    assert again.settings == replace(got.settings, pins=())
    assert again.controls == got.controls
    assert again.note == ""


@settings(max_examples=200)
@given(
    controls=st.dictionaries(NAMES, ANYTHING, max_size=25),
    changed=st.lists(NAMES, max_size=6),
    pins=st.lists(st.tuples(SOME_SLOT, TEXTS | st.text(max_size=10)), max_size=6),
    pinning=st.lists(
        st.builds(Action, st.sampled_from(list(ACTIONS)), st.none() | SOME_SLOT, st.text(max_size=10)), max_size=4
    ),
)
def test_any_question_gives_settings_or_errors(controls, changed, pins, pinning):
    assert_resolved(resolve(controls, changed, pins, pinning))


@settings(max_examples=200)
@given(
    before=st.from_type(Settings),
    moved=st.dictionaries(st.sampled_from(CONTROLS), WORDS | NUMBERS | ANYTHING, min_size=1, max_size=3),
)
def test_any_movement_from_anywhere_gives_settings_or_errors(before, moved):
    got = move(controls_of(before), **moved)
    assert_resolved(got)
    if got.settings is None:
        named = {error.field for error in got.errors}
        assert named <= set(moved) | set(FIELDS) | {"poles"}


@pytest.mark.parametrize(
    ("changed", "scenario", "samples"),
    [
        (["preset"], "garg-accelerating", 10),
        (["scenario", "preset"], "garg-accelerating", 10),
        (["preset", "scenario"], "constant-velocity", 200),
        (["preset", "scenario", "samples"], "constant-velocity", 77),
        (["samples", "scenario"], "constant-velocity", 200),
    ],
)
def test_of_several_changes_the_last_one_stands(controls_for, changed, scenario, samples):
    moved = {"preset": "garg2021/accelerating", "scenario": "constant-velocity", "samples": "77"}
    got = resolve({**controls_for(), **{name: moved[name] for name in changed}}, changed)
    assert (got.controls["scenario"], got.controls["samples"]) == (scenario, samples)


def test_what_was_recorded_is_not_pushed(controls_for):
    """Whichever a hand has moved counts; where it is the pushes, they are refused beside their field."""
    pushed = controls_for(scenario="garg-accelerating", noise="white", manoeuvre="jerk-pulses", manoeuvre_std=2)
    resolution = resolve(pushed | {"noise": "recorded"}, ["noise"])
    assert resolution.errors == ()
    assert resolution.settings.experiment.manoeuvre == "none"
    assert "manoeuvre noise is off" in resolution.note
    recorded = controls_for(scenario="garg-accelerating")
    [error] = resolve(recorded | {"manoeuvre": "jerk-pulses"}, ["manoeuvre"]).errors
    assert error.field == "manoeuvre"
