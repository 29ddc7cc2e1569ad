"""One socket, as its messages pass."""

from __future__ import annotations

import asyncio
import contextlib
import time

from fastapi.responses import JSONResponse
from starlette.types import Message, Receive, Scope, Send
from uvicorn.protocols.utils import ClientDisconnected

from server.headers import Headers
from server.limits import Buckets, Rate, Turns
from server.metrics import MESSAGES, REFUSALS, SOCKETS
from server.problem import problem
from server.routes import template
from server.screen import POLICY, TRY_LATER, Refusal
from server.untaken import TOO_MUCH, Untaken
from tracker_core.checks import InputError

PACE = Rate(per_second=100, at_once=100)
"""Messages of one socket; a slider under a mouse sends 60 a second. More of them wait, in the end in the network."""

PACE_OF_ALL = Rate(per_second=2_500, at_once=2_500)
"""Messages of all sockets of one client: of forty sliders that are moved behind one address."""

AT_A_TIME = 64
"""Messages of one client that are worked on at a time. A page asks again once it has its answer, so that forty have
forty on their way; a client that has more has the server do no less for it, but leaves others their turns."""

OPEN = 101
"""Status of a socket that was opened."""

FAILED = 1011

LATER = {"Retry-After": "5"}

ANSWERED = "websocket.http.response"
"""Extension by which a socket that is not opened can be answered like any other request."""


class Hearing:
    """How the sockets of each client are heard, all of them together: see `PACE_OF_ALL` and `AT_A_TIME`.

    What is more waits, like what one socket says too fast: nobody has to say anything twice.
    """

    def __init__(self) -> None:
        self.said = Buckets(PACE_OF_ALL)
        self.turns = Turns(AT_A_TIME)


class Channel:
    """One socket. Messages pass as they come, no faster than `PACE` and as the client's others leave it its turn.

    A message is worked on from when the application is given it until it answers or asks for the next.

    Args:
        scope: of the socket.
        receive, send: to and from the network.
        headers: that answers get.
        request: its number.
        client: whose it is, as limits know it.
        hearing: of all sockets.
        untaken: large answers of all.

    Attributes:
        scope: of the socket.
        status: of the answer: OPEN once it is open, 0 before there is one.
    """

    __slots__ = (
        "_client", "_closed", "_due", "_full", "_has_turn", "_headers", "_heard", "_hearing", "_number", "_receive",
        "_route", "_send", "_turns", "_untaken", "scope", "status",
    )  # fmt: skip

    def __init__(
        self,
        scope: Scope,
        receive: Receive,
        send: Send,
        headers: Headers,
        request: str,
        client: str,
        hearing: Hearing,
        untaken: Untaken,
    ) -> None:
        self.scope, self._receive, self._send = scope, receive, send
        self._headers, self._number = headers, request.encode()
        self._client, self._hearing, self._turns = client, hearing, hearing.turns.of(client)
        self._untaken = untaken
        self._full, self._due, self._has_turn = 0.0, 0.0, False
        self._heard: Message | None = None
        self._route, self._closed = "", False
        self.status = 0

    async def receive(self) -> Message:
        """The next message, once it is its turn. Who gives up waiting for it has lost none."""
        self._end_turn()
        if self._heard is None:
            now = time.monotonic()
            # Where there is nothing to wait for, others have their turn all the same.
            await asyncio.sleep(max(PACE.wait(self._full, now), self._due - now, 0.0))
            message = await self._receive()
            if message["type"] != "websocket.receive":
                return message
            now = time.monotonic()
            self._full = PACE.taken(self._full, now)
            self._due = now + self._hearing.said.book(self._client, now)
            MESSAGES.labels(self._route).inc()
            self._heard = message
        await self._turns.acquire()
        self._has_turn = True
        heard, self._heard = self._heard, None
        return heard

    async def send(self, message: Message) -> None:
        """Pass on what the application says."""
        self._end_turn()
        kind = message["type"]
        if kind == "websocket.accept":
            self.status, self._route = OPEN, template(self.scope)
            SOCKETS.labels(self._route).inc()
            message = {**message, "headers": [*message.get("headers", ()), (b"x-request-id", self._number)]}
        elif kind == f"{ANSWERED}.start":
            self.status, self._closed = message["status"], True
            headers = self._headers.complete(self.status, message.get("headers", ()), self._number)
            message = {**message, "headers": headers}
        elif kind == "websocket.send":
            await self._say(message)
            return
        elif kind == "websocket.close":
            if not self.status:
                code = message.get("code", POLICY)
                await self._answer(code, _unopened(code))
                return
            self._closed = True
        await self._send(message)

    async def _say(self, message: Message) -> None:
        """Pass on a message; a client that takes none of them is left.

        Raises:
            ClientDisconnected: where it was, as if it had left.
        """
        if self._closed:
            raise ClientDisconnected
        with self._untaken.held(self._client, len(message.get("bytes") or message.get("text") or "")) as has_room:
            if has_room:
                await self._send(message)
            else:
                REFUSALS.labels(TOO_MUCH.reason).inc()
                self._closed = True
                await self._send({"type": "websocket.close", "code": TOO_MUCH.code})
                raise ClientDisconnected

    async def refuse(self, refusal: Refusal) -> None:
        """Answer in place of the application, before it is open."""
        REFUSALS.labels(refusal.reason).inc()
        await self._answer(refusal.code, problem(refusal.error, refusal.status, headers=refusal.headers))

    async def fail(self, response: JSONResponse) -> None:
        """End it as something that went wrong; with an answer where it is not open yet."""
        # The client may have left, and the application said so in an error of its own.
        with contextlib.suppress(OSError, RuntimeError):
            if not self.status:
                await self._answer(FAILED, response)
            elif not self._closed:
                await self.send({"type": "websocket.close", "code": FAILED})

    def end(self) -> None:
        """Count it no more."""
        self._end_turn()
        if self.status == OPEN:
            SOCKETS.labels(self._route).dec()

    def _end_turn(self) -> None:
        if self._has_turn:
            self._has_turn = False
            # What the event loop computes itself takes no time by its own reckoning: given back at once, the turn would
            # go from socket to socket of this client, all of them, before anybody else is heard.
            asyncio.get_running_loop().call_soon(self._turns.release)

    async def _answer(self, code: int, response: JSONResponse) -> None:
        self._closed, self.status = True, response.status_code
        if ANSWERED not in (self.scope.get("extensions") or ()):
            await self._send({"type": "websocket.close", "code": code})
            return
        headers = self._headers.complete(self.status, response.raw_headers, self._number)
        await self._send({"type": f"{ANSWERED}.start", "status": self.status, "headers": headers})
        await self._send({"type": f"{ANSWERED}.body", "body": response.body, "more_body": False})


def _unopened(code: int) -> JSONResponse:
    """What a route says that closes a socket instead of opening it."""
    if code == TRY_LATER:
        return problem(InputError("socket", "must be tried again later", code), 503, headers=LATER)
    return problem(InputError("socket", "must be asked for by a page that may", code), 403)
