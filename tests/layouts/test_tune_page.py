"""What the Tune page asks for and says: from a link to a study, from its outcome to words, offers and errors."""

from dataclasses import replace
from urllib.parse import parse_qsl

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layouts.controls import controls_of, resolve
from layouts.desk import answer, live_answer
from layouts.numbers import MOST_ROWS
from layouts.pages.tune.answers import DESK
from layouts.pages.tune.content import PLOT, begin
from layouts.pages.tune.numbers import MOST_CELLS, TABLES
from layouts.pages.tune.present import present_scores, present_value
from layouts.pages.tune.rivals import HEAD
from layouts.pages.tune.studies import study_of
from layouts.pages.tune.view import layout
from layouts.pages.tune.words import cost_text, found_text, gain_text, number, runs_text
from layouts.questions import StudyQuestion
from layouts.state import Settings, View, from_query, to_query
from layouts.text import significant
from layouts.tuning import TUNING_FIELDS, Tuning, fields_in_use, own_parameter
from tracker_core import DESIGNS, Experiment, Gains, InputError, run_experiment
from tracker_core.stability import is_stable
from tracker_core.statistics import Interval, t_quantile
from tracker_core.tuning import OBJECTIVES, Map, Progress, Sweep
from tracker_core.tuning.sweeps import offered, varied

SHORT = "samples=60&tune_runs=4&points=21&cells=12"


def settings_of(query):
    found, notes = from_query(dict(parse_qsl(query)))
    assert notes == []
    return found


def played(query):
    """A study to its end, and what the page shows of it."""
    study, content = begin(StudyQuestion(seq=1, query=query, theme="dark"))
    *_, last = study.stream()
    return study, last.outcome, content(last)


def move(query, **moved):
    """What a hand does to the page of a link."""
    return resolve({**controls_of(settings_of(query)), **moved}, list(moved))


# The link and the controls -----------------------------------------------------------------------------------------


def test_the_link_says_what_differs():
    tuning = Tuning("map", "tracking_max", "alpha", 0.25, 0.75, 11, 30, 5_000, 7, 0.125)
    wanted = Settings(Experiment.from_dict({}), View(tuning=tuning))
    assert to_query(wanted) == (
        "tune=map&tune_for=tracking_max&against=alpha&from=0.25&to=0.75&points=11&cells=30&budget=5000"
        "&tune_runs=7&noise_weight=0.125"
    )
    assert set(TUNING_FIELDS) == {*dict(parse_qsl(to_query(wanted))), "without_truth"}


@pytest.mark.parametrize("design", ["manual", "critically-damped-bank", *DESIGNS])
def test_a_filter_is_varied_by_what_it_is_made_from(design):
    order = DESIGNS[design].orders[0] if design in DESIGNS else 2
    gains = {"alpha": 0.5, "beta": 0.2} if design == "manual" else {}
    values = dict.fromkeys(DESIGNS[design].parameters, 0.3) if design in DESIGNS else gains
    experiment = Experiment.from_dict({"design": design, "order": order, **values})
    own = own_parameter(experiment)
    assert own in offered(experiment)
    assert own in values or design == "critically-damped-bank"
    # What a filter cannot be varied by gives way.
    assert Tuning(against="eta").parameter(experiment) == own
    assert Tuning(against="eta").fitted(experiment).against is None
    assert Tuning(against="xi").parameter(experiment) == "xi"


def test_another_filter_is_varied_anew_and_another_parameter_over_its_usual_values():
    got = move("against=alpha&from=0.2&to=0.6", design="kalata").settings.view.tuning
    assert (got.against, got.low, got.high) == (None, None, None)
    got = move("from=0.2&to=0.6", against="tracking_index").settings.view.tuning
    assert (got.against, got.low, got.high) == ("tracking_index", None, None)
    got = move("from=0.2", order=2)
    assert got.settings.view.tuning.low is None
    # A slider is no other filter to be looked at, nor is another target.
    for moved in ({"xi": 0.5}, {"scenario": "yu-wu"}, {"samples": 50}):
        assert move("against=beta&from=0.2&to=0.6", **moved).settings.view.tuning.low == 0.2


def test_without_the_truth_the_same_figure_of_the_innovations_counts():
    got = move("tune_for=tracking_max", without_truth="on").settings.view.tuning
    assert (got.objective, got.without_truth) == ("innovation_max", True)
    got = move("tune_for=innovation_max&without_truth=on", without_truth="off").settings.view.tuning
    assert (got.objective, got.without_truth) == ("estimation_max", False)
    assert settings_of("tune_for=noise_lag&without_truth=on").view.tuning.objective == "innovation_rmse"


@pytest.mark.parametrize(
    ("name", "entry", "rule"),
    [
        ("tune_runs", "1000000000", "must be a whole number >= 1 and <= 10,000"),
        ("tune_runs", "0", "must be a whole number >= 1 and <= 10,000"),
        ("cells", "10000", "must be a whole number >= 2 and <= 200"),
        ("points", "1e6", "must be a whole number >= 2 and <= 1,001"),
        ("points", "many", "must be"),
        ("from", "nan", "must be a finite number"),
        ("to", "x", "must be"),
        ("noise_weight", "1.5", "must be a finite number >= 0 and <= 1"),
        ("tune", "everything", "must be one of"),
        ("against", "T", "must be one of"),
        ("tune_for", "luck", "must be one of"),
    ],
)
def test_a_bad_entry_has_its_error_beside_it_and_is_left_out_of_a_link(name, entry, rule):
    got = move("", **{name: entry})
    assert got.settings is None
    assert got.controls[name] == entry
    ((wrong,),) = (got.errors,)
    assert wrong.field == name
    assert wrong.rule.startswith(rule)
    found, notes = from_query({name: entry})
    assert found.view.tuning == Tuning()
    assert [note.split()[0] for note in notes] == [name]


def test_fields_that_mean_nothing_are_hidden():
    present = settings_of("").experiment
    sweep, plane = fields_in_use(Tuning(), present), fields_in_use(Tuning("map"), present)
    assert {name for name, shown in sweep.items() if shown} == {"against", "from", "to", "points", "tune_runs"}
    assert {name for name, shown in plane.items() if shown} == {"plane", "cells", "tune_runs"}
    closed = fields_in_use(Tuning(objective="noise_lag"), present)
    assert closed["noise_weight"]
    assert not closed["tune_runs"]
    # More runs would all be the same.
    assert not fields_in_use(Tuning(), settings_of("noise=none").experiment)["tune_runs"]


# The study ---------------------------------------------------------------------------------------------------------


@settings(max_examples=60)
@given(st.from_type(Settings))
def test_every_link_is_a_study_or_says_what_is_wrong_with_which_control(wanted):
    refused = None
    try:
        study = study_of(wanted)
    except InputError as error:
        refused = error.field
    if refused is None:
        assert hash(study) == hash(study_of(wanted))
        assert study.runs == wanted.view.tuning.runs
    else:
        assert refused in controls_of(wanted)


@pytest.mark.parametrize("parameter", ["alpha", "gamma", "xi", "tracking_index", "process_variance"])
def test_a_sweep_does_not_depend_on_the_value_that_is_varied(parameter):
    base = Experiment.from_dict({"samples": 60})
    one, other = (varied(base, parameter, value) for value in (0.25, 0.4))
    studies = [study_of(Settings(each, View(tuning=Tuning(against=parameter)))) for each in (one, other)]
    assert studies[0] == studies[1]
    # It runs what the sweep of the experiment itself runs.
    plain = Sweep(one, parameter, studies[0].values, "estimation_rmse")
    np.testing.assert_array_equal(plain.vectors(), studies[0].vectors())
    assert replace(studies[0].experiment, seed=9) == replace(studies[1].experiment, seed=9)


@pytest.mark.parametrize("plane", [("alpha", "beta"), ("beta", "gamma"), ("alpha", "gamma")])
def test_a_map_does_not_depend_on_the_gains_of_its_plane(plane):
    held = {"alpha": 0.6, "beta": 0.3, "gamma": 0.1}
    studies = [
        study_of(
            Settings(
                Experiment.from_dict({"order": 3, "convention": "taylor", **held, **dict.fromkeys(plane, value)}),
                View(plane=plane, tuning=Tuning("map")),
            )
        )
        for value in (0.1, 0.7)
    ]
    assert studies[0] == studies[1]
    assert isinstance(studies[0], Map)
    (fixed,) = set(held) - set(plane)
    assert getattr(studies[0].experiment, fixed) == held[fixed]


@pytest.mark.parametrize(
    ("query", "field", "rule"),
    [
        ("from=0.9&to=0.2", "to", "must be > 0.9"),
        ("from=-1", "from", "must be a finite number >= 0 and < 1"),
        ("to=1.5", "to", "must be a finite number >= 0 and < 1"),
        ("against=tracking_index&from=0", "from", "must be a finite number > 0"),
        ("tune=map&tune_runs=5000", "tune_runs", "must be a whole number >= 1 and <= 1,000"),
        ("tune=map&design=critically-damped-bank&order=2", "design", "must have constant gains"),
        ("tune=map&order=3&alpha=0.5&beta=0.2&gamma=8.5", "plane", "must have a stable part"),
        ("samples=200000&tune_runs=10000", "tune_runs", "must be so small that no more than 100,000,000,000"),
        ("points=1001&tune_runs=10000&samples=10", "tune_runs", "must be so small that no more than 5,000,000 scores"),
    ],
)
def test_what_cannot_be_studied_names_the_control_and_the_bound(query, field, rule):
    with pytest.raises(InputError) as caught:
        study_of(settings_of(query))
    assert caught.value.field == field
    assert caught.value.rule.startswith(rule)


# The present filter ------------------------------------------------------------------------------------------------


@settings(max_examples=60)
@given(st.from_type(Experiment))
def test_the_present_filter_lies_on_the_curve_where_it_is_marked(experiment):
    for parameter in offered(experiment):
        value = present_value(experiment, parameter)
        if value is None:
            assert parameter in ("xi", "tracking_index", "process_variance", "sensor_variance")
            continue
        try:
            at = varied(experiment, parameter, value)
        except InputError:
            # So small or great that rounding leaves the domain.
            continue
        np.testing.assert_allclose(at.gains().vector, experiment.gains().vector, rtol=1e-9)


def test_the_present_filter_runs_with_the_seeds_of_the_study():
    wanted = settings_of("samples=60&tune_runs=3&seed=5")
    found = present_scores(study_of(wanted), wanted.experiment)
    for run, score in enumerate(found):
        single = run_experiment(replace(wanted.experiment, seed=5 + run))
        assert score == pytest.approx(single.metrics.estimation_rmse, rel=1e-9)


@pytest.mark.parametrize("query", ["design=critically-damped-bank&order=2", "order=2&alpha=1.9&beta=1.5"])
def test_a_filter_without_stable_gains_is_compared_with_nothing(query):
    wanted = settings_of(f"samples=60&tune_runs=3&against=xi&{query}")
    assert present_scores(study_of(wanted), wanted.experiment) is None
    _, _, shown = played(f"{SHORT}&against=xi&{query}")
    assert shown["texts"]["best"].startswith("Best: ξ = ")
    assert "present" not in shown["texts"]["best"]


# What is said ------------------------------------------------------------------------------------------------------


def test_the_best_value_is_told_with_its_interval_and_the_gain_over_the_present():
    study, outcome, shown = played(f"{SHORT}&xi=0.85")
    best = outcome.optimum()
    value, low, high = number(best.value, best.low, best.high)
    mean, least, most = number(best.score.mean, best.score.low, best.score.high)
    present = np.array(
        [run_experiment(replace(study.experiment, xi=0.85, seed=1 + run)).metrics.estimation_rmse for run in range(4)]
    )
    less = 100 * (1 - outcome.scores[0][:, best.index].mean() / present.mean())
    said = shown["texts"]["best"]
    assert said.startswith(f"Best: ξ = {value} (95 %: {low} to {high}): estimation RMSE {mean} m ({least} to {most}), ")
    assert said.endswith(" less than with the present gains in the runs it was chosen by.")
    assert f", {significant(less, 2)} % (" in said
    assert shown["texts"]["runs"] == "4 runs"
    assert shown["offers"]["use"] == {"text": "Use this", "controls": {"xi": float(f"{best.value:.5g}")}}
    assert set(shown["figures"]) == {PLOT}


@pytest.mark.parametrize(
    "query",
    [
        "against=alpha", "against=tracking_index", "against=sensor_variance", "tune=map",
        "against=beta&convention=half", "tune=map&plane=beta-gamma&convention=taylor",
    ],
)  # fmt: skip
def test_what_is_offered_is_the_best_filter(query):
    """Using it leads to the gains that did best, as far as the digits of an optimum go."""
    study, outcome, shown = played(f"{SHORT}&{query}")
    controls = shown["offers"]["use"]["controls"]
    got = move(f"{SHORT}&{query}", **controls)
    assert got.errors == ()
    gains = got.settings.experiment.gains()
    if isinstance(study, Sweep):
        expected = study.at(outcome.optimum().value).gains()
    else:
        expected = Gains.normalised(outcome.vectors[outcome.best()])
    np.testing.assert_allclose(gains.vector, expected.vector, rtol=1e-4)
    assert is_stable(gains)
    # It is the present filter then, and nothing is better.
    again, content = begin(StudyQuestion(seq=1, query=to_query(got.settings)))
    *_, last = again.stream()
    said = content(last)["texts"]["best"]
    assert "the same as with the present gains" in said or "is shown to be better than the present filter" in said


def test_the_cost_of_not_knowing_the_truth_is_that_of_the_other_best_value():
    _, outcome, shown = played(f"{SHORT}&without_truth=on")
    blind, knowing = outcome.optimum(0), outcome.optimum(1)
    judged = outcome.scores[1]
    cost = 100 * (judged[:, blind.index].mean() / judged[:, knowing.index].mean() - 1)
    said = shown["texts"]["cost"]
    assert said.startswith(f"Tuned on the truth it would be ξ = {number(knowing.value, knowing.low, knowing.high)[0]};")
    assert f"costs {cost:#.2g} % (" in said
    assert shown["texts"]["best"].startswith("Best: ξ")
    assert "innovation RMSE" in shown["texts"]["best"]
    assert played(SHORT)[2]["texts"]["cost"] == ""


def test_the_best_cell_is_told_with_the_ranges_of_its_company():
    study, outcome, shown = played("samples=60&tune_runs=6&cells=30&tune=map&order=3&plane=beta-gamma&convention=half")
    alpha, *varied_gains = study.at(outcome.vectors[outcome.best()]).values
    said = [f"α = {significant(alpha, 3)}"]
    # Half of gamma's convention: twice the normalised gain.
    for symbol, value, factor, ends in zip("βγ", varied_gains, (1, 2), outcome.near_ranges(), strict=True):
        text, low, high = number(value, *(factor * end for end in ends))
        said.append(f"{symbol} = {text} ({low} to {high})")
    assert shown["texts"]["best"].startswith(f"Best cell: {', '.join(said)}: estimation RMSE ")


def test_the_cost_of_a_map_is_told_in_gains():
    _, outcome, shown = played(f"{SHORT}&tune=map&order=2&without_truth=on")
    knowing = outcome.vectors[outcome.best(1)]
    assert f"Tuned on the truth it would be α = {knowing[0]:.3f}, β = {knowing[1]:.3f}" in shown["texts"]["cost"]


def test_costs_in_words():
    pair = ("ξ = 0.5", "ξ = 0.6")
    assert cost_text(pair, Interval(1.62, 1.51, 1.78), 9).endswith("costs 1.6 % (1.5 to 1.8) of estimation RMSE.")
    assert cost_text(pair, Interval(1.62, np.nan, np.nan), 1).endswith("costs 1.6 % of estimation RMSE.")
    assert "next to nothing" in cost_text(pair, Interval(0.0, 0.0, 0.0), 9)
    assert "costs nothing here" in cost_text(("ξ = 0.5", "ξ = 0.5"), Interval(0.2, 0.1, 0.3), 9)
    assert "next to nothing" in cost_text(pair, Interval(0.01, 0.005, 0.015), 9)
    assert "no percentage says" in cost_text(pair, Interval(np.nan, np.nan, np.nan), 9)


def test_gains_over_the_present_in_words():
    present = np.array([10.0, 11.0, 12.0])
    runs, exact = ({"what": "cell", "chance": chance} for chance in (True, False))

    def change(best):
        """The change in percent and its interval, of a ratio of paired means."""
        ratio = best.mean() / 11
        mean, spread = 100 * abs(1 - ratio), 100 * (best - ratio * present).std(ddof=1) / 11
        half = t_quantile(0.95, 2) * spread / np.sqrt(3)
        return f"{significant(mean, 2)} % ({significant(mean - half, 2)} to {significant(mean + half, 2)})"

    less, more = present * [0.87, 0.88, 0.89], present * [1.11, 1.12, 1.13]
    assert gain_text(less, present, **runs) == (
        f", {change(less)} less than with the present gains in the runs it was chosen by"
    )
    assert gain_text(more, present, **runs) == (
        f". No cell is shown to be better than the present filter: the best one has {change(more)} more"
    )
    # A little less in the mean, but not in every run.
    mixed = present * [0.99, 1.02, 0.96]
    assert gain_text(mixed, present, **runs) == (
        f". No cell is shown to be better than the present filter: the best one has {change(mixed)} less"
    )
    assert "(−" in change(mixed)
    assert gain_text(present, present, **runs) == ", the same as with the present gains within 0.05 %"
    assert gain_text(present, None, **runs) == ""
    # One run of many says nothing; where there is but one, it says all.
    assert gain_text(np.array([9.0]), np.array([10.0]), **runs) == ""
    assert gain_text(np.array([9.0]), np.array([10.0]), **exact) == ", 10 % less than with the present gains"
    assert gain_text(np.array([11.0]), np.array([10.0]), **exact) == (
        ". No cell is better than the present filter: the best one has 10 % more"
    )


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        ((0.59338, 0.59102, 0.59561), ("0.5934", "0.5910", "0.5956")),
        ((12.058, 11.94, 12.176), ("12.06", "11.94", "12.18")),
        ((0.5, np.nan, np.nan), ("0.5000", "–", "–")),
        ((15961.4, 14602.1, 17410.2), ("15,961", "14,602", "17,410")),
    ],
)
def test_a_number_has_as_many_digits_as_its_interval_leaves_certain(numbers, said):
    assert number(*numbers) == said


def test_runs_in_words():
    assert (runs_text(3, 20), runs_text(20, 20), runs_text(1, 1)) == ("3 of 20 runs", "20 runs", "1 run")


def test_part_of_a_study_is_not_compared_with_the_present():
    study, content = begin(StudyQuestion(seq=1, query="samples=60&tune_runs=4000&points=31"))
    first = next(study.stream())
    assert first.done < first.of
    texts = content(first)["texts"]
    assert texts["runs"] == f"{first.outcome.runs:,} of 4,000 runs"
    assert texts["best"].startswith("Best so far: ξ = ")
    assert texts["best"].endswith(").")
    assert "present" not in texts["best"]


def test_where_nothing_is_left_to_chance_one_run_is_enough():
    _, outcome, shown = played("samples=60&noise=none&points=21")
    assert outcome.runs == 1
    assert shown["texts"]["runs"] == "1 run"
    assert "95 %" not in shown["texts"]["best"]


# The page's own answers --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ask", [lambda *a: answer(*a)[1], lambda *a: live_answer(*a)[0]], ids=["full", "live"])
def test_the_answer_says_where_the_present_filter_stands(controls_for, request_for, ask):
    rest = ask(DESK, request_for(controls_for(), {"xi": 0.5}))
    assert rest["present"] == {"parameter": "xi", "value": 0.5}
    assert rest["handles"][PLOT]["points"] == []
    view = View(tuning=Tuning("map"))
    rest = ask(DESK, request_for(controls_for(view, order=2, alpha=0.5, beta=0.2)))
    assert rest["handles"][PLOT]["points"] == [[0.5, 0.2]]
    assert rest["present"]["parameter"] == "alpha"


def test_the_handle_is_called_by_the_gains_of_the_boxes(controls_for, request_for):
    """Half of the normalised gamma is what it takes to write it as 2 gamma / T^2."""
    view = View(plane=("beta", "gamma"), tuning=Tuning("map"))
    values = {"order": 3, "alpha": 0.5, "beta": 0.2, "gamma": 0.03, "convention": "taylor"}
    handle = answer(DESK, request_for(controls_for(view, **values)))[1]["handles"][PLOT]
    assert handle["labels"] == ["Present gains: α = 0.500, β = 0.200, γ = 0.0300"]
    assert handle["points"] == [[0.2, 0.06]]


def test_every_column_of_the_rivals_has_a_name_and_all_findings_grow_old_together():
    (results,) = (part for part in layout()._traverse() if getattr(part, "className", None) == "study-results")
    inside = {part.id for part in results._traverse() if getattr(part, "id", None)}
    assert inside == {"tune-best", "tune-cost", "tune-use", "tune-cell", "tune-rivals"}
    *_, last = (part for part in results._traverse() if type(part).__name__ == "Th")
    assert (last.children.children, last.children.className) == ("Take", "visually-hidden")


def test_menus_offer_what_can_be_tuned(controls_for, request_for):
    def offered_now(view, **values):
        offers = answer(DESK, request_for(controls_for(view, **values)))[1]["offers"]
        return offers["tune_for"], offers["against"]

    objectives, parameters = offered_now(View(), order=2)
    assert objectives == list(OBJECTIVES)
    assert {"alpha", "beta", "xi"} <= set(parameters)
    assert not {"gamma", "eta"} & set(parameters)
    objectives, parameters = offered_now(View(tuning=Tuning(objective="innovation_rmse", without_truth=True)))
    assert objectives == [name for name in OBJECTIVES if name.startswith("innovation")]
    assert "alpha" not in offered_now(View(), design="critically-damped-bank", order=2)[1]


# All gains ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def searched():
    return played("samples=60&tune_runs=6&tune=search&budget=2000&order=2&seed=3")


def test_what_was_found_is_told_by_fresh_runs(searched):
    """Seeds 3 to 8 are searched in, 9 to 14 are fresh."""
    study, outcome, shown = searched
    assert (study.experiment.seed, study.drawn) == (3, 6)
    values = dict(zip(("alpha", "beta"), outcome.gains.values, strict=True))
    scores = [
        run_experiment(Experiment.from_dict({"samples": 60, "order": 2, "seed": 9 + run, **values})) for run in range(6)
    ]
    mean = np.mean([result.metrics.estimation_rmse for result in scores])
    assert f"estimation RMSE {mean:.3g}" in shown["texts"]["best"]
    assert "in 6 fresh runs" in shown["texts"]["best"]
    assert shown["texts"]["runs"] == f"{outcome.tried:,} of at most 2,000 gain sets"
    controls = shown["offers"]["use"]["controls"]
    assert controls["design"] == "manual"
    assert [controls["alpha"], controls["beta"]] == pytest.approx(outcome.gains.values, rel=1e-4)


def test_every_design_has_a_row_and_so_has_the_present_filter(searched):
    _, outcome, shown = searched
    rows = shown["rows"]["rivals"]
    assert all(len(row) == len(HEAD) for row in rows)
    titles = [row[0] for row in rows]
    assert titles[0] == "Found"
    assert titles[-1] == "Present"
    ranked = sorted(outcome.rivals, key=lambda rival: rival.score)
    assert [title.split(",")[0] for title in titles[1:-1]] == [rival.title for rival in ranked]
    assert any(title.startswith("Steady Kalman, Λ = ") for title in titles)
    for row, rival in zip(rows[1:-1], ranked, strict=True):
        number_of = outcome.rivals.index(rival)
        more = outcome.fresh.percents[number_of]
        assert row[4][0].startswith(significant(more.mean, 2))
        assert row[4][1] == ("bad" if outcome.fresh.worse(number_of) else "")
        got = move("samples=60&order=2", **row[5]["controls"]).settings.experiment
        assert got.design == rival.design
        np.testing.assert_allclose(got.gains().vector, rival.vector, rtol=1e-3, atol=1e-12)


def test_the_present_filter_is_compared_in_the_fresh_runs(searched):
    _, outcome, shown = searched
    present = [
        run_experiment(Experiment.from_dict({"samples": 60, "order": 2, "seed": 9 + run})).metrics.estimation_rmse
        for run in range(6)
    ]
    more = 100 * (np.mean(present) / outcome.fresh.score.mean - 1)
    row = shown["rows"]["rivals"][-1]
    assert row[3].startswith(f"{np.mean(present):.3g}")
    assert row[4][0].startswith(significant(more, 2))
    assert row[5] == ""


def test_what_the_plot_of_a_search_shows_is_told_in_numbers(searched):
    _, outcome, shown = searched
    rows = shown["rows"]["told-generations"]
    assert rows[-1] == [f"{len(outcome.history):,}", significant(outcome.score, 5)]
    assert all(len(row) == len(TABLES["told-generations"][1]) for row in rows)
    assert not shown["rows"]["told-values"] + shown["rows"]["told-cells"]


@pytest.mark.parametrize("blind", ["", "&without_truth=on"])
def test_what_the_plot_of_a_sweep_shows_is_told_in_numbers(blind):
    _, outcome, shown = played(f"{SHORT}{blind}&points=151")
    rows = {row[0]: row[1:] for row in shown["rows"]["told-values"]}
    assert len(rows) <= MOST_ROWS + 1
    mean, width = outcome.mean()
    best = outcome.optimum().index
    for index in (0, best):
        found = rows[f"ξ = {significant(outcome.sweep.values[index])}"]
        low, high = mean[index] - width[index], mean[index] + width[index]
        assert found[:3] == list(number(mean[index], low, high))
        assert found[3] == (significant(outcome.mean(1)[0][index]) if blind else "")


def test_what_cannot_be_run_is_told_as_unstable():
    gains = "order=2&design=manual&alpha=0.5&beta=0.3"
    _, outcome, shown = played(f"samples=60&tune_runs=2&points=9&{gains}&against=alpha&from=0.5&to=2.5")
    assert not outcome.stable[-1]
    assert shown["rows"]["told-values"][-1][1:] == ["unstable", "", "", ""]


def test_the_best_cells_of_a_map_are_told_in_numbers():
    _, outcome, shown = played(f"{SHORT}&tune=map&order=2")
    rows, means = shown["rows"]["told-cells"], np.sort(outcome.scores[0].mean(axis=0))
    assert len(rows) == MOST_CELLS
    alpha, beta = outcome.vectors[outcome.best()]
    assert rows[0][0] == f"α = {significant(alpha, 3)}, β = {significant(beta, 3)}"
    assert [float(row[1]) for row in rows] == pytest.approx(means[:MOST_CELLS], rel=1e-2)
    assert all(float(row[2]) < float(row[1]) < float(row[3]) for row in rows)


def test_a_search_begins_without_gains(searched):
    study, outcome, _ = searched
    _, content = begin(
        StudyQuestion(seq=1, query="samples=60&tune_runs=6&tune=search&budget=2000&order=2&seed=3", theme="light")
    )
    begun = replace(outcome, gains=None, score=np.inf, history=(), rivals=(), fresh=None, tried=0)
    shown = content(Progress(0, study.steps, begun))
    assert (shown["texts"]["best"], shown["rows"], shown["offers"]) == (
        "The designs are tried.", {table: [] for table in ("rivals", *TABLES)}, {"use": None},
    )  # fmt: skip
    under_way = content(Progress(1, study.steps, replace(outcome, fresh=None)))
    assert under_way["texts"]["best"].startswith("Best so far: α = ")
    assert [row[3] for row in under_way["rows"]["rivals"]] == [""] * (1 + len(outcome.rivals))


def test_a_search_does_not_depend_on_the_present_gains():
    studies = [study_of(settings_of(f"tune=search&order=3&xi={xi}")) for xi in (0.3, 0.7)]
    assert studies[0] == studies[1]
    bank = study_of(settings_of("tune=search&order=3&design=critically-damped-bank"))
    assert bank == studies[0]


def test_of_designs_that_are_the_same_filter_the_kalman_filter_is_named(searched):
    _, outcome, shown = searched
    kalman = outcome.rivals[outcome.kalman]
    best = outcome.rivals[outcome.best_rival]
    if kalman.score <= best.score * (1 + 1e-9):
        assert "Steady Kalman" in shown["texts"]["best"]
    worse = replace(outcome, fresh=replace(outcome.fresh, differences=(Interval(0, -1, 1),) * len(outcome.rivals)))
    assert found_text(worse, complete=True).endswith("is not shown to be worse.")
