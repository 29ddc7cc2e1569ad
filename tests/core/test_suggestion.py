"""The suggested filter: orders that are known, and sentences that say what the numbers do."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from tracker_core import Experiment, InputError, Measurements, identification
from tracker_core.likelihood import likelihood
from tracker_core.suggestion import GATE, suggest

ORDERS = [2, 3, 4]


def recorded(z, interval=1.0):
    z = np.asarray(z, dtype=float)
    z = z[:, None] if z.ndim == 1 else z
    return Measurements(np.arange(len(z)) * interval, z, interval)


@pytest.mark.parametrize("order", ORDERS)
def test_the_order_of_the_model_is_found(pushed_target, order):
    found = suggest(recorded(pushed_target(order, np.ones(600), 0.3, 4.0, np.random.default_rng(order), axes=2)))
    assert found.values["order"] == found.chosen.order == order
    assert found.values["tracking_index"] == found.chosen.tracking_index
    assert found.values["noise_std"] == found.chosen.sensor_std
    assert found.values["gate"] is None
    assert found.bic == {each: found.identified[each].bic for each in ORDERS}
    assert found.bic[order] == min(found.bic.values())


def test_the_values_are_those_of_an_experiment(pushed_target):
    values = dict(suggest(recorded(pushed_target(3, np.ones(300), 0.3, 4.0, np.random.default_rng(0)))).values)
    del values["gate"]
    experiment = Experiment.from_dict(values)
    assert (experiment.order, experiment.design) == (3, "steady-kalman")


def test_orders_are_compared_on_the_same_measurements(pushed_target):
    """A turn that order 2 takes for outliers speaks against it."""
    z = pushed_target(2, np.ones(400), 0.05, 1.0, np.random.default_rng(1), axes=2)
    z[[100, 250]] += 60
    z[180] += 4.7
    measurements = recorded(z)
    found = suggest(measurements)
    beyond = np.logical_and.reduce([each.set_aside for each in found.identified.values()])
    assert beyond[[100, 250]].all()
    for order in ORDERS:
        model = likelihood(measurements, order).believing(~beyond)
        profile = model.profile(np.array([True, True]))
        top = -minimize_scalar(lambda at, p=profile: -p.at(at), bounds=(-27, 13), method="bounded").fun
        assert found.bic[order] == pytest.approx(3 * math.log(2 * (400 - beyond.sum() - 4)) - 2 * top, abs=1e-3)


def test_outliers_ask_for_a_gate(pushed_target):
    z = pushed_target(2, np.ones(400), 0.3, 2.0, np.random.default_rng(0))
    z[[50, 200, 300]] += 200
    found = suggest(recorded(z))
    assert found.values["gate"] == GATE
    assert any(sentence.startswith("3 of 400 samples") for sentence in found.why)


def test_why_in_numbers(pushed_target):
    z = pushed_target(2, np.ones(500), 0.3, 2.0, np.random.default_rng(0), axes=2)
    found = suggest(recorded(z, 0.5), axes=("east", "north"))
    text = " ".join(found.why)
    chosen = found.chosen
    for number in (*chosen.sensor_std, *chosen.process_std, chosen.tracking_index, *chosen.index_interval):
        assert f"{number:.3g}" in text
    for gain in chosen.gains:
        assert f"{gain:.4g}" in text
    assert "(east)" in text
    assert "(north)" in text
    assert "m/s²" in text
    assert f"{found.bic[3] - found.bic[2]:,.1f} over order 3" in text
    assert all(sentence.endswith(".") for sentence in found.why)


def test_a_target_that_does_not_manoeuvre_and_one_without_noise(pushed_target):
    t = np.arange(300.0)
    straight = suggest(recorded(3 * t + np.random.default_rng(0).normal(size=300)))
    assert straight.values["order"] == 2
    assert straight.values["tracking_index"] == straight.chosen.index_interval[1]
    assert "No manoeuvre was found" in " ".join(straight.why)
    exact = suggest(recorded(t**2))
    assert exact.values["order"] == 3
    assert exact.values["noise_std"] == (0.0,)
    assert "rounding" in exact.why[0]
    assert "No noise was found" in " ".join(exact.why)
    assert exact.bic[3] is None
    circle = suggest(recorded(1000 * np.cos(t / 20)))
    assert "without any noise" in " ".join(circle.why)


def test_few_orders():
    z = np.random.default_rng(0).normal(size=100)
    assert suggest(recorded(z), orders=(3,)).why[0] == "Order 3 was asked for."
    assert suggest(recorded(z), orders=(4, 3)).values["order"] == 3
    with pytest.raises(InputError, match="^orders must hold one order"):
        suggest(recorded(z), orders=())
    with pytest.raises(InputError, match="^order must be 2, 3 or 4"):
        suggest(recorded(z), orders=(1,))


def test_few_measurements_are_no_certainty():
    z = np.array([30171, 30353, 30756, 30799, 31018, 31278, 31276, 31379, 31748, 32175.0])
    found = suggest(recorded(z, 5.0))
    assert 0 < found.values["tracking_index"] < 100
    assert found.chosen.index_interval[0] < 1e-6


def test_of_very_many_samples_the_sentences_say_so(pushed_target):
    found = suggest(recorded(pushed_target(2, np.ones(12_000), 0.3, 2.0, np.random.default_rng(0))))
    assert "Estimated from 10,000 of the 12,000 samples, in blocks spread evenly over them." in found.why


def test_too_many_outliers_are_none(pushed_target, monkeypatch):
    z = pushed_target(2, np.ones(600), 0.1, 1.0, np.random.default_rng(3))
    z[::25] += 100
    monkeypatch.setattr(identification, "MOST_SET_ASIDE", 23 / 600)
    found = suggest(recorded(z), orders=(2,))
    assert found.values["gate"] is None
    assert "none was set aside" in " ".join(found.why)
