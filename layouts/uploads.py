"""Files on their way in and out: what a browser sends is looked at before it is kept, and can be fetched again."""

from __future__ import annotations

import asyncio
import contextlib
import io
import re
from collections.abc import AsyncIterator, Iterator
from concurrent.futures import ThreadPoolExecutor
from urllib.parse import quote

from fastapi import FastAPI, Request, Response
from fastapi.responses import JSONResponse
from prometheus_client import Counter
from starlette.requests import ClientDisconnect

from layouts.files import NoRoomError, Store
from layouts.incoming import MEGABYTE, Incoming, too_large
from layouts.text import error_text
from server.metrics import REGISTRY, computing, watch
from server.problem import problem
from tracker_core.checks import InputError, check_choice
from tracker_core.measured import SHELF, File, clean_name, fetch, proposed
from tracker_core.recordings import look

WAY_IN = ("PUT", "/recordings")
"""Method and path of what bounds what it is sent, here and nowhere else."""

MOST_BYTES = 10 * MEGABYTE

AT_ONCE = 16
"""Files that may be on their way in."""

LOOKED_AT = 2
"""Files that are looked at at a time."""

DEADLINE = 300.0
"""Seconds that a file may be on its way."""

DRAINED = 8
"""So many times the bound is still read of what is too much, so that who sends it hears why it is refused."""

KEEP = ("store", "browser")

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
        self._coming = 0
        watch("gainscope_recordings_coming", "Recordings that are on their way in.", lambda: self._coming)
        kept = self._store
        if kept is not None:
            watch("gainscope_recordings_kept_bytes", "Size of all recordings that are kept.", kept.size)

    def attach(self, server: FastAPI) -> None:
        """Serve the ways in and out.

        `PUT /recordings?name=...&keep=store|browser` takes the bytes of a file and answers `{data, name, bytes, kept}`;
        `GET /recordings` says what is kept and how much; `GET /recordings/{data}` gives a file back as it came.
        What is refused is answered as `problem` has it.
        """

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
            try:
                file = await asyncio.to_thread(fetch, data)
            except InputError as error:
                return refusal(error, 404)
            return Response(file.content, headers=attachment(file.name), media_type="application/octet-stream")

    async def _put(self, request: Request, name: str, keep: str) -> Response:
        if self._coming >= AT_ONCE:
            return refusal(InputError("file", f"must wait: {AT_ONCE} files are on their way in", name), 503)
        self._coming += 1
        try:
            async with asyncio.timeout(DEADLINE):
                return await self._received(request, name, keep)
        except TimeoutError:
            return refusal(InputError("file", f"must come within {DEADLINE:g} s", name), 408)
        finally:
            self._coming -= 1

    async def _received(self, request: Request, name: str, keep: str) -> Response:
        chunks = request.stream()
        try:
            wanted = self._store if check_choice("keep", keep, KEEP) == "store" else None
            self._check_length(request)
        except InputError as error:
            await self._drain(chunks)
            return refusal(error, 413 if error.field == "file" else 422)
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
                await asyncio.to_thread(incoming.write, chunk)
        except InputError as error:
            await self._drain(chunks)
            return refusal(error, 413)
        try:
            loop = asyncio.get_running_loop()
            file = await loop.run_in_executor(self._looking, self._keep, incoming, store, name)
        except NoRoomError as error:
            return refusal(error, 507)
        except InputError as error:
            return refusal(error, 422)
        kept = "memory" if store is None else "store"
        RECEIVED.inc(len(file.content))
        return JSONResponse({"data": file.data, "name": file.name, "bytes": len(file.content), "kept": kept})

    @computing("recording")
    def _keep(self, incoming: Incoming, store: Store | None, name: str) -> File:
        """Look at a file that has come, and keep it if it is a table."""
        content = incoming.content()
        _check_table(content)
        if store is not None:
            file = store.keep(incoming)
        else:
            file = File(clean_name(name), content)
            SHELF.keep(file)
        # The page asks for it at once, and a large one takes seconds: here nobody waits for anything else.
        with contextlib.suppress(InputError):
            proposed(file.data)
        return file

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


def refusal(error: InputError, status: int) -> JSONResponse:
    """What is answered to what cannot be taken."""
    return problem(error, status, error_text(error), {"Connection": "close"} if status in (408, 413) else None)


def attachment(name: str) -> dict[str, str]:
    """Headers by which a browser saves what it gets under this name, and never shows it."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", name)
    return {
        "Content-Disposition": f"attachment; filename=\"{plain}\"; filename*=UTF-8''{quote(name, safe='')}",
        "X-Content-Type-Options": "nosniff",
        "Content-Security-Policy": "sandbox; default-src 'none'",
        "Cache-Control": "private, max-age=3600",
    }
