"""Many simulated users at a time."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Iterator, Sequence
from random import Random

from trials.page import PATHS
from trials.tally import Tally
from trials.user import User


def addresses(users: int, together: int = 40) -> Iterator[str]:
    """An address for each of some users: a class shares the first, everybody else has one of their own."""
    for user in range(users):
        yield "127.0.2.1" if user < together else f"127.0.{3 + user // 250}.{1 + user % 250}"


@contextlib.asynccontextmanager
async def crowd(
    port: int, users: int, pace: float, arrivals: float, seed: int = 1, pages: Sequence[str] = tuple(PATHS)
) -> AsyncIterator[Tally]:
    """Users who come little by little and stay until the end.

    Args:
        port: of the server.
        users: how many.
        pace: seconds from one action of one of them to the next.
        arrivals: of them a second, on average.
        seed: by which everything is chosen.
        pages: that they open.
    """
    tally, over = Tally(), asyncio.Event()

    async def come(number: int, address: str, when: float) -> None:
        await asyncio.sleep(when)
        await User(port, address, seed * 1000 + number, tally, pages).live(pace, over.is_set)

    # Not one after the other like clockwork: those would act at the same moments for ever.
    random = Random(seed)
    tasks = [
        asyncio.create_task(come(number, address, random.uniform(0, users / arrivals)))
        for number, address in enumerate(addresses(users))
    ]
    try:
        await asyncio.sleep(users / arrivals)
        yield tally
    finally:
        over.set()
        await asyncio.gather(*tasks)
