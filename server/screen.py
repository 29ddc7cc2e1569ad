"""What is refused before any page sees it, whatever it is about: too often, too long, from elsewhere."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field

from starlette.types import Scope

from server.limits import Buckets, Rate
from server.origin import same_origin
from tracker_core.checks import InputError

LONGEST_ADDRESS = 8192
"""Bytes; a link has 2,000."""

MOST_HEADERS, LARGEST_HEADERS = 100, 16_384
"""And bytes of all of them: what logs people in for a whole university may set cookies of several thousand."""

SAFE = frozenset(("GET", "HEAD", "OPTIONS", "TRACE"))

FOREIGN = (b"cross-site", b"same-site")
"""What a browser says of a request that a page of another server sent."""

POLICY, TRY_LATER = 1008, 1013
"""Codes that a socket is closed with."""

BEFORE = "refusal"
"""Name in a scope's state of a refusal by who reads from the network: of what cannot be read, or finds no place."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why something is refused.

    Attributes:
        reason: that it is counted by.
        error: what is wrong with what.
        status: of HTTP.
        headers: more of them.
        code: that a socket is closed with.
    """

    reason: str
    error: InputError
    status: int
    headers: Mapping[str, str] = field(default_factory=dict)
    code: int = POLICY


CROWDED = Refusal(
    "connections",
    InputError("connections", "must wait: as many as may be are open", "one more"),
    503,
    {"Retry-After": "5", "Connection": "close"},
    TRY_LATER,
)
"""Of who came when all places for connections were taken; who looks whether the server lives needs none."""


class Screen:
    """What looks at requests and sockets before anything else does.

    Args:
        per_second: requests of one client, for long.
        at_once: requests of one client, in a burst.
    """

    def __init__(self, per_second: float, at_once: float) -> None:
        self._rule = f"must be at most {per_second:g} a second of one address"
        self._asked = Buckets(Rate(per_second, at_once))

    def refusal(
        self, scope: Scope, headers: Mapping[bytes, bytes], client: str, *, is_limited: bool = True
    ) -> Refusal | None:
        """Why it is refused; None where it is not.

        Args:
            scope: of the request or socket.
            headers: of it, by name.
            client: that it is counted for.
            is_limited: whether it is counted at all, and needs a place.
        """
        before: Refusal | None = scope["state"].pop(BEFORE, None)
        if before is not None and (is_limited or before is not CROWDED):
            return before
        wait = self._asked.take(client, time.monotonic()) if is_limited else 0.0
        if wait:
            later = {"Retry-After": str(math.ceil(wait))}
            return Refusal("rate", InputError("requests", self._rule, "more"), 429, later, TRY_LATER)
        return too_long(scope) or _from_elsewhere(scope, headers)


def too_long(scope: Scope) -> Refusal | None:
    """Why it is refused for the length of its address or its headers; None where it is not."""
    length = len(scope.get("raw_path") or b"") + len(scope["query_string"])
    if length > LONGEST_ADDRESS:
        rule = f"must have at most {LONGEST_ADDRESS} characters"
        return Refusal("address", InputError("address", rule, length), 414)
    headers = scope["headers"]
    size = sum(len(name) + len(value) for name, value in headers)
    if size > LARGEST_HEADERS or len(headers) > MOST_HEADERS:
        rule = f"must be at most {MOST_HEADERS}, of {LARGEST_HEADERS} characters together"
        return Refusal("headers", InputError("headers", rule, f"{len(headers)} of {size}"), 431)
    return None


def _from_elsewhere(scope: Scope, headers: Mapping[bytes, bytes]) -> Refusal | None:
    """Whether a page of another server sent it. A browser says so of every socket and of every change."""
    origin = headers.get(b"origin")
    if scope["type"] == "http":
        if scope["method"] in SAFE:
            return None
        foreign = headers.get(b"sec-fetch-site") in FOREIGN
        if origin is None and not foreign:
            return None  # no browser's page
    else:
        foreign = False
    sent_from = origin.decode("latin-1") if origin is not None else None
    host = headers.get(b"host")
    if not foreign and same_origin(sent_from, host.decode("latin-1") if host is not None else None):
        return None
    return Refusal("origin", InputError("origin", "must be this server", sent_from), 403)
