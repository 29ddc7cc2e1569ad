"""Studies on the server: a few at a time, the others in turn; progress and partial results over a socket.

A page asks with its link, as often as it likes: a question about the study that is running goes on with it, another
one ends it, and so does a page that goes away. Nothing is kept but the last few outcomes: the same link gives the same
study, and the same study the same bits, after a reload or a restart as well.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import partial
from time import perf_counter
from typing import Any

import orjson
from fastapi import FastAPI, WebSocket, WebSocketDisconnect

from layouts.asked import Asked, Content, Study, refused
from layouts.questions import StudyQuestion, read_study_question
from server.apart import Apart
from server.clients import CLIENT
from server.limits import share
from server.line import Line
from server.metrics import computing
from server.sockets import listen
from server.work import NoAnswerError, Work
from tracker_core import InputError
from tracker_core.tuning import Progress

AT_ONCE = 3
"""Studies that are computed at a time, two of one client: one may take an hour, and others are not to wait for that."""

BESIDE = 2
"""Threads in which studies are begun and shown: files are read there, and what a page gets is drawn."""

STEP = 0.25
"""Seconds between two partial results."""

PACE = 5
"""A partial result takes at most one part in this of a study's time, however large it is."""

MINUTES = 60.0
WAITING = 100

REMEMBERED = 32
REMEMBERED_SCORES = 8_000_000
"""Outcomes that are kept for whoever asks again, a reload or another theme; and the scores that they may hold. As much
again for what ended before it was done."""

_LOG = logging.getLogger(__name__)


Begin = Callable[[StudyQuestion], tuple[Study, Content]]
"""From a page's question to the study it asks for and what the page shows of it; raises InputError."""


class Studies:
    """The studies of all pages.

    Args:
        work: under whose limits they are begun and shown.
        executor: where their parts are computed; None for this machine's threads.
        minutes: after which a study ends with what it has come to.
        waiting: studies that may wait for their turn; half of them one client's.

    Attributes:
        work: threads in which they are begun and shown.
    """

    def __init__(
        self, work: Work, executor: Executor | None = None, *, minutes: float = MINUTES, waiting: int = WAITING
    ) -> None:
        self.work = work.beside("study page", BESIDE)
        self._executor = executor
        self._minutes = minutes
        self._drivers = ThreadPoolExecutor(AT_ONCE, thread_name_prefix="studies")
        self._line: Line[Asked] = Line(AT_ONCE, share(AT_ONCE), waiting)
        self._ended = False
        self._outcomes: OrderedDict[Study, Progress[Any]] = OrderedDict()
        self._unfinished: OrderedDict[Asked, Progress[Any]] = OrderedDict()

    def attach(self, server: FastAPI, path: str, begin: Begin) -> None:
        """Serve a page's studies on a socket; the questions are of `StudyQuestion`.

        Answers are `{seq, state}`, with `place` while "queued"; `done`, `of`, `seconds`, `remaining` and `content`
        while "running" and once "done", and `minutes` as well where it has taken them and is "over"; `errors` by field
        where "refused". To "again" the same is to be asked once more, where too many are "waiting" later on. Of a
        question that cannot be read `problem` says why.
        """

        @server.websocket(path)
        async def socket(websocket: WebSocket) -> None:
            page = _Page(self, begin)
            sending = asyncio.create_task(page.send(websocket.send_bytes))
            try:
                await listen(websocket, read_study_question, page.ask, _unreadable)
            finally:
                page.leave()
                sending.cancel()

    def stop(self) -> None:
        """Begin nothing more: the server ends."""
        self._ended = True
        self._drivers.shutdown(wait=False, cancel_futures=True)

    def outcome(self, study: Study) -> Progress[Any] | None:
        """What a study came to, if it has been run lately."""
        found = self._outcomes.get(study)
        if found is not None:
            self._outcomes.move_to_end(study)
        return found

    def _remember(self, study: Study, progress: Progress[Any]) -> None:
        """Keep an outcome, as long as there is room."""
        self._outcomes[study] = progress
        while _is_too_much(self._outcomes):
            self._outcomes.popitem(last=False)

    def _look_back(self, asked: Asked) -> None:
        """Keep how far a study had come that runs no more, as long as there is room: its page may want to see it."""
        if asked.is_forgotten:
            asked.last = None
        if asked.last is None:
            return
        self._unfinished[asked] = asked.last[0]
        while _is_too_much(self._unfinished):
            self._unfinished.popitem(last=False)[0].last = None

    def load(self) -> tuple[int, int]:
        """Studies that run, and that wait for their turn."""
        return self._line.taken, len(self._line)

    def processes(self) -> int:
        """Processes of this machine that studies are computed by, beside the server."""
        return int(isinstance(self._executor, Apart) and self._executor.running())

    def enter(self, asked: Asked) -> None:
        """Run it now or put it in the line, if that is not too long already."""
        if not self._line.enter(asked.client, asked):
            asked.stopped.set()
            asked.tell({"seq": asked.view[0], "state": "waiting"})
            return
        self._call()

    def leave(self, asked: Asked) -> None:
        """Take it out of the line, or end it within a part of its work."""
        asked.stopped.set()
        if self._line.remove(asked.client, asked):
            self._call()

    def forget(self, asked: Asked) -> None:
        """Nobody will look back at it."""
        asked.is_forgotten, asked.last = True, None
        self._unfinished.pop(asked, None)

    def _call(self) -> None:
        """Whose turn it is begins, the others are told their places."""
        while (asked := self._line.next()) is not None:
            future = asyncio.get_running_loop().run_in_executor(self._drivers, self._drive, asked)
            future.add_done_callback(partial(self._finish, asked))
        for place, asked in enumerate(self._line, start=1):
            asked.tell({"seq": asked.view[0], "state": "queued", "place": place})

    def _finish(self, asked: Asked, driven: asyncio.Future[None]) -> None:
        del driven
        self._look_back(asked)
        self._line.leave(asked.client)
        self._call()

    @computing("study")
    def _drive(self, asked: Asked) -> None:
        """In a thread: take one part after the other until it is done or nobody wants it any more."""
        try:
            begun, next_at = perf_counter(), STEP
            stream = asked.study.stream(self._executor)
            progress = None
            asked.post({"seq": asked.view[0], "state": "running", "done": 0, "of": 1, "seconds": 0, "remaining": None})
            for progress in stream:
                if asked.stopped.is_set():
                    stream.close()  # type: ignore[attr-defined]
                    return
                now = perf_counter() - begun
                if progress.done < progress.of and now > 60 * self._minutes:
                    stream.close()  # type: ignore[attr-defined]
                    over = asked.shown(progress, now) | {"state": "over", "minutes": self._minutes}
                    asked.end(over, (progress, now))
                    return
                if progress.done < progress.of and now >= next_at:
                    asked.last = (progress, now)
                    asked.post(asked.shown(progress, now))
                    after = perf_counter() - begun
                    next_at = after + max(STEP, PACE * (after - now))
            if progress is not None:
                seconds = perf_counter() - begun
                message = asked.shown(progress, seconds)
                asked.loop.call_soon_threadsafe(self._remember, asked.study, progress)
                asked.end(message)
        except InputError as error:
            asked.end(refused(error))
        except (Exception, asyncio.CancelledError):  # noqa: BLE001 - whatever it was, the page must hear of it
            if not self._ended:
                _LOG.exception("A study failed")
            asked.end({"state": "failed"})


def _is_too_much(kept: Mapping[Any, Progress[Any]]) -> bool:
    return len(kept) > REMEMBERED or sum(map(_scores, kept.values())) > REMEMBERED_SCORES


def _scores(progress: Progress[Any]) -> int:
    """How many scores an outcome holds: one that shows some of them holds all."""
    scores: Any = getattr(progress.outcome, "scores", None)
    base = getattr(scores, "base", None)
    return int(getattr(scores if base is None else base, "size", 0))


def _unreadable(problem: Mapping[str, str]) -> bytes:
    return orjson.dumps({"problem": problem})


class _Page:
    """One page's socket: the newest question counts, and the newest answer is sent."""

    def __init__(self, studies: Studies, begin: Begin) -> None:
        self._studies = studies
        self._begin = begin
        self._asked: Asked | None = None
        self._left: Asked | None = None
        self._message: dict[str, Any] | None = None
        self._news = asyncio.Event()

    async def send(self, send_bytes: Callable[[bytes], Awaitable[None]]) -> None:
        """Send what there is to say, the newest alone where the page is slow, until it has gone."""
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                await self._news.wait()
                self._news.clear()
                message, self._message = self._message, None
                if message is not None:
                    await send_bytes(orjson.dumps(message, option=orjson.OPT_SERIALIZE_NUMPY))

    def _say(self, message: Mapping[str, Any]) -> None:
        self._message = dict(message)
        self._news.set()

    async def ask(self, question: StudyQuestion) -> None:
        """Answer a question: go on, begin, refuse or stop."""
        seq = question.seq
        if question.stop:
            self.stop()
            self._say({"seq": seq, "state": "stopped"})
            return
        try:
            study, content = await self._studies.work.run(self._begin, question)
            await (self._look if question.look else self._go_on)(seq, study, content)
        except InputError as error:
            self.stop()
            self._say({"seq": seq, **refused(error)})
        except NoAnswerError:
            self.stop()
            self._say({"seq": seq, "state": "waiting"})

    async def _go_on(self, seq: Any, study: Study, content: Content) -> None:
        """Show what runs or is known of a study, or have it run."""
        present = self._asked
        if present is not None and present.study == study:
            if not present.stopped.is_set() and await self._shown_anew(present, (seq, content)):
                return
            # It has ended, and what it came to is being remembered.
            await asyncio.sleep(0)
        self.stop()
        self._left = None
        known = self._studies.outcome(study)
        asked = Asked(study, (seq, content), self._say, asyncio.get_running_loop(), CLIENT.get())
        self._asked = asked
        if known is not None:
            asked.stopped.set()
            self._say(await self._studies.work.run(asked.shown, known, 0.0))
        else:
            self._studies.enter(asked)

    async def _shown_anew(self, present: Asked, view: tuple[Any, Content]) -> bool:
        """Show what runs in another view; whether it still ran then."""
        present.view = view
        last, message = present.last, None
        if last is not None:
            # Where nobody has time to show it, the next part is: the study goes on.
            with contextlib.suppress(NoAnswerError):
                message = await self._studies.work.run(present.shown, *last)
        if present.stopped.is_set():
            return False
        # What has come meanwhile is newer.
        if message is not None and present.last is last:
            self._say(message)
        return True

    async def _look(self, seq: Any, study: Study, content: Content) -> None:
        """What a study had come to when it was stopped, or had taken its time."""
        ended, message = self._left or self._asked, {"seq": seq, "state": "stopped"}
        if ended is not None and ended.stopped.is_set() and ended.study == study and ended.last is not None:
            ended.view = (seq, content)
            message = await self._studies.work.run(ended.shown, *ended.last) | message
        self._say(message)

    def stop(self) -> None:
        """What runs for this page is ended; how far it has come can be looked at until something else is asked."""
        if self._asked is not None:
            self._studies.leave(self._asked)
            self._left, self._asked = self._asked, None

    def leave(self) -> None:
        """The page has gone."""
        self.stop()
        if self._left is not None:
            self._studies.forget(self._left)
            self._left = None
