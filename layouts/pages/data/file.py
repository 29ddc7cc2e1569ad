"""A file as the page shows it: what it was recognised as, its columns by name, its first rows with their roles."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from layouts.reading import NONE, PARTS, SLOTS, fields_read, labels_read
from tracker_core.checks import InputError
from tracker_core.measured import fetch, looked, tracks_in, written
from tracker_core.recordings import DELIMITERS, Look, Reading
from tracker_core.recordings.preview import Preview, preview

MOST_SHOWN = 40
"""Columns of the first rows that are shown, beside those that are read."""

NAME_LENGTH = 60
"""Characters of a column's name in a menu."""

TITLES = {
    "delimiter": "Between cells", "decimal": "Decimal sign", "header": "Names", "time": "Time", "clock": "Clock",
    "frame": "Position", "at": "Columns", "units": "Units", "angle": "Angle", "truth": "Truth", "track": "Track",
    "only": "Track", "held": "Held positions",
}  # fmt: skip
"""What the reasons of a proposal are about."""


def file_shown(data: str, controls: Mapping[str, Any]) -> dict[str, Any]:
    """What is shown of a file, all of it text that nobody interprets.

    Args:
        data: what it is known by.
        controls: of how it is read, right or wrong.

    Raises:
        InputError: for a file that is nowhere, or is no table.
    """
    seen = looked(data)
    file = fetch(data)
    delimiter = str(controls.get("read_delimiter"))
    delimiter = delimiter if delimiter in DELIMITERS else seen.reading.delimiter
    header = controls.get("read_header") != "no"
    head = _preview(data, delimiter, header)
    roles = roles_of(controls)
    names = _names(head, seen, header, max(map(int, roles), default=0))
    columns = [number for number in range(1, len(names) + 1) if number <= MOST_SHOWN or str(number) in roles]
    return {
        "data": data,
        "name": file.name,
        "bytes": len(file.content),
        "format": seen.format,
        "rows": seen.rows,
        "packed": seen.packed,
        "columns": [[number, name] for number, name in enumerate(names, start=1)],
        "roles": roles,
        "preview": {
            "columns": columns,
            "left": len(names) - len(columns),
            "rows": [[line, [row[number - 1] if number <= len(row) else "" for number in columns]]
                     for line, row in head.rows],
        },
        "tracks": [[name, count] for name, count in _tracks(data, delimiter, header, seen, controls)],
        "why": reasons(seen),
        "fields": fields_read(controls),
        "labels": labels_read(controls),
        "proposed": controls.get("reading") in ("", None, written(seen.reading)),
    }  # fmt: skip


def reasons(seen: Look) -> list[str]:
    """Why it is proposed to read the file like this: every reason once, with what it speaks for."""
    about: dict[str, list[str]] = {}
    for name, reason in seen.why.items():
        title = TITLES.get(name, name)
        if title not in about.setdefault(reason, []):
            about[reason].append(title)
    return [f"{', '.join(titles)}: {reason}" for reason, titles in about.items()]


def roles_of(controls: Mapping[str, Any]) -> dict[str, str]:
    """What is read from which column, by its number."""
    parts = PARTS.get(str(controls.get("read_frame")), PARTS["plane"])
    said = [("read_time", "Time"), ("read_track", "Track")]
    said += [(f"read_at{slot}", part) for slot, part in zip(SLOTS, parts, strict=True)]
    said += [(f"read_truth{slot}", f"True {part}") for slot, part in zip(SLOTS, parts, strict=True)]
    roles: dict[str, str] = {}
    for name, role in said:
        column = str(controls.get(name, NONE))
        if column.isdecimal() and int(column):
            roles[column] = f"{roles[column]}, {role}" if column in roles else role
    return roles


def _names(head: Preview, seen: Look, header: bool, least: int) -> list[str]:
    """Names of all columns as menus show them; "column 7" where there is none."""
    names = list(head.names)
    if not header and not any(names) and len(seen.columns) == head.width:
        # A comment may hold them.
        names = [column.name for column in seen.columns]
    names += [""] * (max(head.width, least) - len(names))
    return [name[:NAME_LENGTH] or f"column {number}" for number, name in enumerate(names, start=1)]


def _tracks(
    data: str, delimiter: str, header: bool, seen: Look, controls: Mapping[str, Any]
) -> tuple[tuple[str, int], ...]:
    column = str(controls.get("read_track", NONE))
    if not column.isdecimal() or not int(column):
        return ()
    if seen.tracks and int(column) == seen.reading.track and delimiter == seen.reading.delimiter:
        return seen.tracks
    try:
        return tracks_in(data, written(Reading(delimiter=delimiter, header=header)), int(column))
    except InputError:
        return ()


@lru_cache(maxsize=32)
def _preview(data: str, delimiter: str, header: bool) -> Preview:
    try:
        return preview(fetch(data).content, delimiter, header=header)
    except InputError:
        # Split like that it passes a bound.
        return Preview((), ())
