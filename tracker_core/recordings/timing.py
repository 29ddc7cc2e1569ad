"""Whether samples come at one constant interval, and which."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker_core.recordings.bounds import MOST_ROWS
from tracker_core.types import FloatArray, IntArray

TOLERANCE = 0.01
"""Share of the interval by which a stamp may lie beside its sample."""

ROUNDED = 0.1
"""The same, less than which it is where stamps are rounded: further aside, they may as well be true."""

LONG = 1.5
"""Nominal intervals over which an interval is a gap."""

_EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True, slots=True)
class Regularity:
    """How even the times of a recording are.

    Attributes:
        nominal: the usual interval, s: the constant one, or the median.
        shortest, longest: of the intervals between two rows, s.
        odd: share of intervals further than TOLERANCE of the nominal one from a whole multiple of it.
        jitter: root mean square of those distances, s.
        aside: greatest distance of a stamp from its sample, s; 0 where the interval is not constant.
    """

    nominal: float
    shortest: float
    longest: float
    odd: float
    jitter: float
    aside: float


@dataclass(frozen=True, slots=True)
class Grid:
    """A constant interval.

    Attributes:
        interval: s.
        samples: number of the sample of every row, from 0, increasing; shape (n,).
    """

    interval: float
    samples: IntArray


def regularity(times: FloatArray, interval: float | None) -> Regularity:
    """How even strictly increasing times are, with the constant interval where there is one."""
    steps = np.diff(times)
    nominal = float(np.median(steps)) if interval is None else interval
    counts = np.maximum(np.round(steps / nominal), 1)
    beside = steps - nominal * counts
    odd = np.abs(beside) > TOLERANCE * nominal * (1 + 1e-6)
    jitter = float(np.sqrt(np.mean(beside**2)))
    samples = np.concatenate(([0.0], np.cumsum(counts)))
    aside = 0.0 if interval is None else _distance(samples, times, interval)
    return Regularity(nominal, float(steps.min()), float(steps.max()), float(odd.mean()), jitter, aside)


def find_grid(times: FloatArray, offset: float = 0.0) -> Grid | None:
    """The constant interval of times, or None.

    Interval T and sample numbers k are constant if no stamp lies further from a + k T, with the a and T that make the
    greatest of these distances least, than 1 % of T or, where that is more, half a unit of the last decimal that the
    stamps have, as long as that is less than T/10: a stamp of 25 samples a second that is rounded to the millisecond
    lies 1.25 % of T aside, and is meant to be even. Whole seconds 2, 3, 2, 3 s apart may be every 2.5 s, or true: they
    are not constant.
    Distances do not add up, so a clock that drifts is not constant. Of the intervals that fit about as well as the
    best, the one of fewest digits is taken: 0.1 and not 0.09999999999999998.

    Args:
        times: shape (n,), s from the first, strictly increasing, n >= 2.
        offset: of the first stamp as written, s: what its digits are counted with.
    """
    steps = np.diff(times)
    usual = np.sort(steps)[(len(steps) - 1) // 2]
    # Stamps of every 5.4 s in whole seconds are 5 or 6 s apart: their mean tells more than any of them.
    interval = float(steps[(steps >= usual / LONG) & (steps <= LONG * usual)].mean())
    last = times[-1] / interval
    if not last < MOST_ROWS * LONG:
        return None
    samples = np.concatenate(([0.0], np.cumsum(np.round(steps / interval))))
    for _ in range(2):
        first, interval = _line(samples, times)
        if not interval > 0:
            return None
        samples = np.round((times - first) / interval)
    samples -= samples[0]
    if np.any(np.diff(samples) < 1) or samples[-1] >= MOST_ROWS:
        return None
    interval = _evenest(samples, times)
    rounding = 4 * _EPSILON * (abs(offset) + times[-1])
    worst = _distance(samples, times, interval)
    rounded = 0.5 * _last_decimal(times + offset) * (1 + 1e-6)
    # At the limit, as every 2.5 s in stamps 2 and 3 s apart, they are not constant, whatever the last bits say.
    rounded = min(rounded, ROUNDED * interval * (1 - 1e-6) - 2 * rounding)
    if worst > max(TOLERANCE * interval, rounded) + rounding:
        return None
    return Grid(_shortest(samples, times, interval, 1.5 * worst + rounding), samples.astype(np.int64))


def _line(samples: FloatArray, times: FloatArray) -> tuple[float, float]:
    """Offset and slope of times over sample numbers by least squares."""
    deviation = samples - samples.mean()
    slope = float(deviation @ (times - times.mean()) / max(float(deviation @ deviation), _EPSILON))
    return float(times.mean() - slope * samples.mean()), slope


def _evenest(samples: FloatArray, times: FloatArray) -> float:
    """The interval that makes the greatest distance of a stamp from its sample least (Chebyshev), s.

    Twice the distance is a convex function of the interval T, of straight pieces: each is rise - T run, from the stamp
    that lies lowest beside the samples to the one that lies highest. Nothing lies below the place where two pieces
    meet, of which one falls and one rises; the piece over that place takes the place of one of them, until it is no
    higher than they are (Kelley 1960, cutting planes).

    Args:
        samples: shape (n,), increasing, n >= 2.
        times: shape (n,), s, from 0.
    """
    rise, run = float(times[-1]), float(samples[-1] - samples[0])
    # Of a very short interval the last stamp is the highest, of a very long one the first.
    falling, rising = (rise, run), (-rise, -run)
    exact = 16 * _EPSILON * rise
    while True:
        interval = (falling[0] - rising[0]) / (falling[1] - rising[1])
        beside = times - interval * samples
        high, low = beside.argmax(), beside.argmin()
        rise, run = float(times[high] - times[low]), float(samples[high] - samples[low])
        if rise - interval * run <= falling[0] - interval * falling[1] + exact:
            return interval
        if run > 0:
            falling = (rise, run)
        else:
            rising = (rise, run)


def _distance(samples: FloatArray, times: FloatArray, interval: float) -> float:
    """Greatest distance of a stamp from its sample, with the offset that makes it least, s."""
    beside = times - interval * samples
    return float(beside.max() - beside.min()) / 2


def _last_decimal(stamps: FloatArray) -> float:
    """The greatest of 1, 0.1, ..., 1e-6 s of which all stamps are multiples; 0 where none is."""
    for decimals in range(7):
        scaled = stamps * 10.0**decimals
        if np.all(np.abs(scaled - np.round(scaled)) <= 1e-3 + 2 * _EPSILON * np.abs(scaled)):
            return 10.0**-decimals
    return 0.0


def _shortest(samples: FloatArray, times: FloatArray, interval: float, tolerance: float) -> float:
    for digits in range(1, 17):
        candidate = float(f"{interval:.{digits}g}")
        if _distance(samples, times, candidate) <= tolerance:
            return candidate
    return interval
