"""Beginning and end of a server: how soon it is ready, and how it goes when it is told to."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import subprocess
import tempfile
import time
from collections.abc import AsyncIterator, Iterator

import orjson
import psutil
import uvloop

from benchmarks.serving import Running, running, start, wait_until_ready
from trials.crowd import crowd
from trials.report import Finding, at_most, none_of
from trials.wire import Answer, Client

COLD, WARM, EXIT = 10.0, 3.0, 10.0
"""Seconds: to be ready without and with compiled code, and to end."""

AT_ONCE = 0.25
"""Seconds after which it may no longer say that it is ready."""

LONG = "/export/track.json?samples=5000&seed={}"
"""What takes a while to be answered."""

ASKED = 2


def trial(short: bool = False) -> Iterator[Finding]:
    """Starts without and with compiled code, and an end in the middle of work."""
    with tempfile.TemporaryDirectory() as cache:
        yield at_most("ready, nothing compiled", _ready(cache), COLD, "s", timed=True)
        if not short:
            warm = min(_ready(cache) for _ in range(3))
            yield at_most("ready, all compiled", warm, WARM, "s", timed=True)
        with tempfile.TemporaryFile() as log, running(log, NUMBA_CACHE_DIR=cache) as it:
            yield from uvloop.run(_ended(it, users=3 if short else 30))


def _ready(cache: str) -> float:
    """Seconds until a server says that it is ready."""
    begun = time.perf_counter()
    with tempfile.TemporaryFile() as log:
        it = start(log, NUMBA_CACHE_DIR=cache)
    try:
        wait_until_ready(it, patience=300)
        seconds = time.perf_counter() - begun
        # What is compiled after that is to be there for the next.
        time.sleep(2)
        return seconds
    finally:
        it.process.terminate()
        it.process.wait()


async def _ended(it: Running, users: int) -> list[Finding]:
    """Tell it to end while it is busy."""
    server = psutil.Process(it.process.pid)
    async with crowd(it.port, users, pace=1, arrivals=users):
        clients = [Client(it.port, f"127.0.1.{1 + number}") for number in range(ASKED)]
        asked = [asyncio.create_task(client.ask("GET", LONG.format(n))) for n, client in enumerate(clients)]
        slow = Client(it.port, "127.0.1.100")
        sent = asyncio.create_task(slow.ask("PUT", "/recordings?name=slow.csv&keep=browser", _slowly()))
        await asyncio.sleep(0.2)
        # What came before a question that has been answered is under way.
        await Client(it.port).ask("GET", "/livez", headers={"Connection": "close"})
        children = server.children(recursive=True)
        begun = time.perf_counter()
        it.process.send_signal(signal.SIGTERM)
        await asyncio.sleep(AT_ONCE)
        still = [text for text in await _says_ready(it) if text]
        answers = await asyncio.gather(*asked, return_exceptions=True)
        (upload,) = await asyncio.gather(sent, return_exceptions=True)
        ended = await asyncio.to_thread(_wait, it, 3 * EXIT)
        seconds = time.perf_counter() - begun
        for client in (*clients, slow):
            await client.close()
    orphans = [child.name() for child in children if child.is_running()]
    return [
        none_of("told to end: says that it is ready", still, "every question afterwards"),
        none_of("told to end: exports under way that are not whole", filter(None, map(_broken, answers)), f"{ASKED}"),
        none_of("told to end: an upload under way that is not taken", filter(None, [_refused(upload)]), "1"),
        at_most("told to end: ended", seconds if ended else float("inf"), EXIT, "s"),
        none_of("told to end: processes that stay", orphans, f"{len(children)}"),
        Finding("told to end: exit", str(it.process.returncode), "0 or -15", it.process.returncode in (0, -15)),
    ]


async def _says_ready(it: Running) -> list[str]:
    """What it says whoever asks whether it is ready, as long as it runs."""
    said: list[str] = []
    client = Client(it.port)
    while it.process.poll() is None and len(said) < 20:
        with contextlib.suppress(OSError, EOFError, TimeoutError):
            answer = await client.ask("GET", "/readyz", patience=1)
            said.append("200" if answer.status == 200 else "")
        await client.close()
        await asyncio.sleep(0.05)
    return said


async def _slowly() -> AsyncIterator[bytes]:
    """A file that is a second and a half on its way."""
    yield b"t,x,y\n"
    for row in range(15):
        yield b"%d,%d,%d\n" % (row, 3 * row, row * row)
        await asyncio.sleep(0.1)


def _refused(answer: Answer | BaseException) -> str:
    """How an upload was not taken; empty where it was."""
    if isinstance(answer, BaseException):
        return f"{type(answer).__name__} {answer}"
    return "" if answer.status == 200 else f"{answer.status} {answer.body[:100]!r}"


def _broken(answer: Answer | BaseException) -> str:
    """What is wrong with an export; empty where nothing is."""
    if isinstance(answer, BaseException) or answer.status != 200:
        return _refused(answer)
    try:
        orjson.loads(answer.body)
    except ValueError as error:
        return str(error)
    return ""


def _wait(it: Running, patience: float) -> bool:
    """Whether it has ended within so many seconds; it is ended if not."""
    try:
        it.process.wait(patience)
    except subprocess.TimeoutExpired:
        it.process.kill()
        return False
    return True
