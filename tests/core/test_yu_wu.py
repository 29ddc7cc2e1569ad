"""Yu & Wu 2017: the target of jerk segments, the reconstruction of their tables, and what real noise makes of it."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from statistics import fmean, median

import numpy as np
import pytest
from scipy.optimize import minimize

from tracker_core import SCENARIOS, Experiment, Gains, Measurements, run_experiment, run_filter
from tracker_core.papers import papers
from tracker_core.run import known_state

INTERVALS = [0.2, 0.1, 0.05, 0.025, 0.0125]
SIGMAS = [1, 10, 50]

# The target --------------------------------------------------------------------------------------------------------


def states(times):
    return SCENARIOS["yu-wu"].truth(np.asarray(times, dtype=float)).states


@pytest.mark.parametrize("joint", range(10, 100, 10))
def test_segments_join_to_the_acceleration(joint):
    before, at, after = states([joint - 1e-7, joint, joint + 1e-7])[:, :, :3]
    for beside in (before, after):
        assert beside == pytest.approx(at, rel=1e-8, abs=1e-4)


@pytest.mark.parametrize("derivative", range(4))
def test_every_state_is_the_derivative_of_the_one_before(derivative):
    times = np.linspace(0.5, 109.5, 439)
    times = times[(np.abs(times[:, None] - np.arange(0, 101, 10)) > 0.1).all(axis=1)]
    step = 0.01
    before, at, after = (states(times + shift) for shift in (-step, 0, step))
    slope = (after - before)[:, :, derivative] / (2 * step)
    scale = np.abs(at[:, :, derivative]).max() * 1e-16 / step + np.abs(at[:, :, derivative + 1]).max() * 1e-5
    assert np.abs(slope - at[:, :, derivative + 1]).max() <= 10 * scale + 1e-12


def test_jerk_is_the_printed_one():
    jerk = states(np.arange(5, 100, 10))[:, :, 3]
    assert jerk[:, 0].tolist() == [0, -2, 4, -4, 2, -2, 4, -2, 4, -4]
    assert jerk[:, 1].tolist() == [0, -1, 2, -2, 2, -2, 2, -2, 2, -1]
    # A joint belongs to the segment that begins with it, whatever rounding does to its time.
    assert states([10 - 1e-12, 10, 10 + 1e-12])[:, 0, 3].tolist() == [-2, -2, -2]


@pytest.mark.parametrize("interval", [*INTERVALS, 0.3, 7.0])
def test_the_same_place_is_reached_with_every_interval(interval):
    """In steps of that interval, and in steps of Taylor's series that end on every joint."""
    samples = int(100 / interval)
    along = states(np.arange(1, samples + 1) * interval)[-1]
    assert along == pytest.approx(states([samples * interval])[0], rel=1e-12, abs=1e-9)
    state = np.array([[1000.0, 200, 0], [-1000, 200, 0]])
    transition = np.array([[1, 10, 50], [0, 1, 10], [0, 0, 1.0]])
    push = np.array([1000 / 6, 50, 10])
    for jerk in states(np.arange(5, 100, 10))[:, :, 3]:
        state = state @ transition.T + jerk[:, None] * push
    assert states([100.0])[0, :, :3] == pytest.approx(state, rel=1e-9, abs=1e-6)


# The tables, reconstructed -----------------------------------------------------------------------------------------

# Estimation L2 in metres: medians that a reconstruction by hand gave.
FOUND = {
    "gamma": dict(zip(INTERVALS, [4.33e-3, 7.44e-4, 1.29e-4, 2.28e-5, 4.03e-6], strict=True)),
    "delta": dict(zip(INTERVALS, [2.22e-3, 2.22e-4, 2.05e-5, 1.80e-6, 1.62e-7], strict=True)),
}


@cache
def medians(kind, interval):
    (run,) = [run for run in papers()["yu2017"].runs if run.name == f"{kind}-{interval}"]
    return median(run_experiment(replace(run.experiment, seed=seed)).metrics.estimation_l2 for seed in range(1, 21))


@pytest.mark.parametrize("kind", FOUND)
@pytest.mark.parametrize("interval", INTERVALS)
def test_reconstruction(kind, interval):
    assert medians(kind, interval) == pytest.approx(FOUND[kind][interval], rel=0.15)


@pytest.mark.parametrize("interval", INTERVALS)
def test_the_fourth_gain_helps_at_every_interval(interval):
    assert medians("delta", interval) < 0.7 * medians("gamma", interval)


@pytest.mark.parametrize("kind", FOUND)
def test_the_error_falls_with_the_interval(kind):
    found = [medians(kind, interval) for interval in INTERVALS]
    assert all(after < before / 4 for before, after in pairwise(found))


# With noise on the position ----------------------------------------------------------------------------------------


@cache
def against_raw(kind, sigma):
    """Estimation RMSE over that of the raw measurement at T = 0.2 s, in the mean over ten seeds."""
    if kind == "bank":
        values = {"scenario": "yu-wu", "noise_std": sigma, "design": "critically-damped-bank", "order": 4}
        experiment = Experiment.from_dict(values)
    else:
        (run,) = [run for run in papers()["yu2017"].runs if run.name == f"{kind}-sigma-{sigma}"]
        experiment = run.experiment
    found = [run_experiment(replace(experiment, seed=seed)).metrics for seed in range(1, 11)]
    return fmean(metrics.estimation_rmse / metrics.observation_rmse for metrics in found)


@pytest.mark.parametrize("sigma", SIGMAS)
def test_the_oracle_of_order_4_is_worse_than_the_raw_measurement(sigma):
    assert 6 < against_raw("delta", sigma) < 8


@pytest.mark.parametrize("sigma", SIGMAS)
def test_the_oracle_of_order_3_is_hardly_better(sigma):
    assert 0.85 < against_raw("gamma", sigma) < 1


@pytest.mark.parametrize("sigma", SIGMAS)
def test_a_causal_bank_is_much_better(sigma):
    assert against_raw("bank", sigma) < 0.75
    assert against_raw("bank", sigma) == pytest.approx({1: 0.7331, 10: 0.5935, 50: 0.4819}[sigma], abs=0.001)


# The causal bank against constants that have seen the answer -------------------------------------------------------

SEEDS = (1, 2, 3)


def bank_runs(interval, sigma):
    values = {
        "scenario": "yu-wu", "samples": round(100 / interval), "interval": interval, "noise_std": sigma, "order": 4,
        "design": "critically-damped-bank",
    }  # fmt: skip
    results = [run_experiment(Experiment.from_dict({**values, "seed": seed})) for seed in SEEDS]
    (told,) = {tuple(result.experiment.parameters().items()) for result in results}
    assert dict(told) == {"members": 12, "memory": 4, "shortest": 1.2 * interval, "longest": 20}
    return results


def fading_memory(xi):
    return 1 - xi**3, 1.5 * (1 - xi) ** 2 * (1 + xi), (1 - xi) ** 3


def best_constant(results):
    """Least estimation RMSE of one set of constant alpha-beta-gamma gains over all of these runs.

    Nelder and Mead from the best fading-memory filter; all runs are filtered at once, as axes beside each other.
    """
    truth, seen = (
        np.concatenate(columns, axis=1)
        for columns in zip(
            *((result.truth.positions, result.measurements.positions) for result in results), strict=True
        )
    )
    measurements = Measurements(results[0].truth.times, seen, results[0].experiment.interval)
    before = np.concatenate([known_state(result.experiment)[:, :3] for result in results])

    def error(logarithms):
        gains = Gains(tuple(np.exp(logarithms).tolist()))
        track = run_filter(measurements, gains, start="known", initial_state=before)
        if track.stopped_at is not None:
            return 1e9
        return np.sqrt(2 * np.mean((track.smoothed[:, :, 0] - truth) ** 2))

    first = min((np.log(fading_memory(1 - share)) for share in np.geomspace(0.005, 0.9, 12)), key=error)
    simplex = first + 0.3 * np.vstack((np.zeros(3), np.eye(3)))
    return minimize(
        error, first, method="Nelder-Mead", options={"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-5}
    ).fun


@pytest.mark.parametrize("interval", [0.2, 0.05, 0.0125])
@pytest.mark.parametrize("sigma", SIGMAS)
def test_the_bank_is_within_a_tenth_of_the_best_constant_gains(interval, sigma):
    """Of those tuned on the truth that it does not know, for these very runs."""
    results = bank_runs(interval, sigma)
    bank = np.sqrt(fmean(result.metrics.estimation_rmse**2 for result in results))
    assert 1 < bank / best_constant(results) < 1.1
