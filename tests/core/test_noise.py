"""Measurement noise: its statistics, and that it is the same everywhere."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from tracker_core import InputError
from tracker_core.noise import NOISES, coloured, signal_to_noise, std_from_snr, white

SAMPLES = 200_000
SEEDS = [0, 1, 2**53 - 1]
DRAWS = [noise.draw for noise in NOISES.values() if noise.draw]
every_draw = pytest.mark.parametrize("draw", DRAWS, ids=lambda draw: draw.__name__)


@pytest.mark.parametrize("name", NOISES)
def test_noise_is_described(name):
    assert NOISES[name].title
    assert (NOISES[name].draw is None) == (name in {"none", "recorded"})


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("std", [(10.0,), (0.5, 20.0)], ids=str)
def test_standard_deviation_and_mean(seed, std):
    """Within five standard errors of what is asked for."""
    noise = white((SAMPLES, 2), std, seed)
    expected = np.array(std * 2 if len(std) == 1 else std)
    assert np.abs(noise.std(axis=0) / expected - 1).max() <= 5 / np.sqrt(2 * SAMPLES)
    assert np.abs(noise.mean(axis=0) / expected).max() <= 5 / np.sqrt(SAMPLES)


@pytest.mark.parametrize("seed", SEEDS)
def test_is_gaussian(seed):
    assert stats.kstest(white((SAMPLES, 1), (1.0,), seed)[:, 0], "norm").pvalue > 1e-3


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("lag", [1, 2, 10])
def test_is_white(seed, lag):
    noise = white((SAMPLES, 1), (1.0,), seed)[:, 0]
    assert abs(np.mean(noise[lag:] * noise[:-lag])) <= 5 / np.sqrt(SAMPLES)


@pytest.mark.parametrize("seed", SEEDS)
def test_axes_are_uncorrelated(seed):
    correlations = np.corrcoef(white((SAMPLES, 3), (1.0,), seed).T)[np.triu_indices(3, 1)]
    assert np.abs(correlations).max() <= 5 / np.sqrt(SAMPLES)


@every_draw
@given(seed=st.integers(0, 2**53 - 1), axes=st.integers(1, 4), samples=st.integers(1, 50))
def test_same_seed_same_bits(draw, seed, axes, samples):
    assert np.array_equal(draw((samples, axes), (3.0,), seed, 0.7), draw((samples, axes), (3.0,), seed, 0.7))


@every_draw
@given(seed=st.integers(0, 2**53 - 1), samples=st.integers(1, 50))
def test_adding_an_axis_changes_no_other(draw, seed, samples):
    three = draw((samples, 3), (2.0,), seed, 0.7)
    for axes in (1, 2):
        assert np.array_equal(draw((samples, axes), (2.0,), seed, 0.7), three[:, :axes])


@every_draw
@given(seed=st.integers(0, 2**53 - 1), short=st.integers(1, 30), more=st.integers(0, 30))
def test_a_longer_run_begins_with_the_shorter_one(draw, seed, short, more):
    assert np.array_equal(draw((short + more, 2), (1.0,), seed, 0.7)[:short], draw((short, 2), (1.0,), seed, 0.7))


@every_draw
@given(seed=st.integers(0, 2**53 - 2))
def test_another_seed_draws_other_noise(draw, seed):
    assert not np.isin(draw((20, 2), (1.0,), seed, 0.7), draw((20, 2), (1.0,), seed + 1, 0.7)).any()


@every_draw
@given(seed=st.integers(0, 99), std=st.lists(st.floats(0, 1e9), min_size=3, max_size=3))
def test_standard_deviation_only_scales(draw, seed, std):
    unit = draw((10, 3), (1.0,), seed, 0.7)
    assert np.array_equal(draw((10, 3), tuple(std), seed, 0.7), unit * std)


def test_bits_are_these():
    """A link shared today must show the same noise tomorrow, on any machine."""
    drawn = white((2, 2), (1.0,), 1)
    assert [value.hex() for value in drawn.ravel().tolist()] == [
        "-0x1.47d7d484fd806p-1",
        "0x1.3e2ac4e525978p+1",
        "0x1.923302bda0bb5p-2",
        "0x1.1b1f2a2bf9a87p+0",
    ]


# Coloured noise ----------------------------------------------------------------------------------------------------

CORRELATIONS = st.floats(-1, 1, exclude_min=True, exclude_max=True)


@given(seed=st.integers(0, 2**53 - 1), correlation=CORRELATIONS, samples=st.integers(1, 60))
def test_coloured_noise_is_the_recursion(seed, correlation, samples):
    """Sample by sample, from the white noise of the same seed."""
    fresh = white((samples, 2), (1.0,), seed)
    expected = [fresh[0]]
    for k in range(1, samples):
        expected.append(correlation * expected[k - 1] + math.sqrt(1 - correlation**2) * fresh[k])
    # 1 - rho^2 as written here cancels near 1: its square root keeps half the digits, of what is then very small.
    found = coloured((samples, 2), (1.0,), seed, correlation)
    assert found == pytest.approx(np.array(expected), rel=1e-12, abs=1e-12 if abs(correlation) < 0.999 else 1e-6)


@given(seed=st.integers(0, 2**53 - 1), std=st.floats(1e-3, 1e3), axes=st.integers(1, 3))
def test_without_correlation_it_is_white_noise_to_the_bit(seed, std, axes):
    assert np.array_equal(coloured((40, axes), (std,), seed, 0.0), white((40, axes), (std,), seed))


@pytest.mark.parametrize("correlation", [-0.9, -0.3, 0.5, 0.99])
def test_its_standard_deviation_is_the_same_at_every_sample(correlation):
    """Over many axes, which are independent: at the first sample, soon after it and late."""
    axes = 4000
    noise = coloured((200, axes), (10.0,), 3, correlation)
    for sample in (0, 1, 5, 199):
        assert noise[sample].std() == pytest.approx(10, rel=4.5 / math.sqrt(2 * axes), abs=0)
        assert abs(noise[sample].mean()) <= 4.5 * 10 / math.sqrt(axes)


@pytest.mark.parametrize("correlation", [-0.9, -0.3, 0.5, 0.99])
@pytest.mark.parametrize("lag", [1, 2, 10])
def test_its_correlation_over_samples_is_a_power(correlation, lag):
    """rho^m over m samples; the variance of an estimated correlation by Bartlett's formula."""
    noise = coloured((SAMPLES, 1), (1.0,), 7, correlation)[:, 0]
    square = correlation**2
    variance = ((1 + square) * (1 - square**lag) / (1 - square) - 2 * lag * square**lag) / SAMPLES
    found = noise[lag:] @ noise[:-lag] / (noise @ noise)
    assert abs(found - correlation**lag) <= 5 * math.sqrt(variance)


@pytest.mark.parametrize("correlation", [-1, 1, 1.5, math.nan, math.inf, "much"])
def test_correlations_that_are_not_stationary_are_refused(correlation):
    with pytest.raises(InputError) as caught:
        coloured((5, 1), (1.0,), 1, correlation)
    assert caught.value.field == "correlation"


# Signal to noise ---------------------------------------------------------------------------------------------------


def test_power_is_the_mean_square_of_the_position_itself():
    """Not about its mean: (3, 4) m has the power 12.5 m^2, and a sine of amplitude 2 about 0 the power 2."""
    turn = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    assert std_from_snr(np.array([[3.0], [4.0]]), 2.0, decibel=False) == pytest.approx((2.5,), rel=1e-15, abs=0)
    wave = np.stack((2 * np.sin(turn), 10 + 2 * np.sin(turn)), axis=1)
    found = std_from_snr(wave, 0.5, decibel=False)
    assert found == pytest.approx((2, math.sqrt(204)), rel=1e-12, abs=0)


@given(decibel=st.floats(-100, 100))
def test_decibels_are_ten_times_the_logarithm(decibel):
    positions = np.array([[1.0, -700.0], [5.0, 20.0], [-3.0, 1e4]])
    expected = std_from_snr(positions, 10 ** (decibel / 10), decibel=False)
    assert std_from_snr(positions, decibel, decibel=True) == pytest.approx(expected, rel=1e-12, abs=0)


@given(
    snr=st.floats(1e-10, 1e10),
    positions=st.lists(st.tuples(st.floats(1e-3, 1e7), st.floats(-1e7, -1e-3)), min_size=1, max_size=20),
)
def test_ratio_and_standard_deviation_undo_each_other(snr, positions):
    found = signal_to_noise(np.array(positions), std_from_snr(np.array(positions), snr, decibel=False))
    assert found == pytest.approx((snr, snr), rel=1e-12, abs=0)


def test_a_drawn_noise_has_the_ratio_asked_for():
    """5 dB, measured on a long run."""
    truth = np.stack((np.linspace(-300, 700, SAMPLES), np.full(SAMPLES, 40.0)), axis=1)
    noise = white(truth.shape, std_from_snr(truth, 5.0, decibel=True), 1)
    ratio = (truth**2).sum(axis=0) / (noise**2).sum(axis=0)
    assert 10 * np.log10(ratio) == pytest.approx([5, 5], abs=0.1)


def test_one_standard_deviation_serves_all_axes():
    positions = np.array([[3.0, 1.0], [4.0, 1.0]])
    assert signal_to_noise(positions, (2.0,)) == signal_to_noise(positions, (2.0, 2.0)) == (3.125, 0.25)


def test_no_signal_and_no_noise():
    positions = np.array([[0.0, 5.0], [0.0, 5.0]])
    assert std_from_snr(positions, 4.0, decibel=False) == (0.0, 2.5)
    assert std_from_snr(positions, -20.0, decibel=True) == pytest.approx((0, 50), rel=1e-15, abs=0)
    assert signal_to_noise(positions, (0.0,)) == (math.inf, math.inf)
    assert signal_to_noise(positions, (1.0, 0.0)) == (0.0, math.inf)


@pytest.mark.parametrize(
    ("snr", "decibel"), [(0, False), (-3, False), (math.inf, False), (math.nan, True), (301, True), ("loud", True)]
)
def test_ratios_that_make_no_sense_are_refused(snr, decibel):
    with pytest.raises(InputError) as caught:
        std_from_snr(np.ones((3, 1)), snr, decibel=decibel)
    assert caught.value.field == "snr"


@pytest.mark.parametrize("std", [(), (1.0, 2.0, 3.0), (-1.0,), (1.0, math.nan)], ids=str)
def test_standard_deviations_that_do_not_fit_are_refused(std):
    with pytest.raises(InputError) as caught:
        signal_to_noise(np.ones((3, 2)), std)
    assert caught.value.field == "std"


@pytest.mark.parametrize(
    "draw", [white, lambda shape, std, seed: coloured(shape, std, seed, 0.5)], ids=["white", "coloured"]
)
@pytest.mark.parametrize("std", [(), (1.0, 2.0), (1.0, 2.0, 3.0, 4.0), (-1.0,), (math.nan,)], ids=str)
def test_there_is_one_deviation_or_one_for_each_axis(draw, std):
    with pytest.raises(InputError, match="^std must be"):
        draw((4, 3), std, 1)
