"""The Data page: what it shows of a file, right or wrong, of what was found, and of the filter that suits it."""

import json
from pathlib import Path
from urllib.parse import urlencode

import numpy as np
import pytest
from dash._utils import to_json

from layouts import desk
from layouts.desk import answer, beginning
from layouts.figures.recording import filled
from layouts.pages.data import suggesting
from layouts.pages.data.answers import DESK, NUMBERS
from layouts.pages.data.file import MOST_SHOWN
from layouts.pages.data.view import EXAMPLES, layout
from layouts.questions import StudyQuestion
from layouts.text import significant
from layouts.theme import SCORES, tokens
from tests.tables import cells
from tracker_core import Experiment, InputError, run_experiment
from tracker_core.measured import SHELF, File, recorded

RECORDINGS = Path(__file__).parents[2] / "assets" / "recordings"
UNKNOWN = "f" * 32


@pytest.fixture
def example():
    def keep(name):
        return SHELF.keep(File(f"{name}.csv", (RECORDINGS / f"{name}.csv").read_bytes()))

    return keep


@pytest.fixture
def show(request_for):
    """The page's answer to a link, as JSON: its plots, or what is wanted."""

    def shown(moved=None, want=None, **query):
        begun = beginning(DESK, query)
        updates, rest = answer(DESK, request_for(begun["controls"], moved, want=want))
        return updates if want else updates[: len(DESK.plots)], json.loads(json.dumps(rest))

    return shown


# Without a recording -------------------------------------------------------------------------------------------------


def test_without_a_recording_the_page_says_what_can_be_loaded(show):
    text = to_json(layout())
    assert "latitude and longitude" in text
    for name in EXAMPLES:
        assert f'"{name}.csv"' in text
        assert (RECORDINGS / f"{name}.csv").exists()
    _, rest = show()
    assert rest["ok"]
    assert rest["recording"] is None
    assert rest["rows"] == {"facts": [], "counts": [], "findings": []}


def test_a_recording_that_is_nowhere_is_missing_and_one_that_cannot_be_read_is_not():
    assert beginning(DESK, {"data": UNKNOWN})["missing"] == UNKNOWN
    assert beginning(DESK, {"data": "nonsense"})["missing"] == ""
    data = SHELF.keep(File("words.csv", b"one,two\n1,a\nb,c\n"))
    assert beginning(DESK, {"data": data})["missing"] == ""


def test_a_change_to_a_recording_that_is_nowhere_says_so(show):
    _, rest = show({"data": UNKNOWN})
    assert not rest["ok"]
    assert rest["missing"] == UNKNOWN
    assert rest["recording"] is None
    assert rest["errors"].keys() == {"data"}


# With one ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_is_shown_whole(show, example, name):
    updates, rest = show(data=example(name))
    assert rest["ok"]
    assert rest["recording"]["name"] == f"{name}.csv"
    assert rest["stem"] == name
    assert rest["recording"]["proposed"]
    assert rest["recording"]["why"]
    found = recorded(rest["controls"]["data"], rest["controls"]["reading"])
    assert len(rest["rows"]["counts"]) == len(found.counts)
    assert len(rest["rows"]["findings"]) == len(found.findings)
    for update in updates:
        assert {"data", "layout"} <= update.keys()


def test_the_dirty_file_is_told_in_full(show, example):
    _, rest = show(data=example("dirty"))
    counts = {title: (int(count), done) for title, count, done in rest["rows"]["counts"]}
    assert counts["Held position"] == (23, "Taken as missing.")
    assert counts["Out of order"] == (3, "The row is moved to its place in time.")
    lines = (RECORDINGS / "dirty.csv").read_text().splitlines()
    for line, kind, reason in rest["rows"]["findings"]:
        if kind == "Not a number":
            assert reason.partition(": ")[2] in lines[int(line) - 1]
    facts = dict(rest["rows"]["facts"])
    assert facts["Interval"] == "constant, T = 1 s, 4 gaps"
    assert facts["Truth"] == "not known: innovations take its place"
    _, kept = show({"read_held": "kept"}, data=example("dirty"))
    assert ["Held position", "23", "Kept as they are."] in kept["rows"]["counts"]
    assert not kept["recording"]["proposed"]


def test_intervals_that_vary_and_other_tracks_are_told(show, example):
    _, rest = show(data=example("irregular"))
    facts = dict(rest["rows"]["facts"])
    assert facts["Rows"] == "520, 220 of other tracks"
    assert facts["Interval"].startswith("varies: shortest 2 s, median 8 s, longest 73 s;")
    assert rest["recording"]["tracks"] == [["211000101", 300], ["211000202", 220]]
    assert rest["recording"]["roles"] == {"1": "Track", "2": "Time", "3": "Latitude", "4": "Longitude"}
    assert rest["recording"]["fields"]["read_only"]


def kept(times, names="t,x"):
    rows = (f"{time},{place**1.5:.6f}" if names[0] == "t" else f"{place**1.5:.6f}" for place, time in enumerate(times))
    return SHELF.keep(File("times.csv", "\n".join([names, *rows]).encode()))


def test_how_far_stamps_lie_beside_a_constant_interval_is_told(show):
    def interval(data, moved=None):
        return dict(show(moved, data=data)[1]["rows"]["facts"])["Interval"]

    assert interval(kept(np.floor(5.5 * np.arange(301) + 0.5))) == (
        "constant, T = 5.5 s; stamps lie up to 0.25 s beside it"
    )
    assert interval(kept(10 * np.arange(60))) == "constant, T = 10 s"
    assert interval(kept(1_714_800_000 + 0.04 * np.delete(np.arange(60), 30))) == "constant, T = 0.04 s, 1 gap"
    assert interval(kept(np.arange(60), names="x")) == "constant, T = 1 s, assumed: no column is read as a time"
    told = interval(kept(np.cumsum([0, *[2, 3] * 30])))
    assert told.startswith("varies: shortest 2 s, median 2.5 s, longest 3 s;")


HTML = "<img src=x onerror=alert(1)>"


def test_names_ids_and_cells_are_text_and_reach_no_figure(show):
    rows = "\n".join(f"{row},{row * row},{-row},{HTML if row % 3 else '=1+1'}" for row in range(60))
    data = SHELF.keep(File(f"{HTML}.csv", f"{HTML},{HTML} x,y,{HTML} id\n{rows}\n".encode()))
    moved = {"read_time": "1", "read_at1": "2", "read_at2": "3", "read_at3": "0", "read_track": "4"}
    updates, rest = show(moved, data=data)
    assert rest["ok"]
    assert rest["recording"]["columns"][0] == [1, HTML]
    assert rest["recording"]["tracks"][0] == [HTML, 40]
    assert rest["recording"]["preview"]["rows"][1][1][3] == HTML
    assert HTML not in json.dumps(updates)
    assert rest["stem"] == "img-src-x-onerror-alert-1"


def test_a_wide_table_shows_what_is_read_and_the_first_columns(show):
    names = ",".join(f"c{number}" for number in range(1, 301))
    rows = "\n".join(",".join(str(row * number % 97) for number in range(1, 301)) for row in range(1, 40))
    data = SHELF.keep(File("wide.csv", f"{names}\n{rows}\n".encode()))
    moved = {"read_time": "0", "read_at1": "299", "read_at2": "0", "read_at3": "0"}
    _, rest = show(moved, data=data)
    shown = rest["recording"]["preview"]["columns"]
    assert shown == [*range(1, MOST_SHOWN + 1), 299]
    assert rest["recording"]["preview"]["left"] == 300 - MOST_SHOWN - 1
    assert len(rest["recording"]["columns"]) == 300


def test_a_wrong_reading_still_shows_the_file_split_as_it_says(show, example):
    _, rest = show({"read_delimiter": "semicolon"}, data=example("good"))
    assert not rest["ok"]
    assert rest["errors"].keys() == {"reading"}
    assert rest["missing"] == ""
    assert len(rest["recording"]["preview"]["rows"][0][1]) < 7
    assert "," in rest["recording"]["columns"][0][1]
    _, mended = show({"read_delimiter": "comma"}, data=example("good"))
    assert mended["ok"]


def test_a_reading_as_polar_names_its_columns(show, example):
    _, rest = show({"read_frame": "polar"}, data=example("good"))
    assert rest["recording"]["labels"]["read_at2"] == "Bearing"
    assert rest["recording"]["fields"]["read_angle"]
    assert dict(rest["rows"]["facts"])["Axes"] == "east, north"


def test_files_are_read_in_a_thread(example, request_for):
    stands = beginning(DESK, {"data": example("good")})["controls"]
    assert request_for(stands).is_long
    assert not request_for(beginning(DESK, {})["controls"]).is_long


# Figures -------------------------------------------------------------------------------------------------------------


def trace(figure, name):
    return next(each for each in figure["data"] if each.get("name") == name)


def values(packed):
    return desk.coordinates(packed)


def test_held_positions_lie_where_the_sensor_repeated_itself(show, example):
    data = example("dirty")
    updates, rest = show(data=data)
    held = trace(updates[0], "Held")
    found = recorded(data, rest["controls"]["reading"])
    lines = [finding.line for finding in found.findings if finding.kind == "held"]
    assert len(values(held["x"])) == len(lines) == 23
    before = filled(found.positions)
    for x, line in zip(values(held["x"]), sorted(lines), strict=True):
        place = int(np.flatnonzero(found.lines == line)[0])
        assert np.isnan(found.positions[place]).all()
        assert x == pytest.approx(before[place, 0], rel=1e-6)


def test_more_held_positions_than_are_listed_are_all_marked(show):
    rows = "\n".join(f"{row},{row // 2},{-(row // 2)}" for row in range(3000))
    data = SHELF.keep(File("held.csv", f"t,x,y\n{rows}\n".encode()))
    updates, rest = show(data=data)
    found = recorded(data, rest["controls"]["reading"])
    assert len(found.findings) < 1500
    held = trace(updates[0], "Held")
    assert values(held["x"]) == pytest.approx(np.arange(1500.0))
    # A click on one chooses the sample that is the second of its kind.
    assert values(held["customdata"]) == pytest.approx(np.arange(1, 3000, 2))


def test_the_path_of_a_run_cut_short_has_no_marks_beyond_its_end(show, example):
    updates, _ = show({"samples": "50"}, data=example("dirty"))
    held = values(trace(updates[0], "Held")["x"])
    smoothed = values(trace(updates[0], "Smoothed")["x"])
    assert len(held) < 23
    assert held.max(initial=0) <= np.nanmax(smoothed) + 1000


def test_every_interval_between_rows_is_drawn(show, example):
    data = example("irregular")
    updates, rest = show(data=data)
    found = recorded(data, rest["controls"]["reading"])
    usual, gaps = (values(trace(updates[1], name)["y"]) for name in ("Interval", "Gap"))
    assert np.sort(np.concatenate((usual, gaps))) == pytest.approx(np.sort(np.diff(found.times)), rel=1e-6)
    assert len(gaps) == found.counts["gap"]


def test_what_the_gate_refuses_lies_above_it(show, example):
    data = example("dirty")
    updates, _ = show({"gate": "5", "noise_std": "12, 12, 4"}, data=data)
    figure = updates[2]
    assert figure["layout"]["yaxis"]["title"]["text"] == "innovation (σ)"
    assert trace(figure, "Innovation")["marker"]["color"] == tokens("light")[SCORES["innovation"]]
    assert trace(figure, "Gate")["y"] == [5, 5]
    assert values(trace(figure, "Not believed")["y"]).min() > 5
    gone = run_experiment(Experiment.from_dict({"data": data, "gate": 5, "noise_std": [12, 12, 4]})).track.rejected
    assert len(values(trace(figure, "Not believed")["x"])) == int(gone.sum()) > 5
    open_figure = show(data=data)[0][2]
    assert open_figure["layout"]["yaxis"]["title"]["text"] == "innovation (m)"
    gate = trace(open_figure, "Gate")
    assert (gate["x"], gate["y"], gate["showlegend"]) == ([], [], False)
    assert not trace(open_figure, "Not believed")["showlegend"]
    text = to_json(layout())
    assert "Innovation and gate" not in text


def test_a_change_of_the_gate_alone_moves_nothing_but_what_it_moves(show, example, request_for):
    """Every plot answers a patch, or the page would wait for ever."""
    stands = beginning(DESK, {"data": example("good")})["controls"]
    _, rest = answer(DESK, request_for(stands))
    updates, _ = answer(DESK, request_for(rest["controls"], {"xi": 0.3}, drawn=rest["drawn"]))
    for update in updates[: len(DESK.plots)]:
        assert update.to_plotly_json()["operations"]


def told(show, **query):
    """Rows of the tables of numbers, by caption and by name of the row."""
    tables = (cells(component) for component in show(want=[NUMBERS], **query)[0][-1])
    return {caption: {name: row for name, *row in rows} for caption, _, rows in tables}


def test_intervals_and_innovations_are_told_in_numbers(show, example):
    data = example("dirty")
    query = {"data": data, "gate": "5", "noise_std": "12,12,4"}
    tables = told(show, **query)
    _, rest = show(**query)
    found = recorded(data, rest["controls"]["reading"])
    steps = np.diff(found.times[found.lines > 0])
    intervals = tables["Intervals between rows"]
    assert intervals["Intervals"] == [f"{len(steps):,}"]
    assert intervals["Gaps, more than 1.5 times the usual"] == [str(found.counts["gap"])]
    assert intervals["Longest (s)"] == [significant(steps.max(), 5)]
    result = run_experiment(Experiment.from_dict({"data": data, "gate": 5, "noise_std": [12, 12, 4]}))
    for caption, values in (
        ("Innovations (m)", result.track.innovation),
        ("Innovations (σ)", result.track.innovation / result.track.spread),
    ):
        believed = np.column_stack([values, np.linalg.norm(values, axis=1)])[~result.track.rejected]
        rows = tables[caption]
        assert rows["Not believed"] == [str(result.track.rejected.sum())] * 4
        assert rows["Believed"] == [f"{count:,}" for count in np.isfinite(believed).sum(axis=0)]
        assert rows["Mean"] == [*(significant(mean, 5) for mean in np.nanmean(believed, axis=0)[:3]), "–"]
        sizes = np.abs(believed)
        assert rows["Greatest"] == [significant(size, 5) for size in np.nanmax(sizes, axis=0)]
        assert rows["Median size"] == [significant(size, 5) for size in np.nanmedian(sizes, axis=0)]
    assert "Innovations (σ)" not in told(show, data=data)


@pytest.mark.parametrize(
    ("gate", "said"),
    [
        ("", ""),
        # chi2.sf(gate^2, 3), to two digits.
        ("1", "Where errors are Gaussian with this σ, the gate refuses 80 % of the right measurements."),
        ("4", "Where errors are Gaussian with this σ, the gate refuses one right measurement in 880."),
        ("100", "Where errors are Gaussian with this σ, the gate refuses no right measurement."),
    ],
)
def test_how_often_the_gate_refuses_what_is_right_is_told(show, example, gate, said):
    _, rest = show(data=example("dirty"), noise_std="12,12,4", gate=gate)
    assert rest["texts"]["gate-text"] == said
    assert '"data-gate-text"' in to_json(layout())


# The suggestion ------------------------------------------------------------------------------------------------------


def study(**query):
    asked, show = suggesting.begin(StudyQuestion(seq=1, query=urlencode(query)))
    *_, last = asked.stream()
    return asked, show(last)


def test_the_suggestion_is_used_by_one_click(show, example):
    data = example("dirty")
    _, shown = study(data=data)
    controls = shown["offers"]["use"]["controls"]
    assert list(controls) == ["order", "design", "tracking_index", "start", "noise_std", "gate"]
    _, before = show(data=data)
    _, rest = show(controls, data=data)
    assert rest["ok"]
    for name, value in controls.items():
        assert str(rest["controls"][name]) == str(value)
    assert float(rest["cards"]["innovation_rmse"][0].split()[0]) < 0.1 * float(
        before["cards"]["innovation_rmse"][0].split()[0]
    )
    assert "σ_w" not in shown["texts"]["why"]
    assert [row[0] for row in shown["rows"]["estimates"]] == ["east", "north", "up"]


def test_the_same_recording_under_another_filter_is_the_same_study(example):
    data = example("good")
    first, _ = study(data=data)
    second, _ = study(data=data, design="kalata", order="2", tracking_index="0.3", gate="4")
    assert first == second
    assert hash(first) == hash(second)
    fewer, _ = study(data=data, samples="200")
    assert fewer != first


def test_a_clean_recording_needs_no_gate(example):
    _, shown = study(data=example("good"))
    assert shown["offers"]["use"]["controls"]["gate"] == ""


def test_without_a_recording_there_is_nothing_to_suggest():
    with pytest.raises(InputError, match="needs a recording"):
        suggesting.begin(StudyQuestion(seq=1, query=""))


def test_too_few_measurements_are_refused(example):
    data = SHELF.keep(File("few.csv", b"t,x\n" + b"".join(b"%d,%d\n" % (row, row) for row in range(6))))
    asked, _ = suggesting.begin(StudyQuestion(seq=1, query=urlencode({"data": data})))
    with pytest.raises(InputError):
        list(asked.stream())
