"""A file on its way in: hashed as it comes, and no larger than it may be."""

from __future__ import annotations

import hashlib
from typing import IO

from tracker_core.checks import InputError

MEGABYTE = 1_000_000


class Incoming:
    """A file on its way in.

    Args:
        stream: where its bytes go; it can be read as well.
        most: bytes that it may have.
        head: what stands before it in the stream.

    Attributes:
        size: bytes that have come.
    """

    def __init__(self, stream: IO[bytes], most: int, head: bytes = b"") -> None:
        self.size = 0
        self._stream, self._most, self._begins = stream, most, len(head)
        self._hash = hashlib.sha256()
        stream.write(head)

    def write(self, chunk: bytes) -> None:
        """Take in what has come.

        Raises:
            InputError: where it is too much; nothing more is written then.
        """
        self.size += len(chunk)
        if self.size > self._most:
            raise too_large(self._most, self.size)
        self._stream.write(chunk)
        self._hash.update(chunk)

    @property
    def data(self) -> str:
        """What the bytes that have come are known by: see `measured.content_name`."""
        return self._hash.hexdigest()[:32]

    @property
    def stream(self) -> IO[bytes]:
        """Where the bytes went, every one of them written."""
        self._stream.flush()
        return self._stream

    def content(self) -> bytes:
        """The bytes that have come."""
        self.stream.seek(self._begins)
        return self._stream.read()


def too_large(most: int, received: int) -> InputError:
    """What is said of a file that passes the bound."""
    rule = f"must have at most {most / MEGABYTE:g} MB; leave out columns, rows or tracks that are not needed"
    return InputError("file", rule, f"{received / MEGABYTE:.1f} MB")
