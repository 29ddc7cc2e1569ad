"""What the processes that the server starts have in common: how one begins, and how it is spoken with.

It hears on its standard input and answers on its standard output, in frames: the length (4 bytes), and so many bytes.
What it says first belongs to no question: it is ready. It ends when nothing more can come, for then the server has
gone.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from typing import BinaryIO

from server import logs, memory


def begin(form: str, level: str) -> BinaryIO:
    """Begin such a process: its log, compiled code, and where it answers.

    Args:
        form, level: of the log.
    """
    memory.share()
    logs.start(form, level)
    # Ctrl-C is for the server, which then ends this.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What is printed by mistake is no answer.
    out, sys.stdout = os.fdopen(os.dup(1), "wb"), sys.stderr
    os.dup2(2, 1)
    from tracker_core import kernels
    from tracker_core.kernels.child import make
    from tracker_core.kernels.signatures import SIGNATURES

    for name in SIGNATURES:
        make(getattr(kernels, name), name)
    memory.settle()
    return out


def framed(text: bytes) -> bytes:
    """A text as it goes through a pipe."""
    return len(text).to_bytes(4, "little") + text


def text_in(stream: Callable[[int], bytes | None]) -> bytes | None:
    """The next text that comes through a pipe; None where there will be none.

    Args:
        stream: reads up to so many bytes, none only at its end.
    """
    head = _exactly(stream, 4)
    return None if head is None else _exactly(stream, int.from_bytes(head, "little"))


def _exactly(stream: Callable[[int], bytes | None], size: int) -> bytes | None:
    parts: list[bytes] = []
    while size:
        part = stream(size)
        if not part:
            return None
        parts.append(part)
        size -= len(part)
    return b"".join(parts)
