"""Many gain sets, many runs: the errors of every filter in every run, without the tracks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tracker_core.checks import POSITIVE, InputError, check_choice
from tracker_core.filters import STOP_LIMIT, check_measurements, check_start, intervals_of
from tracker_core.lanes import FIGURES, KINDS, Batch, Group
from tracker_core.sequences import sequential_errors
from tracker_core.types import ORDERS, FloatArray, Measurements, Truth

__all__ = ["FIGURES", "KINDS", "Errors", "Runs", "batch_errors", "errors_of_runs"]


@dataclass(frozen=True, slots=True)
class Runs:
    """Measurements of one target, or of one each, over and over.

    Attributes:
        positions: shape (r, n_samples, n_axes), m; NaN where a measurement is missing.
        truth: the true positions, shape (1 or r, n_samples, n_axes), m; NaN where nobody knows them, None where
            nobody knows any.
        interval: s, constant; the nominal one where it varies.
        times: shape (n_samples,), s, strictly increasing, where the interval varies; else None.
    """

    positions: FloatArray
    truth: FloatArray | None
    interval: float
    times: FloatArray | None = None


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

    Filters run side by side where samples are evenly spaced and all of the truth is known, or none of it; else one
    after the other, which takes several times as long.

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
    chosen = tuple(check_choice("kinds", kind, KINDS) for kind in kinds)
    groups = _groups(gains)
    positions, truth, whole = _check_runs(runs, chosen)
    states = _check_states(start, initial_state, positions.shape[0], positions.shape[2], groups)
    batch = Batch(
        groups=groups,
        positions=positions,
        truth=truth,
        interval=POSITIVE.check("interval", runs.interval),
        start=start,
        states=states,
        limit=POSITIVE.check("limit", limit),
        kinds=chosen,
        figures=tuple(check_choice("figures", figure, FIGURES) for figure in figures),
    )
    dt = _intervals(runs, positions.shape[1])
    found = batch.errors() if whole and len(dt) == 1 else sequential_errors(batch, dt)
    return {kind: Errors(errors) for kind, errors in found.items()}


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
        measurements: as for `filters.run_filter`.
        truth: what was there; NaN where nobody knows it.
        gains: shape (m, order), normalised.
        start, initial_state, limit: as for `filters.run_filter`.

    Returns:
        Errors by kind, of KINDS, with figures of shape (m,); where nobody knows the truth, of innovations alone.

    Raises:
        InputError: as `filters.run_filter`; and for gains of another shape.
    """
    check_measurements(measurements)
    even, known = measurements.interval, truth.positions[None] if truth.known else None
    times = np.asarray(measurements.times, dtype=np.float64) if even is None else None
    nominal = float(np.median(np.diff(measurements.times))) if even is None else even
    runs, kinds = Runs(measurements.positions[None], known, nominal, times), KINDS if truth.known else ("innovation",)
    found = errors_of_runs(runs, gains, start=start, initial_state=initial_state, limit=limit, kinds=kinds)
    return {
        kind: Errors({name: values[:, 0] for name, values in errors.figures.items()}) for kind, errors in found.items()
    }


def _groups(gains: FloatArray | Sequence[FloatArray]) -> list[Group]:
    if isinstance(gains, np.ndarray):
        if gains.ndim != 2 or gains.shape[1] not in ORDERS:
            raise InputError("gains", "must have shape (m, 2), (m, 3) or (m, 4)", gains.shape)
        return [Group(np.arange(len(gains)), np.asarray(gains, dtype=np.float64))] if len(gains) else []
    sets = [np.asarray(one, dtype=np.float64) for one in gains]
    for one in sets:
        if one.ndim != 1 or len(one) not in ORDERS:
            raise InputError("gains", "must be vectors of 2, 3 or 4 numbers", one.shape)
    rows = {order: [i for i, one in enumerate(sets) if len(one) == order] for order in ORDERS}
    return [Group(np.array(some), np.array([sets[i] for i in some])) for some in rows.values() if some]


def _check_runs(runs: Runs, kinds: tuple[str, ...]) -> tuple[FloatArray, FloatArray, bool]:
    """Positions and truth, contiguous, and whether the truth is whole: zeros where nobody knows it, NaN for parts."""
    positions = np.require(runs.positions, np.float64, ["C", "W"])
    if positions.ndim != 3 or not positions.size:
        raise InputError("positions", "must have shape (n_runs, n_samples, n_axes)", positions.shape)
    if _odd(positions)[1]:
        raise InputError("positions", "must be finite or NaN", "an infinite number")
    one = (1, *positions.shape[1:])
    truth = np.full(one, np.nan) if runs.truth is None else np.require(runs.truth, np.float64, ["C", "W"])
    missing, infinite = _odd(truth)
    if missing and np.isnan(truth).all():
        if kinds != ("innovation",):
            raise InputError("kinds", "must be innovation alone where the truth is not known", ", ".join(kinds))
        return positions, np.zeros(one), True
    if truth.shape not in {positions.shape, one}:
        raise InputError("truth", f"must have shape {one} or {positions.shape}", truth.shape)
    if infinite:
        raise InputError("truth", "must be finite, or NaN where nobody knows it", "an infinite number")
    return positions, truth, not missing


def _odd(values: FloatArray) -> tuple[bool, bool]:
    """Whether some values are missing, and whether some are infinite; one look at them tells that none is."""
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(values.sum()):
            return False, False
    return bool(np.isnan(values).any()), bool(np.isinf(values).any())


def _intervals(runs: Runs, samples: int) -> FloatArray:
    """The interval before each sample, or the one number if it is constant, s."""
    if runs.times is None:
        return np.array([POSITIVE.check("interval", runs.interval)])
    times = np.asarray(runs.times, dtype=np.float64)
    if times.shape != (samples,):
        raise InputError("times", f"must have shape ({samples},) like the runs", times.shape)
    if not np.isfinite(times).all():
        raise InputError("times", "must be finite", "an infinite or missing time")
    return intervals_of(times)


def _check_states(
    start: str, initial_state: FloatArray | None, runs: int, axes: int, groups: list[Group]
) -> FloatArray | None:
    """Initial states, shape (r, axes, greatest order)."""
    orders = [group.order for group in groups] or [min(ORDERS)]
    shape = (axes, max(orders))
    states = None if initial_state is None else np.asarray(initial_state, dtype=np.float64)
    if states is not None and states.ndim == 3 and states.shape != (runs, *shape):
        raise InputError("initial_state", f"must have shape {shape} or {(runs, *shape)}", states.shape)
    # Where one of the numbers is not finite, their sum is not.
    summed = states.sum(axis=0) if states is not None and states.ndim == 3 else states
    check_start(start, min(orders), None if summed is None else summed[..., : min(orders)], axes)
    check_start(start, max(orders), summed, axes)
    return None if states is None else np.broadcast_to(states, (runs, *shape))
