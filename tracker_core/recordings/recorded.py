"""A recording: measurements read from a file, with all that was found on the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker_core.recordings.findings import Finding
from tracker_core.recordings.reading import Reading
from tracker_core.recordings.timing import Regularity
from tracker_core.types import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class Recorded:
    """What a file says, read as a reading says.

    Attributes:
        reading: how it was read.
        axes: names of the axes: x, y, z of a plane; east, north, up of local ground.
        times: shape (n,), s from the first row; sample number times `interval` where that is constant, else as stamped.
        positions: shape (n, axes), m; NaN where a measurement is missing.
        truth: the same of the true position, NaN where it is unknown; None where the reading names no columns of it.
        interval: s where it is constant, else None.
        regularity: how even the stamps are.
        lines: shape (n,), number of the row's line in the file; 0 for a sample that was put into a gap.
        held: shape (n,), whether the row's position is exactly that of the measurement before, missing or kept.
        start: date and time of the first row in UTC; empty where the clock does not tell.
        place: latitude, longitude (degrees) and altitude (m) of the local origin; None where there is none.
        rows: how many rows the file has.
        others: how many of them belong to other tracks.
        counts: how many findings of every kind, those found only.
        findings: the first of them, by line; see MOST_LISTED.
    """

    reading: Reading
    axes: tuple[str, ...]
    times: FloatArray
    positions: FloatArray
    truth: FloatArray | None
    interval: float | None
    regularity: Regularity
    lines: IntArray
    held: BoolArray
    start: str
    place: tuple[float, float, float] | None
    rows: int
    others: int
    counts: dict[str, int]
    findings: tuple[Finding, ...]

    @property
    def nominal(self) -> float:
        """The constant interval, or the median one, s."""
        return self.regularity.nominal

    @property
    def measured(self) -> int:
        """How many samples have a position along some axis."""
        return int(np.isfinite(self.positions).any(axis=1).sum())

    @property
    def origin(self) -> str:
        """Where time and axes begin, in words; empty where nothing is known."""
        parts = [f"t = 0 at {self.start}"] if self.start else []
        if self.place:
            latitude, longitude, altitude = self.place
            parts.append(f"origin at latitude {latitude:.7f}°, longitude {longitude:.7f}°, altitude {altitude:.1f} m")
        return "; ".join(parts)
