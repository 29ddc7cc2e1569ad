"""What a filter with constant gains does to its input: noise, powers of the time, every frequency; its lag.

With p(z) the characteristic polynomial and m the order, the error of the prediction is (z - 1)^m / p(z) times the
measured position, that of the smoothed position (1 - g0) times as much.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial, inf, isfinite

import numpy as np
from numpy.typing import NDArray

from tracker_core.checks import POSITIVE, Domain, InputError
from tracker_core.conventions import Gains
from tracker_core.filters import run_filter
from tracker_core.motion import transition
from tracker_core.poles import offset_polynomial
from tracker_core.stability import Number, is_stable, margins, stable
from tracker_core.types import ORDERS, FloatArray, Measurements

SETTLED = 0.02
"""A step response has settled when it stays this close to 1."""

HORIZON = 10_000
"""Samples after which a step response that is not close to 1 for good counts as never settling."""

SAMPLES = Domain(1, 200_000, whole=True)
FREQUENCY = Domain(0, 0.5)


@dataclass(frozen=True, slots=True)
class Variances:
    """Steady variances of the estimates under white measurement noise of unit variance and no motion.

    Attributes:
        smoothed: of every state after the measurement, shape (order,); derivative i in 1/s^(2i).
        predicted: of the predicted position.
    """

    smoothed: FloatArray
    predicted: float


@dataclass(frozen=True, slots=True)
class FrequencyResponse:
    """Complex ratio of estimated to measured position.

    Attributes:
        frequency: cycles per sample, shape (n,).
        predicted, smoothed: complex, shape (n,); the prediction is that for the sample itself.
    """

    frequency: FloatArray
    predicted: NDArray[np.complex128]
    smoothed: NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class TimeResponse:
    """Answer to a polynomial input from rest; interval 1.

    Attributes:
        input: the measured position, shape (n,).
        predicted, smoothed: what the filter makes of it, shape (n,); NaN after a stop.
    """

    input: FloatArray
    predicted: FloatArray
    smoothed: FloatArray


def error_change(gains: Gains) -> FloatArray:
    """N = (I - K H) F - I at T = 1: what the error of the smoothed state changes by, shape (order, order)."""
    f = transition(gains.order, 1.0)
    # The unit matrix goes first, so that gains far below 1 keep their digits.
    return f - np.eye(gains.order) - np.outer(gains.vector, f[0])


def steady_covariance(gains: Gains, q: FloatArray) -> FloatArray:
    """P = A P A' + Q with A = (I - K H) F, the Lyapunov equation, shape (order, order).

    Solved as N P + P N' + N P N' = -Q, where nothing cancels for slow filters.

    Args:
        gains: a stable set.
        q: symmetric, shape (order, order).

    Raises:
        InputError: for gains that are not stable, or by so little that rounding hides it.
    """
    require_stable(gains)
    n, unit = error_change(gains), np.eye(gains.order)
    rows, columns = np.triu_indices(gains.order)
    # Unknowns are the entries on and above the diagonal; P_ij appears twice off it.
    change = sum(np.einsum("ik,jl->ijkl", *pair) for pair in ((n, unit), (unit, n), (n, n)))[rows, columns]
    system = change[:, rows, columns] + np.where(rows == columns, 0.0, change[:, columns, rows])
    p = np.empty_like(n)
    try:
        p[rows, columns] = p[columns, rows] = np.linalg.solve(system, -q[rows, columns])
    except np.linalg.LinAlgError:
        p.fill(np.nan)
    variances = np.diag(p)
    if not (variances >= -1e-9 * variances.max()).all():
        raise InputError("gains", "must be stable by more than rounding", gains.values)
    # What is nothing may have come out below it.
    np.fill_diagonal(p, np.maximum(variances, 0.0))
    return p


def variance_reduction(gains: Gains, interval: float = 1.0) -> Variances:
    """Steady variances per unit measurement variance, from P = A P A' + K K'.

    Args:
        gains: a stable set of any order.
        interval: T, s.

    Raises:
        InputError: for gains that are not stable by more than rounding, or an interval that is not positive.
    """
    interval = POSITIVE.check("interval", interval)
    p = steady_covariance(gains, np.outer(gains.vector, gains.vector))
    f = transition(gains.order, 1.0)[0]
    return Variances(np.diag(p) / interval ** (2 * np.arange(gains.order)), float(f @ p @ f))


def noise_gain(vectors: FloatArray) -> FloatArray:
    """Variance of the smoothed position per unit measurement variance, in closed form.

    Args:
        vectors: normalised gains, shape (..., order).

    Returns:
        Shape (...); NaN where the gains are not stable.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(stable(vectors), smoothed_variance(*np.moveaxis(vectors, -1, 0)), np.nan)


def steady_variance(gains: Gains, formula: Callable[..., float]) -> float:
    """A variance of one filter, from a formula of its normalised gains such as `predicted_variance`.

    Raises:
        InputError: for gains that are not stable, or by so little that the variance is beyond all numbers.
    """
    require_stable(gains)
    try:
        value = formula(*gains.to("normalised").values)
    except ZeroDivisionError:
        value = inf
    if not isfinite(value):
        raise InputError("gains", "must be stable by more than rounding", gains.values)
    return value


def smoothed_variance(*g: Number) -> Number:
    """Of the smoothed position, per unit measurement variance: it mixes the prediction with a new measurement.

    Args:
        g: normalised gains of a stable filter, each a number or an array of one shape.
    """
    return (1 - g[0]) * (1 - g[0]) * predicted_variance(*g) + g[0] * g[0]


def predicted_variance(*g: Number) -> Number:
    """Of the predicted position, per unit measurement variance: arguments as for `smoothed_variance`.

    Each order's is the solution of the Lyapunov equation by Cramer's rule, F's first row from both sides; the
    denominators are what must be positive for stability. Of the first two orders every term is positive.
    """
    a, b = g[:2]
    if len(g) == 2:
        *_, wall = margins(*g)
        return (2 * a + b + 2 * b / a) / wall
    c = g[2]
    if len(g) == 3:
        _, _, _, wall, _, roof = margins(*g)
        return (2 * a + b + 2 * b * (2 * b + c) / roof) / wall
    d = g[3]
    *_, wall, roof = margins(*g)
    rest = 36 * b * c * (2 * b + c) - d * (72 * (a * b + c) - 6 * (a * d + b * c) + c * (3 * c + d))
    return (24 * a + 12 * b - d + 2 * rest / roof) / wall


def require_stable(gains: Gains) -> None:
    """Raise an InputError where gains are not stable."""
    if not is_stable(gains):
        raise InputError("gains", "must be stable", gains.values)


def lag_coefficient(vectors: FloatArray) -> FloatArray:
    """Steady lag of the smoothed position per T^m and unit m-th derivative: (1 - g0)/g_last.

    Args:
        vectors: normalised gains, shape (..., order); has a meaning where they are stable.

    Returns:
        Shape (...); infinite where the last gain is so small that the quotient overflows.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return (1 - vectors[..., 0]) / vectors[..., -1]


def frequency_response(gains: Gains, frequency: FloatArray) -> FrequencyResponse:
    """From the measured position to the predicted and to the smoothed one.

    Args:
        gains: any set; for unstable gains it is a ratio of polynomials and no response.
        frequency: cycles per sample, shape (n,), 0 to 0.5.

    Raises:
        InputError: for a frequency outside.
    """
    frequency = np.asarray(frequency, dtype=np.float64)
    for value in frequency[~((frequency >= FREQUENCY.low) & (frequency <= FREQUENCY.high))][:1]:
        FREQUENCY.check("frequency", value)
    polynomial = offset_polynomial(gains)
    # z - 1, and what is left of p(z) without its first term: nothing cancels at low frequencies.
    offset = 2j * np.sin(np.pi * frequency) * np.exp(1j * np.pi * frequency)
    rest, power = np.polyval(polynomial[1:], offset), offset**gains.order
    with np.errstate(divide="ignore", invalid="ignore"):
        return FrequencyResponse(frequency, rest / (rest + power), (rest + gains.vector[0] * power) / (rest + power))


def time_response(gains: Gains, degree: int, samples: int) -> TimeResponse:
    """The answer to k^degree/degree!, k = 0, 1, ...: a step, a ramp, a parabola, and so on.

    Args:
        gains: any set.
        degree: 0 to the order, at which the filter lags.
        samples: length of the response.

    Raises:
        InputError: for another degree or a length outside 1 to 200,000.
    """
    degree = int(Domain(0, gains.order, whole=True).check("degree", degree))
    k = np.arange(int(SAMPLES.check("samples", samples)), dtype=np.float64)
    position = k**degree / factorial(degree)
    track = run_filter(
        Measurements(k, position[:, None], 1.0), gains, start="known", initial_state=np.zeros((1, gains.order))
    )
    return TimeResponse(position, track.predicted[:, 0, 0], track.smoothed[:, 0, 0])


def step_figures(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Overshoot and settling time of the smoothed step response.

    Args:
        vectors: normalised gains, shape (..., order).

    Returns:
        How far the response passes 1 at most, and how many intervals after the step it stays within SETTLED of 1; each
        of shape (...), NaN and infinity where the gains are unstable or the response has not settled within HORIZON.
    """
    from tracker_core.kernels import step_response

    flat = np.zeros((int(np.prod(vectors.shape[:-1])), max(ORDERS)))
    flat[:, : vectors.shape[-1]] = np.reshape(vectors, (len(flat), -1))
    # A response on the border may die away while a pole on the circle is not excited.
    flat[~stable(vectors).ravel()] = np.nan
    overshoot, settling = np.empty(len(flat)), np.empty(len(flat))
    step_response(flat, SETTLED, HORIZON, overshoot, settling)
    return overshoot.reshape(vectors.shape[:-1]), settling.reshape(vectors.shape[:-1])
