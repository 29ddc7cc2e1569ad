"""Singer's target: its exact discretisation, and that what is drawn has the statistics of the process."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss
from scipy.linalg import expm

from tracker_core import SCENARIOS, Experiment, InputError, run_experiment
from tracker_core.kernels import autoregress
from tracker_core.noise import white
from tracker_core.run import known_state
from tracker_core.scenarios.singer import POSITION, RMS_ACCELERATION, TAU, VELOCITY, covariance, transition

RATIOS = [5e-8, 1e-4, 1e-2, 0.3, 0.999, 1.0, 1.001, 3.0, 20.0, 200.0]
FLIGHTS = 1500


def process(ratio):
    """The matrix whose exponential holds F and Q (Van Loan 1978), for T = 1, tau = 1/ratio and an rms of 1."""
    m = np.zeros((6, 6))
    drift = np.array([[0, 1, 0], [0, 0, 1], [0, 0, -ratio]])
    m[:3, :3], m[3:, 3:], m[2, 5] = -drift, drift.T, 2 * ratio
    return m


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("interval", [0.01, 1.0, 5.0])
def test_discretisation_is_the_exponential_of_the_process(ratio, interval):
    """To 12 digits of every entry: exponentials of 250 digits, in the unit of time T."""
    with mp.workdps(250):
        e = mp.expm(mp.matrix(process(ratio).tolist()))
        f = e[3:, 3:].T
        q = f * e[:3, 3:]
        f, q = (np.array(m.tolist(), dtype=float) for m in (f, q))
    units = interval ** np.arange(2.0, -1, -1)
    tau = interval / ratio
    assert transition(interval, tau) == pytest.approx(f * np.outer(units, 1 / units), rel=1e-12, abs=1e-80)
    assert covariance(interval, tau, 3.0) == pytest.approx(9 * q * np.outer(units, units), rel=1e-12, abs=0)


@given(ratio=st.floats(1e-6, 2))
def test_discretisation_is_the_exponential_everywhere(ratio):
    e = expm(process(ratio))
    f = e[3:, 3:].T
    # The exponential is accurate as a whole: T/tau is as small as its smallest entries.
    assert transition(1.0, 1 / ratio) == pytest.approx(f, rel=1e-12, abs=1e-15)
    assert covariance(1.0, 1 / ratio, 1.0) == pytest.approx(f @ e[:3, 3:], rel=1e-11, abs=1e-15)


@given(ratio=st.floats(1e-7, 5e4))
def test_covariance_has_a_root_and_two_steps_are_one_long_step(ratio):
    q = covariance(ratio, 1.0, 1.0)
    assert np.array_equal(q, q.T)
    root = np.linalg.cholesky(q)
    scale = np.sqrt(np.outer(np.diag(q), np.diag(q)))
    assert (np.abs(root @ root.T - q) <= 1e-13 * scale).all()
    f = transition(ratio, 1.0)
    twice = covariance(2 * ratio, 1.0, 1.0)
    assert f @ q @ f.T + q == pytest.approx(twice, rel=1e-11, abs=0)


@given(decay=st.lists(st.floats(-1, 1), min_size=2, max_size=30), seed=st.integers(0, 99))
def test_autoregression_is_the_recursion(decay, seed):
    """With a factor for every sample, and with one for all."""
    fresh = np.random.default_rng(seed).standard_normal(len(decay))
    for factors in (decay, decay[:1]):
        found = fresh.copy()
        autoregress(np.array(factors), found)
        last = 0.0
        for k, value in enumerate(fresh):
            last = value + (factors[k % len(factors)] * last if k else 0)
            assert found[k] == pytest.approx(last, rel=1e-14, abs=1e-14)


# What is drawn -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def flights():
    """Position, velocity and acceleration of many flights, shape (2 FLIGHTS, n, 3), less the motion without manoeuvre.

    The grid is irregular on purpose, and ends at 60 s = 3 tau; both axes are taken as flights of one kind.
    """
    times = np.array([0.0, 0.5, 1.0, 4.0, 4.1, 11.0, 40.0, 60.0])
    states = np.stack([SCENARIOS["singer"].truth(times, seed).states[:, :, :3] for seed in range(FLIGHTS)])
    states[:, :, :, 0] -= np.array(POSITION) + times[:, None] * VELOCITY
    states[:, :, :, 1] -= VELOCITY
    return times, states.transpose(0, 2, 1, 3).reshape(2 * FLIGHTS, len(times), 3)


def standard_errors(found, expected):
    """By how many of its standard errors an estimated covariance of Gaussian numbers differs."""
    deviations = np.sqrt(np.diag(expected))
    error = np.sqrt((np.outer(deviations, deviations) ** 2 + expected**2) / (2 * FLIGHTS))
    return np.abs(found - expected) / error


def test_acceleration_is_stationary_and_forgets_exponentially(flights):
    """At every two times: sigma^2 exp(-|s - t|/tau)."""
    times, states = flights
    a = states[:, :, 2]
    expected = RMS_ACCELERATION**2 * np.exp(-np.abs(times[:, None] - times) / TAU)
    assert standard_errors(a.T @ a / len(a), expected).max() <= 4.5
    assert np.abs(a.mean(axis=0)).max() <= 4.5 * RMS_ACCELERATION / np.sqrt(len(a))


@pytest.mark.parametrize("row", [1, 3, 7])
def test_covariance_of_the_flight_is_the_integral_of_the_accelerations(flights, row):
    """cov(p), cov(p, v), cov(v), ...: double integrals over exp(-|s - u|/tau), done numerically; no F, no Q."""
    times, states = flights
    time = times[row]
    nodes, weights = leggauss(40)
    # The kernel has a kink at s = u: outer nodes over (0, t), inner ones over (0, s) and (s, t).
    outer, w_outer = (nodes + 1) * time / 2, weights * time / 2
    low, high = outer[:, None], time - outer[:, None]
    inner = np.concatenate(((nodes + 1) / 2 * low, low + (nodes + 1) / 2 * high), axis=1)
    w_inner = np.concatenate((weights / 2 * low, weights / 2 * high), axis=1)
    kernel = RMS_ACCELERATION**2 * np.exp(-np.abs(inner - low) / TAU) * w_inner * w_outer[:, None]
    p, p_inner = time - outer[:, None], time - inner
    last = RMS_ACCELERATION**2 * np.exp(-(time - outer) / TAU) * w_outer
    pp, pv, vv = (kernel * p * p_inner).sum(), (kernel * p).sum(), kernel.sum()
    pa, va = (last * (time - outer)).sum(), last.sum()
    expected = np.array([[pp, pv, pa], [pv, vv, va], [pa, va, RMS_ACCELERATION**2]])
    # The integrals are right: so says the discretisation, from an acceleration drawn at time zero.
    f, q = transition(time, TAU), covariance(time, TAU, RMS_ACCELERATION)
    assert f @ np.diag([0, 0, RMS_ACCELERATION**2]) @ f.T + q == pytest.approx(expected, rel=1e-10, abs=0)
    found = states[:, row].T @ states[:, row] / len(states)
    assert standard_errors(found, expected).max() <= 4.5


def test_axes_are_independent_and_not_the_measurement_noise():
    times = np.arange(2000.0) * 200
    # Samples ten time constants apart are as good as independent.
    a = SCENARIOS["singer"].truth(times, 4).states[:, :, 2] / RMS_ACCELERATION
    noise = white(a.shape, (1.0,), 4)
    correlations = np.corrcoef(np.concatenate((a, noise), axis=1).T)[np.triu_indices(4, 1)]
    assert np.abs(correlations).max() <= 4.5 / np.sqrt(len(a))


def test_there_is_no_jerk():
    states = SCENARIOS["singer"].truth(np.array([0.0, 1.0]), 1).states
    assert np.isnan(states[:, :, 3:]).all()


def test_times_that_repeat_stand_still():
    states = SCENARIOS["singer"].truth(np.array([0.0, 3.0, 3.0, 5.0]), 1).states
    assert np.array_equal(states[1], states[2], equal_nan=True)
    skipped = SCENARIOS["singer"].truth(np.array([3.0, 5.0]), 1).states
    assert np.array_equal(states[2:], skipped, equal_nan=True)


def test_times_that_decrease_are_refused():
    with pytest.raises(InputError) as caught:
        SCENARIOS["singer"].truth(np.array([0.0, 2.0, 1.0]), 1)
    assert caught.value.field == "times"


@pytest.mark.parametrize("interval", [1e-6, 1e6])
def test_the_ends_of_the_interval_are_flown(interval):
    states = SCENARIOS["singer"].truth(np.arange(1000) * interval, 2).states
    assert np.isfinite(states[:, :, :3]).all()


@pytest.mark.parametrize("order", [2, 3, 4])
def test_the_known_start_belongs_to_the_flight(order):
    """It is the state one interval before the first sample of the same seed, also for the filter that tracks jerk."""
    experiment = Experiment.from_dict(
        {"scenario": "singer", "start": "known", "order": order, "noise": "none", "seed": 8, "interval": 2.0}
    )
    result = run_experiment(experiment)
    first = result.truth.states[0]
    expected = first[:, 0] - 2 * first[:, 1] + 2 * first[:, 2]
    assert known_state(experiment)[:, 0] == pytest.approx(expected, rel=1e-14, abs=0)
    # Constant acceleration until the first sample: a filter that knows it predicts that sample without an error.
    if order > 2:
        assert result.track.innovation[0] == pytest.approx(0, abs=1e-8)
