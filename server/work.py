"""Answers that take long: few at a time, a line that has an end, and a limit on how long anybody waits."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar, TypeVarTuple

from fastapi.responses import JSONResponse

from server.clients import CLIENT
from server.line import Line
from server.metrics import REFUSALS, computing
from server.problem import problem
from tracker_core.checks import InputError

A = TypeVarTuple("A")
T = TypeVar("T")

AT_ONCE = 4
"""Answers that are computed at a time: kernels let go of the interpreter, so a few share two processors well."""

WAITING = 500
"""Answers that may wait, half of them one client's; one of them takes no more room than its question."""

SECONDS = 30.0

ANSWERS = "answers"
"""What most of it is, among the figures."""

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


def busy() -> NoAnswerError:
    """That there are too many questions already; it is counted as a refusal."""
    REFUSALS.labels("busy").inc()
    error = InputError("server", "must have fewer questions to answer, of all clients or of this one", "one more")
    return NoAnswerError(error, "it is busy with other answers", 503, AGAIN)


def late(seconds: float) -> NoAnswerError:
    """That an answer takes more than so many seconds; it is counted as a refusal."""
    REFUSALS.labels("late").inc()
    error = InputError("answer", f"must be there within {seconds:g} s", "none yet")
    return NoAnswerError(error, f"it has tried for {seconds:g} s", 504)


@dataclass(eq=False, slots=True)
class _Asked:
    """An answer that is to be computed.

    Attributes:
        client: who asks.
        compute: gives it.
        answer: what it will be.
    """

    client: str
    compute: Callable[[], Any]
    answer: Future[Any] = field(default_factory=Future)


class Work:
    """Threads for answers that take long; clients take turns at them.

    Args:
        threads: of them.
        waiting: answers that may wait for a thread; those of one client half of them.
        seconds: after which an answer is given up, the time in the line included. A thread cannot be stopped: it goes
            on to its end and is no other's until then.
        name: of the threads, and of what they do among the figures.
    """

    def __init__(
        self, *, threads: int = AT_ONCE, waiting: int = WAITING, seconds: float = SECONDS, name: str = ANSWERS
    ) -> None:
        self._name = name
        self._seconds = seconds
        self._waiting = waiting
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._line: Line[_Asked] = Line(threads, threads, waiting)
        self._lock = threading.Lock()

    def beside(self, name: str, threads: int) -> Work:
        """Threads of their own under the same limits, for what must not hold up the others."""
        return Work(threads=threads, waiting=self._waiting, seconds=self._seconds, name=name)

    async def run(self, function: Callable[[*A], T], *arguments: *A) -> T:
        """What the function gives, computed in a thread.

        Raises:
            NoAnswerError: where too many wait already, or it takes too long.
        """
        # The thread knows which request it works for.
        compute = partial(copy_context().run, function, *arguments)
        asked = _Asked(CLIENT.get(), partial(_measured, self._name, compute))
        with self._lock:
            if not self._line.enter(asked.client, asked):
                raise busy()
        self._call()
        try:
            async with asyncio.timeout(self._seconds) as limit:
                return await asyncio.wrap_future(asked.answer)
        except TimeoutError:
            if not limit.expired():
                raise
            raise late(self._seconds) from None
        finally:
            # Whoever gives up in the line gives up the place; whoever is being computed keeps it.
            with self._lock:
                self._line.remove(asked.client, asked)
            # An error holds this frame by its trace, and the answer holds the error.
            del asked

    def _call(self) -> None:
        """Whose turn it is gets a thread."""
        while True:
            with self._lock:
                asked = self._line.next()
            if asked is None:
                return
            if asked.answer.set_running_or_notify_cancel():
                self._pool.submit(asked.compute).add_done_callback(partial(self._end, asked))
            else:
                self._leave(asked)

    def _end(self, asked: _Asked, computed: Future[Any]) -> None:
        """In its thread: what was asked is computed, and the next one gets the thread."""
        self._leave(asked)
        self._call()
        error = computed.exception()
        if error is None:
            asked.answer.set_result(computed.result())
        else:
            asked.answer.set_exception(error)

    def _leave(self, asked: _Asked) -> None:
        with self._lock:
            self._line.leave(asked.client)


def _measured(name: str, compute: Callable[[], T]) -> T:
    with computing(name):
        return compute()
