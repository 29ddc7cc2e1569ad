"""How a file is read, as controls: one for every field of a `Reading`, and one for every column that it names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tracker_core.checks import Domain, InputError, check_choice
from tracker_core.measured import looked, tracks_in, written
from tracker_core.recordings import FRAMES, Reading
from tracker_core.recordings.bounds import MOST_COLUMNS

SLOTS = (1, 2, 3)
"""Of the columns of a position."""

PARTS = {
    "plane": ("x", "y", "z"),
    "geographic": ("Latitude", "Longitude", "Altitude"),
    "polar": ("Range", "Bearing", "Elevation angle"),
}
"""What the columns of a position hold."""

NONE = "0"
"""The column that none is."""

COLUMN_OR_NONE = Domain(0, MOST_COLUMNS, whole=True)

_SINGLE = ("delimiter", "decimal", "time", "interval", "clock", "frame", "angle", "track", "only", "held")

READING_FIELDS = (
    *(f"read_{name}" for name in ("header", *_SINGLE)),
    *(f"read_{name}{slot}" for name in ("at", "truth", "units") for slot in SLOTS),
)
"""The controls."""


def reading_controls(reading: Reading) -> dict[str, Any]:
    """Every control as it stands for a reading."""
    controls: dict[str, Any] = {f"read_{name}": getattr(reading, name) for name in _SINGLE}
    controls |= {name: str(controls[name]) for name in ("read_time", "read_track")}
    controls["read_header"] = "yes" if reading.header else "no"
    for slot in SLOTS:
        for name in ("at", "truth"):
            columns = getattr(reading, name)
            controls[f"read_{name}{slot}"] = str(columns[slot - 1]) if slot <= len(columns) else NONE
        controls[f"read_units{slot}"] = reading.units[min(slot, len(reading.units)) - 1]
    return controls


def follow_reading(controls: dict[str, Any], changed: list[str]) -> list[str]:
    """Change what follows from a file that was chosen, or from a control of how it is read.

    Args:
        controls: every control by name; changed in place.
        changed: names of those that a hand has moved.

    Returns:
        The same names, in place of those of the reading its own.

    Raises:
        InputError: naming the field `reading`, where the controls are none; `data` for a file that is not there.
    """
    moved = [name for name in changed if name in READING_FIELDS]
    if not moved:
        if {"data", "reading"} & {*changed} and controls.get("data"):
            text = "" if "reading" not in changed else str(controls.get("reading") or "")
            controls |= reading_controls(Reading.from_text(text) if text else looked(str(controls["data"])).reading)
        return changed
    try:
        reading = reading_of(controls, moved)
    except InputError as error:
        raise InputError("reading", f"must fit together: {error.field} {error.rule}", error.received) from error
    controls |= {"reading": written(reading), **reading_controls(reading)}
    return [name for name in changed if name not in {*moved, "reading"}] + ["reading"]


def reading_of(controls: Mapping[str, Any], moved: list[str]) -> Reading:
    """The reading that controls say; what was not moved gives way to what was.

    Raises:
        InputError: for a value that is none, or a column that cannot be.
    """
    controls = {**reading_controls(Reading()), **controls}
    values: dict[str, Any] = {name: controls[f"read_{name}"] for name in _SINGLE}
    for name in ("time", "track"):
        values[name] = int(COLUMN_OR_NONE.check(name, values[name]))
    values["header"] = controls["read_header"] == "yes"
    for name in ("at", "truth"):
        columns = (COLUMN_OR_NONE.check(name, controls[f"read_{name}{slot}"]) for slot in SLOTS)
        values[name] = tuple(int(column) for column in columns if column)
    if "read_frame" in moved:
        values["at"], values["truth"] = _columns_for(values), ()
    units = [controls[f"read_units{slot}"] for slot in SLOTS[: len(values["at"])]]
    several = values["frame"] == "plane" and len({*units}) > 1
    values["units"] = tuple(units) if several else (units[0] if units else "m",)
    if values["truth"] and len(values["truth"]) != len(values["at"]) and not _chosen(moved, "truth"):
        values["truth"] = ()
    if "read_track" in moved or not values["track"]:
        values["only"] = _first_track(controls, values)
    return Reading(**values)


def _chosen(moved: list[str], name: str) -> bool:
    return any(f"read_{name}{slot}" in moved for slot in SLOTS)


def _columns_for(values: Mapping[str, Any]) -> tuple[int, ...]:
    """Columns of a position in another frame: as they are, or with the next ones where they are too few."""
    fewest, most = FRAMES[check_choice("frame", values["frame"], FRAMES)]
    at = list(values["at"])[:most]
    while at and len(at) < fewest:
        following = at[-1] + 1
        at.append(following + (following == values["time"]))
    return tuple(at)


def _first_track(controls: Mapping[str, Any], values: Mapping[str, Any]) -> str:
    """The id of most rows in the column that was chosen."""
    if not values["track"] or not controls.get("data"):
        return ""
    usual = Reading(delimiter=values["delimiter"], header=values["header"])
    found = tracks_in(str(controls["data"]), written(usual), values["track"])
    return found[0][0] if found else ""


def fields_read(controls: Mapping[str, Any]) -> dict[str, bool]:
    """Of the controls that do not always mean something whether they do now."""
    frame = _frame(controls)
    plane, most = frame == "plane", FRAMES[frame][1]
    used = {name: sum(str(controls.get(f"read_{name}{slot}", NONE)) != NONE for slot in SLOTS)
            for name in ("at", "truth")}  # fmt: skip
    timed, tracked = (str(controls.get(f"read_{name}", NONE)) != NONE for name in ("time", "track"))
    shown = {"read_interval": not timed, "read_clock": timed, "read_only": tracked, "read_angle": frame == "polar"}
    shown["read_units1"] = frame != "geographic" or used["at"] > 2
    for slot in SLOTS:
        shown[f"read_at{slot}"] = slot <= min(used["at"] + 1, most)
        shown[f"read_truth{slot}"] = slot <= (used["at"] if used["truth"] else 1)
    return shown | {f"read_units{slot}": plane and slot <= used["at"] for slot in SLOTS[1:]}


def labels_read(controls: Mapping[str, Any]) -> dict[str, str]:
    """What the columns of a position are called in its frame."""
    frame = _frame(controls)
    parts = PARTS[frame]
    units = {"plane": "Unit of {}", "geographic": "Unit of altitude", "polar": "Unit of range"}[frame]
    labels = {f"read_at{slot}": part for slot, part in zip(SLOTS, parts, strict=True)}
    labels |= {f"read_truth{slot}": f"True {part}" for slot, part in zip(SLOTS, parts, strict=True)}
    return labels | {f"read_units{slot}": units.format(part) for slot, part in zip(SLOTS, parts, strict=True)}


def _frame(controls: Mapping[str, Any]) -> str:
    frame = str(controls.get("read_frame"))
    return frame if frame in FRAMES else "plane"
