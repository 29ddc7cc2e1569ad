"""Pins: a filter under a name, what a hand does with six of them, and how they run."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layouts.comparing import Comparing
from layouts.pinned import last_pinned, merits_of, metrics_of
from layouts.pinning import Action, apply
from layouts.pins import NAME_LENGTH, SLOTS, clean_name, filter_name, pin_of, read_pin
from layouts.readouts import since_text
from layouts.state import LINK_LIMIT, Settings, View, to_query
from tracker_core import DESIGNS, SCENARIOS, Experiment, InputError, run_experiment
from tracker_core.adaptive import METHODS
from tracker_core.merits import merits

DEFAULT = Settings(Experiment.from_dict({}))
SPARE = {"alpha": 0.5, "beta": 0.2, "gamma": 0.05, "eta": 0.005, "xi": 0.64, "tracking_index": 0.1}


def with_xi(*values):
    """Settings whose pins are fading memories, in slots 1, 2, 3 ..."""
    pins = tuple(read_pin(slot, f"fading-memory,xi:{xi}") for slot, xi in zip(SLOTS, values, strict=False))
    return replace(DEFAULT, pins=pins)


def slots(settings):
    return [pin.slot for pin in settings.pins]


# A pin -------------------------------------------------------------------------------------------------------------


@given(experiment=st.from_type(Experiment), name=st.text())
def test_a_pin_is_the_filter_of_an_experiment_and_comes_back_from_its_text(experiment, name):
    pin = pin_of(4, experiment).named(name)
    assert pin.on(experiment) == experiment
    assert read_pin(4, pin.text()) == pin
    assert 0 < len(pin.name) <= NAME_LENGTH
    assert pin.named("") == pin_of(4, experiment)


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ({}, "Fading memory ξ 0.64"),
        ({"order": 2, "xi": 0.123456}, "Fading memory ξ 0.123, order 2"),
        ({"alpha": 0.5, "beta": 0.2}, "Manual 0.5, 0.2"),
        ({"alpha": 0.5, "beta": 0.2, "gamma": 0.05, "eta": -1.23456e-7}, "Manual 0.5, 0.2, 0.05, -1.23e-07"),
        ({"design": "benedict-bordner", "alpha": 0.5}, "Benedict–Bordner α 0.5"),
        ({"design": "kalata", "tracking_index": 1234.5}, "Kalata Λ 1234"),
        ({"design": "growing-memory"}, "Growing memory (M2)"),
        ({"design": "moving-window", "window": 31, "criterion": "mean-absolute"}, "Moving window (M4) W 31"),
        ({"design": "jeong-gray-murray", "tracking_index": 0.123}, "Gray–Murray of Jeong (approxima… Λ 0.123"),
        ({"design": "critically-damped-bank", "order": 4, "members": 5}, "Bank of critically damped… K 5, order 4"),
    ],
)  # fmt: skip
def test_a_filter_is_called_by_its_design_and_what_that_is_computed_from(values, name):
    pin = pin_of(1, Experiment.from_dict(values))
    assert pin.name == name
    assert len(name) <= NAME_LENGTH
    assert ",name:" not in pin.text()


@pytest.mark.parametrize("name", METHODS)
def test_every_method_has_a_name_that_says_which(name):
    values = {"design": name, **dict.fromkeys(METHODS[name].parameters, 3)}
    assert filter_name(values)[:8] == METHODS[name].title[:8]
    assert len(filter_name({**values, "order": 4})) <= NAME_LENGTH


@pytest.mark.parametrize(
    ("given_name", "name"),
    [
        ("  two\twords\n", "two words"),
        ("x" * 41, "x" * 40),
        ("\u202eabc\x00\ud800", "abc"),
        ("<b>bold</b> & $x^2$", "<b>bold</b> & $x^2$"),
        ("", ""),
        ("\n", ""),
    ],
)
def test_a_name_is_one_line_that_can_be_seen(given_name, name):
    assert clean_name(given_name) == name


# What a hand does --------------------------------------------------------------------------------------------------


def test_pinning_appends_the_present_filter_in_the_lowest_free_slot():
    settings, note = apply(
        replace(with_xi(0.1, 0.2, 0.3), view=View(comparing=Comparing(reference=2))),
        [Action("remove", 2), Action("add")],
    )
    assert slots(settings) == [1, 3, 2]
    assert settings.pins[-1] == pin_of(2, DEFAULT.experiment)
    assert (settings.view.comparing.reference, note) == (0, "")


def test_what_is_pinned_already_becomes_the_last():
    settings, note = apply(with_xi(0.1, 0.64, 0.3), [Action("rename", 2, "mine"), Action("add")])
    assert slots(settings) == [1, 3, 2]
    assert (settings.pins[-1].name, note) == ("mine", "")


def test_a_seventh_replaces_the_last_and_says_so():
    settings, note = apply(with_xi(0.1, 0.2, 0.3, 0.4, 0.5, 0.6), [Action("add")])
    assert slots(settings) == [1, 2, 3, 4, 5, 6]
    assert settings.pins[-1] == pin_of(6, DEFAULT.experiment)
    assert note == "Six filters are pinned at most: Fading memory ξ 0.6 has made room."


def test_a_pin_becomes_the_present_filter_and_stays():
    settings, note = apply(with_xi(0.1, 0.2), [Action("use", 2)])
    assert settings.experiment == Experiment.from_dict({"xi": 0.2})
    assert (settings.pins, note) == (with_xi(0.1, 0.2).pins, "")


def test_a_pin_that_does_not_fit_cannot_become_the_present_filter():
    before = replace(DEFAULT, pins=(read_pin(1, "moving-window,window:5000"),))
    settings, note = apply(before, [Action("use", 1)])
    assert settings == before
    assert note.startswith("Moving window (M4) W 5000 does not fit here: Window must be ")


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("interval", [None, 1e-6, 1e6])
def test_three_filters_to_begin_with_run_on_every_target(scenario, order, interval):
    usual = Experiment.from_dict({"scenario": scenario})
    values = {} if interval is None else {"interval": interval, "noise": "white"}
    present = replace(usual.with_filter({"order": order, "xi": 0.5}), **values)
    settings, note = apply(Settings(present), [Action("start")])
    assert (len({pin.name for pin in settings.pins}), note) == (3, "")
    for pin in settings.pins:
        assert pin.on(present).order == order
        if interval is None:
            assert run_experiment(pin.on(present)).metrics.observation_rmse is not None


@pytest.mark.parametrize("action", [Action("remove"), Action("remove", 5), Action("rename", 5, "x"), Action("use")])
def test_an_action_of_no_pin_does_nothing(action):
    assert apply(with_xi(0.1), [action]) == (with_xi(0.1), "")


def test_a_name_that_would_make_the_link_too_long_is_not_taken():
    settings = with_xi(0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    actions = [Action("rename", slot, "漢" * 40) for slot in SLOTS]
    settings, note = apply(settings, actions)
    assert len(to_query(settings)) <= LINK_LIMIT
    assert settings.pins[0].name == "漢" * 40
    assert settings.pins[-1].name == "Fading memory ξ 0.6"
    assert "the link would grow beyond 2,000 characters" in note


def test_in_a_link_that_is_too_long_already_a_name_may_become_shorter():
    long = [read_pin(slot, f"fading-memory,xi:0.{slot},name:{'漢' * 40}") for slot in SLOTS]
    before = replace(DEFAULT, pins=tuple(long))
    assert len(to_query(before)) > LINK_LIMIT
    settings, note = apply(before, [Action("rename", 2, "漢" * 39), Action("rename", 3, "漢" * 39 + "字")])
    assert (settings.pins[1].name, settings.pins[2].name, note) == ("漢" * 39, "漢" * 39 + "字", "")


def test_six_pins_with_names_and_every_digit_fit_into_a_link():
    third = 0.123456789012345678
    experiment = Experiment.from_dict(
        {
            "scenario": "jeong-ship", "samples": 199_999, "interval": third, "noise_std": [third, 2 * third],
            "seed": 2**53 - 1, "order": 4, "design": "manual", "convention": "taylor",
            **dict.fromkeys(("alpha", "beta", "gamma", "eta"), third),
        }
    )  # fmt: skip
    pins = tuple(pin_of(slot, experiment).named("n" * 40) for slot in SLOTS)
    assert len(to_query(Settings(experiment, pins=pins))) <= 0.85 * LINK_LIMIT


# Runs --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("design", DESIGNS)
def test_what_is_pinned_last_runs_on_the_present_target(design):
    values = {name: SPARE[name] for name in DESIGNS[design].parameters}
    pin = pin_of(1, Experiment.from_dict({"design": design, **values}))
    present = Experiment.from_dict({"scenario": "garg-accelerating", "noise": "white", "seed": 3})
    run = last_pinned(Settings(present, pins=(*with_xi(0, 0.2).pins[1:], pin)))
    assert run == present.with_filter({"design": design, **values})
    assert metrics_of(run) == run_experiment(run).metrics
    assert merits_of(run) == merits(run.gains(), present.interval)


def test_a_stopped_run_has_no_metrics():
    assert metrics_of(Experiment.from_dict({"alpha": 1.9, "beta": 1.5})) is None


def test_without_a_pin_nothing_is_compared():
    assert (last_pinned(DEFAULT), since_text(DEFAULT)) == (None, "")
    assert since_text(with_xi(0.1, 0.2)) == "since Fading memory ξ 0.2"


@pytest.mark.parametrize("text", ["moving-window,window:5000", "kalata,order:3,tracking_index:1"])
def test_a_pin_that_does_not_fit_is_compared_with_nothing_and_says_why(text):
    settings = replace(DEFAULT, pins=(read_pin(1, text),))
    with pytest.raises(InputError) as caught:
        settings.pins[0].on(settings.experiment)
    assert last_pinned(settings) is None
    assert since_text(settings).startswith(settings.pins[0].name)
    assert caught.value.rule in since_text(settings)
