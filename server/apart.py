"""An executor whose work is done by another process, when nobody else wants the processor.

Threads of the server would do as well, did they not take turns with its event loop at being the one who may run: work
of minutes beside it makes everybody wait. `python -m server.apart FORM LEVEL THREADS` is the process.
"""

from __future__ import annotations

import logging
import os
import pickle
import select
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from functools import partial
from itertools import count
from typing import IO, Any

from server import child

NICE = 10

IDLE = 300.0
"""Seconds after which the process is ended that nobody has needed."""

AGAIN = 10.0
"""Seconds from the start of one to the start of the next: one that cannot live is not to be started all the time."""

_LOG = logging.getLogger(__name__)

Call = Callable[[], Any]


class Apart(Executor):
    """Calls go to a process of their own; to `here` as long as there is none, and again where it has died.

    It is started when it is first needed, and ended when nobody has needed it for a while.

    Args:
        command: that starts the process.
        workers: threads that it computes with.
        here: computes what it cannot.
        may_start: whether it may be started by now.
    """

    def __init__(
        self, command: Sequence[str], workers: int, here: Executor, may_start: Callable[[], bool] = lambda: True
    ) -> None:
        # Whoever hands parts over looks how many to hand over at a time, as with executors of threads.
        self._max_workers = workers
        self._command = tuple(command)
        self._here = here
        self._may_start = may_start
        self._lock = threading.Lock()
        self._process: _Process | None = None
        self._next_at = 0.0
        self._ended = False

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """Hand a call over: a function of a module, with what can be pickled."""
        call = partial(work, *arguments, **named)
        process = self._there()
        future = None if process is None else process.ask(call)
        return self._here.submit(call) if future is None else future

    def _there(self) -> _Process | None:
        """The process; one is started where there is none and may be."""
        with self._lock:
            now = time.monotonic()
            if self._process is None and not self._ended and now >= self._next_at and self._may_start():
                self._next_at = now + AGAIN
                try:
                    self._process = _Process(self._command, self._again, self._gone)
                except OSError as error:
                    _LOG.warning("Another process could not be started: %s: %s", type(error).__name__, error)
            return self._process

    def running(self) -> bool:
        """Whether there is a process."""
        return self._process is not None

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the process; what it has not done is given up."""
        del wait, cancel_futures
        with self._lock:
            self._ended, process = True, self._process
        if process is not None:
            process.end()

    def _gone(self) -> None:
        with self._lock:
            self._process = None

    def _again(self, future: Future[Any], call: Call) -> None:
        """Do here what the process has not done."""
        if self._ended:
            future.cancel()
            return
        _LOG.warning("What another process has not done is done here")
        self._here.submit(call).add_done_callback(lambda done: _copy(done, future))


class _Process:
    """The process, and a thread that hears it.

    Args:
        command: that starts it.
        again: is given what it has not done.
        gone: called once it has ended.
    """

    def __init__(
        self, command: Sequence[str], again: Callable[[Future[Any], Call], None], gone: Callable[[], None]
    ) -> None:
        # Read without a buffer: what has been taken out of the pipe could not be seen in it any more.
        self._popen = subprocess.Popen(  # noqa: S603 - our own program
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
        )
        hears, says = self._popen.stdout, self._popen.stdin
        if hears is None or says is None:
            raise OSError("there is no pipe")
        self._hears, self._says = hears, says
        self._again, self._gone = again, gone
        self._lock = threading.Lock()
        self._asked: dict[int, tuple[Future[Any], Call]] = {}
        self._numbers = count()
        self._ready = False
        threading.Thread(target=self._hear, name="apart", daemon=True).start()

    def ask(self, call: Call) -> Future[Any] | None:
        """What the call gives, once it is there; None where it is to be done elsewhere."""
        future: Future[Any] = Future()
        number = next(self._numbers)
        text = child.framed(pickle.dumps((number, call), 5))
        with self._lock:
            if not self._ready:
                return None
            self._asked[number] = future, call
            try:
                _write(self._says, text)
            except OSError:
                del self._asked[number]
                return None
        return future

    def end(self) -> None:
        """End it at once."""
        self._popen.kill()

    def _hear(self) -> None:
        """In its thread: take answers until it is gone, or idle for long."""
        try:
            while self._may_go_on() and (text := child.text_in(self._hears.read)) is not None:
                if self._ready:
                    self._take(text)
                self._ready = True
        except (OSError, pickle.UnpicklingError, LookupError) as error:
            _LOG.warning("Another process is gone: %s: %s", type(error).__name__, error)
        with self._lock:
            self._ready = False
            left, self._asked = list(self._asked.values()), {}
        with self._popen:
            self._popen.kill()
        self._gone()
        for future, call in left:
            self._again(future, call)

    def _may_go_on(self) -> bool:
        """Wait for what it says next; false where nobody has needed it for long."""
        while not select.select([self._hears], [], [], IDLE)[0]:
            with self._lock:
                if self._ready and not self._asked:
                    self._ready = False
                    return False
        return True

    def _take(self, text: bytes) -> None:
        number, right, value = pickle.loads(text)  # noqa: S301 - from a process of our own
        with self._lock:
            future, _ = self._asked.pop(number)
        # Who asked may not want it any more.
        if not future.set_running_or_notify_cancel():
            return
        if right:
            future.set_result(value)
        else:
            future.set_exception(value)


def _write(pipe: IO[bytes], text: bytes) -> None:
    """Write all of it."""
    rest = memoryview(text)
    while rest:
        rest = rest[pipe.write(rest) :]


def _copy(done: Future[Any], future: Future[Any]) -> None:
    """Give a future what another has come to."""
    if not future.set_running_or_notify_cancel():
        return
    if (error := done.exception()) is not None:
        future.set_exception(error)
    else:
        future.set_result(done.result())


def give_way() -> None:
    """From now on this thread, and those that it starts, compute when nobody else wants the processor."""
    if hasattr(os, "SCHED_IDLE"):
        # Merely nice, it would have a processor of its own while all others share what is left.
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    else:
        os.nice(NICE)


def main() -> None:
    """Do what is asked until the server is gone."""
    form, level, threads = sys.argv[1:]
    out = child.begin(form, level)
    give_way()
    lock = threading.Lock()

    def say(answer: Any) -> None:
        text = child.framed(pickle.dumps(answer, 5))
        with lock:
            out.write(text)
            out.flush()

    def do(number: int, call: Call) -> None:
        try:
            say((number, True, call()))
        except Exception as error:  # noqa: BLE001 - whoever asked has to know it
            error.add_note(traceback.format_exc())
            say((number, False, error))

    pool = ThreadPoolExecutor(int(threads), thread_name_prefix="apart")
    say(None)
    while (text := child.text_in(sys.stdin.buffer.read)) is not None:
        pool.submit(do, *pickle.loads(text))  # noqa: S301 - from the server
    # Nobody waits for what is still being computed.
    os._exit(0)


if __name__ == "__main__":
    main()
