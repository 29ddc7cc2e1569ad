"""How a file is probably meant to be read."""

from __future__ import annotations

from tracker_core.recordings.choose_position import choose_position
from tracker_core.recordings.choose_time import choose_time
from tracker_core.recordings.formats import recognise
from tracker_core.recordings.layout import Layout
from tracker_core.recordings.names import take_apart
from tracker_core.recordings.proposal import Proposal

_IDS = (
    "icao24", "icao", "hex", "hexident", "mmsi", "trackid", "tracknumber", "track", "targetid", "objectid", "target",
    "vesselid", "aircraftid", "callsign", "flight", "flightid", "tripid", "id", "vesselname", "object", "vessel",
)  # fmt: skip
"""Names of columns that tell tracks apart, the likeliest first."""


def propose(layout: Layout) -> Proposal:
    """A reading for a layout: names first, values where names tell nothing."""
    names = [take_apart(name) for name in layout.names]
    known = recognise(names)
    made = Proposal(known.title if known else "")
    made.choose("delimiter", layout.delimiter, "It splits the rows most evenly into numbers and times.")
    made.choose("decimal", layout.decimal, f"So the numbers are written: with a {layout.decimal}.")
    made.choose("header", layout.header, "The first row holds text." if layout.header else "The first row holds data.")
    choose_time(made, layout, names)
    choose_position(made, layout, names, known)
    if made.values["time"] in made.at:
        made.choose("time", 0, "The column that looks like a time is part of the position.")
    if not made.format:
        made.format = _plain_title(made)
    used = {made.values.get("time", 0), *made.at}
    wholes = [name.whole for name in names]
    made.ids = [wholes.index(known_id) + 1 for known_id in _IDS if known_id in wholes]
    made.ids = [column for column in made.ids if column not in used]
    return made


def _plain_title(made: Proposal) -> str:
    if made.values.get("frame") == "geographic":
        return "Latitude and longitude"
    axes = ("x", "y", "z")[: len(made.at)]
    if made.values.get("frame") == "polar":
        axes = ("range", "bearing", "elevation")[: len(axes)]
    return ", ".join((*(("t",) if made.values["time"] else ()), *axes))
