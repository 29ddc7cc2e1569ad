"""The published runs, row by row: each printed number to half a unit of its last digit."""

from dataclasses import replace
from decimal import Decimal
from functools import cache
from statistics import fmean

import numpy as np
import pytest

from tracker_core import DESIGNS, InputError, run_experiment
from tracker_core.papers import NAMES, papers

SEEDS = range(20)


def run_of(paper, name):
    (run,) = [run for run in papers()[paper].runs if run.name == name]
    return run


@cache
def result_of(paper, name):
    return run_experiment(run_of(paper, name).experiment)


def assert_prints(value, printed):
    """`value` rounds to `printed`, a number as the document prints it."""
    half_a_unit = 0.5 * 10.0 ** int(Decimal(printed).as_tuple().exponent)
    # The last addend is the rounding of the comparison itself, for values that print as a tie.
    assert abs(float(value) - float(printed)) <= half_a_unit + 1e-9 * half_a_unit


# The registry ------------------------------------------------------------------------------------------------------


def test_papers_are_in_their_order():
    assert tuple(papers()) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_paper_is_described(name):
    paper = papers()[name]
    assert paper.name == name
    assert paper.title
    assert paper.title.split()[0] in paper.citation or paper.title.split(",")[0] in paper.citation
    assert len({run.name for run in paper.runs}) == len(paper.runs) > 0


@pytest.mark.parametrize(
    ("paper", "name"), [(paper.name, run.name) for paper in papers().values() for run in paper.runs]
)
def test_run_is_described_and_runs(paper, name):
    run = run_of(paper, name)
    assert run.title
    assert run.note.endswith(".")
    result = result_of(paper, name)
    assert result.verdict.stable
    assert result.track.stopped_at is None


# Garg 2021, and the example at kalmanfilter.net that it follows ----------------------------------------------------

GARG = {
    "constant-velocity": {
        "observed": "30171 30353 30756 30799 31018 31278 31276 31379 31748 32175",
        "x": "30194.2 30383.64 30612.73 30818.93 31025.7 31242.3 31418.8 31566.3 31739.4 31964.1",
        "v": "39.42 38.65 42.24 41.74 41.55 42.44 38.87 34.18 34.40 39.67",
    },
    "constant-velocity-earlier": {
        "observed": "30110 30265 30740 30750 31135 31015 31180 31610 31960 31865",
        "x": "30182 30351.4 30573.3 30769.5 31001.5 31176.4 31333.2 31529.4 31764.3 31952.9",
        # The prediction for the next sample.
        "next": "30373 30531.6 30774.3 30968.1 31216.8 31371.5 31509.2 31715.4 31974.8 32152.4",
    },
    "accelerating-earlier": {
        "observed": "30160 30365 30890 31050 31785 32215 33130 34510 36010 37265",
        "x": "30205 30387.5 30721 31038.8 31591.1 32201.7 33032.5 34250.7 35822.9 37465.4",
        "v": "42.8 35.6 57.2 67.2 107.2 133.9 175.1 250 334 371.1",
        "a": "-.7 -1.1 1.6 1.8 4.9 5.1 6.7 10.8 13.8 10.6",
    },
    "accelerating": {"observed": "30221 30453 30906 30999 31368 31978 32526 33379 34698 36275"},
}
STATES = {"x": 0, "v": 1, "a": 2}
CELLS = [
    pytest.param(run, column, sample, printed, id=f"{run}-{column}-{sample + 1}")
    for run, columns in GARG.items()
    for column, row in columns.items()
    for sample, printed in enumerate(row.split())
]


@pytest.mark.parametrize(("run", "column", "sample", "printed"), CELLS)
def test_garg_sample(run, column, sample, printed):
    result = result_of("garg2021", run)
    if column == "observed":
        assert result.measurements.positions[sample, 0] == float(printed)
    elif column == "next":
        position, velocity = result.track.smoothed[sample, 0]
        assert_prints(position + 5 * velocity, printed)
        if sample < 9:
            assert_prints(result.track.predicted[sample + 1, 0, 0], printed)
    else:
        assert_prints(result.track.smoothed[sample, 0, STATES[column]], printed)


@pytest.mark.parametrize("run", ["constant-velocity", "constant-velocity-earlier"])
def test_garg_first_prediction_comes_from_the_known_state(run):
    """30 km and 40 m/s, five seconds before the first sample."""
    assert result_of("garg2021", run).track.predicted[0, 0].tolist() == [30_200, 40]


@pytest.mark.parametrize("run", GARG)
def test_garg_gains(run):
    gains = result_of("garg2021", run).gains
    expected = (0.5, 0.4, 0.1) if run.startswith("accelerating") else (0.2, 0.1)
    assert (gains.values, gains.convention) == (expected, "taylor")


def test_garg_script_in_plain_python():
    """The listing of the alpha-beta-gamma filter, line by line, on the later edition's ranges."""
    alpha, beta, gamma, t = 0.5, 0.4, 0.1, 5
    x_temp, v_temp, a_temp = 30000 + 50 * t, 50, 0
    result = result_of("garg2021", "accelerating")
    for sample, z in enumerate(map(int, GARG["accelerating"]["observed"].split())):
        assert result.track.predicted[sample, 0] == pytest.approx([x_temp, v_temp, a_temp], rel=1e-12, abs=1e-12)
        x = x_temp + alpha * (z - x_temp)
        v = v_temp + beta * (z - x_temp) / t
        a = a_temp + 2 * gamma * (z - x_temp) / t / t
        assert result.track.smoothed[sample, 0] == pytest.approx([x, v, a], rel=1e-12, abs=1e-12)
        x_temp, v_temp, a_temp = x + v * t + a * t * t / 2, v + a * t, a


def test_garg_alpha_beta_lags_an_accelerating_aircraft():
    """His observation 1: without an acceleration in the model, the estimate trails behind for good."""
    with_acceleration, without = (
        result_of("garg2021", run) for run in ("accelerating", "accelerating-with-alpha-beta")
    )
    last_error = [(r.truth.positions - r.track.smoothed[:, :, 0])[-1, 0] for r in (with_acceleration, without)]
    assert last_error[1] > 1000
    assert abs(last_error[0]) < 500


# Jeong, Njonjo & Pan 2017, tables 1-4: smoothing coefficients ------------------------------------------------------

TABLES_1_TO_4 = [
    ("benedict-bordner", "alpha", "0.86"),
    ("benedict-bordner", "beta", "0.6488"),
    ("gray-murray", "alpha", "0.5277"),
    ("gray-murray", "beta", "0.1956"),
    ("fading-memory", "alpha", "0.7379"),
    ("fading-memory", "beta", "0.3188"),
    ("fading-memory", "gamma", "0.0467"),
    ("jerk", "alpha", "0.7001"),
    ("jerk", "beta", "0.3085"),
    ("jerk", "gamma", "0.0612"),
    ("jerk", "eta", "7.6163e-4"),
]


@pytest.mark.parametrize(("run", "name", "printed"), TABLES_1_TO_4)
def test_jeong_smoothing_coefficient(run, name, printed):
    """As written in eq. 6, with 2 gamma/T^2 and 6 eta/T^3."""
    gains = run_of("jeong2017", run).experiment.gains()
    assert gains.convention == "taylor"
    assert_prints(dict(zip(("alpha", "beta", "gamma", "eta"), gains.values, strict=False))[name], printed)


def test_jeong_table_1_gamma_is_rounding():
    """Eq. 8 with the beta of eq. 7 forces gamma = 0; the printed 4.4409e-16 is two units in the last place of 1."""
    alpha, beta = run_of("jeong2017", "benedict-bordner").experiment.gains().values
    assert abs(DESIGNS["simpson"].gains(alpha=alpha, beta=beta)[2]) <= 4.4409e-16


def test_jeong_table_2_gamma_is_read_wrongly():
    """Eq. 13 gives 0.0363; the printed 0.0101 is beta^2/2*alpha evaluated from left to right."""
    alpha, beta, gamma = run_of("jeong2017", "gray-murray").experiment.gains().values
    assert_prints(gamma, "0.0363")
    assert_prints(beta**2 / 2 * alpha, "0.0101")


def test_jeong_table_3_is_not_for_the_stated_factor():
    """0.62 gives alpha = 0.7617; the printed gains are those of 0.64."""
    assert_prints(DESIGNS["fading-memory"].gains(3, xi=0.62)[0], "0.7617")
    assert run_of("jeong2017", "fading-memory").experiment.xi == 0.64


def test_jeong_tracking_index_and_damping_parameter():
    """Variances of 1e-3 and 1 with T = 3 s give 0.2846 and r = 0.6873."""
    experiment = run_of("jeong2017", "gray-murray").experiment
    assert_prints(experiment.tracking_index, "0.2846")
    assert_prints(1e-3**0.5 * experiment.interval**2, "0.2846")
    assert_prints((1 - experiment.gains().values[0]) ** 0.5, "0.6873")


# Tables 5 and 6: total errors over 1000 samples --------------------------------------------------------------------

# Printed total, and what this target gives with two-point start and noise of 10 m per axis, averaged over seeds. The
# document prints neither its noise nor its seed, and its first row is measured against the observations.
TOTALS = {
    "benedict-bordner": {"tracking": (26_326, 23_420), "estimation": (11_677, 11_260)},
    "gray-murray": {"tracking": (21_071, 20_250), "estimation": (11_693, 11_660)},
    "fading-memory": {"tracking": (19_622, 18_700), "estimation": (10_653, 10_490)},
    "jerk": {"tracking": (17_859, 17_820), "estimation": (10_227, 10_295)},
}


@cache
def mean_totals(name):
    """Tracking and estimation total of a run, averaged over the seeds."""
    experiment = run_of("jeong2017", name).experiment
    metrics = [run_experiment(replace(experiment, seed=seed)).metrics for seed in SEEDS]
    return {
        "tracking": fmean(m.tracking_total for m in metrics),
        "estimation": fmean(m.estimation_total for m in metrics),
        "innovation": fmean(m.innovation_total for m in metrics),
    }


@pytest.mark.parametrize("name", TOTALS)
def test_jeong_runs_as_the_paper_did(name):
    experiment = run_of("jeong2017", name).experiment
    assert (experiment.samples, experiment.interval, experiment.noise_std) == (1000, 3.0, (10.0,))
    assert (experiment.convention, experiment.start, experiment.noise) == ("taylor", "two-point", "white")


@pytest.mark.parametrize("kind", ["tracking", "estimation"])
@pytest.mark.parametrize("name", TOTALS)
def test_jeong_total(name, kind):
    assert mean_totals(name)[kind] == pytest.approx(TOTALS[name][kind][1], rel=0.03, abs=0)


@pytest.mark.parametrize("kind", ["tracking", "estimation"])
def test_jeong_order_of_the_four_filters(kind):
    """From the best to the worst, as printed."""
    printed = sorted(TOTALS, key=lambda name: TOTALS[name][kind][0])
    assert sorted(TOTALS, key=lambda name: mean_totals(name)[kind]) == printed


def test_jeong_first_row_is_measured_against_the_observations():
    """The printed 26,326 m is no error against the truth, but the total innovation."""
    assert mean_totals("benedict-bordner")["innovation"] == pytest.approx(26_326, rel=0.03, abs=0)
    assert mean_totals("benedict-bordner")["tracking"] < 0.92 * 26_326


def test_jeong_only_the_corrected_gamma_reproduces_table_5():
    """With the printed 0.0101 the Gray-Murray filter would be nearly twice as bad."""
    experiment = run_of("jeong2017", "gray-murray").experiment
    alpha, beta, _ = experiment.gains().values
    misprinted = replace(experiment, design="manual", tracking_index=None, alpha=alpha, beta=beta, gamma=0.0101)
    totals = [run_experiment(replace(misprinted, seed=seed)).metrics.tracking_total for seed in range(3)]
    assert fmean(totals) == pytest.approx(42_000, rel=0.03, abs=0)


# Njonjo, Pan & Jeong 2016 ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "same_as"), [("order-3", "fading-memory"), ("order-4", "jerk")])
def test_njonjo_runs_the_same_two_filters(name, same_as):
    assert run_of("njonjo2016", name).experiment == run_of("jeong2017", same_as).experiment


def test_njonjo_the_fourth_state_helps():
    """By nine percent of the tracking error in the paper's own numbers; here by about five."""
    three, four = (mean_totals(name)["tracking"] for name in ("fading-memory", "jerk"))
    assert 0.03 < 1 - four / three < 0.09


def test_papers_are_read_once():
    assert papers() is papers()


def test_a_run_with_a_bad_experiment_would_be_refused():
    """The files are read through the same door as everything else."""
    with pytest.raises(InputError, match="^xi must be"):
        replace(run_of("jeong2017", "jerk").experiment, xi=1.0)


def test_published_tracks_have_no_holes():
    for run in papers()["garg2021"].runs:
        assert np.isfinite(result_of("garg2021", run.name).track.smoothed).all()
