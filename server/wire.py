"""What comes before there is a request to look at, beside its body, and between requests.

uvicorn reads headers of any size for any time, keeps as many requests as one connection sends ahead, and waits for ever
for what a client has only begun. Here every connection has a place, and all that it may send has a bound and an end.
What is refused is answered by the guard, like all else: it finds the refusal in the scope's state, see `screen.BEFORE`.
"""

from __future__ import annotations

import asyncio
import socket
from typing import Any

import httptools
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol, RequestResponseCycle
from websockets import http11
from websockets.exceptions import InvalidMessage

from server.entrance import Entrance
from server.limits import Places
from server.metrics import REFUSALS
from server.screen import BEFORE, CROWDED, LARGEST_HEADERS, LONGEST_ADDRESS, MOST_HEADERS, Refusal, too_long
from server.socket_wire import Socket
from tracker_core.checks import InputError

HEAD_SECONDS = 10.0
"""For which the headers of a request may be on their way, or a body that nobody waits for any more; a connection may
not wait longer for its first ones."""

BESIDE_BYTES = 64 * 1024
"""Of what comes of a request beside its body; what ends is measured more closely, see `screen`."""

FOR_EACH = 8
"""Bytes that may come for each of the body: one that comes alone, in a chunk, takes six."""

SMALL_PARTS, PART = 20_000, 64
"""Parts of a body that may be of any size, and bytes that the others have on average."""

MOST_AHEAD = 8
"""Requests of one connection that are not answered yet. Browsers and proxies wait for each answer."""

STALLED_MS = 60_000
"""For which who is answered may take nothing of what is sent."""

MALFORMED = Refusal("malformed", InputError("request", "must be HTTP/1.1", "something else"), 400)
HEAD_TOO_LARGE = Refusal(
    "headers", InputError("headers", f"must have at most {LARGEST_HEADERS} characters together", "more"), 431
)
PADDED = Refusal("padding", InputError("body", "must be more than what is beside it", "too little"), 400)
AHEAD = Refusal("ahead", InputError("requests", f"must be at most {MOST_AHEAD} ahead of their answers", "more"), 429)
NOT_ALONE = Refusal("handshake", InputError("handshake", "must wait until all before it is answered", "one ahead"), 400)

# A line may be as long as an address or all headers together. It is read anew for every line.
http11.MAX_LINE_LENGTH = LONGEST_ADDRESS + LARGEST_HEADERS


class AheadError(Exception):
    """As many requests as may be are ahead of their answers: nothing more is read."""


class Wire(HttpToolsProtocol):
    """HTTP/1.1 as uvicorn speaks it, with bounds: `uvicorn.Config(http=functools.partial(Wire, entrance))`.

    Args:
        entrance: of all connections.
        more: what uvicorn gives each.
    """

    def __init__(self, entrance: Entrance, **more: Any) -> None:
        super().__init__(**more)
        self._entrance = entrance
        self._name = ""
        self._place: Places | None = None
        # Where in a request the last byte stood, and whether no more are read.
        self._in_head = self._in_body = self._is_deaf = False
        # Of the request that is coming: whether it began in what was read last, bytes of all that came since then, of
        # its body, parts of that, and bytes of its headers.
        self._is_new, self._come, self._body, self._parts, self._named = False, 0, 0, 0, 0
        self._ending: asyncio.TimerHandle | None = None

    # Connection ------------------------------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a place and begin to wait for the first request."""
        super().connection_made(transport)
        self._name = self._entrance.client(self.client)
        self._place = self._entrance.take(self._name)
        if self._place is None and not self._entrance.spares(self.client):
            REFUSALS.labels(CROWDED.reason).inc()
            self._is_deaf = True
            transport.abort()
            return
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            # The system ends what stalls, whoever speaks over it later: uvicorn waits for it for ever.
            transport.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, STALLED_MS)
        self._settle()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more, and give the place back."""
        self._stop_waiting()
        self._unset_keepalive_if_required()
        super().connection_lost(exc)
        if self._place is not None:
            self._place.leave(self._name)

    # What comes ------------------------------------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        """Read what has come."""
        if self._is_deaf:
            return
        self._unset_keepalive_if_required()
        self._is_new = False
        try:
            self.parser.feed_data(data)
        except httptools.HttpParserUpgrade:
            if self._should_upgrade():
                self.handle_websocket_upgrade()
                return
            # It is answered like any other request, but what follows would be taken for another, its body as well.
            self.cycle.keep_alive, self._is_deaf = False, True
        except httptools.HttpParserError as error:
            self._refuse(AHEAD if isinstance(error.__context__, AheadError) else MALFORMED)
            return
        if not self._is_new:
            # Where one request ends in it and the next begins, nobody knows what belongs to which.
            self._come += len(data)
        is_beside = self._come > BESIDE_BYTES + FOR_EACH * self._body
        if (self._in_head and is_beside) or (self._in_body and (is_beside or self._is_crumbled())):
            self._refuse(HEAD_TOO_LARGE if self._in_head else PADDED)
        self._settle()

    def on_message_begin(self) -> None:
        """A request begins."""
        self._in_head = self._is_new = True
        self._come = self._body = self._parts = self._named = 0
        super().on_message_begin()

    def on_header(self, name: bytes, value: bytes) -> None:
        """Keep a header, of those before the body, and no more than it takes to see that there are too many."""
        if self._in_head and len(self.headers) <= MOST_HEADERS and self._named <= LARGEST_HEADERS:
            self._named += len(name) + len(value)
            super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """Its headers are there."""
        if len(self.pipeline) + self._is_busy() >= MOST_AHEAD:
            raise AheadError
        self._place = self._entrance.take(self._name, self._place)
        if not self._entrance.serves(self._place, len(self.tasks)):
            self.scope["state"][BEFORE] = CROWDED
        super().on_headers_complete()
        self._in_head, self._in_body = False, True

    def on_body(self, body: bytes) -> None:
        """A part of its body."""
        self._body += len(body)
        self._parts += 1
        super().on_body(body)

    def _is_crumbled(self) -> bool:
        """Whether a body comes in more parts than anybody sends: each takes as long as a large one."""
        return self._parts > SMALL_PARTS + self._body // PART

    def on_message_complete(self) -> None:
        """All of it is there."""
        self._in_body = False
        super().on_message_complete()
        if not self._is_busy():
            # Its answer was sooner: the next one may take as long as after any other.
            self._stop_waiting()
            keep = self.timeout_keep_alive, self.timeout_keep_alive_handler
            self.timeout_keep_alive_task = self.loop.call_later(*keep)

    def handle_websocket_upgrade(self) -> None:
        """Hand the connection over, or answer what cannot be one as any other request."""
        self._stop_waiting()
        self._unset_keepalive_if_required()
        # uvicorn looks no further at what is to be a socket.
        scope: Any = self.scope
        scope.update({"path": "", "raw_path": self.url, "query_string": b""})
        refusal = NOT_ALONE if self._is_busy() else too_long(scope)
        if refusal is None:
            refusal = self._hand_over()
        if refusal is not None:
            self._refuse(refusal)

    def _hand_over(self) -> Refusal | None:
        """Have the connection go on as a socket; why it cannot, where it cannot."""
        first = f"{self.scope['method']} ".encode(), self.url, f" HTTP/{self.scope['http_version']}\r\n".encode()
        lines = [part for name, value in self.headers for part in (name, b": ", value, b"\r\n")]
        own = Socket(
            self._name,
            self._place,
            self._entrance.asides,
            config=self.config,
            server_state=self.server_state,
            app_state=self.scope["state"],
        )
        own.conn.receive_data(b"".join([*first, *lines, b"\r\n"]))
        requests = own.conn.events_received()
        # It is looked at here, since of what is none uvicorn's own says nothing, or answers in words of its own.
        if not requests or own.conn.accept(requests[0]).status_code != 101:  # type: ignore[arg-type]
            error = own.conn.handshake_exc
            received = str(error.__cause__ if isinstance(error, InvalidMessage) else error)
            rule = "must be that of a socket (RFC 6455)"
            version = {"Sec-WebSocket-Version": "13"}
            return Refusal("handshake", InputError("handshake", rule, received), 400, version)
        self.connections.discard(self)
        own.connection_made(self.transport)
        if self.flow.write_paused:
            # The transport has said so already, to this one.
            own.pause_writing()
        own.handle_connect(requests[0])  # type: ignore[arg-type]
        self.transport.set_protocol(own)
        # It holds this one, which would otherwise be left for the collector.
        self.parser = None  # type: ignore[assignment]
        return None

    # What is refused -------------------------------------------------------------------------------------------------

    def _refuse(self, refusal: Refusal) -> None:
        """Answer what cannot be read, after what came before it; nothing more is read, and the connection closed."""
        self._is_deaf = True
        if not self._in_body:
            self._answer(refusal)
        elif self._is_busy():
            # Its request is being answered: whoever waits for the body finds it.
            self.cycle.scope["state"][BEFORE] = refusal
            self.cycle.keep_alive = False
            self.cycle.message_event.set()
        else:
            # There is nothing to be answered any more.
            REFUSALS.labels(refusal.reason).inc()
            self.transport.close()

    def _answer(self, refusal: Refusal) -> None:
        """Have the guard answer in the place of a request."""
        if self.scope is getattr(self.cycle, "scope", None):
            # Nothing of it is known; it needs a scope of its own.
            super().on_message_begin()
        scope: Any = self.scope
        for name, nothing in (("method", ""), ("path", ""), ("raw_path", b""), ("query_string", b"")):
            scope.setdefault(name, nothing)
        scope["state"][BEFORE] = refusal
        cycle = RequestResponseCycle(
            scope=scope,
            transport=self.transport,
            flow=self.flow,
            logger=self.logger,
            access_logger=self.access_logger,
            access_log=self.access_log,
            default_headers=self.server_state.default_headers,
            message_event=asyncio.Event(),
            expect_100_continue=False,
            keep_alive=False,
            on_response=self.on_response_complete,
        )
        is_busy, self.cycle = self._is_busy(), cycle
        if is_busy:
            self.pipeline.appendleft((cycle, self.app))
        else:
            self._start_asgi_task(cycle, self.app)
        self._settle()

    # Waiting ---------------------------------------------------------------------------------------------------------

    def on_response_complete(self) -> None:
        """A request is answered."""
        super().on_response_complete()
        self._settle()

    def _is_busy(self) -> bool:
        """Whether a request is being answered: how long that may take is the guard's."""
        # There is none before the first.
        return not getattr(self.cycle, "response_complete", True)

    def _settle(self) -> None:
        """Wait with an end for what has to come next, whatever has come."""
        if self._is_busy() or self.transport.is_closing():
            self._stop_waiting()
            self._unset_keepalive_if_required()
        elif self._in_head or self._in_body:
            self._unset_keepalive_if_required()
            self._wait()
        elif self.timeout_keep_alive_task is None:
            self._wait()

    def _wait(self) -> None:
        if self._ending is None:
            self._ending = self.loop.call_later(HEAD_SECONDS, self._end)

    def _stop_waiting(self) -> None:
        if self._ending is not None:
            self._ending.cancel()
            self._ending = None

    def _end(self) -> None:
        """End a connection on which something has been waited for too long."""
        self._ending = None
        if self._in_head or self._in_body:
            what = "headers" if self._in_head else "body"
            error = InputError(what, f"must come in full within {HEAD_SECONDS:g} s", "a part")
            self._refuse(Refusal("slow", error, 408))
        else:
            # Browsers open connections ahead that they may never need.
            self.transport.close()
