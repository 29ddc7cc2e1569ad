"""From the start of the server to the moment it says it is ready: with nothing compiled yet, and again."""

from __future__ import annotations

import os
import tempfile
import time
from unittest.mock import patch

from benchmarks.serving import server


def measure_startup(rounds: int = 3) -> None:
    """Print the first start with an empty cache of compiled code, and the quickest of some that find it full."""
    with tempfile.TemporaryDirectory() as cache, patch.dict(os.environ, NUMBA_CACHE_DIR=cache):
        cold, *warm = (_start() for _ in range(1 + rounds))
    print(f"\n{'start of the server to ready':<64} {'s':>9}")
    print(f"{'cold: everything is compiled':<64} {cold:9.1f}  at most 10")
    print(f"{'warm':<64} {min(warm):9.1f}  at most 3")


def _start() -> float:
    begun = time.perf_counter()
    with server():
        return time.perf_counter() - begun
