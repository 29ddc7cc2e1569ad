"""Other processes that compute answers too, once one processor is not enough: Python computes one thing at a time.

A server that few people use has none. Where the event loop is late again and again, a helper is started, and takes over
what it can; when nobody has needed it for a while, it is ended. A helper that dies or hangs costs time alone: what it
was asked is computed here.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from asyncio.subprocess import PIPE, Process
from collections import deque
from collections.abc import Callable, Sequence
from statistics import median
from time import monotonic

import msgspec

EVERY = 0.25
"""Seconds from one look at how late the event loop is to the next."""

LOOKS = 8
"""The last ones count."""

LATE = 0.02
"""Seconds: where their median is more, there is more to do than can be done here."""

DEPTH = 100
"""Questions that a helper has at a time. The event loop takes all that have come before it hears answers again: with
fewer, it computes the rest itself, and the helper meanwhile has nothing to do."""

IDLE = 300.0
"""Seconds after which a helper is ended that nobody has needed."""

PATIENCE = 30.0
"""Seconds for an answer that takes milliseconds; then the helper is ended."""

AGAIN = 10.0
"""Seconds from the start of one to the start of the next: until then it cannot be seen what it helps."""

_LOG = logging.getLogger(__name__)


class HelperGoneError(Exception):
    """There will be no answer from this helper."""


class ComputingError(Exception):
    """Computing has failed in a helper as it would have here; says how."""


class Helpers:
    """The helpers of a server; all of it on its event loop.

    Args:
        most: of them; 0 for none ever.
        command: that starts one; it speaks as `frame` says on its standard input and output.
    """

    def __init__(self, most: int, command: Sequence[str]) -> None:
        self._most = most
        self._command = tuple(command)
        self._helpers: list[_Helper] = []
        self._watching: asyncio.Task[None] | None = None
        self._ended = False

    async def compute(self, name: str, question: Callable[[], bytes]) -> bytes | None:
        """An answer, by a helper that is free; None where there is none, and it is to be computed here.

        Args:
            name: what is to be computed, as helpers know it.
            question: what it is computed from.

        Raises:
            ComputingError: where it failed.
        """
        if self._watching is None and self._most and not self._ended:
            self._watching = asyncio.create_task(self._watch(), name="helpers")
        for helper in tuple(self._helpers):
            if helper.is_free:
                with contextlib.suppress(HelperGoneError):
                    return await helper.ask(name, question())
        return None

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

    async def _watch(self) -> None:
        """Look how late the event loop is; where it is late most of the time, call help."""
        late: deque[float] = deque(maxlen=LOOKS)
        while True:
            due = monotonic() + EVERY
            await asyncio.sleep(EVERY)
            late.append(monotonic() - due)
            if len(late) == LOOKS and median(late) > LATE and len(self._helpers) < self._most:
                late.clear()
                helper = _Helper()
                self._helpers.append(helper)
                helper.work = asyncio.create_task(self._keep(helper), name="helper")
                await asyncio.sleep(AGAIN)

    async def _keep(self, helper: _Helper) -> None:
        """From the start of a helper to its end."""
        try:
            await helper.run(self._command)
        except (OSError, asyncio.IncompleteReadError, msgspec.DecodeError) as error:
            if not self._ended:
                _LOG.warning("A helper is gone: %s: %s", type(error).__name__, error)
        finally:
            self._helpers.remove(helper)
            helper.kill()


class _Helper:
    """One process, which answers questions in their order."""

    def __init__(self) -> None:
        self._process: Process | None = None
        self._says: asyncio.StreamWriter | None = None
        self._asked: deque[asyncio.Future[bytes]] = deque()
        self._ready = self._unwanted = False
        self._used = monotonic()
        self.work: asyncio.Task[None] | None = None

    @property
    def is_free(self) -> bool:
        return self._ready and len(self._asked) < DEPTH

    async def run(self, command: Sequence[str]) -> None:
        """Start the process and hear it until nobody needs it.

        Raises:
            OSError: where it cannot be started.
            asyncio.IncompleteReadError: where it has ended.
            msgspec.DecodeError: where it says what is no answer.
        """
        self._process = process = await asyncio.create_subprocess_exec(*command, stdin=PIPE, stdout=PIPE)
        if self._unwanted:
            self.kill()
        hears, self._says = process.stdout, process.stdin
        if hears is None:
            raise OSError("there is no pipe")
        try:
            while True:
                try:
                    async with asyncio.timeout(IDLE):
                        said = await _unframed(hears)
                except TimeoutError:
                    if self._asked or monotonic() - self._used < IDLE:
                        continue
                    return
                if self._ready:
                    self._take(said)
                self._ready = True
        finally:
            self._ready = False
            for future in self._asked:
                if not future.done():
                    future.set_exception(HelperGoneError())
            self._asked.clear()

    async def ask(self, name: str, question: bytes) -> bytes:
        """Its answer.

        Raises:
            ComputingError: where there is an error instead.
            HelperGoneError: where it has ended, or is ended for taking so long.
        """
        if self._says is None:
            raise HelperGoneError
        future: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._used = monotonic()
        self._asked.append(future)
        self._says.write(frame((name, question)))
        try:
            async with asyncio.timeout(PATIENCE):
                return await future
        except TimeoutError:
            _LOG.warning("A helper has not answered %s within %g s and is ended", name, PATIENCE)
            self.kill()
            raise HelperGoneError from None

    def kill(self) -> None:
        """End the process at once: it has nothing that could be lost."""
        self._ready, self._unwanted = False, True
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()

    def _take(self, said: bytes) -> None:
        right, answer = _read_answer(said)
        if not self._asked:
            raise msgspec.DecodeError("nobody has asked for it")
        future = self._asked.popleft()
        # Whoever asked may have gone.
        if not future.done():
            if right:
                future.set_result(answer)
            else:
                future.set_exception(ComputingError(answer.decode()))


_read_answer = msgspec.msgpack.Decoder(tuple[bool, bytes]).decode
_read_question = msgspec.msgpack.Decoder(tuple[str, bytes]).decode


def frame(message: tuple[str, bytes] | tuple[bool, bytes]) -> bytes:
    """A message as it goes through a pipe: its length (4 bytes), and MessagePack.

    A question is a name and what is computed from; an answer is true and what was computed, or false and what went
    wrong. The first answer belongs to no question: the helper is ready.
    """
    text = msgspec.msgpack.encode(message)
    return len(text).to_bytes(4, "little") + text


async def _unframed(stream: asyncio.StreamReader) -> bytes:
    return await stream.readexactly(int.from_bytes(await stream.readexactly(4), "little"))


def question_in(stream: Callable[[int], bytes]) -> tuple[str, bytes] | None:
    """The next question that a helper is asked; None where there will be none.

    Args:
        stream: reads so many bytes, fewer only at its end.
    """
    length = stream(4)
    if len(length) < 4:
        return None
    text = stream(int.from_bytes(length, "little"))
    return _read_question(text)
