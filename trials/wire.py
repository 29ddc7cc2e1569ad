"""HTTP/1.1 as a browser speaks it, from an address of its own: what a few hundred users at a time can afford.

A client library costs as much as the server's answer; here a request is a write and a read.
"""

from __future__ import annotations

import asyncio
import gzip
from collections.abc import AsyncIterable, Mapping
from dataclasses import dataclass

import brotli
import zstandard

PATIENCE = 60.0
"""Seconds after which an answer no longer comes."""

LINE = 1 << 20
"""Bytes that are read ahead."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What a server answered: status, headers by their lower-case names, the body as it came."""

    status: int
    headers: Mapping[str, str]
    raw: bytes

    @property
    def body(self) -> bytes:
        """The body, unpacked.

        Raises:
            ValueError: where it is packed in a way that was not asked for.
        """
        match self.headers.get("content-encoding", ""):
            case "":
                return self.raw
            case "gzip":
                return gzip.decompress(self.raw)
            case "br":
                return bytes(brotli.decompress(self.raw))
            case "zstd":
                return zstandard.ZstdDecompressor().decompressobj().decompress(self.raw)
            case other:
                raise ValueError(f"packed by {other}")


class Client:
    """One connection that is kept open, and opened again where the server has closed it.

    Args:
        port: of the server.
        address: of this end, in 127.0.0.0/8.
    """

    def __init__(self, port: int, address: str = "127.0.0.1") -> None:
        self.port, self.address = port, address
        self.origin = f"http://127.0.0.1:{port}"
        self._reader: asyncio.StreamReader | None = None
        self._writer: asyncio.StreamWriter | None = None

    async def ask(
        self,
        method: str,
        path: str,
        body: bytes | AsyncIterable[bytes] | None = None,
        headers: Mapping[str, str] | None = None,
        patience: float = PATIENCE,
    ) -> Answer:
        """The answer to a request.

        Args:
            method: of it.
            path: with its query.
            body: all of it with its length, or in pieces without.
            headers: more of them, or others in the place of the usual ones.
            patience: seconds after which no answer is one.

        Raises:
            OSError, EOFError: where there is no answer, or not all of it.
            TimeoutError: where it takes too long.
        """
        async with asyncio.timeout(patience):
            head = self._head(method, path, body, headers or {})
            if self._writer is not None:
                try:
                    return await self._exchange(method, head, body)
                except (OSError, asyncio.IncompleteReadError) as error:
                    # The server closes what is idle for long; a browser then asks again.
                    if getattr(error, "partial", b"") or not isinstance(body, bytes | None):
                        raise
            await self._open()
            return await self._exchange(method, head, body)

    def _head(
        self, method: str, path: str, body: bytes | AsyncIterable[bytes] | None, more: Mapping[str, str]
    ) -> bytes:
        headers = {
            "Host": f"127.0.0.1:{self.port}", "Connection": "keep-alive", "Accept": "*/*",
            "Accept-Encoding": "gzip, deflate, br, zstd",
        }  # fmt: skip
        if method != "GET":
            headers["Origin"] = self.origin
        if isinstance(body, bytes):
            headers["Content-Length"] = str(len(body))
        elif body is not None:
            headers["Transfer-Encoding"] = "chunked"
        lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in (headers | dict(more)).items())]
        return "\r\n".join([*lines, "", ""]).encode()

    async def _open(self) -> None:
        await self.close()
        self._reader, self._writer = await asyncio.open_connection(
            "127.0.0.1", self.port, local_addr=(self.address, 0), limit=LINE
        )

    async def _exchange(self, method: str, head: bytes, body: bytes | AsyncIterable[bytes] | None) -> Answer:
        assert self._reader is not None
        assert self._writer is not None
        try:
            sent = True
            if isinstance(body, bytes | None):
                self._writer.write(head + (body or b""))
            else:
                self._writer.write(head)
                sent = await self._send(self._writer, body)
            answer = await _read(self._reader, method)
        except BaseException:
            await self.close()
            raise
        if not sent or answer.headers.get("connection", "").lower() == "close":
            await self.close()
        return answer

    async def _send(self, writer: asyncio.StreamWriter, pieces: AsyncIterable[bytes]) -> bool:
        """Send pieces; whether all of them went: a server that has heard enough stops listening."""
        try:
            async for piece in pieces:
                writer.write(b"%x\r\n%b\r\n" % (len(piece), piece))
                await writer.drain()
            writer.write(b"0\r\n\r\n")
        except ConnectionError:
            return False
        return True

    async def close(self) -> None:
        """Hang up."""
        writer, self._reader, self._writer = self._writer, None, None
        if writer is not None:
            writer.close()


async def _read(reader: asyncio.StreamReader, method: str) -> Answer:
    first, *lines = (await reader.readuntil(b"\r\n\r\n"))[:-4].decode("latin-1").split("\r\n")
    status = int(first.split(" ", 2)[1])
    headers = {}
    for line in lines:
        name, _, value = line.partition(":")
        headers[name.strip().lower()] = value.strip()
    if method == "HEAD" or status in (204, 304):
        return Answer(status, headers, b"")
    if headers.get("transfer-encoding", "").lower() == "chunked":
        return Answer(status, headers, await _chunks(reader))
    if "content-length" in headers:
        return Answer(status, headers, await reader.readexactly(int(headers["content-length"])))
    return Answer(status, headers, await reader.read())


async def _chunks(reader: asyncio.StreamReader) -> bytes:
    pieces = []
    while size := int(await reader.readuntil(b"\r\n"), 16):
        pieces.append(await reader.readexactly(size))
        await reader.readexactly(2)
    await reader.readexactly(2)
    return b"".join(pieces)
