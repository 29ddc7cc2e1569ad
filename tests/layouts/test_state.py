"""The link: whatever it says comes back, and what it gets wrong is said and left out."""

from dataclasses import replace
from urllib.parse import parse_qsl

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from layouts.comparing import Comparing
from layouts.pins import SLOTS, pin_of
from layouts.state import (
    BACKGROUNDS,
    EXAGGERATIONS,
    LIMIT_FIELDS,
    LINK_LIMIT,
    VIEW_FIELDS,
    Limits,
    Settings,
    View,
    from_query,
    inputs_of,
    to_query,
)
from tracker_core import DESIGNS, SCENARIOS, Experiment, InputError, run_experiment
from tracker_core.batch import KINDS
from tracker_core.fields import FIELDS
from tracker_core.region import PLANES
from tracker_core.tuning.monte_carlo import FIGURES

DEFAULT = Settings(Experiment.from_dict({}))
PINS = [f"pin{slot}" for slot in SLOTS]
NAMES = [*FIELDS, *VIEW_FIELDS, *LIMIT_FIELDS, *PINS]


def read(link):
    return from_query(dict(parse_qsl(link, strict_parsing=bool(link))))


def pinned(slot, values, name=""):
    """The default run with one pin."""
    return replace(DEFAULT, pins=(pin_of(slot, Experiment.from_dict(values)).named(name),))


# There and back ----------------------------------------------------------------------------------------------------


@given(wanted=st.from_type(Settings))
@example(wanted=DEFAULT)
@example(wanted=Settings(DEFAULT.experiment, pins=(pin_of(3, DEFAULT.experiment), pin_of(1, DEFAULT.experiment))))
@example(wanted=Settings(DEFAULT.experiment, pins=(pin_of(6, DEFAULT.experiment).named("a, name:b & c=d + 100 %"),)))
@example(wanted=Settings(DEFAULT.experiment, View(axis=1, quantity=2, exaggerate=100, at=0)))
@example(wanted=Settings(DEFAULT.experiment, limits=Limits(5e-324, 1e9, 0.1, 1 / 3)))
def test_a_link_round_trips(wanted):
    link = to_query(wanted)
    assert read(link) == (wanted, [])
    if not wanted.pins:
        assert len(link) <= LINK_LIMIT


def test_the_longest_link_is_short_enough():
    third = 123456.12345678901 / 3
    experiment = Experiment.from_dict(
        {
            "scenario": "jeong-ship", "samples": 199_999, "interval": third, "noise": "none",
            "noise_std": [third, 2 * third], "seed": 2**53 - 1, "start": "three-point", "order": 4, "design": "manual",
            "convention": "taylor", **dict.fromkeys(("alpha", "beta", "gamma", "eta"), -1.2345678901234567e-100),
        }
    )  # fmt: skip
    view = View(1, 2, 100, 199_998, ("alpha", "gamma"), "noise", "parabola")
    limits = Limits(*[1.2345678901234567e-100] * 4)
    wanted = Settings(experiment, view, tuple(pin_of(slot, experiment) for slot in SLOTS), limits)
    assert read(to_query(wanted)) == (wanted, [])
    assert len(to_query(wanted)) <= LINK_LIMIT


@pytest.mark.parametrize("design", ["manual", *DESIGNS])
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_every_scenario_and_design_round_trips(scenario, design):
    orders = DESIGNS[design].orders if design in DESIGNS else (2, 3, 4)
    takes = DESIGNS[design].parameters if design in DESIGNS else None
    for order in orders:
        names = takes or ("alpha", "beta", "gamma", "eta")[:order]
        values = {"scenario": scenario, "design": design, "order": order, **dict.fromkeys(names, 0.3)}
        wanted = Settings(Experiment.from_dict(values))
        assert read(to_query(wanted)) == (wanted, [])


@pytest.mark.parametrize(
    ("scenario", "moved"),
    [
        ("garg-accelerating", {"alpha": 0.3}),
        ("garg-accelerating", {"beta": 0.3}),
        ("garg-accelerating", {"gamma": 0.3}),
        ("garg-constant-velocity", {"alpha": 0.3}),
        ("garg-constant-velocity", {"beta": 0.3}),
        ("jeong-ship", {"xi": 0.5}),
    ],
)
def test_one_gain_of_a_scenario_moved_round_trips(scenario, moved):
    usual = Experiment.from_dict({"scenario": scenario})
    wanted = Settings(replace(usual, **moved))
    assert read(to_query(wanted)) == (wanted, [])


def test_the_defaults_give_an_empty_link():
    assert to_query(DEFAULT) == ""
    assert from_query({}) == (DEFAULT, [])


@pytest.mark.parametrize(
    ("settings", "link"),
    [
        (Settings(Experiment.from_dict({"scenario": "garg-accelerating"})), "scenario=garg-accelerating"),
        (Settings(Experiment.from_dict({"seed": 2})), "seed=2"),
        (Settings(Experiment.from_dict({"noise_std": "10,20"})), "noise_std=10.0,20.0"),
        (replace(DEFAULT, view=View(axis=1, quantity=1, exaggerate=20, at=41)),
         "axis=y&quantity=velocity&exaggerate=20&at=42"),
        (replace(DEFAULT, view=View(plane=("beta", "gamma"), background="lag", input="ramp")),
         "plane=beta-gamma&background=lag&input=ramp"),
        (replace(DEFAULT, limits=Limits(limit_lag=2.5, limit_settling=30.0)), "limit_lag=2.5&limit_settling=30.0"),
        (replace(DEFAULT, view=View(comparing=Comparing(3, "innovation", runs=20))),
         "reference=3&compared=innovation&runs=20"),
        (pinned(1, {}), "pin1=fading-memory,xi:0.64"),
        (pinned(2, {"order": 2, "xi": 0.5}), "pin2=fading-memory,order:2,xi:0.5"),
        (pinned(3, {"alpha": 0.5, "beta": 0.2, "start": "known"}), "pin3=manual,alpha:0.5,beta:0.2,start:known"),
        (pinned(6, {"design": "moving-window", "order": 2}, "My, own"), "pin6=moving-window,name:My,+own"),
    ],
)  # fmt: skip
def test_a_link_says_what_differs_and_nothing_else(settings, link):
    assert to_query(settings) == link


@settings(max_examples=40)
@given(wanted=st.from_type(Settings))
def test_a_run_from_the_link_is_the_same_to_the_last_bit(wanted):
    experiment = replace(wanted.experiment, samples=min(wanted.experiment.samples, 300))
    wanted = replace(wanted, experiment=experiment, view=View())
    reopened, _ = read(to_query(wanted))
    assert run_experiment(reopened.experiment).metrics == run_experiment(experiment).metrics


@pytest.mark.parametrize(("at", "samples", "cursor"), [(None, 200, 100), (None, 3, 1), (7, 200, 7), (900, 200, 199)])
def test_the_cursor_stays_within_the_run(at, samples, cursor):
    assert View(at=at).cursor(samples) == cursor


# What cannot be used -----------------------------------------------------------------------------------------------

BAD = {
    "scenario": ["moon", "Jeong-ship", "jeong ship"],
    "samples": ["2", "200001", "3.5", "many", "nan", "1e400", "0x10"],
    "interval": ["0", "-1", "nan", "inf", "1e7", "1,5", "3 s"],
    "noise": ["pink", "recorded"],
    "noise_std": ["-1", "a", "1,2,3", "1,,2", ",", "nan", "1e10"],
    "seed": ["-1", "1.5", "9007199254740993", "seed"],
    "start": ["four-point", "0"],
    "order": ["1", "5", "2.5", "two"],
    "convention": ["kalata", "Taylor"],
    "design": ["best", "None"],
    "xi": ["1", "-0.1", "nan", "ξ"],
    "axis": ["z", "range", "0"],
    "quantity": ["jerk", "speed", "1"],
    "exaggerate": ["3", "0", "-1", "1.0", "1000"],
    "at": ["0", "-1", "1001", "1.5", "here", "nan"],
    "plane": ["gamma-eta", "beta-alpha", "alpha", "alpha beta"],
    "background": ["gold", "Noise"],
    "input": ["impulse", "1"],
    "reference": ["7", "-1", "1.5", "present"],
    "compared": ["smoothed", "Tracking"],
    "figure": ["lag", "rmse"],
    "runs": ["1", "1000001", "2.5", "many"],
    **{name: ["0", "-1", "nan", "inf", "1e10", "none"] for name in LIMIT_FIELDS},
    "colour": ["red"],
    "x" * 40: ["1"],
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in BAD.items() for value in values])
def test_a_bad_value_falls_back_and_is_named(name, value):
    got, notes = from_query({name: value})
    assert got == DEFAULT
    assert len(notes) == 1
    assert notes[0].startswith(f"{name} ")
    # Of a list the item is shown, or the list as it was read.
    assert name == "noise_std" or value in notes[0]
    assert notes[0].rstrip(".").endswith(("the default is used", "the default is shown", "no limit is set"))


@pytest.mark.parametrize(("name", "value"), [(name, values[0]) for name, values in BAD.items()])
def test_a_bad_value_takes_no_good_one_with_it(name, value):
    good = {
        "seed": "7",
        "exaggerate": "5",
        "background": "lag",
        "limit_overshoot": "20",
        "pin4": "kalata,tracking_index:1",
    }
    good.pop(name, None)
    got, notes = from_query({**good, name: value})
    assert (got, []) == from_query(good)
    assert len(notes) == 1


def test_an_unknown_field_with_a_long_name_takes_no_good_one_with_it():
    got, notes = from_query({"a" * 41: "1", "seed": "7"})
    assert got.experiment.seed == 7
    assert len(notes) == 1


@given(chosen=st.sets(st.sampled_from(["samples", "interval", "noise", "seed", "xi", "axis", "at", "colour"])))
def test_every_bad_value_of_several_is_named(chosen):
    got, notes = from_query({name: BAD[name][0] for name in sorted(chosen)})
    assert got == DEFAULT
    assert {note.split()[0] for note in notes} == chosen
    assert len(notes) == len(chosen)


@pytest.mark.parametrize(
    ("query", "named", "kept"),
    [
        ({"design": "kalata", "order": "4", "tracking_index": "0.1"}, "order",
         {"design": "kalata", "tracking_index": 0.1}),
        ({"design": "simpson", "order": "2", "alpha": "0.5", "beta": "0.2"}, "order",
         {"design": "simpson", "alpha": 0.5, "beta": 0.2}),
        ({"design": "manual", "order": "3", "alpha": "0.5", "beta": "0.2"}, "gamma", {}),
        ({"design": "manual", "order": "2", "alpha": "0.5", "beta": "0.2", "gamma": "0.1"}, "gamma",
         {"design": "manual", "order": 2, "alpha": 0.5, "beta": 0.2}),
        ({"design": "fading-memory", "xi": "0.5", "alpha": "0.5"}, "alpha", {"xi": 0.5}),
        ({"design": "kalata"}, "tracking_index", {}),
        ({"order": "2", "xi": "0.5", "start": "three-point"}, "start", {"order": 2, "xi": 0.5}),
        ({"scenario": "garg-accelerating", "samples": "11"}, "samples", {"scenario": "garg-accelerating"}),
        ({"scenario": "garg-accelerating", "interval": "4"}, "interval", {"scenario": "garg-accelerating"}),
        ({"scenario": "garg-accelerating", "noise_std": "1,2"}, "noise_std", {"scenario": "garg-accelerating"}),
    ],
)  # fmt: skip
def test_values_that_do_not_fit_together_fall_back_and_are_named(query, named, kept):
    got, notes = from_query(query)
    assert got.experiment == Experiment.from_dict(kept)
    assert len(notes) == 1
    assert notes[0].startswith(f"{named} ")


def test_the_view_falls_back_where_the_experiment_does():
    got, notes = from_query({"samples": "2", "at": "1001", "order": "9", "quantity": "jerk"})
    assert got == DEFAULT
    assert sorted(note.split()[0] for note in notes) == ["at", "order", "quantity", "samples"]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "design must be one of manual"),
        ("default", "design must be one of manual"),
        ("fading-memory,xi", "xi must be given once, as name:value"),
        ("fading-memory,xi:0.5,xi:0.6", "xi must be given once, as name:value"),
        ("fading-memory,xi:half", "xi must be a finite number"),
        ("fading-memory,seed:3", "seed is not a field of the filter"),
        ("fading-memory,colour:red", "colour is not a field of the filter"),
        ("xi:0.5", "design must be one of manual"),
    ],
)
def test_a_malformed_pin_is_left_out_with_a_note_and_nothing_else(text, named):
    good = {"seed": "7", "pin5": "manual,alpha:0.5,beta:0.2", "compared": "tracking", "limit_lag": "3.0"}
    got, (note,) = from_query({**good, "pin2": text})
    assert (got, []) == from_query(good)
    assert note.startswith(f"Pin 2: {named}")
    assert note.endswith("; it is left out.")


@pytest.mark.parametrize(
    "text", ["moving-window,window:9000", "gray-murray,order:2,tracking_index:1.0", "manual,alpha:0.5", "kalata,xi:0.5"]
)
def test_a_pin_that_does_not_fit_stays(text):
    got, notes = from_query({"pin1": text})
    assert (to_query(got), notes) == (f"pin1={text}", [])
    with pytest.raises(InputError):
        got.pins[0].on(got.experiment)


def test_pins_keep_slot_and_order():
    link = "pin4=kalata,tracking_index:1.0&pin1=fading-memory,xi:0.5&pin6=manual,alpha:0.5,beta:0.2"
    got, notes = read(link)
    assert ([pin.slot for pin in got.pins], notes) == ([4, 1, 6], [])
    assert to_query(got) == link


def test_what_goes_unsaid_of_a_pin_is_not_said_again():
    got, _ = read("pin1=fading-memory,order:3,xi:0.640,convention:normalised,start:two-point,name:Fading+memory+ξ+0.64")
    assert to_query(got) == "pin1=fading-memory,xi:0.64"


def test_a_pin_does_not_grow_without_limit():
    got, notes = from_query({"pin1": "fading-memory,xi:0.5,name:" + "long " * 5_000})
    assert got.pins[0].name == "long long long long long long long long"
    assert notes == []
    _, (note,) = from_query({"pin1": "fading-memory," + "," * 5_000})
    assert len(note) < 200


def test_there_are_six_pins_and_no_more():
    _, notes = from_query(dict.fromkeys(["pin", "pin0", "pin7", "pin01"], "fading-memory,xi:0.5"))
    assert [note.split()[0] for note in notes] == ["pin", "pin0", "pin7", "pin01"]


PLAUSIBLE = st.sampled_from([
    *SCENARIOS, *DESIGNS, "manual", "taylor", "half", "known", "three-point", "white", "recorded", "none",
    "2", "3", "4", "5", "10", "0.5", "1", "-1", "0", "1e-30", "999999", "10,20", "y", "range", "jerk", "velocity",
    "fading-memory,xi:0.5", "manual,alpha:0.5,beta:1,name:N",
    "moving-window,window:10000", "kalata,name:", "", "nan", "inf", "1_000", "١٢", "\x00", "🙂",
])  # fmt: skip


@settings(max_examples=400)
@given(query=st.dictionaries(st.sampled_from(NAMES) | st.text(max_size=45), PLAUSIBLE | st.text(max_size=60)))
@example(query={"design": "jeong-gray-murray", "order": "3", "tracking_index": "1e-7"})
def test_any_link_gives_settings_that_have_a_link(query):
    got, notes = from_query(query)
    assert read(to_query(got)) == (got, [])
    if notes:
        assert all(notes)
        return
    # What is not complained about is used.
    for name, value in query.items():
        if name in FIELDS:
            assert getattr(got.experiment, name) == FIELDS[name].read(name, value)
        elif name == "exaggerate" and value:
            assert str(got.view.exaggerate) == value
        elif name in LIMIT_FIELDS and value:
            assert getattr(got.limits, name) == float(value)


@pytest.mark.parametrize("design", ["jeong-gray-murray", "jeong-gray-murray-as-run"])
def test_a_link_with_a_tiny_tracking_index_is_read_or_refused(design):
    got, notes = from_query({"design": design, "order": "3", "tracking_index": "1e-40"})
    assert notes or got.experiment.tracking_index == 1e-40


@given(value=st.text(min_size=1))
def test_a_note_shows_a_foreign_value_in_one_short_line(value):
    assume(value.strip())
    _, (note,) = from_query({"colour": value})
    assert "\n" not in note
    assert len(note) < 200


def test_every_choice_of_the_view_can_be_linked():
    views = [
        *(View(exaggerate=int(factor)) for factor in EXAGGERATIONS),
        *(View(background=name) for name in BACKGROUNDS),
        *(View(input=name) for name in inputs_of(DEFAULT.experiment.order)),
        *(View(comparing=Comparing(compared=name)) for name in KINDS),
        *(View(comparing=Comparing(figure=name)) for name in FIGURES),
        *(View(comparing=Comparing(reference=slot)) for slot in SLOTS),
    ]
    for view in views:
        wanted = replace(DEFAULT, view=view)
        assert read(to_query(wanted)) == (wanted, [])
    for order, planes in PLANES.items():
        experiment = Experiment.from_dict({"design": "fading-memory", "order": order, "xi": 0.5})
        for plane in planes:
            wanted = Settings(experiment, View(plane=plane))
            assert read(to_query(wanted)) == (wanted, [])
