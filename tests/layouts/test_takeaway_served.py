"""Exports over a real connection: many at once, clients that leave or take nothing, files that fail on their way."""

import asyncio
import dataclasses
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest
import uvicorn
from fastapi import FastAPI

from layouts import pipe, takeaway
from layouts.files import Store
from layouts.pipe import PIECE, piped
from layouts.uploads import Uploads
from tracker_core import measured

LINK = "/export/track.csv?samples=2000&order=4&xi=0.8"
TEXT = b"t,x,y\n" + b"".join(b"%d,%d,%d\n" % (row, 3 * row, row * row) for row in range(50))
WAIT = 60


@pytest.fixture
def address(tmp_path, monkeypatch):
    """A server on a port, with its exports and its uploads."""
    store = Store(tmp_path, most_bytes=1_000_000, longest_age_days=30)
    monkeypatch.setattr(measured, "_sources", [store.fetch])
    app = FastAPI()
    Uploads(store).attach(app)
    takeaway.attach(app)
    server = uvicorn.Server(
        uvicorn.Config(app, host="127.0.0.1", port=0, log_level="critical", lifespan="off", timeout_graceful_shutdown=1)
    )
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    yield server.servers[0].sockets[0].getsockname()
    server.should_exit = True
    thread.join()


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


def asked(address):
    """A connection on which an export has been asked for, and nothing read."""
    connection = socket.create_connection(address, timeout=WAIT)
    connection.sendall(f"GET {LINK} HTTP/1.1\r\nHost: {address[0]}\r\n\r\n".encode())
    return connection


def free(address):
    """Wait until there is a place again: the link is wrong, so that nothing is made."""
    until = time.monotonic() + WAIT
    while time.monotonic() < until:
        status = httpx.get(f"http://{address[0]}:{address[1]}/export/track.csv?xi=2", timeout=WAIT).status_code
        if status == 422:
            return True
        assert status == 503
        time.sleep(0.05)
    return False


def endless(began, ended):
    def write(stream):
        began.set()
        try:
            while True:
                stream.write(bytes(PIECE))
        finally:
            ended.set()

    return write


def test_many_at_once_arrive_whole_while_files_come_in_and_go_out(address, exporting):
    content, going_on = bytes(range(256)) * 5000, threading.Event()

    def write(stream):
        stream.write(content[:PIECE])
        going_on.wait(WAIT)
        stream.write(content[PIECE:])

    exporting(write)

    async def run():
        async with client_of(address) as client:
            several = [asyncio.ensure_future(client.get(LINK)) for _ in range(12)]
            await asyncio.sleep(0.5)
            kept = await client.put("/recordings?name=log.csv&keep=store", content=TEXT)
            back = await client.get(f"/recordings/{kept.json()['data']}")
            assert not any(one.done() for one in several)
            going_on.set()
            return kept, back, await asyncio.gather(*several)

    kept, back, several = asyncio.run(run())
    assert (kept.status_code, back.content) == (200, TEXT)
    assert [one.status_code for one in several] == [200] * 12
    assert all(one.content == content for one in several)


def test_places_are_counted_before_anything_is_read(address, monkeypatch):
    monkeypatch.setattr(takeaway, "MOST_WAITING", 3)

    async def run():
        async with client_of(address) as client:
            return await asyncio.gather(*[client.get(LINK) for _ in range(12)])

    counts = [one.status_code for one in asyncio.run(run())]
    assert counts.count(200) >= 3
    assert counts.count(503) >= 1
    assert free(address)


def test_a_client_that_leaves_while_it_is_sent_to_frees_its_place_and_stops_the_maker(address, exporting, monkeypatch):
    monkeypatch.setattr(takeaway, "MOST_WAITING", 1)
    began, ended = threading.Event(), threading.Event()
    exporting(endless(began, ended))
    with asked(address) as connection:
        assert connection.recv(1000).startswith(b"HTTP/1.1 200")
        assert not ended.is_set()
    assert ended.wait(WAIT)
    assert free(address)


def test_a_client_that_leaves_while_it_waits_is_not_written_for(address, exporting, monkeypatch):
    monkeypatch.setattr(takeaway, "MOST_WAITING", takeaway.AT_ONCE + 1)
    going_on, written = threading.Event(), []

    def write(stream):
        written.append(stream)
        going_on.wait(WAIT)

    exporting(write)
    makers = [asked(address) for _ in range(takeaway.AT_ONCE)]
    until = time.monotonic() + WAIT
    while len(written) < takeaway.AT_ONCE and time.monotonic() < until:
        time.sleep(0.01)
    asked(address).close()
    assert free(address)
    going_on.set()
    for connection in makers:
        assert connection.recv(1000).startswith(b"HTTP/1.1 200")
        connection.close()
    assert len(written) == takeaway.AT_ONCE


def test_a_client_that_takes_nothing_loses_its_place(address, exporting, monkeypatch):
    monkeypatch.setattr(takeaway, "MOST_WAITING", 1)
    monkeypatch.setattr(takeaway, "STALLED", 0.2)
    began, ended = threading.Event(), threading.Event()
    exporting(endless(began, ended))
    with asked(address):
        assert began.wait(WAIT)
        assert ended.wait(WAIT)
        assert free(address)


def test_a_file_that_fails_on_its_way_does_not_look_complete(address, exporting):
    def write(stream):
        stream.write(bytes(3 * PIECE))
        raise ZeroDivisionError

    exporting(write)
    with pytest.raises(httpx.RemoteProtocolError, match="incomplete"):
        httpx.get(f"http://{address[0]}:{address[1]}{LINK}", timeout=WAIT)


def test_who_goes_on_after_the_maker_gave_up_hears_of_it(monkeypatch):
    monkeypatch.setattr(pipe, "STALLED", 0.02)
    ended = threading.Event()

    async def run():
        pieces = piped(pool, endless(threading.Event(), ended))
        try:
            await pieces.opened()
            # The only thread is free again once the maker has given up.
            await asyncio.get_running_loop().run_in_executor(pool, ended.wait, WAIT)
            assert ended.is_set()
            async with asyncio.timeout(WAIT):
                return [piece async for piece in pieces]
        finally:
            pieces.leave()

    with ThreadPoolExecutor(1) as pool, pytest.raises(BrokenPipeError):
        asyncio.run(run())
