"""How a file is probably meant to be read, with the reason for every choice."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from math import pi, tau

from tracker_core.recordings.formats import LATITUDE, LONGITUDE, Format, recognise
from tracker_core.recordings.layout import Layout
from tracker_core.recordings.names import Name, take_apart
from tracker_core.recordings.units import LENGTHS

_TIMES = (
    "time", "timestamp", "t", "times", "ts", "epoch", "unixtime", "unix", "datetime", "basedatetime", "timeutc",
    "utctime", "utc", "gpstime", "posixtime", "snapshotts", "lastupdate", "seconds", "sec", "secs", "s", "millis", "ms",
    "date", "hms", "hhmmss", "dt", "elapsed", "tod",
)  # fmt: skip
_TIMES_OF_DAY = ("utc", "hms", "hhmmss", "nmea", "tod", "gps")
_ALTITUDES = (
    "geoaltitude", "altitude", "alt", "ele", "elevation", "height", "hae", "altgeom", "geometricaltitude",
    "baroaltitude", "altbaro",
)  # fmt: skip
_PAIRS = frozenset({"position", "latlon", "latlng", "latlong", "location", "coordinates", "coords", "point"})
_RANGES = frozenset({"range", "r", "rho", "dist", "distance", "slantrange"})
_BEARINGS = frozenset({"bearing", "brg", "azimuth", "az", "theta"})
_ELEVATIONS = frozenset({"elevation", "elevationangle", "el", "elev", "phi"})
_AXES = (
    ("x", "y", "z"),
    ("posx", "posy", "posz"),
    ("positionx", "positiony", "positionz"),
    ("px", "py", "pz"),
    ("xposition", "yposition", "zposition"),
    ("xpos", "ypos", "zpos"),
    ("east", "north", "up"),
    ("e", "n", "u"),
    ("easting", "northing", "height"),
)
_SINGLE = ("position", "pos", "range", "z", "value", "distance", "height", "altitude", "y", "signal")
IDS = (
    "icao24", "icao", "hex", "hexident", "mmsi", "trackid", "tracknumber", "track", "targetid", "objectid", "target",
    "vesselid", "aircraftid", "callsign", "flight", "flightid", "tripid", "id", "vesselname", "object", "vessel",
)  # fmt: skip


@dataclass(slots=True)
class Proposal:
    """Fields of a reading, and why.

    Attributes:
        format: what the file was recognised as.
        values: fields of Reading by name.
        why: a sentence for each of them that was chosen for a reason.
        ids: columns, from 1, that may tell tracks apart, the likeliest first.
    """

    format: str
    values: dict[str, object] = field(default_factory=dict)
    why: dict[str, str] = field(default_factory=dict)
    ids: list[int] = field(default_factory=list)

    def choose(self, name: str, value: object, why: str) -> None:
        """Set one field."""
        self.values[name] = value
        self.why[name] = why


def propose(layout: Layout) -> Proposal:
    """A reading for a layout: names first, values where names tell nothing."""
    names = [take_apart(name) for name in layout.names]
    known = recognise(names)
    made = Proposal(known.title if known else "")
    made.choose("delimiter", layout.delimiter, "It splits the rows most evenly into numbers and times.")
    made.choose("decimal", layout.decimal, f"So the numbers are written: with a {layout.decimal}.")
    made.choose("header", layout.header, "The first row holds text." if layout.header else "The first row holds data.")
    _time(made, layout, names)
    if not (_geographic(made, layout, names, known) or _polar(made, layout, names) or _named_axes(made, layout, names)):
        _first_numbers(made, layout)
    if not made.format:
        made.format = _plain_title(made)
    used = {made.values.get("time", 0), *_columns_of(made)}
    wholes = [name.whole for name in names]
    made.ids = [wholes.index(known_id) + 1 for known_id in IDS if known_id in wholes]
    made.ids = [column for column in made.ids if column not in used]
    return made


def _columns_of(made: Proposal) -> tuple[int, ...]:
    at = made.values["at"]
    return at if isinstance(at, tuple) else ()


def _titled(layout: Layout, column: int) -> str:
    name = layout.names[column][:40]
    return f"“{name}”" if name else f"column {column + 1}"


# Time ---------------------------------------------------------------------------------------------------------------


def _time(made: Proposal, layout: Layout, names: list[Name]) -> None:
    timed = {"number", "date", "clock"}
    wholes = [name.whole for name in names]
    named = [wholes.index(known) for known in _TIMES if known in wholes]
    # A date alone beside a time of day is no time; the time of day is one.
    column = next((c for c in named if layout.kinds[c] in timed and not _is_day(layout, c)), None)
    if column is None:
        column = next((c for c, kind in enumerate(layout.kinds) if kind in {"date", "clock"}), None)
    why = "Its name says so." if column in named else "It holds dates or times."
    if column is None and not any(layout.names):
        numeric = [c for c, kind in enumerate(layout.kinds) if kind == "number"]
        if len(numeric) > 1 and _rises(layout.values(numeric[0])):
            column, why = numeric[0], "It is the first column, and its numbers rise."
    if column is None:
        made.choose("time", 0, "No column looks like a time: say the interval between two rows.")
        return
    made.choose("time", column + 1, f"{_titled(layout, column)}: {why[0].lower()}{why[1:]}")
    clock, why = _clock(layout, column, names[column])
    made.choose("clock", clock, why)


def _is_day(layout: Layout, column: int) -> bool:
    cells = layout.cells(column)
    return (
        layout.kinds[column] == "date" and not any(":" in cell for cell in cells) and len(set(cells)) * 2 <= len(cells)
    )


def _rises(values: list[float]) -> bool:
    up = sum(later > earlier for earlier, later in pairwise(values))
    return len(values) > 1 and up >= 0.8 * (len(values) - 1)


def _clock(layout: Layout, column: int, name: Name) -> tuple[str, str]:
    if layout.kinds[column] == "date":
        aware = any(cell.strip().endswith(("Z", "z", "UTC")) or _zone(cell) for cell in layout.cells(column))
        note = "" if aware else " No zone is given: taken as UTC."
        return "iso", f"Its cells are dates and times (ISO 8601).{note}"
    if layout.kinds[column] == "clock":
        return "hms", "Its cells are times of day; the day after begins at midnight."
    if _looks_like_hhmmss(layout.cells(column), name):
        return "hms", "Its numbers are hhmmss, as in NMEA sentences."
    if name.unit in {"ms", "us"} or name.whole in {"ms", "millis"}:
        clock = "microseconds" if name.unit == "us" else "milliseconds"
        return clock, f"Its name says {clock}."
    values = sorted(abs(value) for value in layout.values(column))
    middle = values[len(values) // 2] if values else 0.0
    if middle >= 1e14:
        return "microseconds", "Its numbers are microseconds since 1970."
    if middle >= 1e11:
        return "milliseconds", "Its numbers are milliseconds since 1970."
    return "seconds", "Its numbers are seconds since 1970." if middle >= 2e8 else "Numbers, taken as seconds."


def _zone(cell: str) -> bool:
    tail = cell.strip()[-6:]
    return tail[:1] in {"+", "-"} and tail[3:4] == ":"


def _looks_like_hhmmss(cells: list[str], name: Name) -> bool:
    heads = [cell.strip().partition(".")[0] for cell in cells]
    valid = all(
        len(head) == 6 and head.isdigit() and head < "240000" and head[2:4] < "60" and head[4:] < "60" for head in heads
    )
    hinted = any(word in name.words for word in _TIMES_OF_DAY) or any(head.startswith("0") for head in heads)
    return bool(heads) and valid and hinted


# Position -----------------------------------------------------------------------------------------------------------


def _find(layout: Layout, names: list[Name], wanted: frozenset[str], *, true: bool = False) -> int | None:
    """The first column of numbers of one of these names."""
    for column, name in enumerate(names):
        if layout.kinds[column] in {"number", "empty"} and name.true == true and not name.other:
            told = name.bare if true or name.observed else name.whole
            if told in wanted or (wanted in {LATITUDE, LONGITUDE} and name.words and name.words[-1] in wanted):
                return column
    return None


def _geographic(made: Proposal, layout: Layout, names: list[Name], known: Format | None) -> bool:
    latitude, longitude = _find(layout, names, LATITUDE), _find(layout, names, LONGITUDE)
    if latitude is not None and longitude is not None:
        if not _within(layout, latitude, 90) or not _within(layout, longitude, 360):
            return False
        at, why = [latitude, longitude], "Their names say latitude and longitude, and the numbers are within range."
    else:
        pair = next((c for c, kind in enumerate(layout.kinds) if kind == "pair" and names[c].whole in _PAIRS), None)
        if pair is None:
            return False
        at, why = [pair, pair], f"{_titled(layout, pair)} holds latitude and longitude in one cell."
    altitude = next((c for c in (_altitude(layout, names, known) for known in _ALTITUDES) if c is not None), None)
    if altitude is not None:
        at.append(altitude)
        unit = names[altitude].unit
        if unit in LENGTHS:
            made.choose("units", (unit,), f"The name of the altitude says {unit}.")
        else:
            default = known.altitude if known else "m"
            made.choose("units", (default,), known.why if known and known.why else "Metres, as nothing else is said.")
    made.choose("frame", "geographic", why)
    made.choose("at", tuple(column + 1 for column in at), why)
    true = [_find(layout, names, wanted, true=True) for wanted in (LATITUDE, LONGITUDE)]
    if altitude is not None:
        true.append(_find(layout, names, frozenset(_ALTITUDES), true=True))
    _choose_truth(made, true)
    return True


def _altitude(layout: Layout, names: list[Name], wanted: str) -> int | None:
    column = _find(layout, names, frozenset({wanted}))
    return column if column is not None and layout.kinds[column] == "number" else None


def _within(layout: Layout, column: int, limit: float) -> bool:
    values = layout.values(column)
    return sum(abs(value) <= limit for value in values) >= 0.8 * len(values)


def _polar(made: Proposal, layout: Layout, names: list[Name]) -> bool:
    distance, bearing = _find(layout, names, _RANGES), _find(layout, names, _BEARINGS)
    if distance is None or bearing is None:
        return False
    at = [distance, bearing]
    raised = _find(layout, names, _ELEVATIONS)
    if raised is not None and _within(layout, raised, 90):
        at.append(raised)
    why = "Their names say range and bearing, clockwise from north."
    made.choose("frame", "polar", why)
    made.choose("at", tuple(column + 1 for column in at), why)
    if names[distance].unit in LENGTHS:
        made.choose("units", (names[distance].unit,), f"The name of the range says {names[distance].unit}.")
    unit = names[bearing].unit
    if unit in {"deg", "rad"}:
        made.choose("angle", unit, f"The name of the bearing says {unit}.")
    elif (values := layout.values(bearing)) and max(map(abs, values)) <= tau and max(map(abs, values)) > pi / 180:
        made.choose("angle", "rad", "No bearing is over 2π: taken as radians.")
    else:
        made.choose("angle", "deg", "Taken as degrees.")
    _choose_truth(
        made, [_find(layout, names, wanted, true=True) for wanted in (_RANGES, _BEARINGS, _ELEVATIONS)][: len(at)]
    )
    return True


def _named_axes(made: Proposal, layout: Layout, names: list[Name]) -> bool:
    for axes in (*_AXES, *((single,) for single in _SINGLE)):
        found = [_observed(made, layout, names, axis) for axis in axes]
        at = found[: found.index(None)] if None in found else found
        if at and (len(at) > 1 or len(axes) == 1 or axes[0] == "x"):
            break
    else:
        return False
    chosen = [column for column in at if column is not None]
    made.choose("at", tuple(column + 1 for column in chosen), "Their names say so.")
    units = [names[column].unit for column in chosen]
    if all(unit in LENGTHS for unit in units):
        told = (units[0],) if len(set(units)) == 1 else tuple(units)
        made.choose("units", told, f"The names say {', '.join(told)}.")
    _choose_truth(made, [_find(layout, names, frozenset({names[column].bare}), true=True) for column in chosen])
    return True


def _observed(made: Proposal, layout: Layout, names: list[Name], axis: str) -> int | None:
    """The column of an axis: one that is said to be observed before one that is not."""
    candidates = [
        column
        for column, name in enumerate(names)
        if layout.kinds[column] in {"number", "empty"}
        and not name.true
        and not name.other
        and column + 1 != made.values["time"]
    ]
    observed = [column for column in candidates if names[column].observed and names[column].bare == axis]
    return next(iter(observed + [column for column in candidates if names[column].whole == axis]), None)


def _choose_truth(made: Proposal, found: list[int | None]) -> None:
    columns = tuple(column + 1 for column in found if column is not None)
    if columns and len(columns) == len(found):
        made.choose("truth", columns, "Their names say that they hold the truth.")


def _first_numbers(made: Proposal, layout: Layout) -> None:
    numeric = [c + 1 for c, kind in enumerate(layout.kinds) if kind == "number" and c + 1 != made.values["time"]]
    taken = numeric if len(numeric) <= 3 else numeric[:2]
    why = "The first columns of numbers, as no name tells." if taken else "No column holds numbers."
    made.choose("at", tuple(taken) or (1 if made.values["time"] != 1 else 2,), why)


def _plain_title(made: Proposal) -> str:
    axes = ("x", "y", "z")[: len(_columns_of(made))]
    if made.values.get("frame") == "polar":
        axes = ("range", "bearing", "elevation")[: len(axes)]
    return ", ".join((*(("t",) if made.values["time"] else ()), *axes))
