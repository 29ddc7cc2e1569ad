"""What simulated users have seen."""

from __future__ import annotations

import asyncio
from collections import Counter, defaultdict


class Tally:
    """What a crowd has seen.

    Attributes:
        seconds: from when each action was due until it was answered, by kind.
        errors: what went wrong, in words, and how often.
        refused: answers that said that something cannot be run.
    """

    def __init__(self) -> None:
        self.seconds: defaultdict[str, list[float]] = defaultdict(list)
        self.errors: Counter[str] = Counter()
        self.refused = 0
        self._more = asyncio.Event()

    def __len__(self) -> int:
        """How many actions."""
        return sum(map(len, self.seconds.values()))

    def count(self, kind: str, seconds: float) -> None:
        """An action has been answered."""
        self.seconds[kind].append(seconds)
        self._more.set()

    async def reached(self, least: int) -> None:
        """Wait for so many actions."""
        while len(self) < least:
            self._more.clear()
            await self._more.wait()

    def clear(self) -> None:
        """Forget durations, not errors."""
        self.seconds.clear()
