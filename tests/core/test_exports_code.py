"""The tuned filter as source code: compiled, run, and compared with the filter that it came from, sample by sample."""

import csv
import importlib.util
import math
import shutil
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracker_core import STARTS, Experiment, Gains, Gate, InputError, Measurements, run_experiment, run_filter
from tracker_core.exports.code import sources, tuned_filter
from tracker_core.exports.code.sources import FILES, C
from tracker_core.exports.code.template import comment, harmless, render
from tracker_core.exports.code.tuned import TRIAL, describe

ORDERS = [2, 3, 4]
GAINS = {2: Gains((0.3, 0.06)), 3: Gains((0.4, 0.1, 0.006), "taylor"), 4: Gains((0.5, 0.16, 0.06, 0.018), "half")}
CASES = [(order, start) for order in ORDERS for start in STARTS if order >= STARTS[start].least_order]
COMPILER = shutil.which("gcc") or shutil.which("cc")
OCTAVE = shutil.which("octave-cli")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wshadow", "-Wconversion")

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler")
needs_octave = pytest.mark.skipif(OCTAVE is None, reason="no Octave")


def recording(seed, axes=2, *, samples=80, irregular=False, holes=0.15, outliers=0.1):
    draw = np.random.default_rng(seed)
    z = draw.normal(size=(samples, axes)).cumsum(axis=0) * 2 + draw.normal(size=(samples, axes)) * 3 + 1000
    z[draw.random((samples, axes)) < holes] = np.nan
    z[draw.random(samples) < outliers] += 300
    if irregular:
        return Measurements(np.cumsum(draw.uniform(0.4, 0.6, samples)), z, None)
    return Measurements(np.arange(samples) * 0.5, z, 0.5)


def setup(order, start, *, axes=2, gated=True, **changes):
    state = np.random.default_rng(order).normal(size=(axes, order))
    state[:, 0] += 1000
    return {
        "start": start,
        "initial_state": state if start == "known" else None,
        "gate": Gate(4.0, (3.0,) if axes == 2 else (3.0, 2.0, 4.0)[:axes], 0.05, 0.4) if gated else None,
        **changes,
    }


def tuned(measurements, order, options, **words):
    axes = tuple("xyz")[: measurements.positions.shape[1]]
    return describe(measurements, GAINS[order], axes=axes, **options, **words)


def intervals(measurements):
    if measurements.interval is not None:
        return np.full(len(measurements.times), measurements.interval)
    steps = np.diff(measurements.times)
    return np.concatenate((steps[:1], steps))


def assert_same(found, track, z):
    """Predicted, smoothed, innovation and rejected of every sample, to twelve digits of each state's scale.

    What is computed from positions by differences has their rounding: it sets the scale of the derivatives.
    """
    predicted, smoothed, innovation, rejected = found
    seen = np.nanmax(np.abs(z))
    for one, other in ((predicted, track.predicted), (smoothed, track.smoothed)):
        assert np.array_equal(np.isnan(one), np.isnan(other))
        scale = np.nanmax(np.abs(other), axis=(0, 1), initial=seen)
        assert (np.nan_to_num(np.abs(one - other)) <= 1e-12 * scale).all()
    assert np.array_equal(np.isnan(innovation), np.isnan(track.innovation))
    assert np.nan_to_num(np.abs(innovation - track.innovation)).max() <= 1e-12 * max(seen, np.nanmax(np.abs(smoothed)))
    assert np.array_equal(rejected, np.zeros(len(z), dtype=bool) if track.rejected is None else track.rejected)


def write(folder, filter_):
    for name, text in sources(filter_).items():
        (folder / name).write_text(text, encoding="utf-8")


def load(path):
    spec = importlib.util.spec_from_file_location("exported", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run_python(folder, measurements):
    tracker = load(folder / "tuned_filter.py").TunedFilter()
    steps = [
        tracker.update(z, t) for z, t in zip(measurements.positions.tolist(), intervals(measurements), strict=True)
    ]
    return tuple(np.array(part) for part in zip(*steps, strict=True))


DRIVER = """
#include "tuned_filter.h"
#include <stdio.h>

int main(void)
{
    tuned_filter tracker;
    tuned_filter_step step;
    double t, z[TUNED_FILTER_AXES];
    tuned_filter_init(&tracker);
    while (scanf("%lf", &t) == 1) {
        for (int i = 0; i < TUNED_FILTER_AXES; i++)
            if (scanf("%lf", &z[i]) != 1)
                return 1;
        if (tuned_filter_update(&tracker, t, z, &step) != (t > 0 ? 0 : -1))
            return 1;
        for (int i = 0; i < TUNED_FILTER_AXES; i++) {
            for (int r = 0; r < TUNED_FILTER_ORDER; r++)
                printf("%.17g,%.17g,", step.predicted[i][r], step.smoothed[i][r]);
            printf("%.17g,", step.innovation[i]);
        }
        printf("%d\\n", step.rejected);
    }
    return 0;
}
"""


def compiled(folder, *sources_, name="driver"):
    subprocess.run([COMPILER, *STRICT, *sources_, "-o", name, "-lm"], cwd=folder, check=True)
    return folder / name


def run_c(program, steps, positions, order):
    lines = [" ".join(map(repr, [float(t), *z])) for t, z in zip(steps, positions.tolist(), strict=True)]
    done = subprocess.run([program], input="\n".join(lines), check=True, capture_output=True, text=True)
    return read_rows(done.stdout, positions.shape[1], order)


def read_rows(text, axes, order):
    """Rows of, per axis, the pairs of predicted and smoothed states and the innovation; then whether refused."""
    rows = np.array([[float(cell) for cell in row] for row in csv.reader(text.splitlines())])
    per_axis = rows[:, :-1].reshape(len(rows), axes, 2 * order + 1)
    return per_axis[:, :, 0:-1:2], per_axis[:, :, 1:-1:2], per_axis[:, :, -1], rows[:, -1] == 1


@pytest.mark.parametrize(("order", "start"), CASES)
@pytest.mark.parametrize("gated", [False, True])
@settings(max_examples=12)
@given(seed=st.integers(0, 10**6), axes=st.integers(1, 3), irregular=st.booleans())
def test_python_is_the_filter(tmp_path_factory, order, start, gated, seed, axes, irregular):
    folder = tmp_path_factory.mktemp("python")
    seen, options = recording(seed, axes, irregular=irregular), setup(order, start, axes=axes, gated=gated)
    write(folder, tuned(seen, order, options))
    assert_same(run_python(folder, seen), run_filter(seen, GAINS[order], **options), seen.positions)


@needs_compiler
@pytest.mark.parametrize(("order", "start"), CASES)
@pytest.mark.parametrize("gated", [False, True])
@pytest.mark.parametrize("axes", [1, 2, 3])
def test_c_is_the_filter(tmp_path, order, start, gated, axes):
    options = setup(order, start, axes=axes, gated=gated)
    write(tmp_path, tuned(recording(0, axes), order, options))
    (tmp_path / "driver.c").write_text(DRIVER)
    program = compiled(tmp_path, "driver.c", "tuned_filter.c")

    @settings(max_examples=6)
    @given(seed=st.integers(0, 10**6), irregular=st.booleans(), holes=st.sampled_from([0, 0.2, 0.5]))
    def holds(seed, irregular, holes):
        seen = recording(seed, axes, irregular=irregular, holes=holes, samples=300)
        assert_same(
            run_c(program, intervals(seen), seen.positions, order),
            run_filter(seen, GAINS[order], **options),
            seen.positions,
        )

    holds()


@needs_octave
@pytest.mark.parametrize(("order", "start"), CASES)
@pytest.mark.parametrize("gated", [False, True])
@pytest.mark.parametrize("irregular", [False, True])
def test_octave_is_the_filter(tmp_path, order, start, gated, irregular):
    seen, options = recording(3, irregular=irregular), setup(order, start, gated=gated)
    write(tmp_path, tuned(seen, order, options))
    np.savetxt(tmp_path / "in.csv", np.column_stack((intervals(seen), seen.positions)), fmt="%.17g", delimiter=",")
    script = """
        input = dlmread('in.csv');
        tracker = tuned_filter();
        for k = 1:size(input, 1)
            [tracker, step] = tuned_filter(tracker, input(k, 2:end), input(k, 1));
            for i = 1:size(step.predicted, 1)
                fprintf('%.17g,', [step.predicted(i, :); step.smoothed(i, :)], step.innovation(i));
            end
            fprintf('%d\\n', step.rejected);
        end
    """
    (tmp_path / "drive.m").write_text(textwrap.dedent(script))
    done = subprocess.run([OCTAVE, "--norc", "drive.m"], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert_same(read_rows(done.stdout, 2, order), run_filter(seen, GAINS[order], **options), seen.positions)


@pytest.mark.parametrize(("order", "start"), CASES)
@pytest.mark.parametrize("irregular", [False, True])
def test_filterpy_is_the_filter_from_the_end_of_the_start_on(tmp_path, capsys, order, start, irregular):
    pytest.importorskip("filterpy")
    write(tmp_path, tuned(recording(4, irregular=irregular), order, setup(order, start)))
    assert load(tmp_path / "filterpy_filter.py").self_test()
    assert len(capsys.readouterr().out.splitlines()) == TRIAL


# The self-tests ----------------------------------------------------------------------------------------------------

COMMANDS = {
    "tuned_filter.py": [sys.executable, "-I", "-S", "tuned_filter.py"],
    "tuned_filter.c": ["./self_test"],
    "tuned_filter.m": [OCTAVE, "--norc", "tuned_filter_test.m"],
}


def self_test(folder, name):
    if name == "tuned_filter.c":
        if COMPILER is None:
            pytest.skip("no C compiler")
        compiled(folder, "-DSELF_TEST", "tuned_filter.c", name="self_test")
    if name == "tuned_filter.m" and OCTAVE is None:
        pytest.skip("no Octave")
    return subprocess.run(COMMANDS[name], cwd=folder, check=False, capture_output=True, text=True)


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize(("order", "start"), [(2, "two-point"), (3, "expanding"), (4, "known"), (3, "first")])
def test_the_self_test_prints_ten_samples_and_agrees(tmp_path, name, order, start):
    seen = recording(1)
    write(tmp_path, tuned(seen, order, setup(order, start)))
    done = self_test(tmp_path, name)
    assert done.returncode == 0, done.stderr
    _, *lines, last = done.stdout.splitlines()
    assert last == "equal"
    track = run_filter(seen, GAINS[order], **setup(order, start))
    numbers = np.array([[float(cell) for cell in line.split()] for line in lines])
    assert numbers.shape == (10, 4)
    assert np.array_equal(numbers[:, 1::2], track.smoothed[:10, :, 0], equal_nan=True)


@pytest.mark.parametrize("name", COMMANDS)
def test_the_self_test_notices_another_gain(tmp_path, name):
    write(tmp_path, tuned(recording(1, holes=0), 2, setup(2, "two-point", gated=False)))
    path = tmp_path / name
    text = path.read_text(encoding="utf-8")
    assert text.count("0.3, 0.06") == 1
    path.write_text(text.replace("0.3, 0.06", "0.300001, 0.06"), encoding="utf-8")
    assert self_test(tmp_path, name).returncode != 0


def test_an_exported_filter_stops_where_the_filter_does(tmp_path):
    seen = recording(2, 1, samples=300, holes=0)
    options = setup(2, "two-point", axes=1, gated=False, limit=1e6)
    described = describe(seen, Gains((0.5, 3.9)), axes=("x",), **options)
    write(tmp_path, described)
    track = run_filter(seen, Gains((0.5, 3.9)), **options)
    assert track.stopped_at is not None
    found = run_python(tmp_path, seen)
    assert np.array_equal(np.isnan(found[1]), np.isnan(track.smoothed))
    assert np.isnan(found[1][track.stopped_at + 1 :]).all()
    if COMPILER:
        (tmp_path / "driver.c").write_text(DRIVER)
        found = run_c(compiled(tmp_path, "driver.c", "tuned_filter.c"), intervals(seen), seen.positions, 2)
        assert np.array_equal(np.isnan(found[1]), np.isnan(track.smoothed))


@pytest.mark.parametrize(
    ("gains", "interval"),
    [(Gains((0.7, 0.2)), t) for t in (3.7, 6.3, 7.4, 7.7)] + [(Gains((0.95, 0.8, 0.3)), t) for t in (5.0, 10.0)],
    ids=str,
)
def test_a_growing_memory_whose_gain_is_alpha_has_handed_over(tmp_path, gains, interval):
    """Its gain at the fourth measurement is 7/10 at order 2 and 19/20 at order 3: ties, but for rounding."""
    seen = recording(3, holes=0, outliers=0)
    seen = Measurements(np.arange(len(seen.positions)) * interval, seen.positions, interval)
    write(tmp_path, describe(seen, gains, axes=("x", "y"), start="expanding"))
    track = run_filter(seen, gains, start="expanding")
    assert_same(run_python(tmp_path, seen), track, seen.positions)
    one = run_filter(Measurements(seen.times / interval, seen.positions, 1.0), gains, start="expanding")
    np.testing.assert_allclose(track.smoothed[:, :, 0], one.smoothed[:, :, 0], rtol=1e-12)
    # The fourth measurement is the constant gains' own.
    before, after = track.predicted[3, :, 1], track.smoothed[3, :, 1]
    np.testing.assert_allclose(after - before, gains.vector[1] * track.innovation[3] / interval, rtol=1e-9)


@pytest.mark.parametrize("gated", [False, True])
def test_an_exported_filter_stops_where_its_state_is_no_number(tmp_path, gated):
    """After an endless interval nothing is known any more."""
    seen, options = recording(6, holes=0, outliers=0), setup(2, "two-point", gated=gated)
    write(tmp_path, tuned(seen, 2, options))
    tracker = load(tmp_path / "tuned_filter.py").TunedFilter()
    for z in seen.positions[:5].tolist():
        tracker.update(z)
    assert not tracker.stopped
    tracker.update(seen.positions[5].tolist(), math.inf)
    assert tracker.stopped
    if COMPILER:
        (tmp_path / "driver.c").write_text(DRIVER)
        program = compiled(tmp_path, "driver.c", "tuned_filter.c")
        smoothed = run_c(program, [0.5] * 5 + [math.inf, 0.5], seen.positions[:7], 2)[1]
        assert np.isfinite(smoothed[2:5]).all()
        assert np.isnan(smoothed[5:]).all()


@needs_compiler
@pytest.mark.parametrize("gated", [False, True])
def test_c_refuses_an_interval_that_is_none_and_goes_on(tmp_path, gated):
    """Two plots with one time stamp leave the filter as it was."""
    seen, options = recording(7, holes=0, outliers=0), setup(2, "two-point", gated=gated)
    write(tmp_path, tuned(seen, 2, options))
    (tmp_path / "driver.c").write_text(DRIVER)
    program = compiled(tmp_path, "driver.c", "tuned_filter.c")
    steps = [0.5 if k % 2 == 0 else (0.0, -1.0, math.nan)[k % 3] for k in range(2 * len(seen.positions))]
    found = run_c(program, steps, np.repeat(seen.positions, 2, axis=0), 2)
    assert np.isnan(found[1][1::2]).all()
    assert_same(tuple(part[::2] for part in found), run_filter(seen, GAINS[2], **options), seen.positions)


@pytest.mark.parametrize("start", ["two-point", "expanding"])
def test_a_trial_that_no_limit_stops_goes_on_behind_the_stop(start):
    """FilterPy has no limit: what it is compared with has none either."""
    gains, seen = Gains((0.5, 3.9)), recording(2, 2, holes=0, outliers=0)
    z = seen.positions.copy()
    z[:4, 1] = np.nan
    limit = 1.0001 * np.abs(z[0, 0])
    made = describe(Measurements(seen.times, z, 0.5), gains, axes=("x", "y"), start=start, limit=limit)
    assert run_filter(Measurements(seen.times, z, 0.5), gains, start=start, limit=limit).stopped_at < 5
    trial, g = made.trial, gains.vector / 0.5 ** np.arange(2)
    assert len(trial.onward) == TRIAL
    state = trial.state.copy()
    for measured, smoothed in zip(trial.onward, trial.onward_smoothed, strict=True):
        state[:, 0] += 0.5 * state[:, 1]
        state += np.outer(measured - state[:, 0], g)
        np.testing.assert_allclose(state[:, 0], smoothed, rtol=1e-12)


@pytest.mark.parametrize("start", ["expanding", "first"])
@pytest.mark.parametrize("gate", [None, Gate(4.0, (3.0,), 0.05, 0.4)], ids=["open", "gated"])
def test_a_gain_of_one_needs_no_growing_memory(tmp_path, start, gate):
    seen, options = recording(5, holes=0), {"start": "expanding", "gate": gate}
    gains = Gains((1.0, 0.5))
    write(tmp_path, describe(seen, gains, axes=("x", "y"), start=start, gate=gate))
    assert_same(run_python(tmp_path, seen), run_filter(seen, gains, **options), seen.positions)


def test_python_takes_none_for_a_missing_measurement_and_refuses_nonsense(tmp_path):
    write(tmp_path, tuned(recording(1), 2, setup(2, "first")))
    tracker = load(tmp_path / "tuned_filter.py").TunedFilter()
    tracker.update([1.0, None])
    step = tracker.update([None, 2])
    assert step.smoothed[0] == [1.0, 0.0]
    assert step.smoothed[1] == [2.0, 0.0]
    for bad in ([1.0], [1.0, 2.0, 3.0]):
        with pytest.raises(ValueError, match="expected 2 positions"):
            tracker.update(bad)
    for bad in (0.0, -1.0, math.nan):
        with pytest.raises(ValueError, match="expected an interval > 0"):
            tracker.update([1.0, 2.0], bad)


# What it is made from, and what it says ----------------------------------------------------------------------------


def test_the_filter_of_an_experiment():
    result = run_experiment(Experiment.from_dict({"scenario": "garg-accelerating"}))
    found = tuned_filter(result, origin="https://example.org/?scenario=garg-accelerating")
    assert found.gains == result.gains
    assert found.start == result.experiment.start
    assert found.interval == result.experiment.interval
    assert found.axes == ("range",)
    assert found.title == result.scenario.title
    assert np.array_equal(found.trial.smoothed, result.track.smoothed[:10, :, 0])
    text = sources(found)["tuned_filter.py"]
    assert "https://example.org/?scenario=garg-accelerating" in text
    named = dict(zip(("alpha", "beta", "gamma"), result.gains.values, strict=True))
    for name, value in named.items():
        assert f"{name} = {value!r}" in text
    assert f"convention '{result.gains.convention}'" in text


def test_a_method_that_chooses_gains_is_refused():
    result = run_experiment(Experiment.from_dict({"design": "growing-memory", "samples": 40}))
    with pytest.raises(InputError) as caught:
        tuned_filter(result)
    assert caught.value.field == "design"
    assert caught.value.received == "growing-memory"


def test_axes_without_a_name_are_refused():
    with pytest.raises(InputError, match="axes must be 2 names"):
        describe(recording(1), GAINS[2], axes=("x",))


@pytest.mark.parametrize(
    ("convention", "terms"),
    [
        ("normalised", "alpha e, beta e/T, gamma e/T^2, eta e/T^3"),
        ("taylor", "alpha e, beta e/T, 2 gamma e/T^2, 6 eta e/T^3"),
        ("half", "alpha e, beta e/T, gamma e/(2 T^2), eta e/(6 T^3)"),
    ],
)
def test_the_convention_is_written_out(convention, terms):
    seen = recording(1)
    text = sources(describe(seen, Gains((0.5, 0.16, 0.03, 0.003)).to(convention), axes=("x", "y")))["tuned_filter.py"]
    assert terms in " ".join(text.replace("#", "").split())


EVIL = [
    '*/ int main(void) { return 3; } /*',
    '"""\nraise SystemExit(3)\n"""',
    "line\nraise SystemExit(3)\r\x0b\x0c\x1c\u2028\u0085raise SystemExit(3)",
    "a backslash at the end \\",
    "??/\n??/",
    "%{\nexit(3)\n%}",
    "# -*- coding: utf-7 -*-",
    "@{head} @if gate @end {0} %s $x",
    "*" * 300 + "/",
    "\ud800 \u202e \x00 \x1b[31m",
    "höhe 高さ ±",
]  # fmt: skip


@pytest.mark.parametrize("text", EVIL, ids=range(len(EVIL)))
def test_no_text_breaks_out_of_its_comment(tmp_path, text):
    """Every file is the same but for its comments, and still compiles and agrees."""
    seen, options = recording(1), setup(3, "two-point")
    axes = (text, "y")
    described = describe(seen, GAINS[3], axes=axes, title=text, origin=text, **options)
    plain = describe(seen, GAINS[3], axes=("x", "y"), title="", origin="", **options)
    write(tmp_path, described)
    for name in COMMANDS:
        if (name.endswith("c") and COMPILER) or name.endswith("py") or (name.endswith("m") and OCTAVE):
            assert self_test(tmp_path, name).returncode == 0
    for name, (language, _) in FILES.items():
        assert code(sources(described)[name], language) == code(sources(plain)[name], language)


def code(text, language):
    """A source without the comment at its head."""
    if language is C:
        return text[text.index("\n */\n") :] if "\n */\n" in text else text
    return [line for line in text.splitlines() if not line.startswith(language.prefix.rstrip())]


@given(st.text())
def test_harmless_text_is_one_line_without_a_mark(text):
    found = harmless(text)
    assert found.isprintable()
    for mark in ("*/", "/*", "??"):
        assert mark not in found
    assert len(found.splitlines()) <= 1


@given(st.lists(st.text()))
def test_every_line_of_a_comment_has_its_prefix(lines):
    assert all(line.startswith("%") for line in comment(lines, "% ").splitlines())


def test_a_template_keeps_what_holds(monkeypatch, tmp_path):
    (tmp_path / "templates").mkdir()
    (tmp_path / "templates" / "t").write_text("a @{x}\n@if b\nb\n@if not c\nc\n@end\n@end\n@if not b\nd\n@end\n")
    monkeypatch.setattr("tracker_core.exports.code.template.files", lambda _: tmp_path)
    assert render("t", {"x": "@{y}"}, {"b": True, "c": False}) == "a @{y}\nb\nc\n"
    assert render("t", {"x": "1"}, {"b": False, "c": False}) == "a 1\nd\n"


@pytest.mark.parametrize(("order", "start"), CASES)
@pytest.mark.parametrize("gated", [False, True])
def test_the_code_is_tidy(order, start, gated):
    """Nothing left of the templates, no gaps, no trailing blanks; Python without an unused name."""
    found = sources(tuned(recording(1), order, setup(order, start, gated=gated)))
    assert list(found) == list(FILES)
    for text in found.values():
        assert "@" not in text
        assert text.endswith("\n")
        assert "\n\n\n\n" not in text
        assert [line for line in text.splitlines() if line != line.rstrip()] == []
        assert [line for line in text.splitlines() if len(line) > 120] == []
    used = found["tuned_filter.py"]
    names = ("WIDTH", "POINTS", "HUGE", "FAR", "interpolation", "carry_covariance", "learn", "begin", "sqrt", "hypot")
    for name in names:
        assert used.count(name) != 1
