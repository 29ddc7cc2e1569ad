"""From a thread that writes a file to a response that sends it, piece by piece, never more in memory than a few."""

from __future__ import annotations

import asyncio
import contextlib
import io
import threading
from collections.abc import Callable
from concurrent.futures import Executor
from typing import IO, Any, cast

PIECE = 1 << 18
"""Bytes that are sent at a time."""

PIECES = 4
"""Of them in memory."""

STALLED = 60.0
"""Seconds after which nobody is waiting any more who takes nothing."""


class Pipe(io.RawIOBase):
    """A file that is written to in a thread, and whose pieces a loop takes; no thread waits for a piece to come.

    Args:
        loop: that takes the pieces.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._pieces: asyncio.Queue[bytes | BaseException | None] = asyncio.Queue()
        self._room = threading.Semaphore(PIECES)
        self._gone = threading.Event()
        self._gathered = bytearray()
        self._first: bytes | None = None
        self._ended = False

    def writable(self) -> bool:
        """It is there to be written to."""
        return True

    def write(self, data: Any) -> int:
        """Pass on what makes a piece.

        Raises:
            BrokenPipeError: once nobody takes the pieces.
        """
        self._gathered += data
        if len(self._gathered) >= PIECE:
            self._pass(bytes(self._gathered))
            self._gathered.clear()
        return len(data)

    def fill(self, write: Callable[[IO[bytes]], None]) -> None:
        """Let the file be written, to its end or its failure; both reach who takes the pieces."""
        end: BaseException | None = None
        if self._gone.is_set():
            return
        try:
            write(cast("IO[bytes]", self))
            if self._gathered:
                self._pass(bytes(self._gathered))
        except BaseException as error:  # noqa: BLE001 - whatever it was, the reader must hear of it
            end = error
        # An end needs no room: whoever takes nothing for long and then goes on must not wait for it in vain.
        with contextlib.suppress(BrokenPipeError):
            self._send(end)

    def _pass(self, piece: bytes) -> None:
        if self._gone.is_set() or not self._room.acquire(timeout=STALLED) or self._gone.is_set():
            raise BrokenPipeError
        self._send(piece)

    def _send(self, piece: bytes | BaseException | None) -> None:
        try:
            self._loop.call_soon_threadsafe(self._pieces.put_nowait, piece)
        except RuntimeError:
            # The server has stopped.
            raise BrokenPipeError from None

    async def opened(self) -> None:
        """Wait for the first piece, or the end.

        Raises:
            BaseException: what writing failed with before that.
        """
        self._first = await self._take()

    async def _take(self) -> bytes:
        """The next piece; nothing at the end."""
        if self._ended:
            return b""
        piece = await self._pieces.get()
        self._room.release()
        if isinstance(piece, bytes):
            return piece
        self._ended = True
        if piece is not None:
            raise piece
        return b""

    def leave(self) -> None:
        """Take no more: who writes is stopped at the next piece."""
        self._gone.set()
        self._room.release()

    def __aiter__(self) -> Pipe:
        return self

    async def __anext__(self) -> bytes:
        piece, self._first = self._first, None
        piece = await self._take() if piece is None else piece
        if not piece:
            raise StopAsyncIteration
        return piece


def piped(executor: Executor, write: Callable[[IO[bytes]], None]) -> Pipe:
    """The pieces of a file as it is written by a thread of an executor; whoever takes them leaves in the end."""
    loop = asyncio.get_running_loop()
    pipe = Pipe(loop)
    loop.run_in_executor(executor, pipe.fill, write)
    return pipe
