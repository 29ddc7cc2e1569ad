"""How much one client may take: of requests and messages by time, of sockets and of what is worked on at a time."""

from __future__ import annotations

import asyncio
import threading
from collections import Counter, OrderedDict
from dataclasses import dataclass
from weakref import WeakValueDictionary

MOST_CLIENTS = 10_000
"""Clients that are remembered, about 2 MB; of more of them, the one heard of longest ago is forgotten first."""

ROUNDING = 1e-6
"""Seconds that are no wait: a clock that has run for a year is good to a fraction of this."""


def share(most: int) -> int:
    """The part of so many that one client may have: half of them, and one at least."""
    return max(1, (most + 1) // 2)


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

    def taken(self, full: float, now: float, amount: float = 1) -> float:
        """When the bucket is full after so many more have been taken."""
        return max(full, now) + amount / self.per_second


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

    def wait(self, client: str, now: float) -> float:
        """Seconds until there is one for a client; 0 where there is."""
        return self._rate.wait(self._full.get(client, 0.0), now)

    def draw(self, client: str, now: float, amount: float = 1) -> None:
        """Take so many for a client, whether they are there or not: until they have come back there is none."""
        self._full[client] = self._rate.taken(self._full.pop(client, 0.0), now, amount)
        if len(self._full) > self._most:
            self._full.popitem(last=False)

    def take(self, client: str, now: float) -> float:
        """Take one for a client: 0, or the seconds until there is one, when nothing was taken."""
        wait = self.wait(client, now)
        # Who is given none is remembered as well.
        self.draw(client, now, 0 if wait else 1)
        return wait

    def book(self, client: str, now: float) -> float:
        """Take one for a client, of what is there or of what comes back next: the seconds until it is there."""
        wait = self.wait(client, now)
        self.draw(client, now)
        return wait


class Places:
    """What clients hold at a time. Any thread may call this.

    Args:
        most: of all clients.
        most_of_one: of one of them.

    Attributes:
        total: that are held.
    """

    def __init__(self, most: int, most_of_one: int) -> None:
        self._most = most
        self._most_of_one = most_of_one
        self._held: Counter[str] = Counter()
        self._lock = threading.Lock()
        self.total = 0

    def has(self, client: str, amount: int = 1) -> bool:
        """Whether there are so many for a client."""
        return self.total + amount <= self._most and self._held[client] + amount <= self._most_of_one

    def held(self, client: str) -> int:
        """How many a client holds."""
        return self._held[client]

    def enter(self, client: str, amount: int = 1) -> bool:
        """Take so many places; whether there were."""
        with self._lock:
            if not self.has(client, amount):
                return False
            self.total += amount
            self._held[client] += amount
            return True

    def leave(self, client: str, amount: int = 1) -> None:
        """Give so many places back that were taken."""
        with self._lock:
            self.total -= amount
            self._held[client] -= amount
            # Who holds nothing is not remembered.
            if not self._held[client]:
                del self._held[client]

    def __len__(self) -> int:
        return len(self._held)


class Turns:
    """What is worked on for clients at a time; the rest waits in its order, that of each client apart.

    Args:
        most_of_one: for one client.
    """

    def __init__(self, most_of_one: int) -> None:
        self._most_of_one = most_of_one
        self._turns: WeakValueDictionary[str, asyncio.Semaphore] = WeakValueDictionary()

    def of(self, client: str) -> asyncio.Semaphore:
        """Those of a client, the same for as long as anybody holds on to them."""
        turns = self._turns.get(client)
        if turns is None:
            turns = self._turns[client] = asyncio.Semaphore(self._most_of_one)
        return turns

    def __len__(self) -> int:
        return len(self._turns)
