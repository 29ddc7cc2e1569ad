"""One socket, as its messages pass."""

from __future__ import annotations

import asyncio
import contextlib
import time

from fastapi.responses import JSONResponse
from starlette.types import Message, Receive, Scope, Send

from server.headers import Headers
from server.limits import Rate
from server.metrics import MESSAGES, REFUSALS, SOCKETS
from server.problem import problem
from server.routes import template
from server.screen import POLICY, TRY_LATER, Refusal
from tracker_core.checks import InputError

PACE = Rate(per_second=100, at_once=100)
"""Messages of one socket; a slider under a mouse sends 60 a second. More of them wait, in the end in the network."""

OPEN = 101
"""Status of a socket that was opened."""

FAILED = 1011

LATER = {"Retry-After": "5"}

ANSWERED = "websocket.http.response"
"""Extension by which a socket that is not opened can be answered like any other request."""


class Channel:
    """One socket. Messages pass as they come, and no faster than `PACE`.

    Args:
        scope: of the socket.
        receive, send: to and from the network.
        headers: that answers get.
        request: its number.

    Attributes:
        scope: of the socket.
        status: of the answer: OPEN once it is open, 0 before there is one.
    """

    __slots__ = ("_closed", "_full", "_headers", "_number", "_receive", "_route", "_send", "scope", "status")

    def __init__(self, scope: Scope, receive: Receive, send: Send, headers: Headers, request: str) -> None:
        self.scope, self._receive, self._send = scope, receive, send
        self._headers, self._number = headers, request.encode()
        self._full, self._route, self._closed = 0.0, "", False
        self.status = 0

    async def receive(self) -> Message:
        """The next message, once it is its turn."""
        # The wait comes first: who gives up waiting has lost no message.
        wait = PACE.wait(self._full, time.monotonic())
        if wait:
            await asyncio.sleep(wait)
        message = await self._receive()
        if message["type"] == "websocket.receive":
            self._full = PACE.taken(self._full, time.monotonic())
            MESSAGES.labels(self._route).inc()
        return message

    async def send(self, message: Message) -> None:
        """Pass on what the application says."""
        kind = message["type"]
        if kind == "websocket.accept":
            self.status, self._route = OPEN, template(self.scope)
            SOCKETS.labels(self._route).inc()
            message = {**message, "headers": [*message.get("headers", ()), (b"x-request-id", self._number)]}
        elif kind == f"{ANSWERED}.start":
            self.status, self._closed = message["status"], True
            headers = self._headers.complete(self.status, message.get("headers", ()), self._number)
            message = {**message, "headers": headers}
        elif kind == "websocket.close":
            if not self.status:
                code = message.get("code", POLICY)
                await self._answer(code, _unopened(code))
                return
            self._closed = True
        await self._send(message)

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
        if self.status == OPEN:
            SOCKETS.labels(self._route).dec()

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
