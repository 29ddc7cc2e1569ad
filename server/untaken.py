"""Large answers lie in memory until their clients have taken them: how much of that there may be."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from server.limits import Places
from server.metrics import UNTAKEN
from server.screen import TRY_LATER, Refusal
from tracker_core.checks import InputError

LARGE = 64 * 1024
"""Bytes; what is no more is given to the network whole, and how much that keeps for a connection is bounded."""

MOST, MOST_OF_ONE = 256_000_000, 128_000_000
"""Bytes of large answers, and of those of one client: forty who take none have 3 MB each."""

TOO_MUCH = Refusal(
    "untaken",
    InputError("answers", f"must be taken: of one client at most {MOST_OF_ONE // 1_000_000} MB wait for that", "more"),
    503,
    {"Retry-After": "5"},
    TRY_LATER,
)


class Untaken:
    """Bytes of large answers that are being sent, by client."""

    def __init__(self) -> None:
        self._places = Places(MOST, MOST_OF_ONE)

    @contextlib.contextmanager
    def held(self, client: str, size: int) -> Iterator[bool]:
        """While so many bytes are being sent to a client; whether there is room for them."""
        if size <= LARGE:
            yield True
            return
        if not self._places.enter(client, size):
            yield False
            return
        UNTAKEN.inc(size)
        try:
            yield True
        finally:
            UNTAKEN.dec(size)
            self._places.leave(client, size)
