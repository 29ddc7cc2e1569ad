"""The short way between a moving slider and the server: a socket beside Dash's callbacks.

A callback's answer passes through Dash's store in the browser, which costs it several times what computing, sending
and drawing together cost. While a slider moves, the page asks here instead; without a socket it falls back to the
callback.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from fastapi import FastAPI, WebSocket, WebSocketDisconnect

from server.origin import same_origin
from tracker_core.types import FloatArray

MESSAGE_LIMIT = 20_000
"""Characters of one question; a longer one ends the connection."""

Answer = Callable[[Mapping[str, Any]], tuple[Mapping[str, Any], Iterable[FloatArray]]]

POLICY, UNREADABLE, TOO_LARGE = 1008, 1003, 1009


def attach(server: FastAPI, path: str, answer: Answer, is_long: Callable[[Mapping[str, Any]], bool]) -> None:
    """Serve questions on a socket.

    Args:
        server: the application.
        path: of the socket.
        answer: from a question to the text part and the arrays of the answer.
        is_long: whether answering a question would hold up others; it then runs in a thread.
    """

    @server.websocket(path)
    async def socket(websocket: WebSocket) -> None:
        if not same_origin(websocket.headers.get("origin"), websocket.headers.get("host")):
            await websocket.close(POLICY)
            return
        await websocket.accept()
        try:
            while True:
                text = await websocket.receive_text()
                if len(text) > MESSAGE_LIMIT:
                    await websocket.close(TOO_LARGE)
                    return
                await websocket.send_bytes(await _reply(text, answer, is_long))
        except WebSocketDisconnect:
            return
        except (ValueError, TypeError, LookupError, AttributeError, RecursionError, OverflowError):
            await websocket.close(UNREADABLE)


async def _reply(text: str, answer: Answer, is_long: Callable[[Mapping[str, Any]], bool]) -> bytes:
    question = json.loads(text)
    if is_long(question):
        return framed(*await asyncio.to_thread(answer, question))
    return framed(*answer(question))


def framed(rest: Mapping[str, Any], arrays: Iterable[FloatArray]) -> bytes:
    """A message of text and numbers: length of the text (4 bytes), the text as JSON, padding, 32-bit floats."""
    text = json.dumps(rest).encode()
    text += b" " * (-len(text) % 4)
    return b"".join((len(text).to_bytes(4, "little"), text, *(array.tobytes() for array in arrays)))
