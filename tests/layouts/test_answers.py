"""What Explore is sent beside its figures, most of it as on every page: verdict, cards, menus, texts, tables."""

import math
import re
from urllib.parse import parse_qsl

import numpy as np
import pytest
from dash import no_update
from dash.development.base_component import Component

from layouts.desk import answer
from layouts.pages.explore.answers import DESK, NUMBERS
from layouts.readouts import formula_text, offers, owned
from layouts.run_cards import CARDS
from layouts.state import View, from_query
from layouts.text import change_text, metric_text, significant
from tests.tables import cells
from tracker_core import DESIGNS, METRICS, SCENARIOS, Experiment, run_experiment
from tracker_core.fields import FIELDS

WILD = {"design": "manual", "order": 2, "alpha": 1.9, "beta": 1.5, "gamma": 1.0, "eta": 0.1}


def read(link):
    """The experiment of a link."""
    return from_query(dict(parse_qsl(link)))[0].experiment


def ask(request_for, controls, moved=None, **more):
    """The plots of an answer by name, and the rest of it."""
    updates, rest = answer(DESK, request_for(controls, moved, **more))
    return dict(zip(DESK.plots, updates[:-1], strict=True)), rest


# Verdict, cards, pin -----------------------------------------------------------------------------------------------


STOPPED = "The run stopped at sample 41: a position passed 1e+12 m."


@pytest.mark.parametrize(
    ("gains", "text"),
    [
        ({"order": 2, "alpha": 1.9, "beta": 1.5},
         f"Unstable: 4 − 2α − β > 0 fails by 1.30 (normalised gains). {STOPPED}"),
        ({"order": 2, "alpha": -0.5, "beta": 0.1, "samples": 5}, "Unstable: α > 0 fails by 0.500 (normalised gains)."),
        ({"order": 2, "alpha": 2.5, "beta": -1.5, "samples": 5},
         "Unstable: 2 − α > 0 fails by 0.500, β > 0 fails by 1.50 (normalised gains)."),
        ({"order": 2, "alpha": 1, "beta": 2, "samples": 5}, "Unstable: 4 − 2α − β > 0 fails by 0 (normalised gains)."),
        ({"order": 3, "alpha": 0.5, "beta": 0.1, "gamma": 0.2, "samples": 5},
         "Unstable: 2αβ − γ(2 − α) > 0 fails by 0.200 (normalised gains)."),
        # Written as 2γ/T², γ = 0.1 is the same filter.
        ({"order": 3, "alpha": 0.5, "beta": 0.1, "gamma": 0.1, "convention": "taylor", "samples": 5},
         "Unstable: 2αβ − γ(2 − α) > 0 fails by 0.200 (normalised gains)."),
        ({"order": 4, "alpha": 0.5, "beta": 0.1, "gamma": 0.02, "eta": -0.25, "samples": 5},
         "Unstable: η > 0 fails by 0.250 (normalised gains)."),
    ],
)  # fmt: skip
def test_unstable_gains_are_told_by_the_inequality_that_fails(controls_for, request_for, gains, text):
    _, rest = ask(request_for, controls_for(design="manual", **gains))
    assert rest["tone"] == "bad"
    assert rest["texts"]["status"] == text


@pytest.mark.parametrize("order", [2, 3, 4])
def test_the_sample_where_the_run_stopped_is_the_first_beyond_the_limit(controls_for, request_for, order):
    controls = controls_for(
        **{k: v for k, v in WILD.items() if k not in ["gamma", "eta"][order - 2 :]} | {"order": order}
    )
    _, rest = ask(request_for, controls)
    result = run_experiment(read(rest["link"]))
    stop = int(re.search(r"stopped at sample ([\d,]+)", rest["texts"]["status"])[1].replace(",", ""))
    beyond = np.abs(result.track.smoothed[:, :, 0]).max(axis=1) > 1e12
    assert beyond[stop - 1]
    assert not beyond[: stop - 1].any()
    assert rest["cards"] == {name: ["–", "", ""] for name in CARDS}


def test_a_stable_run_that_leaves_the_world_is_told_too(controls_for, request_for):
    """The target itself passes the limit."""
    controls = controls_for(scenario="constant-acceleration", interval=1e6, samples=300)
    _, rest = ask(request_for, controls)
    assert rest["tone"] == "bad"
    assert rest["texts"]["status"].startswith("Stable: the largest pole has magnitude ")
    assert "The run stopped at sample " in rest["texts"]["status"]
    assert rest["cards"]["estimation_rmse"] == ["–", "", ""]


@pytest.mark.parametrize(
    ("xi", "text"),
    [
        (0, "Stable: the largest pole has magnitude 0."),
        (0.64, "Stable: the largest pole has magnitude 0.640."),
        (0.995, "Stable: the largest pole has magnitude 0.995."),
    ],
)
@pytest.mark.parametrize("order", [2, 3])
def test_a_stable_filter_is_told_by_its_largest_pole(controls_for, request_for, order, xi, text):
    _, rest = ask(request_for, controls_for(design="fading-memory", order=order, xi=xi))
    assert (rest["tone"], rest["texts"]["status"]) == ("good", text)


@pytest.mark.parametrize("xi", [0.99, 0.9999])
def test_the_pole_that_is_shown_is_the_pole(controls_for, request_for, xi):
    _, rest = ask(request_for, controls_for(design="fading-memory", order=4, xi=xi))
    if xi > 0.999:
        assert rest["texts"]["status"] == "Stable, barely: the largest pole is within 0.001 of the unit circle."
    else:
        assert float(rest["texts"]["status"].split()[-1].rstrip(".")) == pytest.approx(xi, abs=5e-4)


def test_the_cards_are_the_metrics_of_the_run(controls_for, request_for):
    _, rest = ask(request_for, controls_for())
    metrics = run_experiment(Experiment.from_dict({})).metrics.to_dict()
    assert rest["cards"] == {name: [metric_text(METRICS[name], metrics[name]), "", ""] for name in CARDS}
    assert set(CARDS) <= set(METRICS)
    assert rest["pins"] == []
    assert rest["texts"]["since"] == ""


def test_an_unstable_filter_that_was_not_stopped_has_no_lag(controls_for, request_for):
    _, rest = ask(request_for, controls_for(design="manual", order=2, alpha=1.9, beta=0.5, samples=5))
    assert rest["cards"]["lag"] == ["–", "", ""]
    assert rest["cards"]["tracking_rmse"][0] != "–"


@pytest.mark.parametrize("moved", [{"xi": 0.3}, {"xi": 0.9}, {"order": 4}, {"design": "gray-murray"}])
def test_cards_show_the_change_since_the_last_pin(controls_for, request_for, moved):
    pins = [[1, "kalata,tracking_index:3"], [3, "fading-memory,xi:0.64,name:A & B"]]
    _, rest = ask(request_for, controls_for(), moved, pins=pins)
    now, then = (run_experiment(e).metrics.to_dict() for e in (read(rest["link"]), Experiment.from_dict({})))
    assert rest["pins"] == [[1, "kalata,tracking_index:3.0"], [3, "fading-memory,xi:0.64,name:A & B"]]
    assert rest["texts"]["since"] == "since A & B"
    for name, (value, change, tone) in rest["cards"].items():
        assert value == metric_text(METRICS[name], now[name])
        assert (change, tone) == change_text(METRICS[name], now[name], then[name])
        assert float(change.split()[0].replace("−", "-").replace(",", "")) == pytest.approx(
            now[name] - then[name], rel=0.051, abs=1e-9
        )
        improved = (now[name] < then[name]) == METRICS[name].lower_is_better
        assert tone == ("better" if improved else "worse")


def test_nothing_changed_since_the_pin(controls_for, request_for):
    _, rest = ask(request_for, controls_for(), pinning=[["add"]])
    assert {tuple(card[1:]) for card in rest["cards"].values()} == {("no change", "same")}
    assert rest["link"] == "pin1=fading-memory,xi:0.64"


def test_a_pin_runs_on_the_present_target_and_sensor(controls_for, request_for):
    controls = controls_for(scenario="garg-accelerating", noise="white", seed=4)
    _, rest = ask(request_for, controls, pins=[[1, "fading-memory,xi:0.5"]])
    present = read(rest["link"])
    now, then = (run_experiment(e).metrics for e in (present, present.with_filter({"xi": 0.5})))
    assert then.lag != run_experiment(Experiment.from_dict({"xi": 0.5})).metrics.lag
    assert rest["cards"]["lag"][1:] == list(change_text(METRICS["lag"], now.lag, then.lag))


def test_a_pin_that_was_stopped_is_compared_with_nothing(controls_for, request_for):
    _, rest = ask(request_for, controls_for(), pins=[[1, "manual,alpha:1.9,beta:1.5"]])
    assert {tuple(card[1:]) for card in rest["cards"].values()} == {("", "")}


def test_a_pin_that_does_not_fit_stays_and_says_why(controls_for, request_for):
    pins = [[1, "fading-memory,xi:0.5"], [2, "moving-window,window:500"]]
    _, rest = ask(request_for, controls_for(samples=100), pins=pins)
    assert {tuple(card[1:]) for card in rest["cards"].values()} == {("", "")}
    assert rest["pins"] == pins
    said = rest["texts"]["since"]
    assert said.startswith("Moving window (M4) W 500: Window must be ")
    assert said.endswith("got “500”.")


# The other readouts ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("values", "link"),
    [
        ({}, ""),
        ({"seed": 3}, "seed=3"),
        ({"scenario": "garg-accelerating", "seed": 3}, "scenario=garg-accelerating&seed=3"),
    ],
)
def test_the_link_is_that_of_the_settings(controls_for, request_for, values, link):
    _, rest = ask(request_for, controls_for(**values))
    assert rest["link"] == link


@pytest.mark.parametrize(("factor", "text"), [(1, ""), (20, "deviations × 20")])
def test_an_exaggeration_is_told(controls_for, request_for, factor, text):
    _, rest = ask(request_for, controls_for(View(exaggerate=factor)))
    assert rest["texts"]["scale"] == text


@pytest.mark.parametrize("samples", [3, 200, 4000, 200_000])
def test_the_cursor_is_told_in_words(controls_for, request_for, samples):
    _, rest = ask(request_for, controls_for(samples=samples), want=[])
    cursor = samples // 2
    # Which one it is stands in the box before it.
    assert rest["texts"]["at-text"] == f"of {samples:,}, {significant(cursor * 3.0)} s"
    assert rest["controls"]["at"] == cursor + 1
    assert rest["samples"] == samples


@pytest.mark.parametrize(
    ("values", "states"),
    [
        ({}, ["computed"] * 3 + ["unused", "free", "unused"]),
        ({"design": "manual", "order": 2, "alpha": 0.5, "beta": 0.1}, ["free"] * 2 + ["unused"] * 4),
        ({"design": "kalata", "order": 2, "tracking_index": 1}, ["computed"] * 2 + ["unused"] * 3 + ["free"]),
        ({"design": "simpson", "order": 3, "alpha": 0.5, "beta": 0.3}, ["free", "free", "computed"] + ["unused"] * 3),
    ],
)
def test_every_slider_knows_how_it_stands_to_the_design(values, states):
    names = ["alpha", "beta", "gamma", "eta", "xi", "tracking_index"]
    assert owned(Experiment.from_dict(values)) == dict(zip(names, states, strict=True))


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("order", [2, 3, 4])
def test_menus_offer_what_makes_an_experiment(scenario, order):
    base = {"scenario": scenario, "order": order, "design": "fading-memory", "xi": 0.5}
    offered = offers(Experiment.from_dict(base))
    assert offered["axis"] == list(SCENARIOS[scenario].axes)
    assert offered["quantity"] == ["position", "velocity", "acceleration", "jerk"][:order]
    assert offered["input"] == ["step", "ramp", "parabola", "cubic", "quartic"][: order + 1]
    for name in ("noise", "start"):
        for choice in FIELDS[name].choices:
            try:
                Experiment.from_dict({**base, name: choice})
                possible = True
            except ValueError:
                possible = False
            assert (choice in offered[name]) == possible


@pytest.mark.parametrize("design", ["manual", *DESIGNS])
def test_every_design_is_explained_by_its_formula(design):
    for order in DESIGNS[design].orders if design in DESIGNS else (2, 3, 4):
        names = DESIGNS[design].parameters if design in DESIGNS else ("alpha", "beta", "gamma", "eta")[:order]
        text = formula_text(Experiment.from_dict({"design": design, "order": order, **dict.fromkeys(names, 0.3)}))
        if design == "manual":
            assert text == "The gains are set by hand."
        else:
            assert text.startswith(DESIGNS[design].formula[order])
            assert text.endswith(DESIGNS[design].remark or ".")


@pytest.mark.parametrize(
    ("gains", "text"),
    [
        ({"order": 2, "alpha": 0.5, "beta": 0.1}, "triangle"),
        ({"order": 3, "alpha": 0.5, "beta": 0.1, "gamma": 0.01}, "slice at γ = 0.0100"),
        ({"order": 4, "alpha": 0.5, "beta": 0.1, "gamma": 0.01, "eta": 0.001}, "slice at γ = 0.0100, η = 0.00100"),
    ],
)
def test_the_map_says_which_slice_it_shows(controls_for, request_for, gains, text):
    _, rest = ask(request_for, controls_for(design="manual", **gains))
    assert rest["texts"]["slice"] == text


# Numbers -----------------------------------------------------------------------------------------------------------


def tables(request_for, controls):
    updates, rest = answer(DESK, request_for(controls, want=[NUMBERS]))
    assert all(update is no_update for update in updates[:-1])
    assert rest["drawn"] == {NUMBERS: ""}
    assert all(isinstance(table, Component) for table in updates[-1])
    return [cells(table) for table in updates[-1]]


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_metrics_are_listed_jointly_and_per_axis(controls_for, request_for, scenario):
    (caption, head, rows), *_ = tables(request_for, controls_for(scenario=scenario))
    axes = SCENARIOS[scenario].axes
    result = run_experiment(Experiment.from_dict({"scenario": scenario}))
    assert caption == "Metrics"
    assert head == ["", "joint", *(axes if len(axes) > 1 else ())]
    assert len(rows) == len(METRICS)
    columns = [result.metrics.to_dict(), *(metrics.to_dict() for metrics in result.axis_metrics())]
    for row, (name, metric) in zip(rows, METRICS.items(), strict=True):
        assert row[0].startswith(metric.title)
        assert row[0].endswith(f"({metric.unit})")
        assert len(row) == len(head)
        for text, column in zip(row[1:], columns, strict=False):
            value = column[name]
            if value is None:
                assert text == "–"
            else:
                assert float(text.replace(",", "").replace("−", "-")) == pytest.approx(value, rel=1e-5)


@pytest.mark.parametrize(("samples", "at"), [(1000, None), (1000, 0), (1000, 999), (3, None), (31, 30)])
def test_the_samples_of_the_close_up_are_listed(controls_for, request_for, samples, at):
    *_, (caption, head, rows) = tables(request_for, controls_for(View(at=at), samples=samples))
    result = run_experiment(Experiment.from_dict({"samples": samples}))
    assert caption == "Samples around the chosen one (m, s)"
    assert len(rows) == min(31, samples)
    assert head[:2] == ["sample", "time"]
    assert not any("velocity" in name for name in head)
    column = head.index("x smoothed")
    for row in rows:
        index = int(row[0].replace(",", "")) - 1
        value = result.track.smoothed[index, 0, 0]
        if math.isnan(value):
            assert row[column] == "–"
        else:
            assert float(row[column].replace(",", "").replace("−", "-")) == pytest.approx(value, rel=1e-6)
    assert f"{(samples // 2 if at is None else at) + 1:,}" in [row[0] for row in rows]


def test_the_samples_of_a_long_way_can_be_told_apart(controls_for, request_for):
    *_, (_, head, rows) = tables(request_for, controls_for(samples=20_000, interval=600))
    times = [row[head.index("time")] for row in rows]
    positions = [row[head.index("x true")] for row in rows]
    assert len(set(times)) == len(times)
    assert len(set(positions)) == len(positions)


def test_without_being_asked_for_the_numbers_are_not_sent(controls_for, request_for):
    updates, rest = answer(DESK, request_for(controls_for()))
    assert updates[-1] is no_update
    assert NUMBERS not in rest["drawn"]
