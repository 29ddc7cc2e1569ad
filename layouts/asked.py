"""One study that a page waits for, and what the page is told of it: how far it has come, and what it shows so far."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Any, Protocol

from layouts.text import error_text
from tracker_core import InputError
from tracker_core.tuning import Progress


class Study(Protocol):
    """What can be run: a hashable description."""

    def __hash__(self) -> int: ...

    def stream(self, executor: Executor | None = None) -> Iterator[Progress[Any]]:
        """The outcome as it grows; closing the iterator ends the work."""
        ...


Content = Callable[[Progress[Any]], Mapping[str, Any]]
"""What a page shows of how far a study has come, as plain values."""


@dataclass(eq=False, slots=True)
class Asked:
    """A study that a page waits for.

    Attributes:
        study: what is run.
        view: number of the question, and what the page shows of the study; a page that asks again about the study
            that runs for it looks at it in another way, another theme say.
        tell: sends to the page, from the server's loop.
        loop: that loop.
        client: whose page it is, as limits know it.
        stopped: set once nobody wants it any more, or it has ended.
        last: how far it had come when it was shown last, and after how many seconds; None once all of it is there, or
            there was no room for it any more.
        is_forgotten: whether its page has gone, so that nobody will look back at it.
    """

    study: Study
    view: tuple[Any, Content]
    tell: Callable[[Mapping[str, Any]], None]
    loop: asyncio.AbstractEventLoop
    client: str
    stopped: threading.Event = field(default_factory=threading.Event)
    last: tuple[Progress[Any], float] | None = None
    is_forgotten: bool = False

    def post(self, message: Mapping[str, Any]) -> None:
        """Send to the page, from a thread."""
        if not self.stopped.is_set():
            self.loop.call_soon_threadsafe(self.tell, message)

    def end(self, message: Mapping[str, Any], last: tuple[Progress[Any], float] | None = None) -> None:
        """Send the last word on it, from a thread: whoever asks again is told what is remembered, or begins anew."""
        if not self.stopped.is_set():
            self.stopped.set()
            self.last = last
            self.loop.call_soon_threadsafe(self._last_word, message)

    def _last_word(self, message: Mapping[str, Any]) -> None:
        seq = self.view[0]
        # A question that came while the answer to the one before was made is to be asked once more.
        late = message.get("seq", seq) != seq
        self.tell({"seq": seq, "state": "again"} if late else {"seq": seq, **message})

    def shown(self, progress: Progress[Any], seconds: float) -> dict[str, Any]:
        """How far it has come, as the page is told."""
        over = progress.done >= progress.of
        rate = progress.done / seconds if seconds else 0.0
        # Taken once: a question that comes meanwhile is answered with what belongs to it.
        seq, content = self.view
        return {
            "seq": seq,
            "state": "done" if over else "running",
            "done": progress.done,
            "of": progress.of,
            "seconds": seconds,
            "remaining": (progress.of - progress.done) / rate if rate else None,
            "content": content(progress),
        }


def refused(error: InputError) -> dict[str, Any]:
    """What a page is told of a study that cannot be run."""
    return {"state": "refused", "errors": {error.field: error_text(error)}}
