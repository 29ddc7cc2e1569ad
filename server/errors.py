"""What goes wrong in the application: one shape of answer for all of it, and a traceback in the log alone."""

from __future__ import annotations

import logging
from http import HTTPStatus

from dash.exceptions import DependencyException, InvalidResourceError, PreventUpdate
from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.types import ASGIApp, Receive, Scope, Send

from server.metrics import ERRORS
from server.problem import REQUEST, problem
from tracker_core.checks import InputError

_LOG = logging.getLogger(__name__)

_FAILURE = "failure"

CALLBACKS = "/_dash-"
"""How the addresses begin that Dash answers callbacks at."""


class Innermost:
    """Next to the routes: keeps what they raise for the guard.

    Dash's own middleware would answer it in words of its own, and say nothing of it in the log.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve, and never raise but what Dash has to see."""
        try:
            await self._app(scope, receive, send)
        except PreventUpdate:
            # Nothing went wrong: Dash answers that nothing changes.
            raise
        except Exception as error:  # noqa: BLE001 - the guard logs and answers it
            scope["state"][_FAILURE] = error


def attach(server: FastAPI) -> None:
    """Answer what routes refuse, and keep what they raise; before the first request."""
    server.add_exception_handler(HTTPException, _refused)  # type: ignore[arg-type]
    server.add_exception_handler(RequestValidationError, _unreadable)  # type: ignore[arg-type]
    for absent in (InvalidResourceError, DependencyException):
        server.add_exception_handler(absent, _absent)
    server.user_middleware.append(Middleware(Innermost))


def kept(scope: Scope) -> Exception | None:
    """What a route raised, if it did."""
    failure = scope["state"].pop(_FAILURE, None)
    return failure if isinstance(failure, Exception) else None


def log(error: Exception, scope: Scope, route: str) -> None:
    """Log and count what could not be answered."""
    where = "socket" if scope["type"] == "websocket" else "callback" if route.startswith(CALLBACKS) else "route"
    ERRORS.labels(where, type(error).__name__).inc()
    _LOG.error("%s %s could not be answered, request %s", where, route, REQUEST.get(), exc_info=error)


def unanswered() -> JSONResponse:
    """The answer to what went wrong."""
    error = InputError("server", "could not answer; the log has more under this request's number", "")
    return problem(error, 500, f"the server {error.rule}")


def _refused(request: Request, error: HTTPException) -> Response:
    """What Starlette and FastAPI refuse."""
    path, status = request.scope["path"], error.status_code
    if status < 400:
        return Response(status_code=status, headers=error.headers)
    allowed = (error.headers or {}).get("Allow", "another one")
    named = {
        404: InputError("address", "must be one of this server", path),
        405: InputError("method", f"must be {allowed}", request.method),
    }
    rule = error.detail if error.detail != HTTPStatus(status).phrase else "cannot be answered"
    return problem(named.get(status, InputError("request", rule, path)), status, headers=error.headers)


def _unreadable(request: Request, error: RequestValidationError) -> Response:
    """A parameter or a body that is not as its route describes it."""
    del request
    first = error.errors()[0]
    field = str(first["loc"][-1]) if first["loc"] else "request"
    return problem(InputError(field, f"cannot be read: {first['msg']}", first.get("input")), 422)


def _absent(request: Request, error: Exception) -> Response:
    """A file of a package that Dash does not serve."""
    del error
    return problem(InputError("address", "must be one of this server", request.scope["path"]), 404)
