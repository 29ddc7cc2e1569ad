"""What a file is taken for: formats that people have, names and values, and the reason for every choice."""

import gzip
from dataclasses import fields

import numpy as np
import pytest

from tracker_core.checks import InputError
from tracker_core.recordings import Reading, bounds, look, read, tracks
from tracker_core.recordings.names import take_apart
from tracker_core.recordings.numbers import split


def lines(names, row, count=20):
    return "\n".join([*([names] if names else []), *(row(k) for k in range(count))]) + "\n"


OPENSKY = (
    "time,icao24,lat,lon,velocity,heading,vertrate,callsign,onground,alert,spi,squawk,baroaltitude,geoaltitude,"
    "lastposupdate,lastcontact"
)
FILES = {
    "opensky": (
        lines(OPENSKY, lambda k: f"{1500000000 + k},3c6444,{48 + k / 100},{11 - k / 100},200,10,0,DLH1,0,0,0,"
                                 f"1000,{3000 + k},{3100 + k},{1500000000 + k - 0.3},{1500000000 + k - 0.1}"),
        "OpenSky state vectors", "frame:geographic,at:3.4.14",
    ),
    "flightradar24": (
        lines("Timestamp,UTC,Callsign,Position,Altitude,Speed,Direction",
              lambda k: f'{1500000000 + 10 * k},2017-07-14T02:{k:02d}:00Z,B,"51.{47 + k},-0.{45 + k}",{100 * k},9,270'),
        "FlightRadar24 CSV", "frame:geographic,at:4.4.5,units:ft",
    ),
    "marine cadastre": (
        lines("MMSI,BaseDateTime,LAT,LON,SOG,COG,Heading,VesselName,IMO",
              lambda k: f"{366000000 + k % 3 // 2},2020-01-01T00:{k:02d}:0{k % 7},{29 + k / 1e3},-90.{k:02d},1,2,3,A,"),
        "MarineCadastre AIS", "time:2,clock:iso,frame:geographic,at:3.4,track:1,only:366000000",
    ),
    "marine cadastre of later years": (
        lines("mmsi,base_date_time,longitude,latitude,sog",
              lambda k: f"366000000,2020-01-01 00:{k:02d}:00,-90.{k:02d},{29 + k / 1e3},1"),
        "MarineCadastre AIS", "time:2,clock:iso,frame:geographic,at:4.3",
    ),
    "gpsbabel": (
        lines("No,Latitude,Longitude,Altitude,Date,Time",
              lambda k: f"{k},47.{k:03d},11.{k:03d},{500 + k},2020/05/01,12:00:{k:02d}"),
        "GPX as CSV", "time:6,clock:hms,frame:geographic,at:2.3.4",
    ),
    "gps visualizer": (
        lines("type,time,latitude,longitude,altitude (m),name,desc",
              lambda k: f"T,2020-05-01 12:00:{k:02d},47.{k:03d},11.{k:03d},{k},,"),
        "GPX as CSV", "time:2,clock:iso,frame:geographic,at:3.4.5",
    ),
    "traffic library": (
        lines("timestamp,icao24,latitude,longitude,altitude,groundspeed",
              lambda k: f"2020-01-01 00:00:{k:02d}+00:00,abc,{48 + k / 100},{11 - k / 100},{1000 + 25 * k},200"),
        "ADS-B log (lat/lon/alt)", "clock:iso,frame:geographic,at:3.4.5,units:ft",
    ),
    "t, x, y": (lines("t,x,y", lambda k: f"{k / 10},{k},{2 * k}"), "t, x, y", ""),
    "without names": (lines("", lambda k: f"{k / 10},{k},{2 * k}"), "t, x, y", "header:no"),
    "four numbers": (lines("", lambda k: f"{k}\t{k}\t{2 * k}\t{-k}"), "t, x, y, z", "delimiter:tab,header:no,at:2.3.4"),
    "truth": (lines("t,x,y,x_true,y_true", lambda k: f"{k},{k},{k},{k},{k}"), "t, x, y", "truth:4.5"),
    "measured": (
        lines("Time [s];xTrue;yTrue;xMeas [km];yMeas [km];xEst;yEst", lambda k: f"{k};{k};{k};{k};{k};{k};{k}"),
        "t, x, y", "delimiter:semicolon,at:4.5,units:km,truth:2.3",
    ),
    "east and north": (lines("time,east_ft,north_ft,up_ft", lambda k: f"{k},{k},{k},{k}"),
                       "t, x, y, z", "at:2.3.4,units:ft"),
    "blanks": (lines("", lambda k: f"  {k / 10:.1f}   {k}  {2 * k}"), "t, x, y", "delimiter:space,header:no"),
    "savetxt": (lines("# t x y", lambda k: f"{k / 10:e} {k:e} {2 * k:e}"), "t, x, y", "delimiter:space,header:no"),
    "decimal comma": (
        lines("Zeit;x [km];y [km]", lambda k: f"{k},5;{k},25;{2 * k},125"),
        "t, x, y", "delimiter:semicolon,decimal:comma,units:km",
    ),
    "decimal comma in quotes": (
        lines("t,x,y", lambda k: f'"{k},5","{k},25","{k},125"'), "t, x, y", "decimal:comma",
    ),
    "pairs with decimal commas": (
        lines("Zeit;Kurs;Position", lambda k: f"{k},5;{k * k},25;48,{k + 10} -11,{k + 10}"),
        "Latitude and longitude", "delimiter:semicolon,decimal:comma,frame:geographic,at:3.3",
    ),
    "pairs with decimal commas and semicolons": (
        lines("Zeit;Kurs;Position", lambda k: f'{k},5;{k * k},25;"48,{k + 10}; -11,{k + 10}"'),
        "Latitude and longitude", "delimiter:semicolon,decimal:comma,frame:geographic,at:3.3",
    ),
    "pairs with decimal commas and commas": (
        lines("t,course,position", lambda k: f'{k},{k * k},"(48,{k + 10}, -11,{k + 10})"'),
        "Latitude and longitude", "decimal:comma,frame:geographic,at:3.3",
    ),
    "pairs with decimal commas and commas, unquoted": (
        lines("Zeit;Kurs;Position", lambda k: f"{k};{k * k};48,{k + 10}, -11,{k + 10}"),
        "Latitude and longitude", "delimiter:semicolon,decimal:comma,frame:geographic,at:3.3",
    ),
    "pairs between tabs": (
        lines("t\tcourse\tposition", lambda k: f"{k},5\t{k * k},5\t48,{k + 10}, -11,{k + 10}"),
        "Latitude and longitude", "delimiter:tab,decimal:comma,frame:geographic,at:3.3",
    ),
    "pairs of another name": (
        lines("t;course;Ort", lambda k: f"{k};{k * k % 360};{k},5 {k + 1},25"),
        "t, x, y", "delimiter:semicolon,decimal:comma,at:3.3",
    ),
    "pairs with points beside decimal commas": (
        lines("t;height;position", lambda k: f"{k},5;{k * k},25;48.{k + 10},-11.{k + 10}"),
        "Latitude and longitude", "delimiter:semicolon,decimal:comma,frame:geographic,at:3.3.2",
    ),
    "sample, x, y": (lines("sample,x,y", lambda k: f"{k},{k},{-k}"), "t, x, y", ""),
    "k, pos": (lines("k;pos_x;pos_y", lambda k: f"{k};{k};{-k}"), "t, x, y", "delimiter:semicolon"),
    "frames last": (lines("x,y,frame_id", lambda k: f"{k * k},{-k},{7 + k}"), "t, x, y", "time:3,at:1.2"),
    "a counter beside a time": (lines("n,time,x", lambda k: f"{k},{k / 10},{k * k}"), "t, x", "time:2,at:3"),
    "a counter that begins anew": (lines("frame,x,y", lambda k: f"{k % 15},{k},{-k}"), "x, y", "time:0"),
    "east and n": (lines("e,n", lambda k: f"{k * k},{k}"), "x, y", "time:0,at:1.2"),
    "one column": (lines("", lambda k: f"{k * k}"), "x", "header:no,time:0,at:1"),
    "no time": (lines("x,y", lambda k: f"{k * k},{-k}"), "x, y", "time:0,at:1.2"),
    "a position that rises": (
        lines("gps_lat,gps_lon", lambda k: f"{48 + k / 100},{11 - k / 100}"),
        "Latitude and longitude", "time:0,frame:geographic,at:1.2",
    ),
    "radar": (
        lines("time_ms\trange_km\tazimuth_deg\televation", lambda k: f"{100 * k}\t{k + 1}\t{20 * k}\t{k}"),
        "t, range, bearing, elevation", "delimiter:tab,clock:milliseconds,frame:polar,at:2.3.4,units:km",
    ),
    "radians": (lines("t,r,theta", lambda k: f"{k},{k},{k / 4}"), "t, range, bearing", "frame:polar,angle:rad"),
    "nmea": (
        lines("utc,lat,lon", lambda k: f"{235950 + k if k < 10 else k - 10:06d}.00,{48 + k / 100},{11 - k / 100}"),
        "Latitude and longitude", "clock:hms,frame:geographic",
    ),
    "epoch in milliseconds": (lines("ts,x,y", lambda k: f"{1714800000000 + 40 * k},{k},{k}"),
                              "t, x, y", "clock:milliseconds"),
    "epoch in microseconds": (lines("ts,x,y", lambda k: f"{1714800000000000 + 40 * k},{k},{k}"),
                              "t, x, y", "clock:microseconds"),
    "held": (lines("t,x,y", lambda k: f"{k},{k // 4 * 4 if k > 12 else k},1"), "t, x, y", "held:missing"),
    "standing": (lines("t,x,y", lambda k: f"{k},{k // 10},1"), "t, x, y", ""),
    "a preamble": ("Log of today\n\n" + lines("t,x,y", lambda k: f"{k},{k},{-k}"), "t, x, y", ""),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_recognised(name):
    text, title, reading = FILES[name]
    for data in (text.encode(), gzip.compress(text.encode("utf-16"))):
        seen = look(data)
        assert (seen.format, seen.reading.text()) == (title, reading)
        assert read(data, seen.reading).measured >= 10


@pytest.mark.parametrize("name", FILES)
def test_every_choice_has_its_reason(name):
    seen = look(FILES[name][0].encode())
    changed = {field.name for field in fields(Reading) if getattr(seen.reading, field.name) != field.default}
    assert changed <= set(seen.why)
    assert all(why.endswith(".") for why in seen.why.values())


def test_the_gaps_of_a_counter_are_kept():
    counts = [*range(40), *range(80, 120)]
    for name in ("sample", "k", "frame", "Scan No"):
        data = "\n".join([f"{name},x,y", *(f"{k},{k},{-k}" for k in counts)]).encode()
        seen = look(data)
        assert "One second a count is assumed" in seen.why["time"]
        assert "gaps are kept" in seen.why["time"]
        found = read(data, seen.reading)
        assert (found.interval, len(found.times), found.counts) == (1, 120, {"gap": 1})
        assert np.flatnonzero(found.lines).tolist() == counts


@pytest.mark.parametrize(
    ("cell", "decimal", "parts"),
    [
        ("(51.5, -0.1)", ".", ["51.5", "-0.1"]), ("51.5;-0.1", ".", ["51.5", "-0.1"]),
        ("48,1 11,5", ",", ["48.1", "11.5"]),
        ("48,1; 11,5", ",", ["48.1", "11.5"]), ("48,1, 11,5", ",", ["48.1", "11.5"]),
        ("[48,1;-11]", ",", ["48.1", "-11"]),
        ("48, 11,5", ",", ["48", "11.5"]), ("48,1", ",", ["48.1"]), ("48.1,11.5", ",", ["48.1", "11.5"]),
        ("1.048,1 11,5", ",", ["1_048.1", "11.5"]),
    ],
)  # fmt: skip
def test_cells_that_hold_several_numbers(cell, decimal, parts):
    assert split(cell, decimal) == parts


def test_a_pair_with_decimal_commas_is_read_to_the_digit():
    reading = Reading(delimiter="semicolon", decimal="comma", at=(2, 2))
    cells = ["48,1 11,5", '"48,25; 11,75"', "48,5, 12,25", "49,5", ""]
    found = read("\n".join(["t;p", *(f"{k};{cell}" for k, cell in enumerate(cells))]).encode(), reading)
    expected = [[48.1, 11.5], [48.25, 11.75], [48.5, 12.25]]
    assert found.positions[:3].tolist() == expected
    # One number is no pair: none of its digits passes for the other one.
    assert [finding.line for finding in found.findings if finding.kind == "position"] == [5]
    assert np.isnan(found.positions[3, 1])


def test_what_is_shown():
    data = "n,<b>t</b>,Höhe\n" + "".join(f"<i>{k}</i>,{k},{'z' * 200}\n" for k in range(30))
    seen = look(data.encode())
    assert [column.name for column in seen.columns] == ["n", "<b>t</b>", "Höhe"]
    assert [column.kind for column in seen.columns] == ["text", "number", "text"]
    assert seen.columns[0].first == ("<i>0</i>", "<i>1</i>", "<i>2</i>")
    assert (seen.rows, seen.encoding, seen.packed) == (30, "utf-8", False)
    assert seen.preview[0] == (2, ("<i>0</i>", "0", "z" * 79 + "…"))
    assert len(seen.preview) == 8


def test_names_from_a_comment():
    seen = look(FILES["savetxt"][0].encode())
    assert [column.name for column in seen.columns] == ["t", "x", "y"]


def test_a_date_without_a_zone_is_said_to_be_taken_as_utc():
    text = lines("t,x", lambda k: f"2020-01-01 00:00:{k:02d},{k}")
    assert "taken as UTC" in look(text.encode()).why["clock"]
    assert "taken as UTC" not in look(text.replace(",", "Z,").encode()).why["clock"]


def test_tracks_with_most_rows_come_first():
    rows = [f"{k},{k % 7 if k % 2 else 'b'},{k}" for k in range(100)]
    data = "\n".join(["t,id,x", *rows]).encode()
    seen = look(data)
    assert seen.tracks[0] == ("b", 50)
    assert (seen.reading.track, seen.reading.only) == (2, "b")
    assert sum(count for _, count in seen.tracks) == 100
    assert tracks(data, seen.reading, 2) == seen.tracks
    assert tracks(data, seen.reading, 9) == ()


def test_a_number_of_every_row_is_no_track():
    seen = look(lines("id,t,x,y", lambda k: f"{k},{k},{k},{-k}").encode())
    assert (seen.tracks, seen.reading.track) == ((), 0)


def test_ids_are_listed_up_to_a_bound():
    data = lines("t,id,x", lambda k: f"{k},{k // 3:04d}{'é' * 200},{k}", 6000).encode()
    seen = look(data)
    assert len(seen.tracks) == bounds.MOST_TRACKS
    assert all(len(name) == bounds.ID_LENGTH for name, _ in seen.tracks)
    assert read(data, seen.reading).measured == 3
    assert len(seen.reading.text()) <= 2000


@pytest.mark.parametrize("data", [b"", b"\n\n", b"# only a comment", b"\0" * 50, gzip.compress(b"", mtime=0)])
def test_nothing_to_look_at(data):
    with pytest.raises(InputError, match="file must hold rows of cells, got 'none'"):
        look(data)


@pytest.mark.parametrize("data", [b"hello", b"hello\nworld", b"a,b\nc,d", b"=1+1", b"1", b",,,\n,,,"])
def test_a_text_that_is_no_table_is_looked_at_and_not_read(data):
    seen = look(data)
    with pytest.raises(InputError, match="at least|must follow"):
        read(data, seen.reading)


@pytest.mark.parametrize(
    ("name", "words", "unit"),
    [
        ("x_true", ("x", "true"), ""), ("xTrue", ("x", "true"), ""), ("Altitude (ft)", ("altitude",), "ft"),
        ("pos_x [km]", ("pos", "x"), "km"), ("range_m", ("range",), "m"), ("m", ("m",), ""),
        ("time_ms", ("time",), "ms"),
        ("BaseDateTime", ("base", "date", "time"), ""), ("LAT", ("lat",), ""), ("", (), ""), ("[[[", (), ""),
        ("GPSLat", ("gps", "lat"), ""), ("x" * 5000, ("x" * 200,), ""),
    ],
)  # fmt: skip
def test_names_are_taken_apart(name, words, unit):
    found = take_apart(name)
    assert (found.words, found.unit) == (words, unit)


def test_distances_of_recognised_files():
    """Latitude and longitude in one cell, altitude in feet: the same place as in columns of their own."""
    text, _, reading = FILES["flightradar24"]
    found = read(text.encode(), Reading.from_text(reading))
    apart = read(
        text.replace('"', "").replace("Position", "lat,lon").encode(),
        Reading.from_text("frame:geographic,at:4.5.6,units:ft"),
    )
    assert np.array_equal(found.positions, apart.positions)
    assert found.interval == 10
