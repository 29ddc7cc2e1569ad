"""Al-Wagih & Abdulla: the pushed target, and how the five methods fare on ten sets of noise.

The paper's target is not printed: rankings and proportions are what can be compared.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tracker_core import SCENARIOS, run_experiment
from tracker_core.papers import papers

METHODS = ["m1", "m2", "m3", "m4", "m5", "m5-causal"]
KINDS = ["white", "coloured"]
SEEDS = range(1, 6)
SETS = [pytest.param(kind, seed, id=f"{kind}-{seed}") for kind in KINDS for seed in SEEDS]
X, Y = 0, 1


@cache
def error(method, kind, seed):
    """Tracking RMSE of both axes."""
    (run,) = [run for run in papers()["alwagih"].runs if run.name == f"{method}-{kind}"]
    result = run_experiment(replace(run.experiment, seed=seed))
    return np.array([metrics.tracking_rmse for metrics in result.axis_metrics()])


@cache
def mean(method):
    """Over the ten sets."""
    return np.mean([error(method, kind, seed) for kind in KINDS for seed in SEEDS], axis=0)


# The ten sets ------------------------------------------------------------------------------------------------------


def test_the_runs_are_six_methods_on_two_noises():
    assert [run.name for run in papers()["alwagih"].runs] == [f"{name}-{kind}" for kind in KINDS for name in METHODS]


def test_the_first_set_is_what_the_run_shows():
    for run in papers()["alwagih"].runs:
        assert run.experiment.seed == 1


def test_a_fixed_alpha_loses_the_target_that_is_pushed():
    """Its error in y is about four times that of the growing memory; the paper's is about five times."""
    ratio = mean("m1")[Y] / mean("m2")[Y]
    assert 3 < ratio < 6
    assert ratio == pytest.approx(3.825, abs=0.005)


@pytest.mark.parametrize(("kind", "seed"), SETS)
@pytest.mark.parametrize("method", ["m2", "m3"])
def test_a_growing_memory_follows_the_push(method, kind, seed):
    assert error(method, kind, seed)[Y] < 0.35 * error("m1", kind, seed)[Y]


@pytest.mark.parametrize(("kind", "seed"), SETS)
def test_the_combination_does_not_help_in_y(kind, seed):
    """The weight that is searched is zero there: M3 is M2."""
    assert error("m3", kind, seed)[Y] == error("m2", kind, seed)[Y]


@pytest.mark.parametrize(("kind", "seed"), SETS)
def test_the_window_beats_the_alpha_that_it_began_with(kind, seed):
    assert (error("m4", kind, seed) < error("m1", kind, seed)).all()


@pytest.mark.parametrize(("kind", "seed"), SETS)
def test_hindsight_is_far_below_a_fixed_alpha(kind, seed):
    x, y = error("m5", kind, seed) / error("m1", kind, seed)
    assert x < 0.75
    assert y < 0.1


@pytest.mark.parametrize("kind", KINDS)
def test_hindsight_is_far_below_a_fixed_alpha_in_the_mean(kind):
    ratios = [np.mean([error(name, kind, seed) for seed in SEEDS], axis=0) for name in ("m5", "m1")]
    x, y = ratios[0] / ratios[1]
    assert x < 0.5
    assert y < 0.06


@pytest.mark.parametrize("method", ["m1", "m2", "m3", "m4"])
def test_hindsight_is_about_half_of_every_other_or_less(method):
    x, y = mean("m5") / mean(method)
    assert x < 0.53
    assert y < 0.21


def test_what_is_left_of_it_without_the_future_is_still_the_best():
    """In the mean over the ten sets; only hindsight comes near."""
    causal = mean("m5-causal")
    for method in ("m1", "m2", "m3", "m4"):
        assert (causal < 0.55 * mean(method)).all()
    assert 1.0 < (causal / mean("m5"))[Y] < 1.2


@pytest.mark.parametrize("seed", SEEDS)
def test_hindsight_chases_white_noise(seed):
    """Where little moves, the prediction nearest the measurement is not the one nearest the truth."""
    assert error("m5-causal", "white", seed)[X] < 0.95 * error("m5", "white", seed)[X]


@pytest.mark.parametrize("seed", SEEDS)
def test_noise_with_a_memory_can_be_chased(seed):
    """The next error resembles this one: there hindsight is ahead in both axes."""
    assert (error("m5-causal", "coloured", seed) > error("m5", "coloured", seed)).all()


@pytest.mark.parametrize("kind", KINDS)
def test_a_quick_m4_may_beat_hindsight_where_nothing_moves(kind):
    """x of the third set: the order of the methods is one in the mean, not in every set."""
    ratio = error("m4", kind, 3)[X] / error("m5", kind, 3)[X]
    assert ratio == pytest.approx({"white": 1.130, "coloured": 0.927}[kind], abs=0.001)


# The target --------------------------------------------------------------------------------------------------------


def states(*times):
    return SCENARIOS["alwagih"].truth(np.array(times)).states


def test_x_weaves_slowly_about_a_constant_velocity():
    times = np.linspace(0, 200, 2001)
    x = states(*times)[:, 0]
    assert np.abs(x[:, 0] - 150 * times).max() == pytest.approx(60, rel=1e-4)
    assert np.abs(x[:, 1] / 150 - 1).max() < 0.03
    assert np.abs(x[:, 2]).max() < 0.2
    again = states(*(times + 115))[:, 0]
    assert again[:, 0] - x[:, 0] == pytest.approx(150 * 115, rel=1e-12)
    assert again[:, 1:] == pytest.approx(x[:, 1:], rel=0, abs=1e-9)


def test_y_is_pushed_and_pulled_back():
    """Textbook uniform acceleration: 12 s at 12, 4 s of coasting, 17 s at -0.9, then coasting."""
    y = states(0, 6, 12, 16, 33, 133)[:, 1, :3]
    assert y[:, 2].tolist() == [12, 12, 0, -0.9, 0, 0]
    assert y[:, 1] == pytest.approx([0, 72, 144, 144, 128.7, 128.7], rel=1e-14)
    at_16 = 6 * 144 + 4 * 144
    at_33 = at_16 + 17 * 144 - 0.45 * 17**2
    assert y[:, 0] == pytest.approx([0, 6 * 36, 6 * 144, at_16, at_33, at_33 + 12_870], rel=1e-14)


@pytest.mark.parametrize("joint", [0.0, 12.0, 16.0, 33.0])
def test_position_and_velocity_are_continuous(joint):
    before, at, after = states(joint - 1e-9, joint, joint + 1e-9)[:, :, :2]
    for beside in (before, after):
        assert beside[:, 0] == pytest.approx(at[:, 0], rel=0, abs=1e-6)
        assert beside[:, 1] == pytest.approx(at[:, 1], rel=0, abs=1e-7)


@pytest.mark.parametrize("derivative", range(4))
def test_every_state_is_the_derivative_of_the_one_before(derivative):
    times = np.linspace(0.5, 199.5, 399)
    times = times[(np.abs(times[:, None] - [0, 12, 16, 33]) > 0.1).all(axis=1)]
    step = 0.01
    before, at, after = (states(*(times + shift)) for shift in (-step, 0, step))
    slope = (after - before)[:, :, derivative] / (2 * step)
    scale = np.abs(at[:, :, derivative]).max() * 1e-16 / step + np.abs(at[:, :, derivative + 1]).max() * 1e-6
    assert np.abs(slope - at[:, :, derivative + 1]).max() <= 10 * scale + 1e-12
