"""A server that is killed again and again while files come in: what it said it has, it has."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import os
import socket
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from random import Random

import orjson
import uvloop

from benchmarks.serving import Running, start, wait_until_ready
from layouts.files import PART, SUFFIX, SUM
from trials.report import Finding, none_of
from trials.wire import Client

KILLS, SHORT = 100, 3

UPLOADERS = 6
"""Who send one file after the other."""

STARTING = 0.2
"""Share of the servers that are killed before they are ready."""

LOOKED_AT = 20
"""Older sets that are looked at after every start; those that are new are all, and in the end every one is."""

TOLD_EVERY = 10
"""Kills after which it is said how far it is: all of them take a quarter of an hour."""

AGED = 7200.0
"""Seconds by which what a killed server left is made older: then it is nobody's."""

Sets = dict[str, str]
"""What sets are known by, and the hashes of their bytes."""


def trial(short: bool = False) -> Iterator[Finding]:
    """Kill it at random moments under uploads; every set that was acknowledged is there and whole."""
    kills = SHORT if short else KILLS
    with tempfile.TemporaryDirectory() as folder:
        seen = uvloop.run(_Killed(Path(folder)).run(kills))
        sent = f"{len(seen.acknowledged)} acknowledged, {len(seen.others)} not, {kills} kills"
        yield none_of("sets that are lost or broken", seen.faults, sent)
        yield Finding("sets that were acknowledged", str(len(seen.acknowledged)), "some", bool(seen.acknowledged))
        yield Finding("killed before it was ready", str(seen.early))
        left = [path.name for path in Path(folder).iterdir() if path.suffix != SUFFIX and path.name != SUM]
        yield none_of("left over after a start two hours later", left, f"{seen.parts} that there were")


class _Killed:
    """A server in a folder that is killed, and who sends to it.

    Attributes:
        acknowledged: sets of which the server said that it has them.
        others: sets that were sent and of which it said nothing.
        faults: sets that were not as they should be.
        early: how often it was killed before it was ready.
        parts: what it had left over in the end.
    """

    def __init__(self, folder: Path) -> None:
        self.acknowledged: Sets = {}
        self.others: Sets = {}
        self.faults: list[str] = []
        self.early = self.parts = 0
        self._folder = folder
        self._random = Random(1)
        self._settings = {
            "GAINSCOPE_DATA": str(folder),
            # More than it is sent: nothing makes room for anything else.
            "GAINSCOPE_DATA_MB": "100000",
            "GAINSCOPE_PORT": str(_free_port()),
        }
        self._checked: set[str] = set()

    async def run(self, kills: int) -> _Killed:
        """Kill it so many times, then look at everything."""
        port = int(self._settings["GAINSCOPE_PORT"])
        over = asyncio.Event()
        uploaders = [asyncio.create_task(self._upload(port, number, over)) for number in range(UPLOADERS)]
        for kill in range(kills):
            if kill and kill % TOLD_EVERY == 0:
                print(f"  {kill} kills, {len(self.acknowledged)} sets acknowledged", flush=True)
            with self._started() as it:
                if self._random.random() < STARTING:
                    self.early += 1
                    await asyncio.sleep(self._random.uniform(0, 2))
                else:
                    await asyncio.to_thread(wait_until_ready, it)
                    await self._look(port, everything=False)
                    await asyncio.sleep(self._random.uniform(0, 1))
        over.set()
        await asyncio.gather(*uploaders)
        with self._started() as it:
            await asyncio.to_thread(wait_until_ready, it)
            await self._look(port, everything=True)
        self._age()
        with self._started() as it:
            await asyncio.to_thread(wait_until_ready, it)
        return self

    @contextlib.contextmanager
    def _started(self) -> Iterator[Running]:
        with tempfile.TemporaryFile() as log:
            it = start(log, **self._settings)
        try:
            yield it
        finally:
            it.process.kill()
            it.process.wait()

    async def _upload(self, port: int, number: int, over: asyncio.Event) -> None:
        """Send one file after the other, whether or not there is a server."""
        random = Random(number)
        client = Client(port, f"127.0.1.{1 + number}")
        while not over.is_set():
            content = _recording(random)
            digest = hashlib.sha256(content).hexdigest()
            # The server may have it whole before it is killed, and not have said so.
            self.others[digest[:32]] = digest
            try:
                answer = await client.ask("PUT", f"/recordings?name={number}.csv", content)
                told = orjson.loads(answer.body) if answer.status == 200 else {}
            except ConnectionRefusedError:
                # There is no server that could have it.
                del self.others[digest[:32]]
                await asyncio.sleep(0.05)
                continue
            except (OSError, EOFError, TimeoutError):
                await asyncio.sleep(0.05)
                continue
            if not told:
                self.faults.append(f"an upload was answered with {answer.status}")
            elif told["kept"] != "store" or told["data"] != digest[:32]:
                self.faults.append("an upload was not kept")
            else:
                self.acknowledged[told["data"]] = self.others.pop(told["data"])
        await client.close()

    async def _look(self, port: int, *, everything: bool) -> None:
        """Fetch what has been acknowledged since the last look, and some more; or all that was ever sent."""
        known = list(self.acknowledged)
        new = [data for data in known if data not in self._checked]
        older = self._random.sample(known, min(LOOKED_AT, len(known)))
        client = Client(port, "127.0.1.100")
        for data in known if everything else {*new, *older}:
            answer = await client.ask("GET", f"/recordings/{data}")
            if answer.status != 200 or hashlib.sha256(answer.body).hexdigest() != self.acknowledged[data]:
                self.faults.append(f"{data}: {answer.status}, {len(answer.body)} bytes")
            self._checked.add(data)
        for data, digest in list(self.others.items()) if everything else ():
            answer = await client.ask("GET", f"/recordings/{data}")
            if answer.status != 404 and hashlib.sha256(answer.body).hexdigest() != digest:
                self.faults.append(f"{data}, not acknowledged: {answer.status}, {len(answer.body)} bytes")
        await client.close()

    def _age(self) -> None:
        """What is left over was left long ago."""
        for path in self._folder.glob(f"*{PART}"):
            self.parts += 1
            then = time.time() - AGED
            os.utime(path, (then, then))


def _recording(random: Random) -> bytes:
    """A table that is like no other, of 1 kB to 2 MB."""
    rows = b"".join(b"%d,%d,%d\n" % (row, 3 * row, row) for row in range(50))
    times = random.choice((1, 10, 100, 2000))
    return b"t,x,y\n%d,0,0\n" % random.getrandbits(62) + rows * times


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])
