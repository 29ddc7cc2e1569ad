"""Compare: its list, tables and plots, and what it says of a study, beside what the core says directly."""

import json
import re
from dataclasses import replace
from html import escape, unescape
from urllib.parse import parse_qsl

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as settings_of
from hypothesis import strategies as st

from layouts.comparing import Comparing
from layouts.controls import controls_of
from layouts.desk import answer, live_answer
from layouts.figures.common import coordinates
from layouts.figures.comparison import errors_of
from layouts.figures.forest import Entry, forest_figure
from layouts.numbers import MOST_ROWS
from layouts.pages.compare.answers import DESK, NUMBERS, SAME_RUNS
from layouts.pages.compare.study import begin, difference_text, mean_text, signed
from layouts.pinned import candidates, reference_of
from layouts.pins import SLOTS, read_pin
from layouts.questions import Question, StudyQuestion
from layouts.state import Settings, View, from_query, to_query
from layouts.text import change_text, metric_text, significant
from layouts.theme import PIN_LOOKS, THEMES, tokens
from tests.tables import cells
from tracker_core import METRICS, Experiment, InputError, run_experiment
from tracker_core.statistics import Interval
from tracker_core.tuning.monte_carlo import FIGURES, Difference

PINS = [
    [2, "fading-memory,xi:0.5"],
    [1, "manual,alpha:0.8,beta:0.4,name:<b>Mine</b> & more"],
    [5, "growing-memory"],
    [6, "moving-window,window:5000"],
]
SHORT = {"samples": 120}


def ask(request_for, controls, moved=None, **more):
    """The plots of an answer by name, and the rest of it."""
    updates, rest = answer(DESK, request_for(controls, moved, **more))
    return dict(zip(DESK.plots, updates[: len(DESK.plots)], strict=True)), rest


def settings(pins=PINS, view=None, **values):
    return Settings(Experiment.from_dict({**SHORT, **values}), view or View(), tuple(read_pin(*pin) for pin in pins))


def run_of(slot, **values):
    """The run of a pin, from the core alone."""
    present = Experiment.from_dict({**SHORT, **values})
    text = dict(PINS)[slot]
    return run_experiment(read_pin(slot, text).on(present))


# The list ----------------------------------------------------------------------------------------------------------


def test_the_list_has_the_present_filter_and_the_pins_by_slot(controls_for, request_for):
    _, rest = ask(request_for, controls_for(**SHORT), pins=PINS)
    rows = {row["slot"]: row for row in rest["filters"]}
    assert list(rows) == [0, 1, 2, 5, 6]
    assert [row["name"] for row in rows.values()] == [
        "Fading memory ξ 0.64", "<b>Mine</b> & more", "Fading memory ξ 0.5", "Growing memory (M2)",
        "Moving window (M4) W 5000",
    ]  # fmt: skip
    assert rows[1]["gains"] == "α 0.800, β 0.400"
    assert rows[1]["design"] == "Manual, order 2"
    assert rows[5]["gains"] == "gains chosen as it runs"
    assert rows[6]["problem"].startswith("Window must be < 120")
    assert (rows[6]["gains"], rows[1]["problem"]) == ("", "")
    assert [slot for slot, row in rows.items() if row["reference"]] == [0]
    # Which filter it is, whatever it is called.
    assert [row["key"] for row in rows.values()] == [
        "fading-memory,xi:0.64", "manual,alpha:0.8,beta:0.4", "fading-memory,xi:0.5", "growing-memory", "",
    ]  # fmt: skip


def test_gains_are_written_as_the_present_ones_are(controls_for, request_for):
    pins = [[1, "fading-memory,xi:0.5"], [2, "fading-memory,xi:0.5,convention:half"]]
    _, rest = ask(request_for, controls_for(convention="taylor", **SHORT), pins=pins)
    assert [row["gains"] for row in rest["filters"][1:]] == ["α 0.875, β 0.562, γ 0.0625"] * 2


def test_a_stopped_run_and_an_oracle_are_marked(controls_for, request_for):
    pins = [[1, "manual,alpha:1.9,beta:1.5,start:known"], [2, "parallel-bank"]]
    _, rest = ask(request_for, controls_for(), pins=pins)
    _, stopped, oracle = rest["filters"]
    assert stopped["problem"] == "The run was stopped: it left the world."
    assert stopped["design"].endswith(", order 2, start: known state")
    assert oracle["design"].startswith("◆ ")
    assert [row[2] for row in rest["rows"]["metrics"]] == [["–", "same", ""] for _ in METRICS]


@pytest.mark.parametrize(("chosen", "reference"), [(0, 0), (2, 2), (3, 0), (6, 0)])
def test_the_reference_is_one_that_runs(chosen, reference):
    assert reference_of(settings(view=View(comparing=Comparing(reference=chosen)))) == reference


def test_the_present_filter_takes_over_from_a_reference_that_is_removed(controls_for, request_for):
    controls = controls_for(View(comparing=Comparing(reference=2)), **SHORT)
    _, rest = ask(request_for, controls, pins=PINS, pinning=[["remove", 2]])
    assert rest["controls"]["reference"] == 0
    assert [row["slot"] for row in rest["filters"] if row["reference"]] == [0]


# The table ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("reference", [0, 1, 2])
def test_every_metric_of_every_filter_stands_beside_the_reference(controls_for, request_for, reference):
    controls = controls_for(View(comparing=Comparing(reference=reference)), **SHORT)
    _, rest = ask(request_for, controls, pins=PINS)
    found = {
        0: run_experiment(Experiment.from_dict(SHORT)).metrics,
        **{slot: run_of(slot).metrics for slot in (1, 2, 5)},
    }
    for row, (name, metric) in zip(rest["rows"]["metrics"], METRICS.items(), strict=True):
        assert row[0] == metric.title
        assert len(row) == 6
        base = getattr(found[reference], name)
        for slot, (value, tone, change) in zip((0, 1, 2, 5), row[1:], strict=False):
            assert value == metric_text(metric, getattr(found[slot], name))
            expected = (
                ("reference", "same") if slot == reference else change_text(metric, getattr(found[slot], name), base)
            )
            assert (change, tone) == expected
        assert row[5] == ["–", "same", ""]


def test_alone_a_filter_is_compared_with_nothing(controls_for, request_for):
    _, rest = ask(request_for, controls_for(**SHORT))
    assert all(cell[1:] == ["same", ""] for row in rest["rows"]["metrics"] for cell in row[1:])


# The plots ---------------------------------------------------------------------------------------------------------


def lines(figure):
    """Slot and trace of every pinned line, told by their colour."""
    colours = {tokens("light")[f"pin-{slot}"]: slot for slot in SLOTS}
    return [
        (colours[part["line"]["color"]], part)
        for part in figure["data"]
        if part.get("line", {}).get("color") in colours
    ]


def test_every_filter_has_its_own_look_on_every_plot(controls_for, request_for):
    plots, _ = ask(request_for, controls_for(**SHORT), pins=PINS)
    for name, figure in plots.items():
        drawn = lines(figure)
        assert {slot for slot, _ in drawn} == {1, 2, 5}, name
        for slot, part in drawn:
            assert (part["line"]["dash"], part["marker"]["symbol"]) == PIN_LOOKS[slot]
    for theme in THEMES:
        assert len({tokens(theme)[f"pin-{slot}"] for slot in SLOTS}) == 6
    assert len({dash for dash, _ in PIN_LOOKS.values()}) == len({symbol for _, symbol in PIN_LOOKS.values()}) == 6


def test_names_are_text_to_plotly(controls_for, request_for):
    plots, _ = ask(request_for, controls_for(**SHORT), pins=PINS)
    for figure in plots.values():
        names = {part["name"] for slot, part in lines(figure) if slot == 1}
        assert names == {"&lt;b&gt;Mine&lt;/b&gt; &amp; more"}


@pytest.mark.parametrize("factor", [1, 20])
def test_paths_are_those_of_the_runs(controls_for, request_for, factor):
    plots, _ = ask(request_for, controls_for(View(exaggerate=factor), **SHORT), pins=PINS)
    truth = run_of(1).truth.positions
    runs = {slot: truth + factor * (run_of(slot).track.smoothed[:, :, 0] - truth) for slot in (1, 2, 5)}
    for slot, part in lines(plots["compare-path"]):
        drawn = np.column_stack([coordinates(part[axis]) for axis in "xy"])
        np.testing.assert_allclose(drawn, runs[slot], rtol=1e-6)
    for slot, part in lines(plots["compare-close-up"]):
        drawn = np.column_stack([coordinates(part[axis]) for axis in "xy"])
        np.testing.assert_allclose(drawn, runs[slot][45:76], rtol=1e-6)


@pytest.mark.parametrize("kind", ["tracking", "estimation", "innovation"])
def test_errors_are_those_of_the_runs(controls_for, request_for, kind):
    """A short run is drawn sample by sample."""
    controls = controls_for(View(comparing=Comparing(compared=kind)), samples=60)
    plots, _ = ask(request_for, controls, pins=PINS[:2])
    for slot, part in lines(plots["compare-error"]):
        result = run_of(slot, samples=60)
        positions = {"tracking": result.track.predicted, "estimation": result.track.smoothed}
        expected = (
            np.linalg.norm(result.track.innovation, axis=1)
            if kind == "innovation"
            else np.linalg.norm(positions[kind][:, :, 0] - result.truth.positions, axis=1)
        )
        np.testing.assert_allclose(coordinates(part["y"]), expected, rtol=1e-6)
        np.testing.assert_allclose(errors_of(result, kind), expected, rtol=1e-12)


def test_a_filter_that_diverges_spoils_no_axis(controls_for, request_for):
    plain, _ = ask(request_for, controls_for(**SHORT), pins=PINS[:2])
    wild, _ = ask(request_for, controls_for(**SHORT), pins=[*PINS[:2], [3, "manual,alpha:1.9,beta:1.5"]])
    for name in ("compare-path", "compare-close-up"):
        assert wild[name]["layout"]["yaxis"]["range"] == plain[name]["layout"]["yaxis"]["range"]
    level = run_of(1).metrics.observation_rmse
    assert wild["compare-error"]["layout"]["yaxis"]["range"][1] <= 30 * level


def test_gains_stand_in_rows_in_the_present_convention(controls_for, request_for):
    plots, _ = ask(request_for, controls_for(convention="taylor", **SHORT), pins=PINS)
    figure = plots["compare-gains"]
    present = Experiment.from_dict({"convention": "taylor", **SHORT}).gains().values
    assert [set(coordinates(part["y"])) for part in figure["data"][:3]] == [{np.float32(gain)} for gain in present]
    assert "visible" in figure["data"][3]
    drawn = [(slot, part["yaxis"], coordinates(part["y"])) for slot, part in lines(figure)]
    assert [(slot, axis) for slot, axis, _ in drawn] == [
        (1, "y"), (1, "y2"), (2, "y"), (2, "y2"), (2, "y3"), (5, "y"), (5, "y2"), (5, "y3"),
    ]  # fmt: skip
    assert set(drawn[0][2]) == {np.float32(0.8)}
    assert set(drawn[4][2]) == {np.float32(0.0625)}
    # Of the growing memory the gains as they were used; written 2γ/T², γ is half the normalised one.
    used = run_of(5).selection.gains[:, 0, 2]
    np.testing.assert_allclose(drawn[7][2], used / 2, rtol=1e-6)
    assert [figure["layout"][f"yaxis{row}"]["visible"] for row in ("", 2, 3, 4)] == [True, True, True, False]


@pytest.mark.parametrize("gate", [None, 2.5])
def test_what_the_present_gate_refuses_is_crossed_out(controls_for, request_for, gate):
    """Under the pinned filters, whose gates are their own."""
    values = {"gate": gate, "noise_std": 30, **SHORT}
    plots, _ = ask(request_for, controls_for(View(at=60), **values), pins=PINS)
    result = run_experiment(Experiment.from_dict(values))
    gone = np.zeros(120, dtype=bool) if gate is None else result.track.rejected
    assert gone.any() == (gate is not None)
    for name, rows in (("compare-path", slice(None)), ("compare-close-up", slice(45, 76))):
        names = [part.get("name") for part in plots[name]["data"]]
        place = names.index("Not believed")
        crosses = plots[name]["data"][place]
        drawn = np.column_stack([coordinates(crosses[axis]) for axis in "xy"])
        np.testing.assert_allclose(drawn, result.measurements.positions[rows][gone[rows]], rtol=1e-6)
        assert crosses["showlegend"] == gone[rows].any()
        # Each knows which sample it is.
        np.testing.assert_array_equal(coordinates(crosses["customdata"]), np.arange(120)[rows][gone[rows]])
        assert crosses["marker"]["line"]["color"] == tokens("light")["bad"]
        assert names[place + 1 :] == [part["name"] for _, part in lines(plots[name])]


def test_while_a_slider_moves_the_present_lines_alone_are_sent(controls_for, request_for):
    controls = controls_for(**SHORT)
    _, rest = ask(request_for, controls, pins=PINS)
    question = request_for(controls, {"xi": 0.3}, pins=PINS, drawn=rest["drawn"], want=list(DESK.plots))
    answered, arrays = live_answer(DESK, question)
    assert answered["outdated"] == []
    assert {name: [index for index, _ in moved] for name, moved in answered["lines"].items()} == {
        "compare-path": [2, 3, 4], "compare-close-up": [2, 3, 4], "compare-error": [1, 2],
        "compare-gains": [0, 1, 2, 3],
    }  # fmt: skip
    assert answered["filters"][0]["name"] == "Fading memory ξ 0.3"
    full, _ = ask(request_for, {**controls}, {"xi": 0.3}, pins=PINS)
    np.testing.assert_array_equal(arrays[1], coordinates(full["compare-path"]["data"][2]["y"]))


def test_another_pin_draws_the_plots_anew(controls_for, request_for):
    controls = controls_for(**SHORT)
    _, rest = ask(request_for, controls, pins=PINS)
    question = request_for(controls, pins=PINS, pinning=[["remove", 2]], drawn=rest["drawn"], want=list(DESK.plots))
    assert live_answer(DESK, question)[0]["outdated"] == list(DESK.plots)


# The study ---------------------------------------------------------------------------------------------------------


def study_of(theme="light", **more):
    """The study of a link, and what the page shows once it is done."""
    study, content = begin(StudyQuestion(seq=1, query=to_query(settings(**more)), theme=theme))
    *_, last = study.stream()
    shown = content(last)
    json.dumps(shown)
    return study, last.outcome, shown


def test_a_study_compares_every_filter_that_fits():
    view = View(comparing=Comparing(reference=1, figure="tracking_max", runs=40))
    study, outcome, shown = study_of(view=view)
    assert [experiment.design for experiment in study.experiments] == [
        "fading-memory", "manual", "fading-memory", "growing-memory",
    ]  # fmt: skip
    assert study.runs == 40
    rows = {row[0]: row[1:] for row in shown["rows"]["over-runs"]}
    assert list(rows) == [*(METRICS[name].title for name in FIGURES), "Stopped runs"]
    # A column for every slot, so that none stands under another one's name once pins come and go.
    assert rows["Stopped runs"] == ["0", "0", "0", "–", "–", "0", "–"]
    keys = ["fading-memory,xi:0.64", "manual,alpha:0.8,beta:0.4", "fading-memory,xi:0.5", "", "", "growing-memory", ""]
    assert shown["columns"]["over-runs"] == list(enumerate(keys))
    figure = shown["figures"]["compare-forest"]
    # The reference and what does not fit are not drawn; what is far off stands at the edge.
    assert [part["name"] for part in figure["data"]] == ["Present", "Fading memory ξ 0.5"]
    assert len(figure["layout"]["annotations"]) == 1
    for number, part in zip((0, 2), figure["data"], strict=True):
        difference = outcome.difference("tracking_max", number, 1)
        assert part["x"] == [difference.percent.mean]
        assert part["error_x"]["array"] == [difference.percent.high - difference.percent.mean]
        assert part["marker"]["symbol"].endswith("-open") != difference.significant
    for name in FIGURES:
        cells = rows[METRICS[name].title]
        assert cells[1][2] == "reference"
        assert cells[3] == cells[4] == cells[6] == ["–", "", ""]
        for number, slot in ((0, 0), (2, 2), (3, 5)):
            said = difference_text(outcome.difference(name, number, 1), METRICS[name], final=True)
            assert (cells[slot][2], cells[slot][1]) == said


def test_nothing_is_called_significant_before_the_last_run():
    """Who may stop at the first significant result finds one sooner or later."""
    view = View(comparing=Comparing(runs=1_200))
    study, content = begin(StudyQuestion(seq=1, query=to_query(settings(pins=PINS[:2], view=view))))
    parts = list(study.stream())
    assert len(parts) > 1
    for part in parts:
        shown, final = content(part), part is parts[-1]
        drawn = shown["figures"]["compare-forest"]["data"]
        text, cells = shown["texts"]["runs-text"], [cell for row in shown["rows"]["over-runs"][:-1] for cell in row[1:]]
        differences = [part.outcome.difference("estimation_rmse", number, 0) for number in (1, 2)]
        # There would be something to say from the first part on.
        assert any(difference.significant for difference in differences)
        assert [trace["error_x"]["array"][0] > 0 for trace in drawn] == [True] * len(drawn)
        assert any(not trace["marker"]["symbol"].endswith("-open") for trace in drawn) == final
        assert ("so far; verdicts come with the last run" in text) != final
        assert text.startswith(f"{part.outcome.runs:,} runs, seeds 1 to {part.outcome.runs:,}")
        assert any(tone in ("better", "worse") for _, tone, _ in cells) == final
        assert ("significant" in json.dumps(shown)) == final


def test_a_filter_alone_waits_for_no_verdicts():
    study, content = begin(
        StudyQuestion(seq=1, query=to_query(settings(pins=[], view=View(comparing=Comparing(runs=5)))))
    )
    *_, last = study.stream()
    text = content(replace(last, done=last.done - 1))["texts"]["runs-text"]
    assert text.startswith("5 runs, seeds 1 to 5, so far. Means with their 95 % intervals.")
    assert "verdict" not in text


def test_the_means_of_a_study_are_those_of_its_runs():
    view = View(comparing=Comparing(runs=12))
    _, _, shown = study_of(pins=PINS[:1], view=view)
    values = [
        run_experiment(Experiment.from_dict({**SHORT, "seed": seed})).metrics.tracking_rmse for seed in range(1, 13)
    ]
    cell = next(row[1][0] for row in shown["rows"]["over-runs"] if row[0] == METRICS["tracking_rmse"].title)
    mean, half = (float(part) for part in cell.removesuffix(" m").split(" ± "))
    assert mean == pytest.approx(np.mean(values), abs=half / 10)
    # Student's t of 95 % at 11 degrees of freedom.
    assert half == pytest.approx(2.200985 * np.std(values, ddof=1) / np.sqrt(12), rel=0.05)


def test_what_significant_means_is_said_in_plain_words():
    _, _, shown = study_of(view=View(comparing=Comparing(runs=5)))
    text = shown["texts"]["runs-text"]
    assert text.startswith("5 runs, seeds 1 to 5. Means with their 95 % intervals.")
    assert "98.3 % each, so that all 3 comparisons of a row are right together with 95 % (Bonferroni)" in text
    _, _, shown = study_of(pins=PINS[:1], view=View(comparing=Comparing(runs=5)))
    assert shown["texts"]["runs-text"].endswith("zero lies outside its interval, which has 95 %.")
    _, _, shown = study_of(pins=[], view=View(comparing=Comparing(runs=5)))
    assert shown["texts"]["runs-text"].endswith("Pin a filter to see differences.")
    assert [note["text"] for note in shown["figures"]["compare-forest"]["layout"]["annotations"]] == [
        "Pin a filter to compare it with."
    ]


@pytest.mark.parametrize("values", [{"noise": "none"}, {"scenario": "garg-accelerating", "samples": 10}])
def test_where_nothing_is_left_to_chance_no_study_is_run_and_the_page_says_so(controls_for, request_for, values):
    with pytest.raises(InputError, match="noise must leave something to chance"):
        begin(StudyQuestion(seq=1, query=to_query(settings(pins=[], **values))))
    _, rest = ask(request_for, controls_for(**{**SHORT, **values}))
    assert rest["texts"]["chance"] == SAME_RUNS
    _, rest = ask(request_for, controls_for(**SHORT))
    assert rest["texts"]["chance"] == ""


@pytest.mark.parametrize("entry", ["1000001", "1", "2.5", "many"])
def test_a_number_of_runs_over_the_bound_is_said_beside_its_field(controls_for, request_for, entry):
    _, rest = ask(request_for, controls_for(**SHORT), {"runs": entry})
    assert list(rest["errors"]) == ["runs"]
    assert rest["errors"]["runs"].startswith("Runs must be a whole number >= 2 and <= 1,000,000")


def test_a_study_of_too_many_steps_is_refused_by_its_runs():
    view = View(comparing=Comparing(runs=1_000_000))
    with pytest.raises(InputError) as caught:
        begin(StudyQuestion(seq=1, query=to_query(settings(view=view, samples=100_000))))
    assert caught.value.field == "runs"


@pytest.mark.parametrize("query", ["", "pin1=nonsense&theme=1", "%"])
def test_any_link_begins_a_study(query):
    study, _ = begin(StudyQuestion(seq=1, query=query))
    assert len(study.experiments) == 1


@pytest.mark.parametrize(
    ("interval", "text"),
    [
        (Interval(12.3456, 12.3, 12.3912), "12.346 ± 0.046 m"),
        (Interval(24126.4, 24060, 24192.8), "24,126 ± 66 m"),
        (Interval(-0.5, -0.6, -0.4), "−0.50 ± 0.10 m"),
        (Interval(3.0, 3.0, 3.0), "3.000 m"),
        (Interval(3.0, float("nan"), float("nan")), "3.000 m"),
        (Interval(float("nan"), float("nan"), float("nan")), "–"),
    ],
)
def test_a_mean_is_said_to_the_digits_that_its_interval_leaves(interval, text):
    assert mean_text(interval, METRICS["tracking_rmse"]) == text


@pytest.mark.parametrize(
    ("metric", "mean", "tone"),
    [("tracking_rmse", -2.0, "better"), ("tracking_rmse", 2.0, "worse"), ("noise_reduction", 2.0, "better")],
)
def test_a_difference_that_is_significant_has_a_tone(metric, mean, tone):
    sure = Interval(mean, mean - 1, mean + 1)
    text, got = difference_text(Difference(sure, sure, significant=True, runs=5), METRICS[metric], final=True)
    assert got == tone
    assert re.fullmatch(r"[+−]2.00 % \([+−]\d.00 to [+−]\d.00\)\nsignificant", text)
    chance = Difference(sure, sure, significant=False, runs=5)
    assert difference_text(chance, METRICS[metric], final=True) == (text.replace("\n", "\nnot "), "same")


def test_numbers_bear_their_sign():
    assert [signed(value) for value in (1.5, -1.5, 0.0)] == ["+1.50", "−1.50", "0"]


@pytest.mark.parametrize("metric", ["estimation_rmse", "noise_reduction"])
def test_where_percent_mean_nothing_the_unit_is_drawn(metric):
    absolute, none = Interval(1.0, 0.5, 1.5), Interval(float("nan"), float("nan"), float("nan"))
    entry = Entry(3, "x" * 40, Difference(absolute, none, significant=True, runs=3))
    figure = forest_figure([entry], METRICS[metric], "a < b", "dark", final=True)
    assert figure["data"][0]["x"] == [1.0]
    title = figure["layout"]["xaxis"]["title"]["text"]
    assert title == f"difference to<br>a &lt; b ({'m' if metric == 'estimation_rmse' else 'percentage points'})"
    assert figure["layout"]["yaxis"]["ticktext"] == ["x" * 21 + "…"]
    assert unescape(escape("a < b")) == "a < b"


# Anything ----------------------------------------------------------------------------------------------------------


@settings_of(max_examples=60)
@given(wanted=st.from_type(Settings), theme=st.sampled_from(THEMES))
def test_any_filters_can_be_compared_on_any_target(wanted, theme):
    experiment = replace(wanted.experiment, samples=min(wanted.experiment.samples, 60))
    wanted = replace(wanted, experiment=experiment, view=replace(wanted.view, at=None))
    pins = [(pin.slot, pin.text()) for pin in wanted.pins]
    question = Question(seq=1, controls=controls_of(wanted), pins=pins, theme=theme)
    updates, rest = answer(DESK, question)
    assert len(rest["filters"]) == len(pins) + 1
    for figure in updates[: len(DESK.plots)]:
        assert np.isfinite(figure["layout"]["yaxis"]["range"]).all()
    json.dumps([updates[:-1], rest])


# Links -------------------------------------------------------------------------------------------------------------


def test_the_link_of_the_page_brings_all_of_it_back():
    wanted = settings(view=View(comparing=Comparing(5, "innovation", "estimation_l2", 20)))
    got, notes = from_query(dict(parse_qsl(to_query(wanted))))
    assert (got, notes) == (wanted, [])
    assert [candidate.slot for candidate in candidates(got)] == [0, 1, 2, 5, 6]
    assert replace(got, pins=()) == replace(wanted, pins=())


def test_a_filter_far_off_is_named_at_the_edge():
    """It would press the others into one line."""
    means = (1.3, -0.7, 9_062.0)
    entries = [
        Entry(slot, f"pin {slot}", Difference(Interval(m, m - 0.1, m + 0.1), Interval(m, m - 0.1, m + 0.1), True, 20))
        for slot, m in enumerate(means, start=1)
    ]
    figure = forest_figure(entries, METRICS["estimation_rmse"], "Present", "light", final=True)
    assert [trace["x"] for trace in figure["data"]] == [[1.3], [-0.7]]
    low, high = figure["layout"]["xaxis"]["range"]
    assert low < -0.7
    assert 1.3 < high < 2
    (note,) = figure["layout"]["annotations"]
    assert (note["text"], note["y"]) == ("9,062 % →", -2)
    together = forest_figure(entries[:2], METRICS["estimation_rmse"], "Present", "light", final=True)
    assert "range" not in together["layout"]["xaxis"]


# The plots in numbers ----------------------------------------------------------------------------------------------


def test_gains_and_errors_of_every_filter_are_told_in_numbers(controls_for, request_for):
    controls = controls_for(**SHORT, convention="taylor")
    updates, _ = answer(DESK, request_for(controls, pins=PINS, want=[NUMBERS]))
    (gains_caption, head, gains), (errors_caption, names, errors) = map(cells, updates[-1])
    assert (gains_caption, head) == ("Gains", ["Filter", "α", "β", "γ"])
    present = Experiment.from_dict({**SHORT, "convention": "taylor"})
    assert gains[0] == ["Present", *(significant(value) for value in present.gains().values)]
    # A filter of order 2 has no third gain, and one whose method chooses them has a range.
    assert gains[1] == ["<b>Mine</b> & more", "0.8000", "0.4000", "–"]
    chosen = run_of(5, convention="taylor").selection.gains[:, 0, 0]
    least, middle, greatest = (significant(value) for value in np.nanquantile(chosen, (0, 0.5, 1)))
    assert gains[3][1] == f"{least} to {greatest}, median {middle}"
    assert errors_caption == "Errors: smoothed to true (m), running RMS of 3 samples"
    assert names == ["time (s)", *(row[0] for row in gains)]
    curves = [
        errors_of(run_experiment(present), "estimation"),
        *(errors_of(run_of(n), "estimation") for n in (1, 2, 5)),
    ]
    assert len(errors) == MOST_ROWS
    for place, row in enumerate(errors):
        around = slice(max(0, 2 * place - 1), 2 * place + 2)
        means = [np.sqrt(np.nanmean(curve[around] ** 2)) for curve in curves]
        assert [float(text.replace(",", "")) for text in row[1:]] == pytest.approx(means, rel=1e-3)
