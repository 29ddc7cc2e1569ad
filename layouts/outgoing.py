"""Files on their way out: written by a thread into a place of their own, then sent from there.

Nobody who makes a file waits for whoever takes it, and whoever takes it slowly keeps nothing but the place.
"""

from __future__ import annotations

import asyncio
import io
import threading
from collections.abc import AsyncIterator
from concurrent.futures import Executor
from contextlib import AsyncExitStack
from pathlib import Path
from tempfile import SpooledTemporaryFile
from typing import IO, Any

from fastapi.responses import StreamingResponse
from starlette.requests import ClientDisconnect
from starlette.types import Receive, Scope, Send

from layouts.files import PART
from layouts.incoming import MEGABYTE
from server.limits import Places

PIECE = 1 << 18
"""Bytes that are read and sent at a time; a file that has no more stays in memory."""

STEP = MEGABYTE
"""Bytes of room that are taken at a time."""

LONGEST = 600.0
"""Seconds for which a file may be sent."""


class FullError(Exception):
    """There is no room: other files have not been taken yet."""


class Outgoing(io.RawIOBase):
    """A file that is made in a thread. Where it lies it has no name, so that whatever happens nothing of it stays.

    Args:
        room: bytes that all such files may have.
        client: for whom it is.
        folder: on whose disk it lies; None for where the system has such files.

    Attributes:
        size: bytes that it has.
    """

    def __init__(self, room: Places, client: str, folder: Path | None) -> None:
        self.size = 0
        self._room, self._client, self._taken = room, client, 0
        self._lock = threading.Lock()
        where = None if folder is None else str(folder)
        self._stream: IO[bytes] = SpooledTemporaryFile(PIECE, dir=where, suffix=PART)  # noqa: SIM115 - see close

    def writable(self) -> bool:
        """It is there to be written to."""
        return True

    def write(self, data: Any) -> int:
        """Write more at the end.

        Raises:
            FullError: where there is no room.
            BrokenPipeError: once nobody wants it any more.
            OSError: where the disk does not take it.
        """
        with self._lock:
            if self.closed:
                raise BrokenPipeError
            while self.size + len(data) > self._taken:
                if not self._room.enter(self._client, STEP):
                    raise FullError
                self._taken += STEP
            self._stream.write(data)
            self.size += len(data)
            return len(data)

    def begin(self) -> IO[bytes]:
        """All of it, to be read from its beginning."""
        self._stream.seek(0)
        return self._stream

    def close(self) -> None:
        """Let go of it, in any thread: who still writes is stopped."""
        with self._lock:
            if not self.closed:
                super().close()
                self._stream.close()
                self._room.leave(self._client, self._taken)


class Sent(StreamingResponse):
    """A file as an answer; in the end, whichever it is, what it took is free again.

    Args:
        stream: at the beginning of the file.
        size: bytes of it.
        readers: threads that it is read in.
        ending: of what it took.
        more: of any answer: `headers`, `media_type`.
    """

    def __init__(self, stream: IO[bytes], size: int, readers: Executor, ending: AsyncExitStack, **more: Any) -> None:
        headers = {"Content-Length": str(size), **more.pop("headers", {})}
        super().__init__(_pieces(stream, readers), headers=headers, **more)
        self._ending = ending

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send it, unless that takes too long: who stays and takes next to nothing has left as well."""
        try:
            async with asyncio.timeout(LONGEST):
                await super().__call__(scope, receive, send)
        except TimeoutError:
            raise ClientDisconnect from None
        finally:
            await self._ending.aclose()


async def _pieces(stream: IO[bytes], readers: Executor) -> AsyncIterator[bytes]:
    loop = asyncio.get_running_loop()
    while piece := await loop.run_in_executor(readers, stream.read, PIECE):
        yield piece
