"""A server under users for long: whether its memory or its open files grow."""

from __future__ import annotations

import asyncio
import contextlib
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import psutil
import uvloop
from scipy.stats import theilslopes

from benchmarks.serving import running
from trials.crowd import crowd
from trials.load import tracebacks
from trials.report import Finding, none_of, percentiles
from trials.tally import Tally

SLOPE = 5.0
"""Megabytes an hour that its memory may grow by."""

CONFIDENCE = 0.95
PARTS = 30
"""Medians of as many parts of the time make a line: neighbouring samples say the same."""

PACE, EVERY = 1.0, 1.0
"""Seconds from one action of a user to the next, and from sample to sample."""


@dataclass(frozen=True, slots=True)
class Long:
    """How many stay for how long.

    Attributes:
        minutes: that are measured.
        warming: minutes before, in which all of them act at twice the pace: what is remembered has bounds, and comes to
            them sooner.
        users: of all pages.
        watchers: of the page with the scene in three dimensions.
        quiet: seconds after which a server has closed everything that its users have left.
    """

    minutes: float = 30.0
    warming: float = 20.0
    users: int = 50
    watchers: int = 20
    quiet: float = 20.0


Samples = list[tuple[float, float]]
"""Hours, and megabytes."""

SERVER = "the server"

SHORT = Long(minutes=0.05, warming=0.1, users=4, watchers=2, quiet=5.0)


def trial(short: bool = False, long: Long | None = None) -> Iterator[Finding]:
    """Users and scenes; how memory and open files go."""
    plan = long or (SHORT if short else Long())
    with tempfile.TemporaryFile() as log:
        with running(log) as it:
            yield from uvloop.run(_stay(it.port, psutil.Process(it.process.pid), plan))
        yield none_of("tracebacks in the log", tracebacks(log), "all")


async def _stay(port: int, server: psutil.Process, plan: Long) -> list[Finding]:
    await _crowded(port, server, plan, plan.warming * 60, seed=1, pace=PACE / 2)
    before = await _open_files(server, 0, plan.quiet)
    memory, tally = await _crowded(port, server, plan, plan.minutes * 60, seed=2, pace=PACE)
    after = await _open_files(server, before, plan.quiet)
    _, late, _ = percentiles(seconds for found in tally.seconds.values() for seconds in found)
    # What came later is still filling its memories.
    lasting = {name: found for name, found in memory.items() if len(found) == len(memory[SERVER])}
    return [
        *(_growth(name, found, plan.minutes) for name, found in lasting.items()),
        Finding("open files without users, before and after", f"{before} and {after}", "no more", after <= before),
        none_of("errors", tally.errors, f"{len(tally)} actions"),
        Finding("actions", f"p95 {late:.0f} ms"),
    ]


def _growth(name: str, samples: Samples, minutes: float) -> Finding:
    slope, low, high = slope_of(samples)
    return Finding(
        f"memory of {name}, {minutes:g} minutes",
        f"{slope:+.1f} MB/h, 95 % {low:+.1f} to {high:+.1f}; {samples[-1][1]:.0f} MB",
        f"under {SLOPE:g} MB/h",
        slope < SLOPE,
        # Some seconds make no hour.
        timed=minutes < 1,
    )


async def _open_files(server: psutil.Process, enough: int, quiet: float) -> int:
    """Open files once there are few enough, or after so many seconds without users.

    The two ends of what is spoken with another process do not count: such processes come and go.
    """

    def opened() -> int:
        return int(server.num_fds()) - 2 * len(server.children())

    for _ in range(int(quiet / EVERY)):
        if opened() <= enough:
            break
        await asyncio.sleep(EVERY)
    return opened()


async def _crowded(
    port: int, server: psutil.Process, plan: Long, seconds: float, seed: int, pace: float
) -> tuple[dict[str, Samples], Tally]:
    """Hours and megabytes of every process, sample by sample, and what the users saw."""
    found: defaultdict[str, Samples] = defaultdict(list)
    async with contextlib.AsyncExitStack() as stack:
        tally = await stack.enter_async_context(crowd(port, plan.users, pace, 4.0, seed))
        watching = await stack.enter_async_context(crowd(port, plan.watchers, pace, 4.0, seed + 100, ("track",)))
        # Nothing is to be started for the first time later.
        await watching.reached(2 * plan.watchers)
        begun = time.monotonic()
        while (now := time.monotonic() - begun) < seconds:
            for name, megabytes in _memory(server):
                found[name].append((now / 3600, megabytes))
            await asyncio.sleep(EVERY)
    tally.errors.update(watching.errors)
    return dict(found), tally


def _memory(server: psutil.Process) -> Iterator[tuple[str, float]]:
    """The server and the processes that it has started, by name, and the megabytes that each holds."""
    for process in (server, *server.children()):
        # One that has ended meanwhile holds nothing.
        with contextlib.suppress(psutil.NoSuchProcess, IndexError):
            name = SERVER if process is server else f"{process.cmdline()[2]} {process.pid}"
            yield name, process.memory_info().rss / 1e6


def slope_of(samples: Samples) -> tuple[float, float, float]:
    """The slope through samples of time and value that outliers do not turn, and its confidence interval (Theil, Sen).

    Args:
        samples: at least two, in the order of time.
    """
    parts = [part for part in np.array_split(np.asarray(samples), PARTS) if len(part)]
    middles = np.array([np.median(part, axis=0) for part in parts])
    slope, _, low, high = theilslopes(middles[:, 1], middles[:, 0], CONFIDENCE)
    return float(slope), float(low), float(high)
