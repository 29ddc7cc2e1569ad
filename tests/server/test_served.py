"""The guard and the wire over a real network."""

import asyncio
import http.client
import json
import threading
import time

import pytest
import websockets
from fastapi.responses import StreamingResponse

from server import guard
from server.settings import Settings
from tests.serving import echo_at, plain

SETTINGS = Settings(body_kb=16, requests_per_second=1e6, requests_at_once=1_000_000, sockets=2)


@pytest.fixture(scope="module")
def address(served):
    app, go_on = plain(), threading.Event()

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

    echo_at(app, "/echo")
    guard.attach(app, SETTINGS)
    with served(app, SETTINGS) as found:
        yield found


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


def test_a_socket_that_is_not_opened_is_answered(address, caplog):
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
    assert not [record for record in caplog.records if record.name.startswith("uvicorn")]
