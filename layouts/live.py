"""The short way between a moving slider and the server: a socket beside Dash's callbacks.

A callback's answer passes through Dash's store in the browser, which costs it several times what computing, sending
and drawing together cost. While a slider moves, the page asks here instead; without a socket it falls back to the
callback.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping
from typing import Any

import orjson
from fastapi import FastAPI, WebSocket

from layouts.questions import Question
from server.problem import said
from server.sockets import listen
from server.typed import Reader
from server.work import NoAnswerError
from tracker_core.types import FloatArray


def attach(server: FastAPI, path: str, read: Reader[Question], give: Callable[[Question], Awaitable[bytes]]) -> None:
    """Serve questions on a socket.

    Where there is no answer, the text part is `{seq, problem, again}`: what is wrong in the shape of every refusal, and
    after how many seconds to ask again (null for not at all). One to what cannot be read has no `seq`.

    Args:
        server: the application.
        path: of the socket.
        read: from a text to a question.
        give: answers a question with a message (see `framed`); raises NoAnswerError.
    """

    @server.websocket(path)
    async def socket(websocket: WebSocket) -> None:
        async def hear(question: Question) -> None:
            try:
                message = await give(question)
            except NoAnswerError as error:
                problem = said(error.error, error.message)
                message = framed({"seq": question.seq, "problem": problem, "again": error.again}, ())
            await websocket.send_bytes(message)

        await listen(websocket, read, hear, lambda problem: framed({"problem": problem, "again": None}, ()))


def framed(rest: Mapping[str, Any], arrays: Iterable[FloatArray]) -> bytes:
    """A message of text and numbers: length of the text (4 bytes), the text as JSON, padding, 32-bit floats."""
    text = orjson.dumps(rest, option=orjson.OPT_SERIALIZE_NUMPY)
    text += b" " * (-len(text) % 4)
    return b"".join((len(text).to_bytes(4, "little"), text, *(array.tobytes() for array in arrays)))
