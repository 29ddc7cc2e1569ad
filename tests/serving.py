"""Applications on a port."""

import asyncio
import contextlib
import threading

import uvicorn
from fastapi import FastAPI, Request, WebSocket

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


def echo_at(app, path):
    """Have an application answer every text on a socket with itself."""

    @app.websocket(path)
    async def echo(websocket: WebSocket):
        await websocket.accept()
        async for text in websocket.iter_text():
            await websocket.send_text(text)


def opening(path):
    """What a browser says to open a socket, as bytes."""
    return (
        b"GET %b HTTP/1.1\r\nHost: a\r\nOrigin: http://a\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    ) % path


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
