"""Measured data as targets: files, known by their content, and the scenario that each is read as."""

from __future__ import annotations

import hashlib
import re
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import floor, inf, log10

import numpy as np

from tracker_core.checks import InputError
from tracker_core.identification import measured_std
from tracker_core.recordings import Look, Reading, Recorded, look, read, tracks
from tracker_core.scenarios import Recording, Scenario
from tracker_core.types import Measurements

RECORDING = "recording"
"""The scenario of an experiment whose target was measured."""

AXES = ("x", "y", "z", "east", "north", "up")
"""What axes of recordings are called."""

DATA = re.compile(r"[0-9a-f]{32}")
"""What the field `data` of an experiment looks like: see `content_name`."""

NAME_LENGTH = 80

SHELF_BYTES = 64_000_000

FILE_BYTES = 1_000
"""That a file takes beside its content."""


@dataclass(frozen=True, slots=True)
class File:
    """A file of measured data.

    Attributes:
        name: what it was called where it came from; any characters that can be seen, at most NAME_LENGTH.
        content: its bytes.
    """

    name: str
    content: bytes

    @property
    def data(self) -> str:
        """What it is known by."""
        return content_name(self.content)


Source = Callable[[str], File | None]
"""From what a file is known by to the file; None where it is not there."""


def content_name(content: bytes) -> str:
    """What a file is known by: the first 128 bits of the SHA-256 of its content, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()[:32]


def clean_name(name: str) -> str:
    """The name of a file without its folders, in one line of characters that can be seen."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    seen = "".join(part for part in last if part.isprintable() or part.isspace())
    return " ".join(seen.split())[:NAME_LENGTH].strip() or "recording"


class Shelf:
    """Files in memory; those that nobody has asked for longest make room.

    Args:
        most: bytes of all together, with FILE_BYTES more for each.

    Attributes:
        lifetime: seconds after which a file is let go that nobody asks for; for ever, unless somebody sets it.
    """

    def __init__(self, most: int = SHELF_BYTES) -> None:
        self.lifetime = inf
        self._most = most
        self._files: OrderedDict[str, tuple[float, File]] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def keep(self, file: File) -> str:
        """Put a file there; what it is known by."""
        data = file.data
        with self._lock:
            if data in self._files:
                self._let_go(data)
            self._files[data] = time.monotonic(), file
            self._bytes += len(file.content) + FILE_BYTES
            self._forget()
        return data

    def fetch(self, data: str) -> File | None:
        """The file, if it is there."""
        with self._lock:
            self._forget()
            if data not in self._files:
                return None
            _, file = self._files.pop(data)
            self._files[data] = time.monotonic(), file
            return file

    def _forget(self) -> None:
        """Let go of what is too much, or has not been asked for."""
        since = time.monotonic() - self.lifetime
        while self._files:
            oldest, (asked, _) = next(iter(self._files.items()))
            if asked >= since and (self._bytes <= self._most or len(self._files) == 1):
                return
            self._let_go(oldest)

    def _let_go(self, data: str) -> None:
        _, file = self._files.pop(data)
        self._bytes -= len(file.content) + FILE_BYTES


SHELF = Shelf()
"""Where files are that were given to this process, and to it alone."""

_sources: list[Source] = [SHELF.fetch]


def look_in(source: Source) -> None:
    """Look for files there too.

    What is found follows from the content it is known by: where it comes from makes no difference.
    """
    if source not in _sources:
        _sources.append(source)


def fetch(data: str) -> File:
    """The file that is known by this.

    Raises:
        InputError: where it is nowhere.
    """
    if DATA.fullmatch(data):
        for source in _sources:
            file = source(data)
            if file is not None:
                return file
        raise InputError("data", "is not kept here, or no longer: load the file again", data)
    raise InputError("data", "must be 32 hexadecimal digits, which a file is known by", data)


def parcel(data: str | None) -> File | None:
    """The file that work on an experiment takes along to where it may not be: see `deliver`; None for no file.

    Raises:
        InputError: as `fetch`.
    """
    return None if data is None else fetch(data)


def deliver(data: str | None, file: File | None) -> None:
    """Put a file that was taken along on the shelf of this process, unless it is there.

    Args:
        data: what it is known by.
        file: what `parcel` has given for that.
    """
    if data is not None and file is not None and SHELF.fetch(data) is None:
        SHELF.keep(file)


def known(data: str) -> bool:
    """Whether the file that is known by this is here."""
    try:
        fetch(data)
    except InputError:
        return False
    return True


_UNFIT = "must fit the file: "


def _fault(error: InputError) -> str:
    """What is wrong, once: the part of a file or of a reading, and its rule."""
    if error.field == "reading":
        return error.rule.removeprefix(_UNFIT)
    return error.rule if error.field == "file" else f"{error.field} {error.rule}"


@lru_cache(maxsize=32)
def looked(data: str) -> Look:
    """What a file seems to be, and the reading that is proposed for it.

    Raises:
        InputError: naming the field `data`, for a file that is nowhere, or is no table.
    """
    content = fetch(data).content
    try:
        return look(content)
    except InputError as error:
        raise InputError("data", f"must be a table of measurements: {_fault(error)}", error.received) from error


@lru_cache(maxsize=32)
def proposed(data: str) -> str:
    """How a file is read if nobody says otherwise, as the text of a `Reading`.

    Raises:
        InputError: naming the field `data`, for a file that is nowhere, or holds no measurements.
    """
    reading = written(looked(data).reading)
    try:
        recorded(data, reading)
    except InputError as error:
        raise InputError("data", f"must be a table of measurements: {_fault(error)}", error.received) from error
    return reading


def written(reading: Reading) -> str:
    """The text of a reading, which is never empty: an address forgets what is."""
    return reading.text() or "time:1"


@lru_cache(maxsize=6)
def recorded(data: str, reading: str) -> Recorded:
    """What a file says, read like this.

    Raises:
        InputError: naming the field `data` for a file that is nowhere, `reading` for one that cannot be read like this.
    """
    content = fetch(data).content
    try:
        return read(content, Reading.from_text(reading))
    except InputError as error:
        raise InputError("reading", f"{_UNFIT}{_fault(error)}", error.received) from error


@lru_cache(maxsize=8)
def tracks_in(data: str, reading: str, column: int) -> tuple[tuple[str, int], ...]:
    """The ids in a column of a file with their rows, most rows first.

    Raises:
        InputError: naming the field `data` for a file that is nowhere, `reading` for one that cannot be read like this.
    """
    content = fetch(data).content
    try:
        return tracks(content, Reading.from_text(reading), column)
    except InputError as error:
        raise InputError("reading", f"{_UNFIT}{_fault(error)}", error.received) from error


@lru_cache(maxsize=6)
def target(data: str, reading: str) -> Scenario:
    """The scenario that a file is, read like this.

    Raises:
        InputError: as `recorded`.
    """
    found = recorded(data, reading)
    for array in (found.positions, found.times, found.truth):
        if array is not None:
            array.setflags(write=False)
    name = clean_name(fetch(data).name)
    measured = Measurements(found.times, found.positions, found.interval)
    return Scenario(
        name=RECORDING,
        title=name,
        axes=found.axes,
        description=_description(found),
        source=f"Your recording, {name}",
        defaults={
            "samples": len(found.times),
            "interval": found.nominal,
            "noise": "recorded",
            "noise_level": "std",
            "noise_std": tuple(_rounded(std) for std in measured_std(measured)),
        },
        recording=Recording(
            found.positions, found.nominal, found.times if found.interval is None else None, found.truth
        ),
    )


def _description(found: Recorded) -> str:
    """How much there is of it, and how often it was measured."""
    missing = int(np.isnan(found.positions).any(axis=1).sum())
    every = f"every {found.nominal:.6g} s"
    if found.interval is None:
        every = f"at intervals that vary; {found.nominal:.6g} s is the middle one"
    gone = f"; {missing:,} missing or incomplete" if missing else ""
    return f"{len(found.times):,} samples over {found.times[-1]:,.6g} s, {every}{gone}."


def _rounded(value: float) -> float:
    """To three significant digits: no estimate has more."""
    return round(value, 2 - floor(log10(value))) if value > 0 else 0.0
