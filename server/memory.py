"""The memory of a process that serves for weeks: how it is asked for, and what looks for what nobody uses any more."""

from __future__ import annotations

import contextlib
import ctypes
import gc

YOUNG, MIDDLE, OLD = 10_000, 5, 2
"""An answer makes thousands of values and lets go of all of them: with Python's 700, the collector looks through them
several times while it is being made. So it is called less often, and then looks at what is old sooner: all of it every
two minutes where a class is at work, which takes a tenth of a second."""

ARENAS = 2

_M_ARENA_MAX = -8


def share() -> None:
    """Have all threads share a few arenas; before the first thread is started.

    The C library gives each its own, up to eight for every processor, and each keeps the holes that arrays leave in it.
    Nothing happens where it has no such thing.
    """
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).mallopt(_M_ARENA_MAX, ARENAS)


def settle() -> None:
    """What is here now stays: look at it no more, and less often at what is new."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(YOUNG, MIDDLE, OLD)
    # Old values are looked through once there are a quarter more than were left the last time: of those to look at.
    gc.collect()
