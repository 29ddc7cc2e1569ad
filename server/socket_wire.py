"""A WebSocket between the network and the application, of which no more is kept than is heard and taken.

uvicorn reads on until a message is there and queues all that came with it, answers pings of somebody who takes no
answer, and takes pings, pongs and parts of messages without number. Here the rest waits, in the network in the end, and
is not lost.
"""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import CloseCode, Frame

from server.limits import Buckets, Places, Rate

BITE = 4096
"""Bytes that are read before it is looked whether there is something to be heard first: 700 messages at most."""

MOST_PARTS = 256
"""Frames that one message may come in. Browsers send most in one."""

LINGER, LET_PASS = 2.0, 4_000_000
"""Seconds and bytes for which what is still on its way passes unread, once it is said why a socket ends."""

ASIDES = Rate(per_second=1_000, at_once=2_000)
"""Frames of all sockets of one client that begin no message: pings, pongs, further parts. A browser sends a pong every
20 s. More of them wait."""


class Socket(WebSocketsSansIOProtocol):
    """A WebSocket as uvicorn speaks it, after `wire.Wire` has read its head.

    Args:
        name: of the client.
        place: that it took for the connection; it is given back when that is gone.
        asides: frames that begin no message, of all sockets.
        more: what uvicorn gives each.
    """

    def __init__(self, name: str, place: Places | None, asides: Buckets, **more: Any) -> None:
        super().__init__(**more)
        self._name, self._place, self._asides = name, place, asides
        self._is_ending = False
        self._unread = b""
        # Whether nothing is read any more, and the bytes that have passed since then.
        self._is_deaf, self._passed = False, 0
        # Frames that begin no message, of what is being read; and until when no more are read.
        self._aside = 0
        self._rest: asyncio.TimerHandle | None = None

    def connection_lost(self, exc: Exception | None) -> None:
        """Give the place back, and read no more."""
        if self._rest is not None:
            self._rest.cancel()
        super().connection_lost(exc)
        # What reads, and what it reads for, hold each other until it comes to its end.
        self.conn.parser.close()
        if self._place is not None:
            self._place.leave(self._name)

    # What comes ------------------------------------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        """Read what has come; a client that does not wait until it is opened is none."""
        if self._is_deaf:
            self._passed += len(data)
            if self._passed > LET_PASS:
                self.transport.close()
        elif self.handshake_complete:
            self._unread += data
            self._read_on()
        else:
            self.transport.close()

    def handle_cont(self, event: Frame) -> None:
        """Take a further part of a message."""
        self._aside += 1
        if self.close_sent:
            return
        if len(self.frames) < MOST_PARTS:
            super().handle_cont(event)
        else:
            self.conn.fail(CloseCode.MESSAGE_TOO_BIG, f"more than {MOST_PARTS} parts")
            self.handle_parser_exception()

    def handle_ping(self) -> None:
        """Answer a ping."""
        self._aside += 1
        super().handle_ping()

    def handle_pong(self, event: Frame) -> None:
        """Take the answer to a ping."""
        self._aside += 1
        super().handle_pong(event)

    def handle_parser_exception(self) -> None:
        """Say why it ends to who says what cannot be read.

        To close the connection while more is on its way would reset it, and the reset overtake what was said.
        """
        close: Any = self.conn.close_sent
        self.queue.put_nowait({"type": "websocket.disconnect", "code": close.code, "reason": close.reason})
        self.transport.write(b"".join(self.conn.data_to_send()))
        self.close_sent = self._is_deaf = True
        self._unread = b""
        self.stop_keepalive()
        if self.transport.can_write_eof():
            self.transport.write_eof()
        # uvicorn lets the connection be as long as there is one.
        self.close_timer = self.loop.call_later(LINGER, self.transport.close)

    def keepalive_timeout(self) -> None:
        """End it where no answer came to a ping; one that has not been read may have."""
        if self._unread or not self._hears():
            self.pong_timer = self.loop.call_later(self.ping_timeout or 0.0, self.keepalive_timeout)
        else:
            super().keepalive_timeout()

    async def receive(self) -> Any:
        """The next message."""
        message = await self.queue.get()
        self._read_on()
        return message

    def resume_writing(self) -> None:
        """What was sent has been taken, so more may be said that is answered at once."""
        super().resume_writing()
        self._read_on()

    def _hears(self) -> bool:
        """Whether what is read now would be heard, and what is said in turn be taken."""
        return self._rest is None and self.writable.is_set() and (self.close_sent or self.queue.empty())

    def _read_on(self) -> None:
        """Read of what has come as much as is heard; the network is to wait while there is more."""
        while self._unread and self._hears() and not self.transport.is_closing():
            bite, self._unread = self._unread[:BITE], self._unread[BITE:]
            super().data_received(bite)
            self._count()
        if self.transport.is_closing():
            self._unread = b""
        elif self._hears() == self.read_paused:
            self.read_paused = not self.read_paused
            (self.transport.pause_reading if self.read_paused else self.transport.resume_reading)()

    def _count(self) -> None:
        """Count what was beside messages, and rest where it was too much."""
        if not self._aside:
            return
        now = self.loop.time()
        self._asides.draw(self._name, now, self._aside)
        self._aside = 0
        wait = self._asides.wait(self._name, now)
        if wait:
            self._rest = self.loop.call_later(wait, self._rested)

    def _rested(self) -> None:
        self._rest = None
        self._read_on()

    # What goes -------------------------------------------------------------------------------------------------------

    async def send(self, message: Any) -> None:
        """Pass on what the application says, and wait until most of it is taken."""
        if self.close_sent and (self._is_deaf or self.transport.is_closing()):
            # It has been ended for what it said, or did not say. For uvicorn it were the application's mistake.
            raise ClientDisconnected
        await super().send(message)
        # An answer in its place ends the handshake as well, which uvicorn would log as an error.
        self.handshake_complete |= self.close_sent
        if self._is_ending and message["type"] == "websocket.accept" and self.handshake_complete:
            super().shutdown()
        if self.close_sent:
            # Whether the other side closes it too stands behind all that it has said.
            self._read_on()
        await self.writable.wait()

    def shutdown(self) -> None:
        """Close it because the server stops; one that is not open yet is first opened, or answered by the guard."""
        self._is_ending = True
        if self.handshake_complete and not self.transport.is_closing():
            super().shutdown()
