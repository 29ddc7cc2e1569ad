"""What methods refuse: by themselves, in an experiment and on the command line, always with field and rule."""

import numpy as np
import pytest

from tracker_core import SCENARIOS, Experiment, InputError, Measurements, Truth
from tracker_core.__main__ import main
from tracker_core.adaptive import METHODS
from tracker_core.run import known_state, observe

# Fields of an experiment; the field that is refused, and what its rule says.
ABSURD = {
    "no-members": ({"design": "parallel-bank", "members": 0}, "members", ">= 1"),
    "no-members-causal": ({"design": "parallel-bank-causal", "members": 0}, "members", ">= 1"),
    "no-members-mixture": ({"design": "critically-damped-bank", "members": 0}, "members", ">= 1"),
    "half-a-member": ({"design": "parallel-bank", "members": 2.5}, "members", "a whole number"),
    "window-longer": ({"design": "moving-window", "window": 201, "samples": 200}, "window", "< 200"),
    "window-as-long": ({"design": "moving-window", "window": 200, "samples": 200}, "window", "< 200"),
    "window-of-one": ({"design": "moving-window", "window": 1}, "window", ">= 2"),
    "no-grid": ({"design": "moving-window", "levels": 0}, "levels", ">= 1"),
    "no-step": ({"design": "moving-window", "step": 0}, "step", ">= 1"),
    "negative-refinements": ({"design": "moving-window", "refinements": -1}, "refinements", ">= 0"),
    "alpha-zero": ({"design": "moving-window", "fixed_alpha": 0}, "fixed_alpha", "> 0"),
    "alpha-above-one": ({"design": "linear-combination", "fixed_alpha": 1.01}, "fixed_alpha", "<= 1"),
    "weight-above-one": ({"design": "linear-combination", "weight": 1.5}, "weight", "<= 1"),
    "weight-negative": ({"design": "linear-combination", "weight": -0.1}, "weight", ">= 0"),
    "weight-nan": ({"design": "linear-combination", "weight": float("nan")}, "weight", "a finite number"),
    "criterion": ({"design": "linear-combination", "criterion": "median"}, "criterion", "mean-square, mean-absolute"),
    "foreign": ({"design": "parallel-bank", "window": 20}, "window", "left out for the method 'parallel-bank'"),
    "foreign-memory": ({"design": "parallel-bank", "memory": 2}, "memory", "left out for the method 'parallel-bank'"),
    "foreign-weight": ({"design": "growing-memory", "weight": 0.5}, "weight", "left out for the method 'growing-"),
    "order": ({"design": "parallel-bank", "order": 3}, "order", "2 for the method 'parallel-bank'"),
    "order-search": ({"design": "sample-search", "order": 2}, "order", "3 or 4 for the method 'sample-search'"),
    "expanding": ({"design": "growing-memory", "start": "expanding"}, "start", "not be 'expanding' for the method"),
    "longest": ({"design": "critically-damped-bank", "shortest": 5, "longest": 4}, "longest", ">= 5"),
    "shortest-beyond-the-default": ({"design": "critically-damped-bank", "shortest": 500}, "longest", ">= 500"),
    "shortest-zero": ({"design": "critically-damped-bank", "shortest": 0}, "shortest", ">= 1e-06"),
    "no-memory": ({"design": "critically-damped-bank", "memory": 0}, "memory", ">= 1e-06"),
    "no-levels": ({"design": "sample-search", "grid": 0}, "grid", ">= 1"),
    "no-levels-eta": ({"design": "sample-search", "order": 4, "grid_eta": 0}, "grid_eta", ">= 1"),
    "huge-grid": ({"design": "sample-search", "grid": 200}, "grid", "at most 500,000,000 filter steps"),
    "huge-grid-run": ({"design": "run-search", "order": 4, "grid": 30}, "grid", "at most 500,000,000 filter steps"),
    "long-search": ({"design": "sample-search", "grid": 12, "samples": 200_000}, "grid", "at most 500,000,000"),
    "long-run-search": ({"design": "run-search", "grid": 8, "samples": 200_000}, "grid", "at most 500,000,000"),
    "beyond-any-grid": ({"design": "sample-search", "grid": 201}, "grid", "<= 200"),
    "both-ends-of-one": ({"design": "sample-search", "grid": 1, "end_points": "both"}, "grid", ">= 2"),
    "both-ends-of-one-eta": (
        {"design": "run-search", "order": 4, "grid_eta": 1, "end_points": "both"}, "grid_eta", ">= 2"),
    "none-stable": ({"design": "run-search", "grid": 2, "end_points": "both"}, "grid", "a stable set"),
    "objective-above-the-order": (
        {"design": "sample-search", "order": 3, "objective": "jerk"}, "objective",
        "position, velocity, acceleration, which"),
    "objective-unknown-to-all": (
        {"scenario": "singer", "design": "sample-search", "order": 4, "objective": "jerk"}, "objective",
        "position, velocity, acceleration, which"),
    "objective-snap": ({"design": "sample-search", "objective": "snap"}, "objective", "one of position"),
    "huge-bank": ({"design": "parallel-bank", "members": 201}, "members", "<= 200"),
    "huge-mixture": (
        {"design": "critically-damped-bank", "members": 26, "samples": 200_000, "order": 3}, "members", "<= 20 for"),
    "huge-window": ({"design": "moving-window", "window": 10_000, "samples": 200_000}, "window", "at most 500,000,000"),
}  # fmt: skip


def cases(table):
    return [pytest.param(*case, id=name) for name, case in table.items()]


@pytest.mark.parametrize(("values", "field", "rule"), cases(ABSURD))
def test_an_experiment_refuses(values, field, rule):
    with pytest.raises(InputError) as caught:
        Experiment.from_dict(values)
    assert caught.value.field == field
    assert caught.value.rule.startswith("must")
    assert rule in caught.value.rule


@pytest.mark.parametrize(("values", "field", "rule"), cases(ABSURD))
def test_the_command_line_refuses_in_one_line(capsys, values, field, rule):
    flags = [text for name, value in values.items() for text in (f"--{name.replace('_', '-')}", str(value))]
    assert main(["run", *flags]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"python -m tracker_core: {field} must")
    assert rule in err
    assert err.count("\n") == 1


SENSOR = ("scenario", "samples", "interval")


@pytest.mark.parametrize(("values", "field", "rule"), cases(ABSURD))
def test_the_method_itself_refuses(values, field, rule):
    usual = {"order": METHODS[values["design"]].orders[0], "start": "two-point"} | values
    seen = Experiment.from_dict({name: usual[name] for name in SENSOR if name in usual})
    truth, measurements, _ = observe(seen)
    told = {name: value for name, value in usual.items() if name not in (*SENSOR, "design", "order", "start")}
    with pytest.raises(InputError) as caught:
        METHODS[usual["design"]].run(measurements, usual["order"], truth=truth, start=usual["start"], **told)
    assert caught.value.field == field
    assert rule in caught.value.rule


@pytest.mark.parametrize("name", ["sample-search", "run-search"])
def test_a_search_needs_a_truth(name):
    measurements = Measurements(np.arange(20.0), np.zeros((20, 1)), 1.0)
    with pytest.raises(InputError) as caught:
        METHODS[name].run(measurements, 3)
    assert caught.value.field == "design"
    assert "needs the truth" in caught.value.rule


@pytest.mark.parametrize("name", METHODS)
def test_an_unknown_parameter_is_refused(name):
    measurements = Measurements(np.arange(20.0), np.zeros((20, 1)), 1.0)
    with pytest.raises(InputError) as caught:
        METHODS[name].run(measurements, METHODS[name].orders[0], speed=3)
    assert caught.value.field == "speed"


@pytest.mark.parametrize("order", [None, 0, 2.5, 5, "two"])
def test_a_method_of_several_orders_must_be_told_a_whole_one(order):
    measurements = Measurements(np.arange(20.0), np.zeros((20, 1)), 1.0)
    with pytest.raises(InputError) as caught:
        METHODS["growing-memory"].run(measurements, order)
    assert caught.value.field == "order"


def test_what_is_just_admitted_runs():
    """The bounds that the rules name are the last good values."""
    assert Experiment.from_dict({"design": "moving-window", "window": 199, "samples": 200}).window == 199
    assert Experiment.from_dict({"design": "parallel-bank", "members": 50, "samples": 200_000}).members == 50
    assert Experiment.from_dict({"design": "critically-damped-bank", "shortest": 3, "longest": 3}).longest == 3
    jerk = {"design": "sample-search", "order": 4, "objective": "jerk"}
    assert Experiment.from_dict(jerk).objective == "jerk"
    singer = Experiment.from_dict({"scenario": "singer", "design": "sample-search", "objective": "acceleration"})
    assert SCENARIOS["singer"].known_states == 3
    truth, measurements, _ = observe(singer)
    selection = METHODS["sample-search"].run(
        measurements, singer.order, truth=truth, start=singer.start, initial_state=known_state(singer)
    )
    assert selection.track.stopped_at is None


@pytest.mark.parametrize("name", METHODS)
def test_too_few_measurements_for_the_start_are_refused(name):
    positions = np.full((40, 1), np.nan)
    positions[3] = 1.0
    truth = Truth(np.arange(40.0), np.zeros((40, 1, 5)))
    with pytest.raises(InputError) as caught:
        METHODS[name].run(Measurements(truth.times, positions, 1.0), METHODS[name].orders[0], truth=truth)
    assert caught.value.field == "positions"
