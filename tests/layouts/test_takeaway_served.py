"""Exports over a real connection: many at once, clients that leave or take nothing, files that cannot be made."""

import asyncio
import contextlib
import dataclasses
import socket
import threading
import time

import httpx
import pytest
import uvicorn
from fastapi import FastAPI

from layouts import outgoing, takeaway
from layouts.files import SUM, Store
from layouts.outgoing import STEP
from layouts.uploads import Uploads
from server import metrics
from server.work import Work
from tests.serving import on_a_port
from tests.waiting import eventually
from tracker_core import measured

LINK = "/export/track.csv?samples=2000&order=4&xi=0.8"
TEXT = b"t,x,y\n" + b"".join(b"%d,%d,%d\n" % (row, 3 * row, row * row) for row in range(50))
LARGE = bytes(range(256)) * (8 * STEP // 256)
"""More than the network keeps for a client that takes nothing."""
WAIT = 60


@pytest.fixture
def serve(tmp_path, monkeypatch):
    """Starts a server on a port, with its exports and its uploads; gives its address."""
    store = Store(tmp_path, most_bytes=1_000_000, longest_age_days=30)
    monkeypatch.setattr(measured, "_sources", [store.fetch])
    stack = contextlib.ExitStack()

    def start(**limits):
        app = FastAPI()
        Uploads(store).attach(app)
        takeaway.attach(app, Work(**limits), tmp_path)
        config = uvicorn.Config(
            app, host="127.0.0.1", port=0, log_level="critical", lifespan="off", timeout_graceful_shutdown=1
        )
        return stack.enter_context(on_a_port(config))

    with stack:
        yield start


@pytest.fixture
def exporting(monkeypatch):
    """Let the track be written by a function of the test's own."""

    def replace(write):
        export = takeaway.EXPORTS["track.csv"]
        own = dataclasses.replace(export, write=lambda result, stream, link: write(stream))
        monkeypatch.setitem(takeaway.EXPORTS, "track.csv", own)

    return replace


def client_of(address):
    return httpx.AsyncClient(base_url=f"http://{address[0]}:{address[1]}", timeout=WAIT)


def get(address, link=LINK):
    return httpx.get(f"http://{address[0]}:{address[1]}{link}", timeout=WAIT)


def asked(address):
    """A connection on which an export has been asked for, and nothing read."""
    connection = socket.create_connection(address, timeout=WAIT)
    connection.sendall(f"GET {LINK} HTTP/1.1\r\nHost: {address[0]}\r\n\r\n".encode())
    return connection


def under_way():
    return metrics.REGISTRY.get_sample_value("gainscope_exports")


def endless(began, ended):
    """Writes until nobody wants it any more."""

    def write(stream):
        began.set()
        try:
            while True:
                stream.write(b"x")
                time.sleep(0.001)
        finally:
            ended.set()

    return write


def test_many_at_once_arrive_whole_while_files_come_in_and_go_out(serve, exporting):
    going_on = threading.Event()

    def write(stream):
        stream.write(LARGE[:STEP])
        going_on.wait(WAIT)
        stream.write(LARGE[STEP:])

    exporting(write)
    address = serve()

    async def run():
        async with client_of(address) as client:
            several = [asyncio.ensure_future(client.get(LINK)) for _ in range(12)]
            await eventually(lambda: under_way() == 12)
            kept = await client.put("/recordings?name=log.csv&keep=store", content=TEXT)
            back = await client.get(f"/recordings/{kept.json()['data']}")
            assert not any(one.done() for one in several)
            going_on.set()
            return kept, back, await asyncio.gather(*several)

    kept, back, several = asyncio.run(run())
    assert (kept.status_code, back.content) == (200, TEXT)
    assert [one.status_code for one in several] == [200] * 12
    assert all(one.content == LARGE for one in several)


def test_clients_that_take_nothing_stop_no_maker(serve, exporting):
    exporting(lambda stream: stream.write(LARGE))
    address = serve()
    slow = [asked(address) for _ in range(takeaway.AT_ONCE + 2)]
    for connection in slow:
        assert connection.recv(1000).startswith(b"HTTP/1.1 200")
    assert get(address).content == LARGE
    for connection in slow:
        connection.close()
    asyncio.run(eventually(lambda: under_way() == 0))


def test_a_client_that_takes_nothing_loses_its_place(serve, exporting, monkeypatch):
    monkeypatch.setattr(outgoing, "LONGEST", 0.2)
    monkeypatch.setattr(takeaway, "MOST_BYTES", 20 * STEP)
    exporting(lambda stream: stream.write(LARGE))
    address = serve()
    with asked(address) as connection:
        assert connection.recv(1000).startswith(b"HTTP/1.1 200")
        # Two would be more than one client may have.
        asyncio.run(eventually(lambda: get(address).status_code == 200))


def test_what_finds_no_room_is_to_be_asked_for_later(serve, exporting, monkeypatch):
    monkeypatch.setattr(takeaway, "MOST_BYTES", 20 * STEP)
    exporting(lambda stream: stream.write(LARGE))
    address = serve()
    with asked(address) as connection:
        assert connection.recv(1000).startswith(b"HTTP/1.1 200")
        answer = get(address)
        assert (answer.status_code, answer.json()["field"], answer.headers["retry-after"]) == (503, "export", "5")
    asyncio.run(eventually(lambda: get(address).status_code == 200))


def test_a_client_that_leaves_while_it_waits_ends_the_making(serve, exporting, monkeypatch):
    monkeypatch.setattr(takeaway, "LOOKED_AFTER", 0.02)
    began, ended = threading.Event(), threading.Event()
    exporting(endless(began, ended))
    with asked(serve()):
        assert began.wait(WAIT)
        assert not ended.is_set()
    assert ended.wait(WAIT)
    asyncio.run(eventually(lambda: under_way() == 0))


def test_a_client_that_leaves_the_line_is_not_written_for(serve, exporting, monkeypatch):
    monkeypatch.setattr(takeaway, "LOOKED_AFTER", 0.02)
    going_on, written = threading.Event(), []

    def write(stream):
        written.append(stream)
        going_on.wait(WAIT)
        stream.write(b"made")

    exporting(write)
    address = serve()
    makers = [asked(address) for _ in range(takeaway.AT_ONCE)]
    asyncio.run(eventually(lambda: len(written) == takeaway.AT_ONCE))
    gone = asked(address)
    asyncio.run(eventually(lambda: under_way() == takeaway.AT_ONCE + 1))
    gone.close()
    asyncio.run(eventually(lambda: under_way() == takeaway.AT_ONCE))
    going_on.set()
    for connection in makers:
        assert connection.recv(1000).startswith(b"HTTP/1.1 200")
        connection.close()
    assert get(address).content == b"made"
    assert len(written) == takeaway.AT_ONCE + 1


def test_what_takes_too_long_to_make_is_given_up_and_its_maker_stops(serve, exporting):
    began, ended = threading.Event(), threading.Event()
    exporting(endless(began, ended))
    answer = get(serve(seconds=0.2))
    assert (answer.status_code, answer.json()["message"]) == (504, "it has tried for 0.2 s")
    assert ended.wait(WAIT)


def test_a_file_that_fails_while_it_is_made_is_no_file(serve, exporting):
    def write(stream):
        stream.write(LARGE)
        raise ZeroDivisionError

    exporting(write)
    assert get(serve()).status_code == 500


def test_a_file_on_its_way_has_no_name_that_could_be_left(serve, exporting, tmp_path):
    exporting(lambda stream: stream.write(LARGE))
    address = serve()
    with asked(address) as connection:
        assert connection.recv(1000).startswith(b"HTTP/1.1 200")
        assert [path.name for path in tmp_path.iterdir()] == [SUM]
