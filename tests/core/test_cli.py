"""The command line: what it prints, what it writes, and how it refuses."""

import csv
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tracker_core import CONVENTIONS, DESIGNS, METRICS, Experiment, Gains, assess, run_experiment
from tracker_core.__main__ import main
from tracker_core.exports import run_summary, track_columns
from tracker_core.fields import FIELDS
from tracker_core.merits import merits
from tracker_core.poles import damping_class
from tracker_core.region import nearest_stable
from tracker_core.stability import printed_conditions
from tracker_core.types import GAIN_NAMES

ROOT = Path(__file__).parents[2]
GARG = ["run", "--scenario", "garg-constant-velocity"]


@pytest.fixture
def call(capsys):
    """Run a command line: exit status, stdout, stderr."""

    def run(*arguments):
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as stop:
            status = stop.code
        return status, *capsys.readouterr()

    return run


@pytest.fixture
def answer(call):
    """The JSON object that a command line prints."""

    def run(*arguments):
        status, out, err = call(*arguments, "--json")
        assert (status, err) == (0, "")
        return json.loads(out)

    return run


# run ---------------------------------------------------------------------------------------------------------------

RUN_KEYS = [
    "experiment",
    "gains",
    "stable",
    "spectral_radius",
    "metrics",
    "evidence",
    "axes",
    "missing",
    "rejected",
    "stopped_at",
    "found",
    "method",
]


def test_run_prints_one_json_object(answer):
    summary = answer("run")
    result = run_experiment(Experiment.from_dict({}))
    assert list(summary) == RUN_KEYS
    assert summary == json.loads(json.dumps(run_summary(result)))
    assert summary["experiment"] == result.experiment.to_dict()
    assert list(summary["gains"]) == ["convention", "alpha", "beta", "gamma", "eta"]
    assert summary["gains"]["eta"] is None
    assert list(summary["metrics"]) == list(METRICS)
    assert list(summary["axes"]) == ["x", "y"]
    assert [list(metrics) for metrics in summary["axes"].values()] == [list(METRICS)] * 2
    assert (summary["stable"], summary["missing"], summary["rejected"], summary["stopped_at"]) == (True, 0, None, None)


def test_run_counts_the_sample_it_stopped_at_from_one(answer):
    flags = ["--alpha", "0.5", "--beta", "3.5"]
    summary = answer("run", *flags)
    result = run_experiment(Experiment.from_dict({"alpha": 0.5, "beta": 3.5}))
    assert summary["stable"] is False
    assert summary["metrics"]["lag"] is None
    assert summary["stopped_at"] == result.track.stopped_at + 1


def test_run_takes_every_field_as_a_flag(answer):
    flags = {
        "scenario": "constant-acceleration",
        "samples": 25,
        "interval": 0.5,
        "noise": "coloured",
        "noise_level": "std",
        "noise_std": [3.0, 4.0],
        "noise_correlation": 0.4,
        "manoeuvre": "jerk-pulses",
        "manoeuvre_std": 0.3,
        "seed": 11,
        "start": "expanding",
        "order": 4,
        "convention": "half",
        "design": "manual",
        "alpha": 0.5,
        "beta": 0.2,
        "gamma": 0.05,
        "eta": 0.01,
    }
    arguments = []
    for name, value in flags.items():
        arguments += [f"--{name.replace('_', '-')}", "3,4" if name == "noise_std" else str(value)]
    assert answer("run", *arguments)["experiment"] == flags


@pytest.mark.parametrize("flags", [["--xi", "0.5"], ["--tracking-index", "0.3"]], ids=str)
def test_run_takes_the_parameter_of_a_design(answer, flags):
    summary = answer("run", *flags)
    name = flags[0][2:].replace("-", "_")
    assert summary["experiment"][name] == float(flags[1])


def test_run_reads_an_experiment_file_and_flags_override_it(answer, tmp_path):
    file = tmp_path / "experiment.json"
    file.write_text(json.dumps({"scenario": "constant-velocity", "seed": 4, "xi": 0.7}), encoding="utf-8")
    experiment = answer("run", "--experiment", file, "--seed", "5")["experiment"]
    assert (experiment["scenario"], experiment["xi"], experiment["seed"]) == ("constant-velocity", 0.7, 5)


def test_run_reads_back_what_it_printed(answer, tmp_path):
    """The experiment of a summary, saved as a file, gives the same summary."""
    summary = answer(*GARG, "--alpha", "0.4", "--beta", "0.2")
    file = tmp_path / "again.json"
    file.write_text(json.dumps(summary["experiment"]), encoding="utf-8")
    assert answer("run", "--experiment", file) == summary


@pytest.mark.parametrize(
    "flags", [GARG, ["run", "--start", "expanding"], ["run", "--alpha", "0.5", "--beta", "3.5"]], ids=str
)
def test_run_writes_the_track_exactly(call, tmp_path, flags):
    file = tmp_path / "track.csv"
    assert call(*flags, "--out", file)[0] == 0
    values = dict(zip((flag[2:] for flag in flags[1::2]), flags[2::2], strict=True))
    columns = track_columns(run_experiment(Experiment.from_dict(values)))
    assert b"\r" not in file.read_bytes()
    with file.open(encoding="utf-8", newline="") as stream:
        header, *rows = csv.reader(stream)
    assert header == list(columns)
    for name, cells in zip(header, zip(*rows, strict=True), strict=True):
        read = np.array([float(cell) if cell else math.nan for cell in cells])
        assert np.array_equal(read, columns[name], equal_nan=True)


def test_run_prints_a_short_track_as_a_table(call):
    status, out, err = call(*GARG)
    assert (status, err) == (0, "")
    lines = out.splitlines()
    assert lines[0].split()[:3] == ["sample", "time", "range_true"]
    assert lines[1].split() == ["1", "5", "30200", "30171", "30200", "30194.2", "40", "39.42"]
    assert lines[10].split()[0] == "10"
    assert lines[12] == "alpha 0.2  beta 0.1"
    assert lines[13] == "stable (largest pole 0.894427)"
    assert next(line for line in lines if line.startswith("Noise reduction")).endswith(" %")
    assert len(lines) == 14 + len(METRICS)


def test_run_prints_no_long_track(call):
    status, out, _ = call("run")
    assert status == 0
    assert len(out.splitlines()) == 2 + len(METRICS)


def test_run_says_where_an_unstable_filter_stopped(call):
    out = call("run", "--alpha", "0.5", "--beta", "3.5")[1]
    stop = run_experiment(Experiment.from_dict({"alpha": 0.5, "beta": 3.5})).track.stopped_at + 1
    assert f"stopped at sample {stop}: a position passed 1e+12 m" in out
    assert "unstable (largest pole" in out


# design ------------------------------------------------------------------------------------------------------------

PARAMETERS = {"alpha": "0.5", "beta": "0.3", "xi": "0.6", "tracking_index": "0.5"}
ALL_DESIGNS = [(design.name, order) for design in DESIGNS.values() for order in design.orders]


@pytest.mark.parametrize(("name", "order"), ALL_DESIGNS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_design_prints_gains_and_poles(answer, name, order, convention):
    design = DESIGNS[name]
    flags = [part for key in design.parameters for part in (f"--{key.replace('_', '-')}", PARAMETERS[key])]
    summary = answer("design", name, "--order", order, "--convention", convention, *flags)
    assert list(summary) == ["design", "order", "convention", "alpha", "beta", "gamma", "eta", "poles"]
    assert (summary["design"], summary["order"], summary["convention"]) == (name, order, convention)
    expected = Gains.normalised(design.gains(order, **{key: PARAMETERS[key] for key in design.parameters})).to(
        convention
    )
    found = [summary[key] for key in ("alpha", "beta", "gamma", "eta")]
    assert found == [*expected.values, *[None] * (4 - order)]
    assert [complex(*pole) for pole in summary["poles"]] == list(assess(expected).poles)


def test_design_knows_the_order_of_a_design_with_one(answer):
    assert answer("design", "gray-murray", "--tracking-index", "1")["order"] == 3


@pytest.mark.parametrize("name", ["kalata", "gray-murray", "jeong-gray-murray"])
def test_design_makes_the_tracking_index_from_both_noises(answer, name):
    """Lambda = process_std T^2 / sensor_std."""
    found = answer("design", name, "--process-std", "0.03162", "--sensor-std", "2", "--interval", "3")
    expected = answer("design", name, "--tracking-index", 0.03162 * 3**2 / 2)
    assert found == expected


@pytest.mark.parametrize("order", [2, 3, 4])
def test_design_from_both_noises_solves_the_riccati_equation(answer, steady_kalman, order):
    """What disturbs the target is an acceleration, at order 4 a jerk."""
    noise = ("--process-std", "1", "--sensor-std", "10", "--interval", "0.1")
    found = answer("design", "steady-kalman", "--order", order, *noise)
    t = 0.1
    enters = {2: [t**2 / 2, t], 3: [t**2 / 2, t, 1], 4: [t**3 / 6, t**2 / 2, t, 1]}[order]
    expected = steady_kalman(np.outer(enters, enters), 100.0, t)
    assert [found[name] for name in GAIN_NAMES[:order]] == pytest.approx(expected, rel=1e-9)


def test_design_in_plain_text(call):
    status, out, err = call("design", "kalata", "--process-std", "0.1", "--sensor-std", "2", "--interval", "1")
    assert (status, err) == (0, "")
    assert out.splitlines()[0].split() == ["alpha", "0.270867118992628"]
    assert out.splitlines()[1].split()[1].startswith("0.04269463903721")
    assert "convention normalised: γ/T², η/T³" in out
    assert "poles  0.843219+0.13459j, 0.843219-0.13459j" in out


# stability ---------------------------------------------------------------------------------------------------------

STABILITY_KEYS = [
    "stable", "spectral_radius", "poles", "conditions", "jury", "printed", "damping_class", "merits", "nearest_stable",
]  # fmt: skip


@pytest.mark.parametrize(
    ("flags", "gains"),
    [
        (["--alpha", "0.5", "--beta", "0.2"], Gains((0.5, 0.2))),
        (["--alpha", "0.5", "--beta", "3.5"], Gains((0.5, 3.5))),
        (
            ["--alpha", "0.5", "--beta", "0.4", "--gamma", "0.1", "--convention", "taylor"],
            Gains((0.5, 0.4, 0.1), "taylor"),
        ),
        (["--alpha=0.7", "--beta=0.3", "--gamma=0.06", "--eta=0.001", "--order=4"], Gains((0.7, 0.3, 0.06, 0.001))),
    ],
    ids=["stable", "unstable", "order-3-taylor", "order-4"],
)
def test_stability_prints_poles_conditions_and_table(answer, flags, gains):
    summary = answer("stability", *flags)
    verdict = assess(gains)
    assert list(summary) == STABILITY_KEYS
    assert summary["stable"] == verdict.stable
    assert summary["spectral_radius"] == verdict.spectral_radius
    assert [complex(*pole) for pole in summary["poles"]] == list(verdict.poles)
    for key, conditions in (
        ("conditions", verdict.conditions), ("jury", verdict.jury), ("printed", printed_conditions(gains)),
    ):  # fmt: skip
        rows = summary[key]
        assert [row["condition"] for row in rows] == [condition.text for condition in conditions]
        assert [row["margin"] for row in rows] == [condition.margin for condition in conditions]
        assert [row["holds"] for row in rows] == [condition.holds for condition in conditions]
    assert all(list(row) == ["condition", "margin", "holds"] for row in summary["conditions"])
    assert all(list(row) == ["condition", "margin", "holds", "numbers"] for row in summary["jury"])


def test_stability_in_plain_text(call):
    status, out, err = call("stability", "--alpha", "0.5", "--beta", "3.5")
    assert (status, err) == (0, "")
    first, *conditions, poles, nearest = out.splitlines()
    assert first.startswith("unstable (largest pole 1.7")
    assert [line.split()[0] for line in conditions] == ["holds"] * 3 + ["FAILS", "holds", "FAILS", "holds"]
    assert poles == "poles  -1.70711+0j, -0.292893+0j (alternating)"
    # The foot of the perpendicular on the slanting side of the triangle with poles within 0.99.
    assert nearest.startswith("nearest stable gains  alpha 0.2986")


def test_stability_in_plain_text_has_the_figures_of_merit(call):
    out = call("stability", "--alpha", "0.5", "--beta", "0.2", "--gamma", "0.08")[1]
    assert "as printed by Yu & Wu 2017, in the convention half:" in out
    figures = {line[:28].strip(): line[28:].strip() for line in out.splitlines()[-7:]}
    assert figures["Noise gain"] == "0.571429"
    assert figures["Noise gain, predicted"] == "1.28571"
    assert figures["Lag per unit"] == "6.25 m"
    assert figures["Settling time"].endswith(" s")
    assert "nearest" not in out


@pytest.mark.parametrize("flags", [["--interval", "3"], []], ids=str)
def test_stability_gives_the_figures_of_merit(answer, flags):
    summary = answer("stability", "--alpha", "0.5", "--beta", "0.2", "--gamma", "0.08", *flags)
    assert summary["merits"] == merits(Gains((0.5, 0.2, 0.08)), 3.0 if flags else 1.0)
    assert summary["damping_class"] == damping_class(Gains((0.5, 0.2, 0.08)))
    assert summary["nearest_stable"] is None


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_stability_shows_the_way_back(answer, convention):
    flags = ["--alpha", "0.5", "--beta", "3.5", "--gamma", "0.4", "--convention", convention]
    summary = answer("stability", *flags)
    found = summary["nearest_stable"]
    expected = nearest_stable(Gains((0.5, 3.5, 0.4), convention))
    assert found == {"convention": convention, **dict(zip(GAIN_NAMES, [*expected.values, None], strict=True))}
    assert [name for name, value in summary["merits"].items() if value is not None] == ["spectral_radius"]


# Refusals ----------------------------------------------------------------------------------------------------------


def assert_refused(outcome, *words):
    """Exit status 2, nothing on stdout, one line on stderr that holds the words."""
    status, out, err = outcome
    assert status == 2
    assert out == ""
    assert len(err.splitlines()) == 1
    assert err.endswith("\n")
    for word in words:
        assert word in err


REFUSED = [
    ("run --interval 0", ["interval must be a finite number >= 1e-06", "got '0'"]),
    ("run --interval -1", ["interval must be", "got '-1'"]),
    ("run --interval nan", ["interval must be", "got 'nan'"]),
    ("run --interval inf", ["interval must be", "got 'inf'"]),
    ("run --samples 2", ["samples must be a whole number >= 3 and <= 200,000", "got '2'"]),
    ("run --samples 200001", ["samples must be", "got '200001'"]),
    ("run --samples 3.5", ["samples must be a whole number", "got '3.5'"]),
    ("run --noise-std -1", ["noise_std must be a finite number >= 0", "got '-1'"]),
    ("run --noise-std 1,2,3", ["noise_std must be one number, or 2 for the axes x, y"]),
    ("run --scenario garg-accelerating --noise-std 1,2", ["noise_std must be one number", "[1.0, 2.0]"]),
    ("run --seed 0.5", ["seed must be a whole number >= 0", "got '0.5'"]),
    ("run --order 5", ["order must be a whole number >= 2 and <= 4", "got '5'"]),
    ("run --scenario mars", ["scenario must be one of jeong-ship,", "got 'mars'"]),
    ("run --noise pink", ["noise must be one of white, coloured, none, recorded", "got 'pink'"]),
    ("run --start cold", ["start must be one of known, first,", "got 'cold'"]),
    ("run --convention own", ["convention must be one of normalised, taylor, half", "got 'own'"]),
    ("run --design guess", ["design must be one of manual,", "got 'guess'"]),
    ("run --start three-point --order 2 --xi 0.5", ["start must not be 'three-point' for a filter of order 2"]),
    ("run --noise recorded", ["noise must not be 'recorded': nothing was recorded for 'jeong-ship'"]),
    ("run --design benedict-bordner --alpha 2", ["alpha must be a finite number > 0 and < 2", "got 2"]),
    ("run --tracking-index 0", ["tracking_index must be a finite number >= 1e-12 and <= 1,000,000", "got 0"]),
    ("run --xi 1", ["xi must be a finite number >= 0 and < 1", "got 1"]),
    ("run --alpha 0.5", ["beta must be given for order 2", "got None"]),
    ("run --order 3 --alpha 0.5 --beta 0.2", ["gamma must be given for order 3"]),
    ("run --order 2 --alpha 0.5 --beta 0.2 --gamma 0.1", ["gamma must be left out", "got 0.1"]),
    ("run --alpha much --beta 1", ["alpha must be a finite number", "got 'much'"]),
    ("run --experiment no-such-file.json", ["'no-such-file.json': No such file or directory"]),
    ("run --experiment .", ["'.': Is a directory"]),
    ("run --out no-such-folder/track.csv", ["'no-such-folder/track.csv': No such file or directory"]),
    ("run --speed 3", ["--speed"]),
    ("run 3", ["3"]),
    ("run --interval", ["--interval", "expected one argument"]),
    ("", ["run|suggest|design|stability"]),
    ("walk", ["walk"]),
    ("design", ["NAME"]),
    ("design guess", ["design must be one of fading-memory,", "got 'guess'"]),
    ("design manual", ["design must be one of fading-memory,", "got 'manual'"]),
    ("design kalata", ["tracking_index must be given for the design 'kalata'"]),
    ("design kalata --tracking-index -1", ["tracking_index must be a finite number >= 1e-12 and <= 1,000,000", "'-1'"]),
    ("design kalata --tracking-index 1 --order 3", ["order must be 2 for the design 'kalata'", "got 3"]),
    ("design kalata --tracking-index 1 --order two", ["order must be a whole number", "got 'two'"]),
    ("design kalata --tracking-index 1 --convention own", ["convention must be one of", "got 'own'"]),
    ("design kalata --xi 0.5", ["xi must be left out for the design 'kalata'"]),
    ("design kalata --process-std 1", ["sensor_std must be given"]),
    ("design kalata --process-std 1 --sensor-std 1", ["interval must be given"]),
    ("design fading-memory --order 2 --xi .5 --process-std 1", ["process_std must be left out"]),
    ("design kalata --sensor-std 1 --interval 1", ["process_std must be given"]),
    ("design kalata --process-std 0 --sensor-std 1 --interval 1", ["process_std must be a finite number > 0", "'0'"]),
    ("design kalata --process-std 1 --sensor-std -1 --interval 1", ["sensor_std must be", "'-1'"]),
    ("design kalata --process-std 1 --sensor-std 1 --interval 0", ["interval must be", "'0'"]),
    ("design kalata --process-std 1e9 --sensor-std 1 --interval 1", ["tracking_index must be"]),
    ("design kalata --tracking-index 1 --interval 1", ["tracking_index must be left out"]),
    ("design fading-memory --xi 0.5", ["order must be 2 or 3 or 4 for the design 'fading-memory'"]),
    ("design benedict-bordner --alpha 2", ["alpha must be a finite number > 0 and < 2", "'2'"]),
    ("stability", ["alpha must be given for order 2"]),
    ("stability --alpha 0.5", ["beta must be given for order 2"]),
    ("stability --alpha 0.5 --beta 0.2 --order 3", ["gamma must be given for order 3"]),
    ("stability --alpha 0.5 --beta 0.2 --gamma 0.1 --order 2", ["gamma must be left out for order 2", "'0.1'"]),
    ("stability --alpha nan --beta 0.2", ["alpha must be a finite number", "'nan'"]),
    ("stability --alpha 1001 --beta 0.2", ["alpha must be a finite number >= -1,000 and <= 1,000", "'1001'"]),
    ("stability --alpha 0.5 --beta 0.2 --convention own", ["convention must be one of", "'own'"]),
    ("stability --alpha 0.5 --beta 0.2 --interval 0", ["interval must be a finite number >= 1e-06", "'0'"]),
    ("stability --alpha 0.5 --beta 0.2 --order 7", ["order must be a whole number", "'7'"]),
]  # fmt: skip


@pytest.mark.parametrize(("line", "words"), REFUSED, ids=[line or "nothing" for line, _ in REFUSED])
def test_bad_command_line_is_refused(call, line, words):
    assert_refused(call(*line.split()), *words)


@pytest.mark.parametrize("line", [line for line, _ in REFUSED if line], ids=str)
def test_refused_as_json_too(call, line):
    assert_refused(call(*line.split(), "--json"))


FILES = [
    ("not-json", b"{", ["experiment must be a JSON file"]),
    ("empty", b"", ["experiment must be a JSON file"]),
    ("not-utf-8", b'{"seed": "\xff"}', ["experiment must be a JSON file"]),
    ("list", b"[1, 2]", ["experiment must be a JSON object", "[1, 2]"]),
    ("number", b"3", ["experiment must be a JSON object", "3"]),
    ("unknown-field", b'{"speed": 3}', ["speed", "3"]),
    ("bad-value", b'{"interval": -1}', ["interval must be", "-1"]),
    ("nan", b'{"interval": NaN}', ["interval must be", "nan"]),
    ("text-with-breaks", b'{"scenario": "a\\nb"}', ["scenario must be one of"]),
    ("list-for-number", b'{"seed": [1]}', ["seed must be a whole number", "[1]"]),
    ("field-name-with-breaks", b'{"a\\nb": 1}', ["'a\\nb' is not a field", "got 1"]),
    ("too-deep", b"[" * 100_000, ["experiment must be a JSON file"]),
    ("manual-with-xi-alone", b'{"design": "manual", "xi": 0.5}', ["alpha must be given for order 3"]),
]


@pytest.mark.parametrize(
    ("content", "words"), [pytest.param(content, words, id=name) for name, content, words in FILES]
)
def test_bad_experiment_file_is_refused(call, tmp_path, content, words):
    file = tmp_path / "experiment.json"
    file.write_bytes(content)
    assert_refused(call("run", "--experiment", file), *words)


def test_a_negative_number_may_have_an_exponent(answer):
    assert answer("stability", "--alpha", "0.5", "--beta", "-1e-3")["stable"] is False


def test_a_vanishing_gain_still_prints_json(answer):
    assert answer("run", "--alpha", "0.5", "--beta", "1e-320")["stable"] is True


# Help and the real thing -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["run", "design", "stability"])
def test_help_names_the_flags(call, command):
    status, out, err = call(command, "--help")
    assert (status, err) == (0, "")
    for name in FIELDS if command == "run" else ["order", "convention", "alpha", "beta"]:
        assert f"--{name.replace('_', '-')}" in out


def program(*arguments):
    command = [sys.executable, "-X", "utf8", "-m", "tracker_core", *arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, encoding="utf-8", check=False)


def test_the_program_prints_what_main_prints(answer):
    flags = ["design", "gray-murray", "--tracking-index", "0.1"]
    done = program(*flags, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == answer(*flags)


@pytest.mark.parametrize("line", ["run --interval 0", "design guess", "walk"])
def test_the_program_refuses_with_status_two_and_one_line(line):
    done = program(*line.split())
    assert_refused((done.returncode, done.stdout, done.stderr))
    assert done.stderr.startswith("python -m tracker_core")


# sweep -------------------------------------------------------------------------------------------------------------

XI = ["sweep", "xi", "--samples", 50, "--runs", 4, "--from", 0.4, "--to", 0.8, "--points", 5]


def test_sweep_prints_what_every_value_comes_to(call):
    status, out, err = call(*XI, "--for", "tracking_rmse", "--json")
    assert (status, err) == (0, "")
    found = json.loads(out)
    assert found["values"] == pytest.approx([0.4, 0.5, 0.6, 0.7, 0.8])
    for value, mean in zip(found["values"], found["mean"], strict=True):
        runs = [Experiment.from_dict({"samples": 50, "xi": value, "seed": seed}) for seed in range(1, 5)]
        expected = np.mean([run_experiment(run).metrics.tracking_rmse for run in runs])
        assert mean == pytest.approx(expected, rel=1e-11)
    assert found["optimum"]["low"] <= found["optimum"]["value"] <= found["optimum"]["high"]
    assert found["runs"] == 4
    assert Experiment.from_dict(found["experiment"]).samples == 50


def test_sweep_in_words(call):
    status, out, _ = call(*XI)
    assert status == 0
    assert out.count("\n") == 1 + 5 + 2
    assert out.splitlines()[-1].startswith("best: ξ = 0.")
    assert out.splitlines()[-1].endswith("over 4 runs")


def test_sweep_without_chance_has_no_interval(call):
    status, out, _ = call("sweep", "xi", "--samples", 50, "--noise", "none", "--points", 5, "--json")
    found = json.loads(out)
    assert status == 0
    assert found["runs"] == 1
    assert set(found["low"]) == {None}
    assert found["optimum"]["low"] is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["sweep", "speed"], "parameter must be one of alpha"),
        (["sweep", "eta"], "parameter must be "),
        ([*XI, "--runs", 10**9], "runs must be a whole number >= 1 and <= 10,000, got '1000000000'"),
        ([*XI, "--points", 0], "points must be"),
        ([*XI, "--from", "low"], "low must be a finite number, got 'low'"),
        ([*XI, "--from", 0.9], "high must be > 0.9"),
        ([*XI, "--for", "joy"], "objective must be one of"),
        (["sweep", "xi", "--noise-weight", 2], "weight must be"),
    ],
)
def test_sweep_refuses(call, arguments, message):
    status, out, err = call(*arguments)
    assert (status, out) == (2, "")
    assert f"python -m tracker_core: {message}" in err
