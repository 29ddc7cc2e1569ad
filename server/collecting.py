"""The garbage collector of a process that serves."""

from __future__ import annotations

import gc

YOUNG, MIDDLE, OLD = 20_000, 20, 20
"""An answer makes thousands of values and lets go of all of them: with Python's 700, the collector looks through them
several times while it is being made."""


def settle() -> None:
    """What is here now stays: look at it no more, and less often at what is new."""
    gc.freeze()
    gc.set_threshold(YOUNG, MIDDLE, OLD)
