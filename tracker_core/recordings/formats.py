"""Files that are recognised by the names of their columns."""

from __future__ import annotations

from dataclasses import dataclass

from tracker_core.recordings.names import Name


@dataclass(frozen=True, slots=True)
class Format:
    """A kind of file.

    Attributes:
        title: what it is called.
        needs: names (small letters and digits) that it has, each with its other spellings.
        altitude: unit of an altitude whose name tells none, in LENGTHS.
        why: where that unit comes from.
    """

    title: str
    needs: tuple[frozenset[str], ...]
    altitude: str = "m"
    why: str = ""


def _spelled(*names: str) -> tuple[frozenset[str], ...]:
    return tuple(frozenset(name.split("|")) for name in names)


LATITUDE = frozenset({"lat", "latitude"})
LONGITUDE = frozenset({"lon", "lng", "long", "longitude"})

_FEET = "Altitudes of aircraft are given in feet where nothing else is said."

FORMATS = (
    Format(
        "OpenSky state vectors",
        _spelled("time", "icao24", "lat", "lon", "lastposupdate|lastcontact"),
        why="OpenSky gives altitudes in metres.",
    ),
    Format("FlightRadar24 CSV", _spelled("timestamp", "utc", "callsign", "position", "altitude"), "ft", _FEET),
    Format("MarineCadastre AIS", _spelled("mmsi", "basedatetime", "lat|latitude", "lon|longitude")),
    Format("AIS log", _spelled("mmsi", "lat|latitude", "lon|longitude|long")),
    Format(
        "ADS-B log (lat/lon/alt)",
        _spelled("icao24|icao|hex|hexident|callsign|flight", "lat|latitude", "lon|longitude|long|lng"),
        "ft",
        _FEET,
    ),
    Format(
        "GPX as CSV",
        _spelled("lat|latitude", "lon|longitude", "ele|elevation|altitude|alt|hdop|sat|name|desc|type|no|date"),
        why="GPX gives elevations in metres.",
    ),
    Format("Latitude and longitude", _spelled("lat|latitude", "lon|longitude|long|lng")),
    Format("Gainscope track", _spelled("sample", "time")),
)
"""The first whose names are all there is meant."""


def recognise(names: list[Name]) -> Format | None:
    """The format that names of columns belong to."""
    there = {name.whole for name in names}
    for known in FORMATS:
        if all(not spellings.isdisjoint(there) for spellings in known.needs):
            if known.title == "Gainscope track" and not any(name.whole.endswith("observed") for name in names):
                continue
            return known
    return None
