"""Lets go at once of what viser keeps of a connection that has ended.

viser's handler of a connection holds its tasks, a task holds the error by which it ended, and the error holds the
handler by its trace. Nodes of a scene and the scene hold each other, a connection and what logs for it as well. Such
circles are found by Python's collector alone, which counts objects: it does not see that each of these has 0.7 MB with
it, of compressors and of points. To look for them often enough would stop the server for a tenth of a second each time.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Coroutine
from functools import wraps
from typing import TYPE_CHECKING, Any

from websockets.asyncio.connection import Connection

if TYPE_CHECKING:
    import viser

_Hear = Callable[..., Coroutine[Any, Any, None]]

_LOG = logging.getLogger("websockets")

AFTER = 0.1
"""Seconds after an error, in which viser's handler comes to its end."""


def forget_traces() -> None:
    """Have errors that end connections lose their traces once they are handled; before viser serves."""
    from viser.infra import _infra

    if not hasattr(_infra._message_consumer, "__wrapped__"):  # noqa: SLF001
        _infra._message_consumer = _traceless(_infra._message_consumer)  # noqa: SLF001


def _traceless(hear: _Hear) -> _Hear:
    @wraps(hear)
    async def heard(connection: Connection, *arguments: Any) -> None:
        def end(error: BaseException) -> None:
            error.with_traceback(None)
            unbind(connection)

        try:
            await hear(connection, *arguments)
        except BaseException as error:
            asyncio.get_running_loop().call_later(AFTER, end, error)
            raise

    return heard


def unbind(connection: Connection) -> None:
    """Have a connection hold itself no more: by what logs for it, opened it, and pings until it has ended."""
    connection.protocol.logger = connection.logger = _LOG
    connection.keepalive_task = None
    connection.protocol.__dict__.pop("select_subprotocol", None)


def let_go(client: viser.ClientHandle) -> None:
    """Have a scene that nobody sees any more lose its nodes, and soon the client its scene; in viser's thread."""
    client.scene._handle_from_node_name.clear()  # noqa: SLF001
    client.scene._children_from_node_name.clear()  # noqa: SLF001
    asyncio.get_running_loop().call_later(AFTER, _take_apart, client)


def _take_apart(client: viser.ClientHandle) -> None:
    """Once viser has told everybody that a client has gone."""
    client._websock_connection._incoming_handlers.clear()  # noqa: SLF001
    for part in ("scene", "gui", "camera", "local_storage"):
        client.__dict__.pop(part, None)
