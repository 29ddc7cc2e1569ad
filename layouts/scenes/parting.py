"""Lets go at once of what viser keeps of a connection that has ended.

viser's handler of a connection holds its tasks, a task holds the error by which it ended, and the error holds the
handler by its trace. Nodes of a scene and the scene hold each other. Such circles are found by Python's collector
alone, which counts objects: it does not see that each of these has 0.7 MB with it, of compressors and of points. To
look for them often enough would stop the server for a tenth of a second each time.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec

if TYPE_CHECKING:
    import viser

P = ParamSpec("P")

AFTER = 0.1
"""Seconds after an error, in which viser's handler comes to its end."""


def forget_traces() -> None:
    """Have errors that end connections lose their traces once they are handled; before viser serves."""
    from viser.infra import _infra

    if not hasattr(_infra._message_consumer, "__wrapped__"):  # noqa: SLF001
        _infra._message_consumer = _traceless(_infra._message_consumer)  # noqa: SLF001


def _traceless(hear: Callable[P, Coroutine[Any, Any, None]]) -> Callable[P, Coroutine[Any, Any, None]]:
    @wraps(hear)
    async def heard(*arguments: P.args, **named: P.kwargs) -> None:
        try:
            await hear(*arguments, **named)
        except BaseException as error:
            asyncio.get_running_loop().call_later(AFTER, error.with_traceback, None)
            raise

    return heard


def let_go(client: viser.ClientHandle) -> None:
    """Have a scene that nobody sees any more lose its nodes; in viser's thread."""
    client.scene._handle_from_node_name.clear()  # noqa: SLF001
    client.scene._children_from_node_name.clear()  # noqa: SLF001
