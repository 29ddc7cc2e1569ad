"""What the proxy and the host of the scenes have in common: one connected browser and its token."""

from __future__ import annotations

import asyncio
import contextlib
import re
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import viser

    from layouts.scenes.region import RegionScene
    from layouts.scenes.track import TrackScene

TOKEN = re.compile(r"[0-9a-f]{32}")
"""Minted by the browser; whoever knows it sees the scene."""


@dataclass(frozen=True, slots=True)
class Stats:
    """How much there is: connected browsers and remembered pictures."""

    sessions: int
    pictures: int


class RefusedError(Exception):
    """A session that may not begin.

    Attributes:
        full: whether there are too many already.
    """

    def __init__(self, *, full: bool) -> None:
        super().__init__()
        self.full = full


@dataclass(slots=True, eq=False, repr=False)
class Session:
    """One connected browser. Its token is kept out of every message.

    Attributes:
        token: of the browser.
        owner: the client whose it is, as limits know it.
        key: by which viser's side of the connection is told from others; known to this process alone.
        loop: of the proxy.
        ended: set when it must end.
        active: when something was last shown or the camera moved, s.
        client: viser's handle of the browser; None before its camera is placed.
        scene: what is drawn in it; None before a picture is.
    """

    token: str
    owner: str
    key: str
    loop: asyncio.AbstractEventLoop
    active: float
    ended: asyncio.Event = field(default_factory=asyncio.Event)
    client: viser.ClientHandle | None = None
    scene: RegionScene | TrackScene | None = None

    def touch(self) -> None:
        """Something happened."""
        self.active = time.monotonic()

    def end(self) -> None:
        """Ask the proxy to close it, from any thread."""
        with contextlib.suppress(RuntimeError):  # a loop that is closed has no sessions any more
            self.loop.call_soon_threadsafe(self.ended.set)
