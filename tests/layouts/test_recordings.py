"""The pages on a recording: what they show where nobody knows the truth, and links whose file is gone."""

import re
from urllib.parse import parse_qsl

import numpy as np
import pytest

from layouts.desk import answer, beginning, live_answer
from layouts.figures.common import coordinates
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pages.track.answers import DESK as TRACK
from layouts.pages.track.answers import picture
from layouts.pages.tune.answers import DESK as TUNE
from layouts.questions import Question
from layouts.run_cards import CARDS, EVIDENCE_CARDS
from layouts.shown import Shown
from layouts.state import from_query
from tracker_core import run_experiment
from tracker_core.measured import SHELF, File

DESKS = {desk.page: desk for desk in (EXPLORE, STABILITY, TRACK)}
LOST = "0123456789abcdef" * 2


def lines(times, *columns):
    return "\n".join(
        ",".join("" if v != v else repr(float(v)) for v in row) for row in zip(times, *columns, strict=True)
    )


@pytest.fixture(scope="module")
def files():
    """A constant interval with an outlier and a gap, varying intervals, and a constant one with the truth beside it."""
    draw, times = np.random.default_rng(3), np.arange(120.0)
    odd = np.cumsum(draw.uniform(0.3, 2, 120))
    true = np.stack([12 * times, 300 * np.cos(times / 20)])
    seen = true + draw.normal(0, 2, true.shape)
    dirty = seen.copy()
    dirty[0, 60] += 500
    dirty[:, 80:83] = np.nan
    contents = {
        "constant": "t,x,y\n" + lines(times, *dirty),
        "varying": "t,x,y\n" + lines(odd, *seen),
        "known": "t,x,y,x_true,y_true\n" + lines(times, *seen, *true),
        "one": "t,x\n" + lines(times, seen[1]),
    }
    return {name: SHELF.keep(File(f"{name} <b>&.csv", text.encode())) for name, text in contents.items()}


def ask(desk, query, changed=None, **more):
    """The answer to a page that a link has opened, with everything wanted, after a change of its controls."""
    controls = beginning(desk, dict(parse_qsl(query)))["controls"] | (changed or {})
    wanted = [*desk.plots, *desk.tables]
    return answer(desk, Question(seq=1, controls=controls, changed=list(changed or ()), want=wanted, **more))


@pytest.mark.parametrize("name", ["constant", "varying", "known", "one"])
@pytest.mark.parametrize("page", DESKS)
def test_every_page_shows_a_recording(page, name, files):
    updates, rest = ask(DESKS[page], f"data={files[name]}&xi=0.6")
    assert rest["ok"], rest["errors"]
    for plot, figure in zip(DESKS[page].plots, updates, strict=False):
        if plot == "explore-gains":
            # Constant gains have no course.
            continue
        numbers = [coordinates(trace[axis]) for trace in figure["data"] if "x" in trace for axis in ("x", "y")]
        assert any(np.isfinite(part).any() for part in numbers)
        for axis in ("xaxis", "yaxis"):
            assert np.isfinite(figure["layout"][axis].get("range", [0.0])).all()
    settings, notes = from_query(dict(parse_qsl(rest["link"])))
    assert settings.experiment.data == files[name]
    assert notes == []


@pytest.mark.parametrize(("name", "known"), [("constant", False), ("varying", False), ("known", True)])
def test_the_cards_are_those_that_can_be_known(name, known, files):
    _, rest = ask(EXPLORE, f"data={files[name]}&xi=0.6")
    assert set(rest["cards"]) == set(CARDS if known else EVIDENCE_CARDS)
    shown = {title for title, (value, _, _) in rest["cards"].items() if value != "–"}
    # Of a recorded truth nobody knows the derivative that the lag follows.
    assert shown == set(CARDS) - {"lag"} if known else set(EVIDENCE_CARDS)
    assert rest["fields"]["with-truth"] == known
    assert rest["fields"]["without-truth"] != known
    assert rest["fields"]["exaggerate"] == known


def test_nothing_is_drawn_for_a_recording(files):
    _, rest = ask(EXPLORE, f"data={files['constant']}")
    assert not any(rest["fields"][name] for name in ("seed", "noise", "manoeuvre", "interval"))
    assert rest["offers"]["start"] == ["first", "two-point", "three-point", "expanding"]
    _, rest = ask(EXPLORE, "")
    assert all(rest["fields"][name] for name in ("seed", "noise", "manoeuvre", "interval"))
    assert "known" in rest["offers"]["start"]


def test_varying_intervals_are_said(files):
    for name, said in (("constant", False), ("varying", True)):
        _, rest = ask(STABILITY, f"data={files[name]}&xi=0.6")
        assert ("here it varies" in rest["texts"]["status"]) == said
        assert ("at intervals that vary" in rest["texts"]["description"]) == said


def test_what_the_gate_refuses_is_crossed_out(files):
    def crosses(query):
        updates, rest = ask(EXPLORE, query)
        assert rest["ok"], rest["errors"]
        return {
            name: len(coordinates(part["x"]))
            for name, figure in zip(EXPLORE.plots, updates, strict=False)
            for part in figure["data"]
            if part.get("name") == "Not believed"
        }

    without = crosses(f"data={files['constant']}&xi=0.6&at=61")
    assert set(without.values()) == {0}
    assert set(without) == {"explore-path", "explore-close-up", "explore-time", "explore-error"}
    assert set(crosses(f"data={files['constant']}&xi=0.6&at=61&gate=6").values()) == {1}


@pytest.mark.parametrize(("gate", "refused"), [("", False), ("&gate=6", True)])
def test_the_scene_shows_what_the_gate_refuses(files, gate, refused):
    _, rest = ask(TRACK, f"data={files['constant']}&xi=0.6{gate}")
    assert rest["fields"]["refused"] == refused
    settings, _ = from_query(dict(parse_qsl(rest["link"])))
    result = run_experiment(settings.experiment)
    drawing = picture(Shown(result, settings, "light", {})).thinned()
    assert drawing.refused_times.tolist() == ([60.0] if refused else [])
    np.testing.assert_array_equal(drawing.refused, result.measurements.positions[60:61][: int(refused)])


def test_errors_are_called_what_they_are(files):
    titles = {"explore": "{}", "track": "{}", "tune": "The present filter's {}"}
    for name, word in (("constant", "Residual"), ("known", "Error")):
        for desk in (EXPLORE, TRACK, TUNE):
            updates, rest = ask(desk, f"data={files[name]}&xi=0.6")
            said = titles[desk.page].format(word if desk.page != "tune" else word.lower())
            assert rest["texts"]["error-title"] == said
            figure = dict(zip(desk.plots, updates, strict=False))[f"{desk.page}-error"]
            away = "truth" if word == "Error" else "measurement"
            assert figure["layout"]["yaxis"]["title"]["text"] == f"distance to the {away} (m)"


def test_crosses_follow_a_slider(files):
    controls = beginning(EXPLORE, {"data": files["constant"], "xi": "0.6", "gate": "6"})["controls"]
    _, rest = answer(EXPLORE, Question(seq=1, controls=controls))
    moved = Question(
        seq=2, controls=controls | {"xi": 0.7}, changed=["xi"], drawn=rest["drawn"], want=list(EXPLORE.plots)
    )
    live, _ = live_answer(EXPLORE, moved)
    assert [6, 1] in live["lines"]["explore-path"]


def test_another_file_is_another_target(files):
    _, rest = ask(EXPLORE, "xi=0.6&seed=5&samples=50&at=7", {"data": files["constant"]})
    assert rest["ok"], rest["errors"]
    controls = rest["controls"]
    assert (controls["scenario"], controls["samples"], controls["noise"]) == ("recording", 120, "recorded")
    assert controls["xi"] == 0.6
    assert controls["at"] == 61
    # And back, and forth again: the recording is still in the menu's hand.
    for scenario in ("jeong-ship", "recording"):
        question = Question(seq=2, controls=controls | {"scenario": scenario}, changed=["scenario"])
        _, rest = answer(EXPLORE, question)
        assert rest["ok"], rest["errors"]
        controls = rest["controls"]
        assert controls["data"] == files["constant"]
    assert f"data={files['constant']}" in rest["link"]


def test_another_reading_is_another_target(files):
    _, rest = ask(EXPLORE, f"data={files['constant']}&xi=0.6", {"reading": "at:3"})
    assert rest["ok"], rest["errors"]
    assert rest["offers"]["axis"] == ["x"]
    assert "reading=at:3" in rest["link"]
    _, rest = ask(EXPLORE, rest["link"], {"data": files["known"]})
    assert rest["offers"]["axis"] == ["x", "y"]


@pytest.mark.parametrize(
    ("changed", "field"),
    [
        ({"data": LOST}, "data"),
        ({"scenario": "recording"}, "data"),
        ({"reading": "time:1,at:2.99"}, "reading"),
        ({"gate": "soon"}, "gate"),
        ({"gate": "0.1"}, "gate"),
    ],
    ids=str,
)
def test_what_is_wrong_is_said_beside_its_field(changed, field, files):
    query = f"data={files['constant']}" if field in {"reading", "gate"} else ""
    _, rest = ask(EXPLORE, query, changed)
    assert not rest["ok"]
    assert list(rest["errors"]) == [field]


def test_a_method_has_no_gate(files):
    _, rest = ask(EXPLORE, f"data={files['constant']}&gate=4", {"design": "parallel-bank-causal"})
    assert rest["ok"], rest["errors"]
    assert rest["controls"]["gate"] == ""
    assert "outlier gate" in rest["note"]


def test_a_link_without_its_file_says_so():
    start = beginning(EXPLORE, {"data": LOST, "reading": "time:1", "samples": "70", "xi": "0.7", "gate": "5"})
    assert start["missing"] == LOST
    assert start["controls"]["scenario"] == "jeong-ship"
    assert (start["controls"]["xi"], start["controls"]["gate"]) == (0.7, 5)
    assert len(start["notes"]) == 1
    assert "load the file again" in start["notes"][0]
    assert beginning(EXPLORE, {"data": "<b>"})["missing"] == ""
    assert beginning(EXPLORE, {})["missing"] == ""


def test_a_link_whose_reading_fits_no_more_is_read_as_proposed(files):
    start = beginning(EXPLORE, {"data": files["constant"], "reading": "time:1,at:9", "xi": "0.7"})
    assert start["missing"] == ""
    assert start["controls"]["data"] == files["constant"]
    assert len(start["notes"]) == 1
    assert "reading" in start["notes"][0]


def test_the_scene_takes_a_run_without_a_truth(files):
    for name in ("constant", "varying", "one", "known"):
        settings, _ = from_query({"data": files[name], "xi": "0.6"})
        result = run_experiment(settings.experiment)
        seen = picture(Shown(result, settings, "light", {}))
        assert np.isnan(seen.truth).all() == (name != "known")
        assert seen.thinned().series["observed"].shape == (120, 1 if name == "one" else 2)


def test_a_gate_that_refuses_right_measurements_is_told(files):
    _, rest = ask(EXPLORE, "scenario=jeong-ship&xi=0.8&gate=4")
    assert rest["tone"] == "bad"
    assert re.search(r"The gate refuses \d+ % of the samples", rest["texts"]["status"])
    _, rest = ask(EXPLORE, f"data={files['constant']}&xi=0.6&gate=6")
    assert (rest["tone"], "refuses" in rest["texts"]["status"]) == ("good", False)
