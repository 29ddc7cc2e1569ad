"""Numbers and messages as a person reads them."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layouts.text import change_text, error_text, metric_text, significant, subscripts
from tracker_core import METRICS, InputError
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.experiment import read_experiment
from tracker_core.fields import FIELDS


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"), (-0.0, "0"), (1, "1.000"), (0.99996, "1.000"), (0.0999999, "0.1000"), (999.96, "1,000"),
        (-1.5, "−1.500"), (0.64, "0.6400"), (12.345, "12.35"),
        (999.94, "999.9"), (1234.5, "1,234"), (98765.4, "98,765"), (1_234_567.8, "1,234,568"), (-4321, "−4,321"),
        (9_999_999, "9,999,999"), (1e7, "1.00e7"), (-2.5e12, "−2.50e12"), (0.0001, "0.0001000"),
        (0.000012345, "1.23e−5"), (5e-324, "4.94e−324"), (1.7976931348623157e308, "1.80e308"),
        (math.nan, "–"), (math.inf, "–"), (-math.inf, "–"),
    ],
)  # fmt: skip
def test_four_digits_for_a_reader(value, text):
    assert significant(value) == text


@pytest.mark.parametrize(
    ("digits", "text"), [(1, "3,142"), (3, "3,142"), (4, "3,142"), (5, "3,141.6"), (7, "3,141.593")]
)
def test_whole_digits_are_never_rounded_away(digits, text):
    assert significant(3141.59265, digits) == text


@given(value=st.floats(-1e300, 1e300), digits=st.integers(2, 7))
def test_the_text_is_the_number_to_its_digits(value, digits):
    text = significant(value, digits)
    assert "-" not in text
    assert (text[0] == "−") == (value < 0)
    digits = digits if 1e-4 <= abs(value) < 1e7 else min(digits, 3)
    back = float(text.replace("−", "-").replace(",", ""))
    assert back == pytest.approx(value, rel=0.5001 * 10.0 ** (1 - digits), abs=1e-323)


@given(value=st.floats(1e-4, 9.99e6))
def test_between_a_ten_thousandth_and_ten_million_there_is_no_exponent(value):
    assert re.fullmatch(r"\d{1,3}(,\d{3})*(\.\d+)?", significant(value))


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("tracking_rmse", 12.3456, "12.35 m"),
        ("noise_reduction", -12.5, "−12.50 %"),
        ("lag", None, "–"),
        ("lag", 0.0, "0 m"),
    ],
)
def test_a_metric_has_its_unit(name, value, text):
    assert metric_text(METRICS[name], value) == text


@pytest.mark.parametrize("name", METRICS)
def test_every_metric_has_a_text(name):
    assert metric_text(METRICS[name], 2.5) == f"2.500 {METRICS[name].unit}"
    assert metric_text(METRICS[name], None) == "–"


@pytest.mark.parametrize(
    ("name", "value", "pinned", "text", "tone"),
    [
        ("tracking_rmse", 12.0, 10.0, "+2.0 (+20.0 %)", "worse"),
        ("tracking_rmse", 8.0, 10.0, "−2.0 (−20.0 %)", "better"),
        ("tracking_rmse", 109.0, 10.0, "+99 (+990.0 %)", "worse"),
        ("tracking_rmse", 120.0, 10.0, "+110 (× 12)", "worse"),
        ("tracking_rmse", 3e9, 1.0, "+3.0e9 (× 3.0e9)", "worse"),
        ("tracking_rmse", 5.0, 0.0, "+5.0", "worse"),
        ("tracking_rmse", 0.0, 5.0, "−5.0 (−100.0 %)", "better"),
        # In percent already: no percentage of a percentage.
        ("noise_reduction", 30.0, 20.0, "+10", "better"),
        ("noise_reduction", 10.0, 20.0, "−10", "worse"),
        ("noise_reduction", -10.0, 20.0, "−30", "worse"),
        ("lag", 5.0, 5.0, "no change", "same"),
        ("lag", 5.0, 5.0 * (1 + 1e-15), "no change", "same"),
        ("lag", 0.0, 0.0, "no change", "same"),
        ("lag", None, 5.0, "–", "same"),
        ("lag", 5.0, None, "–", "same"),
        ("lag", math.inf, 5.0, "–", "same"),
        ("lag", 5.0, math.nan, "–", "same"),
    ],
)  # fmt: skip
def test_a_change_since_the_pin(name, value, pinned, text, tone):
    assert change_text(METRICS[name], value, pinned) == (text, tone)


@pytest.mark.parametrize("name", METRICS)
def test_the_tone_follows_what_is_better(name):
    up, down = ("worse", "better") if METRICS[name].lower_is_better else ("better", "worse")
    assert change_text(METRICS[name], 3.0, 2.0)[1] == up
    assert change_text(METRICS[name], 2.0, 3.0)[1] == down


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"samples": "2"}, "n must be a whole number >= 3 and <= 200,000, got “2”."),
        ({"interval": ""}, "T must be a finite number >= 0.000001 and <= 1,000,000, got nothing."),
        ({"xi": 1}, "ξ must be a finite number >= 0 and < 1, got “1”."),
        ({"noise": "recorded"}, "Noise must not be 'recorded': nothing was recorded for 'jeong-ship', got “recorded”."),
        ({"colour": "red"}, "colour is not a field of the experiment, got “red”."),
        ({"design": "kalata", "order": 2}, "Λ must be given for the design 'kalata', got nothing."),
    ],
)
def test_an_error_says_label_rule_and_what_came(values, text):
    _, (error, *_) = read_experiment(values)
    expected = text.replace("0.000001", "1e-06")
    assert error_text(error) == expected


@pytest.mark.parametrize("name", FIELDS)
def test_every_field_is_called_as_it_is_labelled(name):
    text = error_text(InputError(name, "must be good", "x" * 100))
    # Symbols of a method's parameters, such as W and m, are no names.
    symbol = "" if name in METHOD_PARAMETERS else FIELDS[name].symbol
    assert text == f"{symbol or FIELDS[name].title} must be good, got “{'x' * 40}”."


@pytest.mark.parametrize(
    ("text", "pieces"),
    [
        ("σ_w²/σ_v", [("σ", False), ("w", True), ("²/σ", False), ("v", True)]),
        ("L_max of a_s(k)", [("L", False), ("max", True), (" of a", False), ("s", True), ("(k)", False)]),
        ("no subscript, 5_000", [("no subscript, 5_000", False)]),
        ("", []),
    ],
)
def test_subscripts_are_what_stands_after_a_letter_and_a_low_line(text, pieces):
    assert subscripts(text) == pieces
