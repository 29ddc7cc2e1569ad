"""Figures of the server's own work, for Prometheus.

Labels take few values: a route is its template, never an address that somebody thought of.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import logging
import math
import resource
import time
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from pathlib import Path

from fastapi import FastAPI, Request, Response
from prometheus_client import (
    CONTENT_TYPE_LATEST,
    CollectorRegistry,
    Counter,
    Gauge,
    GCCollector,
    Histogram,
    ProcessCollector,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.context_managers import Timer
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector
from starlette.exceptions import HTTPException

from server.clients import Client, client_at, is_forwarded

PATH = "/metrics"

# When a figure was first counted is nobody's question, and would take as much room as the figures.
disable_created_metrics()  # type: ignore[no-untyped-call]

REGISTRY = CollectorRegistry()
"""Of this process, whose memory, descriptors and processor time are in it as well."""

ProcessCollector(registry=REGISTRY)
GCCollector(registry=REGISTRY)

_ANSWERS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30)
_WORK = (*_ANSWERS, 60, 300, 1800)

REQUESTS = Counter(
    "gainscope_requests", "Requests that were answered.", ["route", "method", "status"], registry=REGISTRY
)
SECONDS = Histogram(
    "gainscope_request_seconds",
    "Time from a request's headers to its answer's; a body may take longer to be sent.",
    ["route"],
    buckets=_ANSWERS,
    registry=REGISTRY,
)
REFUSALS = Counter(
    "gainscope_refusals", "What was refused before any page saw it, and why.", ["reason"], registry=REGISTRY
)
ERRORS = Counter(
    "gainscope_errors", "What could not be answered: where, and the type of error.", ["where", "kind"],
    registry=REGISTRY,
)  # fmt: skip
SOCKETS = Gauge("gainscope_sockets", "Sockets that are open.", ["route"], registry=REGISTRY)
MESSAGES = Counter("gainscope_socket_messages", "Messages that sockets brought.", ["route"], registry=REGISTRY)
UNTAKEN = Gauge("gainscope_untaken_bytes", "Of large answers that clients have not taken yet.", registry=REGISTRY)
COMPUTING = Histogram(
    "gainscope_computing_seconds",
    "Time that a piece of work took, from its beginning to its end, here or in a helper.",
    ["work"],
    buckets=_WORK,
    registry=REGISTRY,
)
LATENESS = Histogram(
    "gainscope_event_loop_lateness_seconds",
    "By how much the event loop was late: everybody waits that long.",
    buckets=_ANSWERS,
    registry=REGISTRY,
)

LOOKED_AFTER = 0.25
"""Seconds between two looks at how late the event loop is."""

_LOG = logging.getLogger(__name__)

_watched: dict[str, Gauge] = {}


def computing(work: str) -> Timer:
    """Measure what is computed within, in any thread: `with computing("run"): ...`, or `@computing("run")`.

    Args:
        work: what it is called; one of a few names.
    """
    return COMPUTING.labels(work).time()


class Children(Collector):
    """The processes that this one has started, all of them together: helpers, that of studies, those that compile.

    Where the system does not say which they are, there are no such figures: Linux says.
    """

    def __init__(self) -> None:
        self._number = ""
        self._one = ProcessCollector(pid=lambda: self._number, registry=None)
        self._seconds = 0.0

    def collect(self) -> Iterator[Metric]:
        """What they hold now, and have taken."""
        lists = list(Path("/proc/self/task").glob("*/children"))
        if not lists:
            return
        # First those that have ended: one that does so meanwhile is missed once, and not counted twice.
        ended = resource.getrusage(resource.RUSAGE_CHILDREN)
        memory, seconds = 0.0, ended.ru_utime + ended.ru_stime
        for number in _words(lists):
            self._number = number
            of_one = {sample.name: sample.value for family in self._one.collect() for sample in family.samples}
            memory += of_one.get("process_resident_memory_bytes", 0.0)
            seconds += of_one.get("process_cpu_seconds_total", 0.0)
        self._seconds = max(self._seconds, seconds)
        meaning = "Memory that the processes hold which the server has started."
        yield GaugeMetricFamily("gainscope_children_resident_memory_bytes", meaning, memory)
        meaning = "Processor time that the processes have taken which the server has started."
        yield CounterMetricFamily("gainscope_children_cpu_seconds", meaning, self._seconds)


def _words(files: list[Path]) -> Iterator[str]:
    for file in files:
        # A thread may have ended.
        with contextlib.suppress(OSError):
            yield from file.read_text().split()


REGISTRY.register(Children())


def watch(name: str, meaning: str, read: Callable[[], float]) -> None:
    """Show a figure that is read when somebody asks, on the event loop: it has to be quick. Where it fails it is NaN.

    Args:
        name: `gainscope_...`, with its unit at the end; the last that is watched under a name counts.
        meaning: in a sentence.
        read: gives it.
    """
    if name not in _watched:
        _watched[name] = Gauge(name, meaning, registry=REGISTRY)
    _watched[name].set_function(lambda: _read(name, read))


def _read(name: str, read: Callable[[], float]) -> float:
    try:
        return read()
    except Exception:  # noqa: BLE001 - the others are wanted most when something is wrong
        _LOG.exception("%s could not be read", name)
        return math.nan


@contextlib.asynccontextmanager
async def lateness() -> AsyncIterator[None]:
    """Measure how late the event loop is, for as long as this lasts."""

    async def measure() -> None:
        while True:
            due = time.perf_counter() + LOOKED_AFTER
            await asyncio.sleep(LOOKED_AFTER)
            LATENESS.observe(max(time.perf_counter() - due, 0.0))

    task = asyncio.create_task(measure(), name="lateness")
    try:
        yield
    finally:
        task.cancel()


def attach(server: FastAPI, token: str = "") -> None:
    """Serve the figures at `GET /metrics`.

    Args:
        server: the application.
        token: that has to come as `Authorization: Bearer ...`. Without one, this machine alone is answered, and only
            directly: for anybody else, there is no such address.
    """

    @server.get(PATH)
    async def metrics(request: Request) -> Response:
        client = client_at(request.client.host if request.client is not None else "")
        if is_admitted(dict(request.headers.raw), client, token):
            return Response(generate_latest(REGISTRY), media_type=CONTENT_TYPE_LATEST)
        if token:
            raise HTTPException(401, "must come with the token of these figures", {"WWW-Authenticate": "Bearer"})
        raise HTTPException(404)


def is_admitted(headers: Mapping[bytes, bytes], client: Client, token: str) -> bool:
    """Whether who asks may see the figures, see `attach`.

    Args:
        headers: of the request, by name.
        client: who asks.
        token: that has to come with it.
    """
    if token:
        return hmac.compare_digest(headers.get(b"authorization", b""), f"Bearer {token}".encode())
    return client.loopback and not is_forwarded(headers)
