"""A search without derivatives from many starts at once: CMA-ES (Hansen 2016, The CMA Evolution Strategy: A Tutorial).

Every start is an island, a population that moves and shrinks by itself. All islands take their steps together, so that
one batch of runs serves them all. An island ends when its own scores agree, when a better one sits on the same place,
or when it is on the way to a hollow that is not the deepest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tracker_core.types import FloatArray

if TYPE_CHECKING:
    from cmaes import CMA

POPULATION = 12
"""Places that an island tries at a time."""

EDGE = 12.0
"""Magnitude of a coordinate that is not passed: a reflection coefficient of 1 - 1e-10."""

AGREE = 1e-6
"""Share of its score within which the better half of a population that has arrived lies."""

_SPREAD = 0.3
"""Standard deviation of a population when it sets out."""

_SAME = 0.03
"""Populations whose middles are no further apart along any axis sit on the same place."""

_HOPELESS = 10.0
"""An island that would have to descend this many times the height its population spans ends in another hollow."""

_NOTHING = 1e300


@dataclass(slots=True)
class _Island:
    strategy: CMA
    places: FloatArray
    best: float = np.inf


class Islands:
    """A search for the place with the least score.

    Args:
        starts: shape (islands, dimensions).
        seed: of the draws; the same one gives the same search.
    """

    def __init__(self, starts: FloatArray, seed: int = 0) -> None:
        from cmaes import CMA  # an extra that nothing else needs

        edges = np.tile([-EDGE, EDGE], (starts.shape[1], 1))
        self._islands = [
            _Island(
                CMA(np.clip(start, -EDGE, EDGE), _SPREAD, edges, seed=seed + number, population_size=POPULATION),
                np.empty((POPULATION, starts.shape[1])),
            )
            for number, start in enumerate(starts)
        ]

    def __len__(self) -> int:
        """Islands that have not ended."""
        return len(self._islands)

    def ask(self) -> FloatArray:
        """The places to be tried next, shape (islands * POPULATION, dimensions)."""
        for island in self._islands:
            island.places = np.array([island.strategy.ask() for _ in range(POPULATION)])
        return np.concatenate([island.places for island in self._islands])

    def tell(self, scores: FloatArray) -> None:
        """What the places asked last came to, shape (islands * POPULATION,); infinite or NaN where it is nothing."""
        usable = np.where(np.isfinite(scores), scores, _NOTHING).reshape(len(self._islands), POPULATION)
        gaps = np.empty(len(self._islands))
        for row, island in enumerate(self._islands):
            island.strategy.tell(list(zip(island.places, usable[row].tolist(), strict=True)))
            ranked = np.sort(usable[row])
            island.best = min(island.best, float(ranked[0]))
            gaps[row] = ranked[POPULATION // 2 - 1] - ranked[0]
        best = np.array([island.best for island in self._islands])
        means = np.array([island.strategy.mean for island in self._islands])
        arrived = gaps <= AGREE * np.abs(best)
        hopeless = best - best.min() > _HOPELESS * gaps
        kept: list[int] = []
        for row in np.argsort(best, kind="stable"):
            taken = (np.abs(means[kept] - means[row]).max(axis=1) < _SAME).any() if kept else False
            if not (arrived[row] or hopeless[row] or taken):
                kept.append(int(row))
        self._islands = [self._islands[row] for row in kept]
