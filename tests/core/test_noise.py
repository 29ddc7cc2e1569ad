"""Measurement noise: its statistics, and that it is the same everywhere."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from tracker_core.noise import NOISES, white

SAMPLES = 200_000
SEEDS = [0, 1, 2**53 - 1]


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


@given(seed=st.integers(0, 2**53 - 1), axes=st.integers(1, 4), samples=st.integers(1, 50))
def test_same_seed_same_bits(seed, axes, samples):
    assert np.array_equal(white((samples, axes), (3.0,), seed), white((samples, axes), (3.0,), seed))


@given(seed=st.integers(0, 2**53 - 1), samples=st.integers(1, 50))
def test_adding_an_axis_changes_no_other(seed, samples):
    three = white((samples, 3), (2.0,), seed)
    for axes in (1, 2):
        assert np.array_equal(white((samples, axes), (2.0,), seed), three[:, :axes])


@given(seed=st.integers(0, 2**53 - 1), short=st.integers(1, 30), more=st.integers(0, 30))
def test_a_longer_run_begins_with_the_shorter_one(seed, short, more):
    assert np.array_equal(white((short + more, 2), (1.0,), seed)[:short], white((short, 2), (1.0,), seed))


@given(seed=st.integers(0, 2**53 - 2))
def test_another_seed_draws_other_noise(seed):
    assert not np.isin(white((20, 2), (1.0,), seed), white((20, 2), (1.0,), seed + 1)).any()


@given(seed=st.integers(0, 99), std=st.lists(st.floats(0, 1e9), min_size=3, max_size=3))
def test_standard_deviation_only_scales(seed, std):
    unit = white((10, 3), (1.0,), seed)
    assert np.array_equal(white((10, 3), tuple(std), seed), unit * std)


def test_bits_are_these():
    """A link shared today must show the same noise tomorrow, on any machine."""
    drawn = white((2, 2), (1.0,), 1)
    assert [value.hex() for value in drawn.ravel().tolist()] == [
        "-0x1.47d7d484fd806p-1",
        "0x1.3e2ac4e525978p+1",
        "0x1.923302bda0bb5p-2",
        "0x1.1b1f2a2bf9a87p+0",
    ]
