"""Answers that take long: few at a time, a line that has an end, and a limit on how long anybody waits."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from functools import partial
from typing import TypeVar, TypeVarTuple

from fastapi.responses import JSONResponse

from server.problem import problem
from tracker_core.checks import InputError

A = TypeVarTuple("A")
T = TypeVar("T")

AT_ONCE = 4
"""Answers that are computed at a time: kernels let go of the interpreter, so a few share two processors well."""

WAITING = 500
"""Answers that may wait; one of them takes no more room than its question."""

SECONDS = 30.0

AGAIN = 2
"""Seconds after which to ask again where everybody is busy."""


class NoAnswerError(Exception):
    """There will be no answer to a question that is right.

    Attributes:
        error: why.
        message: the same for a person, of the server.
        status: of HTTP.
        again: seconds after which to ask again; None where that would take as long.
    """

    def __init__(self, error: InputError, message: str, status: int, again: int | None = None) -> None:
        super().__init__(str(error))
        self.error = error
        self.message = message
        self.status = status
        self.again = again

    def response(self) -> JSONResponse:
        """The answer of HTTP."""
        headers = {} if self.again is None else {"Retry-After": str(self.again)}
        return problem(self.error, self.status, self.message, headers)


def busy(most: int) -> NoAnswerError:
    """That there are so many questions already."""
    error = InputError("server", f"must have fewer than {most} questions to answer", most)
    return NoAnswerError(error, "it is busy with other answers", 503, AGAIN)


class Work:
    """Threads for answers that take long.

    Args:
        threads: of them.
        waiting: answers that may wait for a thread.
        seconds: after which an answer is given up, the time in the line included. A thread cannot be stopped: it goes
            on to its end and is no other's until then.
        name: of the threads.
    """

    def __init__(
        self, *, threads: int = AT_ONCE, waiting: int = WAITING, seconds: float = SECONDS, name: str = "answers"
    ) -> None:
        self._seconds = seconds
        self._waiting = waiting
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._most = threads + waiting
        self._places = threading.BoundedSemaphore(self._most)

    def beside(self, name: str, threads: int) -> Work:
        """Threads of their own under the same limits, for what must not hold up the others."""
        return Work(threads=threads, waiting=self._waiting, seconds=self._seconds, name=name)

    async def run(self, function: Callable[[*A], T], *arguments: *A) -> T:
        """What the function gives, computed in a thread.

        Raises:
            NoAnswerError: where too many wait already, or it takes too long.
        """
        if not self._places.acquire(blocking=False):
            raise busy(self._most)
        # The thread knows which request it works for.
        future = self._pool.submit(partial(copy_context().run, function, *arguments))
        # Whoever gives up in the line gives up the place; whoever is being computed keeps it.
        future.add_done_callback(lambda _: self._places.release())
        try:
            async with asyncio.timeout(self._seconds) as limit:
                return await asyncio.wrap_future(future)
        except TimeoutError:
            if not limit.expired():
                raise
            error = InputError("answer", f"must be there within {self._seconds:g} s", "none yet")
            raise NoAnswerError(error, f"it has tried for {self._seconds:g} s", 504) from None
