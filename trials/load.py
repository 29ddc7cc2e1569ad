"""Many users at a time, on the same two cores as the server.

What is asked for is in user.py. On Tune, Compare and Data every visit asks for the page's study as the link says; on
top of that, in one part, two studies run that never end. A duration counts from when the action was due, so that
whoever had to wait for the action before has waited for this one as well.
"""

from __future__ import annotations

import asyncio
import contextlib
import tempfile
import time
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from typing import IO

import orjson
import psutil
import uvloop
from websockets.asyncio.client import connect
from websockets.typing import Origin

from benchmarks.serving import running
from trials.crowd import crowd
from trials.report import Finding, at_most, none_of, percentiles
from trials.tally import Tally

HEAVY = ("load", "part", "export", "upload")
"""Kinds of actions that may take their time beside studies."""

LONG = "order=2&xi=0.6&pin1=kalata,order:2,tracking_index:0.5&runs=1000000&seed={}"
"""A comparison that takes as long as there is."""


@dataclass(frozen=True, slots=True)
class Crowd:
    """How many come, how fast, and how long is measured once all are there.

    Attributes:
        users: how many.
        pace: seconds from one action of one of them to the next.
        arrivals: of them a second.
        settling: seconds after the last has come, in which what a server does for the first time comes to its end.
        seconds: that are measured.
        least: actions that are waited for all the same.
        studies: that run beside them.
        bound: of the 95th percentile, ms; 0 for none.
    """

    users: int
    pace: float = 1.0
    arrivals: float = 4.0
    settling: float = 30.0
    seconds: float = 60.0
    least: int = 0
    studies: int = 0
    bound: float = 0.0


CROWDS = (Crowd(200, bound=250), Crowd(400), Crowd(200, studies=2, bound=300))
SHORT = (Crowd(6, pace=0.1, arrivals=6, settling=0, seconds=1, least=150, studies=1),)

LONGEST = 300.0
"""Seconds that are waited for the least number of actions."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a crowd has seen, the shares of one core that server and crowd took, and that other machines took of all."""

    tally: Tally
    seconds: float
    server: float
    crowd: float
    stolen: float


def trial(short: bool = False) -> Iterator[Finding]:
    """Users of all pages: how long they wait, and that nothing goes wrong."""
    for group in SHORT if short else CROWDS:
        with tempfile.TemporaryFile() as log:
            with running(log) as it:
                outcome = uvloop.run(measure(it.port, psutil.Process(it.process.pid), group))
            yield from findings(group, outcome)
            yield none_of(f"{group.users} users: tracebacks in the log", tracebacks(log), "all")


async def measure(port: int, server: psutil.Process, group: Crowd) -> Outcome:
    """What a crowd sees at a server."""
    async with contextlib.AsyncExitStack() as stack:
        for number in range(group.studies):
            await stack.enter_async_context(study(port, LONG.format(number)))
        tally = await stack.enter_async_context(crowd(port, group.users, group.pace, group.arrivals))
        await asyncio.sleep(group.settling)
        tally.clear()
        before, own, begun, machine = taken(server), time.process_time(), time.perf_counter(), psutil.cpu_times()
        await asyncio.sleep(group.seconds)
        async with asyncio.timeout(LONGEST):
            await tally.reached(group.least)
        served, spent, seconds = taken(server) - before, time.process_time() - own, time.perf_counter() - begun
        now = psutil.cpu_times()
        seen = Tally()
        seen.seconds |= {kind: list(found) for kind, found in tally.seconds.items()}
    # What goes wrong when they leave counts as well.
    seen.errors, seen.refused = tally.errors, tally.refused
    # What a virtual machine is not given although it wants it; nil where nobody counts it.
    stolen = getattr(now, "steal", 0.0) - getattr(machine, "steal", 0.0)
    return Outcome(seen, seconds, served / seconds, spent / seconds, stolen / seconds)


def taken(server: psutil.Process) -> float:
    """Processor time of a server and its helpers, s."""
    return float(sum(sum(each.cpu_times()[:2]) for each in (server, *server.children(recursive=True))))


@contextlib.asynccontextmanager
async def study(port: int, query: str) -> AsyncIterator[None]:
    """A study on the Compare page that runs until the end."""
    origin = Origin(f"http://127.0.0.1:{port}")
    async with connect(f"ws://127.0.0.1:{port}/compare/study", origin=origin, max_size=None, proxy=None) as socket:
        await socket.send(orjson.dumps({"seq": 1, "query": query, "theme": "light"}).decode())
        while orjson.loads(await socket.recv())["state"] != "running":
            pass

        async def hear() -> None:
            async for _ in socket:
                pass

        hearing = asyncio.create_task(hear())
        try:
            yield
        finally:
            hearing.cancel()


def findings(group: Crowd, outcome: Outcome) -> Iterator[Finding]:
    """What came out, kind by kind and altogether."""
    tally = outcome.tally
    name = f"{group.users} users" + (f", {group.studies} studies" if group.studies else "")
    for kind, seconds in sorted(tally.seconds.items()):
        median, high, most = percentiles(seconds)
        yield Finding(f"{name}: {kind}", f"{len(seconds)}: p50 {median:.0f}, p95 {high:.0f}, max {most:.0f} ms")
    counted = [
        seconds for kind, found in tally.seconds.items() if not (group.studies and kind in HEAVY) for seconds in found
    ]
    _, high, _ = percentiles(counted)
    what = f"{name}: p95 of {'light' if group.studies else 'all'} actions"
    more = f"{len(counted) / outcome.seconds:.0f} a second of {group.users / group.pace:.0f}"
    if group.bound:
        yield at_most(what, high, group.bound, "ms", timed=True, more=more)
    else:
        yield Finding(what, f"{high:.0f} ms, {more}")
    done = len(tally)
    each = outcome.server * outcome.seconds / max(done, 1) * 1e3
    cores = f"server {outcome.server:.2f} ({each:.1f} ms an action), users {outcome.crowd:.2f}"
    yield Finding(f"{name}: cores", f"{cores}, other machines {outcome.stolen:.2f}")
    yield none_of(f"{name}: errors", tally.errors, f"{done} actions, {tally.refused} could not be run")
    least = max(group.least, 1)
    yield Finding(f"{name}: actions", f"{done} of {len(tally.seconds)} kinds", f"at least {least}", done >= least)


def tracebacks(log: IO[bytes]) -> list[str]:
    """The last lines of the tracebacks in a log."""
    log.seek(0)
    said = log.read().decode(errors="replace")
    found = []
    for part in said.split("Traceback (most recent call last):")[1:]:
        ends = [line for line in part.splitlines() if line and not line.startswith((" ", "\t"))]
        found.append(ends[0] if ends else "cut off")
    return found
