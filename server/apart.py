"""An executor whose work is done by another process, when nobody else wants the processor.

Threads of the server would do as well, did they not take turns with its event loop at being the one who may run: work
of minutes beside it makes everybody wait. Where the processors are wanted all the time, a piece of work now and then is
done here all the same, so that none stands still. `python -m server.apart FORM LEVEL THREADS` is the process.
"""

from __future__ import annotations

import contextlib
import logging
import os
import pickle
import queue
import select
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, Future, InvalidStateError, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from server import child

NICE = 10

IDLE = 300.0
"""Seconds after which the process is ended that nobody has needed."""

HURRY = 1.0
"""Seconds without an answer after which the oldest call is done here as well; one at a time."""

LOOKED_AFTER = 0.1
"""Seconds without an answer after which it is looked how long there has been none."""

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
        folder: in which it is started; None for the present one.
    """

    def __init__(
        self,
        command: Sequence[str],
        workers: int,
        here: Executor,
        may_start: Callable[[], bool] = lambda: True,
        folder: Path | None = None,
    ) -> None:
        # Whoever hands parts over looks how many to hand over at a time, as with executors of threads.
        self._max_workers = workers
        self._command = tuple(command)
        self._here = here
        self._may_start = may_start
        self._folder = folder
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
                    self._process = _Process(self._command, self._folder, self._do, self._gone)
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

    def _gone(self, left: Iterable[_Given]) -> None:
        """The process has ended; what it has not done is done here."""
        with self._lock:
            self._process = None
        for given in left:
            if self._ended:
                given.future.cancel()
            else:
                _LOG.warning("What another process has not done is done here")
                self._do(given)

    def _do(self, given: _Given) -> Future[Any]:
        done = self._here.submit(given.call)
        done.add_done_callback(partial(_copy, given.future))
        return done


@dataclass(slots=True)
class _Given:
    """A call that a process is given.

    Attributes:
        future: what it comes to.
        call: does it.
        text: the same as it is sent.
        since: when it was given, in seconds of `time.monotonic`.
        is_sent: whether the process hears of it.
    """

    future: Future[Any]
    call: Call
    text: bytes
    since: float
    is_sent: bool = False


class _Process:
    """The process, and a thread that hears it.

    Args:
        command: that starts it.
        folder: in which.
        do: does a call here.
        gone: is given what it has not done, once it has ended.
    """

    def __init__(
        self,
        command: Sequence[str],
        folder: Path | None,
        do: Callable[[_Given], Future[Any]],
        gone: Callable[[Iterable[_Given]], None],
    ) -> None:
        # Read without a buffer: what has been taken out of the pipe could not be seen in it any more.
        self._popen = subprocess.Popen(  # noqa: S603 - our own program
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, cwd=folder
        )
        hears, says = self._popen.stdout, self._popen.stdin
        if hears is None or says is None:
            raise OSError("there is no pipe")
        self._hears, self._says = hears, says
        self._do, self._gone = do, gone
        self._lock = threading.Lock()
        self._asked: dict[int, _Given] = {}
        self._numbers = count()
        self._ready = False
        self._used = time.monotonic()
        self._hurried: Future[Any] | None = None
        # Numbers alone: what nobody wants any more takes no room while it waits to be sent.
        self._words: queue.SimpleQueue[int | None] = queue.SimpleQueue()
        self._speaker = threading.Thread(target=self._say, name="apart-says", daemon=True)
        self._speaker.start()
        threading.Thread(target=self._hear, name="apart-hears", daemon=True).start()

    def ask(self, call: Call) -> Future[Any] | None:
        """What the call gives, once it is there; None where it is to be done elsewhere."""
        number = next(self._numbers)
        given = _Given(Future(), call, child.framed(pickle.dumps((number, call), 5)), time.monotonic())
        with self._lock:
            if not self._ready:
                return None
            self._asked[number] = given
        self._words.put(number)
        given.future.add_done_callback(lambda _: self._drop(number))
        return given.future

    def end(self) -> None:
        """End it at once."""
        self._popen.kill()

    def _drop(self, number: int) -> None:
        """Nobody waits any more for what it was given, if it has not answered."""
        with self._lock:
            given = self._asked.pop(number, None)
        if given is not None and given.is_sent:
            self._words.put(number)

    def _say(self) -> None:
        """In its thread: say what there is to be said. Where it gets no processor, it does not listen either."""
        with contextlib.suppress(OSError):
            while (number := self._words.get()) is not None:
                rest = memoryview(self._text(number))
                while rest:
                    rest = rest[self._says.write(rest) :]

    def _text(self, number: int) -> bytes:
        """What is said under a number: first the call, then that nobody wants it any more."""
        with self._lock:
            given = self._asked.get(number)
            if given is None:
                return child.framed(pickle.dumps((number, None), 5))
            given.is_sent = True
            return given.text

    def _hear(self) -> None:
        """In its thread: take answers until it is gone, or idle for long."""
        try:
            # Not select, which knows no descriptor beyond 1,023.
            poll = select.poll()
            poll.register(self._hears, select.POLLIN)
            while self._is_wanted():
                if not poll.poll(1000 * LOOKED_AFTER):
                    self._hurry()
                elif (text := child.text_in(self._hears.read)) is None:
                    break
                else:
                    self._take(text)
        except Exception as error:  # noqa: BLE001 - whatever it says, somebody waits for it
            _LOG.warning("Another process is gone: %s: %s", type(error).__name__, error)
        with self._lock:
            self._ready = False
            left, self._asked = list(self._asked.values()), {}
        self._words.put(None)
        self._popen.kill()
        self._speaker.join()
        with self._popen:
            pass
        self._gone(left)

    def _is_wanted(self) -> bool:
        """Whether it was needed lately; from then on it is given nothing."""
        with self._lock:
            if self._ready and not self._asked and time.monotonic() - self._used > IDLE:
                self._ready = False
                return False
        return True

    def _hurry(self) -> None:
        """Have the oldest call done here as well, where there has been no answer for long."""
        with self._lock:
            oldest = next(iter(self._asked.values()), None)
        now = time.monotonic()
        if oldest is None or now - max(oldest.since, self._used) < HURRY:
            return
        if self._hurried is None or self._hurried.done():
            self._used, self._hurried = now, self._do(oldest)

    def _take(self, text: bytes) -> None:
        self._used = time.monotonic()
        if not self._ready:
            self._ready = True
            return
        number, right, value = pickle.loads(text)  # noqa: S301 - from a process of our own
        with self._lock:
            given = self._asked.pop(number, None)
        if given is not None:
            _settle(given.future, value if right else None, None if right else value)


def _settle(future: Future[Any], result: Any, error: BaseException | None) -> None:
    """Say what it came to; who asked may have gone, or have been told already."""
    with contextlib.suppress(InvalidStateError):
        if error is None:
            future.set_result(result)
        else:
            future.set_exception(error)


def _copy(future: Future[Any], done: Future[Any]) -> None:
    """Give a future what another one has come to."""
    if done.cancelled():
        future.cancel()
    else:
        error = done.exception()
        _settle(future, None if error else done.result(), error)


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
    given: dict[int, Future[None]] = {}

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

    def forget(number: int, done: Future[None]) -> None:
        del done
        given.pop(number, None)

    pool = ThreadPoolExecutor(int(threads), thread_name_prefix="apart")
    say(None)
    while (text := child.text_in(sys.stdin.buffer.read)) is not None:
        number, call = pickle.loads(text)  # noqa: S301 - from the server
        if call is not None:
            given[number] = pool.submit(do, number, call)
            given[number].add_done_callback(partial(forget, number))
        elif (unwanted := given.get(number)) is not None:
            unwanted.cancel()
    # Nobody waits for what is still being computed.
    os._exit(0)


if __name__ == "__main__":
    main()
