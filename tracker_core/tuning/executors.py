"""Where the parts of a study are computed: on any `concurrent.futures.Executor`, threads by default.

The compiled kernels release the interpreter's lock: threads are all that is needed by a process that does nothing else.
The executor of another process, or of a cluster, takes the same functions with the same arguments.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from functools import cache
from typing import TypeVar

TaskT = TypeVar("TaskT")
PartT = TypeVar("PartT")

AHEAD = 2
"""Parts per worker that are handed over before the first of them is back: few, since studies stand in one line."""


@cache
def threads() -> ThreadPoolExecutor:
    """The threads that studies share where no executor is given: one per processor, and one left to everything else."""
    return ThreadPoolExecutor(max(1, (os.cpu_count() or 2) - 1), thread_name_prefix="study")


def ordered(executor: Executor | None, work: Callable[[TaskT], PartT], tasks: Iterable[TaskT]) -> Iterator[PartT]:
    """What every task comes to, in the order of the tasks; they are computed side by side.

    Closing the iterator cancels what has not begun.

    Args:
        executor: any; None for `threads()`.
        work: a function of a module, so that other processes know it.
        tasks: what it is called with, one after the other.
    """
    pool = threads() if executor is None else executor
    # An executor of a cluster does not say how many workers it has.
    window = AHEAD * getattr(pool, "_max_workers", 8)
    waiting: deque[Future[PartT]] = deque()
    try:
        for task in tasks:
            waiting.append(pool.submit(work, task))
            if len(waiting) >= window:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        for future in waiting:
            future.cancel()
