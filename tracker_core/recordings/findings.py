"""What was found in a file and what was done about it: every kind counted, the first of each listed by line."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice
from types import MappingProxyType

from tracker_core.recordings.bounds import MOST_LISTED, clip


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of finding.

    Attributes:
        title: for labels.
        sentence: what it is, plainly.
        done: what is done with it.
    """

    title: str
    sentence: str
    done: str


KINDS = MappingProxyType(
    {
        "encoding": Kind(
            "Not UTF-8",
            "The bytes of the file are not those of UTF-8 text.",
            "It is read as Latin-1; letters outside ASCII may come out wrong, numbers do not.",
        ),
        "quote": Kind(
            "Quotation mark not closed",
            "A cell opens with a quotation mark that is not closed within twenty lines.",
            "The line is left out.",
        ),
        "lines": Kind(
            "Row over several lines",
            "A cell in quotation marks goes over the ends of lines.",
            "The lines are read as one row.",
        ),
        "before": Kind("Before the names", "The row stands before the one that holds the names.", "It is left out."),
        "short": Kind(
            "Row too short",
            "The row ends before the last column that is read.",
            "The cells it lacks are taken as empty.",
        ),
        "time": Kind("No time", "The time is missing, or not of the form that is read.", "The row is left out."),
        "position": Kind(
            "Not a number", "A position is not a number.", "The measurement is missing: the filter predicts over it."
        ),
        "empty": Kind("Empty", "A position is empty.", "The measurement is missing: the filter predicts over it."),
        "beyond": Kind(
            "Out of range",
            "A position lies outside what can be: over 1,000,000 km, a latitude over 90°, a longitude over 360°, a "
            "negative range, an infinite number, or latitude 0 and longitude 0 far from all others.",
            "The measurement is missing: the filter predicts over it.",
        ),
        "order": Kind(
            "Out of order", "The time is earlier than that of a row before.", "The row is moved to its place in time."
        ),
        "duplicate": Kind(
            "Same time twice",
            "Another row has the same time.",
            "The first that holds a position stays, the others are left out.",
        ),
        "held": Kind(
            "Held position",
            "Every axis is exactly as at the measurement before, though time went on: the sensor repeats itself.",
            "The measurement is missing, or kept as it is, as the reading says.",
        ),
        "gap": Kind(
            "Gap",
            "The time since the row before is over one and a half times the usual interval.",
            "Where the interval is constant, samples without a measurement are put in; else the interval is used as "
            "it is.",
        ),
        "truth": Kind("No truth", "A true position is not a number, or out of range.", "It is taken as unknown."),
    }
)
"""Kinds of findings, in the order in which they are met."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing found in a file.

    Attributes:
        kind: a name in KINDS.
        line: of the file, from 1; 0 for the file as a whole.
        text: the reason with the value received, as text and never interpreted.
    """

    kind: str
    line: int
    text: str


class Ledger:
    """Counts findings and keeps the first of each kind."""

    def __init__(self) -> None:
        self._counts = dict.fromkeys(KINDS, 0)
        self._kept: dict[str, list[Finding]] = {kind: [] for kind in KINDS}

    def add(self, kind: str, line: int, text: str) -> None:
        """Note one finding."""
        self._counts[kind] += 1
        if len(self._kept[kind]) < MOST_LISTED:
            self._kept[kind].append(Finding(kind, line, clip(text)))

    def add_all(self, kind: str, count: int, found: Iterable[tuple[int, str]]) -> None:
        """Note `count` findings, of which `found` gives line and text lazily: only as many are taken as are kept."""
        room = MOST_LISTED - len(self._kept[kind])
        self._counts[kind] += count
        self._kept[kind].extend(Finding(kind, line, clip(text)) for line, text in islice(found, room))

    @property
    def counts(self) -> dict[str, int]:
        """How many of each kind, those that were found only."""
        return {kind: count for kind, count in self._counts.items() if count}

    def listed(self) -> tuple[Finding, ...]:
        """At most MOST_LISTED findings by line; of more, the rarer kinds are listed whole before others."""
        chosen: list[Finding] = []
        by_size = sorted((kept for kept in self._kept.values() if kept), key=len)
        for index, kept in enumerate(by_size):
            chosen += kept[: (MOST_LISTED - len(chosen)) // (len(by_size) - index)]
        return tuple(sorted(chosen, key=lambda finding: finding.line))
