"""The designs of one parameter at their best: what a search for all gains at once has to beat."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from tracker_core.design import DESIGNS
from tracker_core.design.curves import along_curve, curve_designs, curve_values
from tracker_core.stability import stable
from tracker_core.types import FloatArray

KALMAN = "steady-kalman"
"""The design that is optimal for white process noise: the steady-state Kalman filter."""

POINTS, ZOOM_POINTS, ZOOMS = 61, 13, 2
"""Values of each parameter that are looked at first, and as often again between the neighbours of the best one."""


@dataclass(frozen=True, slots=True)
class Rival:
    """A design at the best value of its parameter.

    Attributes:
        design: a name in DESIGNS.
        parameter: its one parameter.
        value: of it.
        vector: normalised gains.
        score: mean over the runs of the search, m.
    """

    design: str
    parameter: str
    value: float
    vector: tuple[float, ...]
    score: float

    @property
    def title(self) -> str:
        """For tables."""
        return DESIGNS[self.design].title

    @property
    def is_kalman(self) -> bool:
        """Whether this is the steady-state Kalman filter."""
        return self.design == KALMAN


class Scores(Protocol):
    """What gains come to: normalised, shape (p, order), to mean scores, shape (p,); yields while it is at work."""

    def __call__(self, vectors: FloatArray) -> Generator[Any, None, FloatArray]:
        """Score them."""
        ...


def best_of_designs(order: int, scores: Scores) -> Generator[Any, None, tuple[Rival, ...]]:
    """Every design of the order at its best: the best of a row of values, then of finer ones around it.

    Args:
        order: of the filter.
        scores: of gains; what it yields is passed on.

    Returns:
        The rivals, in the order of the registry; a design without stable gains or scores is left out.
    """
    names = curve_designs(order)
    places = [curve_values(name, POINTS) for name in names]
    best: dict[str, Rival] = {}
    for _ in range(1 + ZOOMS):
        vectors = [along_curve(name, order, values) for name, values in zip(names, places, strict=True)]
        found = yield from scores(np.concatenate(vectors))
        parts = np.split(found, np.cumsum([len(values) for values in places])[:-1])
        for row, (name, values, part) in enumerate(zip(names, places, parts, strict=True)):
            usable = np.where(stable(vectors[row]), part, np.inf)
            index = int(np.argmin(usable))
            if usable[index] < (best[name].score if name in best else np.inf):
                (parameter,) = DESIGNS[name].parameters
                chosen = tuple(float(gain) for gain in vectors[row][index])
                best[name] = Rival(name, parameter, float(values[index]), chosen, float(usable[index]))
            low, high = values[max(0, index - 1)], values[min(len(values) - 1, index + 1)]
            even = np.geomspace if low > 0 and high > 2 * low else np.linspace
            places[row] = even(low, high, ZOOM_POINTS)
    return tuple(best[name] for name in names if name in best)
