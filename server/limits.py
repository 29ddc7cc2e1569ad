"""How much one client may take: of requests by time, of sockets at a time."""

from __future__ import annotations

from collections import Counter, OrderedDict
from dataclasses import dataclass

MOST_CLIENTS = 10_000
"""Clients that are remembered, about 2 MB; of more of them, the one heard of longest ago is forgotten first."""

ROUNDING = 1e-6
"""Seconds that are no wait: a clock that has run for a year is good to a fraction of this."""


@dataclass(frozen=True, slots=True)
class Rate:
    """A bucket of `at_once` tokens, to which `per_second` come back until it is full.

    All that is known of a bucket is when it will be full again (the generic cell rate algorithm, ITU-T I.371): one
    number instead of tokens and a time, and nothing to do while nobody asks. Times are seconds of one clock.

    Attributes:
        per_second: that may be taken for long; positive.
        at_once: that may be taken from a full bucket; at least 1.
    """

    per_second: float
    at_once: float

    def wait(self, full: float, now: float) -> float:
        """Seconds until one may be taken of a bucket that is full at a time; 0 for at once."""
        wait = max(full - now, 0.0) + (1 - self.at_once) / self.per_second
        return wait if wait > ROUNDING else 0.0

    def taken(self, full: float, now: float) -> float:
        """When the bucket is full after one more has been taken."""
        return max(full, now) + 1 / self.per_second


class Buckets:
    """One bucket for each client.

    Args:
        rate: of each.
        most: clients that are remembered. Who is forgotten has a full bucket again.
    """

    def __init__(self, rate: Rate, most: int = MOST_CLIENTS) -> None:
        self._rate = rate
        self._most = most
        self._full: OrderedDict[str, float] = OrderedDict()

    def __len__(self) -> int:
        return len(self._full)

    def take(self, client: str, now: float) -> float:
        """Take one for a client: 0, or the seconds until there is one, when nothing was taken."""
        full = self._full.pop(client, 0.0)
        wait = self._rate.wait(full, now)
        self._full[client] = full if wait else self._rate.taken(full, now)
        if len(self._full) > self._most:
            self._full.popitem(last=False)
        return wait


class Places:
    """What clients hold at a time.

    Args:
        most: of all clients.
        most_of_one: of one of them.
    """

    def __init__(self, most: int, most_of_one: int) -> None:
        self._most = most
        self._most_of_one = most_of_one
        self._held: Counter[str] = Counter()
        self.total = 0

    def enter(self, client: str) -> bool:
        """Take a place; whether there was one."""
        if self.total >= self._most or self._held[client] >= self._most_of_one:
            return False
        self.total += 1
        self._held[client] += 1
        return True

    def leave(self, client: str) -> None:
        """Give a place back that was taken."""
        self.total -= 1
        self._held[client] -= 1
        # Who holds nothing is not remembered.
        if not self._held[client]:
            del self._held[client]

    def __len__(self) -> int:
        return len(self._held)
