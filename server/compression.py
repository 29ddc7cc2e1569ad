"""Answers that are made anew for every request are compressed on their way out, in a time that nobody notices.

Most are seen once: they are compressed quickly. What comes a second time will come again, as the beginning of a page
does for everyone who opens the same link: it is compressed thoroughly and remembered.

Compressing lets a listener guess what stands beside something that he can choose. No answer of this server has a
secret in it, so there is nothing to guess.
"""

from __future__ import annotations

import asyncio
import hashlib
from collections import OrderedDict

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.codings import Coding, preferred, write

LEAST = 1_000
"""Bytes below which an answer is one packet anyway."""

LONG = 20_000
"""Bytes above which gzip, several times as slow as brotli, works in a thread."""

TEXTS = ("application/json", "text/")

REMEMBERED = 4_000
"""Answers that are recognised."""

REMEMBERED_BYTES = 8_000_000
"""Of compressed answers that are remembered."""


class Memory:
    """Compressed answers by their content; what was used longest ago is forgotten first.

    Args:
        most: answers that are recognised.
        most_bytes: of compressed ones.
    """

    def __init__(self, most: int = REMEMBERED, most_bytes: int = REMEMBERED_BYTES) -> None:
        self.most, self.most_bytes = most, most_bytes
        self._known: OrderedDict[tuple[bytes, Coding], bytes] = OrderedDict()
        self._bytes = 0

    async def written(self, body: bytes, coding: Coding) -> bytes:
        """The answer in a coding."""
        key = hashlib.blake2b(body, digest_size=16).digest(), coding
        known = self._known.get(key)
        if known:
            self._known.move_to_end(key)
            return known
        if known is None:
            self._keep(key, b"")
            if coding == "gzip" and len(body) > LONG:
                return await asyncio.to_thread(write, body, coding, "quick")
            return write(body, coding, "quick")
        data = await asyncio.to_thread(write, body, coding, "thorough")
        self._keep(key, data)
        return data

    def _keep(self, key: tuple[bytes, Coding], data: bytes) -> None:
        self._bytes += len(data) - len(self._known.pop(key, b""))
        self._known[key] = data
        while len(self._known) > self.most or self._bytes > self.most_bytes:
            self._bytes -= len(self._known.popitem(last=False)[1])


class Compression:
    """Compresses whole answers of text; streams and what is compressed already pass as they are.

    Args:
        app: makes the answers.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app
        self.memory = Memory()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the application answer, and send that smaller."""
        coding = preferred(Headers(scope=scope).get("accept-encoding", "")) if scope["type"] == "http" else "identity"
        if coding == "identity" or scope["method"] == "HEAD":
            await self.app(scope, receive, send)
            return
        start: Message | None = None

        async def smaller(message: Message) -> None:
            nonlocal start
            if message["type"] == "http.response.start" and _is_text(Headers(raw=message["headers"])):
                # What is said of the body is known when the body is.
                start = message
                return
            if start is not None:
                held, start = start, None
                if message["type"] == "http.response.body" and not message.get("more_body"):
                    message = {**message, "body": await self._body(held, message.get("body", b""), coding)}
                await send(held)
            await send(message)

        await self.app(scope, receive, smaller)

    async def _body(self, start: Message, body: bytes, coding: Coding) -> bytes:
        headers = MutableHeaders(raw=list(start["headers"]))
        headers.add_vary_header("Accept-Encoding")
        if len(body) >= LEAST:
            body = await self.memory.written(body, coding)
            headers["Content-Encoding"] = coding
            headers["Content-Length"] = str(len(body))
        start["headers"] = headers.raw
        return body


def _is_text(headers: Headers) -> bool:
    # Dash does not say of what type its answers are; it is JSON.
    kind = headers.get("content-type", "application/json")
    return "content-encoding" not in headers and kind.startswith(TEXTS)
