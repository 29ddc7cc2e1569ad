"""How a recording is read: every field of a reading as a native control, prefilled with the proposal."""

from __future__ import annotations

from dash import html
from dash.development.base_component import Component

from layouts.inputs import about, box_field, error_line, select_field
from layouts.reading import PARTS, SLOTS
from tracker_core.recordings import DECIMALS, DELIMITERS, HELD
from tracker_core.recordings.clocks import CLOCKS
from tracker_core.recordings.units import ANGLES, LENGTHS

SIGNS = {
    "comma": "Comma ,", "semicolon": "Semicolon ;", "tab": "Tab", "pipe": "Bar |", "space": "Blanks",
    "point": "Point .",
}  # fmt: skip

FRAMES = {
    "plane": "Axes: x, y, z",
    "geographic": "Latitude, longitude",
    "polar": "Range and bearing",
}

UNITS = {"m": "metres", "km": "kilometres", "ft": "feet", "NM": "nautical miles"}

HELD_TITLES = {"kept": "Keep them as they are", "missing": "Take them as missing"}


def reading_card() -> Component:
    """The controls; assets/data.js fills the menus of columns and tracks in."""
    return html.Section(
        [
            html.Div(
                [
                    html.H2("How it is read"),
                    html.Button("As proposed", id="data-proposal", type="button", className="quiet", hidden=True),
                ],
                className="card-head",
            ),
            error_line("data", "reading"),
            html.Details(
                [html.Summary("Why this is proposed"), html.Ul(id="data-reasons", className="reasons-list")],
                className="reasons-card",
            ),
            *_columns(),
            _table_fields(),
        ],
        className="card reading-card",
    )  # fmt: skip


def _columns() -> list[Component]:
    time = html.Div(
        [
            column_field("read_time", "Time", "Its column; without one, rows follow at a constant interval."),
            select_field("data", "read_clock", "Written as", "How a time is written.",
                         [(name, clock.title) for name, clock in CLOCKS.items()]),
            box_field("data", "read_interval", "Interval", "Between two rows, where there is no time.", "s"),
        ],
        className="pair",
    )  # fmt: skip
    position = [
        select_field("data", "read_frame", "Position given as", "What its columns hold.", list(FRAMES.items())),
        html.Div([column_field(f"read_at{slot}", PARTS["plane"][slot - 1], "The column that holds it.")
                  for slot in SLOTS], className="pair"),
        html.Div([_unit_field(slot) for slot in SLOTS]
                 + [select_field("data", "read_angle", "Angles in", "Of bearing and elevation.",
                                 [(name, "degrees" if name == "deg" else "radians") for name in ANGLES])],
                 className="pair"),
    ]  # fmt: skip
    truth = html.Div(
        [column_field(f"read_truth{slot}", f"True {PARTS['plane'][slot - 1]}",
                      "The column of the true position, in the same frame and units, if there is one.")
         for slot in SLOTS],
        className="pair",
    )  # fmt: skip
    track = html.Div(
        [column_field("read_track", "Track", "The column that tells targets apart, if there is one."), _only_field()],
        className="pair",
    )
    return [time, *position, truth, track]


def _table_fields() -> Component:
    fields = [
        select_field("data", "read_delimiter", "Between cells", "What stands between two cells.",
                     [(name, SIGNS[name]) for name in DELIMITERS]),
        select_field("data", "read_decimal", "Decimal sign", "What stands before the fraction of a number.",
                     [(name, SIGNS[name]) for name in DECIMALS]),
        select_field("data", "read_header", "First row", "Whether the first row holds names.",
                     [("yes", "Names"), ("no", "Numbers")]),
        select_field("data", "read_held", "Held positions", "What is done with a position that is exactly the one "
                     "before, though time went on.", [(name, HELD_TITLES[name]) for name in HELD]),
    ]  # fmt: skip
    return html.Div(fields, className="pair")


def column_field(name: str, label: str, sentence: str) -> Component:
    """A menu of columns, filled in by the page's script; so is its label, which depends on the frame."""
    return html.Div(
        [
            html.Label(label, htmlFor=f"data-{name}", id=f"data-{name}-label", className="tip"),
            html.Select([], id=f"data-{name}", **_told(name), **{"data-control": name, "data-columns": "yes"}),
            about("data", name, sentence),
        ],
        className=f"field field-{name}",
    )


def _told(name: str) -> dict[str, str]:
    """What is wrong with a column stands above all of them."""
    return {"aria-describedby": f"data-{name}-about data-reading-error"}


def _unit_field(slot: int) -> Component:
    name = f"read_units{slot}"
    options = [html.Option(UNITS[unit], value=unit) for unit in LENGTHS]
    return html.Div(
        [
            html.Label("Unit", htmlFor=f"data-{name}", id=f"data-{name}-label", className="tip"),
            html.Select(options, id=f"data-{name}", **_told(name), **{"data-control": name}),
            about("data", name, "The unit of length that the file uses."),
        ],
        className=f"field field-{name}",
    )


def _only_field() -> Component:
    """A box with a list to choose from: type a part of the id."""
    place = {"input": "list", "id": "data-read_only", "control": "read_only", "label": "Which track"}
    return html.Div(
        [
            html.Label("Which", htmlFor="data-read_only", className="tip"),
            html.Div(className="placeholder", **{f"data-{name}": said for name, said in place.items()}),
            html.Datalist(id="data-read_only-list"),
            about("data", "read_only", "The id of the track that is read; type a part of it to search."),
        ],
        className="field field-read_only",
    )
