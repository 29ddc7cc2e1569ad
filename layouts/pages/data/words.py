"""What was found in a recording, in words and rows of tables."""

from __future__ import annotations

import numpy as np

from layouts.text import significant
from tracker_core import Result
from tracker_core.consistency import reject_probability
from tracker_core.recordings import KINDS, Recorded

LISTED = 200
"""Findings that the page lists; the rest is in the table that can be taken home."""

ASIDE = 0.001
"""Share of the interval from which on it is said how far stamps lie beside their samples."""

OFTEN, NEVER = 0.05, 1e-9
"""Shares of right measurements that are refused: told in percent beyond the first, not at all below the second."""


def found_text(found: Recorded) -> str:
    """How many rows were out of the ordinary, in a sentence."""
    count = sum(found.counts.values())
    if not count:
        return "Nothing out of the ordinary: every row that is read is a measurement."
    listed = len(found.findings)
    said = f"{count:,} things were found before anything ran; nothing is left out in silence."
    if count > listed:
        said += f" {listed:,} of them are listed, of every kind some."
    return said


def counts_rows(found: Recorded) -> list[list[str]]:
    """A row for every kind that was found: what, how often, what is done with it."""
    rows = []
    for name, count in found.counts.items():
        kind = KINDS[name]
        done = kind.done
        if name == "held":
            done = "Taken as missing." if found.reading.held == "missing" else "Kept as they are."
        rows.append([kind.title, f"{count:,}", done])
    return rows


def findings_rows(found: Recorded) -> list[list[str]]:
    """The first findings: line, kind, reason with what was received."""
    return [
        [f"{finding.line:,}" if finding.line else "file", KINDS[finding.kind].title, finding.text]
        for finding in found.findings[:LISTED]
    ]


def facts_rows(found: Recorded, result: Result) -> list[list[str]]:
    """What there is of the recording."""
    missing = int(np.isnan(found.positions).any(axis=1).sum())
    of = f", {found.others:,} of other tracks" if found.others else ""
    rows = [
        ["Rows", f"{found.rows:,}{of}"],
        ["Measurements", f"{found.measured:,} of {len(found.times):,} samples"
         + (f", {missing:,} missing or incomplete" if missing else "")],
        ["Duration", _duration(float(found.times[-1]))],
        ["Interval", _interval(found)],
        ["Axes", ", ".join(found.axes)],
    ]  # fmt: skip
    if result.experiment.samples < len(found.times):
        rows.append(["Used", f"the first {result.experiment.samples:,} samples"])
    if found.start:
        rows.append(["Begins", found.start])
    if found.place:
        latitude, longitude, altitude = found.place
        rows.append(["Origin", f"{latitude:.6f}°, {longitude:.6f}°, {altitude:.1f} m"])
    truth = "known: errors are told" if result.truth.known else "not known: innovations take its place"
    return [*rows, ["Truth", truth]]


def gate_text(result: Result) -> str:
    """How often the gate refuses what is right, in a sentence; empty without a gate."""
    if result.gate is None:
        return ""
    share = reject_probability(result.gate.width, len(result.scenario.axes))
    if share > OFTEN:
        said = f"{significant(100 * share, 2)} % of the right measurements"
    else:
        said = f"one right measurement in {float(f'{1 / share:.2g}'):,.0f}" if share > NEVER else "no right measurement"
    return f"Where errors are Gaussian with this σ, the gate refuses {said}."


def _interval(found: Recorded) -> str:
    even = found.regularity
    if found.interval is None:
        return (
            f"varies: shortest {_brief(even.shortest, 3)} s, median {_brief(even.nominal, 3)} s, longest "
            f"{_brief(even.longest, 3)} s; every filter uses the actual ones"
        )
    constant = f"constant, T = {_brief(found.interval, 6)} s"
    if not found.reading.time:
        return f"{constant}, assumed: no column is read as a time"
    gaps = found.counts.get("gap", 0)
    said = constant + (f", {gaps:,} gap{'s' if gaps > 1 else ''}" if gaps else "")
    if even.aside > ASIDE * found.interval:
        said += f"; stamps lie up to {_brief(even.aside, 2)} s beside it"
    return said


def _brief(value: float, digits: int) -> str:
    """A number to some significant digits, without zeros at the end of its fraction."""
    text = significant(value, digits)
    return text.rstrip("0").rstrip(".") if "." in text and "e" not in text else text


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{significant(seconds, 4)} s"
    hours, rest = divmod(round(seconds), 3600)
    minutes, left = divmod(rest, 60)
    clock = f"{hours:,} h {minutes} min" if hours else f"{minutes} min {left} s"
    return f"{clock} ({significant(seconds, 4)} s)"
