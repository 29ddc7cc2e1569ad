"""What a scene shows, as data: the region with the gains in it, or a track. Nothing here knows how it is drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from layouts.theme import THEMES
from tracker_core.checks import Domain, InputError, check_choice
from tracker_core.types import GAIN_NAMES, BoolArray, FloatArray

DRAWN_SAMPLES = 2_000
"""Of a longer run every n-th sample is drawn."""

TRAIL_SAMPLES = 40
"""So many steps behind the cursor are drawn bold."""

SERIES = ("truth", "observed", "predicted", "smoothed")
GAIN = Domain()


@dataclass(frozen=True, slots=True)
class RegionPicture:
    """The stable region of order 3 with the operating point.

    Attributes:
        gains: normalised alpha, beta, gamma.
        stable: the verdict on them.
        theme: "light" or "dark".

    Raises:
        InputError: for gains that are not three finite numbers, or an unknown theme.
    """

    gains: tuple[float, float, float]
    stable: bool
    theme: str = "light"

    def __post_init__(self) -> None:
        if len(self.gains) != 3:
            raise InputError("gains", "must be 3 numbers", self.gains)
        for name, value in zip(GAIN_NAMES, self.gains, strict=False):
            GAIN.check(name, value)
        check_choice("theme", self.theme, THEMES)


@dataclass(frozen=True, slots=True, eq=False)
class TrackPicture:
    """A run of the filter: what the target did, what was seen of it, what the filter made of that.

    Attributes:
        key: stays the same as long as times, truth and observed do.
        times: shape (n_samples,), s, increasing.
        truth: shape (n_samples, n_axes), m, one to three axes; NaN where nobody knows it.
        observed: same shape; NaN where a measurement is missing.
        predicted: same shape; NaN where there is none.
        smoothed: same shape; NaN where there is none.
        cursor: index of the sample that is looked at.
        trail: whether the last steps before the cursor are drawn bold.
        names: of the axes, for their labels.
        theme: "light" or "dark".
        refused: shape (n_samples,), whether a gate did not believe a measurement; None where none watched.

    Raises:
        InputError: for shapes that do not fit, times that are not finite, a cursor outside the run, or an unknown
            theme.
    """

    key: str
    times: FloatArray
    truth: FloatArray
    observed: FloatArray
    predicted: FloatArray
    smoothed: FloatArray
    cursor: int
    trail: bool = False
    names: tuple[str, ...] = ("x", "y", "z")
    theme: str = "light"
    refused: BoolArray | None = None

    def __post_init__(self) -> None:
        if self.times.ndim != 1 or not len(self.times) or not np.isfinite(self.times).all():
            raise InputError("times", "must be finite numbers, shape (n_samples,)", self.times)
        samples = len(self.times)
        for name in SERIES:
            shape = getattr(self, name).shape
            if len(shape) != 2 or shape[0] != samples or shape[1] not in (1, 2, 3) or shape != self.truth.shape:
                raise InputError(name, f"must have the shape ({samples}, n_axes) with 1 to 3 axes", shape)
        if self.refused is not None and self.refused.shape != (samples,):
            raise InputError("refused", f"must have the shape ({samples},)", self.refused.shape)
        if len(self.names) < self.truth.shape[1]:
            raise InputError("names", f"must be {self.truth.shape[1]} names", self.names)
        Domain(0, samples - 1, whole=True).check("cursor", self.cursor)
        check_choice("theme", self.theme, THEMES)

    def thinned(self) -> TrackDrawing:
        """What is drawn of it and remembered: no more than DRAWN_SAMPLES of a series."""
        rows = _every(len(self.times))
        trail = slice(max(0, self.cursor - TRAIL_SAMPLES), self.cursor + 1)
        gone = np.flatnonzero(np.zeros(len(self.times)) if self.refused is None else self.refused)
        gone = gone[_every(len(gone))]
        return TrackDrawing(
            key=self.key,
            times=self.times[rows].copy(),
            series={name: getattr(self, name)[rows].copy() for name in SERIES},
            refused_times=self.times[gone].copy(),
            refused=self.observed[gone].copy(),
            cursor_time=float(self.times[self.cursor]),
            cursor={name: getattr(self, name)[self.cursor].copy() for name in ("observed", "smoothed")},
            trail_times=self.times[trail].copy() if self.trail else np.empty(0),
            trail=self.smoothed[trail].copy() if self.trail else np.empty((0, self.truth.shape[1])),
            names=self.names[: self.truth.shape[1]],
            theme=self.theme,
        )


@dataclass(frozen=True, slots=True, eq=False)
class TrackDrawing:
    """The samples of a track that are drawn.

    Attributes:
        key: as in the picture.
        times: shape (n_drawn,), s.
        series: truth, observed, predicted and smoothed, each of shape (n_drawn, n_axes), m.
        refused_times: of the measurements that a gate did not believe, shape (n_refused,), s.
        refused: these, shape (n_refused, n_axes), m.
        cursor_time: of the sample that is looked at, s.
        cursor: observed and smoothed of that sample, each of shape (n_axes,), m.
        trail_times: of the steps that lead to it, shape (n_trail,), s.
        trail: smoothed positions of these, shape (n_trail, n_axes), m.
        names: of the axes.
        theme: as in the picture.
    """

    key: str
    times: FloatArray
    series: dict[str, FloatArray]
    refused_times: FloatArray
    refused: FloatArray
    cursor_time: float
    cursor: dict[str, FloatArray]
    trail_times: FloatArray
    trail: FloatArray
    names: tuple[str, ...]
    theme: str

    @property
    def still(self) -> tuple[object, ...]:
        """What must be the same for one scene to show both."""
        return self.key, self.theme, self.names, self.series["truth"].shape

    def same_line(self, other: TrackDrawing, name: str) -> bool:
        """Whether a series is the same in both."""
        return np.array_equal(self.series[name], other.series[name], equal_nan=True)


def _every(samples: int) -> slice:
    """All of so many, or every n-th."""
    return slice(None, None, max(1, math.ceil(samples / DRAWN_SAMPLES)))


Picture = RegionPicture | TrackPicture
Drawing = RegionPicture | TrackDrawing
