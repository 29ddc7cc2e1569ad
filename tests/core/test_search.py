"""The search for all gains: the true optimum beside other optimisers, fair rivals, fresh runs, bounds."""

import pickle
from dataclasses import replace
from functools import cache
from math import isfinite

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar
from scipy.stats import ttest_1samp

from tracker_core import DESIGNS, Experiment, Gains, InputError, run_experiment
from tracker_core.design.curves import curve_designs
from tracker_core.reflections import gains_at, place_of
from tracker_core.stability import is_stable, stable
from tracker_core.tuning import Search, evaluate
from tracker_core.tuning.base import MOST_STEPS
from tracker_core.tuning.rivals import KALMAN
from tracker_core.tuning.search import BUDGET

SMALL = {"samples": 50, "seed": 4}
SMALL_BUDGET = 4_000
SPACE = {"scenario": "climbing-turn"}
CASES = {
    "ship 2": Search(Experiment.from_dict(SMALL | {"order": 2, "xi": 0.5}), "estimation_rmse", 4, budget=SMALL_BUDGET),
    "turn 3": Search(
        Experiment.from_dict(SMALL | {"scenario": "climbing-turn", "order": 3, "xi": 0.5}), "tracking_total", 4
    ),
    "worst 3": Search(Experiment.from_dict(SMALL | {"order": 3, "xi": 0.5}), "estimation_max", 3),
    "ship 4": Search(
        Experiment.from_dict(SMALL | {"order": 4, "xi": 0.5, "convention": "half"}), "tracking_rmse", 3
    ),
    "innovation 4": Search(
        Experiment.from_dict(SMALL | {"scenario": "climbing-turn", "order": 4, "xi": 0.5}), "innovation_rmse", 3
    ),
    "noise and lag 4": Search(Experiment.from_dict(SMALL | {"order": 4, "xi": 0.5}), "noise_lag", weight=0.7),
}  # fmt: skip
EACH = pytest.mark.parametrize("case", CASES)


@cache
def stages(case):
    return tuple(CASES[case].stream())


def outcome(case):
    return stages(case)[-1].outcome


def by_hand(search, vectors):
    """Mean scores, one experiment after the other."""
    found = []
    for vector in vectors:
        values = dict(zip(("alpha", "beta", "gamma", "eta"), Gains.normalised(vector).values, strict=False))
        plain = {**search.experiment.to_dict(), "design": "manual", "convention": "normalised", "xi": None, **values}
        runs = [
            run_experiment(Experiment.from_dict(plain | {"seed": search.experiment.seed + run}))
            for run in range(search.drawn)
        ]
        found.append(np.mean([getattr(run.metrics, search.objective) for run in runs]))
    return np.array(found)


def by_batch(search, vectors, seed=0):
    """Mean scores, infinite for what is not stable."""
    experiment = replace(search.experiment, seed=search.experiment.seed + seed)
    *_, (_, _, scores) = evaluate.scored(
        experiment, np.asarray(vectors), [search.objective], search.drawn, search.weight, None
    )
    return np.where(stable(np.asarray(vectors)), scores[0].mean(axis=0), np.inf)


# The optimum -------------------------------------------------------------------------------------------------------


def test_a_fine_grid_finds_nothing_better():
    search = CASES["ship 2"]
    found = outcome("ship 2")
    alpha, beta = np.meshgrid(np.linspace(0.01, 1.99, 199), np.linspace(0.01, 3.99, 200))
    grid = np.stack((alpha.ravel(), beta.ravel()), axis=1)
    grid = grid[stable(grid)]
    best = grid[int(np.argmin(by_batch(search, grid)))]
    finer = best + 0.02 * (np.stack(np.meshgrid(*[np.linspace(-1, 1, 41)] * 2), axis=-1).reshape(-1, 2))
    least = by_batch(search, finer).min()
    assert found.score == pytest.approx(least, rel=1e-5)
    assert found.score <= least * (1 + 1e-9)
    # That is what the filter itself does.
    assert by_hand(search, [found.gains.vector])[0] == pytest.approx(found.score, rel=1e-11)


@pytest.mark.parametrize("case", [name for name in CASES if name != "ship 2"])
def test_another_optimiser_from_many_starts_finds_nothing_better(case):
    search, order = CASES[case], CASES[case].experiment.order
    draw = np.random.default_rng(8)
    fading = [place_of(Gains.normalised(DESIGNS["fading-memory"].gains(order, xi=xi))) for xi in (0.3, 0.5, 0.7, 0.85)]
    starts = np.concatenate((fading, fading[2] + draw.standard_normal((300, order))))
    starts = starts[np.argsort(by_batch(search, gains_at(starts)))[:6]]

    def score(place):
        return min(1e9, float(by_batch(search, gains_at(np.clip(place, -12, 12))[None])[0]))

    options = {"xatol": 1e-4, "fatol": 1e-7, "maxfev": 700}
    least = min(minimize(score, start, method="Nelder-Mead", options=options).fun for start in starts)
    assert outcome(case).score <= least * 1.001


@EACH
def test_the_score_is_that_of_the_gains(case):
    found = outcome(case)
    assert is_stable(found.gains)
    assert found.gains.convention == CASES[case].experiment.convention
    assert by_batch(CASES[case], [found.gains.vector])[0] == pytest.approx(found.score, rel=1e-12)


def test_filters_slower_than_any_design_are_found():
    """A target that does not manoeuvre, a long run: the less gain the better."""
    experiment = Experiment.from_dict(
        {"scenario": "constant-velocity", "order": 2, "xi": 0.5, "samples": 2_000, "start": "known"}
    )
    *_, last = Search(experiment, "estimation_rmse", 2, budget=BUDGET.low).stream()
    assert last.outcome.gains.vector[1] < 1e-6
    assert last.outcome.score <= min(rival.score for rival in last.outcome.rivals)


# Rivals ------------------------------------------------------------------------------------------------------------


@EACH
def test_every_design_of_one_parameter_is_a_rival_at_its_best(case):
    search, rivals = CASES[case], outcome(case).rivals
    order = search.experiment.order
    assert [rival.design for rival in rivals] == list(curve_designs(order))
    for rival in rivals:
        design = DESIGNS[rival.design]
        assert design.gains(order, **{rival.parameter: rival.value}) == pytest.approx(np.array(rival.vector), rel=1e-14)
        assert by_batch(search, [rival.vector])[0] == pytest.approx(rival.score, rel=1e-12)
        assert rival.score >= outcome(case).score


@pytest.mark.parametrize("case", ["ship 2", "turn 3", "ship 4"])
def test_another_optimiser_finds_no_better_value_for_a_rival(case):
    search = CASES[case]
    for rival in outcome(case).rivals:

        def score(value, rival=rival):
            return by_batch(search, [DESIGNS[rival.design].gains(search.experiment.order, **{rival.parameter: value})])[
                0
            ]

        reach = 0.1 * rival.value
        domain = DESIGNS[rival.design].parameters[rival.parameter]
        bounds = max(domain.low, rival.value - reach), min(domain.high, rival.value + reach)
        near = minimize_scalar(score, bounds=bounds, method="bounded", options={"xatol": 1e-7})
        assert rival.score <= near.fun * (1 + 1e-4)


@EACH
def test_the_steady_kalman_filter_is_named(case):
    found = outcome(case)
    kalman = found.rivals[found.kalman]
    assert kalman.design == KALMAN
    assert kalman.is_kalman
    assert kalman.title == "Steady Kalman"
    assert found.rivals[found.best_rival].score == min(rival.score for rival in found.rivals)


def test_an_unstable_rival_is_not_taken():
    """Over five samples gains that are not stable may have the least error."""
    experiment = Experiment.from_dict({"samples": 5, "order": 2, "xi": 0.5})
    *_, last = Search(experiment, "tracking_rmse", 3, budget=BUDGET.low).stream()
    assert all(is_stable(Gains.normalised(rival.vector)) for rival in last.outcome.rivals)


# Fresh runs --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", ["ship 2", "worst 3", "ship 4"])
def test_fresh_runs_are_those_after_the_search(case):
    search, found = CASES[case], outcome(case)
    later = replace(search, experiment=replace(search.experiment, seed=search.experiment.seed + search.runs))
    own = by_hand(later, [found.gains.vector])[0]
    assert found.fresh.runs == search.runs
    assert found.fresh.score.mean == pytest.approx(own, rel=1e-11)
    for number, rival in enumerate(found.rivals):
        mean = by_hand(later, [rival.vector])[0]
        assert found.fresh.rivals[number].mean == pytest.approx(mean, rel=1e-11)
        assert found.fresh.differences[number].mean == pytest.approx(mean - own, rel=1e-9)
        assert found.fresh.percents[number].mean == pytest.approx(100 * (mean - own) / own, rel=1e-9)


def test_intervals_are_those_of_paired_differences():
    search, found = CASES["ship 2"], outcome("ship 2")
    each = []
    for run in range(search.runs):
        single = replace(search, runs=1, experiment=replace(search.experiment, seed=4 + search.runs + run))
        each.append(by_hand(single, [found.gains.vector, *(rival.vector for rival in found.rivals)]))
    each = np.array(each)
    for number, interval in enumerate(found.fresh.differences):
        expected = ttest_1samp(each[:, 1 + number] - each[:, 0], 0).confidence_interval(0.95)
        assert (interval.low, interval.high) == pytest.approx((expected.low, expected.high), rel=1e-8)
        assert found.fresh.worse(number) == (expected.low > 0)
        # In percent, as if the ratio of the means were known: the delta method.
        rest = each[:, 1 + number] - each[:, 1 + number].mean() / each[:, 0].mean() * each[:, 0]
        ratio = ttest_1samp(rest, 0).confidence_interval(0.95)
        percent, size = found.fresh.percents[number], each[:, 0].mean()
        assert percent.high - percent.mean == pytest.approx(100 * ratio.high / size, rel=1e-6, abs=1e-9)


def test_what_a_search_learns_by_heart_is_not_sold():
    """Chosen by two runs, the found gains beat the rivals there; in two hundred others they lose."""
    experiment = Experiment.from_dict({"samples": 40, "order": 4, "xi": 0.5, "seed": 9})
    search = Search(experiment, "estimation_max", 2)
    *_, last = search.stream()
    found, rival = last.outcome, last.outcome.rivals[last.outcome.best_rival]
    assert found.score < 0.95 * rival.score
    many = replace(search, runs=200)
    own, other = by_batch(many, [found.gains.vector, rival.vector], seed=2)
    assert own > 0.97 * other
    assert not found.fresh.worse(found.best_rival)


def test_nothing_left_to_chance_needs_no_fresh_runs():
    experiment = Experiment.from_dict({"samples": 50, "noise": "none", "order": 2, "xi": 0.5})
    *_, last = Search(experiment, "estimation_rmse", 20, budget=BUDGET.low).stream()
    assert last.outcome.search.drawn == 1
    assert last.outcome.fresh is None
    assert outcome("noise and lag 4").fresh is None


# The stream --------------------------------------------------------------------------------------------------------


@EACH
def test_progress_grows_to_the_end(case):
    search, progress = CASES[case], stages(case)
    done = [stage.done for stage in progress]
    assert done == sorted(done)
    assert all(stage.done <= stage.of for stage in progress)
    assert progress[-1].done == progress[-1].of <= search.steps
    assert progress[-1].outcome.tried <= search.budget
    scores = [stage.outcome.score for stage in progress]
    assert scores == sorted(scores, reverse=True)
    assert isfinite(scores[-1])
    assert list(progress[-1].outcome.history) == sorted(progress[-1].outcome.history, reverse=True)
    assert progress[0].outcome.rivals == ()
    assert progress[0].outcome.kalman is progress[0].outcome.best_rival is None
    assert all(stage.outcome.rivals for stage in progress if stage.outcome.history)


def test_the_same_search_gives_the_same_bits():
    search = replace(CASES["turn 3"], budget=SMALL_BUDGET)
    first, again = (list(search.stream())[-1].outcome for _ in range(2))
    assert first == again


def test_a_budget_ends_the_search():
    search = replace(CASES["ship 4"], budget=BUDGET.low)
    *_, last = search.stream()
    assert last.outcome.tried <= BUDGET.low
    assert last.outcome.score < min(rival.score for rival in last.outcome.rivals)


def test_a_search_is_a_value():
    search = CASES["ship 4"]
    assert pickle.loads(pickle.dumps(search)) == search
    assert hash(search) == hash(replace(search))


def test_a_method_s_gains_do_not_matter():
    """The runs are the same whatever filters them at present."""
    bank = Experiment.from_dict(SMALL | {"order": 2, "design": "parallel-bank"})
    *_, last = replace(CASES["ship 2"], experiment=bank).stream()
    assert last.outcome.gains == outcome("ship 2").gains


# Bounds ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"objective": "speed"}, "^objective must be one of"),
        ({"runs": 0}, "^runs must be a whole number >= 1"),
        ({"runs": 10**9}, "^runs must be a whole number >= 1 and <= 1,000"),
        ({"weight": 1.5}, "^weight must be"),
        ({"budget": 10}, "^budget must be a whole number >= 2,000"),
        ({"budget": 10**9}, "^budget must be"),
        ({"experiment": {"samples": 200_000}, "runs": 30}, f"^runs must be so small .* {MOST_STEPS:,}"),
        ({"experiment": SPACE | {"samples": 200_000}, "budget": 200_000}, "^samples must be <= 166,"),
        ({"experiment": {"seed": 2**53 - 5}, "runs": 5}, "^seed must be"),
    ],
)
def test_what_cannot_be_searched_is_refused(change, message):
    experiment = Experiment.from_dict(change.pop("experiment", {}))
    with pytest.raises(InputError, match=message):
        Search(**({"experiment": experiment, "objective": "estimation_rmse"} | change))


def test_the_most_samples_that_are_named_are_taken():
    with pytest.raises(InputError, match="samples") as refused:
        Search(Experiment.from_dict(SPACE | {"samples": 200_000}), "estimation_rmse", 1, budget=200_000)
    most = int(refused.value.rule.split("<= ")[1].split(" ")[0].replace(",", ""))
    for samples in (most, most + 1):
        experiment = Experiment.from_dict(SPACE | {"samples": samples})
        if samples == most:
            Search(experiment, "estimation_rmse", 1, budget=200_000)
        else:
            with pytest.raises(InputError, match="samples"):
                Search(experiment, "estimation_rmse", 1, budget=200_000)
