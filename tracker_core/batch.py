"""Many gain sets, many runs: the errors of every filter in every run, without the tracks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tracker_core.checks import POSITIVE, InputError, check_choice
from tracker_core.filters import STOP_LIMIT, set_up
from tracker_core.types import ORDERS, FloatArray, Measurements, Truth

KINDS = ("tracking", "estimation", "innovation")
FIGURES = ("total", "rmse", "max", "l2")


@dataclass(frozen=True, slots=True)
class Runs:
    """Measurements of one target, or of one each, over and over.

    Attributes:
        positions: shape (r, n_samples, n_axes), m; NaN where a measurement is missing.
        truth: the true positions, shape (1 or r, n_samples, n_axes), m; None where nobody knows them.
        interval: s, constant.
    """

    positions: FloatArray
    truth: FloatArray | None
    interval: float


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors of one kind, m; NaN where the run stopped or nothing is defined.

    Attributes:
        figures: by name, those of FIGURES that were asked for, all of the same shape: one number for every gain set
            (and every run).
    """

    figures: Mapping[str, FloatArray]

    @property
    def total(self) -> FloatArray:
        """The errors added up."""
        return self.figures["total"]

    @property
    def rmse(self) -> FloatArray:
        """Root mean square."""
        return self.figures["rmse"]

    @property
    def max(self) -> FloatArray:
        """The greatest."""
        return self.figures["max"]

    @property
    def l2(self) -> FloatArray:
        """Euclidean norm over the number of errors."""
        return self.figures["l2"]


def errors_of_runs(
    runs: Runs,
    gains: FloatArray | Sequence[FloatArray],
    *,
    start: str = "two-point",
    initial_state: FloatArray | None = None,
    limit: float = STOP_LIMIT,
    figures: Iterable[str] = FIGURES,
    kinds: Iterable[str] = KINDS,
) -> dict[str, Errors]:
    """The errors that `metrics.measure` finds in the track of every gain set in every run, all axes jointly.

    Args:
        runs: r runs.
        gains: m gain sets, normalised: shape (m, order), or a sequence of vectors whose orders may differ.
        start: a name in STARTS.
        initial_state: for the start "known", shape (n_axes, order) or (r, n_axes, order); filters of a lower order
            take its first columns.
        limit: magnitude of a smoothed position, m, at which a run stops.
        figures: of FIGURES; what is not asked for takes no time.
        kinds: of KINDS; without a truth only innovations are defined.

    Returns:
        Errors by kind, as asked for, with figures of shape (m, r).

    Raises:
        InputError: as `filters.run_filter`; for gains and runs of other shapes, unknown figures and kinds, and errors
            against a truth that is not known.
    """
    wanted = tuple(check_choice("figures", figure, FIGURES) for figure in figures)
    asked = tuple(check_choice("kinds", kind, KINDS) for kind in kinds)
    sets = _gain_sets(gains)
    count, samples, axes = _check_runs(runs, asked)
    states = None if initial_state is None else np.asarray(initial_state, dtype=np.float64)
    if states is not None and states.ndim == 2:
        states = np.broadcast_to(states, (count, *states.shape))
    truth = np.full((1, samples, axes), np.nan) if runs.truth is None else runs.truth
    times = np.arange(samples, dtype=np.float64) * runs.interval
    sums = np.empty((len(sets), count, 3, 4))
    for order in sorted({len(one) for one in sets}):
        rows = [index for index, one in enumerate(sets) if len(one) == order]
        g = np.array([sets[index] for index in rows])
        for run in range(count):
            measurements = Measurements(times, runs.positions[run], runs.interval)
            before = None if states is None else states[run, :, :order]
            sums[rows, run] = _sums(measurements, truth[run % len(truth)], g, start, before, limit)
    with np.errstate(invalid="ignore", divide="ignore"):
        return {kind: Errors(_figures(sums[:, :, KINDS.index(kind)], wanted)) for kind in asked}


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
        Errors by kind, of KINDS, with figures of shape (m,).

    Raises:
        InputError: as `filters.run_filter`; and for gains of another shape, or a varying interval.
    """
    if measurements.interval is None:
        raise InputError("interval", "must be constant", None)
    runs = Runs(measurements.positions[None], truth.positions[None], measurements.interval)
    found = errors_of_runs(runs, gains, start=start, initial_state=initial_state, limit=limit)
    return {
        kind: Errors({name: values[:, 0] for name, values in errors.figures.items()}) for kind, errors in found.items()
    }


def _gain_sets(gains: FloatArray | Sequence[FloatArray]) -> list[FloatArray]:
    if isinstance(gains, np.ndarray) and gains.ndim != 2:
        raise InputError("gains", "must have shape (m, 2), (m, 3) or (m, 4)", gains.shape)
    sets = [np.asarray(one, dtype=np.float64) for one in gains]
    for one in sets:
        if one.ndim != 1 or len(one) not in ORDERS:
            raise InputError("gains", "must have shape (m, 2), (m, 3) or (m, 4)", (len(sets), *one.shape))
    return sets


def _check_runs(runs: Runs, kinds: tuple[str, ...]) -> tuple[int, int, int]:
    """Runs, samples and axes."""
    shape = np.shape(runs.positions)
    if len(shape) != 3 or not all(shape):
        raise InputError("positions", "must have shape (n_runs, n_samples, n_axes)", shape)
    POSITIVE.check("interval", runs.interval)
    if runs.truth is None:
        if kinds != ("innovation",):
            raise InputError("kinds", "must be innovation alone where the truth is not known", ", ".join(kinds))
    elif np.shape(runs.truth) not in {shape, (1, *shape[1:])}:
        raise InputError("truth", f"must have shape {(1, *shape[1:])} or {shape}", np.shape(runs.truth))
    count, samples, axes = shape
    return count, samples, axes


def _sums(
    measurements: Measurements,
    truth: FloatArray,
    g: FloatArray,
    start: str,
    initial_state: FloatArray | None,
    limit: float,
) -> FloatArray:
    """Sum, sum of squares, greatest and number of the errors of every kind, shape (m, 3, 4)."""
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    setting = set_up(measurements, g.shape[1], start=start, initial_state=initial_state, limit=limit)
    true = np.ascontiguousarray(truth.T)
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
        kernels.batch_errors(z, true, setting.dt[0], some, states, begins, heads, setting.limit, part)
        sums[rows] = part
    return sums


def _figures(sums: FloatArray, wanted: tuple[str, ...]) -> dict[str, FloatArray]:
    """Figures from sums of shape (m, r, 4)."""
    total, squares, greatest, count = np.moveaxis(sums, -1, 0)
    defined = np.where(count == 0, np.nan, 1.0)
    all_of_them = {
        "total": total * defined,
        "rmse": np.sqrt(squares / count),
        "max": greatest * defined,
        "l2": np.sqrt(squares) / count * defined,
    }
    return {name: all_of_them[name] for name in wanted}
