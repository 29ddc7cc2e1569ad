"""What may come beside requests: heads, the rests of bodies, what is sent ahead, what is no request; over a network."""

import asyncio
import contextlib
import json
import socket
import threading
import time

import pytest
from fastapi import Request, Response, WebSocket

from server import entrance, guard, wire
from server.entrance import Entrance
from server.settings import Settings
from tests.serving import opening, plain
from tests.waiting import eventually

SHAPE = {"field", "rule", "received", "message", "request"}
SETTINGS = Settings(body_kb=16, requests_per_second=1e6, requests_at_once=1_000_000)
SHORT = 0.1
"""Seconds for which tests let something be waited for."""

REACHED = threading.Event()
"""The application has been asked for a socket that it never opens, or has all pieces of a body but the end."""

PIECES = 16_000

ASK = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"
POST = b"POST %b HTTP/1.1\r\nHost: a\r\n%b\r\n\r\n"
CHUNKED, SOON = b"Transfer-Encoding: chunked", b"Expect: 100-continue"
GO_ON = b"HTTP/1.1 100 Continue\r\n\r\n"
OPEN = opening(b"/echo")


def made(settings=SETTINGS):
    app = plain()

    @app.post("/pieces")
    async def pieces(request: Request):
        size = 0
        async for part in request.stream():
            size += len(part)
            if size == PIECES:
                REACHED.set()
        return {"bytes": size}

    @app.post("/names")
    async def names(request: Request):
        await request.body()
        return list(request.headers)

    @app.get("/later")
    async def later():
        await asyncio.sleep(3 * SHORT)
        return {}

    @app.get("/large")
    async def large():
        return Response(b"x" * 20_000_000)

    @app.websocket("/echo")
    async def echo(websocket: WebSocket):
        await websocket.accept()
        await websocket.send_text("there")

    @app.websocket("/never")
    async def never(websocket: WebSocket):
        REACHED.set()
        while (await websocket.receive())["type"] != "websocket.disconnect":
            pass

    guard.attach(app, settings)
    return app


@pytest.fixture(scope="module")
def address(served):
    with served(made(), SETTINGS) as found:
        yield found


@pytest.fixture
def connection(address):
    """A connection on which anything may be said."""
    with socket.create_connection(address, timeout=30) as connection:
        yield connection


@pytest.fixture
def hurried(monkeypatch):
    monkeypatch.setattr(wire, "HEAD_SECONDS", SHORT)


def until_it_ends(connection):
    parts = []
    with contextlib.suppress(ConnectionResetError):
        while part := connection.recv(65_536):
            parts.append(part)
    return b"".join(parts)


def answers(said):
    """Status, headers and body of each answer in what came back."""
    found = []
    while said:
        head, _, said = said.partition(b"\r\n\r\n")
        first, *lines = head.decode("latin-1").split("\r\n")
        headers = {name.lower(): value for name, value in (line.split(": ", 1) for line in lines)}
        size = int(headers.get("content-length", 0))
        found.append((int(first.split()[1]), headers, said[:size]))
        said = said[size:]
    return found


def one_answer(connection):
    """The next answer on a connection that goes on."""
    said = b""
    while True:
        part = connection.recv(65_536)
        assert part, "it was closed"
        said += part
        head, end, body = said.partition(b"\r\n\r\n")
        if end and len(body) >= int(dict(answers(head + end)[0][1]).get("content-length", 0)):
            return answers(said)


def refused(answer, status, field):
    """What a refusal says, in the one shape of all of them, on a connection that ends with it."""
    found, headers, body = answer
    said = json.loads(body)
    assert (found, said["field"]) == (status, field)
    assert set(said) == SHAPE
    assert said["request"] == headers["x-request-id"]
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["content-security-policy"].startswith("default-src 'none'")
    assert headers["cache-control"] == "no-store"
    assert headers["connection"].lower() == "close"
    return said


def begun(connection, path=b"/body"):
    """A request whose body the application waits for."""
    connection.sendall(POST % (path, CHUNKED + b"\r\n" + SOON))
    assert connection.recv(len(GO_ON)) == GO_ON


# Sockets -------------------------------------------------------------------------------------------------------------


def with_more(line):
    return OPEN[:-2] + line + b"\r\n\r\n"


@pytest.mark.parametrize(
    ("said", "status", "field"),
    [
        pytest.param(OPEN.replace(b"GET", b"POST"), 400, "handshake", id="method"),
        pytest.param(OPEN.replace(b"HTTP/1.1", b"HTTP/1.0"), 400, "handshake", id="version of HTTP"),
        pytest.param(with_more(b"Content-Length: 5") + b"hello", 400, "handshake", id="body"),
        pytest.param(with_more(CHUNKED) + b"0\r\n\r\n", 400, "handshake", id="chunks"),
        pytest.param(OPEN.replace(b"Sec-WebSocket-Key", b"X"), 400, "handshake", id="no key"),
        pytest.param(OPEN.replace(b"dGhl", b"?"), 400, "handshake", id="key"),
        pytest.param(with_more(b"Sec-WebSocket-Key: a"), 400, "handshake", id="two keys"),
        pytest.param(OPEN.replace(b"13", b"12"), 400, "handshake", id="version"),
        pytest.param(OPEN.replace(b"Upgrade:", b"Upgrade: h2c\r\nUpgrade:"), 400, "handshake", id="two protocols"),
        pytest.param(with_more(b"X: %b" % (b"x" * 30_000)), 431, "headers", id="long headers"),
        pytest.param(with_more(b"\r\n".join(b"X: %d" % i for i in range(150))), 431, "headers", id="many headers"),
        pytest.param(OPEN.replace(b"/echo", b"/" + b"x" * 9_000), 414, "address", id="long address"),
    ],
)
def test_what_cannot_become_a_socket_is_answered(connection, counted, said, status, field):
    counted("gainscope_refusals_total", reason=field)
    connection.sendall(said)
    [answer] = answers(until_it_ends(connection))
    refused(answer, status, field)
    assert counted("gainscope_refusals_total", reason=field) == 1


@pytest.mark.parametrize("more", [b"X: " + b"x" * 15_000, b"X: \xe4", b"Content-Length: 0"])
def test_what_is_promised_to_requests_holds_for_sockets(connection, more):
    connection.sendall(with_more(more))
    assert connection.recv(65_536).startswith(b"HTTP/1.1 101 ")


def test_a_socket_is_not_opened_beside_a_request(connection):
    connection.sendall(ASK + OPEN)
    first, second = answers(until_it_ends(connection))
    assert first[0] == 200
    refused(second, 400, "handshake")


def test_a_socket_that_is_not_opened_in_time_is_refused(connection, monkeypatch, counted):
    monkeypatch.setattr(guard, "OPENING_SECONDS", SHORT)
    counted("gainscope_refusals_total", reason="ended")
    connection.sendall(OPEN.replace(b"/echo", b"/never"))
    [answer] = answers(until_it_ends(connection))
    refused(answer, 503, "server")
    assert answer[1]["retry-after"] == "5"
    assert counted("gainscope_refusals_total", reason="ended") == 1


def test_who_speaks_before_the_socket_is_open_is_not_heard(connection, caplog):
    REACHED.clear()
    connection.sendall(OPEN.replace(b"/echo", b"/never"))
    assert REACHED.wait(20)
    connection.sendall(b"\xff" * 100)
    assert until_it_ends(connection) == b""
    assert not caplog.records


# Waiting -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("said", "statuses"),
    [
        (b"", []),
        (b"\r\n", []),
        (b"GET / HTTP/1.1\r\nHost: a\r\n", [408]),
        (ASK + b"GET / HTTP/1.1\r\nHost:", [200, 408]),
    ],
)
def test_a_connection_does_not_wait_for_headers_for_ever(hurried, connection, counted, said, statuses):
    counted("gainscope_refusals_total", reason="slow")
    connection.sendall(said)
    found = answers(until_it_ends(connection))
    assert [status for status, _, _ in found] == statuses
    if 408 in statuses:
        refused(found[-1], 408, "headers")
    assert counted("gainscope_refusals_total", reason="slow") == statuses.count(408)


def test_nor_for_an_empty_line_to_be_more(hurried, connection):
    connection.sendall(ASK)
    assert one_answer(connection)[0][0] == 200
    connection.sendall(b"\r\n")
    assert until_it_ends(connection) == b""


@pytest.mark.parametrize("rest", [b"", b"x"])
def test_nor_for_the_rest_of_a_body_that_nobody_wants(hurried, connection, counted, rest):
    counted("gainscope_refusals_total", reason="slow")
    connection.sendall(POST % (b"/nowhere", b"Content-Length: 10"))
    assert one_answer(connection)[0][0] == 404
    connection.sendall(rest)
    assert until_it_ends(connection) == b""
    assert counted("gainscope_refusals_total", reason="slow") == 1


def test_what_comes_ahead_has_its_time_once_what_was_before_is_answered(hurried, connection):
    connection.sendall(ASK.replace(b"/ ", b"/later ") + b"GET / HTTP/1.1\r\nHost:")
    assert [status for status, _, _ in answers(until_it_ends(connection))] == [200, 408]


def test_a_connection_that_goes_on_asking_is_kept(hurried, connection):
    for said in (ASK, POST % (b"/nowhere", b"Content-Length: 10"), ASK):
        connection.sendall(said)
        assert one_answer(connection)[0][0] == (404 if b"nowhere" in said else 200)
        connection.sendall(b"x" * 10 if b"nowhere" in said else b"")
        time.sleep(2 * SHORT)


@pytest.mark.skipif(not hasattr(socket, "TCP_USER_TIMEOUT"), reason="the system has no such bound")
def test_who_takes_nothing_of_what_is_sent_is_given_up(served, monkeypatch):
    lost = []
    monkeypatch.setattr(wire, "STALLED_MS", 100)
    usual = wire.Wire.connection_lost
    monkeypatch.setattr(wire.Wire, "connection_lost", lambda self, exc: (lost.append(exc), usual(self, exc)))
    with served(made(), SETTINGS) as address, socket.create_connection(address) as connection:
        connection.sendall(ASK.replace(b"/ ", b"/large "))
        asyncio.run(eventually(lambda: any(isinstance(exc, TimeoutError) for exc in lost)))


# Size ----------------------------------------------------------------------------------------------------------------


def test_headers_without_an_end_are_refused(connection, address):
    connection.sendall(b"GET / HTTP/1.1\r\nHost: a\r\nX: ")
    sent = 0
    with pytest.raises(OSError, match="."):  # noqa: PT012 - it is one of many writes that fails
        while sent < 100_000_000:
            sent += connection.send(b"x" * 65_536)
    # What the network holds on the way is beyond the server.
    assert sent < 50_000_000
    refused(answers(until_it_ends(connection))[0], 431, "headers")


@pytest.mark.parametrize("more", [b"Cookie: " + b"x" * 20_000, b"\r\n".join(b"X-%d: y" % i for i in range(9_000))])
def test_too_large_headers_that_end_are_refused_as_any_request_is(connection, more):
    connection.sendall(ASK[:-2] + more + b"\r\n\r\n")
    status, headers, body = one_answer(connection)[0]
    assert (status, json.loads(body)["field"]) == (431, "headers")
    assert headers["x-request-id"]


@pytest.mark.parametrize(
    "beside", [b"0\r\n" + b"X: y\r\n" * 40_000, b"0\r\nX: " + b"y" * 200_000, b"1;" + b"x" * 200_000]
)
def test_what_is_beside_a_body_is_bounded(connection, counted, beside):
    counted("gainscope_refusals_total", reason="padding")
    begun(connection)
    with contextlib.suppress(OSError):
        connection.sendall(beside)
    refused(answers(until_it_ends(connection))[0], 400, "body")
    assert counted("gainscope_refusals_total", reason="padding") == 1


def test_a_body_may_come_in_the_smallest_pieces(connection):
    REACHED.clear()
    begun(connection, b"/pieces")
    connection.sendall(b"1\r\nx\r\n" * PIECES)
    assert REACHED.wait(20)
    connection.sendall(b"0\r\n\r\n")
    assert one_answer(connection)[0][2] == b'{"bytes":%d}' % PIECES


@pytest.mark.parametrize("path", [b"/pieces", b"/nowhere"])
def test_but_not_in_any_number_of_them(connection, counted, monkeypatch, path):
    """Each takes the server as long as a large one, also where nobody wants them."""
    monkeypatch.setattr(wire, "SMALL_PARTS", 2_000)
    counted("gainscope_refusals_total", reason="padding")
    connection.sendall(POST % (path, CHUNKED) + b"1\r\nx\r\n" * 3_000)
    found = answers(until_it_ends(connection))
    if path == b"/pieces":
        refused(found[0], 400, "body")
    assert counted("gainscope_refusals_total", reason="padding") == 1


def test_a_large_body_may_come_in_many_parts(connection, monkeypatch):
    monkeypatch.setattr(wire, "SMALL_PARTS", 10)
    body = b"40\r\n" + b"x" * 64 + b"\r\n"
    connection.sendall(POST % (b"/pieces", CHUNKED) + body * 200 + b"0\r\n\r\n")
    assert one_answer(connection)[0][0] == 200


def test_what_follows_a_body_does_not_count_as_headers(connection):
    connection.sendall(POST % (b"/names", CHUNKED) + b"1\r\nx\r\n0\r\nX-Late: y\r\n\r\n")
    assert json.loads(one_answer(connection)[0][2]) == ["host", "transfer-encoding"]


# Ahead ---------------------------------------------------------------------------------------------------------------


def test_a_few_requests_may_be_sent_ahead(connection):
    connection.sendall(ASK * (wire.MOST_AHEAD - 1) + ASK.replace(b"Host", b"Connection: close\r\nHost"))
    assert [status for status, _, _ in answers(until_it_ends(connection))] == [200] * wire.MOST_AHEAD


@pytest.mark.parametrize("many", [wire.MOST_AHEAD + 1, 2_000])
def test_of_many_the_first_are_answered(connection, counted, many):
    counted("gainscope_refusals_total", reason="ahead")
    connection.sendall(ASK * many)
    *first, last = answers(until_it_ends(connection))
    assert [status for status, _, _ in first] == [200] * wire.MOST_AHEAD
    refused(last, 429, "requests")
    assert counted("gainscope_refusals_total", reason="ahead") == 1


# What is no request --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "said",
    [
        pytest.param(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", id="TLS"),
        pytest.param(b"GET / HTTP/9.9\r\n\r\n", id="version"),
        pytest.param(b"GET nowhere HTTP/1.1\r\nHost: a\r\n\r\n", id="address"),
        pytest.param(b"CONNECT a:80 HTTP/1.1\r\nHost: a\r\n\r\n", id="tunnel"),
        pytest.param(POST % (b"/body", CHUNKED) + b"zz\r\n", id="chunk"),
        pytest.param(ASK + b"?", id="after a request"),
    ],
)
def test_what_is_no_request_is_refused_as_any_request_is(connection, counted, caplog, said):
    counted("gainscope_refusals_total", reason="malformed")
    connection.sendall(said)
    *first, last = answers(until_it_ends(connection))
    assert [status for status, _, _ in first] == [200] * said.count(ASK)
    refused(last, 400, "request")
    assert counted("gainscope_refusals_total", reason="malformed") == 1
    assert not [record for record in caplog.records if record.name.startswith("uvicorn")]


def test_what_becomes_none_while_it_is_waited_for_too(connection, counted):
    counted("gainscope_refusals_total", reason="malformed")
    begun(connection)
    connection.sendall(b"zz\r\n")
    [answer] = answers(until_it_ends(connection))
    refused(answer, 400, "request")
    assert counted("gainscope_refusals_total", reason="malformed") == 1


def test_what_is_to_become_something_else_is_answered_once(connection, caplog):
    """Its body is not taken for the next request."""
    smuggled = POST % (b"/body", b"Content-Length: 1") + b"x"
    more = b"Connection: Upgrade\r\nUpgrade: h2c\r\nContent-Length: %d" % len(smuggled)
    connection.sendall(POST % (b"/body", more))
    connection.sendall(smuggled)
    [(status, headers, _)] = answers(until_it_ends(connection))
    assert (status, headers["connection"]) == (200, "close")
    assert not caplog.records


# Places --------------------------------------------------------------------------------------------------------------


def asking(address, source="127.0.0.1", path=b"/", said=b"", more=b""):
    """The answer on a connection of its own, from an address of its own."""
    with socket.create_connection(address, timeout=30, source_address=(source, 0)) as connection:
        connection.sendall(said or b"GET %b HTTP/1.1\r\nHost: a\r\nConnection: close\r\n%b\r\n" % (path, more))
        return answers(until_it_ends(connection))


@pytest.fixture
def holding():
    """Connections that say nothing, from an address; they are closed in the end."""
    with contextlib.ExitStack() as stack:

        def hold(address, source):
            return stack.enter_context(socket.create_connection(address, timeout=30, source_address=(source, 0)))

        yield hold


def test_one_client_does_not_take_all_places(served, monkeypatch, counted, holding):
    monkeypatch.setattr(entrance, "SPARE_OF_ONE", 0)
    settings = Settings(sockets_per_client=2, proxies="127.0.0.4")
    counted("gainscope_refusals_total", reason="connections")
    with served(made(settings), settings) as address:
        first, _ = holding(address, "127.0.0.2"), holding(address, "127.0.0.2")
        [answer] = asking(address, "127.0.0.2")
        refused(answer, 503, "connections")
        assert answer[1]["retry-after"] == "5"
        refused(asking(address, "127.0.0.2", said=OPEN)[0], 503, "connections")
        assert counted("gainscope_refusals_total", reason="connections") == 2
        # Who looks whether the server lives is answered, and so are others, and a proxy, whose connections are many's.
        assert asking(address, "127.0.0.2", b"/livez")[0][0] == 200
        assert asking(address, "127.0.0.3")[0][0] == 200
        for _ in range(4):
            holding(address, "127.0.0.4")
        assert asking(address, "127.0.0.4")[0][0] == 200
        first.close()
        asyncio.run(eventually(lambda: asking(address, "127.0.0.2")[0][0] == 200))


def test_when_all_places_are_taken_it_still_says_whether_it_lives(served, monkeypatch, holding):
    monkeypatch.setattr(entrance, "SPARE", 0)
    settings = Settings(sockets=3, proxies="127.0.0.4")
    with served(made(settings), settings) as address:
        for source in ("127.0.0.2", "127.0.0.3", "127.0.0.4"):
            holding(address, source)
        for source in ("127.0.0.4", "127.0.0.5"):
            refused(asking(address, source)[0], 503, "connections")
            assert asking(address, source, b"/livez")[0][0] == 200
        refused(asking(address, "127.0.0.4", b"/livez", more=b"X-Forwarded-For: 192.0.2.1\r\n")[0], 503, "connections")


def test_who_comes_even_then_is_not_heard(served, monkeypatch, counted, holding):
    for name, most in (("SPARE_OF_ONE", 0), ("EXTRA_OF_ONE", 1)):
        monkeypatch.setattr(entrance, name, most)
    monkeypatch.setattr(Entrance, "spares", lambda self, peer: False)
    settings = Settings(sockets_per_client=1)
    counted("gainscope_refusals_total", reason="connections")
    with served(made(settings), settings) as address:
        for _ in range(2):
            holding(address, "127.0.0.2")
        with holding(address, "127.0.0.2") as third:
            assert until_it_ends(third) == b""
        assert counted("gainscope_refusals_total", reason="connections") == 1
        assert asking(address, "127.0.0.3")[0][0] == 200
