"""From a thread that writes a file to a response that sends it, piece by piece, never more in memory than a few."""

from __future__ import annotations

import asyncio
import contextlib
import io
import queue
import threading
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Executor
from typing import IO, Any, cast

PIECE = 1 << 18
"""Bytes that are sent at a time."""

PIECES = 4
"""Of them in memory."""

STALLED = 60.0
"""Seconds after which nobody is waiting any more who takes nothing."""


class Pipe(io.RawIOBase):
    """A file that can be written to in one thread, and whose pieces another takes."""

    def __init__(self) -> None:
        self._pieces: queue.Queue[bytes | BaseException | None] = queue.Queue(PIECES)
        self._gone = threading.Event()
        self._gathered = bytearray()

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
        try:
            write(cast("IO[bytes]", self))
            if self._gathered:
                self._pass(bytes(self._gathered))
        except BaseException as error:  # noqa: BLE001 - whatever it was, the reader must hear of it
            end = error
        with contextlib.suppress(BrokenPipeError):
            self._pass(end)

    def _pass(self, piece: bytes | BaseException | None) -> None:
        try:
            if self._gone.is_set():
                raise BrokenPipeError
            self._pieces.put(piece, timeout=STALLED)
        except queue.Full:
            raise BrokenPipeError from None

    async def take(self) -> AsyncIterator[bytes]:
        """The pieces.

        Raises:
            BaseException: what writing failed with.
        """
        try:
            while (piece := await asyncio.to_thread(self._pieces.get)) is not None:
                if isinstance(piece, BaseException):
                    raise piece
                yield piece
        finally:
            self._gone.set()
            with contextlib.suppress(queue.Empty):
                while True:
                    self._pieces.get_nowait()


async def piped(executor: Executor, write: Callable[[IO[bytes]], None]) -> AsyncIterator[bytes]:
    """The pieces of a file as it is written.

    Returns once the first is there.

    Raises:
        BaseException: what writing failed with before that.
    """
    pipe = Pipe()
    asyncio.get_running_loop().run_in_executor(executor, pipe.fill, write)
    pieces = pipe.take()
    first = await anext(pieces, b"")

    async def all_pieces() -> AsyncIterator[bytes]:
        async with contextlib.aclosing(cast("Any", pieces)):
            yield first
            async for piece in pieces:
                yield piece

    return all_pieces()
