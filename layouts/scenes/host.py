"""The scenes of all browsers: one viser server of this process, reached through the proxy alone.

viser runs its own event loop in a thread. A scene is drawn there and nowhere else: `Scenes.show` only remembers the
picture and asks for it to be drawn, so it is quick, and of pictures that come faster than they are drawn the last
one is.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import threading
import time
from collections import OrderedDict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fastapi import FastAPI

from layouts.scenes import proxy
from layouts.scenes.parting import forget_traces, let_go
from layouts.scenes.pictures import Drawing, Picture, RegionPicture
from layouts.scenes.region import RegionScene
from layouts.scenes.sessions import TOKEN, RefusedError, Session, Stats
from layouts.scenes.track import TrackScene
from server.clients import CLIENT
from server.limits import share
from tracker_core.checks import InputError

if TYPE_CHECKING:
    import viser

LIMIT = 150
"""Sessions at a time."""

IDLE = 900.0
"""Seconds after which a session ends to which nothing is shown and whose camera does not move."""

REMEMBERED = 2
"""Pictures for each session that there may be, half of them one client's; the oldest is forgotten first."""

LIFETIME = 6 * 3600.0
"""Seconds for which a picture is remembered."""


@dataclass(frozen=True, slots=True)
class _Shown:
    """A picture: when it was shown, in seconds of `time.monotonic`, what there is to draw, and whose it is."""

    at: float
    drawing: Drawing
    owner: str


class Scenes:
    """A scene for each browser.

    Args:
        limit: sessions at a time; of one client half of them.
        idle: seconds after which an idle session ends.
    """

    def __init__(self, limit: int = LIMIT, idle: float = IDLE) -> None:
        self.limit = limit
        self.idle = idle
        self._lock = threading.Lock()
        self._starting = threading.Lock()
        self._server: viser.ViserServer | None = None
        self._remembered = REMEMBERED * limit
        self._pictures: OrderedDict[str, _Shown] = OrderedDict()
        self._sessions: dict[str, Session] = {}
        self._waiting: set[Session] = set()
        self._asleep: OrderedDict[str, None] = OrderedDict()

    def attach(self, server: FastAPI) -> None:
        """Add the routes; before any route that catches all addresses."""
        proxy.attach(server, self)

    def show(self, token: str, picture: Picture) -> None:
        """Show a picture in the browser with that token, now or when it connects. Any thread may call this.

        Raises:
            InputError: for a token that is not 32 lower-case hexadecimal digits.
        """
        if not TOKEN.fullmatch(token):
            # What was received stays out of messages and logs: it may be a slip in a real token.
            raise InputError("token", "must be 32 lower-case hexadecimal digits", "something else")
        drawing = picture if isinstance(picture, RegionPicture) else picture.thinned()
        shown = _Shown(time.monotonic(), drawing, CLIENT.get())
        with self._lock:
            if token not in self._pictures:
                self._make_room(shown.owner)
            self._pictures[token] = shown
            self._pictures.move_to_end(token)
            self._forget(shown.at)
            self._asleep.pop(token, None)
            session = self._sessions.get(token)
        if session is not None:
            session.touch()
            self._ask_to_draw(session)

    def stats(self) -> Stats:
        """Connected browsers and remembered pictures."""
        with self._lock:
            return Stats(len(self._sessions), len(self._pictures))

    def close(self) -> None:
        """End all sessions and stop viser; a later connection starts it again."""
        with self._lock:
            sessions, self._sessions = list(self._sessions.values()), {}
        for session in sessions:
            session.end()
        with self._starting:
            server, self._server = self._server, None
        if server is not None:
            server.stop()

    # For the proxy --------------------------------------------------------------------------------------------------

    def port(self) -> int:
        """viser's port on the loopback interface; starts viser when it does not run yet, which takes about a second."""
        with self._starting:
            if self._server is None:
                self._server = _start()
                self._server.on_client_connect(self._connected)
                self._server.on_client_disconnect(self._disconnected)
            return self._server.get_port()

    def admit(self, token: str) -> Session:
        """Begin a session of whoever asks for it; one with the same token ends.

        Raises:
            RefusedError: when there are too many, in all or of one client, or the token's last session ended idle and
                nothing was shown since.
        """
        owner = CLIENT.get()
        session = Session(token, owner, secrets.token_hex(16), asyncio.get_running_loop(), time.monotonic())
        with self._lock:
            if token in self._asleep:
                raise RefusedError(full=False)
            old = self._sessions.get(token)
            others = [each.owner for each in self._sessions.values() if each is not old]
            if len(others) >= self.limit or others.count(owner) >= share(self.limit):
                raise RefusedError(full=True)
            self._sessions[token] = session
        if old is not None:
            old.end()
        return session

    def release(self, session: Session, *, asleep: bool = False) -> None:
        """Forget a session; when it ended idle, its token is refused until something is shown."""
        with self._lock:
            if self._sessions.get(session.token) is session:
                del self._sessions[session.token]
                if asleep:
                    self._asleep[session.token] = None
                    while len(self._asleep) > self._remembered:
                        self._asleep.popitem(last=False)
        session.client = session.scene = None

    # In viser's thread ----------------------------------------------------------------------------------------------

    async def _connected(self, client: viser.ClientHandle) -> None:
        server = self._server
        session = self._with_key(_path(client).strip("/"))
        if session is None:
            # Not from the proxy. A process of this machine may reach the port; there is nothing for it here.
            return
        session.client = client
        if server is not None:
            self._draw(session)

    async def _disconnected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            sessions = list(self._sessions.values())
        for session in sessions:
            if session.client is client:
                session.client = session.scene = None
        let_go(client)

    def _with_key(self, key: str) -> Session | None:
        with self._lock:
            return next((session for session in self._sessions.values() if session.key == key), None)

    def _ask_to_draw(self, session: Session) -> None:
        server = self._server
        if server is None or session.client is None:
            return
        with self._lock:
            # Waking viser's thread costs more than a drawing: those that wait for it are drawn together.
            asked = bool(self._waiting)
            self._waiting.add(session)
        if not asked:
            with contextlib.suppress(RuntimeError):  # viser was stopped meanwhile
                server.get_event_loop().call_soon_threadsafe(self._draw_waiting)

    def _draw_waiting(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, set()
        for session in waiting:
            self._draw(session)

    def _draw(self, session: Session) -> None:
        with self._lock:
            shown = self._pictures.get(session.token)
        server, client, scene = self._server, session.client, session.scene
        if server is None or client is None or client.client_id not in server.get_clients() or shown is None:
            return
        drawing = shown.drawing
        with client.atomic():
            if scene is None or not scene.update(drawing):
                client.scene.reset()
                session.scene = build(client, drawing)
                if type(session.scene) is not type(scene):
                    session.scene.look(client)
        client.flush()

    def _make_room(self, owner: str) -> None:
        """Forget a client's oldest picture where it has as many as one may have: not another's."""
        own = [token for token, shown in self._pictures.items() if shown.owner == owner]
        if len(own) >= share(self._remembered):
            del self._pictures[own[0]]

    def _forget(self, now: float) -> None:
        """What is too much or too old of the pictures."""
        while self._pictures:
            oldest = next(iter(self._pictures.values()))
            if len(self._pictures) <= self._remembered and now - oldest.at <= LIFETIME:
                return
            self._pictures.popitem(last=False)


def build(client: viser.ClientHandle, drawing: Drawing) -> RegionScene | TrackScene:
    """The scene of a picture, from nothing."""
    return RegionScene(client, drawing) if isinstance(drawing, RegionPicture) else TrackScene(client, drawing)


def _start() -> viser.ViserServer:
    import rich
    import viser

    class Loopback(viser.ViserServer):
        """viser without its tunnel: a browser's message, or any process of this machine, could open one."""

        def request_share_url(self, verbose: bool = True) -> str | None:  # noqa: ARG002
            return None

    # viser prints where it listens and when it stops, whatever it is told.
    rich.reconfigure(quiet=True)
    forget_traces()
    return Loopback(host="127.0.0.1", port=0, verbose=False)


def _path(client: viser.ClientHandle) -> str:
    """The address that the proxy asked for; viser keeps it with the connection."""
    connections = client._viser_server._websock_server._live_connections  # noqa: SLF001
    connection = connections.get(client.client_id)
    return "" if connection is None or connection.request is None else connection.request.path
