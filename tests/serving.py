"""Applications on a port."""

import asyncio
import contextlib
import threading

import uvicorn

from tests.waiting import eventually


@contextlib.contextmanager
def on_a_port(config):
    """A server of this configuration in a thread; its address."""
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        asyncio.run(eventually(lambda: server.started))
        yield server.servers[0].sockets[0].getsockname()
    finally:
        server.should_exit = True
        thread.join()
