"""Waiting for what nobody tells, and whether a process still runs; for tests of any package."""

import asyncio
import time
from pathlib import Path


async def eventually(holds, patience=20.0):
    """Wait until something holds."""
    end = time.monotonic() + patience
    while not holds():
        assert time.monotonic() < end, "it did not come to hold"
        await asyncio.sleep(0.01)


def is_running(number):
    """Whether there is such a process, and more of it than its exit status."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
