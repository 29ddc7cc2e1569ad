"""A WebSocket between the network and the application, of which no more is kept than is heard and taken.

uvicorn reads on until a message is there and queues all that came with it, answers pings of somebody who takes no
answer, and takes messages in parts without number. Here the rest waits, in the network in the end, and is not lost.
"""

from __future__ import annotations

from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import CloseCode, Frame

from server.limits import Places

BITE = 4096
"""Bytes that are read before it is looked whether there is something to be heard first: 700 messages at most."""

MOST_PARTS = 256
"""Frames that one message may come in. Browsers send most in one."""


class Socket(WebSocketsSansIOProtocol):
    """A WebSocket as uvicorn speaks it, after `wire.Wire` has read its head.

    Attributes:
        place: that is given back when the connection is gone.
        name: of the client, by which it was taken.
    """

    place: Places | None = None
    name = ""
    _is_ending = False
    _unread = b""

    def connection_lost(self, exc: Exception | None) -> None:
        """Give the place back."""
        super().connection_lost(exc)
        if self.place is not None:
            self.place.leave(self.name)

    # What comes ------------------------------------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        """Read what has come; a client that does not wait until it is opened is none."""
        if self.handshake_complete:
            self._unread += data
            self._read_on()
        else:
            self.transport.close()

    def handle_cont(self, event: Frame) -> None:
        """Take a further part of a message."""
        if self.close_sent:
            return
        if len(self.frames) < MOST_PARTS:
            super().handle_cont(event)
        else:
            self.conn.fail(CloseCode.MESSAGE_TOO_BIG, f"more than {MOST_PARTS} parts")
            self.handle_parser_exception()

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
        return self.close_sent or (self.queue.empty() and self.writable.is_set())

    def _read_on(self) -> None:
        """Read of what has come as much as is heard; the network is to wait while there is more."""
        while self._unread and self._hears() and not self.transport.is_closing():
            bite, self._unread = self._unread[:BITE], self._unread[BITE:]
            super().data_received(bite)
        if self.transport.is_closing():
            self._unread = b""
        elif self._hears() == self.read_paused:
            self.read_paused = not self.read_paused
            (self.transport.pause_reading if self.read_paused else self.transport.resume_reading)()

    # What goes -------------------------------------------------------------------------------------------------------

    async def send(self, message: Any) -> None:
        """Pass on what the application says, and wait until most of it is taken."""
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
        if self.handshake_complete:
            super().shutdown()
