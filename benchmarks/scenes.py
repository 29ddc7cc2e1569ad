"""From a picture that is shown to the frame that a browser receives, many browsers at a time, through the proxy.

A process of its own serves and moves the operating points; this one is all the browsers. Both read the same clock.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import secrets
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass

import uvicorn
from fastapi import FastAPI
from websockets.asyncio.client import ClientConnection

from benchmarks.scene_browser import View, decoded, scene
from benchmarks.serving import ROOT
from layouts.scenes import RegionPicture, Scenes

RATE = 25
MOVES = 200
STEP = 1 / 1024
"""Of alpha from one move to the next: the scene says by it which move it shows."""


@dataclass(frozen=True, slots=True)
class Moves:
    """How long each move took to arrive, ms, and how many frames came."""

    delays: list[float]
    frames: int


@contextlib.contextmanager
def serving(scenes: Scenes) -> Iterator[int]:
    """A server with nothing but scenes, in a thread; gives its port."""
    app = FastAPI()
    scenes.attach(app)
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        server = uvicorn.Server(uvicorn.Config(app, log_level="warning", timeout_graceful_shutdown=2))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, daemon=True)
        thread.start()
        while not server.started:
            time.sleep(0.01)
        try:
            yield listening.getsockname()[1]
        finally:
            server.should_exit = True
            thread.join()
            scenes.close()


def serve() -> None:
    """What the other process does: serve, and when told move the points and say when each move was made."""
    scenes = Scenes()
    with serving(scenes) as port:
        print(port, flush=True)
        tokens = json.loads(sys.stdin.readline())
        for token in tokens:
            scenes.show(token, RegionPicture((0.0, 1.0, 0.5), stable=True))
        print("shown", flush=True)
        sys.stdin.readline()
        print(json.dumps(_move(scenes, tokens)), flush=True)


def _move(scenes: Scenes, tokens: list[str]) -> list[list[float]]:
    """Move every point so many times a second, one after the other; when, of each."""
    moved: list[list[float]] = [[] for _ in tokens]
    pause = 1 / RATE / len(tokens)
    due = time.perf_counter()
    for move in range(1, MOVES + 1):
        for token, made in zip(tokens, moved, strict=True):
            due += pause
            time.sleep(max(0.0, due - time.perf_counter()))
            made.append(time.perf_counter())
            scenes.show(token, RegionPicture((move * STEP, 1.0, 0.5), stable=True))
    return moved


def measure(sessions: int) -> Moves:
    """Delays with so many sessions that all move."""
    command = [sys.executable, "-c", "from benchmarks.scenes import serve; serve()"]
    tokens = [secrets.token_hex(16) for _ in range(sessions)]
    with subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        outcome = asyncio.run(_watch(process, tokens))
        process.communicate()
    return outcome


async def _watch(process: subprocess.Popen[str], tokens: list[str]) -> Moves:
    told, said = process.stdin, process.stdout
    assert told is not None
    assert said is not None

    async def ask(line: str) -> str:
        told.write(f"{line}\n")
        told.flush()
        return await asyncio.to_thread(said.readline)

    port = int(said.readline())
    await ask(json.dumps(tokens))
    async with contextlib.AsyncExitStack() as stack:
        sockets = [await stack.enter_async_context(scene(port, token)) for token in tokens]
        for browser in sockets:
            await View().until(browser, lambda view: "/gains" in view.nodes)
        arrived: list[list[tuple[float, bytes]]] = [[] for _ in tokens]
        readers = [asyncio.create_task(_read(*pair)) for pair in zip(sockets, arrived, strict=True)]
        moved = json.loads(await ask("move"))
        await asyncio.sleep(1)
        for reader in readers:
            reader.cancel()
    drawn = sum(map(len, arrived))
    return Moves([delay for pair in zip(moved, arrived, strict=True) for delay in _delays(*pair)], drawn)


async def _read(browser: ClientConnection, arrived: list[tuple[float, bytes]]) -> None:
    while True:
        frame = await browser.recv()
        assert isinstance(frame, bytes)
        arrived.append((time.perf_counter(), frame))


def _delays(moved: list[float], arrived: list[tuple[float, bytes]]) -> Iterator[float]:
    """From each move to its arrival, ms; one that was skipped waits until a newer one arrives."""
    seen = 0
    for when, frame in arrived:
        for message in decoded(frame):
            if message["type"] == "SceneNodeUpdateMessage" and message["name"] == "/gains":
                # The axis of alpha goes from 0 to 2 over a length of 1, its middle at zero; first is the ball's top.
                move = round((float(message["updates"]["vertices"][0]) + 0.5) * 2 / STEP)
                yield from ((when - made) * 1e3 for made in moved[seen:move])
                seen = move
    if seen < len(moved):
        raise RuntimeError("the last move did not arrive")
