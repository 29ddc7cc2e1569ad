"""Domains of numbers, and the error that names field, rule and value."""

import gc
import math
import weakref

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import InputError
from tracker_core.checks import POSITIVE, RECEIVED_LENGTH, Domain, check_choice, show

FINITE = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize(
    ("domain", "rule"),
    [
        (Domain(), "must be a finite number"),
        (Domain(0), "must be a finite number >= 0"),
        (POSITIVE, "must be a finite number > 0"),
        (Domain(0, 1, high_open=True), "must be a finite number >= 0 and < 1"),
        (Domain(0, 2, low_open=True), "must be a finite number > 0 and <= 2"),
        (Domain(3, 200_000, whole=True), "must be a whole number >= 3 and <= 200,000"),
        (Domain(1e-6, 1e9), "must be a finite number >= 1e-06 and <= 1e+09"),
        (Domain(high=-2.5), "must be a finite number <= -2.5"),
    ],
)
def test_rule_in_words(domain, rule):
    assert domain.rule == rule


@pytest.mark.parametrize(
    ("domain", "inside", "outside"),
    [
        (Domain(0, 1), [0, 1, 0.5], [-1e-300, math.nextafter(1, 2)]),
        (Domain(0, 1, low_open=True), [1e-300, 1], [0, -0.0]),
        (Domain(0, 1, high_open=True), [0, math.nextafter(1, 0)], [1]),
        (Domain(0, 9, whole=True), [0, 9, 4.0, "7"], [0.5, 9.5, "7.1"]),
        (Domain(), [1e308, -1e308, 0], [math.inf, -math.inf, math.nan]),
    ],
)
def test_ends_belong_or_not_as_declared(domain, inside, outside):
    for value in inside:
        assert domain.check("field", value) == float(value)
    for value in outside:
        with pytest.raises(InputError):
            domain.check("field", value)


@given(low=FINITE, high=FINITE, value=st.floats(), low_open=st.booleans(), high_open=st.booleans())
def test_membership_is_the_two_inequalities(low, high, value, low_open, high_open):
    expected = math.isfinite(value) and low <= value <= high
    if (low_open and value == low) or (high_open and value == high):
        expected = False
    assert (value in Domain(low, high, low_open, high_open)) == expected


@given(value=FINITE)
def test_a_number_and_its_spelling_are_the_same(value):
    assert Domain().check("x", repr(value)) == Domain().check("x", value) == value


@pytest.mark.parametrize(
    "value", [None, True, False, "", "ten", "1,5", [1.0], {}, (), 1j, "nan", "-inf", 10**400], ids=lambda v: repr(v)[:9]
)
def test_what_is_no_number_is_refused(value):
    with pytest.raises(InputError) as caught:
        Domain().check("interval", value)
    assert (caught.value.field, caught.value.rule) == ("interval", "must be a finite number")
    assert caught.value.received is value


def test_message_is_field_rule_and_value_in_one_line():
    error = InputError("alpha", "must be > 0", "a\nb")
    assert isinstance(error, ValueError)
    assert (error.field, error.rule, error.received) == ("alpha", "must be > 0", "a\nb")
    assert "\n" not in str(error)
    assert str(InputError("alpha", "must be > 0", -0.5)) == "alpha must be > 0, got -0.5"


@given(value=st.recursive(st.none() | st.floats() | st.text(), lambda inner: st.lists(inner, max_size=5)))
def test_received_values_are_shown_in_one_short_line(value):
    shown = show(value)
    assert len(shown) <= RECEIVED_LENGTH
    assert len(shown.splitlines()) == 1


def test_values_that_print_on_several_lines_are_shown_in_one():
    assert show(np.eye(2)) == "array([[1., 0.], [0., 1.]])"


def test_long_values_are_cut():
    assert show("x" * 500) == "'" + "x" * (RECEIVED_LENGTH - 2) + "…"


def test_choice_is_one_of_the_names():
    assert check_choice("start", "first", ["first", "known"]) == "first"


@pytest.mark.parametrize("value", ["First", "", None, 1, ["first"], {}], ids=repr)
def test_any_other_choice_is_refused(value):
    with pytest.raises(InputError) as caught:
        check_choice("start", value, ["first", "known"])
    assert (caught.value.field, caught.value.rule) == ("start", "must be one of first, known")
    assert caught.value.received is value


def test_an_error_that_is_kept_keeps_nothing_else():
    """Without the collector's help: neither what was there when it was raised, nor what it was raised from."""

    class Large:
        pass

    def refused():
        large = Large()
        seen.append(weakref.ref(large))
        errors = []
        try:
            try:
                raise ValueError
            except ValueError as error:
                raise InputError("n", "must be > 0", -1) from error
        except InputError as error:
            errors.append(error.kept())
        return errors[0]

    seen = []
    gc.disable()
    try:
        error = refused()
        assert seen[0]() is None
    finally:
        gc.enable()
    assert str(error) == "n must be > 0, got -1"
