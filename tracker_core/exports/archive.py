"""Everything that a run gives away, in one zip: the same run gives the same bytes."""

from __future__ import annotations

import sys
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from io import TextIOWrapper
from typing import IO, TextIO

from tracker_core.checks import InputError
from tracker_core.exports.code.sources import FILES, sources
from tracker_core.exports.code.template import harmless
from tracker_core.exports.code.tuned import tuned_filter
from tracker_core.exports.summary import run_summary, write_columns, write_json
from tracker_core.exports.track import track_columns, write_track
from tracker_core.run import Result

EARLIEST = (1980, 1, 1, 0, 0, 0)
"""The date of every file: a zip knows no earlier one."""

LEVEL = "compress_level" if sys.version_info >= (3, 13) else "_compresslevel"
"""Of a file in a zip how hard it is compressed, 1 to 9; public from Python 3.13 on."""


@dataclass(frozen=True, slots=True)
class Part:
    """One file.

    Attributes:
        name: its path in the archive, with forward slashes.
        content: its bytes, or what writes its text; a long one never stands in memory as a whole.
        sentence: what it is, for the README.
    """

    name: str
    content: bytes | Callable[[TextIO], None]
    sentence: str


def run_parts(result: Result, *, title: str = "", origin: str = "") -> list[Part]:
    """The files of a run: the track, its metrics, the experiment, the filter as code, and a README that lists them.

    Args:
        result: the run.
        title, origin: what the experiment is called and where it comes from; any text.

    Returns:
        The parts. A filter whose gains a method chooses as it runs cannot be exported: the README says so.
    """
    columns, summary, experiment = track_columns(result), run_summary(result), result.experiment.to_dict()
    # The zip does not hold the recording: whoever made it has it.
    recorded = " --data FILE, the recording" if result.scenario.measured else ""
    parts = [
        Part(
            "track.csv",
            partial(write_track, result),
            "The track, one row a sample; empty cells where nothing is known.",
        ),
        Part("track.json", partial(write_columns, columns), "The same by columns; null where nothing is known."),
        Part(
            "metrics.json", partial(write_json, summary), "Gains, stability and figures of merit, jointly and per axis."
        ),
        Part(
            "experiment.json",
            partial(write_json, experiment),
            f"What was run. To repeat it: python -m tracker_core run --experiment experiment.json{recorded}",
        ),
    ]
    note = ""
    try:
        tuned = tuned_filter(result, title=title, origin=origin)
    except InputError:
        note = "There is no code of the filter: its gains were chosen as it ran."
    else:
        parts += [_part(f"filter/{name}", text, FILES[name][1]) for name, text in sources(tuned).items()]
    heading = [harmless(line) for line in (title or result.scenario.title, origin, note) if line]
    return [*parts, _part("README.txt", _readme(heading, parts), "This list.")]


def write_archive(stream: IO[bytes], parts: Sequence[Part]) -> None:
    """Write parts as a zip, in the order of their names, without dates.

    Raises:
        InputError: for two parts of one name.
    """
    names = [part.name for part in parts]
    if len(set(names)) < len(names):
        raise InputError("parts", "must have a name each", sorted(names))
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for part in sorted(parts, key=lambda part: part.name):
            entry = zipfile.ZipInfo(part.name, EARLIEST)
            entry.compress_type = zipfile.ZIP_DEFLATED
            # A plain file that everybody may read, from whatever system it comes.
            entry.create_system, entry.external_attr = 3, 0o100644 << 16
            if isinstance(part.content, bytes):
                archive.writestr(entry, part.content)
                continue
            # Digits are hardly ever repeated: searching for what is takes four times as long to save a twentieth.
            setattr(entry, LEVEL, 1)
            with archive.open(entry, "w") as stored:
                text = TextIOWrapper(stored, "utf-8", "replace", newline="")
                part.content(text)
                text.detach()


def _part(name: str, text: str, sentence: str) -> Part:
    return Part(name, text.encode("utf-8", "replace"), sentence)


def _readme(heading: Sequence[str], parts: Sequence[Part]) -> str:
    lines = ["A run in Gainscope, and the filter that was tuned in it.", *heading, ""]
    for part in parts:
        lines += [part.name, f"    {part.sentence}"]
    return "\n".join(
        [
            *lines,
            "",
            "Positions are in m, times in s, derivatives in m/s, m/s^2 and m/s^3. A self-test runs ten measurements,",
            "prints each smoothed position beside the one found in Gainscope, and fails where they differ.",
            "",
        ]
    )
