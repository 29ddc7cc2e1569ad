"""What every request and every socket passes first, whatever it is for: numbers, limits, headers, errors, figures."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import Collection
from random import getrandbits
from typing import Any, cast

from fastapi import FastAPI
from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketDisconnect
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware
from uvicorn.protocols.utils import ClientDisconnected

from server import errors, metrics
from server.access import Access
from server.channel import Channel, Hearing
from server.clients import CLIENT, Client, client_at, is_forwarded, proxies_of, watchers_of
from server.exchange import Exchange, too_large
from server.headers import Headers
from server.limits import Places
from server.problem import REQUEST
from server.routes import template
from server.screen import TRY_LATER, Refusal, Screen
from server.settings import Settings
from server.untaken import Untaken
from tracker_core.checks import InputError

HEALTH = frozenset(("/livez", "/readyz"))
"""Where this machine and the proxies ask again and again whether the server lives."""

NUMBER = re.compile(rb"[A-Za-z0-9-]{1,64}")
"""What a proxy may call a request."""

LATER = {"Retry-After": "5"}

OPENING_SECONDS = 30.0
"""Within which a socket has to be opened or refused."""

ENDED = Refusal(
    "ended",
    InputError("server", "must be asked again: it ended what it was doing", "one request"),
    503,
    LATER,
    TRY_LATER,
)
"""Of what was still being worked on when the server stopped, and of sockets that were not opened in time."""


class Guard:
    """An application behind its limits; the outermost of all.

    Args:
        app: what is guarded.
        settings: `proxies`, `frames`, `body_kb`, `requests_per_second`, `requests_at_once`, `sockets`,
            `sockets_per_client` and `metrics_token` of them.
        own_bounds: methods and paths of what bounds its bodies itself.
    """

    def __init__(self, app: ASGIApp, settings: Settings, own_bounds: Collection[tuple[str, str]] = ()) -> None:
        self._app = app
        self._headers = Headers(settings.frames)
        self._most = int(settings.body_kb * 1024)
        self._own_bounds = frozenset(own_bounds)
        self._screen = Screen(settings.requests_per_second, settings.requests_at_once)
        self._places = Places(settings.sockets, settings.sockets_per_client)
        self._hearing = Hearing()
        self._untaken = Untaken()
        self._access = Access()
        self._token = settings.metrics_token
        self._is_proxy, self._watches = proxies_of(settings.proxies), watchers_of(settings.proxies)
        # It puts the client that a proxy names in the place of the proxy. uvicorn is not told of proxies: here it has
        # to be known as well whether one was asked, and whether it is trusted.
        self._behind = ProxyHeadersMiddleware(cast(Any, self._known), settings.proxies or [])

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve, and never raise."""
        if scope["type"] == "lifespan":
            async with metrics.lateness():
                await self._app(scope, receive, send)
            return
        headers = dict(scope["headers"])
        peer = scope.get("client")
        number = headers.get(b"x-request-id", b"")
        if not (peer and self._is_proxy(peer[0]) and NUMBER.fullmatch(number)):
            # To tell requests apart, nothing to be kept from anybody.
            number = b"%016x" % getrandbits(64)
        state = scope.setdefault("state", {})
        state["request"], state["headers"] = number.decode(), headers
        await self._behind(cast(Any, scope), cast(Any, receive), cast(Any, send))

    async def _known(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers: dict[bytes, bytes] = scope["state"].pop("headers")
        request: str = scope["state"]["request"]
        address = scope.get("client")
        client = client_at(address[0] if address else "")
        token, known = REQUEST.set(request), CLIENT.set(client.key)
        try:
            if scope["type"] == "http":
                exchange = Exchange(scope, receive, send, self._headers, request, client.key, self._untaken)
                await self._request(exchange, headers, client)
            else:
                channel = Channel(
                    scope, receive, send, self._headers, request, client.key, self._hearing, self._untaken
                )
                await self._socket(channel, headers, client)
        finally:
            CLIENT.reset(known)
            REQUEST.reset(token)

    # Requests --------------------------------------------------------------------------------------------------------

    async def _request(self, exchange: Exchange, headers: dict[bytes, bytes], client: Client) -> None:
        begun = time.perf_counter()
        scope = exchange.scope
        is_quiet = self._is_quiet(scope, headers, client)
        try:
            refusal = self._screen.refusal(scope, headers, client.key, is_limited=not is_quiet)
            if refusal is None:
                refusal = self._bound(exchange, headers)
            if refusal is None:
                await self._answered(exchange)
            else:
                await exchange.refuse(refusal)
        finally:
            self._access.request(exchange, client, begun, is_quiet=is_quiet)

    def _is_quiet(self, scope: Scope, headers: dict[bytes, bytes], client: Client) -> bool:
        """Whether it is asked again and again by a machine that may: it is not limited, and not worth a line."""
        if scope["path"] in HEALTH:
            address = scope.get("client")
            # What somebody asks through a proxy is no question of the proxy's own.
            return address is not None and self._watches(address[0]) and not is_forwarded(headers)
        return scope["path"] == metrics.PATH and metrics.is_admitted(headers, client, self._token)

    def _bound(self, exchange: Exchange, headers: dict[bytes, bytes]) -> Refusal | None:
        """Bound a body that is coming; refuse one that says itself that it is too large."""
        scope = exchange.scope
        declared = headers.get(b"content-length")
        # Of HTTP/1, a request without either header has no body.
        none_comes = declared in (None, b"0") and b"transfer-encoding" not in headers
        if (none_comes and scope["http_version"].startswith("1")) or (
            (scope["method"], scope["path"]) in self._own_bounds
        ):
            return None
        exchange.bound(self._most)
        if declared is not None and declared.isdigit() and int(declared) > self._most:
            return too_large(self._most, int(declared))
        return None

    async def _answered(self, exchange: Exchange) -> None:
        failure: Exception | None = None
        try:
            await self._app(exchange.scope, exchange.receive, exchange.send)
        except asyncio.CancelledError:
            # By uvicorn, once the time for what is in flight is over; nobody else waits for this task.
            if not exchange.status:
                await exchange.refuse(ENDED)
            return
        except Exception as error:  # noqa: BLE001 - whatever it is, it is logged and answered
            failure = error
        failure = failure or errors.kept(exchange.scope)
        # What follows from a refusal, or from a request that broke off, is nobody's mistake.
        if failure is None or isinstance(failure, ClientDisconnect) or exchange.refused or exchange.gone:
            return
        errors.log(failure, exchange.scope, template(exchange.scope))
        await exchange.answer(errors.unanswered())

    # Sockets ---------------------------------------------------------------------------------------------------------

    async def _socket(self, channel: Channel, headers: dict[bytes, bytes], client: Client) -> None:
        begun = time.perf_counter()
        scope = channel.scope
        try:
            refusal = self._screen.refusal(scope, headers, client.key)
            if refusal is not None:
                await channel.refuse(refusal)
            elif self._places.enter(client.key):
                try:
                    await self._served(channel)
                finally:
                    self._places.leave(client.key)
                    channel.end()
            else:
                error = InputError("socket", "must wait: as many as may be are open", "one more")
                await channel.refuse(Refusal("sockets", error, 503, LATER, TRY_LATER))
        finally:
            self._access.socket(channel, client, begun)

    async def _served(self, channel: Channel) -> None:
        failure: Exception | None = None
        task = cast(asyncio.Task[Any], asyncio.current_task())
        opening = asyncio.get_running_loop().call_later(OPENING_SECONDS, lambda: channel.status or task.cancel())
        try:
            await self._app(channel.scope, channel.receive, channel.send)
        except asyncio.CancelledError:
            # By uvicorn, as above, or because it was not opened in time; one that is open has been told why it ends.
            if not channel.status:
                await channel.refuse(ENDED)
            return
        except Exception as error:  # noqa: BLE001 - whatever it is, it is logged and ends the socket
            failure = error
        finally:
            opening.cancel()
        failure = failure or errors.kept(channel.scope)
        if failure is None or isinstance(failure, (WebSocketDisconnect, ClientDisconnected)):
            return
        errors.log(failure, channel.scope, template(channel.scope))
        await channel.fail(errors.unanswered())


def attach(server: FastAPI, settings: Settings, own_bounds: Collection[tuple[str, str]] = ()) -> None:
    """Put an application behind a guard, see `Guard`; after everything else that comes between, before it serves."""
    errors.attach(server)
    server.add_middleware(Guard, settings=settings, own_bounds=own_bounds)
