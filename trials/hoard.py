"""One client that takes nothing of what it is sent and says more than can be heard: others hardly notice.

It has as many connections as one client may have, asks on each for the largest answer of a page and reads none, or says
without end what is answered at once, or what never comes to its end.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import tempfile
from collections.abc import Callable, Iterator
from time import perf_counter

import orjson
import psutil
import uvloop

from benchmarks.serving import running
from trials.load import tracebacks
from trials.page import CALLBACK, Desk, Site
from trials.report import Finding, at_most, none_of, percentiles
from trials.wire import Client

GROWTH = 300.0
"""Megabytes that a server may grow by: what one client may leave untaken, and what its connections take themselves."""

SECONDS = 1.0
"""Within which another client is answered."""

CONNECTIONS, ROUNDS = 450, 80
SHORT = 30, 6

EVERY = 0.25
"""Seconds from question to question of the other client."""

SAMPLES = 3_000
"""Of a run whose answer is large, and computed in a moment."""

FLOOD = 4_000_000
"""Bytes that are said on each connection, if the server takes them."""

GREEDY, OTHER = "127.0.0.9", "127.0.0.1"

OPEN = (
    "GET /explore/live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
    "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
PING, PONG = b"\x89\xfd" + bytes(4) + b"x" * 125, b"\x8a\x80" + bytes(4)
BEGUN, GOES_ON = b"\x01\x81" + bytes(4) + b"x", b"\x00\x80" + bytes(4)

Said = Callable[[int, bytes], Iterator[bytes]]


def _asks(port: int, body: bytes) -> Iterator[bytes]:
    yield (
        f"POST {CALLBACK} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\n\r\n"
    ).encode() + body


def _crumbs(port: int, body: bytes) -> Iterator[bytes]:
    del body
    yield f"PUT /recordings HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nTransfer-Encoding: chunked\r\n\r\n".encode()
    yield b"1\r\nx\r\n" * (FLOOD // 6)


def _on_a_socket(begun: bytes, endless: bytes) -> Said:
    def said(port: int, body: bytes) -> Iterator[bytes]:
        del body
        yield OPEN.format(port=port).encode()
        yield begun + endless * (FLOOD // len(endless))

    return said


KINDS: dict[str, Said] = {
    "answers": _asks,
    "crumbs of a body": _crumbs,
    "pings": _on_a_socket(b"", PING),
    "pongs": _on_a_socket(b"", PONG),
    "parts of a message": _on_a_socket(BEGUN, GOES_ON),
}


def trial(short: bool = False) -> Iterator[Finding]:
    """Each kind in turn."""
    connections, rounds = SHORT if short else (CONNECTIONS, ROUNDS)
    with tempfile.TemporaryFile() as log:
        with running(log) as it:
            server = psutil.Process(it.process.pid)
            for kind, said in KINDS.items():
                yield from uvloop.run(_tried(kind, it.port, server, said, connections, rounds))
        yield none_of("tracebacks in the log", tracebacks(log), "all")


async def _tried(
    kind: str, port: int, server: psutil.Process, said: Said, connections: int, rounds: int
) -> list[Finding]:
    other = Client(port, OTHER)
    site = await Site.load(other)
    desk = Desk(await site.beginning(other, "explore"))
    usual = site.callbacks["explore-request.data"]
    large = orjson.dumps(usual.body([desk.question({"samples": str(SAMPLES)})]))
    headers = {"Content-Type": "application/json"}
    seconds: list[float] = []
    wrong: list[str] = []

    async def ask(client: Client, body: bytes, what: str) -> None:
        begun = perf_counter()
        try:
            answer = await client.ask("POST", CALLBACK, body, headers)
            if answer.status != 200:
                wrong.append(f"{what}: {answer.status} {answer.body[:100]!r}")
        except (OSError, EOFError, TimeoutError) as error:
            wrong.append(f"{what}: {type(error).__name__}")
        seconds.append(perf_counter() - begun)

    small = orjson.dumps(usual.body([desk.question({"samples": "300"})]))
    for _ in range(5):
        await ask(other, small, "before")
    before, peak = server.memory_info().rss, 0
    seconds.clear()
    async with contextlib.AsyncExitStack() as stack:
        greedy = asyncio.gather(*(_hold(stack, port, said(port, large)) for _ in range(connections)))
        stack.push_async_callback(_given_up, greedy)
        for _ in range(rounds):
            await ask(other, small, "another client")
            peak = max(peak, server.memory_info().rss)
            await asyncio.sleep(EVERY)
    _, late, longest = percentiles(seconds)
    # Whatever it held has been given back.
    again = Client(port, GREEDY)
    for _ in range(5):
        await ask(again, large, "the same client afterwards")
    for client in (again, other):
        await client.close()
    return [
        none_of(f"{kind}: answers that others lack", wrong, f"{len(seconds)}"),
        at_most(f"{kind}: p95 of others", late / 1e3, SECONDS, "s", timed=True, more=f"longest {longest / 1e3:.3g} s"),
        at_most(f"{kind}: memory at its peak", (peak - before) / 1e6, GROWTH, "MB", more=f"{connections} connections"),
    ]


async def _hold(stack: contextlib.AsyncExitStack, port: int, parts: Iterator[bytes]) -> None:
    """A connection on which everything is said and nothing is read, until the stack is unwound."""
    loop = asyncio.get_running_loop()
    connection = stack.enter_context(socket.socket())
    connection.setblocking(False)
    # The system takes as little as it can in the client's place.
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.bind((GREEDY, 0))
    # It is refused in the end, or cut off.
    with contextlib.suppress(OSError):
        await loop.sock_connect(connection, ("127.0.0.1", port))
        for part in parts:
            await loop.sock_sendall(connection, part)
        await asyncio.Future()


async def _given_up(task: asyncio.Future[list[None]]) -> None:
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task
