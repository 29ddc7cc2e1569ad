"""From the start to the end of the server: when it is ready, how it is told to stop, and that it then does.

Told to stop, it is not ready any more at once, takes requests for a while still, so that whoever sends them hears of it
first, then no new ones; those in flight are answered, sockets closed with 1012 (the service restarts), work is ended,
and the process is gone within `LONGEST` seconds whatever hangs. Told twice, it is gone at once.
"""

from __future__ import annotations

import asyncio
import functools
import logging
import os
import select
import signal
import threading
import time
from collections.abc import Callable
from socket import socket
from types import FrameType
from typing import Any, cast

import uvicorn
from fastapi import FastAPI
from fastapi.responses import JSONResponse

from server.entrance import Entrance
from server.settings import Settings
from server.wire import Wire

LONGEST = 9.0
"""Seconds from the word to stop to the end of the process."""

ENDING = 2.0
"""Seconds of them that are for ending work; requests in flight have the rest."""

TOLD = 0.5
"""Seconds of these for telling whoever asked for what was given up on."""

LINGERING = 1.0
"""Seconds for which threads that still compute are waited for, once all else has ended."""

WITHIN = 65_536
"""Bytes of a message that comes over a socket, far more than any has."""

_LOG = logging.getLogger(__name__)


class Life:
    """How far the server has come: "starting", "compiling", "ready", "stopping"; never back."""

    STATES = ("starting", "compiling", "ready", "stopping")

    def __init__(self) -> None:
        self._reached = 0
        self._stopped = False
        self._at_stop: list[Callable[[], object]] = []

    @property
    def state(self) -> str:
        """One of `STATES`."""
        return self.STATES[-1] if self._stopped else self.STATES[self._reached]

    def reach(self, state: str) -> None:
        """Go on to a state; nothing happens where it lies behind. One thread alone may call this."""
        self._reached = max(self._reached, self.STATES.index(state))

    def stop(self) -> None:
        """From now on the server is not ready. A signal handler may call this, so no lock is asked for."""
        self._stopped = True

    def at_stop(self, work: Callable[[], object]) -> None:
        """Have something called once requests have been answered; the last registered comes first."""
        self._at_stop.append(work)

    def end(self) -> None:
        """Call what was registered, each whatever became of the others."""
        while self._at_stop:
            work = self._at_stop.pop()
            try:
                work()
            except Exception:  # noqa: BLE001 - the others are to be ended as well
                _LOG.exception("What was to be ended at the stop was not")

    def attach(self, server: FastAPI) -> None:
        """Serve `/livez`, which answers as long as the server does, and `/readyz`: 200 when it is ready, else 503."""

        @server.get("/livez")
        async def livez() -> JSONResponse:
            return JSONResponse({"status": "alive"})

        @server.get("/readyz")
        async def readyz() -> JSONResponse:
            return JSONResponse({"status": self.state}, status_code=200 if self.state == "ready" else 503)


class Server(uvicorn.Server):
    """uvicorn with an end that is bounded.

    Args:
        config: of uvicorn; `config_of` makes it from settings.
        life: what is told of the end.
        drain_seconds: for which requests are still taken after the word to stop.
    """

    def __init__(self, config: uvicorn.Config, life: Life, drain_seconds: float) -> None:
        super().__init__(config)
        self._life = life
        self._drain = drain_seconds
        self._told: float | None = None
        self._watch = Watch()

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Take the word to stop. In a signal handler, which may stand anywhere: no lock may be asked for."""
        del frame
        if self._told is not None:
            os._exit(128 + sig)
        self._told = time.monotonic()
        self._life.stop()
        self._watch.begin()

    async def on_tick(self, counter: int) -> bool:
        """Whether to stop taking requests; asked ten times a second."""
        if self._told is not None and time.monotonic() >= self._told + self._drain:
            self.should_exit = True
        return await super().on_tick(counter)

    async def shutdown(self, sockets: list[socket] | None = None) -> None:
        """Answer what is in flight, close sockets, end all work."""
        _LOG.info("Stopping")
        self._life.stop()
        self._watch.begin()
        await super().shutdown(sockets)
        if given_up := set(self.server_state.tasks):
            await asyncio.wait(given_up, timeout=TOLD)
        self._life.end()
        _LOG.info("Stopped")
        self._watch.ended()


class Watch:
    """Sees to it that the process ends. It is told over a pipe: a thread's locks may be held by who is interrupted."""

    def __init__(self) -> None:
        self._hears, self._says = os.pipe()
        threading.Thread(target=self._keep, name="watch", daemon=True).start()

    def begin(self) -> None:
        """The process is to end within `LONGEST` seconds."""
        os.write(self._says, b"b")

    def ended(self) -> None:
        """Nothing is left but threads that still compute; the process is to end within `LINGERING` seconds."""
        os.write(self._says, b"e")

    def _keep(self) -> None:
        os.read(self._hears, 1)
        last = time.monotonic() + LONGEST
        while select.select([self._hears], [], [], max(0.0, last - time.monotonic()))[0]:
            if os.read(self._hears, 1) == b"e":
                # What a thread still computes nobody waits for; nothing of it can be kept.
                time.sleep(LINGERING)
                os._exit(0)
        # Whoever hangs may hold the log's lock.
        threading.Thread(
            target=_LOG.critical, args=("The server did not stop in time and is ended",), daemon=True
        ).start()
        time.sleep(0.2)
        os._exit(1)


def config_of(settings: Settings, server: FastAPI) -> uvicorn.Config:
    """How uvicorn serves an application."""
    return uvicorn.Config(
        server,
        host=settings.host,
        port=settings.port,
        http=cast(Any, functools.partial(Wire, Entrance(settings))),
        log_config=None,
        # Requests are logged by who knows their number.
        access_log=False,
        server_header=False,
        # The guard has to know whether a proxy asked, before anybody puts the client in its place.
        proxy_headers=False,
        # Longer than the proxy keeps a connection (deploy/Caddyfile): what it sends into one that is being closed is
        # lost.
        timeout_keep_alive=75,
        timeout_graceful_shutdown=max(1, int(LONGEST - ENDING - settings.drain_seconds)),
        ws_max_size=WITHIN,
        # It takes as long as the answer to a moving slider does, and makes its numbers a fifth smaller.
        ws_per_message_deflate=False,
        # A browser that is gone without a word is noticed within 40 s.
        ws_ping_interval=20,
        ws_ping_timeout=20,
    )


def leave_at_once_until_served() -> None:
    """Before there is anything to end, the word to stop ends the process, also the first of a container's."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: os._exit(0))
