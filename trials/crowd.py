"""Many simulated users at a time."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Iterator, Sequence

from trials.tally import Tally
from trials.user import PAGES, User


def addresses(users: int, together: int = 40) -> Iterator[str]:
    """An address for each of some users: a class shares the first, everybody else has one of their own."""
    for user in range(users):
        yield "127.0.2.1" if user < together else f"127.0.{3 + user // 250}.{1 + user % 250}"


@contextlib.asynccontextmanager
async def crowd(
    port: int, users: int, pace: float, arrivals: float, seed: int = 1, pages: Sequence[str] = PAGES
) -> AsyncIterator[Tally]:
    """Users who come one after the other and stay until the end.

    Args:
        port: of the server.
        users: how many.
        pace: seconds from one action of one of them to the next.
        arrivals: of them a second.
        seed: by which everything is chosen.
        pages: that they open.
    """
    tally, over = Tally(), asyncio.Event()

    async def come(number: int, address: str) -> None:
        await asyncio.sleep(number / arrivals)
        await User(port, address, seed * 1000 + number, tally, pages).live(pace, over.is_set)

    tasks = [asyncio.create_task(come(number, address)) for number, address in enumerate(addresses(users))]
    try:
        await asyncio.sleep(users / arrivals)
        yield tally
    finally:
        over.set()
        await asyncio.gather(*tasks)
