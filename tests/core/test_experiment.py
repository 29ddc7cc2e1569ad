"""The experiment: read, refused, written, and run to the same bits."""

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tracker_core import (
    CONVENTIONS,
    DESIGNS,
    SCENARIOS,
    STARTS,
    Experiment,
    Gains,
    InputError,
    run_experiment,
    run_filter,
)
from tracker_core.experiment import DEFAULTS, read_experiment
from tracker_core.fields import FIELDS
from tracker_core.metrics import measure
from tracker_core.run import CACHED_SAMPLES, known_state, observe

GAIN_NAMES = ["alpha", "beta", "gamma", "eta"]


def read(**values):
    return Experiment.from_dict(values)


# Valid experiments, of every kind ----------------------------------------------------------------------------------

PARAMETER = {
    "alpha": st.floats(0.1, 0.99),
    "beta": st.floats(0.1, 2),
    "xi": st.floats(0, 0.99),
    "tracking_index": st.floats(1e-12, 1e6),
}
GAIN = st.floats(-27, 27)


@st.composite
def descriptions(draw):
    """The complete fields of a valid experiment."""
    scenario = SCENARIOS[draw(st.sampled_from(list(SCENARIOS)))]
    values = {"scenario": scenario.name, "seed": draw(st.integers(0, 2**53 - 1))}
    values["noise"] = draw(st.sampled_from(["white", "none", *(["recorded"] if scenario.recording else [])]))
    recorded = values["noise"] == "recorded"
    values["samples"] = draw(st.integers(3, 10 if recorded else 200_000))
    values["interval"] = scenario.recording.interval if recorded else draw(st.floats(1e-6, 1e6))
    count = draw(st.sampled_from([1, len(scenario.axes)]))
    values["noise_std"] = draw(st.lists(st.floats(0, 1e9), min_size=count, max_size=count))
    values["design"] = draw(st.sampled_from(["manual", *DESIGNS]))
    if values["design"] == "manual":
        order = draw(st.integers(2, 4))
        values |= {name: draw(GAIN) for name in GAIN_NAMES[:order]}
    else:
        order = draw(st.sampled_from(DESIGNS[values["design"]].orders))
        values |= {name: draw(PARAMETER[name]) for name in DESIGNS[values["design"]].parameters}
    values["order"] = order
    values["start"] = draw(st.sampled_from([name for name, start in STARTS.items() if start.least_order <= order]))
    values["convention"] = draw(st.sampled_from(list(CONVENTIONS)))
    return values


@st.composite
def tweaks(draw):
    """A scenario as it comes, with one or two of its own fields changed: what moving a slider makes."""
    usual = read(scenario=draw(st.sampled_from(list(SCENARIOS)))).to_dict()
    changes = {
        "alpha": st.floats(0.1, 0.9),
        "beta": st.floats(0.1, 0.9),
        "gamma": st.floats(0.1, 0.9),
        "xi": st.floats(0, 0.99),
        "seed": st.integers(0, 99),
        "samples": st.integers(3, 10),
        "noise": st.sampled_from(["white", "none"]),
        "start": st.sampled_from(["known", "first", "two-point", "expanding"]),
        "convention": st.sampled_from(list(CONVENTIONS)),
    }
    names = draw(st.sets(st.sampled_from([name for name in changes if name in usual]), min_size=1, max_size=2))
    return usual | {name: draw(changes[name]) for name in sorted(names)}


def assert_round_trip(values):
    experiment = read(**values)
    full, minimal = experiment.to_dict(), experiment.to_dict(minimal=True)
    assert {name: full[name] for name in values} == values
    assert minimal.items() <= full.items()
    assert read(**json.loads(json.dumps(full))) == experiment
    assert read(**json.loads(json.dumps(minimal))) == experiment


@given(values=descriptions())
def test_round_trip(values):
    assert_round_trip(values)


@given(values=tweaks())
@example(values={**read(scenario="garg-accelerating").to_dict(), "alpha": 0.3})
@example(values={**read(scenario="garg-accelerating").to_dict(), "gamma": 0.2})
@example(values={**read(scenario="garg-constant-velocity").to_dict(), "beta": 0.2})
def test_round_trip_of_a_scenario_with_a_change(values):
    assert_round_trip(values)


@given(values=descriptions())
def test_round_trip_as_text(values):
    """A link holds text only."""
    experiment = read(**values)
    text = {name: str(value) for name, value in experiment.to_dict().items()}
    text["noise_std"] = ",".join(str(value) for value in experiment.noise_std)
    assert read(**text) == experiment


@pytest.mark.parametrize("name", SCENARIOS)
def test_minimal_description_of_a_scenario_as_it_comes(name):
    minimal = read(scenario=name).to_dict(minimal=True)
    assert minimal == ({} if name == DEFAULTS["scenario"] else {"scenario": name})


def test_minimal_description_names_what_differs_and_no_more():
    assert read(seed=7, xi=0.5).to_dict(minimal=True) == {"seed": 7, "xi": 0.5}
    assert read(noise_std=[10, 20]).to_dict(minimal=True) == {"noise_std": [10, 20]}
    assert read(scenario="garg-constant-velocity", beta=0.3).to_dict(minimal=True) == {
        "scenario": "garg-constant-velocity",
        "beta": 0.3,
    }


def test_another_order_keeps_the_usual_design_and_its_parameter():
    experiment = read(order=4)
    assert (experiment.design, experiment.xi) == ("fading-memory", DEFAULTS["xi"])
    assert experiment.to_dict(minimal=True) == {"order": 4}
    assert read(order=4, xi=0.7).to_dict(minimal=True) == {"order": 4, "xi": 0.7}


def test_another_design_keeps_no_parameter_of_the_usual_one():
    """Even where the number is the same, it is named."""
    minimal = {"design": "jeong-fading-memory-as-run", "xi": DEFAULTS["xi"]}
    assert read(**minimal).to_dict(minimal=True) == minimal
    with pytest.raises(InputError, match="^xi must be given"):
        read(design="jeong-fading-memory-as-run")


def test_another_order_of_a_manual_filter_keeps_no_gain():
    minimal = {"scenario": "garg-accelerating", "order": 2, "alpha": 0.5, "beta": 0.4}
    assert read(**minimal).to_dict(minimal=True) == minimal
    with pytest.raises(InputError, match="^alpha must be given for order 2"):
        read(scenario="garg-accelerating", order=2)


def test_full_description_has_no_empty_fields():
    full = read(design="kalata", tracking_index=1).to_dict()
    assert list(full) == [
        "scenario", "samples", "interval", "noise", "noise_level", "noise_std", "manoeuvre", "seed", "start", "order",
        "convention", "design", "tracking_index",
    ]  # fmt: skip
    assert full["noise_std"] == [10.0]


@given(values=descriptions())
def test_an_experiment_is_a_key(values):
    """Equal descriptions are equal and hash alike: caches rest on it."""
    assert read(**values) == read(**values)
    assert hash(read(**values)) == hash(read(**values))
    assert read(**values) != read(**{**values, "seed": (values["seed"] + 1) % 2**53})


# What is left out --------------------------------------------------------------------------------------------------


def test_nothing_given_means_the_defaults():
    experiment = read()
    expected = {**DEFAULTS, **SCENARIOS["jeong-ship"].defaults}
    assert {name: getattr(experiment, name) for name in expected} == expected


def test_none_is_as_good_as_left_out():
    assert read(**dict.fromkeys(FIELDS)) == read()


@pytest.mark.parametrize(
    ("given_fields", "design", "order"),
    [
        ({}, "fading-memory", 3),
        ({"order": 2}, "fading-memory", 2),
        ({"order": 4}, "fading-memory", 4),
        ({"xi": 0.5}, "fading-memory", 3),
        ({"xi": 0.5, "order": 2}, "fading-memory", 2),
        ({"xi": 0.5, "order": 4}, "fading-memory", 4),
        ({"tracking_index": 1}, "gray-murray", 3),
        ({"tracking_index": 1, "order": 2}, "kalata", 2),
        ({"tracking_index": 1, "order": 4}, "steady-kalman", 4),
        ({"alpha": 0.5, "beta": 0.2}, "manual", 2),
        ({"alpha": 0.5, "beta": 0.2, "gamma": 0.1}, "manual", 3),
        ({"alpha": 0.5, "beta": 0.2, "gamma": 0.1, "eta": 0.01}, "manual", 4),
        ({"design": "kalata", "tracking_index": 1}, "kalata", 2),
        ({"design": "simpson", "alpha": 0.5, "beta": 0.3}, "simpson", 3),
        ({"scenario": "garg-constant-velocity"}, "manual", 2),
        ({"scenario": "garg-accelerating"}, "manual", 3),
        ({"scenario": "garg-accelerating", "xi": 0.5}, "fading-memory", 3),
        ({"scenario": "constant-velocity", "xi": 0.5}, "fading-memory", 2),
    ],
    ids=str,
)
def test_the_parameters_choose_the_design(given_fields, design, order):
    experiment = read(**given_fields)
    assert (experiment.design, experiment.order) == (design, order)


@pytest.mark.parametrize(
    "change",
    [{"alpha": 0.3}, {"beta": 0.3}, {"gamma": 0.3}, {"alpha": 0.3, "beta": 0.3}],
    ids=" ".join,
)
def test_one_gain_of_a_manual_filter_may_be_changed(change):
    """The others stay as the scenario has them."""
    experiment = read(scenario="garg-accelerating", **change)
    expected = {"alpha": 0.5, "beta": 0.4, "gamma": 0.1} | change
    assert experiment.gains() == Gains(tuple(expected.values()), "taylor")


@pytest.mark.parametrize("name", CONVENTIONS)
def test_gains_are_written_in_the_convention_of_the_experiment(name):
    designed = read(design="fading-memory", order=4, xi=0.7, convention=name).gains()
    assert designed.convention == name
    assert designed.vector == pytest.approx(DESIGNS["fading-memory"].gains(4, xi=0.7), rel=1e-15, abs=0)
    assert read(alpha=0.5, beta=0.2, gamma=0.1, convention=name).gains() == Gains((0.5, 0.2, 0.1), name)


# What is refused ---------------------------------------------------------------------------------------------------

REFUSED = [
    ({"interval": 0}, "interval", "must be a finite number >= 1e-06", 0),
    ({"interval": -1}, "interval", "must be a finite number >= 1e-06", -1),
    ({"interval": math.nan}, "interval", "must be a finite number", math.nan),
    ({"interval": math.inf}, "interval", "must be a finite number", math.inf),
    ({"interval": "soon"}, "interval", "must be a finite number", "soon"),
    ({"samples": 2}, "samples", "must be a whole number >= 3 and <= 200,000", 2),
    ({"samples": 200_001}, "samples", "must be a whole number >= 3 and <= 200,000", 200_001),
    ({"samples": 3.5}, "samples", "must be a whole number", 3.5),
    ({"samples": True}, "samples", "must be a whole number", True),
    ({"samples": math.inf}, "samples", "must be a whole number", math.inf),
    ({"noise_std": -1}, "noise_std", "must be a finite number >= 0", -1),
    ({"noise_std": [1, -0.5]}, "noise_std", "must be a finite number >= 0", -0.5),
    ({"noise_std": "1,much"}, "noise_std", "must be a finite number >= 0", "much"),
    ({"noise_std": math.nan}, "noise_std", "must be a finite number >= 0", math.nan),
    ({"noise_std": []}, "noise_std", "must be one number, or one per axis", "0 values"),
    ({"noise_std": [1, 2, 3]}, "noise_std", "must be one number, or 2 for the axes x, y", [1, 2, 3]),
    ({"scenario": "garg-accelerating", "noise_std": "1,2"}, "noise_std", "must be one number", [1, 2]),
    ({"seed": -1}, "seed", "must be a whole number >= 0", -1),
    ({"seed": 0.5}, "seed", "must be a whole number >= 0", 0.5),
    ({"seed": 2**53}, "seed", "must be a whole number >= 0", 2**53),
    ({"order": 1}, "order", "must be a whole number >= 2 and <= 4", 1),
    ({"order": 5}, "order", "must be a whole number >= 2 and <= 4", 5),
    ({"scenario": "mars"}, "scenario", "must be one of jeong-ship, ", "mars"),
    ({"noise": "pink"}, "noise", "must be one of white, coloured, none, recorded", "pink"),
    ({"start": "cold"}, "start", "must be one of known, first, two-point, three-point, expanding", "cold"),
    ({"convention": "own"}, "convention", "must be one of normalised, taylor, half", "own"),
    ({"design": "guess"}, "design", "must be one of manual, fading-memory, ", "guess"),
    ({"design": ["manual"]}, "design", "must be one of manual", ["manual"]),
    ({"alpha": math.nan, "beta": 1}, "alpha", "must be a finite number", math.nan),
    ({"alpha": 0.5, "beta": "1e4"}, "beta", "must be a finite number >= -1,000 and <= 1,000", "1e4"),
    ({"alpha": 0.5}, "beta", "must be given for order 2", None),
    ({"order": 3, "alpha": 0.5, "beta": 0.2}, "gamma", "must be given for order 3", None),
    ({"order": 4, "alpha": 0.5, "beta": 0.2, "gamma": 0.1}, "eta", "must be given for order 4", None),
    ({"order": 2, "alpha": 0.5, "beta": 0.2, "gamma": 0.1}, "gamma", "must be left out", 0.1),
    ({"order": 2, "alpha": 0.5, "beta": 0.2, "xi": 0.1, "design": "manual"}, "xi", "must be left out", 0.1),
    ({"design": "benedict-bordner", "alpha": 2}, "alpha", "must be a finite number > 0 and < 2", 2),
    ({"design": "benedict-bordner", "alpha": 2.5}, "alpha", "must be a finite number > 0 and < 2", 2.5),
    ({"design": "benedict-bordner"}, "alpha", "must be given for the design 'benedict-bordner'", None),
    ({"design": "kalata", "tracking_index": 0}, "tracking_index", "must be a finite number >= 1e-12 and <= 1,0", 0),
    ({"tracking_index": -1}, "tracking_index", "must be a finite number >= 1e-12 and <= 1,000,000", -1),
    ({"tracking_index": 9e-13}, "tracking_index", "must be a finite number >= 1e-12 and <= 1,000,000", 9e-13),
    ({"tracking_index": 1000001}, "tracking_index", "must be a finite number >= 1e-12 and <= 1,000,000", 1000001),
    ({"xi": 1}, "xi", "must be a finite number >= 0 and < 1", 1),
    ({"xi": -0.1}, "xi", "must be a finite number >= 0 and < 1", -0.1),
    ({"xi": 0.5, "design": "kalata", "tracking_index": 1}, "xi", "must be left out for the design 'kalata'", 0.5),
    ({"design": "kalata", "order": 3, "tracking_index": 1}, "order", "must be 2 for the design 'kalata'", 3),
    ({"design": "gray-murray", "tracking_index": 1, "order": 4}, "order", "must be 3 for the design 'gray-m", 4),
    ({"start": "three-point", "order": 2, "xi": 0.5}, "start", "must not be 'three-point' for a", "three-point"),
    ({"noise": "recorded"}, "noise", "must not be 'recorded': nothing was recorded for 'jeong-ship'", "recorded"),
    ({"scenario": "garg-accelerating", "samples": 11}, "samples", "must be <= 10 for recorded measurements", 11),
    ({"scenario": "garg-accelerating", "interval": 1}, "interval", "must be 5 for recorded measurements", 1),
    ({"scenario": "garg-accelerating", "manoeuvre": "acceleration-jumps", "manoeuvre_std": 1}, "manoeuvre",
     "must be 'none' for recorded measurements", "acceleration-jumps"),
    ({"speed": 3}, "speed", "", 3),
]  # fmt: skip


@pytest.mark.parametrize(
    ("values", "field", "rule", "received"), REFUSED, ids=lambda part: str(part) if isinstance(part, dict) else ""
)
def test_bad_input_is_refused(values, field, rule, received):
    with pytest.raises(InputError) as caught:
        Experiment.from_dict(values)
    error = caught.value
    assert error.field == field
    assert error.rule.startswith(rule)
    assert repr(error.received) == repr(received) or error.received == received
    assert str(error).startswith(f"{field} {error.rule}, got ")


def test_every_error_is_reported_at_once():
    experiment, errors = read_experiment({"interval": -1, "samples": 1, "seed": 1, "scenario": "mars", "speed": 3})
    assert experiment is None
    assert [error.field for error in errors] == ["interval", "samples", "scenario", "speed"]


def test_an_experiment_made_by_hand_is_checked_too():
    with pytest.raises(InputError, match="^interval must be"):
        dataclasses.replace(read(), interval=-1.0)
    with pytest.raises(InputError, match="^xi must be given"):
        dataclasses.replace(read(), xi=None)


# Anything at all ---------------------------------------------------------------------------------------------------

JSON_VALUE = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20) | st.just(10**400),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=6,
)
# Near misses: the right kind of value for one field or another, so that the deeper checks are reached as well.
PLAUSIBLE = (
    st.sampled_from(sorted({choice for field in FIELDS.values() for choice in field.choices}))
    | st.integers(-1, 12)
    | st.floats(-1, 3)
    | st.sampled_from(["3", "0.5", "nan", "", "1,2", "1,2,3"])
)


@st.composite
def plausible_fields(draw):
    """Every field that is given has a value of its own kind."""
    names = draw(st.sets(st.sampled_from(list(FIELDS)), max_size=6))
    return {
        name: draw(st.sampled_from(FIELDS[name].choices) if FIELDS[name].choices else PLAUSIBLE)
        for name in sorted(names)
    }


ANY_FIELDS = st.dictionaries(st.sampled_from(list(FIELDS)) | st.text(max_size=50), JSON_VALUE | PLAUSIBLE, max_size=8)


@given(values=ANY_FIELDS | plausible_fields())
@example(values={"design": "manual"})
@example(values={"design": "manual", "xi": 0.5})
@example(values={"design": "manual", "tracking_index": 0.5})
@example(values={"design": "jeong-gray-murray", "tracking_index": 1e-40})
@example(values={"scenario": "garg-accelerating", "order": 4})
@example(values={"a\nb": 1})
def test_whatever_is_read_is_an_experiment_or_errors(values):
    experiment, errors = read_experiment(values)
    if experiment is not None:
        assert errors == []
        assert read(**experiment.to_dict()) == experiment
        assert experiment.gains().order == experiment.order
        return
    assert errors
    for error in errors:
        assert type(error) is InputError
        assert isinstance(error.field, str)
        assert error.rule
        assert hasattr(error, "received")
        assert len(str(error).splitlines()) == 1


def test_a_number_with_thousands_of_digits_is_an_error_like_any_other():
    """Python refuses to spell it out; the message must not."""
    _, errors = read_experiment({"samples": 10**5000})
    assert [error.field for error in errors] == ["samples"]


@pytest.mark.parametrize("values", [None, [], "samples", 3, [("samples", 3)]], ids=repr)
def test_what_is_no_mapping_is_a_programming_error(values):
    with pytest.raises((AttributeError, TypeError)):
        read_experiment(values)


@pytest.mark.parametrize(("convention", "other"), [("taylor", "normalised"), ("normalised", "half")])
@given(gamma=st.floats(1e-9, 1000))
@example(gamma=600.0)
@example(gamma=1000.0)
def test_gains_that_are_admitted_can_be_used_and_rewritten(convention, other, gamma):
    gains = read(alpha=0.5, beta=0.2, gamma=gamma, convention=convention).gains()
    assert gains.to(other).vector.tolist() == gains.vector.tolist()


# The run -----------------------------------------------------------------------------------------------------------

RUNS = [
    {},
    {"scenario": "garg-accelerating"},
    {"scenario": "constant-velocity", "start": "known", "noise_std": "5,20"},
    {"scenario": "constant-acceleration", "start": "expanding", "order": 3, "xi": 0.9, "samples": 30},
    {"noise": "none", "start": "three-point", "samples": 3},
]


@pytest.mark.parametrize("values", RUNS, ids=str)
def test_a_run_is_its_parts_put_together(values):
    experiment = read(**values)
    result = run_experiment(experiment)
    scenario = SCENARIOS[experiment.scenario]
    times = (scenario.first_sample + np.arange(experiment.samples)) * experiment.interval
    truth = scenario.truth(times)
    assert result.scenario is scenario
    assert np.array_equal(result.truth.times, times)
    assert np.array_equal(result.truth.states, truth.states)
    track = run_filter(
        result.measurements, experiment.gains(), start=experiment.start, initial_state=known_state(experiment)
    )
    assert np.array_equal(result.track.smoothed, track.smoothed, equal_nan=True)
    assert result.metrics == measure(track, result.measurements, truth, result.gains, stable=result.verdict.stable)
    assert len(result.axis_metrics()) == len(scenario.axes)


@given(values=descriptions(), samples=st.integers(3, 40))
def test_every_experiment_that_is_admitted_runs(values, samples):
    """To figures that are finite or undefined, never infinite or NaN."""
    result = run_experiment(read(**{**values, "samples": min(samples, values["samples"])}))
    for metrics in (result.metrics, *result.axis_metrics()):
        assert all(value is None or math.isfinite(value) for value in metrics.to_dict().values())


@pytest.mark.parametrize("values", RUNS, ids=str)
def test_same_experiment_same_bits(values):
    first, second = run_experiment(read(**values)), run_experiment(read(**values))
    assert np.array_equal(first.measurements.positions, second.measurements.positions)
    assert np.array_equal(first.track.smoothed, second.track.smoothed, equal_nan=True)
    assert first.metrics == second.metrics


def test_remembered_and_fresh_observations_are_the_same():
    """Long runs are computed anew, short ones are kept: a longer run begins with the shorter one either way."""
    _, short, _ = observe(read(samples=CACHED_SAMPLES))
    _, long, _ = observe(read(samples=CACHED_SAMPLES + 1))
    assert np.array_equal(short.positions, long.positions[:CACHED_SAMPLES])
    assert observe(read(samples=5))[0] is observe(read(samples=5))[0]


def test_what_is_remembered_cannot_be_spoilt():
    result = run_experiment(read(samples=5))
    for array in (result.truth.states, result.truth.times, result.measurements.positions):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_without_noise_the_truth_is_observed():
    result = run_experiment(read(noise="none"))
    assert np.array_equal(result.measurements.positions, result.truth.positions)


@pytest.mark.parametrize("std", [[20.0], [5.0, 50.0]], ids=str)
def test_noise_has_its_standard_deviation_on_every_axis(std):
    result = run_experiment(read(noise_std=std, samples=20_000))
    errors = result.measurements.positions - result.truth.positions
    assert errors.std(axis=0) == pytest.approx(std * (2 // len(std)), rel=5 / math.sqrt(2 * 20_000), abs=0)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_known_start_is_the_truth_one_interval_before(order):
    experiment = read(scenario="constant-acceleration", start="known", order=order, xi=0.5, interval=2.0)
    expected = SCENARIOS["constant-acceleration"].truth(np.array([-2.0])).states[0, :, :order]
    assert np.array_equal(known_state(experiment), expected)
    assert known_state(dataclasses.replace(experiment, start="first")) is None


@pytest.mark.parametrize("start", ["known", "three-point", "expanding"])
def test_a_perfect_sensor_and_the_right_model_leave_no_error(start):
    experiment = read(scenario="constant-acceleration", noise="none", start=start, order=3, xi=0.5)
    track = run_experiment(experiment).track
    assert np.abs(track.innovation[3:]).max() <= 1e-8


def test_an_unstable_run_says_where_it_stopped():
    result = run_experiment(read(alpha=0.5, beta=3.5))
    assert not result.verdict.stable
    assert result.metrics.lag is None
    stop = result.track.stopped_at
    assert np.abs(result.track.smoothed[stop, :, 0]).max() > result.track.limit
    assert result.metrics.estimation_total is not None
