"""Peak memory of the workloads of benchmarks/speed.py: each in a fresh process, less what the same process had before.

`python -m benchmarks.memory W3` prints the peak of one workload, in bytes above the peak once everything it needs has
been loaded, compiled and drawn.
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
from pathlib import Path

MEASURED = ("W2", "W3", "W4", "W5")
PEAK = "VmHWM:"


def peak() -> int:
    """Greatest resident memory of this process since it was last forgotten, bytes."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return 1024 * int(next(line for line in lines if line.startswith(PEAK)).split()[1])


def forget() -> None:
    """Begin a new peak at the present memory."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def measure(name: str) -> int:
    """Peak of one workload above what was there before it, bytes."""
    from benchmarks.speed import gain_map, long_track, monte_carlo, sample_search

    made = dict(zip(MEASURED, (long_track, gain_map, monte_carlo, sample_search), strict=True))[name]()
    # The first call compiles; what it allocates is given back.
    made.ours()
    ctypes.CDLL("libc.so.6").malloc_trim(0)
    forget()
    before = peak()
    kept = made.ours()
    grown = peak() - before
    del kept
    return grown


def measure_memory() -> None:
    """Print them all."""
    print(f"\n{'peak memory above what is there before':<64} {'MB':>9}")
    for name in MEASURED:
        found = subprocess.run(
            [sys.executable, "-m", "benchmarks.memory", name], check=True, capture_output=True, text=True
        )
        print(f"{name:<64} {int(found.stdout) / 1e6:9.1f}")


if __name__ == "__main__":
    print(measure(sys.argv[1]))
