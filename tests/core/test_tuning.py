"""Studies: every score is that of a run of its own, the same bits on any executor, and bounds on everything."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from math import isnan, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker_core import METRICS, Experiment, Gains, InputError, run_experiment
from tracker_core.region import region_slice
from tracker_core.responses import variance_reduction
from tracker_core.run import observe
from tracker_core.stability import is_stable
from tracker_core.statistics import t_quantile
from tracker_core.tuning import OBJECTIVES, PARAMETERS, Map, MonteCarlo, Sweep, evaluate, monte_carlo
from tracker_core.tuning.base import MOST_SCORES, MOST_STEPS, has_chance
from tracker_core.tuning.executors import ordered
from tracker_core.tuning.monte_carlo import FIGURES
from tracker_core.tuning.sweeps import offered, usual_values, varied

SHORT = {"samples": 60, "seed": 4}
TARGETS = {
    "ship": SHORT,
    "singer": SHORT | {"scenario": "singer", "order": 2, "xi": 0.6},
    "pushed": SHORT | {"manoeuvre": "acceleration-pulses", "manoeuvre_std": 0.5, "order": 2, "xi": 0.6},
    "known start": SHORT | {"start": "known", "order": 4, "xi": 0.7},
    "expanding": SHORT | {"start": "expanding"},
    "coloured": SHORT | {"noise": "coloured", "noise_std": "5,20"},
}
RUN_OBJECTIVES = tuple(name for name in OBJECTIVES if name in METRICS)


def last(study, executor=None):
    *_, progress = study.stream(executor)
    assert progress.done == progress.of
    return progress.outcome


# What is varied ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("parameter", PARAMETERS)
@pytest.mark.parametrize("order", [2, 3, 4])
def test_a_parameter_sets_what_it_says(parameter, order):
    experiment = Experiment.from_dict({"order": order, "design": "fading-memory", "xi": 0.7, "interval": 2.0})
    if parameter not in offered(experiment):
        with pytest.raises(InputError, match=f"^parameter must be a gain of order {order}"):
            varied(experiment, parameter, 0.3)
        return
    changed = varied(experiment, parameter, 0.3)
    names = ("alpha", "beta", "gamma", "eta")[:order]
    if parameter in names:
        held = dict(zip(names, experiment.gains().values, strict=True)) | {parameter: 0.3}
        assert changed.gains().values == tuple(held.values())
    elif parameter == "xi":
        assert changed == replace(experiment, xi=0.3)
    else:
        expected = {
            "tracking_index": 0.3, "process_variance": {2: 4, 3: 4, 4: 8}[order] * sqrt(0.3),
            "sensor_variance": 1 / sqrt(0.3),
        }[parameter]  # fmt: skip
        assert changed.tracking_index == pytest.approx(expected, rel=1e-15)
        assert changed.order == order
    for name in ("scenario", "samples", "interval", "noise_std", "seed", "start", "convention"):
        assert getattr(changed, name) == getattr(experiment, name)


def test_a_method_offers_no_gains():
    bank = Experiment.from_dict({"design": "parallel-bank", "order": 2})
    assert not {"alpha", "beta"} & {*offered(bank)}
    with pytest.raises(InputError, match="^parameter must not be a gain"):
        varied(bank, "alpha", 0.3)
    assert varied(bank, "xi", 0.3).design == "fading-memory"


@pytest.mark.parametrize("convention", ["normalised", "taylor", "half"])
@pytest.mark.parametrize("order", [2, 3, 4])
def test_gains_are_varied_over_their_stable_interval(order, convention):
    experiment = Experiment.from_dict({"order": order, "xi": 0.6, "convention": convention})
    for parameter in ("alpha", "beta", "gamma", "eta")[:order]:
        values = usual_values(experiment, parameter, points=40)
        assert all(is_stable(varied(experiment, parameter, value).gains()) for value in values)
        step = values[1] - values[0]
        for beyond in (values[0] - step, values[-1] + step):
            assert beyond < 0 or not is_stable(varied(experiment, parameter, beyond).gains())


def test_ends_that_are_given_are_taken():
    experiment = Experiment.from_dict({})
    assert usual_values(experiment, "xi", 0.2, 0.4, 3) == pytest.approx((0.2, 0.3, 0.4))
    assert usual_values(experiment, "tracking_index", 0.01, 1.0, 3) == pytest.approx((0.01, 0.1, 1.0))
    assert usual_values(experiment, "xi")[0] == 0
    for low, high, rule in (
        (0.5, 0.4, "high must be > 0.5"),
        (0.5, 0.5, "high must be >"),
        (1.5, None, "low must be < 0.99"),
        (None, -1.0, "high must be > 0"),
    ):
        with pytest.raises(InputError, match=f"^{rule}"):
            usual_values(experiment, "xi", low, high)
    with pytest.raises(InputError, match="^low must be"):
        usual_values(experiment, "tracking_index", 0.0, 1.0)
    with pytest.raises(InputError, match="^points must be"):
        usual_values(experiment, "xi", points=1)


# Sweeps ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("objective", RUN_OBJECTIVES)
def test_every_score_is_that_of_a_run(target, objective):
    experiment = Experiment.from_dict(TARGETS[target])
    sweep = Sweep(experiment, "xi", (0.3, 0.6, 0.9), objective, runs=3)
    outcome = last(sweep)
    assert outcome.scores.shape == (1, 3, 3)
    for run in range(3):
        for column, value in enumerate(sweep.values):
            single = replace(experiment, seed=experiment.seed + run, xi=value)
            expected = getattr(run_experiment(single).metrics, objective)
            assert outcome.scores[0, run, column] == pytest.approx(expected, rel=1e-11, abs=0)


def test_several_objectives_come_from_the_same_runs():
    experiment = Experiment.from_dict(SHORT)
    values = (0.4, 0.6, 0.8)
    both = last(Sweep(experiment, "xi", values, "innovation_rmse", 4, beside=("estimation_rmse", "noise_lag")))
    for row, name in enumerate(("innovation_rmse", "estimation_rmse", "noise_lag")):
        runs = 1 if name == "noise_lag" else 4
        alone = last(Sweep(experiment, "xi", values, name, runs)).scores[0]
        assert np.array_equal(both.scores[row], np.broadcast_to(alone, (4, 3)))


def test_the_optimum_is_where_the_mean_is_least():
    experiment = Experiment.from_dict({"seed": 1})
    coarse = last(Sweep(experiment, "xi", usual_values(experiment, "xi", points=41), "estimation_rmse", 30))
    fine = last(Sweep(experiment, "xi", usual_values(experiment, "xi", points=1_001), "estimation_rmse", 30))
    optimum = coarse.optimum()
    assert optimum.value == pytest.approx(fine.sweep.values[int(np.argmin(fine.mean()[0]))], abs=0.003)
    assert optimum.low < optimum.value < optimum.high
    assert optimum.score.mean == pytest.approx(coarse.mean()[0].min(), rel=1e-14)
    assert optimum.score.low < optimum.score.mean < optimum.score.high
    assert not optimum.at_edge


def test_the_optimum_of_other_seeds_lies_in_the_interval_as_often_as_it_says():
    """Twenty disjoint lots of 30 runs beside the optimum of 600: at least 15 of 20 intervals at 95 % hold it."""
    experiment = Experiment.from_dict({"samples": 100})
    values = usual_values(experiment, "xi", 0.3, 0.9, 41)
    whole = last(Sweep(experiment, "xi", values, "estimation_rmse", 600)).optimum().value
    hits = 0
    for lot in range(20):
        own = last(Sweep(replace(experiment, seed=1_000 + 30 * lot), "xi", values, "estimation_rmse", 30)).optimum()
        hits += own.low <= whole <= own.high
    assert hits >= 15


def test_unstable_values_are_no_optimum():
    """Over a few samples an unstable filter may have the least error."""
    experiment = Experiment.from_dict({"order": 2, "design": "manual", "alpha": 0.5, "beta": 0.4, "samples": 5})
    sweep = Sweep(experiment, "beta", tuple(np.linspace(0.1, 5.0, 50)), "tracking_total", 10)
    outcome = last(sweep)
    assert not outcome.stable[-1]
    assert outcome.stable[outcome.optimum().index]
    everywhere = replace(sweep, values=tuple(np.linspace(3.5, 5.0, 9)))
    nothing = last(everywhere).optimum()
    assert isnan(nothing.value)
    assert isnan(nothing.score.mean)


def percent_width(one, other):
    """Half the interval of a ratio of paired means, in percent: as if the ratio were known (the delta method)."""
    rest = one - one.mean() / other.mean() * other
    return 100 * t_quantile(0.95, len(one) - 1) * rest.std(ddof=1) / sqrt(len(one)) / other.mean()


def test_what_tuning_without_the_truth_costs():
    experiment = Experiment.from_dict({})
    values = usual_values(experiment, "xi", points=41)
    outcome = last(Sweep(experiment, "xi", values, "innovation_rmse", 20, beside=("estimation_rmse",)))
    taken, best = (int(np.argmin(outcome.scores[row].mean(axis=0))) for row in (0, 1))
    judged = outcome.scores[1]
    expected = 100 * (judged[:, taken].mean() / judged[:, best].mean() - 1)
    cost = outcome.cost(0, 1)
    assert cost.mean == pytest.approx(expected, rel=1e-12)
    assert 0 <= cost.low < cost.mean < cost.high
    assert cost.high - cost.mean == pytest.approx(percent_width(judged[:, taken], judged[:, best]), rel=1e-9)
    assert outcome.cost(1, 1).mean == 0
    still = Experiment.from_dict({"scenario": "constant-velocity", "noise": "none", "order": 2})
    without = last(Sweep(still, "xi", (0.3, 0.5), "innovation_rmse", beside=("estimation_rmse",)))
    assert without.scores[1].min() == 0
    assert isnan(without.cost(0, 1).mean)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_noise_against_lag(order):
    """Beside the Lyapunov equation and a filter that follows a polynomial."""
    experiment = Experiment.from_dict(
        {"scenario": "coordinated-turn", "order": order, "interval": 0.5, "noise_std": "3,4", "xi": 0.7}
    )
    outcome = last(Sweep(experiment, "xi", (0.5, 0.7), "noise_lag", weight=0.3))
    truth = observe(experiment)[0]
    for column, value in enumerate(outcome.sweep.values):
        gains = replace(experiment, xi=value).gains()
        variance = 25 * variance_reduction(gains).smoothed[0]
        strength = np.sqrt(np.mean(np.sum(truth.states[:, :, order] ** 2, axis=1)))
        lag = abs(steady_lag_by_running(gains)) * 0.5**order * strength
        assert outcome.scores[0, 0, column] == pytest.approx(sqrt(0.3 * variance + 0.7 * lag**2), rel=1e-8)


def steady_lag_by_running(gains):
    """The smoothed error under a unit m-th derivative at T = 1, after a long time."""
    order = gains.order
    g, state, x = gains.vector, np.zeros(order), 0.0
    for step in range(1, 400):
        predicted = np.array(
            [sum(state[c] / np.prod(range(1, c - r + 1)) for c in range(r, order)) for r in range(order)]
        )
        x = step**order / float(np.prod(range(1, order + 1)))
        state = predicted + g * (x - predicted[0])
    return x - state[0]


# Maps --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("order", "plane"), [(2, ("alpha", "beta")), (3, ("beta", "gamma")), (4, ("alpha", "eta"))])
def test_every_cell_of_a_map_is_a_run_with_its_gains(order, plane):
    experiment = Experiment.from_dict(SHORT | {"order": order, "xi": 0.7, "convention": "taylor"})
    study = Map(experiment, plane, "tracking_rmse", columns=7, rows=6, runs=2)
    outcome = last(study)
    assert outcome.stable.shape == (6, 7)
    assert outcome.stable.any()
    mean, cell = outcome.mean(), 0
    names = ("alpha", "beta", "gamma", "eta")[:order]
    for row, up in enumerate(outcome.y):
        for column, across in enumerate(outcome.x):
            held = dict(zip(names, experiment.gains().vector, strict=True)) | {plane[0]: across, plane[1]: up}
            gains = Gains.normalised(tuple(held.values()))
            assert outcome.stable[row, column] == is_stable(gains)
            if not outcome.stable[row, column]:
                assert isnan(mean[row, column])
                continue
            assert study.at(outcome.vectors[cell]).convention == "taylor"
            manual = Experiment.from_dict(
                SHORT | {"order": order, "design": "manual"} | {n: float(v) for n, v in held.items()}
            )
            errors = [run_experiment(replace(manual, seed=4 + run)).metrics.tracking_rmse for run in range(2)]
            assert outcome.scores[0, :, cell] == pytest.approx(errors, rel=1e-10)
            assert mean[row, column] == pytest.approx(np.mean(errors), rel=1e-10)
            cell += 1
    assert cell == len(outcome.vectors)


def test_what_not_knowing_the_truth_costs_on_a_map():
    experiment = Experiment.from_dict(SHORT | {"order": 2})
    study = Map(experiment, ("alpha", "beta"), "innovation_rmse", 12, 12, runs=6, beside=("estimation_rmse",))
    outcome = last(study)
    judged, (taken, best) = outcome.scores[1], (outcome.best(0), outcome.best(1))
    cost = outcome.cost(0, 1)
    assert taken != best
    assert cost.mean == pytest.approx(100 * (judged[:, taken].mean() / judged[:, best].mean() - 1), rel=1e-9)
    assert cost.high - cost.mean == pytest.approx(percent_width(judged[:, taken], judged[:, best]), rel=1e-9)
    assert isnan(replace(outcome, scores=0 * outcome.scores).cost(0, 1).mean)


def test_the_best_cell_and_its_company():
    experiment = Experiment.from_dict({"order": 2, "xi": 0.6})
    outcome = last(Map(experiment, ("alpha", "beta"), "estimation_rmse", 30, 30, runs=20))
    best = outcome.best()
    assert outcome.scores[0].mean(axis=0)[best] == np.nanmin(outcome.mean())
    near = outcome.near_best()
    assert near[best]
    assert 1 < near.sum() < len(near) / 10
    # Cells beyond are worse by a one-sided t-test of the differences, the others are not.
    differences = outcome.scores[0] - outcome.scores[0][:, [best]]
    error = differences.std(axis=0, ddof=1) / sqrt(20)
    t = differences.mean(axis=0) / np.where(error > 0, error, 1)
    assert np.array_equal(near, t <= t_quantile(0.9, 19))
    alone = last(Map(experiment, ("alpha", "beta"), "estimation_rmse", 30, 30, runs=1))
    assert alone.near_best().sum() == 1


def test_the_ranges_of_the_best_cells_go_from_edge_to_edge():
    experiment = Experiment.from_dict({"order": 3, "xi": 0.6})
    study = Map(experiment, ("beta", "gamma"), "estimation_rmse", 30, 24, runs=8)
    outcome = last(study)
    near = outcome.vectors[outcome.near_best()]
    # The box around the region is known, and so are the sides of its cells.
    border = region_slice(experiment.gains(), study.plane)
    for gain, side, count, (low, high) in zip((1, 2), border, (30, 24), outcome.near_ranges(), strict=True):
        half = (side.max() - side.min()) / count / 2
        assert low == pytest.approx(near[:, gain].min() - half, rel=1e-9, abs=1e-12)
        assert high == pytest.approx(near[:, gain].max() + half, rel=1e-9)
    single = last(replace(study, runs=1))
    best = single.vectors[single.best()]
    for gain, along, (low, high) in zip((1, 2), (single.x, single.y), single.near_ranges(), strict=True):
        assert high - low == pytest.approx(along[1] - along[0], rel=1e-9)
        assert (low + high) / 2 == pytest.approx(best[gain], rel=1e-9)
    assert replace(single, scores=single.scores * np.nan).near_ranges() is None
    # The lowest row reaches down to where its gain vanishes.
    everywhere = replace(outcome, scores=np.ones_like(outcome.scores))
    assert everywhere.near_ranges()[1][0] == 0


# Comparisons -------------------------------------------------------------------------------------------------------

RIVALS = (
    {"order": 2, "xi": 0.6},
    {"order": 3, "xi": 0.64},
    {"order": 3, "xi": 0.64, "start": "three-point"},
    {"order": 2, "design": "parallel-bank"},
)


def rivals(**more):
    return tuple(Experiment.from_dict(SHORT | more | values) for values in RIVALS)


@pytest.mark.parametrize("more", [{}, {"scenario": "singer"}], ids=["ship", "singer"])
def test_a_comparison_is_that_of_the_runs_themselves(more):
    filters = rivals(**more)
    comparison = last(MonteCarlo(filters, 12))
    values = np.array(
        [
            [[getattr(run_experiment(replace(one, seed=4 + run)).metrics, name) for name in FIGURES] for one in filters]
            for run in range(12)
        ]
    )
    assert comparison.runs == 12
    assert comparison.stopped.tolist() == [0] * len(filters)
    for column, figure in enumerate(FIGURES):
        for i in range(len(filters)):
            own = comparison.own(figure, i)
            assert own.mean == pytest.approx(values[:, i, column].mean(), rel=1e-10)
            for j in range(len(filters)):
                if i == j:
                    continue
                found = comparison.difference(figure, i, j)
                gaps = values[:, i, column] - values[:, j, column]
                width = t_quantile(1 - 0.05 / 3, 11) * gaps.std(ddof=1) / sqrt(12)
                assert found.interval.mean == pytest.approx(gaps.mean(), rel=1e-8, abs=1e-9)
                assert found.interval.high - found.interval.mean == pytest.approx(width, rel=1e-7, abs=1e-9)
                assert found.significant == (abs(gaps.mean()) > width)
                # The delta method: as if the ratio were known, the mean of i - ratio j is what is uncertain.
                first, other = values[:, i, column], values[:, j, column]
                ratio, size = first.mean() / other.mean(), abs(other.mean())
                width = t_quantile(1 - 0.05 / 3, 11) * (first - ratio * other).std(ddof=1) / sqrt(12)
                percent = 100 * gaps.mean() / size
                assert found.percent.mean == pytest.approx(percent, rel=1e-8, abs=1e-9)
                assert found.percent.high - found.percent.mean == pytest.approx(100 * width / size, rel=1e-6, abs=1e-6)
                assert found.percent.low + found.percent.high == pytest.approx(2 * percent, rel=1e-8, abs=1e-9)
                back = comparison.difference(figure, j, i)
                assert (back.interval.low, back.interval.high) == (-found.interval.high, -found.interval.low)


def test_a_run_without_a_prediction_has_not_stopped():
    """As many samples as the start needs leave nothing to predict; the others of its figures are there."""
    short = Experiment.from_dict(SHORT | {"samples": 3, "start": "three-point", "order": 3, "xi": 0.5})
    comparison = last(MonteCarlo((short,), 20))
    assert comparison.stopped.tolist() == [0]
    assert comparison.own("estimation_rmse", 0).mean > 0
    assert isnan(comparison.own("tracking_rmse", 0).mean)


def test_seeds_that_run_out_are_refused_before_anything_is_run():
    late = Experiment.from_dict(SHORT | {"seed": 2**53 - 2, "xi": 0.5})
    studies = (
        lambda runs: MonteCarlo((late,), runs),
        lambda runs: Sweep(late, "xi", (0.4, 0.6), "estimation_rmse", runs),
        lambda runs: Map(late, ("alpha", "beta"), "estimation_rmse", 5, 5, runs=runs),
    )
    for study in studies:
        study(2)
        with pytest.raises(InputError, match="^seed must be"):
            study(3)


def test_a_filter_that_leaves_the_world_is_counted_and_compared_where_it_stayed():
    wild = {"order": 2, "design": "manual", "alpha": 0.9, "beta": 3.5, "samples": 200}
    calm = Experiment.from_dict(SHORT | {"order": 2, "xi": 0.6, "samples": 200})
    comparison = last(MonteCarlo((calm, Experiment.from_dict(SHORT | wild)), 6))
    assert comparison.stopped.tolist() == [0, 6]
    assert isnan(comparison.own("tracking_rmse", 1).mean)
    assert not isnan(comparison.own("tracking_rmse", 0).mean)
    found = comparison.difference("tracking_rmse", 1, 0)
    assert found.runs == 0
    assert not found.significant


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(1, 40), min_size=1, max_size=6), st.integers(0, 2**32 - 1))
def test_moments_merge_to_those_of_all_runs(sizes, seed):
    values = np.random.default_rng(seed).normal(100, 1, (sum(sizes), 3, 2))
    values[values > 102] = np.nan
    lots = np.split(values, np.cumsum(sizes)[:-1])
    merged = monte_carlo.Moments.of(lots[0])
    for lot in lots[1:]:
        merged = merged.merged(monte_carlo.Moments.of(lot))
    whole = monte_carlo.Moments.of(values)
    assert np.array_equal(merged.count, whole.count)
    assert merged.mean == pytest.approx(whole.mean, rel=1e-12, abs=1e-12)
    assert merged.square == pytest.approx(whole.square, rel=1e-9, abs=1e-9)


def test_no_difference_is_significant_as_seldom_as_it_says():
    """Of 400 comparisons of nothing but noise at 95 % some 20 are significant by chance, 4 sigma either way."""
    rng, chance = np.random.default_rng(9), 0
    for _ in range(400):
        moments = monte_carlo.Moments.of(rng.normal(0, 1, (25, 2, len(FIGURES))))
        chance += (
            monte_carlo.Comparison(2, 25, np.zeros(2, int), moments).difference("estimation_rmse", 1, 0).significant
        )
    assert 20 - 18 <= chance <= 20 + 18


@pytest.mark.parametrize("shared", [0.0, 0.9], ids=["apart", "together"])
@pytest.mark.parametrize("ratio", [0.3, 1.0, 3.0])
def test_an_interval_in_percent_holds_as_often_as_it_says(ratio, shared):
    """Of 4,000 intervals of 95 % for a ratio of means some 200 miss it, 4 sigma and half a percent either way."""
    rng, missed, tried = np.random.default_rng(12), 0, 0
    while tried < 4_000:
        common, own = rng.normal(0, 0.2, (100, 1, len(FIGURES))), rng.normal(0, 0.2, (100, 2, len(FIGURES)))
        runs = (1 + shared * common + sqrt(1 - shared**2) * own) * np.array([1.0, ratio])[:, None]
        comparison = monte_carlo.Comparison(2, 100, np.zeros(2, int), monte_carlo.Moments.of(runs))
        for figure in FIGURES:
            percent = comparison.difference(figure, 1, 0).percent
            missed += not percent.low <= 100 * (ratio - 1) <= percent.high
            tried += 1
    assert abs(missed / tried - 0.05) <= 4 * sqrt(0.05 * 0.95 / tried) + 0.005


def test_an_interval_in_percent_is_that_of_runs_drawn_anew():
    rng = np.random.default_rng(3)
    reference = rng.gamma(16, 1, 400)
    values = np.stack([reference, 2 * reference * rng.gamma(25, 1 / 25, 400)], axis=1)
    moments = monte_carlo.Moments.of(np.repeat(values[:, :, None], len(FIGURES), axis=2))
    found = monte_carlo.Comparison(2, 400, np.zeros(2, int), moments).difference("estimation_rmse", 1, 0).percent
    drawn = rng.multinomial(400, np.full(400, 1 / 400), 20_000) @ values
    low, high = np.quantile(100 * (drawn[:, 1] / drawn[:, 0] - 1), [0.025, 0.975])
    assert (found.low, found.high) == pytest.approx((low, high), abs=0.05 * (high - low))


def test_filters_in_proportion_differ_by_a_percentage_that_is_certain():
    reference = np.random.default_rng(1).uniform(1, 2, (30, 1, len(FIGURES)))
    moments = monte_carlo.Moments.of(np.concatenate([reference, 3 * reference], axis=1))
    found = monte_carlo.Comparison(2, 30, np.zeros(2, int), moments).difference("estimation_rmse", 1, 0)
    assert (found.percent.low, found.percent.high) == pytest.approx((200, 200), abs=1e-4)
    assert found.interval.high - found.interval.low > 0.1


@pytest.mark.parametrize("missing", [[0], [1], [0, 1]])
def test_percent_are_known_where_both_filters_have_the_same_runs(missing):
    values = np.random.default_rng(5).uniform(1, 2, (20, 2, len(FIGURES)))
    values[7, missing] = np.nan
    comparison = monte_carlo.Comparison(2, 20, np.zeros(2, int), monte_carlo.Moments.of(values))
    found = comparison.difference("estimation_rmse", 1, 0)
    assert found.runs == 19
    assert not isnan(found.interval.low)
    assert isnan(found.percent.mean) == isnan(found.percent.low) == (len(missing) == 1)


# Executors and blocks ----------------------------------------------------------------------------------------------

STUDIES = {
    "sweep": Sweep(Experiment.from_dict(SHORT), "xi", (0.3, 0.5, 0.7), "estimation_rmse", 40),
    "map": Map(Experiment.from_dict(SHORT | {"order": 2, "xi": 0.6}), ("alpha", "beta"), "tracking_max", 20, 20, 3),
    "comparison": MonteCarlo(rivals(), 25),
}


def bits(outcome):
    return outcome.scores.tobytes() if hasattr(outcome, "scores") else outcome.moments.square.tobytes()


@pytest.mark.parametrize("name", STUDIES)
def test_the_same_bits_on_any_number_of_threads(name, monkeypatch):
    # Many small parts, so that they do come back out of order.
    monkeypatch.setattr(evaluate, "BLOCK_STEPS", 5_000)
    monkeypatch.setattr(monte_carlo, "BLOCK_STEPS", 200_000)
    found = set()
    for workers in (1, 2, 5):
        with ThreadPoolExecutor(workers) as pool:
            found.add(bits(last(STUDIES[name], pool)))
    found.add(bits(last(STUDIES[name])))
    assert len(found) == 1


@pytest.mark.parametrize("name", ["sweep", "map"])
def test_scores_do_not_depend_on_how_the_work_is_cut(name, monkeypatch):
    whole = bits(last(STUDIES[name]))
    for size in (1, 20_000, 10**9):
        monkeypatch.setattr(evaluate, "BLOCK_STEPS", size)
        assert bits(last(STUDIES[name])) == whole


@pytest.mark.parametrize("name", STUDIES)
def test_partial_results_are_those_of_the_first_runs(name, monkeypatch):
    monkeypatch.setattr(evaluate, "BLOCK_STEPS", 5_000)
    monkeypatch.setattr(monte_carlo, "BLOCK_STEPS", 200_000)
    study, seen, runs = STUDIES[name], 0, []
    for progress in study.stream():
        assert seen < progress.done <= progress.of
        seen = progress.done
        runs.append(progress.outcome.runs)
        if runs[-1] > 1 and hasattr(progress.outcome, "scores"):
            fewer = last(replace(study, runs=runs[-1]))
            assert bits(progress.outcome) == bits(fewer)
    assert seen == progress.of
    assert runs == sorted(runs)
    assert len(runs) > 3


def test_tasks_come_back_in_order_and_the_rest_is_cancelled():
    begun = []

    def work(number):
        begun.append(number)
        return number * number

    with ThreadPoolExecutor(3) as pool:
        assert list(ordered(pool, work, range(50))) == [n * n for n in range(50)]
        begun.clear()
        results = ordered(pool, work, range(10_000))
        assert [next(results) for _ in range(5)] == [0, 1, 4, 9, 16]
        results.close()
    assert len(begun) < 100


def test_an_error_in_a_part_reaches_the_caller():
    def work(number):
        raise InputError("number", "must be another", number)

    with ThreadPoolExecutor(1) as pool, pytest.raises(InputError, match="^number must be another"):
        list(ordered(pool, work, range(3)))


# Bounds ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("study", "changes", "message"),
    [
        ("sweep", {"runs": 0}, "^runs must be"),
        ("sweep", {"runs": 10**9}, "^runs must be a whole number >= 1 and <= 10,000"),
        ("sweep", {"parameter": "eta"}, "^parameter must be one of"),
        ("sweep", {"parameter": "speed"}, "^parameter must be one of"),
        ("sweep", {"objective": "joy"}, "^objective must be one of"),
        ("sweep", {"values": (0.5,)}, "^values must be"),
        ("sweep", {"values": (0.5, 0.4)}, "^values must increase"),
        ("sweep", {"values": (0.5, 1.4)}, "^xi must be"),
        ("sweep", {"weight": 1.5}, "^weight must be"),
        ("sweep", {"beside": ("joy",)}, "^objective must be one of"),
        ("map", {"columns": 10_000, "rows": 10_000}, "^columns must be a whole number >= 2 and <= 200"),
        ("map", {"rows": 10_000}, "^rows must be"),
        ("map", {"runs": 10**9}, "^runs must be a whole number >= 1 and <= 1,000"),
        ("map", {"plane": ("alpha", "gamma")}, "^plane must be two gains of order 2"),
        ("map", {"columns": 200, "rows": 200, "runs": 1_000}, f"^runs must be so small .* {MOST_SCORES:,} scores"),
        ("comparison", {"runs": 10**9}, "^runs must be a whole number >= 2 and <= 1,000,000"),
        ("comparison", {"runs": 1}, "^runs must be"),
        ("comparison", {"experiments": ()}, "^experiments must be"),
        ("comparison", {"experiments": rivals() * 2}, "^experiments must be"),
    ],
)
def test_absurd_requests_are_refused_and_name_the_bound(study, changes, message):
    with pytest.raises(InputError, match=message):
        replace(STUDIES[study], **changes)


def test_long_runs_count():
    long = Experiment.from_dict({"samples": 200_000})
    with pytest.raises(InputError, match=f"^runs must be so small that no more than {MOST_STEPS:,} filter steps"):
        MonteCarlo((long,), 1_000_000)
    with pytest.raises(InputError, match="^runs must be so small"):
        Sweep(long, "xi", usual_values(long, "xi"), "estimation_rmse", 5_000)
    with pytest.raises(InputError, match="^runs must be so small"):
        Map(replace(long, order=2), ("alpha", "beta"), "estimation_rmse", 200, 200, 10)


def test_what_cannot_be_mapped_or_compared_is_refused():
    unstable = {"order": 3, "design": "manual", "alpha": 0.5, "beta": 0.4, "gamma": 9.0}
    with pytest.raises(InputError, match="^plane must have a stable part"):
        Map(Experiment.from_dict(unstable), ("alpha", "beta"), "estimation_rmse")
    bank = Experiment.from_dict({"design": "parallel-bank", "order": 2})
    with pytest.raises(InputError, match="^design must have constant gains"):
        Map(bank, ("alpha", "beta"), "estimation_rmse")
    first, *others = rivals()
    with pytest.raises(InputError, match="^samples must be the same for all filters"):
        MonteCarlo((first, replace(others[0], samples=61)), 5)
    silent = tuple(replace(one, noise="none") for one in rivals())
    with pytest.raises(InputError, match="^noise must leave something to chance"):
        MonteCarlo(silent, 5)


def test_where_nothing_is_left_to_chance_one_run_is_enough():
    recorded = Experiment.from_dict({"scenario": "garg-accelerating", "noise": "recorded"})
    assert not has_chance(recorded)
    outcome = last(Sweep(recorded, "alpha", (0.3, 0.5, 0.7), "estimation_rmse", 20))
    assert outcome.scores.shape == (1, 1, 3)
    assert isnan(outcome.optimum().low)
    silent = Experiment.from_dict({"noise_std": 0})
    assert not has_chance(silent)
    # One number for each axis, and pushes of no size.
    assert not has_chance(replace(silent, noise_std=(0.0, 0.0)))
    assert has_chance(replace(silent, noise_std=(0.0, 1.0)))
    assert not has_chance(replace(silent, manoeuvre="acceleration-pulses", manoeuvre_std=0.0))
    assert has_chance(replace(silent, manoeuvre="acceleration-pulses", manoeuvre_std=1.0))
    assert has_chance(Experiment.from_dict({"noise_level": "snr", "snr": 10}))
    assert has_chance(Experiment.from_dict({"scenario": "singer", "noise": "none", "order": 2, "xi": 0.5}))
