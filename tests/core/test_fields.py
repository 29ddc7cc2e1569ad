"""The fields of the experiment: one description for menus, flags, links and messages."""

import dataclasses

import pytest

from tracker_core import CONVENTIONS, DESIGNS, SCENARIOS, STARTS, Experiment, InputError
from tracker_core.adaptive import METHODS
from tracker_core.adaptive.parameters import BOUNDS, CRITERIA, END_POINTS, PARABOLAS, TIES
from tracker_core.experiment import DEFAULTS, PARAMETERS
from tracker_core.fields import FIELDS, NOISE_LEVELS
from tracker_core.manoeuvre import MANOEUVRES
from tracker_core.measured import RECORDING
from tracker_core.noise import NOISES
from tracker_core.types import STATE_NAMES

CHOICES = {
    "scenario": [*SCENARIOS, RECORDING],
    "noise": list(NOISES),
    "start": list(STARTS),
    "convention": list(CONVENTIONS),
    "design": list(dict.fromkeys(["manual", *DESIGNS, *METHODS])),
    "noise_level": list(NOISE_LEVELS),
    "manoeuvre": list(MANOEUVRES),
    "criterion": list(CRITERIA),
    "objective": list(STATE_NAMES),
    "end_points": list(END_POINTS),
    "ties": list(TIES),
    "bound": list(BOUNDS),
    "parabola": list(PARABOLAS),
}


def test_fields_are_those_of_the_experiment_in_its_order():
    assert list(FIELDS) == [field.name for field in dataclasses.fields(Experiment)]


@pytest.mark.parametrize("name", FIELDS)
def test_field_is_described(name):
    field = FIELDS[name]
    assert field.title
    assert field.sentence.endswith(".")
    assert field.kind in {"number", "whole", "numbers", "choice", "text"}
    assert bool(field.choices) == (field.kind == "choice")
    assert field.domain.whole == (field.kind == "whole")


@pytest.mark.parametrize("value", ["", "x" * 601, "two\nlines", "\x00", None, 3, b"bytes", ["list"]], ids=repr)
def test_other_texts_are_refused(value):
    with pytest.raises(InputError) as caught:
        FIELDS["reading"].read("reading", value)
    assert caught.value.field == "reading"
    assert "1 to 600 characters" in caught.value.rule


@pytest.mark.parametrize(
    ("name", "rule"),
    [
        ("data", "must be a text of 1 to 100 characters that can be seen"),
        ("samples", "must be a whole number >= 3 and <= 200,000"),
        ("noise_std", "must be a finite number >= 0 and <= 1e+09"),
        ("manoeuvre", "must be one of none, acceleration-pulses, acceleration-jumps, jerk-pulses"),
    ],
)
def test_a_field_says_what_it_admits(name, rule):
    assert FIELDS[name].rule == rule


def test_a_text_stays_as_it_is():
    assert FIELDS["reading"].read("reading", "time:1,only:%3Cb%3E") == "time:1,only:%3Cb%3E"


@pytest.mark.parametrize("name", CHOICES)
def test_choices_are_the_registry(name):
    assert list(FIELDS[name].choices) == CHOICES[name]
    for choice in CHOICES[name]:
        assert FIELDS[name].read(name, choice) == choice


@pytest.mark.parametrize("name", sorted(DEFAULTS))
def test_defaults_are_admitted(name):
    assert FIELDS[name].read(name, DEFAULTS[name]) == DEFAULTS[name]


def test_every_choice_is_listed_above():
    assert set(CHOICES) == {name for name, field in FIELDS.items() if field.kind == "choice"}


def test_every_method_parameter_is_a_field():
    assert {name for method in METHODS.values() for name in method.parameters} <= set(FIELDS)


def test_every_design_parameter_is_a_field():
    assert {name for design in DESIGNS.values() for name in design.parameters} <= set(PARAMETERS) <= set(FIELDS)


@pytest.mark.parametrize("value", [200, 200.0, "200", "2e2"], ids=repr)
def test_whole_numbers_become_integers(value):
    number = FIELDS["samples"].read("samples", value)
    assert number == 200
    assert type(number) is int


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (10, (10.0,)),
        ("10", (10.0,)),
        ("10,20", (10.0, 20.0)),
        (" 1 , 2 ", (1.0, 2.0)),
        ([1, "2"], (1.0, 2.0)),
        ((0,), (0.0,)),
    ],
    ids=repr,
)
def test_numbers_are_one_or_one_per_axis(value, expected):
    assert FIELDS["noise_std"].read("noise_std", value) == expected


@pytest.mark.parametrize(
    "value", ["10,", ",", "", [], [1] * 9, [None], [[1]], None, True, "1;2", [float("nan")], -1], ids=repr
)
def test_other_numbers_are_refused(value):
    with pytest.raises(InputError) as caught:
        FIELDS["noise_std"].read("noise_std", value)
    assert caught.value.field == "noise_std"


@pytest.mark.parametrize("name", [name for name, field in FIELDS.items() if field.kind not in {"choice", "text"}])
@pytest.mark.parametrize("value", ["ten", None, False, float("inf")], ids=repr)
def test_every_number_field_names_itself(name, value):
    with pytest.raises(InputError) as caught:
        FIELDS[name].read(name, value)
    assert caught.value.field == name
    assert caught.value.rule.startswith("must be")


@pytest.mark.parametrize("name", CHOICES)
@pytest.mark.parametrize("value", ["no-such-name", None, 1, ["first"]], ids=repr)
def test_every_choice_field_names_itself(name, value):
    with pytest.raises(InputError) as caught:
        FIELDS[name].read(name, value)
    assert caught.value.field == name
    assert caught.value.rule == f"must be one of {', '.join(CHOICES[name])}"
