"""The files that people have given to this server, on disk: known by their content, whole or not there at all.

A set is one file in the store's folder: a line of JSON with its name, then the bytes as they came. It is written beside
its place, forced to the disk, and put there in one step, so that a server that is killed leaves either the set or a
part that the next one removes. Several servers may share a folder: they never write to the same file, and whatever one
of them removes is missing for the others as if it had been too old.
"""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import NamedTemporaryFile

from layouts.incoming import MEGABYTE, Incoming
from tracker_core.checks import InputError
from tracker_core.measured import DATA, File, clean_name, content_name

HOUR = 3600.0
DAY = 24 * HOUR

RECENT = HOUR
"""Seconds for which a set that was used makes room for no other."""

TOUCHED = HOUR / 4
"""Seconds within which a second use is not noted."""

LEFT_OVER = HOUR
"""Seconds after which a part that nobody has finished is nobody's."""

SUFFIX, PART = ".recording", ".part"


class NoRoomError(InputError):
    """The store is full of sets that are in use."""


@dataclass(frozen=True, slots=True)
class _Kept:
    """A set in the folder: where, its bytes, when it was used last."""

    path: Path
    size: int
    used: float


class Store:
    """Files in a folder, within a size and an age.

    Args:
        directory: the folder; made where it is not there.
        most_bytes: of all sets together.
        longest_age_days: days for which a set is kept that nobody uses.

    Attributes:
        directory: the folder.
        problem: why nothing can be kept there; empty where it can.
        most_bytes: of all sets together.
        days: for which a set is kept that nobody uses.
    """

    def __init__(self, directory: Path, *, most_bytes: int, longest_age_days: float) -> None:
        self.directory = directory
        self.most_bytes = most_bytes
        self.days = longest_age_days
        self.problem = self._prepare()
        if not self.problem:
            self._remove_left_over()
            self._remove_old()

    def _prepare(self) -> str:
        """Make the folder and write to it: nothing else tells whether that works."""
        try:
            self.directory.mkdir(mode=0o700, parents=True, exist_ok=True)
            with NamedTemporaryFile(suffix=PART, dir=self.directory):
                pass
        except OSError as error:
            return error.strerror or type(error).__name__
        return ""

    @contextlib.contextmanager
    def receive(self, name: str, most: int) -> Iterator[Incoming]:
        """A file on its way in. Unless it is kept before the end, nothing of it stays.

        Args:
            name: what it is called.
            most: bytes that it may have.

        Raises:
            OSError: where the folder cannot be written to.
        """
        head = json.dumps({"name": clean_name(name)}).encode() + b"\n"
        with NamedTemporaryFile(suffix=PART, dir=self.directory, delete=False) as stream:
            try:
                yield Incoming(stream, most, head)
            finally:
                Path(stream.name).unlink(missing_ok=True)

    def keep(self, incoming: Incoming) -> File:
        """Put a file that has come in whole in its place; once this returns it outlives the machine's loss of power.

        A file that is there already keeps the name it has.

        Raises:
            NoRoomError: where it would be too much, and everything else has been used lately.
            OSError: where the folder cannot be written to.
        """
        known = self.fetch(incoming.data)
        if known is not None:
            return known
        self._make_room(incoming.size)
        os.fsync(incoming.stream.fileno())
        Path(incoming.stream.name).replace(self._path(incoming.data))
        self._sync_directory()
        kept = self.fetch(incoming.data)
        if kept is None:
            raise OSError("the file was not there after it had been written")
        return kept

    def fetch(self, data: str) -> File | None:
        """The file that is known by this; None where it is not there, or no longer what it was."""
        if self.problem or not DATA.fullmatch(data):
            return None
        path = self._path(data)
        try:
            with path.open("rb") as stream:
                # As long as it is open, nothing else gets its number.
                seen = os.fstat(stream.fileno())
                name, content = _name(stream.readline()), stream.read()
                if name is None or content_name(content) != data:
                    self._remove(path, seen)
                    return None
        except OSError:
            return None
        self._touch(path, seen.st_mtime)
        return File(name, content)

    def size(self) -> int:
        """Bytes of all sets together."""
        return 0 if self.problem else sum(item.size for item in self._kept())

    def _path(self, data: str) -> Path:
        return self.directory / f"{data}{SUFFIX}"

    def _touch(self, path: Path, used: float) -> None:
        if time.time() - used > TOUCHED:
            # It may have been removed since, or belong to somebody else.
            with contextlib.suppress(OSError):
                os.utime(path)

    def _remove(self, path: Path, seen: os.stat_result | None = None) -> None:
        """Remove a set, unless another has been put in the place of the one that was seen."""
        with contextlib.suppress(OSError):
            if seen is None or path.stat().st_ino == seen.st_ino:
                path.unlink()

    def _kept(self) -> list[_Kept]:
        """The sets, the longest unused first."""
        kept = []
        for path in self.directory.glob(f"*{SUFFIX}"):
            # Another server may have removed it.
            with contextlib.suppress(OSError):
                found = path.stat()
                kept.append(_Kept(path, found.st_size, found.st_mtime))
        return sorted(kept, key=lambda item: item.used)

    def _remove_left_over(self) -> None:
        for path in self.directory.glob(f"*{PART}"):
            with contextlib.suppress(OSError):
                if time.time() - path.stat().st_mtime > LEFT_OVER:
                    path.unlink()

    def _remove_old(self) -> None:
        for kept in self._kept():
            if time.time() - kept.used > self.days * DAY:
                self._remove(kept.path)

    def _make_room(self, size: int) -> None:
        self._remove_old()
        kept = self._kept()
        spare = self.most_bytes - size - sum(item.size for item in kept)
        going = []
        for item in kept:
            if spare >= 0:
                break
            # A use within TOUCHED of the one before is not noted.
            if time.time() - item.used > RECENT + TOUCHED:
                going.append(item)
                spare += item.size
        if spare < 0:
            rule = (
                f"must fit beside the recordings in use: this server keeps {self.most_bytes / MEGABYTE:g} MB; keep it "
                "in this browser only, or try again in an hour"
            )
            raise NoRoomError("file", rule, f"{size / MEGABYTE:.1f} MB")
        for item in going:
            self._remove(item.path)

    def _sync_directory(self) -> None:
        # Where folders cannot be opened, their entries need no such thing.
        if os.name == "posix":
            handle = os.open(self.directory, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


def _name(head: bytes) -> str | None:
    """The name in the first line of a set; None where that is none."""
    try:
        name = json.loads(head)["name"]
    except (ValueError, TypeError, LookupError, RecursionError):
        return None
    return name if isinstance(name, str) and clean_name(name) == name else None
