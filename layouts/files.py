"""The files that people have given to this server, on disk: known by their content, whole or not there at all.

A set is one file in the store's folder: a line of JSON with its name, then the bytes as they came. It is written beside
its place, forced to the disk, and put there in one step, so that a server that is killed leaves either the set or a
part that goes later. Several servers may share a folder: they never write to the same file, and whatever one of them
removes is missing for the others as if it had been too old. What is removed, and what is acknowledged because it is
there already, is seen to by one of them at a time.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import IO

from layouts.incoming import MEGABYTE, Incoming
from tracker_core.checks import InputError
from tracker_core.measured import DATA, File, clean_name, content_name

if sys.platform != "win32":
    import fcntl

HOUR = 3600.0
DAY = 24 * HOUR

RECENT = HOUR
"""Seconds for which a set that was used makes room for no other."""

TOUCHED = HOUR / 4
"""Seconds within which a second use is not noted."""

LEFT_OVER = HOUR
"""Seconds after which a part that nobody has finished is nobody's."""

COUNTED = 600.0
"""Seconds after which the sets are counted anew: somebody else may have put some there, or taken some away."""

UNIT = 65_536
"""Bytes that a set is counted in: a small one, too, takes blocks of the disk, and its time when all are counted."""

SUFFIX, PART = ".recording", ".part"

SUM = "sum.json"
"""Name of the file that says how much there is; whoever has it locked has the folder to himself."""

SUM_LENGTH = 100
"""Bytes of it, always the same: it is written in one piece, and a kill leaves the sum before or after."""


class NoRoomError(InputError):
    """The store is full of sets that are in use."""


def counted(size: int) -> int:
    """What a file of so many bytes is counted as, bytes."""
    return -(-size // UNIT) * UNIT


@dataclass(frozen=True, slots=True)
class _Kept:
    """A set in the folder, and how it was seen."""

    path: Path
    seen: os.stat_result


@dataclass(slots=True)
class _Sum:
    """How much there is.

    Attributes:
        size: of all sets, as they are counted, bytes.
        at: when they were counted, in seconds since 1970.
    """

    size: int = 0
    at: float = 0.0

    @property
    def is_old(self) -> bool:
        """Whether they are to be counted anew."""
        return abs(time.time() - self.at) > COUNTED

    @classmethod
    def read(cls, stream: IO[bytes]) -> _Sum:
        """What is in the file; an old one where there is none."""
        with contextlib.suppress(ValueError, TypeError, LookupError, RecursionError):
            said = json.loads(stream.read(SUM_LENGTH))
            return cls(int(said["size"]), float(said["at"]))
        return cls()

    def write(self, stream: IO[bytes]) -> None:
        """Put it into the file."""
        stream.seek(0)
        stream.write(json.dumps({"size": self.size, "at": self.at}).encode().ljust(SUM_LENGTH - 1) + b"\n")


class Store:
    """Files in a folder, within a size and an age.

    Args:
        directory: the folder; made where it is not there.
        most_bytes: of all sets together, as they are counted.
        longest_age_days: days for which a set is kept that nobody uses.

    Attributes:
        directory: the folder.
        problem: why nothing can be kept there; empty where it can.
        most_bytes: of all sets together.
        days: for which a set is kept that nobody uses.
        size: of all sets together when this server last had to do with them, as they are counted, bytes.
    """

    def __init__(self, directory: Path, *, most_bytes: int, longest_age_days: float) -> None:
        self.directory = directory
        self.most_bytes = most_bytes
        self.days = longest_age_days
        self.size = 0
        self._threads = threading.Lock()
        self.problem = self._prepare()

    def _prepare(self) -> str:
        """Make the folder, write to it and lock it: nothing else tells whether that works. Count what is there."""
        try:
            self.directory.mkdir(mode=0o700, parents=True, exist_ok=True)
            with NamedTemporaryFile(suffix=PART, dir=self.directory):
                pass
            with self._alone() as there:
                self._count(there)
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
        known = self._find(incoming.data)
        if known is None or not known[1]:
            part = incoming.stream
            os.fsync(part.fileno())
            self._place(Path(part.name), counted(os.fstat(part.fileno()).st_size), self._path(incoming.data))
            known = self._find(incoming.data)
        if known is None:
            raise OSError("the file was not there after it had been written")
        # Who put it there may not have come as far as this.
        self._sync_directory()
        return known[0]

    def fetch(self, data: str) -> File | None:
        """The file that is known by this; None where it is not there, or no longer what it was."""
        found = self._find(data)
        return None if found is None else found[0]

    def has(self, data: str) -> bool:
        """Whether there is a file that is known by this, whatever is in it."""
        return self._path(data).exists()

    def look(self) -> None:
        """See how much there is by now.

        Raises:
            OSError: where the folder cannot be written to.
        """
        with self._alone() as there:
            if there.is_old:
                self._count(there)

    def _path(self, data: str) -> Path:
        return self.directory / f"{data}{SUFFIX}"

    @contextlib.contextmanager
    def _alone(self) -> Iterator[_Sum]:
        """Alone in the folder, of all threads and all servers that share it; what is there is to be kept up to date.

        The system lets go of the lock of whoever is killed.

        Raises:
            OSError: where that cannot be had.
        """
        opened = os.open(self.directory / SUM, os.O_RDWR | os.O_CREAT, 0o600)
        # Where the system has no such lock, one server has a folder to itself.
        with self._threads, os.fdopen(opened, "r+b", buffering=0) as stream:
            if sys.platform != "win32":
                fcntl.flock(stream, fcntl.LOCK_EX)
            there = _Sum.read(stream)
            try:
                yield there
            finally:
                there.write(stream)
                self.size = there.size

    def _find(self, data: str) -> tuple[File, bool] | None:
        """The file that is known by this, and whether it stays for now; None where it is not there, or broken."""
        if self.problem or not DATA.fullmatch(data):
            return None
        path = self._path(data)
        try:
            with path.open("rb") as stream:
                # As long as it is open, nothing else gets its number.
                seen = os.fstat(stream.fileno())
                name, content = _name(stream.readline()), stream.read()
                if name is None or content_name(content) != data:
                    self._drop(path, seen)
                    return None
                return File(name, content), self._use(path, seen)
        except OSError:
            return None

    def _use(self, path: Path, seen: os.stat_result) -> bool:
        """Note that a set is used; whether it is there still, and makes room for no other."""
        if time.time() - seen.st_mtime <= TOUCHED:
            return True
        with contextlib.suppress(OSError), self._alone():
            # It may have been removed since.
            if path.stat().st_ino == seen.st_ino:
                os.utime(path)
                return True
        return False

    def _drop(self, path: Path, seen: os.stat_result) -> None:
        """Remove a set that is broken, unless another has been put in its place."""
        with contextlib.suppress(OSError), self._alone() as there:
            if path.stat().st_ino == seen.st_ino:
                path.unlink()
                there.size -= counted(seen.st_size)

    def _place(self, part: Path, size: int, path: Path) -> None:
        """Put a part in its place, where there is room, or can be made."""
        with self._alone() as there:
            self._make_room(size, there)
            before = 0
            with contextlib.suppress(FileNotFoundError):
                # Somebody else may have put it there meanwhile.
                before = counted(path.stat().st_size)
            part.replace(path)
            there.size += size - before

    def _count(self, there: _Sum) -> list[_Kept]:
        """Count the sets, the longest unused first; what is too old goes, and so do parts that are nobody's."""
        kept = []
        now, there.size = time.time(), 0
        for entry in self.directory.iterdir():
            # Somebody may have removed it by hand.
            with contextlib.suppress(OSError):
                if entry.suffix in (SUFFIX, PART):
                    seen = entry.stat()
                    longest = self.days * DAY if entry.suffix == SUFFIX else LEFT_OVER
                    if now - seen.st_mtime > longest:
                        entry.unlink()
                    elif entry.suffix == SUFFIX:
                        kept.append(_Kept(entry, seen))
                        there.size += counted(seen.st_size)
        there.at = now
        return sorted(kept, key=lambda each: each.seen.st_mtime)

    def _make_room(self, size: int, there: _Sum) -> None:
        """Remove what was used longest ago, where there is no room for so many bytes."""
        if there.size + size <= self.most_bytes and not there.is_old:
            return
        kept = self._count(there)
        spare = self.most_bytes - size - there.size
        going = []
        for each in kept:
            if spare >= 0:
                break
            # A use within TOUCHED of the one before is not noted.
            if time.time() - each.seen.st_mtime > RECENT + TOUCHED:
                going.append(each)
                spare += counted(each.seen.st_size)
        if spare >= 0:
            for each in going:
                self._make_go(each, there)
        if there.size + size > self.most_bytes:
            rule = (
                f"must fit beside the recordings in use: this server keeps {self.most_bytes / MEGABYTE:g} MB; keep it "
                "in this browser only, or try again in an hour"
            )
            raise NoRoomError("file", rule, f"{size / MEGABYTE:.1f} MB")

    def _make_go(self, each: _Kept, there: _Sum) -> None:
        """Remove a set, unless it has been used since it was seen: a server of an earlier version asks for no lock."""
        with contextlib.suppress(OSError):
            now = each.path.stat()
            if (now.st_ino, now.st_mtime_ns) == (each.seen.st_ino, each.seen.st_mtime_ns):
                each.path.unlink()
                there.size -= counted(now.st_size)

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
