"""Experiments with methods, with noise given as a ratio, and with manoeuvre noise: links, defaults, results."""

import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker_core import DESIGNS, SCENARIOS, Experiment, InputError, assess, run_experiment
from tracker_core.adaptive import METHODS, PARAMETERS
from tracker_core.experiment import BESIDE
from tracker_core.manoeuvre import MANOEUVRES, wander
from tracker_core.noise import signal_to_noise, std_from_snr
from tracker_core.run import known_state, observe

NAMES = [name for name in METHODS if name not in DESIGNS]
CASES = [pytest.param(name, order, id=f"{name}-{order}") for name in NAMES for order in METHODS[name].orders]
OTHERS = {
    "fixed_alpha": 0.11, "weight": 0.25, "criterion": "mean-absolute", "window": 31, "step": 3, "levels": 9, "grid": 5,
    "grid_eta": 3, "refinements": 2, "members": 7, "memory": 9.5, "shortest": 2.5, "longest": 77.0,
    "objective": "velocity", "end_points": "middle", "ties": "last", "bound": "triangle", "parabola": "printed",
}  # fmt: skip


def read(**values):
    return Experiment.from_dict(values)


def assert_round_trip(experiment):
    full, minimal = experiment.to_dict(), experiment.to_dict(minimal=True)
    assert minimal.items() <= full.items()
    # A link holds text only.
    text = {name: str(value).strip("[]") for name, value in minimal.items()}
    for values in (full, minimal, json.loads(json.dumps(full)), text):
        assert read(**values) == experiment


# Links -------------------------------------------------------------------------------------------------------------


def test_every_parameter_has_another_value_here():
    assert list(OTHERS) == list(PARAMETERS)


@pytest.mark.parametrize(("name", "order"), CASES)
def test_parameters_that_are_not_the_defaults_come_back(name, order):
    told = {parameter: OTHERS[parameter] for parameter in METHODS[name].parameters}
    experiment = read(design=name, order=order, **told)
    assert experiment.parameters() == told
    assert told.items() <= experiment.to_dict(minimal=True).items()
    assert_round_trip(experiment)


@pytest.mark.parametrize(("name", "order"), CASES)
@pytest.mark.parametrize("interval", [0.0125, 1.0, 40.0])
def test_defaults_are_filled_in_and_left_out_again(name, order, interval):
    experiment = read(design=name, order=order, interval=interval)
    assert experiment.parameters() == METHODS[name].defaults(interval)
    assert set(experiment.to_dict(minimal=True)) <= {"design", "order", "interval"}
    assert_round_trip(experiment)


def test_defaults_follow_the_interval():
    fast, slow = (read(design="critically-damped-bank", interval=interval) for interval in (0.2, 5.0))
    assert (fast.shortest, fast.longest, fast.memory) == (0.24, 20.0, 4.0)
    assert (slow.shortest, slow.longest, slow.memory) == (6.0, 120.0, 50.0)
    assert read(design="parallel-bank-causal", interval=0.25).memory == 2.5


@settings(max_examples=100)
@given(data=st.data())
def test_round_trip_of_any_parameters(data):
    name = data.draw(st.sampled_from(NAMES))
    chosen = data.draw(st.sets(st.sampled_from(sorted(METHODS[name].parameters) or ["seed"])))
    told = {parameter: OTHERS[parameter] for parameter in sorted(chosen) if parameter in METHODS[name].parameters}
    if "shortest" in told:
        told["longest"] = OTHERS["longest"]
    scenario = data.draw(st.sampled_from(["yu-wu", "alwagih", "jeong-ship"]))
    extra = data.draw(
        st.fixed_dictionaries(
            {},
            optional={
                "samples": st.integers(50, 1000),
                "interval": st.floats(0.01, 10),
                "noise_std": st.floats(0, 100),
                "manoeuvre": st.sampled_from(list(MANOEUVRES)),
                "seed": st.integers(0, 2**53 - 1),
            },
        )
    )
    assert_round_trip(read(scenario=scenario, design=name, **told, **extra))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("parameter", PARAMETERS)
def test_fields_of_other_methods_are_refused_by_name(name, parameter):
    if parameter in METHODS[name].parameters:
        return
    with pytest.raises(InputError) as caught:
        read(design=name, **{parameter: OTHERS[parameter]})
    assert caught.value.field == parameter
    assert caught.value.rule == f"must be left out for the method '{name}'"


@pytest.mark.parametrize("parameter", PARAMETERS)
def test_fields_of_methods_are_refused_by_a_design(parameter):
    with pytest.raises(InputError) as caught:
        read(xi=0.5, **{parameter: OTHERS[parameter]})
    assert (caught.value.field, caught.value.rule) == (parameter, "must be left out for the design 'fading-memory'")


@pytest.mark.parametrize("parameter", ["alpha", "beta", "gamma", "eta", "xi", "tracking_index"])
def test_parameters_of_designs_are_refused_by_a_method(parameter):
    with pytest.raises(InputError) as caught:
        read(design="growing-memory", order=4, **{parameter: 0.5})
    assert (caught.value.field, caught.value.rule) == (parameter, "must be left out for the method 'growing-memory'")


def test_m1_is_the_design_of_that_name():
    """Where a design and a method share a name, the design is meant: it has more to show."""
    experiment = read(design="benedict-bordner", alpha=0.2, order=2)
    assert experiment.method is None
    alone = run_experiment(experiment)
    truth, measurements, _ = observe(experiment)
    found = METHODS["benedict-bordner"].run(measurements, truth=truth, fixed_alpha=0.2)
    assert found.track.smoothed == pytest.approx(alone.track.smoothed, rel=1e-12, abs=1e-12, nan_ok=True)


# Results -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "order"), CASES)
def test_a_run_is_that_of_the_method(name, order):
    experiment = read(scenario="yu-wu", samples=60, interval=1.0, design=name, order=order, convention="half")
    result = run_experiment(experiment)
    truth, measurements, _ = observe(experiment)
    selection = METHODS[name].run(
        measurements, order, truth=truth, start="known", initial_state=known_state(experiment)
    )
    assert np.array_equal(result.track.smoothed, selection.track.smoothed)
    assert np.array_equal(result.selection.gains, selection.gains)
    assert result.metrics.lag is None
    assert [metrics.lag for metrics in result.axis_metrics()] == [None, None]
    with pytest.raises(InputError):
        read(design=name, order=order, alpha=0.5)


@pytest.mark.parametrize("convention", ["normalised", "taylor", "half"])
def test_a_result_has_the_gains_of_a_sample(convention):
    result = run_experiment(read(scenario="yu-wu", design="sample-search", convention=convention))
    for sample, axis in ((0, 0), (123, 1), (499, 0)):
        at = result.at(sample, axis)
        assert at.gains.convention == convention
        assert at.gains.vector == pytest.approx(result.selection.gains[sample, axis], rel=1e-15, abs=0)
        assert at.verdict == assess(at.gains)
        assert at.track is result.track
    assert result.gains == result.at(499, 0).gains


def test_a_result_of_a_design_is_the_same_at_every_sample():
    result = run_experiment(read())
    assert result.at(17, 1) is result
    assert result.unstable_share() == 0.0
    assert run_experiment(read(alpha=0.5, beta=3.5)).unstable_share() == 1.0


def test_the_unstable_share_counts_corrections(closed_loop, spectral_radius):
    values = {"scenario": "yu-wu", "design": "sample-search", "order": 4, "ties": "last"}
    for bound in ("exact", "triangle", "printed"):
        result = run_experiment(read(**values, bound=bound))
        used = result.selection.gains.reshape(-1, 4)
        used = used[~np.isnan(used[:, 0])]
        share = result.unstable_share()
        assert share == pytest.approx((spectral_radius(closed_loop(used)) >= 1).mean(), rel=1e-12, abs=0)
        assert (share == 0) == (bound == "exact")


def test_a_run_in_which_nothing_is_corrected_has_no_share():
    result = run_experiment(read(samples=3, start="three-point", design="growing-memory", order=3))
    assert result.unstable_share() == 0.0
    assert result.gains.vector.tolist() == [0, 0, 0]


def test_a_longer_causal_run_begins_with_the_shorter_one():
    short, long = (
        run_experiment(read(scenario="yu-wu", samples=samples, design="critically-damped-bank", order=4))
        for samples in (200, 500)
    )
    assert np.array_equal(short.track.smoothed, long.track.smoothed[:200])


# The sensor and the manoeuvres -------------------------------------------------------------------------------------


@pytest.mark.parametrize("level", ["snr", "snr-decibel"])
@pytest.mark.parametrize("manoeuvre", MANOEUVRES)
def test_a_ratio_gives_the_standard_deviation_of_the_true_signal(level, manoeuvre):
    experiment = read(scenario="yu-wu", noise_level=level, snr=7, manoeuvre=manoeuvre)
    truth, measurements, std = observe(experiment)
    assert std == std_from_snr(truth.positions, 7, decibel=level == "snr-decibel")
    ratio = 7 if level == "snr" else 10**0.7
    assert signal_to_noise(truth.positions, std) == pytest.approx((ratio, ratio), rel=1e-12, abs=0)
    # The same draws, at the level of the truth.
    plain = observe(read(scenario="yu-wu", noise_std=1))
    unit = plain[1].positions - plain[0].positions
    assert (measurements.positions - truth.positions) / std == pytest.approx(unit, rel=1e-9, abs=1e-9)
    assert run_experiment(experiment).noise_std == std


@pytest.mark.parametrize("manoeuvre", [name for name in MANOEUVRES if name != "none"])
def test_manoeuvres_reach_the_truth_and_the_measurements(manoeuvre):
    calm, pushed = (
        observe(read(scenario="alwagih", **extra)) for extra in ({}, {"manoeuvre": manoeuvre, "manoeuvre_std": 0.3})
    )
    deviation = wander(manoeuvre, 200, 2, 1.0, 0.3, 1)
    assert np.array_equal(pushed[0].states, calm[0].states + deviation)
    assert np.abs(deviation[-1, :, 0]).min() > 1
    error = [seen.positions - truth.positions for truth, seen, _ in (calm, pushed)]
    assert error[0] == pytest.approx(error[1], rel=0, abs=1e-9)


def test_a_manoeuvre_of_zero_changes_nothing():
    calm, still = (
        observe(read(scenario="alwagih", **extra)) for extra in ({}, {"manoeuvre": "jerk-pulses", "manoeuvre_std": 0})
    )
    assert np.array_equal(calm[1].positions, still[1].positions)


@pytest.mark.parametrize("name", [name for name in BESIDE if name not in {"data", "reading"}])
def test_a_field_beside_another_is_refused_where_that_does_not_call_for_it(name):
    other, values, default = BESIDE[name]
    experiment = read(**{other: values[0]})
    assert getattr(experiment, name) == default
    usual = {"noise_level": "snr"} if name == "noise_std" else {}
    with pytest.raises(InputError) as caught:
        read(**usual, **{name: 3 if name != "noise_correlation" else 0.3})
    assert caught.value.field == name
    assert caught.value.rule.startswith(f"must be left out where {other} is '")
    with pytest.raises(InputError) as caught:
        dataclasses.replace(experiment, **{name: None})
    assert caught.value.field == name
    assert caught.value.rule == f"must be given where {other} is '{values[0]}'"


@pytest.mark.parametrize(("level", "snr"), [("snr", 0), ("snr", -3), ("snr-decibel", 301), ("snr-decibel", -301)])
def test_a_ratio_outside_its_domain_is_refused(level, snr):
    with pytest.raises(InputError) as caught:
        read(noise_level=level, snr=snr)
    assert caught.value.field == "snr"


def test_negative_decibel_are_a_ratio():
    assert observe(read(noise_level="snr-decibel", snr=-20))[2][0] > observe(read(noise_level="snr", snr=1))[2][0]


def test_every_scenario_runs_with_every_method_that_may_look_at_it():
    for scenario in SCENARIOS:
        for name in ("growing-memory", "critically-damped-bank", "run-search"):
            order = METHODS[name].orders[-2]
            result = run_experiment(read(scenario=scenario, design=name, order=order, start="two-point"))
            assert result.track.stopped_at is None
            assert result.metrics.estimation_rmse is not None


def test_a_bank_with_many_weights_is_not_remembered():
    values = {"scenario": "alwagih", "design": "parallel-bank", "samples": 2_500}
    small, large = (Experiment.from_dict({**values, "members": members}) for members in (160, 161))
    assert run_experiment(small) is run_experiment(small)
    first, second = run_experiment(large), run_experiment(large)
    assert first is not second
    assert np.array_equal(first.track.smoothed, second.track.smoothed, equal_nan=True)
