"""Files on their way in and out: what a browser sends is looked at before it is kept, and can be fetched again."""

from __future__ import annotations

import asyncio
import contextlib
import io
import math
import re
import time
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar, TypeVarTuple
from urllib.parse import quote

from fastapi import FastAPI, Request, Response
from fastapi.responses import JSONResponse
from prometheus_client import Counter
from starlette.requests import ClientDisconnect

from layouts.files import DAY, NoRoomError, Store, counted
from layouts.incoming import MEGABYTE, Incoming, too_large
from layouts.outgoing import Sent
from layouts.text import error_text
from server.clients import CLIENT
from server.limits import Buckets, Rate, share
from server.line import Door
from server.metrics import REFUSALS, REGISTRY, computing, watch
from server.problem import problem
from tracker_core.checks import InputError, check_choice
from tracker_core.measured import SHELF, File, clean_name, fetch, proposed
from tracker_core.recordings import look

WAY_IN = ("PUT", "/recordings")
"""Method and path of what bounds what it is sent, here and nowhere else."""

MOST_BYTES = 10 * MEGABYTE

A = TypeVarTuple("A")
T = TypeVar("T")

AT_ONCE, OUT_AT_ONCE = 16, 8
"""Files that may be on their way in, and out, half of them one client's: each may be in memory as a whole."""

WAITING = 200
"""Who may wait to send one, and to get one, half of them one client's: a whole class may do so at once."""

PATIENCE = 30.0
"""Seconds that anybody waits for that."""

LOOKED_AT, READ_AT = 2, 4
"""Files that are looked at at a time, and pieces of files that are read or written."""

LIFETIME = 15 * 60.0
"""Seconds after which memory lets go of a file that nobody asks for: a browser that keeps it sends it again."""

AGAIN = 5
"""Seconds after which to try again where nobody can say when there will be room."""

REASONS = {408: "slow", 413: "body", 429: "kept", 503: "busy", 507: "full"}
"""What a refusal is counted as, by its status."""

DEADLINE = 300.0
"""Seconds that a file may be on its way."""

DRAINED = 8
"""So many times the bound is still read of what is too much, so that who sends it hears why it is refused."""

SEEN_AFTER = 60.0
"""Seconds after which a figure of what is kept is old."""

KEEP = ("store", "browser")

BYTES = "application/octet-stream"

POSITIONS = ("number", "pair")
"""Kinds of columns that a position may be read from."""

RECEIVED = Counter("gainscope_recordings_received_bytes", "Size of what was taken in.", registry=REGISTRY)

SHOWN = 5
"""Columns that are named where none will do."""


class Uploads:
    """Where files come in.

    Args:
        store: where they are kept; None to keep them in memory alone.
        most_bytes: of one file.
    """

    def __init__(self, store: Store | None = None, *, most_bytes: int = MOST_BYTES) -> None:
        self._store = store if store is not None and not store.problem else None
        self._problem = "it was told to keep nothing" if store is None else store.problem
        self._most = most_bytes
        self._looking = ThreadPoolExecutor(LOOKED_AT, thread_name_prefix="recordings")
        # Threads of their own: what else needs a thread does not wait for these.
        self._disk = ThreadPoolExecutor(READ_AT, thread_name_prefix="disk")
        self._in, self._out = Door(AT_ONCE, WAITING, PATIENCE), Door(OUT_AT_ONCE, WAITING, PATIENCE)
        watch("gainscope_recordings_coming", "Recordings that are on their way in.", lambda: self._in.inside)
        kept = self._store
        self._of_one = share(0 if kept is None else kept.most_bytes)
        self._given = Buckets(Rate(self._of_one / DAY, self._of_one))
        self._seen_at = time.monotonic()
        if kept is not None:
            watch("gainscope_recordings_kept_bytes", "Size of all recordings that are kept.", lambda: self._size(kept))

    def _size(self, kept: Store) -> int:
        """Of all that is kept, as far as it is known; what other servers do is found out by a thread."""
        if time.monotonic() - self._seen_at > SEEN_AFTER:
            self._seen_at = time.monotonic()
            self._disk.submit(kept.look)
        return kept.size

    def attach(self, server: FastAPI) -> None:
        """Serve the ways in and out.

        `PUT /recordings?name=...&keep=store|browser` takes the bytes of a file and answers `{data, name, bytes, kept}`;
        `GET /recordings` says what is kept and how much; `GET /recordings/{data}` gives a file back as it came.
        What is refused is answered as `problem` has it.
        """
        SHELF.lifetime = LIFETIME

        @server.get("/recordings")
        async def terms() -> JSONResponse:
            return JSONResponse(
                {"most_bytes": self._most, "problem": "" if self._store else self._problem}
                | ({} if self._store is None else {"days": self._store.days})
            )

        @server.put("/recordings")
        async def put(request: Request, name: str = "", keep: str = "store") -> Response:
            try:
                return await self._put(request, name, keep)
            except ClientDisconnect:
                return Response(status_code=400)

        @server.api_route("/recordings/{data}", methods=["GET", "HEAD"])
        async def get(data: str) -> Response:
            async with contextlib.AsyncExitStack() as ending:
                if not await ending.enter_async_context(self._out.passed()):
                    return _crowded("out", data)
                try:
                    file = await self._by_disk(fetch, data)
                except InputError as error:
                    return refusal(error, 404)
                stream, size, headers = io.BytesIO(file.content), len(file.content), attachment(file.name)
                return Sent(stream, size, self._disk, ending.pop_all(), headers=headers, media_type=BYTES)

    async def _by_disk(self, work: Callable[[*A], T], *arguments: *A) -> T:
        """What is given by work that may have to wait for the disk."""
        return await asyncio.get_running_loop().run_in_executor(self._disk, work, *arguments)

    async def _put(self, request: Request, name: str, keep: str) -> Response:
        async with self._in.passed() as there:
            if not there:
                return _crowded("in", name)
            try:
                async with asyncio.timeout(DEADLINE):
                    return await self._received(request, name, keep)
            except TimeoutError:
                return refusal(InputError("file", f"must come within {DEADLINE:g} s", name), 408)

    async def _received(self, request: Request, name: str, keep: str) -> Response:
        chunks = request.stream()
        try:
            wanted = self._store if check_choice("keep", keep, KEEP) == "store" else None
            self._check_length(request)
        except InputError as error:
            await self._drain(chunks)
            return refusal(error, 413 if error.field == "file" else 422)
        wait = 0.0 if wanted is None else self._given.wait(CLIENT.get(), time.monotonic())
        if wait:
            most = f"{self._of_one / MEGABYTE:g} MB a day"
            rule = f"must wait, or be kept in this browser only: of one address at most {most} are kept here"
            return refusal(InputError("file", rule, name), 429, wait)
        try:
            with self._place(wanted, name) as incoming:
                return await self._take_in(chunks, wanted, incoming, name)
        except OSError as error:
            # A disk that is full or gone.
            rule = "could not be written by this server; keep it in this browser only"
            return refusal(InputError("file", rule, error.strerror or type(error).__name__), 507)

    @contextlib.contextmanager
    def _place(self, store: Store | None, name: str) -> Iterator[Incoming]:
        if store is None:
            yield Incoming(io.BytesIO(), self._most)
        else:
            with store.receive(name, self._most) as incoming:
                yield incoming

    async def _take_in(
        self, chunks: AsyncIterator[bytes], store: Store | None, incoming: Incoming, name: str
    ) -> Response:
        try:
            async for chunk in chunks:
                await self._by_disk(incoming.write, chunk)
        except InputError as error:
            await self._drain(chunks)
            return refusal(error, 413)
        try:
            loop = asyncio.get_running_loop()
            file, is_new = await loop.run_in_executor(self._looking, self._keep, incoming, store, name)
        except NoRoomError as error:
            return refusal(error, 507)
        except InputError as error:
            return refusal(error, 422)
        kept = "memory" if store is None else "store"
        if is_new:
            self._given.draw(CLIENT.get(), time.monotonic(), counted(incoming.size))
        RECEIVED.inc(len(file.content))
        return JSONResponse({"data": file.data, "name": file.name, "bytes": len(file.content), "kept": kept})

    @computing("recording")
    def _keep(self, incoming: Incoming, store: Store | None, name: str) -> tuple[File, bool]:
        """Look at a file that has come, and keep it if it is a table; whether the store has it since then."""
        content = incoming.content()
        _check_table(content)
        is_new = store is not None and not store.has(incoming.data)
        if store is not None:
            file = store.keep(incoming)
        else:
            file = File(clean_name(name), content)
            SHELF.keep(file)
        # The page asks for it at once, and a large one takes seconds: here nobody waits for anything else.
        with contextlib.suppress(InputError):
            proposed(file.data)
        return file, is_new

    def _check_length(self, request: Request) -> None:
        length = request.headers.get("content-length", "")
        if length.isdecimal() and int(length) > self._most:
            raise too_large(self._most, int(length))

    async def _drain(self, chunks: AsyncIterator[bytes]) -> None:
        """Read on for a while: a browser that is still sending takes no answer."""
        read = 0
        async for chunk in chunks:
            read += len(chunk)
            if read > DRAINED * self._most:
                return


def _check_table(content: bytes) -> None:
    """Refuse what nobody could read positions from, however it is read.

    Raises:
        InputError: naming the bound that it passes, or what it lacks.
    """
    columns = look(content).columns
    if not any(column.kind in POSITIONS for column in columns):
        found = ", ".join(column.kind for column in columns[:SHOWN]) or "nothing"
        raise InputError("file", "must be a table with a column of numbers", found)


def _crowded(way: str, name: str) -> JSONResponse:
    return refusal(InputError("file", f"must wait: as many as may be are on their way {way}", name), 503)


def refusal(error: InputError, status: int, again: float = AGAIN) -> JSONResponse:
    """What is answered to what cannot be taken or given; where that is nobody's mistake, it is counted.

    Args:
        error: what is wrong with what.
        status: of HTTP.
        again: seconds after which to try again, where waiting helps.
    """
    headers = {"Connection": "close"} if status in (408, 413) else {}
    if status in (429, 503):
        headers["Retry-After"] = str(math.ceil(again))
    if status in REASONS:
        REFUSALS.labels(REASONS[status]).inc()
    return problem(error, status, error_text(error), headers)


def attachment(name: str) -> dict[str, str]:
    """Headers by which a browser saves what it gets under this name, and never shows it."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", name)
    return {
        "Content-Disposition": f"attachment; filename=\"{plain}\"; filename*=UTF-8''{quote(name, safe='')}",
        "X-Content-Type-Options": "nosniff",
        "Content-Security-Policy": "sandbox; default-src 'none'",
        "Cache-Control": "private, max-age=3600",
    }
