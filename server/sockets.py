"""Sockets that pages ask questions on: text of a bounded length, read against its description."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import TypeVar

from fastapi import WebSocket, WebSocketDisconnect

from server.problem import said
from server.typed import Reader
from tracker_core.checks import InputError

T = TypeVar("T")

MESSAGE_LIMIT = 20_000
"""Characters of one question; a longer one ends the connection."""

UNREADABLE, POLICY, TOO_LARGE = 1003, 1008, 1009
"""Codes that a connection is closed with."""


async def listen(
    websocket: WebSocket,
    read: Reader[T],
    hear: Callable[[T], Awaitable[None]],
    tell: Callable[[Mapping[str, str]], bytes],
) -> None:
    """Hear a page's questions, one after the other, until it goes away.

    What cannot be read is told in the shape of every refusal (see `problem`), and the connection closed.

    Args:
        websocket: of the page; not accepted yet.
        read: from a text to a question.
        hear: answers a question.
        tell: the message that says that something is refused, as this page expects messages.
    """
    await websocket.accept()
    try:
        while True:
            try:
                question = read(await _text(websocket))
            except InputError as error:
                await websocket.send_bytes(tell(said(error)))
                await websocket.close(TOO_LARGE if error.field == "message" else UNREADABLE)
                return
            await hear(question)
    except WebSocketDisconnect:
        return


async def _text(websocket: WebSocket) -> str:
    """The next question.

    Raises:
        WebSocketDisconnect: where the page has gone.
        InputError: for one that is too long (field `message`) or no text.
    """
    message = await websocket.receive()
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message["code"])
    text = message.get("text")
    if text is None:
        raise InputError("question", "must be text", "bytes")
    if len(text) > MESSAGE_LIMIT:
        raise InputError("message", f"must have at most {MESSAGE_LIMIT:,} characters", len(text))
    return str(text)
