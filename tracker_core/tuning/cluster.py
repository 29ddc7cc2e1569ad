"""Studies on a Dask cluster: its workers compute the same parts as the threads of one machine, and so the same bits."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from threading import Lock
from typing import TYPE_CHECKING, Any

from tracker_core.checks import InputError

if TYPE_CHECKING:
    from distributed import Client

PATIENCE = 5.0
"""Seconds that a scheduler has to answer."""


class Cluster(Executor):
    """An executor whose work is done by the workers of a Dask cluster. Needs the extra `cluster`.

    A scheduler that was lost is looked for again by the next study; what it was computing is not found again.

    A scheduler carries out whatever it is sent, without asking who sends it: it belongs into a network of its own.

    Args:
        address: of the scheduler, such as "tcp://scheduler:8786".
        patience: s, until it counts as out of reach.

    Raises:
        InputError: where no scheduler answers at the address in time, now or when work is handed over.
    """

    def __init__(self, address: str, patience: float = PATIENCE) -> None:
        self._address, self._patience = address, patience
        self._lock = Lock()
        self._client = _connected(address, patience)
        self._pool = _pool(self._client)

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """Hand a call over to a worker."""
        with self._lock:
            if self._client.status == "closed":
                self._client = _connected(self._address, self._patience)
                self._pool = _pool(self._client)
        return self._pool.submit(work, *arguments, **named)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the cluster; what has been handed over is waited for, or given up."""
        self._pool.shutdown(wait=wait and not cancel_futures)
        self._client.close()


def _pool(client: Client) -> Executor:
    # Equal parts of two studies are two: to cancel one must not end the other.
    return client.get_executor(pure=False)


def _connected(address: str, patience: float) -> Client:
    from distributed import Client  # an extra, and half a second

    rule = f"must be the address of a Dask scheduler that answers within {patience:g} s, such as tcp://host:8786"
    with ThreadPoolExecutor(1) as apart:  # a notebook has a loop of its own
        try:
            apart.submit(asyncio.run, _greet(address, patience)).result()
        except Exception as error:
            # A stranger's answer can be misunderstood in any way.
            raise InputError("scheduler", rule, address) from error
    return Client(address, timeout=patience, set_as_default=False)


async def _greet(address: str, patience: float) -> None:
    """Ask who is there. `Client` would wait for ever where somebody listens and says nothing."""
    from distributed import rpc

    async with asyncio.timeout(patience), rpc(address, timeout=patience) as scheduler:
        await scheduler.identity()
