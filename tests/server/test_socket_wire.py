"""What a socket says and takes, over a network: no more is kept of it than is heard, and nothing is lost."""

import asyncio
import socket
import struct
import threading

import pytest
from fastapi import WebSocket

from server import channel, guard
from server.limits import Rate
from server.settings import Settings
from server.socket_wire import BITE, MOST_PARTS, Socket
from tests.serving import plain
from tests.waiting import eventually

SETTINGS = Settings(requests_per_second=1e6, requests_at_once=1_000_000)
TEXT, BINARY, CLOSE, PING, PONG, CONTINUED = 0x1, 0x2, 0x8, 0x9, 0xA, 0x0
LARGE = 64_000_000
"""Bytes that no system keeps for a client that takes nothing."""

OPEN = (
    b"GET /%b HTTP/1.1\r\nHost: a\r\nOrigin: http://a\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)

MAY_HEAR = threading.Event()
HEARD: list[str] = []
TAKEN: list[int] = []


def made():
    app = plain()

    @app.websocket("/echo")
    async def echo(websocket: WebSocket):
        await websocket.accept()
        async for text in websocket.iter_text():
            await websocket.send_text(text)

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

    guard.attach(app, SETTINGS)
    return app


@pytest.fixture(scope="module")
def address(served):
    with served(made(), SETTINGS) as found:
        yield found


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

    def open_one(path):
        connection = socket.create_connection(address, timeout=30)
        connections.append(connection)
        connection.sendall(OPEN % path)
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
    """Say the same again and again until the server reads no more; bytes that were said."""
    connection.settimeout(1)
    sent = 0
    try:
        while sent < most:
            sent += connection.send(said)
    except TimeoutError:
        return sent
    raise AssertionError("it was all read")


def test_what_is_said_at_once_is_heard_in_its_order(opened):
    connection = opened(b"echo")
    texts = [b"%d" % number * (number % 50) for number in range(3000)]
    threading.Thread(target=connection.sendall, args=(b"".join(frame(TEXT, text) for text in texts),)).start()
    said = frames(connection)
    assert [next(said) for _ in texts] == [(TEXT, text) for text in texts]


def test_the_longest_message_is_heard_whole(opened):
    connection = opened(b"echo")
    text = b"0123456789" * 6_553
    assert len(text) > 15 * BITE
    connection.sendall(frame(TEXT, text))
    assert heard(connection) == text


def test_no_more_is_kept_than_is_heard(opened, sockets):
    """The rest waits in the network, and is heard later."""
    connection = opened(b"slow")
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
    connection = opened(b"echo")
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
    connection = opened(b"large")
    read(connection, 1_000)
    assert TAKEN == []
    read(connection, LARGE)
    asyncio.run(eventually(lambda: TAKEN == [LARGE]))


@pytest.mark.parametrize("said", [b"", b"x"])
def test_a_message_has_so_many_parts(opened, said):
    parts = [frame(TEXT, said, is_last=False), *[frame(CONTINUED, said, is_last=False)] * (MOST_PARTS - 2)]
    connection = opened(b"echo")
    connection.sendall(b"".join(parts) + frame(CONTINUED, said))
    assert heard(connection) == said * MOST_PARTS
    connection = opened(b"echo")
    connection.sendall(b"".join(parts) + frame(CONTINUED, said, is_last=False) * 2_000 + frame(CONTINUED, said))
    [(kind, why)] = frames(connection)
    assert (kind, int.from_bytes(why[:2], "big")) == (CLOSE, 1009)


def test_what_was_said_before_it_was_closed_is_heard(opened):
    """Both sides may close it while the other one still speaks."""
    connection = opened(b"echo")
    connection.sendall(b"".join(frame(TEXT, b"%d" % number) for number in range(2000)) + frame(CLOSE))
    said = list(frames(connection))
    assert said[-1][0] == CLOSE
    assert [text for kind, text in said if kind == TEXT] == [b"%d" % number for number in range(len(said) - 1)]


def test_the_end_of_a_client_ends_it(opened, sockets):
    connection = opened(b"slow")
    connection.sendall(frame(TEXT, b"a") * 5_000)
    asyncio.run(eventually(lambda: sockets and sockets[0].read_paused))
    connection.close()
    MAY_HEAR.set()
    asyncio.run(eventually(lambda: sockets[0].disconnected))
