"""The best there is: steady-state Kalman gains for a tracking index, and how far other gains are from them.

The model: the highest derivative that the filter tracks is disturbed by white noise w, held over the interval
(order 2: acceleration, G = [T^2/2, T]) or as an increment (order 3: of the acceleration, G = [T^2/2, T, 1]; order 4: of
the jerk, G = [T^3/6, T^2/2, T, 1]). The tracking index is L = sigma_w T^2/sigma_v, for order 4 sigma_w T^3/sigma_v.

The optimal poles follow from spectral factorisation. With s = z + 1/z - 2 they satisfy
order 2: s^2 + L^2 (s + 4)/4 = 0; order 3: -s^3 + L^2 (s + 4)/4 = 0; order 4: s^4 + L^2 (s + 6)^2/36 = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from math import exp, log

import numpy as np

from tracker_core.checks import POSITIVE, Domain, InputError
from tracker_core.conventions import Gains
from tracker_core.design.kalata import TRACKING_INDEX
from tracker_core.design.steady_kalman import optimal_gains, prediction_variance, steady_gains
from tracker_core.responses import noise_gain, predicted_variance, smoothed_variance, steady_variance
from tracker_core.stability import margins
from tracker_core.types import FloatArray

SMOOTHEST, MOST_RESPONSIVE = 1e-4, 100.0
"""Ends of the smooth-responsive path, tracking indices."""

ORDER = Domain(2, 4, whole=True)
NUMBER = Domain()

_ROUNDS = 3

__all__ = [
    "MOST_RESPONSIVE",
    "SMOOTHEST",
    "Distance",
    "distance_from_optimal",
    "index_of_noise_gain",
    "optimal_gains",
    "path_index",
    "path_share",
    "process_input",
]


@dataclass(frozen=True, slots=True)
class Distance:
    """How far gains are from optimal.

    Attributes:
        percent: by how much the variance of their position error exceeds that of the best gains, at least.
        tracking_index: of the model on which it exceeds it least.
    """

    percent: float
    tracking_index: float


def process_input(order: int) -> FloatArray:
    """G at T = 1: what a unit of process noise adds to the state, shape (order,).

    Raises:
        InputError: for an order other than 2, 3 or 4.
    """
    return {
        2: np.array([1 / 2, 1.0]), 3: np.array([1 / 2, 1.0, 1.0]), 4: np.array([1 / 6, 1 / 2, 1.0, 1.0])
    }[int(ORDER.check("order", order))]  # fmt: skip


def process_gain(gains: Gains) -> float:
    """Variance of the predicted position's error per unit variance of the process noise (T = 1).

    That error is (z + 1)/(2 p(z)) times the noise for orders 2 and 3, (z^2 + 4 z + 1)/(6 p(z)) for order 4, p being the
    characteristic polynomial; the integral of its square over the unit circle, in closed form.

    Raises:
        InputError: for gains that are not stable by more than rounding.
    """
    return steady_variance(gains, _process_gain)


def _process_gain(*g: float) -> float:
    a, b = g[:2]
    if len(g) == 2:
        return 1 / (2 * a * b)
    c, lower_roof = g[2], margins(*g[:3])[-1]
    if len(g) == 3:
        return a / (c * lower_roof)
    d = g[3]
    *_, wall, roof = margins(*g)
    return ((6 * lower_roof + a * d) / d + (2 * c * (2 - a) - a * d) / wall) / (4 * roof)


@lru_cache(maxsize=64)
def distance_from_optimal(gains: Gains) -> Distance:
    """By how much gains miss the optimum, on the model that suits them best.

    On the model with tracking index L the error of the predicted position has the variance V + L^2 W per measurement
    variance, V and W being the gains' own; that of the optimal filter is alpha/(1 - alpha). The least ratio over all L
    in TRACKING_INDEX is sought. The prediction is compared, because a filter with alpha = 1 smooths nothing, whatever
    its other gains are.

    Raises:
        InputError: for gains that are not stable by more than rounding.
    """
    noise, process = steady_variance(gains, predicted_variance), process_gain(gains)
    logs, squares, least = _least(gains.order)
    with np.errstate(over="ignore"):
        ratios = (noise + squares * process) / least
    best = int(np.argmin(ratios))
    at = float(logs[best])

    def ratio(at: float) -> float:
        index = _index(at)
        return (noise + index**2 * process) / prediction_variance(gains.order, index)

    # The lowest point of the parabola through three, twice: the second time from very near.
    if 0 < best < len(logs) - 1:
        step = float(logs[1] - logs[0])
        at += step * _lowest(*ratios[best - 1 : best + 2].tolist())
        step /= 20
        at += step * _lowest(*(ratio(at + shift) for shift in (-step, 0.0, step)))
    return Distance(max(0.0, 100 * (ratio(at) - 1)), _index(at))


def _lowest(below: float, here: float, above: float) -> float:
    """Where the parabola through values at -1, 0 and 1 is lowest, within those ends; 0 where it has no lowest point."""
    bend = below - 2 * here + above
    return min(1.0, max(-1.0, (below - above) / (2 * bend))) if bend > 0 else 0.0


def _index(logarithm: float) -> float:
    """The tracking index with a logarithm, within its domain."""
    return min(TRACKING_INDEX.high, max(TRACKING_INDEX.low, exp(logarithm)))


@cache
def _least(order: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Logarithms of tracking indices, the squares of these, and the least variance of the prediction for each."""
    logs = np.linspace(log(TRACKING_INDEX.low), log(TRACKING_INDEX.high), 1001)
    return logs, np.exp(2 * logs), np.array([prediction_variance(order, _index(at)) for at in logs.tolist()])


def index_of_noise_gain(order: int, value: float) -> float:
    """The tracking index on the path whose optimal filter has that noise gain; the nearer end where there is none.

    Raises:
        InputError: for a noise gain that is not a number.
    """
    if value != value:
        raise InputError("value", "must be a number", value)
    logs, gains = _noise_gains(order)
    cell = int(np.searchsorted(gains, value))
    if cell in {0, len(gains)}:
        return SMOOTHEST if cell == 0 else MOST_RESPONSIVE
    slope = float(logs[cell] - logs[cell - 1]) / log(gains[cell] / gains[cell - 1])
    at = float(logs[cell]) + slope * log(value / gains[cell])
    # Over so short a step the logarithm is all but straight: every round gains two digits or more.
    for _ in range(_ROUNDS):
        at += slope * log(value / smoothed_variance(*steady_gains(order, exp(at))))
    return exp(at)


@cache
def _noise_gains(order: int) -> tuple[FloatArray, FloatArray]:
    """Logarithms of tracking indices along the path, and the noise gain of the optimal filter there, increasing."""
    logs = np.linspace(log(SMOOTHEST), log(MOST_RESPONSIVE), 1001)
    return logs, noise_gain(np.array([steady_gains(order, exp(at)) for at in logs.tolist()]))


def path_index(share: float) -> float:
    """The tracking index at a share, 0 (smooth) to 1 (responsive), of the path; beyond them the end itself."""
    share = min(1.0, max(0.0, NUMBER.check("share", share)))
    return SMOOTHEST ** (1 - share) * MOST_RESPONSIVE**share


def path_share(tracking_index: float) -> float:
    """How far along the path a tracking index stands, 0 to 1."""
    index = POSITIVE.check("tracking_index", tracking_index)
    return min(1.0, max(0.0, log(index / SMOOTHEST) / log(MOST_RESPONSIVE / SMOOTHEST)))
