"""A line in the log for what somebody who runs the server wants to know of, and a count of everything.

What was refused, went wrong or was slow is logged as "info", the rest as "debug": one person at a slider asks many
times a second, and the figures count it all. A line has the template of the route and the client's network, never the
address that was asked for or the client's own: these say what somebody works on, and who.
"""

from __future__ import annotations

import logging
import time
from functools import lru_cache

from server.channel import OPEN, Channel
from server.clients import Client
from server.exchange import Exchange
from server.limits import Buckets, Rate
from server.metrics import REQUESTS, SECONDS
from server.problem import REQUEST
from server.routes import METHODS, template

SLOW = 1.0
"""Seconds after which an answer that has not begun is worth a line."""

LINES = Rate(per_second=1, at_once=20)
"""Lines about one client; of what it does more often, the figures tell."""

LEFT = 499
"""Status of what nobody waited for, as nginx has it."""

_LOG = logging.getLogger(__name__)

# Looking a figure up by its labels takes longer than counting.
_requests = lru_cache(maxsize=4096)(REQUESTS.labels)
_seconds = lru_cache(maxsize=1024)(SECONDS.labels)


class Access:
    """What notes how requests and sockets ended."""

    def __init__(self) -> None:
        self._lines = Buckets(LINES)

    def request(self, exchange: Exchange, client: Client, begun: float, *, is_quiet: bool) -> None:
        """Count a request that has ended, and log it if it is worth it.

        Args:
            exchange: the request and its answer.
            client: who asked.
            begun: when it came, in seconds of `time.perf_counter`.
            is_quiet: whether it is asked for again and again, by a machine.
        """
        now = time.perf_counter()
        route, status = template(exchange.scope), exchange.status or LEFT
        method = exchange.method if exchange.method in METHODS else "other"
        waited = (exchange.began or now) - begun
        _requests(route, method, status).inc()
        _seconds(route).observe(waited)
        is_noted = (status >= 400 or waited > SLOW) and not is_quiet
        self._line(method, route, status, now - begun, exchange.size, client, is_noted=is_noted)

    def socket(self, channel: Channel, client: Client, begun: float) -> None:
        """Log a socket that has ended; one that was not opened is worth more.

        Args:
            channel: the socket.
            client: who opened it.
            begun: when it was asked for, in seconds of `time.perf_counter`.
        """
        status = channel.status or LEFT
        seconds = time.perf_counter() - begun
        self._line("SOCKET", template(channel.scope), status, seconds, 0, client, is_noted=status != OPEN)

    def _line(
        self, method: str, route: str, status: int, seconds: float, size: int, client: Client, *, is_noted: bool
    ) -> None:
        level = logging.INFO if is_noted else logging.DEBUG
        if not _LOG.isEnabledFor(level) or (is_noted and self._lines.take(client.key, time.monotonic())):
            return
        more = {
            "method": method,
            "route": route,
            "status": status,
            "ms": round(1000 * seconds, 1),
            "bytes": size,
            "client": client.shown,
            "request": REQUEST.get(),
        }
        _LOG.log(level, "%s %s %d %.1f ms", method, route, status, 1000 * seconds, extra=more)
