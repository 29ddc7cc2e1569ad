"""Tune and Compare on recordings: what can be asked for, what is said of the rest, and no plot without a word."""

from dataclasses import replace
from urllib.parse import parse_qsl

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs

from layouts.desk import answer, beginning, live_answer
from layouts.figures.common import coordinates
from layouts.figures.comparison import errors_of
from layouts.pages.compare import study as compare_study
from layouts.pages.compare.answers import DESK as COMPARE
from layouts.pages.compare.answers import NEEDS_TRUTH, ONE_RUN, OWN_GATES
from layouts.pages.tune import content as tune_content
from layouts.pages.tune.answers import DESK as TUNE
from layouts.pages.tune.content import PLOT
from layouts.questions import Question, StudyQuestion
from layouts.run_cards import UNDIRECTED
from layouts.state import Settings, from_query, to_query
from layouts.tuning import STUDIES
from tracker_core import METRICS, InputError, run_experiment
from tracker_core.innovations import EVIDENCE
from tracker_core.measured import SHELF, File
from tracker_core.tuning import OBJECTIVES

SAMPLES = 120
FEW = {"points": 5, "cells": 6, "budget": 2000}
INNOVATIONS = [name for name in OBJECTIVES if name.startswith("innovation")]
BLIND = ["constant", "varying", "one"]
NAMES = [*BLIND, "known", "partly"]


def lines(times, *columns):
    rows = zip(times, *columns, strict=True)
    return "\n".join(",".join("" if value != value else repr(float(value)) for value in row) for row in rows)


@pytest.fixture(scope="module")
def files():
    """With and without a truth, at a constant interval and at others; one axis alone; a truth that is known in part."""
    draw, times = np.random.default_rng(3), np.arange(float(SAMPLES))
    odd = np.cumsum(draw.uniform(0.3, 2, SAMPLES))
    true = np.stack([12 * times, 300 * np.cos(times / 20)])
    seen = true + draw.normal(0, 2, true.shape)
    seen[0, 60] += 500
    seen[:, 80:83] = np.nan
    partly = true.copy()
    partly[:, 30:] = np.nan
    contents = {
        "constant": "t,x,y\n" + lines(times, *seen),
        "varying": "t,x,y\n" + lines(odd, *seen),
        "known": "t,x,y,x_true,y_true\n" + lines(times, *seen, *true),
        "partly": "t,x,y,x_true,y_true\n" + lines(odd, *seen, *partly),
        "one": "t,x\n" + lines(times, seen[1]),
    }
    return {name: SHELF.keep(File(f"{name} <b>&.csv", text.encode())) for name, text in contents.items()}


def ask(desk, query, changed=None, pins=()):
    """The answer to a page that a link has opened, with everything wanted, after a change of its controls."""
    start = beginning(desk, dict(parse_qsl(query)))
    controls = start["controls"] | (changed or {})
    pins = [*map(tuple, start["pins"]), *pins]
    question = Question(seq=1, controls=controls, changed=list(changed or ()), want=list(desk.plots), pins=pins)
    updates, rest = answer(desk, question)
    assert rest["ok"], rest["errors"]
    return dict(zip(desk.plots, updates, strict=False)), rest


def studied(query, **more):
    """What the Tune page shows of a study once it is done."""
    link = "&".join([query, *(f"{name}={value}" for name, value in (FEW | more).items())])
    study, content = tune_content.begin(StudyQuestion(seq=1, query=link))
    *_, progress = study.stream()
    return study, content(progress)


def numbers(figure):
    return [coordinates(trace[axis]) for trace in figure["data"] if "x" in trace for axis in ("x", "y")]


# Tune ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_only_what_can_be_known_can_be_tuned_for(name, files):
    figures, rest = ask(TUNE, f"data={files[name]}&xi=0.6")
    blind = name in BLIND
    assert rest["blind"] == blind
    wanted = INNOVATIONS if blind else [each for each in OBJECTIVES if each != "noise_lag"]
    assert rest["offers"]["tune_for"] == wanted
    assert rest["controls"]["tune_for"] == ("innovation_rmse" if blind else "estimation_rmse")
    assert rest["controls"]["without_truth"] == ("on" if blind else "off")
    # There is one run.
    assert not rest["fields"]["tune_runs"]
    # What goes without saying of this target does not stand in the link.
    assert not {"tune_for", "without_truth"} & set(dict(parse_qsl(rest["link"])))
    assert any(np.isfinite(part).any() for part in numbers(figures["tune-error"]))


def test_the_truth_cannot_be_switched_back_on_where_nobody_knows_it(files):
    _, rest = ask(TUNE, f"data={files['varying']}&tune_for=tracking_max")
    assert rest["controls"]["tune_for"] == "innovation_max"
    assert dict(parse_qsl(rest["link"]))["tune_for"] == "innovation_max"
    _, rest = ask(TUNE, rest["link"], {"without_truth": "off"})
    assert rest["controls"]["without_truth"] == "on"
    assert OBJECTIVES[rest["controls"]["tune_for"]].kind == "innovation"
    assert from_query(dict(parse_qsl(rest["link"])))[1] == []


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=30)
@given(other=st.from_type(Settings))
def test_whatever_is_asked_for_a_link_keeps_what_is_meant_here(name, other, files):
    """Anything that was asked of another target: what does not fit here is left out, and then a link keeps it all."""
    present, _ = from_query({"data": files[name], "order": "2", "xi": "0.6"})
    view = replace(
        present.view,
        tuning=other.view.tuning.fitted(present.experiment),
        comparing=other.view.comparing.fitted(present.experiment),
    )
    asked = replace(present, view=view)
    back, notes = from_query(dict(parse_qsl(to_query(asked))))
    assert notes == []
    assert back == asked
    if name in BLIND:
        assert OBJECTIVES[back.view.tuning.objective].kind == back.view.comparing.compared == "innovation"


def test_a_recorded_truth_can_be_tuned_for_or_not(files):
    _, rest = ask(TUNE, f"data={files['known']}", {"without_truth": "on"})
    assert rest["controls"]["tune_for"] == "innovation_rmse"
    assert not rest["blind"]
    study, shown = studied(rest["link"])
    assert study.objectives == ("innovation_rmse", "estimation_rmse")
    assert "Tuned on the truth it would be" in shown["texts"]["cost"]


@pytest.mark.parametrize(
    ("query", "said", "unsaid"),
    [
        (
            "data={constant}",
            ["Nobody knows where", "One recording: there is no second run"],
            ["intervals vary", "gate"],
        ),
        ("data={varying}", ["Nobody knows where", "One recording", "The intervals vary"], ["gate"]),
        ("data={known}", ["One recording"], ["Nobody", "known at", "intervals vary"]),
        ("data={partly}", ["The truth is known at 30 of 120 samples", "The intervals vary"], ["Nobody"]),
        ("data={known}&gate=4", ["What the present filter's gate refuses is left out for all"], []),
        ("gate=4", ["What the present filter's gate refuses is left out for all"], ["One recording", "Every seed"]),
        ("noise=none", ["Every seed gives the same run"], ["One recording"]),
    ],
)
def test_what_a_study_is_made_of_is_said(query, said, unsaid, files):
    _, rest = ask(TUNE, query.format(**files))
    for sentence in said:
        assert sentence in rest["texts"]["data-note"]
    for words in unsaid:
        assert words not in rest["texts"]["data-note"]


def test_usually_there_is_nothing_to_be_said():
    _, rest = ask(TUNE, "")
    assert rest["texts"]["data-note"] == ""
    assert not rest["blind"]


@pytest.mark.parametrize("kind", STUDIES)
@pytest.mark.parametrize("name", NAMES)
def test_every_study_runs_on_a_recording(name, kind, files):
    study, shown = studied(f"data={files[name]}&order=2&xi=0.6", tune=kind)
    figure = shown["figures"][PLOT]
    assert any(np.isfinite(part).any() for part in numbers(figure) if part.size)
    best = shown["texts"]["best"]
    assert best.startswith("Best")
    # One run has no interval, and nothing is called better than chance.
    assert "95 %" not in best
    assert "shown to be" not in best
    assert "fresh run" not in best
    if kind != "search":
        assert shown["texts"]["runs"] == "1 run"
        # Of the present filter it is said how much more or less the best one has.
        assert "than with the present gains" in best or "the present filter: the best one has" in best
    assert shown["texts"]["cost"] == ""
    assert shown["offers"]["use"]["controls"]
    # The best gains are at least as good as the present ones, in the present run.
    present, _ = from_query({"data": files[name], "order": "2", "xi": "0.6"})
    assert study.objective == ("innovation_rmse" if name in BLIND else "estimation_rmse")
    if kind == "search":
        rows = shown["rows"]["rivals"]
        assert rows[0][0] == "Found"
        assert rows[-1][0] == "Present"
        result = run_experiment(present.experiment)
        own = result.evidence().rmse if name in BLIND else result.metrics.estimation_rmse
        assert float(rows[-1][2].replace(",", "")) == pytest.approx(own, rel=1e-3)
        assert all(row[3] == "" for row in rows)
        assert all(float(row[4][0].replace("−", "-")) >= 0 and row[4][1] == "" for row in rows[1:])


def test_a_gate_makes_a_study_one_of_the_present_filter(files):
    def study(xi, gate, kind="sweep"):
        query = f"data={files['known']}&order=2&xi={xi}&tune={kind}{gate}"
        return tune_content.begin(StudyQuestion(seq=1, query=query))[0]

    for kind in STUDIES:
        assert study(0.6, "", kind) == study(0.7, "", kind)
        assert study(0.6, "&gate=4", kind) != study(0.7, "&gate=4", kind)
        present, _ = from_query({"data": files["known"], "order": "2", "xi": "0.6", "gate": "4"})
        kept = study(0.6, "&gate=4", kind).experiment
        np.testing.assert_allclose(kept.gains().vector, present.experiment.gains().vector, rtol=1e-12)


def test_what_nobody_knows_of_a_drawn_target_is_refused_beside_its_field():
    with pytest.raises(InputError, match="^tune_for must not need the jerk of the target: nobody knows it"):
        tune_content.begin(
            StudyQuestion(seq=1, query="scenario=singer&order=3&xi=0.6&tune_for=noise_lag", theme="light")
        )


# Compare ------------------------------------------------------------------------------------------------------------

PINS = "&pin1=manual,alpha:0.5,beta:0.2&pin2=fading-memory,order:2,xi:0.8,gate:5&pin3=moving-window"


@pytest.mark.parametrize("name", NAMES)
def test_filters_are_compared_by_what_is_known(name, files):
    _, rest = ask(COMPARE, f"data={files[name]}&order=2&xi=0.6{PINS}")
    rows = {row[0]: row[1:] for row in rest["rows"]["metrics"]}
    blind = name in BLIND
    told = EVIDENCE | METRICS if blind else METRICS
    assert set(rows) == {metric.title for metric in told.values()}
    dashes = [all(cell[0] == "–" for cell in cells[:3]) for cells in rows.values()]
    # What is known comes first where there is little of it, and a dash needs no difference.
    assert dashes == sorted(dashes) or not blind
    assert {cell[2] for cells, gone in zip(rows.values(), dashes, strict=True) if gone for cell in cells} <= {""}
    assert (NEEDS_TRUTH in rest["texts"]["counted"]) == blind
    assert OWN_GATES in rest["texts"]["counted"]
    ran = [number for number, each in enumerate(rest["filters"]) if not each["problem"]]
    assert ran[:3] == [0, 1, 2]
    for number in ran:
        known = {title for title, cells in rows.items() if cells[number][0] != "–"}
        if blind:
            assert (
                not {metric.title for key, metric in METRICS.items() if key.startswith(("tra", "est", "obs"))} & known
            )
            assert {EVIDENCE[key].title for key in ("innovation_rmse", "innovation_bias", "smoothness")} <= known
        else:
            assert {METRICS["estimation_rmse"].title, METRICS["noise_reduction"].title} <= known
    present, _ = from_query({"data": files[name], "order": "2", "xi": "0.6"})
    result = run_experiment(present.experiment)
    own = result.evidence().rmse if blind else result.metrics.estimation_rmse
    title = "Innovation RMSE" if blind else "Estimation RMSE"
    assert float(rows[title][0][0].split()[0].replace(",", "")) == pytest.approx(own, rel=1e-3)
    if blind:
        assert {cells[1][1] for key in UNDIRECTED for cells in [rows[EVIDENCE[key].title]]} == {"same"}


@pytest.mark.parametrize("name", NAMES)
def test_one_recording_is_not_compared_over_seeds(name, files):
    _, rest = ask(COMPARE, f"data={files[name]}&order=2&xi=0.6{PINS}")
    assert rest["texts"]["chance"] == ONE_RUN
    assert not rest["fields"]["over-seeds"]
    assert not rest["fields"]["figure"]
    assert "seed" not in rest["texts"]["data"]
    with pytest.raises(InputError, match="^runs must not be asked for of a recording") as caught:
        compare_study.begin(StudyQuestion(seq=1, query=rest["link"]))
    # Where its message stands is hidden with the rest of the study.
    assert caught.value.field == "runs"
    _, rest = ask(COMPARE, "")
    assert rest["texts"]["chance"] == ""
    assert rest["fields"]["over-seeds"]
    assert rest["fields"]["figure"]


@pytest.mark.parametrize("name", NAMES)
def test_every_plot_shows_something(name, files):
    figures, rest = ask(COMPARE, f"data={files[name]}&order=2&xi=0.6{PINS}")
    present = {"compare-path": 2, "compare-close-up": 2, "compare-error": 1, "compare-gains": 0}
    for plot, figure in figures.items():
        lines_of = [
            figure["data"][present[plot]],
            *(part for part in figure["data"] if "Manual" in part.get("name", "")),
        ]
        assert len(lines_of) > 1
        for part in lines_of[:2]:
            assert np.isfinite(coordinates(part["x"])).any()
            assert np.isfinite(coordinates(part["y"])).any()
        for axis in ("xaxis", "yaxis"):
            assert np.isfinite(figure["layout"][axis].get("range", [0.0])).all()
    path, error, blind = figures["compare-path"], figures["compare-error"], name in BLIND
    assert path["data"][0]["showlegend"] != blind
    assert error["layout"]["yaxis"]["title"]["text"].startswith(
        "measured to predicted" if blind else "smoothed to true"
    )
    assert rest["offers"]["compared"] == (["innovation"] if blind else ["tracking", "estimation", "innovation"])
    assert rest["controls"]["compared"] == ("innovation" if blind else "estimation")
    assert "compared" not in rest["link"]
    assert rest["texts"]["error-title"] == ("Innovation" if blind else "Error")


def test_pinned_filters_have_their_own_gate(files):
    _, rest = ask(COMPARE, f"data={files['known']}&order=2&xi=0.6&gate=5&pin1=fading-memory,order:2,xi:0.8,gate:5")
    assert rest["texts"]["counted"] == ""
    _, rest = ask(COMPARE, f"data={files['constant']}&order=2&xi=0.6{PINS}")
    designs = [each["design"] for each in rest["filters"]]
    assert [("gate 5 σ" in said) for said in designs] == [False, False, True, False]


def test_refused_innovations_are_no_errors(files):
    present, _ = from_query({"data": files["constant"], "order": "2", "xi": "0.6"})
    result = run_experiment(present.experiment)
    sizes = errors_of(result, "innovation")
    assert np.isfinite(sizes[60])
    gone = np.zeros(SAMPLES, dtype=bool)
    gone[60] = True
    refused = errors_of(replace(result, track=replace(result.track, rejected=gone)), "innovation")
    np.testing.assert_array_equal(refused[~gone], sizes[~gone])
    assert np.isnan(refused[60])


@pytest.mark.parametrize("desk", [TUNE, COMPARE], ids=["tune", "compare"])
@pytest.mark.parametrize("name", NAMES)
def test_a_slider_moves_on_a_recording(name, desk, files):
    controls = beginning(desk, {"data": files[name], "order": "2", "xi": "0.6"})["controls"]
    question = Question(seq=1, controls=controls, want=list(desk.plots))
    _, rest = answer(desk, question)
    moved = structs.replace(question, controls=controls | {"xi": 0.7}, changed=["xi"], drawn=rest["drawn"])
    live, arrays = live_answer(desk, moved)
    assert live["ok"], live["errors"]
    assert set(live["lines"]) == set(desk.plots)
    assert any(np.isfinite(part).any() for part in arrays)
