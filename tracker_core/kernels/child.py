"""A process that compiles: `python -m tracker_core.kernels.child FOLDER`.

It reads names of kernels, a line each, and says of each when it is done, as a JSON object a line. It ends when nothing
more can come, whatever it is doing: whoever wanted it is gone, and nobody else would remove its folder.
"""

from __future__ import annotations

import json
import os
import queue
import shutil
import sys
import threading
import time
from typing import Any

from tracker_core import kernels
from tracker_core.kernels.signatures import FIRST, SIGNATURES

NICE = 10
"""What only some need is compiled when nobody else wants the processor."""


def make(kernel: Any, name: str) -> None:
    """Compile a kernel for all its signatures, or load those that are kept."""
    for signature in SIGNATURES[name]:
        kernel.compile(signature)


def main() -> None:
    """Compile whatever is asked for."""
    names: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(names,), daemon=True).start()
    polite = False
    while True:
        name = names.get()
        if name not in FIRST and not polite:
            polite = True
            os.nice(NICE)
        begun = time.process_time()
        make(getattr(kernels, name), name)
        sys.stdout.write(f"{json.dumps({'kernel': name, 'seconds': time.process_time() - begun})}\n")
        sys.stdout.flush()


def _listen(names: queue.SimpleQueue[str]) -> None:
    for line in sys.stdin:
        names.put(line.strip())
    shutil.rmtree(sys.argv[1], ignore_errors=True)
    os._exit(0)


if __name__ == "__main__":
    main()
