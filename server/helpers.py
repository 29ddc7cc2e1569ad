"""Other processes that compute answers too, once one processor is not enough: Python computes one thing at a time.

A server that few people use has none. Where answers wait again and again, a helper is started; as long as there is one,
helpers compute what they can and the event loop none of it, so that it is there for everybody at once. When nobody has
needed a helper for a while, it is ended. One that dies costs time alone, and one that hangs the answer that it hung on.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from asyncio.subprocess import PIPE, Process
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from statistics import median
from time import monotonic

import msgspec

from server import child
from server.work import SECONDS, busy, late

EVERY = 0.25
"""Seconds from one look at how long answers wait to the next."""

LOOKS = 8
"""The last ones count."""

LATE = 0.02
"""Seconds: where the median of what was seen is more, there is more to do than is being done."""

DEPTH = 16
"""Questions that a helper has at a time: enough that it does not wait for the event loop, which hears it in turn."""

WAITING = 1_000
"""Questions that may wait for a helper; they take some seconds."""

IDLE = 300.0
"""Seconds after which a helper is ended that nobody has needed."""

ENDING = 1.0
"""Seconds for the end of one that has closed its output."""

AGAIN = 10.0
"""Seconds from the start of one to the start of the next: until then it cannot be seen what it helps."""

_LOG = logging.getLogger(__name__)


class HelperGoneError(Exception):
    """There will be no answer from this helper."""


class ComputingError(Exception):
    """Computing has failed in a helper as it would have here; says how."""


@dataclass(eq=False, slots=True)
class _Asked:
    """A question on its way.

    Attributes:
        name: what is to be computed, as helpers know it.
        question: what it is computed from.
        answer: its answer, once it is there.
        since: when it came, in seconds of `time.monotonic`.
        given: when a helper was given it; 0 before.
    """

    name: str
    question: Callable[[], bytes]
    answer: asyncio.Future[bytes]
    since: float
    given: float = 0.0

    def fail(self) -> None:
        """No helper answers it."""
        if not self.answer.done():
            self.answer.set_exception(HelperGoneError())


class Helpers:
    """The helpers of a server; all of it on its event loop.

    Args:
        most: of them; 0 for none ever.
        command: that starts one; it speaks as `frame` says on its standard input and output.
        folder: in which it is started; None for the present one.
        seconds: after which an answer is given up, the time in the line included, and a helper ended that has been at
            one for as long.
    """

    def __init__(self, most: int, command: Sequence[str], folder: Path | None = None, seconds: float = SECONDS) -> None:
        self._most = most
        self._seconds = seconds
        self._command = tuple(command)
        self._folder = folder
        self._helpers: list[_Helper] = []
        self._line: deque[_Asked] = deque()
        self._watching: asyncio.Task[None] | None = None
        self._ended = False

    async def compute(self, name: str, question: Callable[[], bytes]) -> bytes | None:
        """An answer by a helper; None where there is none, and it is to be computed here.

        Args:
            name: what is to be computed, as helpers know it.
            question: what it is computed from.

        Raises:
            ComputingError: where it failed.
            HelperGoneError: where the helper was lost that had been asked, or there is none any more.
            NoAnswerError: where too many wait already, or it takes too long.
        """
        if self._watching is None and self._most and not self._ended:
            self._watching = asyncio.create_task(self._watch(), name="helpers")
        if not any(helper.is_ready for helper in self._helpers):
            return None
        if len(self._line) >= WAITING:
            raise busy()
        asked = _Asked(name, question, asyncio.get_running_loop().create_future(), monotonic())
        self._line.append(asked)
        self._give()
        try:
            async with asyncio.timeout(self._seconds):
                return await asked.answer
        except TimeoutError:
            raise late(self._seconds) from None

    def running(self) -> int:
        """Helpers that are ready or being started."""
        return len(self._helpers)

    def stop(self) -> None:
        """End all, and start none any more."""
        self._ended = True
        if self._watching is not None:
            self._watching.cancel()
        for helper in self._helpers:
            helper.kill()

    def _give(self) -> None:
        """Give what waits to whoever has least to do."""
        ready = [helper for helper in self._helpers if helper.is_ready]
        while self._line:
            helper = min(ready, key=len, default=None)
            if helper is not None and len(helper) >= DEPTH:
                return
            asked = self._line.popleft()
            if helper is None:
                asked.fail()
            elif not asked.answer.done():
                # Somebody still waits for it.
                helper.ask(asked)

    async def _watch(self) -> None:
        """Look how long answers wait; where they do most of the time, call help."""
        waits: deque[float] = deque(maxlen=LOOKS)
        next_at = 0.0
        while True:
            due = monotonic() + EVERY
            await asyncio.sleep(EVERY)
            now = monotonic()
            for helper in tuple(self._helpers):
                helper.look(now, self._seconds)
            oldest = min((helper.oldest for helper in self._helpers), default=now)
            waits.append(now - min(due, oldest))
            if len(waits) == LOOKS and median(waits) > LATE and len(self._helpers) < self._most and now >= next_at:
                waits.clear()
                next_at = now + AGAIN
                helper = _Helper(self._give)
                self._helpers.append(helper)
                helper.work = asyncio.create_task(self._keep(helper), name="helper")

    async def _keep(self, helper: _Helper) -> None:
        """From the start of a helper to its end."""
        try:
            await helper.run(self._command, self._folder)
        except (OSError, asyncio.IncompleteReadError, msgspec.DecodeError) as error:
            if not self._ended:
                _LOG.warning("A helper is gone: %s: %s", type(error).__name__, error)
        finally:
            # Where it was the last one, no other will answer what waits.
            self._give()
            await helper.end()
            self._helpers.remove(helper)


class _Helper:
    """One process, which answers questions in their order.

    Args:
        free: called whenever it can be asked something.
    """

    def __init__(self, free: Callable[[], None]) -> None:
        self._free = free
        self._process: Process | None = None
        self._says: asyncio.StreamWriter | None = None
        self._asked: deque[_Asked] = deque()
        self._unwanted = self._killed = False
        self._used = monotonic()
        self.is_ready = False
        self.work: asyncio.Task[None] | None = None

    def __len__(self) -> int:
        return len(self._asked)

    @property
    def oldest(self) -> float:
        """When what it has been asked first came; infinity where it has nothing to do."""
        return self._asked[0].since if self._asked else inf

    async def run(self, command: Sequence[str], folder: Path | None) -> None:
        """Start the process and hear it until it is ended.

        Raises:
            OSError: where it cannot be started.
            asyncio.IncompleteReadError: where it has ended by itself.
            msgspec.DecodeError: where it says what is no answer.
        """
        self._process = process = await asyncio.create_subprocess_exec(*command, stdin=PIPE, stdout=PIPE, cwd=folder)
        if self._unwanted:
            self.kill()
        hears, self._says = process.stdout, process.stdin
        if hears is None:
            raise OSError("there is no pipe")
        try:
            while True:
                said = await _unframed(hears)
                if self.is_ready:
                    self._take(said)
                self.is_ready = not self._unwanted
                self._used = monotonic()
                self._free()
        except asyncio.IncompleteReadError:
            if not self._unwanted:
                raise
        finally:
            self.is_ready = False
            for asked in self._asked:
                asked.fail()
            self._asked.clear()

    def ask(self, asked: _Asked) -> None:
        """Give it a question, once it is ready."""
        if self._says is None:
            asked.fail()
            return
        asked.given = monotonic()
        self._asked.append(asked)
        self._says.write(frame((asked.name, asked.question())))

    def look(self, now: float, seconds: float) -> None:
        """End it where it has been at an answer for so many seconds, or where nobody has needed it for a while."""
        if self._asked and now - self._asked[0].given > seconds:
            _LOG.warning("A helper has not answered %s within %g s and is ended", self._asked[0].name, seconds)
            self.kill()
        elif self.is_ready and not self._asked and now - self._used > IDLE:
            self.kill()

    def kill(self) -> None:
        """End the process at once: it has nothing that could be lost."""
        self.is_ready, self._unwanted = False, True
        if self._process is not None and not self._killed:
            self._killed = True
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()

    async def end(self) -> None:
        """See the process gone; it is killed unless it is about to end by itself."""
        process, says = self._process, self._says
        if process is None:
            return
        if not self._unwanted:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(ENDING):
                    await process.wait()
        if process.returncode is None:
            self.kill()
            await process.wait()
        if says is not None:
            says.close()
            with contextlib.suppress(OSError):
                await says.wait_closed()

    def _take(self, said: bytes) -> None:
        right, answer = _read_answer(said)
        if not self._asked:
            raise msgspec.DecodeError("nobody has asked for it")
        future = self._asked.popleft().answer
        # Whoever asked may have gone.
        if not future.done():
            if right:
                future.set_result(answer)
            else:
                future.set_exception(ComputingError(answer.decode()))


_read_answer = msgspec.msgpack.Decoder(tuple[bool, bytes]).decode
_read_question = msgspec.msgpack.Decoder(tuple[str, bytes]).decode


def frame(message: tuple[str, bytes] | tuple[bool, bytes]) -> bytes:
    """A message as it goes through a pipe (see server/child.py), in MessagePack.

    A question is a name and what is computed from; an answer is true and what was computed, or false and what went
    wrong.
    """
    return child.framed(msgspec.msgpack.encode(message))


async def _unframed(stream: asyncio.StreamReader) -> bytes:
    return await stream.readexactly(int.from_bytes(await stream.readexactly(4), "little"))


def question_in(stream: Callable[[int], bytes]) -> tuple[str, bytes] | None:
    """The next question that a helper is asked; None where there will be none.

    Args:
        stream: reads up to so many bytes, none only at its end.
    """
    text = child.text_in(stream)
    return None if text is None else _read_question(text)
