"""Figures of merit: each is what its own function says, in its unit, and absent where gains are unstable."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import Gains, InputError, Measurements, Truth, run_filter
from tracker_core.merits import MERITS, merits
from tracker_core.metrics import measure
from tracker_core.responses import time_response


def test_merits_are_described():
    for name, metric in MERITS.items():
        assert metric.title, name
        assert metric.sentence.endswith("."), name
        assert metric.formula, name
    assert len({metric.title for metric in MERITS.values()}) == len(MERITS)
    assert [name for name, metric in MERITS.items() if not metric.lower_is_better] == ["damping"]


@pytest.mark.parametrize("interval", [1.0, 0.5, 3.0])
def test_merits_of_a_known_filter(interval):
    """g = (.5, .2, .08): variances by hand, step response by the filter itself, poles by numpy."""
    found = merits(Gains((0.5, 0.2, 0.08)), interval)
    assert list(found) == list(MERITS)
    assert found["noise_gain"] == pytest.approx(4 / 7, rel=1e-13)
    assert found["predicted_noise_gain"] == pytest.approx(9 / 7, rel=1e-13)
    assert found["unit_lag"] == pytest.approx(6.25 * interval**3, rel=1e-14)
    response = time_response(Gains((0.5, 0.2, 0.08)), 0, 1000).smoothed
    assert found["overshoot"] == pytest.approx(100 * (response.max() - 1), abs=1e-5)
    last = np.flatnonzero(np.abs(response - 1) > 0.02)[-1]
    assert found["settling"] == (last + 1) * interval
    slowest = max(np.roots([1, -2.26, 1.84, -0.5]), key=abs)
    assert found["spectral_radius"] == pytest.approx(abs(slowest), rel=1e-12)
    decay = -math.log(abs(slowest))
    assert found["damping"] == pytest.approx(decay / math.hypot(decay, np.angle(slowest)), rel=1e-12)
    assert 0 < found["optimal_distance"] < 100


def test_merits_do_not_depend_on_the_convention():
    gains = Gains((0.5, 0.2, 0.08, 0.01))
    assert merits(gains.to("taylor"), 2.0) == pytest.approx(merits(gains, 2.0), rel=1e-12)


@pytest.mark.parametrize("g", [(0.5, 3.5), (0.5, 0.0), (0.5, 0.3, 5.0), (0, 0, 0, 0), (1e9, 1e9)], ids=str)
def test_unstable_gains_have_a_largest_pole_alone(g):
    found = merits(Gains(g), 1.0)
    assert found["spectral_radius"] >= 1 - 1e-6
    assert [name for name, value in found.items() if value is not None] == ["spectral_radius"]


def test_what_is_not_finite_is_left_out():
    """A lag that overflows, and a step that has not settled within the horizon."""
    found = merits(Gains((0.5, 1e-320)), 1.0)
    assert found["unit_lag"] is None
    slow = merits(Gains((1 - 0.9999**2, (1 - 0.9999) ** 2)), 1.0)
    assert slow["settling"] is slow["overshoot"] is None
    assert slow["noise_gain"] is not None


@pytest.mark.parametrize(
    ("g", "predicted"), [((0.5, 1e-320), 1 / 3), ((1.0, 1e-220), 1.0), ((1e-12, 1e-30), 5e-13)], ids=str
)
def test_gains_at_the_border_have_merits(g, predicted):
    """With a vanishing beta the filter is an average with weights alpha: a/(2 - a) of the variance is left."""
    assert merits(Gains(g), 1.0)["predicted_noise_gain"] == pytest.approx(predicted, rel=1e-9)


@given(st.sampled_from([2, 3, 4]), st.lists(st.floats(-0.2, 2.2), min_size=4, max_size=4), st.floats(1e-6, 1e6))
def test_merits_are_finite_numbers_or_none(order, g, interval):
    found = merits(Gains(tuple(g[:order])), interval)
    assert all(value is None or (type(value) is float and math.isfinite(value)) for value in found.values())
    # A pole that is inside by less than rounding may seem to lie on the circle, or a digit beyond.
    assert all(value is None or value >= -1e-9 for value in found.values())


@pytest.mark.parametrize("alpha", [0.8, 1.2])
def test_a_filter_that_leads_is_as_far_off_as_one_that_trails(alpha):
    """Both lags are sizes: what a steady manoeuvre of one unit, or of the target's strength, leaves in the long run."""
    gains, times = Gains((alpha, 0.3)), np.arange(300.0)
    seen = Measurements(times, times[:, None] ** 2, 1.0)
    truth = Truth(times, np.stack((times**2, 2 * times, 0 * times + 2, 0 * times, 0 * times), axis=1)[:, None])
    track = run_filter(seen, gains)
    left = abs(float(seen.positions[-1, 0] - track.smoothed[-1, 0, 0]))
    assert measure(track, seen, truth, gains, stable=True).lag == pytest.approx(left, rel=1e-9)
    assert 2 * merits(gains, 1.0)["unit_lag"] == pytest.approx(left, rel=1e-9)


@pytest.mark.parametrize("interval", [0, -1, math.nan, 1e300])
def test_an_interval_that_no_experiment_has_is_refused(interval):
    with pytest.raises(InputError, match="^interval must be"):
        merits(Gains((0.5, 0.2)), interval)
