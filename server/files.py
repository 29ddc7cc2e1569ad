"""Files that do not change while the server runs: each made ready once, named by its content, kept by browsers.

A fixed table of addresses is served and nothing else: no address is ever looked up on the disk. What is published
under an address with the digest of its content is kept for a year without asking; under any other address the
browser asks each time and is mostly told that it has it already.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import os
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fastapi.responses import Response
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from server.codings import COMPRESSED, Coding, Effort, preferred, write
from server.problem import problem
from server.routes import Served
from tracker_core.checks import InputError

IMMUTABLE = "public, max-age=31536000, immutable"
ASK = "no-cache"

PUBLISHED = "/static/"
"""Where files are published by their content."""

MEDIA = {
    ".css": "text/css; charset=utf-8",
    ".csv": "text/csv; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".svg": "image/svg+xml",
}
"""Types by the end of the name; anything else is bytes."""


@dataclass(frozen=True, slots=True)
class File:
    """One address.

    Attributes:
        content: bytes, or where they are read when they are first asked for.
        digest: of the content.
        media: type of the content.
        keep: what the browser is told of keeping it.
        headers: more of them.
        route: what requests for it are counted by.
    """

    content: bytes | Path
    digest: str
    media: str
    keep: str
    headers: Mapping[str, str] = field(default_factory=dict)
    route: str = f"{PUBLISHED}{{file}}"

    def read(self) -> bytes:
        """The content."""
        return self.content if isinstance(self.content, bytes) else self.content.read_bytes()


class Files:
    """The table of addresses.

    Args:
        kept: folder in which compressed contents are kept by their digest; one that cannot be written is read alone;
            None for memory alone.
    """

    def __init__(self, kept: Path | None = None) -> None:
        self.kept = kept
        self._table: dict[str, File] = {}
        self._closed: tuple[str, ...] = (PUBLISHED,)
        self._bodies: dict[tuple[str, Coding], bytes] = {}
        self._making: dict[tuple[str, Coding], asyncio.Task[bytes]] = {}

    def add(
        self, address: str, content: bytes | Path, media: str = "", headers: Mapping[str, str] | None = None
    ) -> None:
        """Serve a content under an address that is not named by it.

        Args:
            address: from the root of this server.
            content: bytes, or the file with them.
            media: its type; by the address if left out.
            headers: more than every file has.
        """
        self._table[address] = File(
            content, _digest(content), media or _media(address), ASK, dict(headers or {}), address
        )

    def publish(self, folder: str, contents: Mapping[str, Path]) -> str:
        """Serve files under a folder that is named by what is in it, so that they find each other.

        Args:
            folder: its last part.
            contents: by their name in it.

        Returns:
            The address of the folder, with a slash at its end.
        """
        digests = {name: _digest(contents[name]) for name in sorted(contents)}
        whole = hashlib.sha256(repr(digests).encode()).hexdigest()[:16]
        address = f"{PUBLISHED}{whole}/{folder}/"
        for name, path in contents.items():
            self._table[address + name] = File(path, digests[name], _media(name), IMMUTABLE)
        return address

    def close(self, *prefixes: str) -> None:
        """Nothing begins with these but what is in the table."""
        self._closed += prefixes

    def addresses(self) -> Iterable[str]:
        """All that is served."""
        return self._table.keys()

    def prepare(self, kept: Path, effort: Effort = "best") -> int:
        """Compress everything into a folder, for servers that start later.

        Returns:
            Bytes of the folder.
        """
        kept.mkdir(parents=True, exist_ok=True)
        files = {file.digest: file for file in self._table.values()}
        total = 0
        for digest, file in files.items():
            for coding in COMPRESSED:
                place = kept / f"{digest}.{coding}"
                if not place.exists():
                    _put(place, write(file.read(), coding, effort))
                total += place.stat().st_size
        return total

    async def answer(self, scope: Scope) -> Response | None:
        """The answer to a request, None where it is not for a file."""
        path = scope["path"]
        file = self._table.get(path)
        if file is None:
            if path.startswith(self._closed):
                return problem(InputError("address", "must be that of a file", path), 404, "There is no such file.")
            return None
        scope["route"] = Served(file.route)
        if scope["method"] not in ("GET", "HEAD"):
            error = InputError("method", "must be GET or HEAD", scope["method"])
            return problem(error, 405, headers={"Allow": "GET, HEAD"})
        return await self.response(file, Headers(scope=scope))

    async def response(self, file: File, headers: Headers, status: int = 200) -> Response:
        """A file as a client reads it, or word that the client has it."""
        coding = preferred(headers.get("accept-encoding", ""))
        tag = f'"{file.digest}"' if coding == "identity" else f'"{file.digest}-{coding}"'
        about = {"Cache-Control": file.keep, "ETag": tag, "Vary": "Accept-Encoding", **file.headers}
        if status == 200 and _has(headers, tag):
            return Response(status_code=304, headers=about)
        body = await self._body(file, coding)
        if coding != "identity":
            about["Content-Encoding"] = coding
        return Response(body, status, {"Accept-Ranges": "none", **about}, file.media)

    def at(self, address: str) -> File:
        """What is served under an address.

        Raises:
            KeyError: where nothing is.
        """
        return self._table[address]

    async def _body(self, file: File, coding: Coding) -> bytes:
        key = file.digest, coding
        if key not in self._bodies:
            making = self._making.get(key)
            if making is None:
                # Whoever asks for it meanwhile waits for the same, without a thread of his own.
                making = self._making[key] = asyncio.create_task(asyncio.to_thread(self._make, file, coding))
                making.add_done_callback(lambda _: self._making.pop(key, None))
            self._bodies[key] = await asyncio.shield(making)
        return self._bodies[key]

    def _make(self, file: File, coding: Coding) -> bytes:
        if coding == "identity" or self.kept is None:
            return write(file.read(), coding, "thorough")
        place = self.kept / f"{file.digest}.{coding}"
        with contextlib.suppress(OSError):
            return place.read_bytes()
        body = write(file.read(), coding, "thorough")
        with contextlib.suppress(OSError):
            self.kept.mkdir(parents=True, exist_ok=True)
            _put(place, body)
        return body


class Serving:
    """Answers requests for files before anything else sees them.

    Args:
        app: answers all other requests.
        files: what is served.
    """

    def __init__(self, app: ASGIApp, files: Files) -> None:
        self.app = app
        self.files = files

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a file, or let the application answer."""
        answer = await self.files.answer(scope) if scope["type"] == "http" else None
        await (self.app if answer is None else answer)(scope, receive, send)


def _digest(content: bytes | Path) -> str:
    return hashlib.sha256(content if isinstance(content, bytes) else content.read_bytes()).hexdigest()[:32]


def _media(name: str) -> str:
    return MEDIA.get(Path(name).suffix, "application/octet-stream")


def _has(headers: Headers, tag: str) -> bool:
    """Whether the client has what the tag names; a proxy that touched it may have called the tag weak."""
    tags = [held.strip().removeprefix("W/") for held in headers.get("if-none-match", "").split(",")]
    return tag in tags or tags == ["*"]


def _put(place: Path, data: bytes) -> None:
    """Write a file whole or not at all."""
    handle, name = tempfile.mkstemp(dir=place.parent)
    try:
        with os.fdopen(handle, "wb") as part:
            part.write(data)
        Path(name).chmod(0o644)
        Path(name).replace(place)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise
