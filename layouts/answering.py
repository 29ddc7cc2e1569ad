"""A page's callbacks and its socket, and where their answers are computed.

That is here, in a thread where they take long, or by a helper where there is one. An answer is bytes as soon as it is
made: so it can come from another process, and is written in JSON once.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import Any

import msgspec
import orjson
from dash import ClientsideFunction, Dash, Input, Output, no_update

from layouts import live
from layouts.desk import Desk, answer, live_answer, reader_of
from layouts.questions import Question
from layouts.services import Services
from server.dispatch import describe
from server.helpers import HelperGoneError
from server.metrics import COMPUTING, computing
from server.work import ANSWERS

_JSON = orjson.OPT_NON_STR_KEYS | orjson.OPT_SERIALIZE_NUMPY


def moving(desk: Desk, question: Question) -> bytes:
    """What a page's socket sends while a slider moves."""
    return live.framed(*live_answer(desk, question))


def full(desk: Desk, question: Question) -> bytes:
    """What a page's callback puts out: MessagePack of one JSON text per output, nil where there is nothing new."""
    updates, rest = answer(desk, question)
    return msgspec.msgpack.encode([None if each is no_update else _text(each) for each in (*updates, rest)])


def _text(value: Any) -> bytes:
    return orjson.dumps(value, option=_JSON, default=lambda part: part.to_plotly_json())


_outputs = msgspec.msgpack.Decoder(list[bytes | None]).decode


def outputs(packed: bytes) -> tuple[Any, ...]:
    """What `full` gave, as Dash takes it."""
    return tuple(no_update if text is None else orjson.Fragment(text) for text in _outputs(packed))


KINDS: dict[str, Callable[[Desk, Question], bytes]] = {"live": moving, "full": full}


async def give(services: Services, name: str, function: Callable[[Question], bytes], question: Question) -> bytes:
    """The answer to a question, computed where it holds nobody up.

    Args:
        services: threads for what takes long, helpers for the rest, and scenes.
        name: of the function, as helpers know it.
        function: computes the answer.
        question: that is answered.

    Raises:
        NoAnswerError: where too many wait already, or it takes too long.
    """
    if question.is_long:
        return await services.work.run(function, question)
    try:
        found = await services.helpers.compute(name, partial(msgspec.json.encode, question))
    except HelperGoneError:
        # It may be what the helper was lost to: the event loop is not to be lost to it as well.
        return await services.work.run(function, question)
    if found is None:
        with computing(ANSWERS):
            return function(question)
    message, picture, seconds = _found(found)
    COMPUTING.labels(ANSWERS).observe(seconds)
    if picture:
        # The scene is in this process.
        services.scenes.show(question.scene, pickle.loads(picture))  # noqa: S301 - from a process of our own
    return message


def found_by_helper(desk: Desk, kind: str) -> Callable[[Question], bytes]:
    """What computes in a helper what `give` takes from one.

    That is the answer, the picture for the page's scene if any, and the seconds that computing took.
    """
    pictures: list[Any] = []
    function = partial(KINDS[kind], replace(desk, show=lambda _, picture: pictures.append(picture)))

    def find(question: Question) -> bytes:
        pictures.clear()
        begun = perf_counter()
        message = function(question)
        picture = pickle.dumps(pictures[-1], 5) if pictures else b""
        return msgspec.msgpack.encode((message, picture, perf_counter() - begun))

    return find


_found = msgspec.msgpack.Decoder(tuple[bytes, bytes, float]).decode


def register(app: Dash, desk: Desk, services: Services) -> None:
    """Attach a page's callbacks and its socket."""
    page, read, shown = desk.page, reader_of(desk), replace(desk, show=services.scenes.show)
    by_callback, by_socket = (
        partial(give, services, f"{page} {kind}", partial(KINDS[kind], shown)) for kind in ("full", "live")
    )
    app.clientside_callback(
        ClientsideFunction("desk", "begin"), Output(f"{page}-begun", "data"), Input(f"{page}-beginning", "data")
    )
    app.clientside_callback(
        ClientsideFunction("desk", "finish"),
        Output(f"{page}-answered", "data"),
        Input(f"{page}-answer", "data"),
        prevent_initial_call=True,
    )

    @app.callback(
        *[Output(plot, "figure") for plot in desk.plots],
        *[Output(place, "children") for place in desk.tables],
        Output(f"{page}-answer", "data"),
        Input(f"{page}-request", "data"),
        prevent_initial_call=True,
    )
    async def update(question: Question) -> tuple[Any, ...]:
        return outputs(await by_callback(question))

    describe(app, f"{page}-request.data", read)
    live.attach(app.server, f"/{page}/live", read, by_socket)
