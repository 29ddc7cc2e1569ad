"""Measurement noise. Every axis draws from a stream of its own, so adding an axis changes no other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

from tracker_core.checks import POSITIVE, Domain, InputError
from tracker_core.types import FloatArray

CORRELATION = Domain(-1, 1, low_open=True, high_open=True)
"""Correlations of one error with the next for which the noise is stationary."""

DECIBEL = Domain(-300, 300)
"""Signal-to-noise ratios in decibel, far wider than any sensor's and far from the end of the numbers."""


def white(shape: tuple[int, int], std: tuple[float, ...], seed: int, _correlation: float = 0.0) -> FloatArray:
    """Zero-mean white Gaussian noise.

    Args:
        shape: (n_samples, n_axes).
        std: standard deviation per axis, m; one number serves all axes.
        seed: whole number >= 0. The same seed gives the same bits, and a longer run begins with the shorter one.

    Returns:
        Array of that shape, m.

    Raises:
        InputError: for standard deviations that are negative, or neither one nor as many as there are axes.
    """
    samples, axes = shape
    per_axis = _each(std, axes)
    columns = [per_axis[axis] * _unit(samples, axis, seed) for axis in range(axes)]
    return np.stack(columns, axis=1)


def coloured(shape: tuple[int, int], std: tuple[float, ...], seed: int, correlation: float) -> FloatArray:
    """Zero-mean Gaussian noise in which every error remembers the one before: a stationary AR(1) process.

    n_0 = e_0, n_k = rho n_(k-1) + sqrt(1 - rho^2) e_k, with e the draws of `white`; rho = 0 gives its bits. The
    standard deviation is the same at every sample, and the correlation over m samples is rho^m (Box & Jenkins,
    Time Series Analysis, section 3.2).

    Args:
        shape: (n_samples, n_axes).
        std: standard deviation per axis, m; one number serves all axes.
        seed: as for `white`; a longer run begins with the shorter one here as well.
        correlation: rho, between -1 and 1; of all axes.

    Returns:
        Array of that shape, m.

    Raises:
        InputError: for a correlation outside CORRELATION, and as for `white`.
    """
    rho = CORRELATION.check("correlation", correlation)
    from tracker_core import kernels  # compiled code is loaded when the first such noise is drawn

    samples, axes = shape
    per_axis = _each(std, axes)
    columns = []
    for axis in range(axes):
        series = _unit(samples, axis, seed)
        series[1:] *= sqrt((1 - rho) * (1 + rho))
        kernels.autoregress(np.array([rho]), series)
        columns.append(per_axis[axis] * series)
    return np.stack(columns, axis=1)


def _unit(samples: int, axis: int, seed: int) -> FloatArray:
    """White noise of standard deviation 1 from the stream of this axis, shape (samples,)."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(axis,))).standard_normal(samples)


def std_from_snr(positions: FloatArray, snr: float, *, decibel: bool) -> tuple[float, ...]:
    """Standard deviation of the noise that gives every axis the same signal-to-noise ratio: sqrt(P/SNR).

    The signal power P is the mean square of the true position itself, not of its deviation from the mean: it grows
    with the distance of the target from the origin.

    Args:
        positions: true positions, shape (n_samples, n_axes), m.
        snr: signal-to-noise ratio: of powers, or 10 log10 of that.
        decibel: whether `snr` is in decibel.

    Returns:
        One standard deviation per axis, m; 0 for an axis that has no power.

    Raises:
        InputError: for a ratio that is not > 0, or decibels outside DECIBEL.
    """
    value = (DECIBEL if decibel else POSITIVE).check("snr", snr)
    amplitudes = 10 ** (value / 20) if decibel else sqrt(value)
    return tuple(sqrt(power) / amplitudes for power in _powers(positions))


def signal_to_noise(positions: FloatArray, std: tuple[float, ...]) -> tuple[float, ...]:
    """Signal-to-noise ratio of every axis: the inverse of `std_from_snr`, P/sigma^2 with the same signal power P.

    Args:
        positions: true positions, shape (n_samples, n_axes), m.
        std: standard deviation per axis, m; one number serves all axes.

    Returns:
        One ratio of powers per axis; infinite where there is no noise.

    Raises:
        InputError: for standard deviations that are negative, or neither one nor as many as there are axes.
    """
    powers = _powers(positions)
    per_axis = _each(std, len(powers))
    return tuple(power / sigma / sigma if sigma else inf for power, sigma in zip(powers, per_axis, strict=True))


_STD = Domain(low=0)


def _each(std: tuple[float, ...], axes: int) -> list[float]:
    """The standard deviation of every axis."""
    if len(std) not in (1, axes):
        raise InputError("std", f"must be one number, or {axes}", std)
    return [_STD.check("std", sigma) for sigma in (tuple(std) * axes if len(std) == 1 else std)]


def _powers(positions: FloatArray) -> list[float]:
    """Mean square of the position of every axis, m^2."""
    return [float(power) for power in np.mean(np.square(positions), axis=0)]


@dataclass(frozen=True, slots=True)
class Noise:
    """One kind of measurement noise.

    Attributes:
        title: for menus.
        draw: the function that draws it from shape, standard deviations, seed and correlation; None where nothing
            is drawn.
    """

    title: str
    draw: Callable[[tuple[int, int], tuple[float, ...], int, float], FloatArray] | None


NOISES: dict[str, Noise] = {
    "white": Noise("White Gaussian", white),
    "coloured": Noise("Coloured Gaussian, AR(1)", coloured),
    "none": Noise("None", None),
    "recorded": Noise("As recorded", None),
}
