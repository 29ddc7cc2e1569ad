"""Questions that no page asks: the server refuses them, says nothing of its inside, and goes on.

Real bodies of every callback and real messages of every socket are changed at random. To every one there must be an
answer below 500 and without a traceback within two seconds, or an end of the socket; and right after, a question of
the page must be answered as before.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import tempfile
from collections import Counter, defaultdict
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from random import Random
from time import perf_counter
from typing import Any

import uvloop
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed
from websockets.typing import Origin

from benchmarks.scene_browser import PROTOCOL, camera
from benchmarks.serving import running
from trials.bodies import changed, torn, written
from trials.load import tracebacks
from trials.page import CALLBACK, CONTENT, DESKS, PATHS, Desk, Site
from trials.report import Finding, at_most, none_of, percentiles
from trials.wire import Answer, Client

BODIES, MESSAGES = 20_000, 2_000
SHORT = 300, 60

AT_ONCE = 8
"""Clients that ask at a time."""

EACH = 50
"""Questions that come from one address: more at a time would be refused for their number."""

SECONDS, PATIENCE = 2.0, 30.0
"""Within which there must be an answer; and after which none is waited for."""

TYPES = (
    "text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", "", "*",
    "application/json; charset=utf-16",
)  # fmt: skip
METHODS = ("PUT", "DELETE", "PATCH", "GET", "OPTIONS", "POST")

INSIDE = (b"Traceback (most recent call last)", b'File "', b"site-packages", b"uvicorn", b"starlette", b"Exception(")
"""What no answer may contain."""


class Sample:
    """Real questions, taken from the pages.

    Attributes:
        bodies: of callbacks.
        messages: by path of a socket, and what there is to ask there.
    """

    def __init__(self, site: Site) -> None:
        self.site = site
        self.bodies: list[Any] = [
            site.callbacks[CONTENT].body([path, query])
            for path in PATHS.values()
            for query in ("", "?order=2&xi=0.7&pin1=kalata,order:2,tracking_index:0.5")
        ]
        self.messages: dict[str, list[Any]] = {}

    @staticmethod
    async def taken(client: Client) -> Sample:
        """From the pages of a server."""
        sample = Sample(await Site.load(client))
        for page in DESKS:
            desk = Desk(await sample.site.beginning(client, page))
            callback = f"{page}-request.data"
            question = desk.question({})
            answer = await sample.site.call(client, callback, [question])
            desk.take(answer[f"{page}-answer"]["data"])
            later = [desk.question({"xi": 0.7}), desk.question({"order": "2"}), {**question, "pinning": [["start"]]}]
            for asked in (question, *later):
                sample.bodies.append(sample.site.callbacks[callback].body([asked]))
            sample.messages[f"/{page}/live"] = [desk.question({"xi": 0.6}, live=True), *later]
        for page in ("tune", "compare", "data"):
            queries = ("", "xi=0.7", "tune=search&budget=2000", "tune=map&cells=5&tune_runs=2", "runs=3")
            sample.messages[f"/{page}/study"] = [
                *({"seq": 1, "query": query, "theme": "light"} for query in queries),
                {"seq": 2, "query": "", "theme": "dark", "stop": True},
                {"seq": 2, "query": "", "theme": "dark", "look": True},
            ]
        return sample


def trial(short: bool = False) -> Iterator[Finding]:
    """Mutated bodies and messages."""
    bodies, messages = SHORT if short else (BODIES, MESSAGES)
    with tempfile.TemporaryFile() as log:
        with running(log) as it:
            yield from uvloop.run(_tried(it.port, bodies, messages))
            yield Finding(
                "the server", "runs" if it.process.poll() is None else "has ended", "runs", it.process.poll() is None
            )
        yield Finding("tracebacks in the log", str(len(tracebacks(log))))


async def _tried(port: int, bodies: int, messages: int) -> list[Finding]:
    client = Client(port)
    sample = await Sample.taken(client)
    await client.close()
    findings = []
    for what, count, ask in (("bodies", bodies, _post), ("messages", messages, _say)):
        faults, seconds = await _asked(port, sample, count, ask)
        longest = percentiles(seconds)[2] / 1e3
        findings += [
            none_of(f"{what}: faults", faults, f"{len(seconds)} mutated"),
            at_most(f"{what}: longest answer", longest, SECONDS, "s", timed=True),
            none_of(f"{what}: pages that are gone afterwards", await _checked(port, sample), "every page"),
        ]
    return findings


Ask = Callable[[int, str, Sample, Random], Awaitable[list[str]]]
"""Asks one question at a port, from an address; says what is wrong with what comes of it."""


async def _asked(port: int, sample: Sample, count: int, ask: Ask) -> tuple[Counter[str], list[float]]:
    """Ask so many questions; the faults, each with the seed that it came with first, and how long each took."""
    faults: defaultdict[str, list[int]] = defaultdict(list)
    seconds: list[float] = []
    numbers = iter(range(count))

    async def one_after_the_other() -> None:
        for number in numbers:
            # A seed for each, whoever asks it.
            random = Random(number)
            address = f"127.1.{number // EACH // 250}.{1 + number // EACH % 250}"
            begun = perf_counter()
            for fault in await ask(port, address, sample, random):
                faults[fault].append(number)
            seconds.append(perf_counter() - begun)

    await asyncio.gather(*(one_after_the_other() for _ in range(AT_ONCE)))
    return Counter({f"{fault} (seed {min(seeds)})": len(seeds) for fault, seeds in faults.items()}), seconds


async def _checked(port: int, sample: Sample) -> list[str]:
    """What the pages no longer answer as they should."""
    client, faults = Client(port), []
    for page in DESKS:
        try:
            desk = Desk(await sample.site.beginning(client, page))
            answer = await sample.site.call(client, f"{page}-request.data", [desk.question({})])
            if not desk.take(answer[f"{page}-answer"]["data"]):
                faults.append(f"{page}: refused")
        except Exception as error:  # noqa: BLE001 - whatever it was, the page is not there
            faults.append(f"{page}: {type(error).__name__} {error}")
    await client.close()
    return faults


# Bodies -----------------------------------------------------------------------------------------------------------


async def _post(port: int, address: str, sample: Sample, random: Random) -> list[str]:
    """Ask a callback something; what is wrong with the answer."""
    real = random.choice(sample.bodies)
    kind = random.random()
    body = torn(random, written(real)) if kind < 0.15 else written(changed(random, real))
    headers = {"Content-Type": "application/json", "Accept": "application/json"}
    method, path = "POST", CALLBACK
    if kind > 0.9:
        headers["Content-Type"] = random.choice(TYPES)
    elif kind > 0.85:
        method = random.choice(METHODS)
    elif kind > 0.8:
        path += "?" + random.choice(("endId=1~2", "cacheKey=a&job=1", "oldJob=1", "x=" + "y" * 3000))
    client = Client(port, address)
    try:
        answer = await client.ask(method, path, body, headers, patience=PATIENCE)
    except (OSError, EOFError, TimeoutError) as error:
        return [f"no answer, {type(error).__name__}"]
    finally:
        await client.close()
    return faults_of(answer)


def faults_of(answer: Answer) -> list[str]:
    """What no answer may be."""
    found = [f"status {answer.status}"] if answer.status >= 500 or answer.status == 429 else []
    body = answer.body
    # A page that is shown may name files of its own; an answer to what is wrong may not.
    told = [inside.decode() for inside in INSIDE if answer.status >= 400 and inside in body]
    return found + [f"says {text!r}" for text in told]


# Sockets ----------------------------------------------------------------------------------------------------------


async def _say(port: int, address: str, sample: Sample, random: Random) -> list[str]:
    """Say something on a socket; what is wrong with what comes of it."""
    path = random.choice([*sample.messages, "/viser"])
    try:
        async with asyncio.timeout(PATIENCE), _open(port, address, path) as socket:
            if path == "/viser":
                await _send_as_camera(socket, random)
            else:
                await _send(socket, sample.messages[path], random)
            return await _heard(socket)
    except ConnectionClosed as closed:
        return _ending(path, closed)
    except (OSError, EOFError, TimeoutError) as error:
        return [f"{path}: {type(error).__name__} {error}"]


@contextlib.asynccontextmanager
async def _open(port: int, address: str, path: str) -> AsyncIterator[ClientConnection]:
    options: dict[str, Any] = {}
    if path == "/viser":
        path, options = f"/viser/{secrets.token_hex(16)}", {"subprotocols": [PROTOCOL]}
    async with connect(
        f"ws://127.0.0.1:{port}{path}", origin=Origin(f"http://127.0.0.1:{port}"), max_size=None, ping_interval=None,
        local_addr=(address, 0), proxy=None, close_timeout=SECONDS, **options,
    ) as socket:  # fmt: skip
        yield socket


async def _send(socket: ClientConnection, messages: list[Any], random: Random) -> None:
    real = random.choice(messages)
    text = torn(random, written(real)) if random.random() < 0.2 else written(changed(random, real))
    match random.randrange(6):
        case 0:
            await socket.send(text)
        case 1:
            short = text[:20_000].decode(errors="replace")
            await socket.send([short[at : at + 40] for at in range(0, len(short), 40)])
        case 2:
            for _ in range(200):
                await socket.ping()
            await socket.send(text.decode(errors="replace"))
        case 3:
            await socket.send(text.decode(errors="replace"))
            await socket.send(written(real).decode())
        case _:
            await socket.send(text.decode(errors="replace"))


async def _send_as_camera(socket: ClientConnection, random: Random) -> None:
    real = camera(position=(random.uniform(-3, 3), 1.0, 2.0))
    match random.randrange(5):
        case 0:
            await socket.send(bytes(random.randrange(256) for _ in range(random.choice((0, 5, 300, 5000)))))
        case 1:
            await socket.send([real[:20], real[20:]])
        case 2:
            await socket.send("x" * random.choice((1, 5000)))
        case 3:
            for _ in range(200):
                await socket.ping()
        case _:
            at = random.randrange(len(real))
            await socket.send(real[:at] + bytes([random.randrange(256)]) + real[at + 1 :])


async def _heard(socket: ClientConnection) -> list[str]:
    """What comes within a moment; a ping is answered as long as the socket is open."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(0.05):
            message = await socket.recv(decode=False)
            told = [inside.decode() for inside in INSIDE if inside in message]
            if told:
                return [f"a message says {told}"]
    await (await socket.ping())
    return []


def _ending(path: str, closed: ConnectionClosed) -> list[str]:
    """1011 is what a server says that has failed."""
    if closed.rcvd is None:
        return [f"{path}: cut off"]
    return [f"{path}: ended with {closed.rcvd.code}"] if closed.rcvd.code == 1011 else []
