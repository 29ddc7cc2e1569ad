"""Sweeps: every number is that of a run of its own."""

from dataclasses import replace
from math import isnan, sqrt

import numpy as np
import pytest

from tracker_core import Experiment, InputError, run_experiment
from tracker_core.metrics import METRICS
from tracker_core.papers import papers
from tracker_core.papers.sweeps import MEASURED, sweep

SEEDS = (1, 5)
SHIP = {"samples": 60, "start": "two-point"}
CASES = {
    "alpha": (Experiment.from_dict(SHIP | {"order": 2, "design": "benedict-bordner", "alpha": 0.5}), (0.2, 0.86)),
    "gamma": (Experiment.from_dict({"scenario": "garg-accelerating"}), (0.05, 0.2, 0.4)),
    "xi": (Experiment.from_dict(SHIP | {"order": 4, "xi": 0.7}), (0.3, 0.74, 0.9)),
    "process_variance": (papers()["jeong2017"].run("gray-murray").experiment, (1e-4, 1e-3, 1.0)),
    "sensor_variance": (papers()["jeong2017"].run("gray-murray").experiment, (0.1, 1.0, 50.0)),
}


def field_of(parameter, value, experiment):
    """The field that the parameter sets and its value, worked out by hand."""
    square = experiment.interval**2
    if parameter == "process_variance":
        return {"tracking_index": square * sqrt(value)}
    if parameter == "sensor_variance":
        process = (experiment.tracking_index / square) ** 2
        return {"tracking_index": square * sqrt(process / value)}
    return {parameter: value}


@pytest.mark.parametrize("objective", [name for name in MEASURED if name in METRICS])
@pytest.mark.parametrize("parameter", CASES)
def test_every_number_is_that_of_a_run(parameter, objective):
    experiment, values = CASES[parameter]
    found = sweep(experiment, parameter, values, objective, SEEDS)
    assert found.shape == (len(SEEDS), len(values))
    for row, seed in enumerate(SEEDS):
        for column, value in enumerate(values):
            single = replace(experiment, seed=seed, **field_of(parameter, value, experiment))
            expected = getattr(run_experiment(single).metrics, objective)
            if expected is None:
                assert isnan(found[row, column])
            else:
                assert found[row, column] == pytest.approx(expected, rel=1e-9, abs=0)


def test_a_run_that_stops_has_no_number():
    """Benedict-Bordner gains are stable up to 2 alpha + beta = 4, which is alpha = 4 - sqrt(8) = 1.172."""
    experiment = replace(CASES["alpha"][0], samples=1000)
    values = (0.9, 1.1, 1.25, 1.9)
    found = sweep(experiment, "alpha", values, "innovation_total", SEEDS)
    for column, value in enumerate(values):
        run = run_experiment(replace(experiment, alpha=value, seed=SEEDS[0]))
        assert (run.track.stopped_at is not None) == isnan(found[0, column])
        assert np.isnan(found[:, column]).all() == (value > 4 - sqrt(8))


def test_the_two_variances_are_one_search():
    """The gains depend on their ratio alone: a sweep of one is the other's, mirrored."""
    experiment = papers()["jeong2017"].run("gray-murray").experiment
    process = (experiment.tracking_index / experiment.interval**2) ** 2
    factors = np.logspace(-3, 3, 5)
    up = sweep(experiment, "process_variance", (process * factors).tolist(), "estimation_total", (3,))
    down = sweep(experiment, "sensor_variance", (1 / factors).tolist(), "estimation_total", (3,))
    np.testing.assert_allclose(up, down, rtol=1e-9)


def test_seeds_of_recorded_measurements_do_not_matter():
    found = sweep(*CASES["gamma"][:1], "gamma", CASES["gamma"][1], "tracking_rmse", (1, 2, 3))
    assert (found == found[0]).all()


def test_sweeps_are_remembered_and_read_only():
    experiment, values = CASES["xi"]
    found = sweep(experiment, "xi", list(values), "tracking_total", range(1, 3))
    assert np.shares_memory(sweep(experiment, "xi", values, "tracking_total", (1, 2)), found)
    with pytest.raises(ValueError, match="read-only"):
        found[0, 0] = 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"parameter": "beta"}, "^parameter must be"),
        ({"objective": "error"}, "^objective must be"),
        ({"parameter": "alpha"}, "^parameter must be one of the design 'fading-memory'"),
        ({"parameter": "process_variance"}, "^parameter must be one of the design"),
        ({"values": (0.5, 1.0)}, "^xi must be"),
        ({"seeds": (-1,)}, "^seed must be"),
    ],
    ids=str,
)
def test_what_cannot_be_swept_is_refused(changes, message):
    usual = {"parameter": "xi", "values": (0.5,), "objective": "tracking_total", "seeds": (1,)}
    with pytest.raises(InputError, match=message):
        sweep(CASES["xi"][0], **(usual | changes))


@pytest.mark.parametrize("parameter", ["process_variance", "sensor_variance"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_variance_is_a_positive_number(parameter, value):
    with pytest.raises(InputError, match=f"^{parameter} must be"):
        sweep(CASES[parameter][0], parameter, (value,), "tracking_total", (1,))


def test_a_method_has_no_gains_to_vary():
    run = papers()["alwagih"].run("m4-white").experiment
    with pytest.raises(InputError, match="^parameter must be one of the design 'moving-window'"):
        sweep(run, "alpha", (0.5,), "tracking_total", (1,))
