"""Measured data in: the bytes of a file and how it is read, to times and positions and all that was found."""

from tracker_core.recordings.findings import KINDS, Finding, Kind
from tracker_core.recordings.look import Column, Look, look, tracks
from tracker_core.recordings.read import read
from tracker_core.recordings.reading import DECIMALS, DELIMITERS, FRAMES, HELD, Reading
from tracker_core.recordings.recorded import Recorded

__all__ = [
    "DECIMALS",
    "DELIMITERS",
    "FRAMES",
    "HELD",
    "KINDS",
    "Column",
    "Finding",
    "Kind",
    "Look",
    "Reading",
    "Recorded",
    "look",
    "read",
    "tracks",
]
