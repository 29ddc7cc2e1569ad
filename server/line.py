"""Whose turn it is, where more is wanted than can be done at a time: clients take turns, however much one of them asks.

Nobody is turned away as long as there is room in the line, and one client has half of that at most.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import AsyncIterator, Iterator
from heapq import heapify, heappop, heappush
from itertools import count
from typing import Generic, TypeVar

from server.clients import CLIENT
from server.limits import Places, share

T = TypeVar("T")


class Line(Generic[T]):
    """Who has a turn, and who waits for one: the next is of the client that has fewest, and had none for longest.

    After whatever may have changed it `next` is called until there is none; one thread at a time may call anything.

    Args:
        most: turns at a time.
        most_of_one: of them for one client.
        waiting: who may wait; of one client half of them.
    """

    def __init__(self, most: int, most_of_one: int, waiting: int) -> None:
        self._turns = Places(most, most_of_one)
        self._waiting = waiting
        # Of each client that has one at all: who waits, and the number of its last turn, or of the last of all before
        # it came.
        self._lines: dict[str, deque[T]] = {}
        self._last: dict[str, float] = {}
        self._number = 0

    def __len__(self) -> int:
        """How many wait."""
        return sum(map(len, self._lines.values()))

    def __iter__(self) -> Iterator[T]:
        """Those who wait, in the order of their turns as far as it can be known now."""
        return (one for _, one in self._in_turn())

    @property
    def taken(self) -> int:
        """How many have a turn."""
        return self._turns.total

    def enter(self, client: str, one: T) -> bool:
        """Put somebody in the line; whether there was a turn at once, or room to wait."""
        there = len(self._lines.get(client, ()))
        if not self._turns.has(client) and (len(self) >= self._waiting or there >= share(self._waiting)):
            return False
        self._lines.setdefault(client, deque()).append(one)
        # Before whoever had the last turn, but not before those who wait for longer, as it would be if it had never had
        # one: while others come all the time, whoever waits for a second turn would wait for ever.
        self._last.setdefault(client, self._number - 0.5)
        return True

    def next(self) -> T | None:
        """Whose turn it is now; None where nobody can have one."""
        client, one = next(self._in_turn(), ("", None))
        # Where the first has no turn, those after him have none either: they have no fewer.
        if one is None or not self._turns.enter(client):
            return None
        self._number += 1
        self._last[client] = self._number
        self._take(client, one)
        return one

    def leave(self, client: str) -> None:
        """The turn of somebody of a client has ended."""
        self._turns.leave(client)
        self._forget(client)

    def remove(self, client: str, one: T) -> bool:
        """Let somebody of a client go who waits; whether he did."""
        if one not in self._lines.get(client, ()):
            return False
        self._take(client, one)
        self._forget(client)
        return True

    def _take(self, client: str, one: T) -> None:
        self._lines[client].remove(one)
        if not self._lines[client]:
            del self._lines[client]

    def _forget(self, client: str) -> None:
        if client not in self._lines and not self._turns.held(client):
            self._last.pop(client, None)

    def _in_turn(self) -> Iterator[tuple[str, T]]:
        clients = [
            (self._turns.held(client), self._last[client], place, client, iter(line))
            for place, (client, line) in enumerate(self._lines.items())
        ]
        heapify(clients)
        for number in count(self._number + 1):
            if not clients:
                return
            has, _, place, client, line = heappop(clients)
            for one in line:
                yield client, one
                heappush(clients, (has + 1, number, place, client, line))
                break


class Door:
    """Where so many may be inside at a time, and the others stand in a line.

    Args:
        most: who may be inside; of one client half of them.
        waiting: who may stand in the line; of one client half of them.
        seconds: for which anybody stands there.
    """

    def __init__(self, most: int, waiting: int, seconds: float) -> None:
        self._line: Line[asyncio.Event] = Line(most, share(most), waiting)
        self._seconds = seconds

    @property
    def inside(self) -> int:
        """How many are."""
        return self._line.taken

    @contextlib.asynccontextmanager
    async def passed(self) -> AsyncIterator[bool]:
        """Go in, and out in the end; whether there came to be room."""
        client, turn = CLIENT.get(), asyncio.Event()
        if not self._line.enter(client, turn):
            yield False
            return
        try:
            self._call()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(self._seconds):
                    await turn.wait()
            yield turn.is_set()
        finally:
            if turn.is_set():
                self._line.leave(client)
            else:
                self._line.remove(client, turn)
            self._call()

    def _call(self) -> None:
        while (turn := self._line.next()) is not None:
            turn.set()
