"""The guard and the wire over a real network."""

import asyncio
import http.client
import json
import socket
import threading
import time

import pytest
import uvicorn
import websockets
from fastapi import FastAPI, Request, WebSocket
from fastapi.responses import StreamingResponse

from server import guard, wire
from server.settings import Settings

SETTINGS = Settings(body_kb=16, requests_per_second=1e6, requests_at_once=1_000_000, sockets=2)


@pytest.fixture(scope="module")
def address():
    """A server on a port, as it is started for good."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    go_on = threading.Event()

    @app.get("/")
    async def root():
        return {}

    @app.post("/body")
    async def body(request: Request):
        return {"bytes": len(await request.body())}

    @app.get("/broken")
    async def broken():
        raise ZeroDivisionError("a secret")

    @app.get("/late")
    async def late():
        async def parts():
            yield b"x" * 100
            raise ZeroDivisionError("a secret")

        return StreamingResponse(parts(), headers={"content-length": "200"})

    @app.get("/parts")
    def parts():
        def produced():
            yield b"one"
            yield b"two" if go_on.wait(20) else b"never"

        return StreamingResponse(produced())

    @app.post("/on")
    async def on():
        go_on.set()
        return {}

    @app.websocket("/echo")
    async def echo(websocket: WebSocket):
        await websocket.accept()
        async for text in websocket.iter_text():
            await websocket.send_text(text)

    guard.attach(app, SETTINGS)
    config = uvicorn.Config(
        app, host="127.0.0.1", port=0, log_level="error", http=wire.Wire, proxy_headers=False, server_header=False
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    yield server.servers[0].sockets[0].getsockname()
    server.should_exit = True
    thread.join()


@pytest.fixture
def ask(address):
    """A request on a connection of its own: status, headers, body."""

    def request(method, path, **more):
        connection = http.client.HTTPConnection(*address, timeout=30)
        try:
            connection.request(method, path, **more)
            answer = connection.getresponse()
            return answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()
        finally:
            connection.close()

    return request


@pytest.fixture
def connection(address):
    """A connection on which anything may be said."""
    with socket.create_connection(address, timeout=30) as connection:
        yield connection


def until_it_ends(connection):
    parts = []
    try:
        while part := connection.recv(65_536):
            parts.append(part)
    except ConnectionResetError:
        pass
    return b"".join(parts)


def test_nothing_says_what_serves(ask):
    for method, path, status in [("GET", "/", 200), ("HEAD", "/", 200), ("GET", "/broken", 500), ("PUT", "/", 405)]:
        found, headers, body = ask(method, path)
        assert found == status
        assert "server" not in headers
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["x-request-id"]
        assert b"secret" not in body


def test_an_answer_that_breaks_off_is_known_as_such(ask):
    with pytest.raises(http.client.IncompleteRead):
        ask("GET", "/late")
    assert ask("GET", "/")[0] == 200


def test_parts_of_an_answer_come_as_they_are_made(address, ask):
    connection = http.client.HTTPConnection(*address, timeout=30)
    connection.request("GET", "/parts")
    answer = connection.getresponse()
    assert answer.read(3) == b"one"
    assert ask("POST", "/on")[0] == 200
    assert answer.read() == b"two"
    connection.close()


@pytest.mark.parametrize("is_said", [True, False])
def test_who_sends_too_much_hears_it_even_while_sending(ask, is_said):
    content = b"x" * 3_000_000
    parts = content if is_said else (content[at : at + 50_000] for at in range(0, len(content), 50_000))
    status, headers, body = ask("POST", "/body", body=parts)
    assert (status, json.loads(body)["field"], headers["connection"]) == (413, "body", "close")
    assert ask("POST", "/body", body=b"x" * 16_384)[2] == b'{"bytes":16384}'


def test_headers_without_an_end_are_refused(connection, ask):
    connection.sendall(b"GET / HTTP/1.1\r\nHost: a\r\nX: ")
    sent = 0
    with pytest.raises(OSError, match="."):  # noqa: PT012 - it is one of many writes that fails
        while sent < 100_000_000:
            sent += connection.send(b"x" * 65_536)
    # What the network holds on the way is beyond the server.
    assert sent < 50_000_000
    assert ask("GET", "/")[0] == 200


def test_too_large_headers_that_end_are_refused_as_any_request_is(ask):
    status, headers, body = ask("GET", "/", headers={"Cookie": "x" * 20_000})
    assert (status, json.loads(body)["field"]) == (431, "headers")
    assert headers["x-request-id"]


@pytest.mark.parametrize(
    "said", [b"", b"GET / HTTP/1.1\r\nHost: a\r\n", b"GET / HTTP/1.1\r\nHost: a\r\n\r\nGET / HTTP/1.1\r\nHost:"]
)
def test_a_connection_does_not_wait_for_headers_for_ever(address, monkeypatch, said):
    monkeypatch.setattr(wire, "HEAD_SECONDS", 0.2)
    with socket.create_connection(address, timeout=30) as connection:
        connection.sendall(said)
        assert until_it_ends(connection).count(b"HTTP/1.1 200") == said.count(b"\r\n\r\n")


def test_a_connection_that_goes_on_asking_is_kept(address, monkeypatch):
    monkeypatch.setattr(wire, "HEAD_SECONDS", 0.2)
    connection = http.client.HTTPConnection(*address, timeout=30)
    connection.connect()
    first = connection.sock
    for _ in range(3):
        connection.request("GET", "/")
        assert connection.getresponse().read() == b"{}"
        time.sleep(0.3)
    assert connection.sock is first
    connection.close()


# Sockets -------------------------------------------------------------------------------------------------------------


def opened(address, **more):
    host, port = address
    origin = more.pop("origin", f"http://{host}:{port}")
    return websockets.connect(f"ws://{host}:{port}/echo", origin=origin, proxy=None, **more)


async def placed(address):
    """A socket once there is a place for it: who has left is not gone before the server has noticed."""
    until = time.monotonic() + 30
    while True:
        try:
            return await opened(address)
        except websockets.exceptions.InvalidStatus as error:
            if error.response.status_code != 503 or time.monotonic() > until:
                raise
            await asyncio.sleep(0.01)


async def refused(address, **more):
    with pytest.raises(websockets.exceptions.InvalidStatus) as caught:
        async with opened(address, **more):
            pass
    return caught.value.response


def test_what_is_said_fast_is_answered_in_order(address):
    async def play():
        async with await placed(address) as connection:
            assert connection.response.headers["x-request-id"]
            said = [str(number) for number in range(130)]
            for text in said:
                await connection.send(text)
            assert [await asyncio.wait_for(connection.recv(), 30) for _ in said] == said

    asyncio.run(play())


def test_a_socket_that_is_not_opened_is_answered(address):
    async def play():
        elsewhere = await refused(address, origin="http://elsewhere.test")
        async with await placed(address), await placed(address):
            full = await refused(address)
        async with await placed(address):
            pass
        return elsewhere, full

    elsewhere, full = asyncio.run(play())
    assert (elsewhere.status_code, json.loads(elsewhere.body)["field"]) == (403, "origin")
    assert (full.status_code, json.loads(full.body)["field"], full.headers["retry-after"]) == (503, "socket", "5")
    for answer in (elsewhere, full):
        assert answer.headers["x-content-type-options"] == "nosniff"
