"""The search for peaks and crossings: on functions whose own are known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core.peaks import Profile

PLACES = st.floats(-20, 10)


def hill(top, width):
    return Profile(lambda x: -np.log1p(((x - top) / width) ** 2), -27.0, 14.0)


@given(top=PLACES, width=st.floats(0.8, 20))
def test_the_peak_of_a_hill(top, width):
    place, value = hill(top, width).peak(1e-8)
    assert place == pytest.approx(top, abs=3e-8 * max(1.0, width))
    assert value == pytest.approx(0, abs=1e-14)


@given(top=PLACES, start=st.floats(-27, 14), width=st.floats(0.8, 20))
def test_the_peak_from_anywhere_on_it(top, start, width):
    place, _ = hill(top, width).peak_near(start, 1e-8)
    assert place == pytest.approx(top, abs=3e-8 * max(1.0, width))


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_slope_is_highest_at_its_end(sign):
    slope = Profile(lambda x: sign * x, -3.0, 5.0)
    end = 5.0 if sign > 0 else -3.0
    assert slope.peak(1e-8)[0] == pytest.approx(end, abs=1e-7)
    assert slope.peak_near(0.0, 1e-8)[0] == pytest.approx(end, abs=1e-7)


def test_the_higher_of_two_hills_is_found():
    two = Profile(lambda x: 3 * np.exp(-((x + 10) ** 2)) + 4 * np.exp(-((x - 5) ** 2)), -27.0, 14.0)
    assert two.peak(1e-8)[0] == pytest.approx(5, abs=1e-6)
    assert two.peak_near(-9.0, 1e-8)[0] == pytest.approx(-10, abs=1e-6)


def test_what_is_flat_everywhere_has_its_peak_somewhere():
    place, value = Profile(np.zeros_like, 0.0, 6.0).peak(1e-8)
    assert 0 <= place <= 6
    assert value == 0


@given(top=PLACES, width=st.floats(0.8, 20), drop=st.floats(0.01, 3))
def test_crossings_lie_where_the_function_says(top, width, drop):
    profile = hill(top, width)
    reach = width * math.sqrt(math.expm1(drop))
    for end, expected in ((-27.0, top - reach), (14.0, top + reach)):
        found = profile.crossing(top, 0.0, -drop, end, 1e-9)
        if -27 < expected < 14:
            assert found == pytest.approx(expected, abs=1e-7 * max(1.0, width) * math.exp(drop))
        elif abs(expected - end) > 1e-6:
            assert found is None


def test_few_values_are_asked_for():
    """Each costs a run of the filter over all measurements."""
    asked = []

    def function(x):
        asked.append(len(x))
        return -np.log1p((x - 0.3) ** 2)

    Profile(function, -27.6, 13.8).peak(1e-8)
    assert sum(asked) <= 50
    asked.clear()
    Profile(function, -27.6, 13.8).peak_near(0.35, 1e-8)
    assert sum(asked) <= 20
