"""The short way between a moving slider and the server: a socket beside Dash's callbacks.

A callback's answer passes through Dash's store in the browser, which costs it several times what computing, sending
and drawing together cost. While a slider moves, the page asks here instead; without a socket it falls back to the
callback.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import orjson
from fastapi import FastAPI, WebSocket

from layouts.questions import Question
from server.problem import said
from server.sockets import listen
from server.typed import Reader
from server.work import NoAnswerError, Work
from tracker_core.types import FloatArray

Answer = Callable[[Question], tuple[Mapping[str, Any], Iterable[FloatArray]]]


def attach(server: FastAPI, path: str, read: Reader[Question], answer: Answer, work: Work) -> None:
    """Serve questions on a socket.

    Where there is no answer, the text part is `{seq, problem, again}`: what is wrong in the shape of every refusal, and
    after how many seconds to ask again (null for not at all). One to what cannot be read has no `seq`.

    Args:
        server: the application.
        path: of the socket.
        read: from a text to a question.
        answer: from a question to the text part and the arrays of the answer.
        work: where answers are made that would hold up others.
    """

    @server.websocket(path)
    async def socket(websocket: WebSocket) -> None:
        async def hear(question: Question) -> None:
            try:
                found = await work.run(answer, question) if question.is_long else answer(question)
            except NoAnswerError as error:
                found = {"seq": question.seq, "problem": said(error.error, error.message), "again": error.again}, ()
            await websocket.send_bytes(framed(*found))

        await listen(websocket, read, hear, lambda problem: framed({"problem": problem, "again": None}, ()))


def framed(rest: Mapping[str, Any], arrays: Iterable[FloatArray]) -> bytes:
    """A message of text and numbers: length of the text (4 bytes), the text as JSON, padding, 32-bit floats."""
    text = orjson.dumps(rest, option=orjson.OPT_SERIALIZE_NUMPY)
    text += b" " * (-len(text) % 4)
    return b"".join((len(text).to_bytes(4, "little"), text, *(array.tobytes() for array in arrays)))
