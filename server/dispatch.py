"""Dash's callbacks, each asked as it was declared or not at all.

Dash takes the body of a request as it comes. Here it is read against one description: an output that there is, the
inputs that its callback declares, and of every input the type that was described for it. A callback receives that type.
"""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import Awaitable, Callable, Mapping
from functools import partial
from typing import Annotated, Any

from dash import Dash
from dash.backends._fastapi import FastAPIDashServer, get_current_request
from fastapi import FastAPI, Request, Response
from msgspec import Meta

from server.callbacks import Declared, Given, Place, read_asked
from server.problem import problem
from server.typed import Reader, reader
from server.work import NoAnswerError, Work
from tracker_core.checks import InputError

_read_pathname: Reader[str] = reader(Annotated[str, Meta(max_length=1_000, pattern=r"^/")], "pathname")
_read_search: Reader[str] = reader(Annotated[str, Meta(max_length=8_000)], "search")


class Dispatch(FastAPIDashServer):
    """Dash on FastAPI with callbacks that are asked as declared, and without its socket."""

    # No callback of ours uses it; the route would be one more to defend.
    websocket_capability = False

    def __init__(self, server: FastAPI) -> None:
        super().__init__(server)
        # Of Dash's own callback, which changes pages.
        self._readers: dict[str, Reader[Any]] = {
            "_pages_location.pathname": _read_pathname, "_pages_location.search": _read_search,
        }  # fmt: skip
        self._declared: dict[str, Declared] = {}

    @staticmethod
    def create_app(name: str = "__main__", config: Mapping[str, Any] | None = None) -> FastAPI:
        """The application of FastAPI that everything is attached to."""
        del name, config
        return FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    def describe(self, place: str, read: Reader[Any]) -> None:
        """Say how the value of an input is read; see the function of that name."""
        self._readers[place] = read

    def finish(self, app: Dash, work: Work) -> None:
        """Take down what can be asked for; see the function of that name."""
        for prepare in self._before_request_funcs:
            waiting = prepare()
            if inspect.iscoroutine(waiting):
                asyncio.run(waiting)
        # Those without a function run in the browser alone.
        answered = {name: each for name, each in app.callback_map.items() if "callback" in each}
        for each in answered.values():
            if not inspect.iscoroutinefunction(each["callback"]):
                each["callback"] = _in_thread(each["callback"], work)
        self._declared = {name: Declared.of(each) for name, each in answered.items()}
        places = {str(place) for each in self._declared.values() for place in (*each.inputs, *each.state)}
        if undescribed := sorted(places - self._readers.keys()):
            raise LookupError(f"nothing describes {', '.join(undescribed)}")

    def serve_callback(self, dash_app: Dash) -> Callable[[Request], Awaitable[Response]]:
        """Answers callbacks."""
        answer = super().serve_callback(dash_app)

        async def dispatch(request: Request) -> Response:
            # A body can be received only once, and Dash's middleware has.
            asked: Request = get_current_request()
            kind = asked.headers.get("content-type", "")
            if kind.partition(";")[0].strip().lower() != "application/json":
                return problem(InputError("Content-Type", "must be application/json", kind), 415)
            try:
                asked.state.json_body = self._checked(await asked.body())
                response: Response = await answer(request)
            except InputError as error:
                return problem(error, 400)
            except NoAnswerError as error:
                return error.response()
            return response

        return dispatch

    def _checked(self, body: bytes) -> dict[str, Any]:
        """A body as Dash takes it, every value of the type that is described.

        Raises:
            InputError: naming what is not as described.
        """
        asked = read_asked(body)
        declared = self._declared.get(asked.output)
        if declared is None:
            raise InputError("output", "must be one that this server computes", asked.output)
        declared.check(asked)
        outputs = asked.outputs
        return {
            "output": asked.output,
            "outputs": outputs.plain() if isinstance(outputs, Place) else [each.plain() for each in outputs],
            "inputs": [self._value(each) for each in asked.inputs],
            "state": [self._value(each) for each in asked.state],
            "changedPropIds": asked.changed_prop_ids,
        }

    def _value(self, given: Given) -> dict[str, Any]:
        place = given.place
        return {**place.plain(), "value": self._readers[str(place)](bytes(given.value))}


def _in_thread(callback: Callable[..., str], work: Work) -> Callable[..., Awaitable[str]]:
    async def threaded(*arguments: Any, **more: Any) -> str:
        return await work.run(partial(callback, *arguments, **more))

    return threaded


def describe(app: Dash, place: str, read: Reader[Any]) -> None:
    """Say how the value of a callback's input is read.

    Args:
        app: whose callback it is.
        place: component and property of the input: "page-request.data".
        read: from JSON to what the callback receives.
    """
    _backend(app).describe(place, read)


def finish(app: Dash, work: Work) -> None:
    """Do what Dash leaves to the first request, and close what can be asked; once everything else is attached.

    A page other than the first would be answered before the pages' own callbacks are there.

    Args:
        app: the application.
        work: where callbacks run that do not await, as Dash's own does, which lays out a page: nobody else is to wait
            until the recording is read that a link names.

    Raises:
        LookupError: for an input of a callback that nothing describes.
    """
    _backend(app).finish(app, work)


def _backend(app: Dash) -> Dispatch:
    backend = app.backend
    if not isinstance(backend, Dispatch):
        raise TypeError(f"the application must be made with backend=Dispatch, not {type(backend).__name__}")
    return backend
