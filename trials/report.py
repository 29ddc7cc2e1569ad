"""What a trial found, and the table that says so."""

from __future__ import annotations

import os
import platform
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

SHOWN = 8
"""Kinds of faults that are shown."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the table.

    Attributes:
        what: was tried.
        measured: what came out.
        bound: what it must not pass; empty where it is only told.
        held: whether it did not.
        timed: whether that depends on how fast the machine is and on what else it does.
    """

    what: str
    measured: str
    bound: str = ""
    held: bool = True
    timed: bool = False


Trial = Callable[[bool], Iterator[Finding]]
"""From whether it is to be short to what it finds, one after the other."""


def none_of(what: str, faults: Mapping[str, int] | Iterable[str], of: str) -> Finding:
    """That there were no faults; the most frequent are shown if there were.

    Args:
        what: was tried.
        faults: each in words, or how often each came.
        of: how many there could have been, in words.
    """
    counted = Counter(faults)
    shown = "".join(f"; {times} times {fault[:200]}" for fault, times in counted.most_common(SHOWN))
    return Finding(what, f"{counted.total()} in {of}{shown}", "none", not counted)


def at_most(what: str, value: float, bound: float, unit: str, *, timed: bool = False, more: str = "") -> Finding:
    """That a number does not pass a bound."""
    measured = f"{value:.3g} {unit}{', ' + more if more else ''}"
    return Finding(what, measured, f"at most {bound:g} {unit}", value <= bound, timed)


def percentiles(seconds: Iterable[float]) -> tuple[float, float, float]:
    """Median, 95th percentile and longest of durations, ms; NaN of none."""
    found = np.fromiter(seconds, float) * 1e3
    if not found.size:
        return (float("nan"),) * 3
    middle, high = np.percentile(found, [50, 95])
    return float(middle), float(high), float(found.max())


def row(trial: str, finding: Finding) -> str:
    """A line of the table."""
    verdict = "" if not finding.bound else "held" if finding.held else "BROKEN"
    return f"{trial:<8} {finding.what:<46} {finding.measured:<58} {finding.bound:<22} {verdict}".rstrip()


def machine() -> str:
    """Cores that this process may use, and the load before anything was tried."""
    loads = " ".join(f"{load:.1f}" for load in os.getloadavg())
    return (
        f"{len(os.sched_getaffinity(0))} cores, load {loads}, {platform.machine()}, Python {platform.python_version()}"
    )
