"""All kernels compiled by other processes, so that this one gets neither the compiler's memory nor its pauses."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import subprocess
import sys
import tempfile
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tracker_core.kernels.signatures import SIGNATURES
from tracker_core.kernels.target import HERE, Target, publish, stamp

PROCESSES = 2
"""That compile at a time; each takes up to 300 MB."""

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Compiled:
    """What has been done for one kernel.

    Attributes:
        kernel: its name.
        signatures: number of them.
        seconds: of a processor that compiling took; None where it was there.
    """

    kernel: str
    signatures: int
    seconds: float | None


class Preparation:
    """Sees to it that all kernels are there.

    Args:
        target: the processor that they are compiled for.
        root: where they are kept.
        done: called with each kernel once it is there, from any thread, one call at a time.
    """

    def __init__(self, target: Target, root: Path, done: Callable[[Compiled], None] = lambda _: None) -> None:
        self._target = target
        self._folder = target.folder(root)
        self._done = done
        self._jobs: deque[str] = deque()
        self._lock = threading.Lock()
        self._processes: list[subprocess.Popen[str]] = []
        self._stopped = False

    def run(self) -> None:
        """Compile what is missing; returns when nothing is any more, or nothing more can be done."""
        for name in SIGNATURES:
            if stamp(self._folder, name).exists():
                self._tell(Compiled(name, len(SIGNATURES[name]), None))
            else:
                self._jobs.append(name)
        workers = [threading.Thread(target=self._work) for _ in range(min(PROCESSES, len(self._jobs)))]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()

    def stop(self) -> None:
        """End all processes."""
        with self._lock:
            self._stopped = True
            for process in self._processes:
                process.kill()

    @property
    def missing(self) -> list[str]:
        """Kernels that are not there: after `run`, those whose compiler failed."""
        return [name for name in SIGNATURES if not stamp(self._folder, name).exists()]

    def _tell(self, compiled: Compiled) -> None:
        with self._lock:
            self._done(compiled)

    def _work(self) -> None:
        """Have one process compile one kernel after the other, until none is left or it fails."""
        with tempfile.TemporaryDirectory(prefix="gainscope-compiling-", ignore_cleanup_errors=True) as own:
            process = self._begin(own)
            if process is None:
                return
            try:
                while (name := self._next()) is not None:
                    seconds = _ask(process, name)
                    if seconds is None:
                        if not self._stopped:
                            _LOG.error("A process that compiles has failed", extra={"kernel": name})
                        break
                    # What kernels call is compiled into them; its own files are not needed.
                    publish(self._target.folder(Path(own)), self._folder, f"*/*.{name}-*")
                    stamp(self._folder, name).touch()
                    self._tell(Compiled(name, len(SIGNATURES[name]), seconds))
            except OSError:
                _LOG.exception("Compiled code cannot be kept")
            finally:
                _end(process)

    def _next(self) -> str | None:
        with self._lock:
            return None if self._stopped or not self._jobs else self._jobs.popleft()

    def _begin(self, own: str) -> subprocess.Popen[str] | None:
        path = os.pathsep.join([str(HERE.parents[1]), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)
        with self._lock:
            if self._stopped:
                return None
            process = subprocess.Popen(  # noqa: S603 - this very program
                [sys.executable, "-P", "-m", "tracker_core.kernels.child", own],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                encoding="utf-8",
                env=os.environ | self._target.variables | {"NUMBA_CACHE_DIR": own, "PYTHONPATH": path},
                # Its end is its input's, not a key pressed in a terminal.
                start_new_session=True,
            )
            self._processes.append(process)
        return process


def _ask(process: subprocess.Popen[str], name: str) -> float | None:
    """Have a kernel compiled; returns what it took, s of a processor, None if it failed."""
    asking, answering = process.stdin, process.stdout
    if asking is None or answering is None:
        return None
    try:
        asking.write(f"{name}\n")
        asking.flush()
        return float(json.loads(answering.readline())["seconds"])
    except (OSError, ValueError):
        return None


def _end(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            # What it was still to be told has nowhere to go.
            with contextlib.suppress(OSError):
                stream.close()
