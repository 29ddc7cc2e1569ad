"""Many gain sets over the same measurements: their errors, without their tracks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker_core.checks import InputError
from tracker_core.filters import STOP_LIMIT, set_up
from tracker_core.types import ORDERS, FloatArray, Measurements, Truth

KINDS = ("tracking", "estimation", "innovation")


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors of one kind for every gain set, shape (m,) each, m; NaN where the run stopped or nothing is defined.

    Attributes:
        total: the errors added up.
        rmse: root mean square.
        max: the greatest.
        l2: Euclidean norm over the number of errors.
    """

    total: FloatArray
    rmse: FloatArray
    max: FloatArray
    l2: FloatArray


def batch_errors(
    measurements: Measurements,
    truth: Truth,
    gains: FloatArray,
    *,
    start: str = "two-point",
    initial_state: FloatArray | None = None,
    limit: float = STOP_LIMIT,
) -> dict[str, Errors]:
    """The errors that `metrics.measure` finds in the track of every gain set, all axes jointly.

    Args:
        measurements: at a constant interval; the others as for `filters.run_filter`.
        truth: what was there.
        gains: shape (m, order), normalised.
        start, initial_state, limit: as for `filters.run_filter`.

    Returns:
        Errors by kind, of KINDS.

    Raises:
        InputError: as `filters.run_filter`; and for gains of another shape, or a varying interval.
    """
    g = np.ascontiguousarray(gains, dtype=np.float64)
    if g.ndim != 2 or g.shape[1] not in ORDERS:
        raise InputError("gains", "must have shape (m, 2), (m, 3) or (m, 4)", g.shape)
    if measurements.interval is None:
        raise InputError("interval", "must be constant", None)
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    setting = set_up(measurements, g.shape[1], start=start, initial_state=initial_state, limit=limit)
    true = np.ascontiguousarray(truth.positions.T)
    z = np.ascontiguousarray(setting.z.T)
    sums = np.empty((len(g), 3, 4))
    # What a growing memory comes to depends on the gains; every other start is the same for all.
    for rows in range(len(g)) if start == "expanding" else (slice(None),):
        some = np.atleast_2d(g[rows])
        heads, states, begins = np.zeros((3, len(setting.z))), np.empty((len(z), g.shape[1])), np.empty(len(z), int)
        for axis in range(len(z)):
            predicted, smoothed = (np.full((len(setting.z), g.shape[1]), np.nan) for _ in range(2))
            states[axis], begins[axis] = setting.begin(axis, some[0], predicted, smoothed)
            head = slice(0, begins[axis])
            heads[0, head] += (predicted[head, 0] - true[axis, head]) ** 2
            heads[1, head] += (smoothed[head, 0] - true[axis, head]) ** 2
            heads[2, head] += (z[axis, head] - predicted[head, 0]) ** 2
        part = np.empty((len(some), 3, 4))
        kernels.batch_errors(z, true, float(measurements.interval), some, states, begins, heads, setting.limit, part)
        sums[rows] = part
    with np.errstate(invalid="ignore", divide="ignore"):
        return {kind: _errors(sums[:, index]) for index, kind in enumerate(KINDS)}


def _errors(sums: FloatArray) -> Errors:
    total, squares, greatest, count = sums.T
    none = count == 0
    return Errors(
        *(np.where(none, np.nan, values) for values in (total, np.sqrt(squares / count), greatest)),
        np.where(none, np.nan, np.sqrt(squares) / count),
    )
