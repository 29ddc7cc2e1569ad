"""What a socket says and takes, over a network: no more is kept of it than is heard, and nothing is lost."""

import asyncio
import socket
import struct
import threading
import time

import pytest
from fastapi import Response, WebSocket

from server import channel, entrance, guard, socket_wire
from server.limits import Rate
from server.settings import Settings
from server.socket_wire import BITE, MOST_PARTS, Socket
from server.wire import Wire
from tests.leaving import there, without_the_collector
from tests.serving import echo_at, opening, plain
from tests.waiting import eventually

SETTINGS = Settings(requests_per_second=1e6, requests_at_once=1_000_000)
TEXT, BINARY, CLOSE, PING, PONG, CONTINUED = 0x1, 0x2, 0x8, 0x9, 0xA, 0x0
KEPT = {"Wire", "HttpRequestParser", "Socket", "ServerProtocol"}
"""What a connection is made of here, by the names of their types."""

LARGE = 64_000_000
"""Bytes that no system keeps for a client that takes nothing."""

MAY_HEAR = threading.Event()
HEARD: list[str] = []
TAKEN: list[int] = []


def made():
    app = plain()

    echo_at(app, "/echo")

    @app.websocket("/slow")
    async def slow(websocket: WebSocket):
        """Hears when it may."""
        await websocket.accept()
        await asyncio.to_thread(MAY_HEAR.wait)
        while True:
            HEARD.append(await websocket.receive_text())

    @app.websocket("/large")
    async def large(websocket: WebSocket):
        await websocket.accept()
        while True:
            await websocket.send_bytes(bytes(LARGE))
            TAKEN.append(LARGE)

    @app.websocket("/refuses")
    async def refuses(websocket: WebSocket):
        await websocket.accept()
        await websocket.receive_text()
        await websocket.close(1003)

    @app.get("/some")
    async def some():
        return Response(bytes(60_000))

    guard.attach(app, SETTINGS)
    return app


def paced(served, asides):
    """An application on a port, which reads what is no message at some rate."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(entrance, "ASIDES", asides)
        return served(made(), SETTINGS)


@pytest.fixture(scope="module")
def address(served):
    with paced(served, Rate(1e9, 1e9)) as found:
        yield found


class Counting:
    """A method that counts how often it is called."""

    def __init__(self, method):
        self.method, self.calls = method, 0

    def __get__(self, instance, owner):
        def call():
            self.calls += 1
            return self.method(instance)

        return call


@pytest.fixture
def sockets(monkeypatch):
    """The server's ends of what is opened."""
    found = []
    usual = Socket.connection_made
    monkeypatch.setattr(Socket, "connection_made", lambda self, transport: (found.append(self), usual(self, transport)))
    return found


@pytest.fixture
def opened(address, monkeypatch):
    """Opens a socket, of which every byte may be said."""
    monkeypatch.setattr(channel, "PACE", Rate(1e9, 1e9))
    monkeypatch.setattr(channel, "PACE_OF_ALL", Rate(1e9, 1e9))
    MAY_HEAR.clear()
    HEARD.clear()
    connections = []

    def open_one(path, at=address):
        connection = socket.create_connection(at, timeout=30)
        connections.append(connection)
        connection.sendall(opening(path))
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += connection.recv(1)
        assert head.startswith(b"HTTP/1.1 101 ")
        return connection

    yield open_one
    MAY_HEAR.set()
    for connection in connections:
        connection.close()


def frame(kind, said=b"", *, is_last=True):
    """A frame as a client sends it, under a mask that changes nothing."""
    size = len(said)
    length = bytes([0x80 | size]) if size < 126 else bytes([0x80 | 126]) + struct.pack("!H", size)
    return bytes([0x80 * is_last | kind]) + length + bytes(4) + said


def read(connection, size):
    parts = b""
    while len(parts) < size:
        part = connection.recv(size - len(parts))
        assert part, "it was closed"
        parts += part
    return parts


def frames(connection):
    """What the server says, frame by frame, until it closes the connection."""
    while head := connection.recv(1):
        [size] = read(connection, 1)
        if size >= 126:
            size = int.from_bytes(read(connection, 2 if size == 126 else 8), "big")
        yield head[0] & 0xF, read(connection, size)


def heard(connection):
    return next(said for kind, said in frames(connection) if kind == TEXT)


def send_until_it_waits(connection, said, most):
    """Say the same again and again until the server reads no more for a second; bytes that were said."""
    connection.settimeout(1)
    sent = 0
    try:
        while sent < most:
            sent += connection.send(said)
    except TimeoutError:
        return sent
    raise AssertionError("it was all read")


def test_what_is_said_at_once_is_heard_in_its_order(opened):
    connection = opened(b"/echo")
    texts = [b"%d" % number * (number % 50) for number in range(3000)]
    threading.Thread(target=connection.sendall, args=(b"".join(frame(TEXT, text) for text in texts),)).start()
    said = frames(connection)
    assert [next(said) for _ in texts] == [(TEXT, text) for text in texts]


def test_the_longest_message_is_heard_whole(opened):
    connection = opened(b"/echo")
    text = b"0123456789" * 6_553
    assert len(text) > 15 * BITE
    connection.sendall(frame(TEXT, text))
    assert heard(connection) == text


def test_no_more_is_kept_than_is_heard(opened, sockets):
    """The rest waits in the network, and is heard later."""
    connection = opened(b"/slow")
    small, large = frame(TEXT, b"a"), frame(TEXT, b"b" * 5_000)
    connection.sendall(small * 10_000)
    sent = send_until_it_waits(connection, large, LARGE)
    [server] = sockets
    assert 0 < server.queue.qsize() <= BITE // len(small) + 1
    assert len(server._unread) <= 1_000_000
    MAY_HEAR.set()
    asyncio.run(eventually(lambda: len(HEARD) == 10_000 + sent // len(large)))
    assert [len(text) for text in HEARD] == [1] * 10_000 + [5_000] * (sent // len(large))


def test_who_takes_no_answer_is_heard_no_more(opened, sockets):
    """A ping is answered at once; whoever sends nothing else and takes nothing fills no memory."""
    connection = opened(b"/echo")
    said = frame(PING, b"x" * 125)
    sent = send_until_it_waits(connection, said * 500, LARGE)
    [server] = sockets
    assert not server.writable.is_set()
    assert server.transport.get_write_buffer_size() < 500_000
    # Once it takes what it is told, it is heard again.
    connection.settimeout(30)
    rest = said[sent % len(said) :] if sent % len(said) else b""
    threading.Thread(target=connection.sendall, args=(rest + frame(TEXT, b"and now"),)).start()
    assert heard(connection) == b"and now"


def test_an_answer_is_sent_once_it_is_taken(opened):
    connection = opened(b"/large")
    read(connection, 1_000)
    assert TAKEN == []
    read(connection, LARGE)
    asyncio.run(eventually(lambda: TAKEN == [LARGE]))


@pytest.mark.parametrize("said", [b"", b"x"])
def test_a_message_has_so_many_parts(opened, said):
    parts = [frame(TEXT, said, is_last=False), *[frame(CONTINUED, said, is_last=False)] * (MOST_PARTS - 2)]
    connection = opened(b"/echo")
    connection.sendall(b"".join(parts) + frame(CONTINUED, said))
    assert heard(connection) == said * MOST_PARTS
    connection = opened(b"/echo")
    connection.sendall(b"".join(parts) + frame(CONTINUED, said, is_last=False) * 2_000 + frame(CONTINUED, said))
    [(kind, why)] = frames(connection)
    assert (kind, int.from_bytes(why[:2], "big")) == (CLOSE, 1009)


def test_what_was_said_before_it_was_closed_is_heard(opened):
    """Both sides may close it while the other one still speaks."""
    connection = opened(b"/echo")
    connection.sendall(b"".join(frame(TEXT, b"%d" % number) for number in range(2000)) + frame(CLOSE))
    said = list(frames(connection))
    assert said[-1][0] == CLOSE
    assert [text for kind, text in said if kind == TEXT] == [b"%d" % number for number in range(len(said) - 1)]


def test_the_end_of_a_client_ends_it(opened, sockets):
    connection = opened(b"/slow")
    connection.sendall(frame(TEXT, b"a") * 5_000)
    asyncio.run(eventually(lambda: sockets and sockets[0].read_paused))
    connection.close()
    MAY_HEAR.set()
    asyncio.run(eventually(lambda: sockets[0].disconnected))


# What is no message --------------------------------------------------------------------------------------------------


def pings(said):
    return [frame(PING, b"%d" % number) for number in range(said)]


def pongs(said):
    return [frame(PONG)] * said


def parts(said):
    whole = [frame(TEXT, b"", is_last=False), *[frame(CONTINUED, b"", is_last=False)] * 98, frame(CONTINUED)]
    return whole * (said // len(whole))


@pytest.mark.parametrize("kind", [pings, pongs, parts])
def test_what_is_no_message_has_a_pace(opened, sockets, monkeypatch, served, kind):
    """All sockets of a client have it together, and in the meantime the rest waits; nothing is lost."""
    monkeypatch.setattr(socket_wire, "BITE", 256)
    rested = []
    usual = Socket._rested
    monkeypatch.setattr(Socket, "_rested", lambda self: (rested.append(self), usual(self)))
    with paced(served, Rate(1_000, 100)) as address:
        first, second = opened(b"/echo", address), opened(b"/echo", address)
        begun = time.monotonic()
        for connection in (first, second):
            connection.sendall(b"".join(kind(600)) + frame(TEXT, b"and now"))
        for connection in (first, second):
            while heard(connection) != b"and now":
                pass
        assert time.monotonic() - begun > 0.9
    assert set(rested) == set(sockets)


def test_a_pong_that_waits_behind_an_answer_is_none_that_does_not_come(opened, sockets, monkeypatch):
    """Whoever takes an answer slowly is there."""
    monkeypatch.setattr(Socket, "keepalive_timeout", counting := Counting(Socket.keepalive_timeout))
    connection = opened(b"/large")
    read(connection, 1_000)
    [server] = sockets
    server.ping_timeout = 0.05
    server.loop.call_soon_threadsafe(server.send_keepalive_ping)
    asyncio.run(eventually(lambda: counting.calls > 2))
    assert not server.close_sent


def test_who_does_not_answer_a_ping_is_gone(opened, sockets):
    connection = opened(b"/echo")
    [server] = sockets
    server.ping_timeout = 0.05
    server.loop.call_soon_threadsafe(server.send_keepalive_ping)
    said = list(frames(connection))
    assert [kind for kind, _ in said] == [PING, CLOSE]
    assert int.from_bytes(said[-1][1][:2], "big") == 1011


# Ends ----------------------------------------------------------------------------------------------------------------


def test_who_is_told_that_it_is_over_is_heard_no_better(opened, sockets):
    """While the server waits for the other side to close it too, what is answered has to be taken all the same."""
    connection = opened(b"/refuses")
    connection.sendall(frame(TEXT, b"no"))
    [server] = sockets
    asyncio.run(eventually(lambda: server.close_sent))
    send_until_it_waits(connection, frame(PING, b"x" * 125) * 500, LARGE)
    assert server.transport.get_write_buffer_size() < 500_000


def test_what_was_full_before_it_became_a_socket_is(address, sockets, monkeypatch):
    """Of answers before it nothing was taken, which the network says once and not to everybody who writes to it."""
    wires = []
    usual = Wire.connection_made
    monkeypatch.setattr(Wire, "connection_made", lambda self, transport: (wires.append(self), usual(self, transport)))
    with socket.create_connection(address, timeout=30) as connection:
        asyncio.run(eventually(lambda: wires))
        [before] = wires
        before.loop.call_soon_threadsafe(before.pause_writing)
        asyncio.run(eventually(lambda: before.flow.write_paused))
        connection.sendall(opening(b"/echo"))
        asyncio.run(eventually(lambda: sockets and not sockets[0].writable.is_set()))
        # Once it is taken, it is a socket like any other.
        before.loop.call_soon_threadsafe(sockets[0].resume_writing)
        assert connection.recv(65_536).startswith(b"HTTP/1.1 101 ")


def test_one_that_is_being_closed_holds_up_no_end(opened, sockets):
    """The server stops between the other side's word that it is over and the end of the connection."""
    connection = opened(b"/echo")
    [server] = sockets
    ended = []

    def end():
        server.data_received(frame(CLOSE))
        server.shutdown()
        ended.append(True)

    server.loop.call_soon_threadsafe(end)
    asyncio.run(eventually(lambda: ended))
    assert [kind for kind, _ in frames(connection)] == [CLOSE]


def test_why_it_ends_is_heard_whatever_is_on_its_way(opened):
    """A connection that is closed before all of it was read is reset, and what was said last is lost."""
    for _ in range(10):
        connection = opened(b"/echo")
        # A frame of no kind, and much behind it.
        connection.sendall(frame(0x3, b"x") + bytes(300_000))
        assert [(kind, said[:2]) for kind, said in frames(connection)] == [(CLOSE, (1002).to_bytes(2))]


def test_who_goes_on_once_it_is_over_is_cut_off(opened, monkeypatch):
    monkeypatch.setattr(socket_wire, "LET_PASS", 500_000)
    connection = opened(b"/echo")
    connection.sendall(frame(0x3, b"x"))
    assert next(frames(connection))[0] == CLOSE
    with pytest.raises(OSError, match="reset|pipe"):
        connection.sendall(bytes(200_000_000))


def test_what_is_over_ends_in_time(opened, sockets, monkeypatch):
    monkeypatch.setattr(socket_wire, "LINGER", 0.2)
    connection = opened(b"/echo")
    connection.sendall(frame(0x3, b"x"))
    asyncio.run(eventually(sockets[0].transport.is_closing))


@pytest.mark.parametrize("way", ["closed by both", "cut off"])
def test_a_socket_that_has_ended_is_not_left_for_the_collector(opened, way):
    """Some thirty values for each of hundreds in a minute, which the collector would find late."""

    async def look():
        async with without_the_collector(KEPT):
            for _ in range(3):
                connection = opened(b"/echo")
                assert there(KEPT) >= {"Socket", "ServerProtocol"}
                if way == "closed by both":
                    connection.sendall(frame(CLOSE, b"\x03\xe8"))
                    assert next(frames(connection))[0] == CLOSE
                connection.close()

    asyncio.run(look())


def test_what_a_client_breaks_is_no_mistake_of_ours(opened, caplog):
    """It breaks it while an answer to it is computed."""
    connection = opened(b"/echo")
    text = b"x" * (BITE - 8)
    connection.sendall(frame(TEXT, text) + b"\x83\x80" + bytes(4))
    assert len(frame(TEXT, text)) == BITE
    said = list(frames(connection))
    assert said[-1][0] == CLOSE
    assert [record for record in caplog.records if record.levelname == "ERROR"] == []
