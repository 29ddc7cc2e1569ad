"""Studies on measured data: what can be tuned for, on which measurements, and with the errors of the tracks."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tracker_core import Experiment, InputError, run_experiment
from tracker_core import run as run_module
from tracker_core.__main__ import main
from tracker_core.measured import SHELF, File, deliver, parcel
from tracker_core.run import believed_runs, known_states, observation_rmse, observe_runs
from tracker_core.tuning import OBJECTIVES, Map, MonteCarlo, Search, Sweep
from tracker_core.tuning.base import UNEVEN, has_chance, knows_truth, steps_of
from tracker_core.tuning.evaluate import run_errors
from tracker_core.tuning.monte_carlo import FIGURES, figures_of
from tracker_core.tuning.objectives import check_objective, objectives_of, usual_objective
from tracker_core.types import Track

RANDOM = np.random.default_rng(11)
SAMPLES = 90
EVEN = 0.5 * np.arange(SAMPLES)
ODD = np.concatenate(([0.0], np.cumsum(RANDOM.uniform(0.2, 1.7, SAMPLES - 1))))
TRUE = np.stack([30 * EVEN, 400 * np.sin(EVEN / 9)], axis=1)
SEEN = TRUE + RANDOM.normal(0, 2, TRUE.shape)
SEEN[20] = np.nan
SEEN[50] += 300
PARTLY = TRUE.copy()
PARTLY[30:50] = np.nan
INNOVATIONS = tuple(name for name in OBJECTIVES if name.startswith("innovation"))


def kept(times, *blocks):
    names = ["t", "x", "y", "x_true", "y_true"][: 1 + 2 * len(blocks)]
    columns = [times, *(column for block in blocks for column in block.T)]
    cells = (["" if value != value else repr(float(value)) for value in row] for row in zip(*columns, strict=True))
    return SHELF.keep(File("boat.csv", "\n".join([",".join(names), *map(",".join, cells)]).encode()))


FILES = {
    "even": kept(EVEN, SEEN),
    "odd": kept(ODD, SEEN),
    "even known": kept(EVEN, SEEN, TRUE),
    "odd known": kept(ODD, SEEN, TRUE),
    "odd partly": kept(ODD, SEEN, PARTLY),
    "even partly": kept(EVEN, SEEN, PARTLY),
}


def experiment(name, **values):
    return Experiment.from_dict({"data": FILES[name], "order": 2, "xi": 0.6, "noise_std": 2.0, **values})


def last(study):
    *_, progress = study.stream()
    assert progress.done == progress.of
    return progress.outcome


def fake_gate(monkeypatch, refuse):
    """A gate that refuses the samples that a function of the gains and the measurements says."""
    real = run_module.run_filter

    def run_filter(measurements, gains, *, gate=None, **options):
        if gate is None:
            return real(measurements, gains, **options)
        gone = refuse(gains, measurements)
        seen = measurements.positions.copy()
        seen[gone] = np.nan
        track = real(replace(measurements, positions=seen), gains, **options)
        values = {name: getattr(track, name) for name in Track.__slots__}
        return Track(**values | {"rejected": gone})

    monkeypatch.setattr(run_module, "run_filter", run_filter)


# What can be tuned for ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FILES)
def test_without_a_truth_only_the_innovations_can_be_tuned_for(name):
    known = name.split()[-1] in {"known", "partly"}
    one = experiment(name)
    assert knows_truth(one) == known
    assert usual_objective(one) == ("estimation_rmse" if known else "innovation_rmse")
    possible = objectives_of(one)
    # Of a recorded truth nobody knows the acceleration that the lag follows.
    assert set(possible) == (set(OBJECTIVES) - {"noise_lag"} if known else set(INNOVATIONS))
    for objective in set(OBJECTIVES) - set(possible):
        with pytest.raises(InputError, match=r"^objective must not need the (truth|acceleration of the target):"):
            check_objective(objective, one)
        for study in (
            lambda: Sweep(one, "xi", (0.4, 0.6), objective),  # noqa: B023
            lambda: Sweep(one, "xi", (0.4, 0.6), "innovation_rmse", beside=(objective,)),  # noqa: B023
            lambda: Map(one, ("alpha", "beta"), objective),  # noqa: B023
            lambda: Search(one, objective),  # noqa: B023
        ):
            with pytest.raises(InputError, match="^objective must not need"):
                study()


def test_noise_against_lag_needs_the_derivative_that_the_filter_lacks():
    singer = Experiment.from_dict({"scenario": "singer", "order": 2, "xi": 0.6})
    assert check_objective("noise_lag", singer) == "noise_lag"
    with pytest.raises(InputError, match="^objective must not need the jerk of the target: nobody knows it"):
        check_objective("noise_lag", replace(singer, order=3))
    assert "noise_lag" in objectives_of(Experiment.from_dict({"order": 4, "xi": 0.6}))


@pytest.mark.parametrize(
    ("scenario", "order", "still"),
    [("constant-velocity", 2, "acceleration"), ("constant-velocity", 4, "snap"), ("constant-acceleration", 3, "jerk")],
)
def test_noise_is_not_weighed_against_a_lag_that_no_filter_has(scenario, order, still):
    """Without it the smoothest filter of all would be the best."""
    one = Experiment.from_dict({"scenario": scenario, "order": order, "xi": 0.6})
    assert "noise_lag" not in objectives_of(one)
    with pytest.raises(InputError, match=f"^objective must not weigh a lag that no filter has: the {still} of the"):
        Sweep(one, "xi", (0.4, 0.6), "noise_lag")


@pytest.mark.parametrize(
    ("manoeuvre", "order", "weighed"),
    [
        ("acceleration-pulses", 2, True),
        ("acceleration-pulses", 3, False),
        ("acceleration-jumps", 2, True),
        ("acceleration-jumps", 3, False),
        ("jerk-pulses", 2, True),
        ("jerk-pulses", 3, True),
        ("jerk-pulses", 4, False),
    ],
)
def test_random_pushes_are_a_manoeuvre_too(manoeuvre, order, weighed):
    pushed = {"scenario": "constant-velocity", "order": order, "xi": 0.6, "manoeuvre": manoeuvre, "manoeuvre_std": 3.0}
    assert ("noise_lag" in objectives_of(Experiment.from_dict(pushed))) == weighed
    assert "noise_lag" not in objectives_of(Experiment.from_dict(pushed | {"manoeuvre_std": 0.0}))


def test_the_best_filter_for_a_pushed_target_is_not_the_smoothest():
    """w alone is the acceleration of this target, held for an interval each: D^2 = axes times its variance."""
    values = {"scenario": "constant-velocity", "order": 2, "xi": 0.6, "noise_std": 10, "interval": 2.0}
    one = Experiment.from_dict(values | {"manoeuvre": "acceleration-pulses", "manoeuvre_std": 0.5})
    *_, last = Sweep(one, "xi", tuple(np.linspace(0.05, 0.95, 91)), "noise_lag").stream()
    assert 0.1 < last.outcome.optimum().value < 0.9
    axes, (alpha, beta) = len(one.target.axes), one.gains().vector
    lag = (1 - alpha) * 4 / beta * 0.5
    result = run_experiment(one)
    assert result.metrics.lag == pytest.approx(lag * np.sqrt(axes), rel=1e-12)
    assert [metrics.lag for metrics in result.axis_metrics()] == pytest.approx([lag] * axes, rel=1e-12)


# The runs -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FILES)
def test_a_recording_is_one_run_with_its_own_times(name):
    one = experiment(name)
    runs = observe_runs(one, [1])
    np.testing.assert_array_equal(runs.positions[0], SEEN)
    np.testing.assert_allclose(runs.times if name.startswith("odd") else EVEN, ODD if runs.times is not None else EVEN)
    assert (runs.times is None) == name.startswith("even")
    assert runs.interval == one.interval
    assert not has_chance(one)
    assert known_states(one, [1], 2) is None
    if name in {"even", "odd"}:
        assert runs.truth is None
        with pytest.raises(InputError, match="^truth must be known"):
            observation_rmse(runs)
        return
    np.testing.assert_array_equal(runs.truth[0], PARTLY if name.endswith("partly") else TRUE)
    errors = np.linalg.norm(SEEN - runs.truth[0], axis=1)
    assert observation_rmse(runs)[0] == pytest.approx(np.sqrt(np.nanmean(errors**2)), rel=1e-12)
    assert observation_rmse(runs)[0] == pytest.approx(run_experiment(one).metrics.observation_rmse, rel=1e-12)


@pytest.mark.parametrize("start", ["two-point", "expanding"])
@pytest.mark.parametrize("name", FILES)
def test_a_sweep_has_the_scores_of_the_runs(name, start):
    one = experiment(name, start=start)
    first, *others = reversed(objectives_of(one))
    sweep = Sweep(one, "xi", (0.3, 0.6, 0.9), first, 20, beside=tuple(others))
    outcome = last(sweep)
    assert outcome.scores.shape == (len(sweep.objectives), 1, 3)
    for column, value in enumerate(sweep.values):
        metrics = run_experiment(sweep.at(value)).metrics.to_dict()
        for row, objective in enumerate(sweep.objectives):
            if objective in metrics:
                assert outcome.scores[row, 0, column] == pytest.approx(metrics[objective], rel=1e-11)


@pytest.mark.parametrize("name", ["even", "odd", "odd partly"])
def test_maps_and_searches_run_on_a_recording(name):
    one = experiment(name)
    outcome = last(Map(one, ("alpha", "beta"), "innovation_rmse", 6, 5))
    best = outcome.vectors[outcome.best()]
    manual = Experiment.from_dict(
        {"data": one.data, "order": 2, "design": "manual", "alpha": best[0], "beta": best[1], "noise_std": 2.0}
    )
    assert outcome.score(outcome.best()).mean == pytest.approx(
        np.sqrt(np.nanmean((run_experiment(manual).track.innovation ** 2).sum(axis=1))), rel=1e-11
    )
    found = last(Search(one, "innovation_rmse", budget=2_000))
    assert found.fresh is None
    assert found.score <= outcome.score(outcome.best()).mean
    assert found.score <= min(rival.score for rival in found.rivals)


def test_steps_that_take_longer_count_as_several():
    plain = 2 * SAMPLES
    assert [steps_of(experiment(name)) for name in ("even", "even known")] == [plain, plain]
    for name in ("odd", "odd known", "odd partly", "even partly"):
        assert steps_of(experiment(name)) == UNEVEN * plain


def test_a_study_over_many_seeds_needs_something_to_draw():
    with pytest.raises(InputError, match="^runs must not be asked for of a recording: it cannot be run again"):
        MonteCarlo((experiment("even known"), experiment("even known", xi=0.7)), 20)


# The gate -------------------------------------------------------------------------------------------------------------


def test_what_the_own_filter_refuses_is_left_out_for_all(monkeypatch):
    """The refused samples follow from the own gains, whatever gains are tried."""

    def refuse(gains, measurements):
        gone = np.zeros(len(measurements.positions), dtype=bool)
        gone[[50, int(100 * gains.values[0]) % 20 + 60]] = True
        return gone

    fake_gate(monkeypatch, refuse)
    one = experiment("odd known", gate=4.0)
    alpha = one.gains().values[0]
    seen = believed_runs(one, [1]).positions[0]
    gone = np.isnan(seen).all(axis=1)
    assert np.flatnonzero(gone).tolist() == sorted({20, 50, int(100 * alpha) % 20 + 60})
    np.testing.assert_array_equal(observe_runs(one, [1]).positions[0], SEEN)
    # The present filter has the figures of its own run; every other one those on what is left.
    kinds, figures = ("tracking", "estimation"), ("rmse",)
    own = run_errors(one, [1], one.gains().vector[None], figures=figures, kinds=kinds)
    metrics = run_experiment(one).metrics
    assert own["estimation"].rmse[0, 0] == pytest.approx(metrics.estimation_rmse, rel=1e-11)
    for xi in (0.4, 0.8):
        other = replace(one, xi=xi)
        found = run_errors(one, [1], other.gains().vector[None], figures=figures, kinds=kinds)
        cleaned = kept(ODD, np.where(gone[:, None], np.nan, SEEN), TRUE)
        alone = run_experiment(replace(other, data=cleaned, gate=None)).metrics
        assert found["estimation"].rmse[0, 0] == pytest.approx(alone.estimation_rmse, rel=1e-11)


@pytest.mark.parametrize("name", FILES)
def test_the_present_filter_has_the_figures_of_its_own_gated_run(name):
    one = experiment(name, gate=5.0)
    result = run_experiment(one)
    assert result.track.rejected[50]
    names = tuple(objective for objective in objectives_of(one) if objective in result.metrics.to_dict())
    first, *others = names
    outcome = last(Sweep(one, "xi", (0.5, 0.6), first, beside=tuple(others)))
    for row, objective in enumerate(names):
        # Innovations that were refused do not count; errors against the truth count there too.
        assert outcome.scores[row, 0, 1] == pytest.approx(getattr(result.metrics, objective), rel=1e-11)


def test_every_run_is_gated_by_itself(monkeypatch):
    """In every run of a target that is drawn, with the noise of that run."""
    fake_gate(monkeypatch, lambda _, measured: np.abs(measured.positions[:, 0] - measured.positions[:, 1]) % 7 < 1)
    values = {"scenario": "singer", "samples": 40, "order": 2, "xi": 0.6, "gate": 4, "seed": 5}
    drawn = Experiment.from_dict(values)
    runs, raw = believed_runs(drawn, [5, 6, 7]), observe_runs(drawn, [5, 6, 7])
    assert len({np.isnan(run).sum() for run in runs.positions}) > 1
    for row, seed in enumerate([5, 6, 7]):
        result = run_experiment(replace(drawn, seed=seed))
        gone = result.track.rejected
        assert np.isnan(runs.positions[row, gone]).all()
        np.testing.assert_array_equal(runs.positions[row, ~gone], raw.positions[row, ~gone])


def test_a_ratio_of_signal_to_noise_gives_every_target_a_gate_of_its_own():
    values = {"scenario": "singer", "noise_level": "snr-decibel", "snr": 40, "start": "known"}
    drawn = Experiment.from_dict(values | {"samples": 60, "order": 2, "xi": 0.6, "gate": 2, "seed": 5})
    runs = believed_runs(drawn, [5, 6, 7])
    for row, seed in enumerate([5, 6, 7]):
        result = run_experiment(replace(drawn, seed=seed))
        assert result.track.rejected.any()
        np.testing.assert_array_equal(np.isnan(runs.positions[row]).all(axis=1), result.track.rejected)
    assert len({run_experiment(replace(drawn, seed=seed)).gate for seed in (5, 6, 7)}) == 3


def test_filters_with_gates_are_compared_each_with_its_own(monkeypatch):
    def refuse(gains, measured):
        return np.arange(len(measured.positions)) % int(3 + 10 * gains.values[0]) == 2

    fake_gate(monkeypatch, refuse)
    first = Experiment.from_dict({"samples": 60, "order": 2, "xi": 0.6, "gate": 4})
    filters = (first, replace(first, gate=None), replace(first, xi=0.8), replace(first, xi=0.3, gate=None))
    values = figures_of(filters, range(3, 6))
    for column, one in enumerate(filters):
        for row, seed in enumerate(range(3, 6)):
            metrics = run_experiment(replace(one, seed=seed)).metrics
            for name in ("tracking_rmse", "estimation_rmse", "estimation_max", "noise_reduction"):
                found = values[row, column, FIGURES.index(name)]
                assert found == pytest.approx(getattr(metrics, name), rel=1e-9), (name, column)


# Files on the way -----------------------------------------------------------------------------------------------------


def test_a_parcel_is_put_on_the_shelf_where_it_is_missing(monkeypatch):
    content = b"t,x\n0,1\n1,2\n2,4\n"
    data = SHELF.keep(File("far.csv", content))
    file = parcel(data)
    assert file.content == content
    assert parcel(None) is None
    kept_files, shelf = [], {}
    monkeypatch.setattr(SHELF.__class__, "fetch", lambda _, name: shelf.get(name))
    monkeypatch.setattr(SHELF.__class__, "keep", lambda _, one: kept_files.append(one) or shelf.update({one.data: one}))
    deliver(data, file)
    deliver(data, file)
    deliver(None, None)
    assert kept_files == [file]
    monkeypatch.undo()
    with pytest.raises(InputError, match="^data is not kept here"):
        parcel("f" * 32)


# The command ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "objective"), [("odd", "innovation_rmse"), ("odd known", "estimation_rmse")])
def test_the_command_takes_a_file(name, objective, tmp_path, capsys):
    path = tmp_path / "boat.csv"
    path.write_bytes(parcel(FILES[name]).content)
    main(["sweep", "xi", "--json", "--data", str(path), "--order", "2", "--points", "5"])
    told = json.loads(capsys.readouterr().out)
    assert (told["objective"], told["runs"]) == (objective, 1)
    assert told["experiment"]["data"] == FILES[name]
    assert told["low"] == [None] * 5
    sweep = Sweep(experiment(name), "xi", tuple(told["values"]), objective)
    np.testing.assert_allclose(told["mean"], last(sweep).scores[0, 0], rtol=1e-12)


@pytest.mark.parametrize(
    ("manoeuvre", "order", "impulses"),
    [
        ("acceleration-pulses", 2, ""), ("acceleration-jumps", 2, ""), ("jerk-pulses", 3, ""),
        ("acceleration-pulses", 3, "jerk"), ("acceleration-jumps", 3, "jerk"), ("jerk-pulses", 4, "snap"),
    ],
)  # fmt: skip
def test_impulses_have_no_steady_lag(manoeuvre, order, impulses):
    """Their mean square is infinite, not zero; where they are held, or shown by the states, it is finite."""
    values = {"scenario": "constant-velocity", "manoeuvre": manoeuvre, "manoeuvre_std": 1, "order": order, "xi": 0.8}
    one = Experiment.from_dict(values)
    lag = run_experiment(one).metrics.lag
    assert (lag is None) == bool(impulses)
    assert ("noise_lag" in objectives_of(one)) == (not impulses)
    if impulses:
        with pytest.raises(InputError, match=f"a lag that has no size: the {impulses} of the target comes in impulses"):
            Sweep(one, "xi", (0.4, 0.6), "noise_lag")
    else:
        assert lag > 0
