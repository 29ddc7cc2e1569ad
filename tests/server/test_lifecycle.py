"""From the start to the end of a server: a process of its own that is told to stop while much is going on."""

from __future__ import annotations

import asyncio
import contextlib
import json
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

from server.lifecycle import Life, config_of
from server.settings import Settings

ROOT = Path(__file__).parents[2]

SCRIPT = """
import asyncio, sys, threading, time
from fastapi import FastAPI, WebSocket
from server import lifecycle, logs
from server.settings import Settings

lifecycle.leave_at_once_until_served()
logs.start("text", "info")
port, drain, how = int(sys.argv[1]), float(sys.argv[2]), sys.argv[3]
app, life = FastAPI(), lifecycle.Life()
life.attach(app)

@app.get("/slow")
async def slow():
    await asyncio.sleep(2)
    return "answered"

@app.get("/stuck")
async def stuck():
    await asyncio.to_thread(time.sleep, 600)

@app.websocket("/socket")
async def talk(websocket: WebSocket):
    await websocket.accept()
    async for text in websocket.iter_text():
        await websocket.send_text(text)

@app.websocket("/slow")
async def slow_to_open(websocket: WebSocket):
    await asyncio.sleep(2)
    await websocket.accept()
    await websocket.receive()

@app.websocket("/never")
async def never(websocket: WebSocket):
    await asyncio.sleep(600)

life.at_stop(lambda: print("ended first", flush=True))
life.at_stop(lambda: 1 / 0)
if how == "hanging":
    lifecycle.LONGEST = 3.0
    life.at_stop(lambda: time.sleep(600))
life.reach("ready")
settings = Settings(port=port, drain_seconds=drain)
if how == "guarded":
    from server import guard
    guard.attach(app, settings)
lifecycle.Server(lifecycle.config_of(settings, app), life, drain).run()
print("left", flush=True)
"""


@pytest.fixture
def port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


@pytest.fixture
def serve(port):
    """A server in a process of its own; `told` is what it has printed at the end."""

    @contextlib.contextmanager
    def started(drain="0", how=""):
        process = subprocess.Popen(
            [sys.executable, "-c", SCRIPT, str(port), drain, how],
            cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8",
        )  # fmt: skip
        try:
            while True:
                with contextlib.suppress(httpx.TransportError):
                    httpx.get(f"http://127.0.0.1:{port}/livez")
                    break
                assert process.poll() is None, process.communicate()[0]
                time.sleep(0.05)
            yield process
        finally:
            process.kill()
            process.communicate()

    return started


async def asked(port, path):
    async with httpx.AsyncClient(timeout=60) as client:
        return await client.get(f"http://127.0.0.1:{port}{path}")


def wanted(port, path):
    """A socket that is opened."""
    origin = Origin(f"http://127.0.0.1:{port}")
    return connect(f"ws://127.0.0.1:{port}{path}", origin=origin, proxy=None, open_timeout=30)


def unopened(port, path):
    """What is answered in the place of a socket."""
    with pytest.raises(InvalidStatus) as refused:
        wanted(port, path)
    return refused.value.response


def test_told_to_stop_it_answers_closes_and_leaves(serve, port):
    """A request in flight is answered, a socket told why it is closed, and a thread that computes is not waited for."""

    async def all_at_once(process):
        slow, stuck = asyncio.create_task(asked(port, "/slow")), asyncio.create_task(asked(port, "/stuck"))
        never = asyncio.create_task(asyncio.to_thread(unopened, port, "/never"))
        late = asyncio.create_task(asyncio.to_thread(wanted, port, "/slow"))
        talking = await asyncio.to_thread(wanted, port, "/socket")
        await asyncio.to_thread(talking.send, "there")
        assert await asyncio.to_thread(talking.recv) == "there"
        assert (await asked(port, "/readyz")).json() == {"status": "ready"}
        process.send_signal(signal.SIGTERM)
        # It still takes requests, so that whoever sends them hears that it is not ready any more.
        ready = await asked(port, "/readyz")
        assert (ready.status_code, ready.json()) == (503, {"status": "stopping"})
        assert (await asked(port, "/livez")).status_code == 200
        answer = await slow
        assert (answer.status_code, answer.json()) == (200, "answered")
        # So is a socket that was not open yet.
        for open_one in (talking, await late):
            with pytest.raises(ConnectionClosed) as closed:
                await asyncio.to_thread(open_one.recv, 30)
            assert closed.value.rcvd.code == 1012
        # What cannot be answered in time is refused as everything is.
        for given_up in (await stuck, await never):
            assert given_up.status_code == 503
            body = given_up.content if isinstance(given_up, httpx.Response) else given_up.body
            assert json.loads(body)["request"] == given_up.headers["x-request-id"]

    with serve(drain="1", how="guarded") as process:
        asyncio.run(all_at_once(process))
        assert process.wait(timeout=30) == 0
        with pytest.raises(httpx.TransportError):
            httpx.get(f"http://127.0.0.1:{port}/livez")
        said = process.stdout.read()
    assert "ended first" in said
    assert said.count("Traceback") == 1
    assert said.index("ZeroDivisionError") < said.index("ended first")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_server_with_nothing_to_do_leaves_by_the_door(serve, number):
    with serve() as process:
        process.send_signal(number)
        assert process.wait(timeout=30) == 0
        assert process.stdout.read().endswith("left\n")


def test_what_hangs_at_the_end_does_not_keep_it(serve):
    with serve(how="hanging") as process:
        process.send_signal(signal.SIGTERM)
        assert process.wait(timeout=60) == 1
        assert "did not stop in time" in process.stdout.read()


def test_told_twice_it_is_gone(serve, port):
    with serve(drain="5") as process:
        process.send_signal(signal.SIGTERM)
        while httpx.get(f"http://127.0.0.1:{port}/readyz").status_code == 200:
            time.sleep(0.02)
        process.send_signal(signal.SIGTERM)
        assert process.wait(timeout=30) == 128 + signal.SIGTERM


def test_life_goes_on_and_never_back():
    life = Life()
    seen = [life.state]
    for state in ("compiling", "starting", "ready", "compiling"):
        life.reach(state)
        seen.append(life.state)
    assert seen == ["starting", "compiling", "compiling", "ready", "ready"]
    life.stop()
    life.reach("ready")
    assert life.state == "stopping"


def test_what_is_registered_is_ended_once_and_the_last_first():
    life, ended = Life(), []
    for name in "abc":
        life.at_stop(lambda name=name: ended.append(name))
    life.end()
    life.end()
    assert ended == ["c", "b", "a"]


def test_proxies_are_left_to_the_guard():
    config = config_of(Settings(proxies="10.0.0.0/8"), FastAPI())
    config.load()
    assert isinstance(config.loaded_app, FastAPI)


@pytest.mark.parametrize("drain", [0.0, 1.0, 5.0])
def test_there_is_time_for_requests_in_flight_before_the_process_is_ended(drain):
    config = config_of(Settings(drain_seconds=drain), FastAPI())
    assert config.timeout_graceful_shutdown >= 2
    assert drain + config.timeout_graceful_shutdown < 9
