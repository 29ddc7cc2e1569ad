"""The memory of a process that serves for weeks: how it is asked for, and what looks for what nobody uses any more."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import threading
import time

YOUNG, MIDDLE, OLD = 10_000, 5, 2
"""An answer makes thousands of values and lets go of all of them: with Python's 700, the collector looks through them
several times while it is being made. So it is called less often, and then looks at what is old sooner."""

EVERY = 120.0
"""Seconds after which all of it is looked at in any case, which takes a twentieth of a second to a tenth. The collector
goes by how many values have become old, and a few of them may hold megabytes."""

ARENAS = 2

_M_ARENA_MAX = -8
_ALL = 2


def share() -> None:
    """Have all threads share a few arenas; before the first thread is started.

    The C library gives each its own, up to eight for every processor, and each keeps the holes that arrays leave in it.
    Nothing happens where it has no such thing.
    """
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).mallopt(_M_ARENA_MAX, ARENAS)


def _give_back(phase: str, info: dict[str, int]) -> None:
    """After all of it was looked at, let the system have the pages on which nothing is left.

    The C library keeps what lies below anything that is still used. So a process would grow to the most that was ever
    in use, and on, since holes that are filled by what is smaller are not holes any more.
    """
    if phase == "stop" and info["generation"] == _ALL:
        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).malloc_trim(0)


def settle() -> None:
    """What is here now stays: look at it no more, and less often at what is new."""
    if _give_back not in gc.callbacks:
        gc.callbacks.append(_give_back)
    gc.collect()
    gc.freeze()
    gc.set_threshold(YOUNG, MIDDLE, OLD)
    # Old values are looked through once there are a quarter more than were left the last time: of those to look at.
    gc.collect()
    if not any(thread.name == _LOOKING for thread in threading.enumerate()):
        threading.Thread(target=_look, name=_LOOKING, daemon=True).start()


_LOOKING = "memory"


def _look() -> None:
    while True:
        time.sleep(EVERY)
        gc.collect()
