"""Measured data as targets: files by their content, and experiments on them."""

import hashlib
import io
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import SCENARIOS, Experiment, InputError, measured, run_experiment, run_filter
from tracker_core.__main__ import main
from tracker_core.consistency import believed_share
from tracker_core.exports import write_track
from tracker_core.innovations import examine
from tracker_core.measured import (
    FILE_BYTES,
    NAME_LENGTH,
    RECORDING,
    SHELF,
    File,
    Shelf,
    clean_name,
    content_name,
    fetch,
    look_in,
    target,
)
from tracker_core.run import observe, suited
from tracker_core.suggestion import suggest
from tracker_core.types import Measurements

RANDOM = np.random.default_rng(7)
SAMPLES = 60
TIMES = np.arange(SAMPLES) * 0.5
TRUE = np.stack([30 * TIMES, 400 * np.sin(TIMES / 9)], axis=1)
SEEN = TRUE + RANDOM.normal(0, 2, TRUE.shape)
SEEN[20] = np.nan
ODD_TIMES = np.concatenate(([0.0], np.cumsum(RANDOM.uniform(0.2, 1.7, SAMPLES - 1))))


def table(times, *columns, head="t,x,y"):
    rows = zip(times, *(column for block in columns for column in block.T), strict=True)
    cells = (["" if value != value else repr(float(value)) for value in row] for row in rows)
    return "\n".join([head, *(",".join(row) for row in cells)]).encode()


def kept(content, name="boat.csv"):
    return SHELF.keep(File(name, content))


@pytest.fixture(scope="module")
def constant():
    return kept(table(TIMES, SEEN))


@pytest.fixture(scope="module")
def varying():
    return kept(table(ODD_TIMES, SEEN))


@pytest.fixture(scope="module")
def known():
    return kept(table(TIMES, SEEN, TRUE, head="t,x,y,x_true,y_true"))


def test_a_file_is_known_by_its_content():
    content = b"t,x\n0,1\n"
    assert content_name(content) == hashlib.sha256(content).hexdigest()[:32]
    assert fetch(kept(content, "one.csv")).content == content
    assert kept(content, "two.csv") == content_name(content)


@pytest.mark.parametrize("data", ["f" * 32, "", "F" * 32, "../../etc/passwd", "0" * 31, "0" * 33, "é" * 32])
def test_what_is_nowhere_is_said_so(data):
    with pytest.raises(InputError) as caught:
        fetch(data)
    assert (caught.value.field, caught.value.received) == ("data", data)


def test_other_places_are_looked_in_too():
    file = File("far.csv", b"far away")
    asked = []

    def source(data):
        asked.append(data)
        return file if data == file.data else None

    look_in(source)
    look_in(source)
    assert fetch(file.data) is file
    assert asked == [file.data]


@given(st.text(max_size=300))
def test_a_name_is_one_line_without_folders(name):
    cleaned = clean_name(name)
    assert 0 < len(cleaned) <= NAME_LENGTH
    assert cleaned.isprintable()
    assert "/" not in cleaned
    assert "\\" not in cleaned
    assert clean_name(cleaned) == cleaned


@given(st.lists(st.binary(min_size=1, max_size=40), min_size=1, max_size=30))
def test_a_shelf_holds_what_was_asked_for_last(contents):
    most = 60 + 3 * FILE_BYTES
    shelf = Shelf(most)
    for content in contents:
        shelf.keep(File("", content))
    room, expected = most, []
    for content in dict.fromkeys(reversed(contents)):
        room -= len(content) + FILE_BYTES
        if room < 0:
            break
        expected.append(content)
    expected = expected or [contents[-1]]
    for content in dict.fromkeys(contents):
        file = shelf.fetch(content_name(content))
        assert (file is not None and file.content == content) == (content in expected)


def test_what_nobody_asks_for_is_let_go_where_that_is_wanted(monkeypatch):
    now = [1000.0]
    monkeypatch.setattr(measured.time, "monotonic", lambda: now[0])
    shelf = Shelf()
    first, second = (shelf.keep(File("", content)) for content in (b"one", b"two"))
    now[0] += 1e9
    assert shelf.fetch(first)
    shelf.lifetime = 60.0
    now[0] += 40
    # The second has not been asked for since it came.
    assert shelf.fetch(first)
    assert shelf.fetch(second) is None
    now[0] += 59
    assert shelf.fetch(first)
    now[0] += 61
    assert shelf.fetch(first) is None
    assert (len(shelf._files), shelf._bytes) == (0, 0)


def test_a_recording_is_an_experiment(constant):
    experiment = Experiment.from_dict({"data": constant, "xi": 0.5})
    assert experiment.scenario == RECORDING
    assert (experiment.samples, experiment.interval, experiment.noise) == (SAMPLES, 0.5, "recorded")
    assert experiment.target.measured
    assert experiment.target.title == "boat.csv"
    minimal = experiment.to_dict(minimal=True)
    assert minimal == {"scenario": RECORDING, "data": constant, "reading": experiment.reading, "xi": 0.5}
    assert Experiment.from_dict(minimal) == experiment
    assert Experiment.from_dict(experiment.to_dict()) == experiment


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"scenario": RECORDING}, "data"),
        ({"data": "a" * 32}, "data"),
        ({"data": "boat.csv"}, "data"),
        ({"scenario": "jeong-ship", "data": "it"}, "data"),
        ({"scenario": "jeong-ship", "reading": "time:1"}, "reading"),
        ({"data": "it", "reading": "nonsense"}, "reading"),
        ({"data": "it", "reading": "x" * 700}, "reading"),
        ({"data": "it", "samples": SAMPLES + 1}, "samples"),
        ({"data": "it", "samples": 3}, "samples"),
        ({"data": "it", "interval": 2}, "interval"),
        ({"data": "it", "noise": "white"}, "noise"),
        ({"data": "it", "noise_level": "snr", "snr": 4}, "noise_level"),
        ({"data": "it", "manoeuvre": "jerk-pulses"}, "manoeuvre"),
        ({"data": "it", "start": "known"}, "start"),
        ({"data": "it", "noise_std": (1, 2, 3)}, "noise_std"),
        ({"data": "it", "gate": 0.5}, "gate"),
        ({"data": "it", "gate": 4, "noise_std": 0}, "gate"),
        ({"data": "it", "gate": 4, "design": "parallel-bank-causal"}, "gate"),
    ],
    ids=str,
)
def test_what_does_not_fit_a_recording_is_refused(values, field, constant):
    given_values = {name: constant if value == "it" else value for name, value in values.items()}
    with pytest.raises(InputError) as caught:
        Experiment.from_dict(given_values)
    assert caught.value.field == field


def test_what_is_no_table_is_refused():
    with pytest.raises(InputError) as caught:
        Experiment.from_dict({"data": kept(b"\x00\x01\x02 nothing to read")})
    assert caught.value.field == "data"


@pytest.mark.parametrize("start", ["first", "two-point", "three-point", "expanding"])
def test_a_recording_runs_as_its_numbers_do(start, constant, varying):
    for data, measurements in (
        (constant, Measurements(TIMES, SEEN, 0.5)),
        (varying, Measurements(ODD_TIMES, SEEN, None)),
    ):
        result = run_experiment(Experiment.from_dict({"data": data, "xi": 0.6, "start": start}))
        expected = run_filter(measurements, result.gains, start=start)
        np.testing.assert_allclose(result.track.smoothed, expected.smoothed, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(result.measurements.times, measurements.times, rtol=1e-12, atol=1e-12)
        assert (result.measurements.interval is None) == (data == varying)
        assert not result.truth.known
        figures = result.metrics.to_dict()
        assert figures.pop("innovation_total") > 0
        assert set(figures.values()) == {None}


def test_the_first_samples_of_a_recording(constant):
    whole, part = (
        run_experiment(Experiment.from_dict({"data": constant, "xi": 0.6, **more})) for more in ({}, {"samples": 25})
    )
    np.testing.assert_array_equal(part.track.smoothed, whole.track.smoothed[:25])


def test_a_truth_that_was_recorded_too_counts(known):
    result = run_experiment(Experiment.from_dict({"data": known, "xi": 0.6}))
    assert result.truth.known
    errors = np.hypot(*(result.track.smoothed[:, :, 0] - TRUE).T)
    assert result.metrics.estimation_rmse == pytest.approx(np.sqrt(np.nanmean(errors**2)), rel=1e-12)
    # The velocity of a recorded path is nobody's knowledge.
    assert result.metrics.lag is None
    assert result.scenario.known_states == 1


def test_methods_that_need_no_truth_run_on_recordings(constant, varying):
    for data in (constant, varying):
        result = run_experiment(Experiment.from_dict({"data": data, "design": "parallel-bank-causal"}))
        assert np.isfinite(result.track.smoothed[30]).all()


def test_another_filter_sees_the_same_recording(constant):
    experiment = Experiment.from_dict({"data": constant, "xi": 0.5})
    other = experiment.with_filter({"order": 2, "xi": 0.8, "gate": 5})
    assert (other.data, other.reading, other.gate) == (experiment.data, experiment.reading, 5)
    assert Experiment.from_dict(other.filter_values() | {"data": constant}) == other


def test_the_noise_of_a_recording_is_estimated(constant):
    assert target(constant, Experiment.from_dict({"data": constant}).reading).defaults["noise_std"] == pytest.approx(
        (2, 2), rel=0.4
    )


def run(capsys, *arguments):
    code = main([str(argument) for argument in arguments])
    return code, capsys.readouterr()


def test_the_command_line_reads_a_file(capsys, tmp_path):
    file = tmp_path / "log.csv"
    file.write_bytes(table(TIMES, SEEN))
    code, captured = run(capsys, "run", "--data", file, "--xi", "0.6", "--json")
    summary = json.loads(captured.out)
    assert code == 0
    assert summary["experiment"]["data"] == content_name(file.read_bytes())
    assert summary["metrics"]["estimation_rmse"] is None
    assert summary["metrics"]["innovation_total"] > 0


@pytest.mark.parametrize("name", ["absent.csv", "."])
def test_the_command_line_says_what_it_cannot_read(capsys, tmp_path, name):
    code, captured = run(capsys, "run", "--data", tmp_path / name)
    assert code == 2
    assert "data must be a file that can be read" in captured.err


def test_the_command_line_suggests_a_filter_that_it_can_run(capsys, tmp_path):
    file = tmp_path / "log.csv"
    file.write_bytes(table(TIMES, SEEN))
    code, captured = run(capsys, "suggest", "--data", file, "--json")
    assert code == 0
    found = json.loads(captured.out)
    assert found["experiment"]["design"] == "steady-kalman"
    assert set(found["orders"]) == {"2", "3", "4"}
    assert found["experiment"]["noise_std"] == found["orders"][str(found["experiment"]["order"])]["sensor_std"]
    again = tmp_path / "experiment.json"
    again.write_text(json.dumps(found["experiment"]), encoding="utf-8")
    code, captured = run(capsys, "run", "--experiment", again, "--json")
    assert json.loads(captured.out)["gains"] == found["gains"]
    code, captured = run(capsys, "suggest", "--data", file)
    flags = captured.out.strip().splitlines()[-1].removeprefix("As flags: ").split()
    code, captured = run(capsys, "run", "--data", file, *flags, "--json")
    assert json.loads(captured.out)["gains"] == found["gains"]


def test_the_command_line_tells_what_was_found(capsys, tmp_path):
    file = tmp_path / "log.csv"
    rows = table(TIMES, SEEN).decode().splitlines()
    file.write_text("\n".join([*rows, rows[5], "soon,1,2"]), encoding="utf-8")
    _, captured = run(capsys, "run", "--data", file, "--xi", "0.6", "--json")
    summary = json.loads(captured.out)
    assert (summary["found"]["duplicate"], summary["found"]["time"], summary["found"]["empty"]) == (1, 1, 1)
    assert summary["evidence"]["innovation_rmse"] > 0
    _, captured = run(capsys, "run", "--data", file, "--xi", "0.6")
    assert "1 x same time twice" in captured.out
    assert "Innovation RMSE" in captured.out


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_what_goes_out_of_a_scenario_comes_in_again(scenario):
    """The exported run of any target, loaded as a file, gives the same track and the same errors."""
    out = run_experiment(Experiment.from_dict({"scenario": scenario, "start": "first", "order": 3, "xi": 0.6}))
    stream = io.StringIO()
    write_track(out, stream)
    data = kept(stream.getvalue().encode(), f"{scenario}.csv")
    back = run_experiment(Experiment.from_dict({"data": data, "start": "first", "order": 3, "xi": 0.6}))
    assert len(back.scenario.axes) == len(out.scenario.axes)
    assert back.measurements.interval == pytest.approx(out.experiment.interval, rel=1e-12)
    size = np.abs(out.measurements.positions).max()
    np.testing.assert_allclose(back.track.smoothed, out.track.smoothed, rtol=1e-9, atol=1e-9 * size)
    for name in ("tracking_rmse", "estimation_rmse", "estimation_max", "innovation_total"):
        assert getattr(back.metrics, name) == pytest.approx(getattr(out.metrics, name), rel=1e-9)


@pytest.mark.parametrize("gate", [None, 20.0])
def test_innovations_at_varying_intervals_are_measured_by_their_own_variance(gate):
    """On the model itself, with intervals from 0.5 to 3 s, NIS is the number of axes; by the steady one it is not."""
    draw = np.random.default_rng(11)
    steps = draw.choice([0.5, 1.0, 1.0, 3.0], size=6000)
    times = np.concatenate(([0.0], np.cumsum(steps)))
    speed = np.cumsum(draw.normal(0, 0.3, (6001, 2)) * np.sqrt(np.concatenate(([1.0], steps)))[:, None], axis=0)
    mean = np.concatenate((np.zeros((1, 2)), (speed[1:] + speed[:-1]) / 2 * steps[:, None]))
    seen = np.cumsum(mean, axis=0) + draw.normal(0, 2, (6001, 2))
    data = kept(table(times, seen))
    values = {"data": data, "design": "steady-kalman", "order": 2, "tracking_index": 0.15, "noise_std": 2}
    result = run_experiment(Experiment.from_dict(values | ({} if gate is None else {"gate": gate})))
    assert result.measurements.interval is None
    assert result.evidence().nis.mean == pytest.approx(2, rel=0.05)
    steady = examine(result.track, result.measurements, result.gains, sensor_std=(2.0,), tracking_index=0.15)
    assert steady.nis.mean > 2.3


@pytest.mark.parametrize("share", [0.05, 0.3])
def test_missing_measurements_do_not_condemn_a_right_filter(pushed_target, share):
    """At a constant interval too: after a gap an innovation is larger than after none."""
    values = {"design": "steady-kalman", "order": 2, "tracking_index": 0.3, "noise_std": 2}
    means, held = [], 0
    for seed in range(20):
        draw = np.random.default_rng(seed)
        seen = pushed_target(2, np.ones(1000), 0.3, 2.0, draw, axes=2)
        seen[draw.random(1000) < share] = np.nan
        result = run_experiment(Experiment.from_dict(values | {"data": kept(table(np.arange(1000.0), seen))}))
        assert result.measurements.interval == 1
        nis = result.evidence().nis
        means.append(nis.mean)
        held += nis.holds
    assert np.mean(means) == pytest.approx(2, rel=0.02)
    # 95 % of them; 15 and fewer of 20 come once in four thousand times.
    assert held >= 16


@pytest.mark.parametrize("gate", [2.5, 3.0, 4.0])
def test_what_a_narrow_gate_refuses_of_right_measurements_is_allowed_for(pushed_target, gate):
    values = {"design": "steady-kalman", "order": 2, "tracking_index": 0.3, "noise_std": 2, "gate": gate}
    means, held = [], 0
    for seed in range(20):
        seen = pushed_target(2, np.ones(2000), 0.3, 2.0, np.random.default_rng(seed), axes=2)
        result = run_experiment(Experiment.from_dict(values | {"data": kept(table(np.arange(2000.0), seen))}))
        nis = result.evidence().nis
        means.append(nis.mean)
        held += nis.holds
    # What is refused is bridged, after which the right measurement is further from the prediction than those before.
    assert 2 * believed_share(gate, 2) - 0.01 < np.mean(means) < 2.01
    assert held >= 16


def test_the_variance_of_innovations_knows_how_wrong_a_start_is():
    """A smooth filter takes a fast target for one at rest, and there are too few samples to leave that out."""
    draw = np.random.default_rng(0)
    times = np.cumsum(draw.uniform(0.5, 1.5, 60))
    data = kept(table(times, (100 * times + draw.normal(0, 2, 60))[:, None], head="t,x"))
    values = {"data": data, "order": 2, "xi": 0.9, "start": "first", "noise_std": 2}
    result = run_experiment(Experiment.from_dict(values))
    assert result.measurements.interval is None
    assert np.abs(result.track.innovation[12:20]).max() > 100
    assert result.evidence().nis.mean < 2


def test_a_suggested_filter_starts_with_all_it_knows(constant):
    experiment = Experiment.from_dict({"data": constant, "convention": "taylor", "start": "first"})
    better = suited(experiment, suggest(observe(experiment)[1], interval=0.5))
    assert (better.start, better.convention, better.data) == ("expanding", "taylor", constant)


def test_what_is_wrong_with_a_file_is_said_once():
    with pytest.raises(InputError) as caught:
        Experiment.from_dict({"data": kept(b"t,x,y\n0,1,2\n")})
    assert str(caught.value).count("got") == 1
    assert "rows must hold at least" in caught.value.rule
