"""Applications on a port."""

import asyncio
import contextlib
import threading

import uvicorn
from fastapi import FastAPI, Request

from tests.waiting import eventually


def plain():
    """An application that says {} at / and /livez, and at /body how long a body is."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    @app.get("/")
    @app.get("/livez")
    async def root():
        return {}

    @app.post("/body")
    async def body(request: Request):
        return {"bytes": len(await request.body())}

    return app


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
