"""One request and its answer, as their parts pass."""

from __future__ import annotations

import asyncio
import time

from fastapi.responses import JSONResponse
from starlette.types import Message, Receive, Scope, Send

from server.headers import Headers
from server.metrics import REFUSALS
from server.problem import problem
from server.routes import Served
from server.screen import BEFORE, Refusal
from server.untaken import LARGE, TOO_MUCH, Untaken
from tracker_core.checks import InputError

BODY_SECONDS = 30.0
"""For which a body may be on its way."""

DRAINED, DRAIN_SECONDS = 32 * 1024 * 1024, 5.0
"""Bytes that are still read of what is too much, and for how long, so that who sends it hears why it is refused."""

PIECE = LARGE
"""Bytes of an answer that the network is given at a time. It takes whatever it is given, and says between two pieces
alone that the client has not taken what was there before."""

GONE: Message = {"type": "http.disconnect"}


class Exchange:
    """One request and its answer. Nothing is kept of either: what comes passes at once.

    What is too much or too slow of a body is refused here, as it comes. The application is told that the client has
    gone and whatever it says then is dropped: an exception might be answered by somebody in between, as Dash does.
    An answer that there is no room for is refused in its place, so its beginning waits for the first of its body.

    Args:
        scope: of the request.
        receive, send: to and from the network.
        headers: that answers get.
        request: its number.
        client: whose it is, as limits know it.
        untaken: large answers of all.

    Attributes:
        scope: of the request, as the application is to see it: HEAD is GET whose body is not sent.
        method: of the request, as it came.
        status: of the answer; 0 before there is one.
        size: bytes of the answer's body.
        began: when the answer began, in seconds of `time.perf_counter`; 0 before.
        refused: whether it was refused here.
        gone: whether the client left before its request was there in full.
    """

    __slots__ = (
        "_bound", "_client", "_deadline", "_head", "_headers", "_incomplete", "_number", "_over", "_receive",
        "_seconds", "_send", "_start", "_taken", "_untaken", "began", "gone", "method", "refused", "scope", "size",
        "status",
    )  # fmt: skip

    def __init__(
        self, scope: Scope, receive: Receive, send: Send, headers: Headers, request: str, client: str, untaken: Untaken
    ) -> None:
        self.method = scope["method"]
        self._head = self.method == "HEAD"
        self.scope = {**scope, "method": "GET"} if self._head else scope
        self._receive, self._send, self._headers, self._number = receive, send, headers, request.encode()
        self._client, self._untaken = client, untaken
        self._start: Message | None = None
        self._bound, self._seconds, self._deadline, self._taken, self._incomplete = 0, 0.0, 0.0, 0, False
        self.status, self.size, self.began = 0, 0, 0.0
        self.refused = self.gone = self._over = False

    def bound(self, most: int, seconds: float = BODY_SECONDS) -> None:
        """Bound the body that is coming.

        Args:
            most: bytes of it.
            seconds: from now on, for which it may be on its way.
        """
        self._bound, self._seconds, self._incomplete = most, seconds, True
        self._deadline = asyncio.get_running_loop().time() + seconds

    async def receive(self) -> Message:
        """The next part of the request."""
        message = await (self._bounded() if self._incomplete else self._receive())
        refusal = self.scope["state"].pop(BEFORE, None)
        if refusal is None:
            return message
        # In the middle of its body it has become none.
        await self.refuse(refusal)
        return GONE

    async def _bounded(self) -> Message:
        """The next part of a body that has bounds."""
        try:
            async with asyncio.timeout_at(self._deadline):
                message = await self._receive()
        except TimeoutError:
            error = InputError("body", f"must come in full within {self._seconds:g} s", f"{self._taken} bytes")
            await self.refuse(Refusal("slow", error, 408))
            return GONE
        if message["type"] != "http.request":
            self.gone = True
            return message
        self._taken += len(message.get("body", b""))
        if self._taken > self._bound:
            await self.refuse(too_large(self._bound, self._taken))
            return GONE
        self._incomplete = message.get("more_body", False)
        return message

    async def send(self, message: Message) -> None:
        """Pass on what the application says."""
        if not self._over:
            await self._pass(message)

    async def refuse(self, refusal: Refusal) -> None:
        """Answer in place of the application, if nothing was answered yet; whatever it says then does not count."""
        REFUSALS.labels(refusal.reason).inc()
        self.refused = True
        closing = {"Connection": "close"} if refusal.status in (408, 413) else {}
        response = problem(refusal.error, refusal.status, headers={**closing, **refusal.headers})
        await self.answer(response, drain=refusal.status == 413)

    async def answer(self, response: JSONResponse, *, drain: bool = False) -> None:
        """Send an answer in place of the application's, if it has not begun one: one that has ends with the connection.

        Args:
            response: the answer.
            drain: whether to read on for a while before the connection is closed: who is still sending would not
                hear of it otherwise.
        """
        if self._over:
            return
        self._over = True
        if self.status:
            return
        headers = response.raw_headers
        await self._pass({"type": "http.response.start", "status": response.status_code, "headers": headers})
        await self._pass({"type": "http.response.body", "body": response.body, "more_body": True})
        if drain:
            await self._drain()
        await self._pass({"type": "http.response.body", "body": b"", "more_body": False})

    async def _pass(self, message: Message) -> None:
        kind = message["type"]
        if kind == "http.response.start":
            self._start = message
            if self._head:
                self._over = True
                await self._begin()
                await self._send({"type": "http.response.body", "body": b"", "more_body": False})
            return
        if self._head:
            return
        body = message.get("body", b"") if kind == "http.response.body" else b""
        # A file is the same in memory for everybody.
        is_own = not isinstance(self.scope.get("route"), Served)
        with self._untaken.held(self._client, len(body) if is_own else 0) as has_room:
            if has_room:
                await self._begin()
                await self._give(message, body)
            else:
                await self.refuse(TOO_MUCH)

    async def _begin(self) -> None:
        """Send the beginning of the answer, if it was not."""
        if self._start is None:
            return
        start, self._start = self._start, None
        self.status, self.began = start["status"], time.perf_counter()
        headers = self._headers.complete(self.status, start.get("headers", ()), self._number)
        await self._send({**start, "headers": headers})

    async def _give(self, message: Message, body: bytes) -> None:
        """Send a part of the answer."""
        self.size += len(body)
        if len(body) <= PIECE:
            await self._send(message)
            return
        for start in range(0, len(body), PIECE):
            await self._send({**message, "body": body[start : start + PIECE], "more_body": True})
        if not message.get("more_body", False):
            # The answer ends once the client has taken most of it.
            await self._send({**message, "body": b""})

    async def _drain(self) -> None:
        left = DRAINED
        try:
            async with asyncio.timeout(DRAIN_SECONDS):
                while left > 0:
                    message = await self._receive()
                    left -= len(message.get("body", b""))
                    if not message.get("more_body", False):
                        return
        except TimeoutError:
            return


def too_large(most: int, received: int) -> Refusal:
    """Why a body is refused that is too large.

    Args:
        most: bytes that it may have.
        received: bytes that it has, or has had so far.
    """
    error = InputError("body", f"must have at most {most / 1024:g} kB", f"{received / 1024:.0f} kB")
    return Refusal("body", error, 413)
