"""What cannot be answered: the one shape of every refusal, with the number that the log knows the request by."""

from __future__ import annotations

from collections.abc import Mapping
from contextvars import ContextVar

from fastapi.responses import JSONResponse

from tracker_core.checks import InputError, show

REQUEST: ContextVar[str] = ContextVar("request", default="")
"""Number of the request that is being answered; empty outside one."""


def said(error: InputError, message: str = "") -> dict[str, str]:
    """What is said of it, over HTTP or a socket: `{field, rule, received, message, request}`.

    Args:
        error: what is wrong with what.
        message: for a person; the error's own words if left out.
    """
    return {
        "field": error.field,
        "rule": error.rule,
        "received": show(error.received),
        "message": message or str(error),
        "request": REQUEST.get(),
    }


def problem(
    error: InputError, status: int, message: str = "", headers: Mapping[str, str] | None = None
) -> JSONResponse:
    """The answer to what cannot be answered, which nobody may keep: the next one may be another.

    Args:
        error: what is wrong with what.
        status: of HTTP.
        message: for a person; the error's own words if left out.
        headers: more of them.
    """
    return JSONResponse(said(error, message), status, {"Cache-Control": "no-store", **(headers or {})})
