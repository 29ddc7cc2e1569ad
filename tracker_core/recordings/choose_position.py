"""Which columns are the position and its truth, and in what frame and units."""

from __future__ import annotations

from itertools import chain
from math import pi, tau

from tracker_core.recordings.formats import LATITUDE, LONGITUDE, Format
from tracker_core.recordings.layout import Layout
from tracker_core.recordings.names import Name
from tracker_core.recordings.proposal import Proposal, titled
from tracker_core.recordings.units import LENGTHS

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
POSITIONS = LATITUDE | LONGITUDE | _PAIRS | _RANGES | _BEARINGS | _ELEVATIONS | {*_SINGLE, *_ALTITUDES, *chain(*_AXES)}
"""Names of columns that hold a part of a position."""


def choose_position(made: Proposal, layout: Layout, names: list[Name], known: Format | None) -> None:
    """Choose the columns of the position: by name, else the first that hold numbers."""
    if not (
        _geographic(made, layout, names, known)
        or _polar(made, layout, names)
        or _named_axes(made, layout, names)
        or _first_pair(made, layout)
    ):
        _first_numbers(made, layout)


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
        at, why = [pair, pair], f"{titled(layout, pair)} holds latitude and longitude in one cell."
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
    # A pair in one cell is a position before a single column is.
    singles = () if "pair" in layout.kinds else _SINGLE
    for axes in (*_AXES, *((single,) for single in singles)):
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


def _first_pair(made: Proposal, layout: Layout) -> bool:
    if "pair" not in layout.kinds:
        return False
    pair = layout.kinds.index("pair")
    made.choose("at", (pair + 1, pair + 1), f"{titled(layout, pair)} holds two numbers in one cell: taken as x and y.")
    return True


def _first_numbers(made: Proposal, layout: Layout) -> None:
    numeric = [c + 1 for c, kind in enumerate(layout.kinds) if kind == "number" and c + 1 != made.values["time"]]
    taken = numeric if len(numeric) <= 3 else numeric[:2]
    why = "The first columns of numbers, as no name tells." if taken else "No column holds numbers."
    made.choose("at", tuple(taken) or (1 if made.values["time"] != 1 else 2,), why)
