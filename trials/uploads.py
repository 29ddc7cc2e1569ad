"""A file that is too large: refused, whether its length is told or not, and hardly noticed."""

from __future__ import annotations

import asyncio
import contextlib
import tempfile
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import psutil
import uvloop

from benchmarks.serving import running
from layouts.files import SUFFIX, SUM
from trials.report import Finding, at_most, none_of
from trials.wire import Client

BYTES, PIECE = 12_000_000, 60_000
GROWTH = 20.0
"""Megabytes that a server may grow by."""

ROUNDS, SHORT = 10, 2
ROW = b"%d,%d,%d\n"
TABLE = b"t,x,y\n" + b"".join(ROW % (row, 3 * row, row) for row in range(1000))


def trial(short: bool = False) -> Iterator[Finding]:
    """Files of 12 MB, kept on disk or in memory, with their length and without."""
    rounds = SHORT if short else ROUNDS
    with (
        tempfile.TemporaryDirectory() as folder,
        tempfile.TemporaryFile() as log,
        running(log, GAINSCOPE_DATA=folder) as it,
    ):
        server = psutil.Process(it.process.pid)
        for keep in ("store", "browser"):
            for told in (True, False):
                how = f"12 MB, {'its length told' if told else 'in pieces'}, for the {keep}"
                growth, wrong = uvloop.run(_send(it.port, server, keep, told=told, rounds=rounds))
                yield none_of(f"{how}: other answers than 413", wrong, f"{rounds} times")
                yield at_most(f"{how}: memory at its peak", growth, GROWTH, "MB")
        left = [path.name for path in Path(folder).iterdir() if path.suffix != SUFFIX and path.name != SUM]
        yield none_of("left on the disk", left, "the folder")


async def _send(port: int, server: psutil.Process, keep: str, *, told: bool, rounds: int) -> tuple[float, list[str]]:
    """Send it so many times; by how many megabytes the server grew at its peak, and answers that are not 413."""
    client, wrong = Client(port), []
    await client.ask("PUT", f"/recordings?name=small.csv&keep={keep}", TABLE)
    before = server.memory_info().rss
    peak = before

    async def watch() -> None:
        nonlocal peak
        while True:
            peak = max(peak, server.memory_info().rss)
            await asyncio.sleep(0.01)

    watching = asyncio.create_task(watch())
    for _ in range(rounds):
        body = b"".join([TABLE] * (BYTES // len(TABLE) + 1)) if told else _pieces()
        try:
            answer = await client.ask("PUT", f"/recordings?name=large.csv&keep={keep}", body)
            if answer.status != 413 or b"file" not in answer.body:
                wrong.append(f"{answer.status} {answer.body[:100]!r}")
        except (OSError, EOFError, TimeoutError) as error:
            wrong.append(f"no answer, {type(error).__name__}")
    watching.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await watching
    await client.close()
    return (peak - before) / 1e6, wrong


async def _pieces() -> AsyncIterator[bytes]:
    piece = (TABLE * (PIECE // len(TABLE) + 1))[:PIECE]
    for _ in range(BYTES // PIECE):
        yield piece
