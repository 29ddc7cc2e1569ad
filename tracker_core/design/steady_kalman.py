"""The steady-state Kalman gains of every order, from the tracking index by spectral factorisation.

With s = z + 1/z - 2 the optimal poles z satisfy
order 2: s^2 + L^2 (s + 4)/4 = 0; order 3: -s^3 + L^2 (s + 4)/4 = 0; order 4: s^4 + L^2 (s + 6)^2/36 = 0.
In u = 1 - z, s = u^2/(1 - u); the gains follow from the u without loss of digits near z = 1.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable
from math import cbrt, inf, sqrt

import numpy as np

from tracker_core.checks import InputError
from tracker_core.design.base import Design
from tracker_core.design.kalata import TRACKING_INDEX
from tracker_core.poles import gains_from_offsets
from tracker_core.types import ORDERS, FloatArray


def time_power(order: int) -> int:
    """p in L = sigma_w T^p/sigma_v: what disturbs the target is an acceleration (m/s^2), at order 4 a jerk (m/s^3)."""
    return 3 if order == 4 else 2


def tracking_index_of(order: int, process_std: float, sensor_std: float, interval: float) -> float:
    """L = sigma_w T^2/sigma_v, for order 4 sigma_w T^3/sigma_v.

    Args:
        order: of the filter.
        process_std: sigma_w, m/s^2, for order 4 m/s^3.
        sensor_std: sigma_v, m.
        interval: T, s.
    """
    return process_std * interval ** time_power(order) / sensor_std


def optimal_gains(order: int, tracking_index: float) -> FloatArray:
    """The steady-state Kalman gains, normalised, shape (order,).

    Args:
        order: 2, 3 or 4.
        tracking_index: L, in TRACKING_INDEX.

    Raises:
        InputError: for another order, or a tracking index outside.
    """
    return np.array(steady_gains(order, tracking_index))


def steady_gains(order: int, tracking_index: float) -> tuple[float, ...]:
    """The same as plain numbers."""
    if order not in ORDERS:
        raise InputError("order", "must be 2, 3 or 4", order)
    return gains_from_offsets(_offsets(order, TRACKING_INDEX.check("tracking_index", tracking_index)))


def prediction_variance(order: int, tracking_index: float) -> float:
    """Variance of the optimal prediction's error per measurement variance: alpha/(1 - alpha).

    Arguments and errors as for `optimal_gains`.
    """
    g = steady_gains(order, tracking_index)
    # L^2 = g_last^2/(1 - alpha) at every order: where alpha is near 1 the last gain has digits that 1 - alpha lost.
    return g[0] * (tracking_index / g[-1]) ** 2


def _offsets(order: int, index: float) -> list[complex]:
    """u = 1 - z of every optimal pole."""
    # Pairs of s and s + 4; where s is close to -4, the second follows from the equation with all its digits.
    if order == 2:
        pairs = [(s, -((2 * s / index) ** 2)) for s in _quadratic(index**2 / 4, index**2)]
    elif order == 3:
        pairs = [(s, s * (2 * s / index) ** 2) for s in _cubic(index)]
    else:
        # s^2 = +-i L (s + 6)/6
        step = 1j * index / 6
        pairs = [(s, s + 4) for s in (*_quadratic(-step, -6 * step), *_quadratic(step, 6 * step))]
    return [_stable_offset(*pair) for pair in pairs]


def _quadratic(b: complex, c: complex) -> list[complex]:
    """Both roots of s^2 + b s + c = 0."""
    root = cmath.sqrt(b * b - 4 * c)
    larger = -(b + root if abs(b + root) >= abs(b - root) else b - root) / 2
    return [larger, c / larger]


def _cubic(tracking_index: float) -> list[complex]:
    """The roots of s^3 = L^2 (s + 4)/4, by way of t = s/L^(2/3), so that none is lost where L is small or large.

    t^3 = r t + 1, r = L^(2/3)/4, has one positive root, at most 1 + sqrt(r). From there Newton's steps go down to it;
    they end where rounding keeps them from going on. The product of all roots is 1 and their sum 0, which leaves a
    quadratic for the other two.
    """
    scale = cbrt(tracking_index) ** 2
    ratio = scale / 4
    root, lower = inf, 1 + sqrt(ratio)
    while lower < root:
        root, lower = lower, (2 * lower**3 + 1) / (3 * lower**2 - ratio)
    return [scale * t for t in (root, *_quadratic(root, 1 / root))]


def _stable_offset(s: complex, s_plus_4: complex) -> complex:
    """u = 1 - z of the root of z^2 - (s + 2) z + 1 = 0 inside the unit circle."""
    root = cmath.sqrt(s * s_plus_4)
    # u^2 + s u - s = 0 has the roots u and u/(u - 1); the smaller magnitude of 1 - u is the stable one.
    return min(2 * s / (s + root), 2 * s / (s - root), key=lambda u: abs(1 - u))


def _formula(order: int) -> Callable[[float], tuple[float, ...]]:
    return lambda tracking_index: steady_gains(order, tracking_index)


DESIGN = Design(
    name="steady-kalman",
    title="Steady Kalman",
    parameters={"tracking_index": TRACKING_INDEX},
    formulas={order: _formula(order) for order in ORDERS},
    formula={
        2: "poles from s² + Λ²(s + 4)/4 = 0,  s = z + 1/z − 2",
        3: "poles from s³ = Λ²(s + 4)/4,  s = z + 1/z − 2",
        4: "poles from s² = ±iΛ(s + 6)/6,  s = z + 1/z − 2",
    },
    source="Spectral factorisation of the random-acceleration and random-jerk models; equals Kalata 1984 at order 2 "
    "and Gray & Murray 1993 at order 3",
    remark="The least error variance for Λ = σ_w T²/σ_v (order 4: σ_w T³/σ_v).",
)
