"""What comes before there is a request to look at: uvicorn reads headers of any size for any time.

One connection could fill the memory with a header that does not end, or stay for ever with one that hardly begins.
"""

from __future__ import annotations

import asyncio

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

HEAD_SECONDS = 10.0
"""For which the headers of a request may be on their way; a connection may not wait longer for its first ones."""

HEAD_BYTES = 64 * 1024
"""Of what has come without the end of the headers; what ends is measured more closely, see `screen`."""


class Wire(HttpToolsProtocol):
    """HTTP/1.1 as uvicorn speaks it, with bounds on what comes before a body: `uvicorn.Config(http=Wire)`."""

    _in_head = False
    _head = 0
    _ending: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for the first request."""
        super().connection_made(transport)
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        self._stop_waiting()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Read what has come."""
        super().data_received(data)
        if not self._in_head or self.transport.is_closing():
            return
        self._head += len(data)
        if self._head > HEAD_BYTES:
            self.send_400_response("The headers are too large.")
        else:
            self._wait()

    def on_message_begin(self) -> None:
        """A request begins."""
        self._in_head, self._head = True, 0
        super().on_message_begin()

    def on_headers_complete(self) -> None:
        """Its headers are there."""
        self._in_head = False
        self._stop_waiting()
        super().on_headers_complete()

    def _wait(self) -> None:
        if self._ending is None:
            self._ending = self.loop.call_later(HEAD_SECONDS, self.transport.close)

    def _stop_waiting(self) -> None:
        if self._ending is not None:
            self._ending.cancel()
            self._ending = None
