"""M4 of Al-Wagih & Abdulla: against a loop that filters the last samples again."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker_core import Measurements
from tracker_core.adaptive import METHODS

METHOD = METHODS["moving-window"]


def series(seed, samples=60, axes=1):
    """Noise around a line that bends."""
    times = np.arange(samples)[:, None]
    draw = np.random.default_rng(seed)
    return np.maximum(times - samples / 2, 0) ** 2 + draw.normal(size=(samples, axes)) * 10 + 0.0 * times


def regular(positions, interval=1.0):
    return Measurements(np.arange(len(positions)) * interval, positions, interval)


def advance(x, v, z, t, alpha):
    """One sample: predicted position, innovation, and the state after it."""
    x = x + t * v
    e = z - x
    beta = alpha * alpha / (2 - alpha)
    return x, e, *((x, v) if math.isnan(e) else (x + alpha * e, v + beta / t * e))


def plain_search(z, t, fixed, window, step, levels, refinements, size):
    """From two points: the alpha in use at every sample, predicted positions, smoothed states."""
    states, alphas, predicted, alpha = {1: (z[1], (z[1] - z[0]) / t)}, [], [], fixed
    for i in range(2, len(z)):
        before, _, *state = advance(*states[i - 1], z[i], t, alpha)
        states[i] = tuple(state)
        alphas.append(alpha)
        predicted.append(before)
        first = i - window + 1
        # One innovation does not depend on alpha.
        if first < 3 or (first - 3) % step or sum(not math.isnan(measured) for measured in z[first : i + 1]) < 2:
            continue
        low, high, best = 0.0, 1.0, (math.inf, alpha)
        for _ in range(refinements + 1):
            width = (high - low) / levels
            for candidate in (low + width * k for k in range(1, levels + 1)):
                x, v = states[first - 1]
                cost = 0.0
                for j in range(first, i + 1):
                    _, e, x, v = advance(x, v, z[j], t, candidate)
                    cost += 0.0 if math.isnan(e) else size(e)
                best = min(best, (cost, candidate), key=lambda pair: pair[0])
            alpha = best[1]
            low, high = max(0.0, alpha - width), min(1.0, alpha + width)
    return alphas, predicted, [states[i] for i in range(2, len(z))]


@settings(max_examples=60)
@given(
    seed=st.integers(0, 999), window=st.integers(2, 15), step=st.integers(1, 9), levels=st.integers(1, 12),
    refinements=st.integers(0, 3), criterion=st.sampled_from(["mean-square", "mean-absolute"]),
    interval=st.sampled_from([0.25, 1.0, 3.0]), fixed=st.floats(0.01, 1), gap=st.booleans(),
)  # fmt: skip
def test_equals_a_loop_that_filters_the_window_again(
    seed, window, step, levels, refinements, criterion, interval, fixed, gap
):
    z = series(seed, 30)
    if gap:
        z[8:12] = np.nan
    selection = METHOD.run(
        regular(z, interval), fixed_alpha=fixed, window=window, step=step, levels=levels, refinements=refinements,
        criterion=criterion,
    )  # fmt: skip
    size = abs if criterion == "mean-absolute" else (lambda e: e * e)
    column = z[:, 0].tolist()
    alphas, predicted, states = plain_search(column, interval, fixed, window, step, levels, refinements, size)
    expected = np.where(np.isnan(z[2:, 0]), np.nan, alphas)
    assert np.array_equal(selection.gains[2:, 0, 0], expected, equal_nan=True)
    assert selection.gains[2:, 0, 1] == pytest.approx(expected**2 / (2 - expected), rel=1e-15, abs=0, nan_ok=True)
    scale = np.nanmax(np.abs(z))
    assert np.abs(selection.track.predicted[2:, 0, 0] - predicted).max() <= 1e-12 * scale
    assert np.abs(selection.track.smoothed[2:, 0] * [1, interval] - np.array(states) * [1, interval]).max() <= (
        1e-12 * scale
    )


@pytest.mark.parametrize("window", [5, 20])
def test_until_the_window_has_filled_it_is_m1(window):
    """The window lies within the recursion: the state before its first sample is the filter's own."""
    measurements = regular(series(4, axes=2))
    selection = METHOD.run(measurements, fixed_alpha=0.05, window=window)
    fixed = METHODS["benedict-bordner"].run(measurements, fixed_alpha=0.05)
    filled = 2 + window + 1
    assert np.array_equal(selection.track.smoothed[:filled], fixed.track.smoothed[:filled], equal_nan=True)
    assert (selection.gains[2:filled, :, 0] == 0.05).all()
    assert (selection.gains[filled, :, 0] != 0.05).all()


def test_the_gains_change_every_step_only():
    gains = METHOD.run(regular(series(4)), window=10, step=7, levels=200).gains[2:, 0, 0]
    changes = np.flatnonzero(np.diff(gains)) + 1
    assert len(changes) > 2
    assert set(changes % 7) == {(10 + 1) % 7}


def test_after_a_turn_alpha_is_larger():
    z = np.maximum(np.arange(80) - 40.0, 0)[:, None] * 30 + np.random.default_rng(1).normal(size=(80, 1))
    gains = METHOD.run(regular(z), window=10, fixed_alpha=0.5).gains[:, 0, 0]
    assert gains[43:50].min() > 0.95
    assert gains[20:41].max() < 0.6


@pytest.mark.parametrize("levels", [1, 20])
def test_equally_good_ones_give_the_smallest(levels):
    """Nothing moves: every alpha is right."""
    gains = METHOD.run(regular(np.zeros((30, 1))), window=5, levels=levels, refinements=3).gains[:, 0, 0]
    assert (gains[10:] == 1 / levels).all()


@pytest.mark.parametrize("gap", [3, 4, 5, 12])
def test_a_window_of_fewer_than_two_measurements_chooses_nothing(gap):
    """After a gap the filter goes on with the last alpha that measurements have chosen."""
    z = np.random.default_rng(3).normal(size=(60, 1)).cumsum(axis=0)
    z[30 : 30 + gap] = np.nan
    gains = METHOD.run(regular(z), window=5).gains[:, 0, 0]
    cut = z[:40].copy()
    # A measurement right after: the choice of sample 32, whose window still holds 28 and 29.
    cut[33] = 0.0
    assert gains[30 + gap] == METHOD.run(regular(cut), window=5).gains[33, 0, 0] > 0.05
