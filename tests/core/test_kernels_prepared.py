"""Kernels compiled before anybody needs them: which, where they are kept, and what happens where something dies."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from numba import typeof

from tracker_core import (
    DESIGNS,
    SCENARIOS,
    Experiment,
    InputError,
    Measurements,
    Truth,
    kernels,
    run_experiment,
    step_figures,
)
from tracker_core.__main__ import main
from tracker_core.adaptive import METHODS
from tracker_core.batch import batch_errors, errors_of_runs
from tracker_core.kernels import loading, preparing, target
from tracker_core.kernels.preparing import Compiled, Preparation
from tracker_core.kernels.signatures import FIRST, LATER, SIGNATURES
from tracker_core.run import observe, observe_runs
from tracker_core.starts import STARTS
from tracker_core.suggestion import suggest

ROOT = Path(__file__).parents[2]
NATIVE = target.named("native")
SMALL = {"transposed": SIGNATURES["transposed"], "autoregress": SIGNATURES["autoregress"]}
EXAMPLE = (np.arange(24.0).reshape(2, 4, 3), np.arange(64) % 2, np.empty((4, 3, 64)), np.zeros(4, bool))


def everything():
    """Whatever calls a kernel."""
    for order in (2, 3, 4):
        for start in STARTS.values():
            if order >= start.least_order:
                run_experiment(Experiment.from_dict({"order": order, "xi": 0.8, "start": start.name, "samples": 20}))
        run_experiment(Experiment.from_dict({"order": order, "xi": 0.8, "samples": 20, "gate": 4}))
    for scenario in SCENARIOS:
        values = {"scenario": scenario, "order": 3, "design": "fading-memory", "xi": 0.8}
        run_experiment(Experiment.from_dict({**values, "samples": 10}))
        run_experiment(Experiment.from_dict({**values, "samples": 10, "noise": "coloured", "noise_correlation": 0.5}))
    small = {"grid": 3, "grid_eta": 3, "members": 3, "window": 6, "samples": 40, "scenario": "yu-wu"}
    # Where a design and a method share a name, the design is meant.
    for name, method in ((name, METHODS[name]) for name in METHODS.keys() - DESIGNS.keys()):
        for order in method.orders:
            taken = {key: value for key, value in small.items() if key in (*method.parameters, "samples", "scenario")}
            run_experiment(Experiment.from_dict({**taken, "design": name, "order": order}))
    for parabola in ("printed", "none"):
        values = {"scenario": "yu-wu", "design": "sample-search", "order": 3, "grid": 3, "parabola": parabola}
        run_experiment(Experiment.from_dict({**values, "samples": 20}))
    suggest(observe(Experiment.from_dict({"samples": 30, "xi": 0.8}))[1])
    filters = [DESIGNS["fading-memory"].gains(order, xi=0.8) for order in (2, 3, 4)]
    for scenario, runs in (("jeong-ship", 1), ("jeong-ship", 100), ("singer", 100)):
        drawn = Experiment.from_dict({"scenario": scenario, "samples": 20, "order": 2, "xi": 0.8})
        errors_of_runs(observe_runs(drawn, range(runs)), filters)
    uneven = np.cumsum(np.linspace(0.5, 1.5, 20))
    truth = Truth(uneven, np.zeros((20, 1, 5)))
    batch_errors(Measurements(uneven, np.sin(uneven)[:, None], None), truth, np.array([[0.5, 0.2], [0.6, 0.3]]))
    step_figures(filters[0])


def test_kernels_are_called_as_they_have_been_compiled_and_no_other_way(monkeypatch):
    """Any other type of an argument would be compiled in the server, while somebody waits."""
    called = {name: set() for name in SIGNATURES}

    def noting(name, kernel):
        def call(*arguments):
            called[name].add(tuple(map(typeof, arguments)))
            return kernel(*arguments)

        return call

    for name in SIGNATURES:
        monkeypatch.setattr(kernels, name, noting(name, getattr(kernels, name)))
    everything()
    known = {name: set(signatures) for name, signatures in SIGNATURES.items()}
    assert {name: types - known[name] for name, types in called.items() if types - known[name]} == {}
    assert {name: types - called[name] for name, types in known.items() if types - called[name]} == {}


def test_every_kernel_is_known():
    assert SIGNATURES == FIRST | LATER
    assert SIGNATURES.keys() == set(kernels.__all__) - {"LANES"}


# Compiling elsewhere -----------------------------------------------------------------------------------------------


@pytest.fixture
def few(monkeypatch):
    """Two kernels that are compiled quickly stand for all."""
    monkeypatch.setattr(preparing, "SIGNATURES", SMALL)
    monkeypatch.setattr(target, "SIGNATURES", SMALL)


LOADED = """
import json, sys
from tracker_core import kernels
from tracker_core.kernels.child import make
found = {}
for name in sys.argv[1:]:
    make(getattr(kernels, name), name)
    stats = getattr(kernels, name).stats
    found[name] = [sum(stats.cache_hits.values()), sum(stats.cache_misses.values())]
print(json.dumps(found))
"""


def loaded_from(root, *names):
    """What another process finds there: kernels loaded, and compiled, by name."""
    done = subprocess.run(
        [sys.executable, "-c", LOADED, *names], cwd=ROOT, env=os.environ | {"NUMBA_CACHE_DIR": str(root)},
        capture_output=True, encoding="utf-8", check=True,
    )  # fmt: skip
    return json.loads(done.stdout)


def test_what_others_compile_is_loaded_and_never_compiled_again(few, tmp_path):
    done = []
    first = Preparation(NATIVE, tmp_path, done.append)
    assert first.missing == list(SMALL)
    first.run()
    assert first.missing == []
    assert {one.kernel for one in done} == SMALL.keys()
    assert all(one.seconds > 0 and one.signatures == 1 for one in done)
    assert NATIVE.complete(tmp_path)
    assert loaded_from(tmp_path, *SMALL) == {name: [1, 0] for name in SMALL}
    done.clear()
    Preparation(NATIVE, tmp_path, done.append).run()
    assert done == [Compiled(name, 1, None) for name in SMALL]


def test_a_compiler_that_fails_leaves_the_rest_to_the_others(few, monkeypatch, tmp_path):
    real, failed = preparing._ask, threading.Lock()

    def ask(process, name):
        if failed.acquire(blocking=False):
            process.kill()
            process.wait()
        return real(process, name)

    monkeypatch.setattr(preparing, "_ask", ask)
    preparation = Preparation(NATIVE, tmp_path)
    preparation.run()
    assert len(preparation.missing) == 1


def test_stopped_it_ends_its_processes_and_begins_no_more(few, monkeypatch, tmp_path):
    preparation, begun = Preparation(NATIVE, tmp_path), threading.Event()
    real = preparing._ask
    # The longest of all, of which nobody waits for the end.
    monkeypatch.setattr(preparing, "_ask", lambda process, _: begun.set() or real(process, "lane_errors"))
    running = threading.Thread(target=preparation.run)
    running.start()
    assert begun.wait(60)
    preparation.stop()
    running.join(60)
    assert not running.is_alive()
    assert all(process.poll() is not None for process in preparation._processes)
    preparation.run()
    assert preparation.missing == list(SMALL)


ORPHANING = """
import sys, threading
from pathlib import Path
from tracker_core.kernels import preparing, target
preparing.SIGNATURES = {"lane_errors": ()}
preparation = preparing.Preparation(target.named("native"), Path(sys.argv[1]))
threading.Thread(target=preparation.run).start()
while not preparation._processes: pass
print(preparation._processes[0].pid, preparation._processes[0].args[-1], flush=True)
"""


def test_no_compiler_outlives_whoever_wanted_it(tmp_path):
    """Not even where that was killed, in the midst of it: neither the process nor its folder is left."""
    parent = subprocess.Popen(
        [sys.executable, "-c", ORPHANING, str(tmp_path)], cwd=ROOT, stdout=subprocess.PIPE, encoding="utf-8"
    )
    child, folder = parent.stdout.readline().split()
    while not list(Path(folder).iterdir()):
        time.sleep(0.05)
    parent.send_signal(signal.SIGKILL)
    parent.communicate()
    for _ in range(600):
        if not running(int(child)) and not Path(folder).exists():
            break
        time.sleep(0.1)
    assert not running(int(child))
    assert not Path(folder).exists()


def running(process):
    with contextlib.suppress(OSError):
        return Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    return False


# Where they are kept -----------------------------------------------------------------------------------------------


def fill(folder, content=b"machine code"):
    """A folder as numba leaves it, complete."""
    (folder / "kernels_0").mkdir(parents=True)
    for name in SIGNATURES:
        (folder / "kernels_0" / f"module.{name}-1.py.1.nbc").write_bytes(content)
        (folder / "kernels_0" / f"module.{name}-1.py.nbi").write_bytes(content)
        target.stamp(folder, name).touch()


def files(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_what_is_not_whole_is_never_seen(monkeypatch, tmp_path):
    """However far copying comes: no file is there in part, none before what it refers to."""
    fill(tmp_path / "from")
    (tmp_path / "from" / "kernels_0" / "module.track-1.py.nbi").chmod(0o644)
    whole, replaced = files(tmp_path / "from"), Path.replace
    for fails_at in (0, 1, len(SIGNATURES), 2 * len(SIGNATURES), 3 * len(SIGNATURES) - 1):
        moves = iter(range(fails_at))

        def failing(self, place, moves=moves):
            if next(moves, None) is None:
                raise KeyboardInterrupt
            return replaced(self, place)

        into = tmp_path / f"into-{fails_at}"
        with monkeypatch.context() as patch:
            patch.setattr(Path, "replace", failing)
            with pytest.raises(KeyboardInterrupt):
                target.publish(tmp_path / "from", into)
        seen = {name: content for name, content in files(into).items() if ".coming-" not in name}
        assert len(seen) == fails_at
        assert seen.items() <= whole.items()
        for name in SIGNATURES:
            there = [
                any(f"{name}{end}" in found for found in seen) for end in (".compiled", "-1.py.nbi", "-1.py.1.nbc")
            ]
            assert there == sorted(there)
        target.publish(tmp_path / "from", into)
        assert {name: c for name, c in files(into).items() if ".coming-" not in name} == whole
        assert (into / "kernels_0" / "module.track-1.py.nbi").stat().st_mode & 0o777 == 0o644


@pytest.fixture
def shipped(monkeypatch, tmp_path):
    """An image's own folder, and a machine that can do everything."""
    monkeypatch.setattr(target, "OWN", tmp_path / "own")
    monkeypatch.setattr(target, "X86", True)
    able = {"value": dict.fromkeys({feature for needed in target.LEVELS.values() for feature in needed}, True)}
    monkeypatch.setattr(target.binding, "get_host_cpu_features", lambda: Features(able["value"]))
    return able


class Features(dict):
    def flatten(self):
        return ",".join(f"+{name}" for name in sorted(self))


def test_the_best_level_is_taken_that_an_image_brings_and_the_machine_has(shipped, tmp_path):
    root = tmp_path / "cache"
    assert target.chosen(root, None, None).name == "native"
    for name in ("x86-64-v3", "x86-64-v4"):
        level = target.named(name)
        fill(level.folder(tmp_path / "own"))
        assert target.chosen(root, None, None) == level
        assert files(level.folder(root)) == files(level.folder(tmp_path / "own"))
    shipped["value"]["avx512f"] = False
    assert target.chosen(root, None, None).name == "x86-64-v3"
    shipped["value"]["fma"] = False
    native = target.chosen(root, None, None)
    assert native.name == "native"
    shipped["value"]["fma"] = True
    fill(target.named("native").folder(root))
    assert target.chosen(root, None, None).name == "native"


def test_what_is_not_complete_is_not_taken(shipped, tmp_path):
    folder = target.named("x86-64-v3").folder(tmp_path / "own")
    fill(folder)
    target.stamp(folder, "track").unlink()
    assert target.chosen(tmp_path / "cache", None, None).name == "native"
    assert not (tmp_path / "cache").exists()


def test_where_nothing_can_be_kept_the_machine_s_own_is_taken(shipped, tmp_path):
    fill(target.named("x86-64-v3").folder(tmp_path / "own"))
    (tmp_path / "file").touch()
    assert target.chosen(tmp_path / "file", None, None).name == "native"


def test_another_kind_of_machine_has_no_levels(shipped, monkeypatch, tmp_path):
    fill(target.named("x86-64-v3").folder(tmp_path / "own"))
    monkeypatch.setattr(target, "X86", False)
    assert target.chosen(tmp_path / "cache", None, None).name == "native"
    with pytest.raises(InputError, match="level must be one of native, got 'x86-64-v3'"):
        target.named("x86-64-v3")


def test_what_numba_is_told_comes_first(shipped, tmp_path):
    fill(target.named("x86-64-v4").folder(tmp_path / "own"))
    assert target.chosen(tmp_path, "skylake", "+avx2") == target.Target("skylake", "skylake", "+avx2")
    assert target.chosen(tmp_path, "skylake", None).cpu == "skylake"


def test_every_target_has_a_folder_of_its_own_and_every_source(monkeypatch, tmp_path):
    folders = {replace(NATIVE, **change).folder(tmp_path) for change in ({}, {"cpu": "other"}, {"features": "+other"})}
    monkeypatch.setattr(target.numba, "__version__", "0")
    folders.add(NATIVE.folder(tmp_path))
    (tmp_path / "kernel.py").write_text("changed", encoding="utf-8")
    monkeypatch.setattr(target, "HERE", tmp_path)
    folders.add(NATIVE.folder(tmp_path))
    assert len(folders) == 5


BITS = """
import sys
import numpy as np
from tracker_core.kernels.compiled import TARGET, compiled
from tracker_core.kernels.steps import LANES, ROWS_OF_AXIS, step4

@compiled
def run(z, states):
    for i in range(z.shape[0]):
        step4(z, i, z, i, 1, 0, 0.37, True, states)

random = np.random.default_rng(1)
z, states = random.normal(size=(200, 1)), random.normal(size=(1, ROWS_OF_AXIS, LANES)) * 0.1
run(z, states)
print(TARGET.name, states.tobytes().hex())
"""


def test_results_have_the_same_bits_on_every_processor(tmp_path):
    able = target.binding.get_host_cpu_features()
    levels = [name for name, needed in target.LEVELS.items() if all(able.get(one, False) for one in needed)]
    if not target.X86:
        pytest.skip("there are no levels of this kind of machine")
    script, found = tmp_path / "bits.py", {}
    script.write_text(BITS, encoding="utf-8")
    # Without fused instructions, a b + c with one rounding is computed by other means.
    for name, variables in {
        "native": {},
        "nehalem": {"NUMBA_CPU_NAME": "nehalem", "NUMBA_CPU_FEATURES": ""},
        **{name: target.named(name).variables for name in levels},
    }.items():
        environment = os.environ | variables | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
        done = subprocess.run(
            [sys.executable, str(script)], env=environment, capture_output=True, encoding="utf-8", check=True
        )
        said, found[name] = done.stdout.split()
        assert said == name
    assert len(found["native"]) > 1000
    assert set(found.values()) == {found["native"]}


# Loading -----------------------------------------------------------------------------------------------------------


class Slowly:
    """A preparation in which every kernel comes when it is told to; one of those that not all need is compiled."""

    missing: ClassVar = [name for name in SIGNATURES if name != "profile"]

    def __init__(self, target, root, done):
        self.done, self.stopped = done, threading.Event()

    def run(self):
        self.stopped.wait(60)

    def stop(self):
        self.stopped.set()


@pytest.fixture
def slowly(monkeypatch):
    monkeypatch.setattr(loading, "Preparation", Slowly)
    ready = []
    begun = loading.Loading(lambda: ready.append(True))
    before = {name: getattr(kernels, name) for name in SIGNATURES}
    thread = threading.Thread(target=begun.run)
    thread.start()
    while kernels.transposed is before["transposed"] or kernels.weight_costs is before["weight_costs"]:
        time.sleep(0.01)
    yield begun, ready, before
    begun.stop()
    thread.join(60)
    assert {name: getattr(kernels, name) for name in SIGNATURES} == before


def test_whoever_calls_a_kernel_too_early_waits_for_it_and_for_no_other(slowly):
    begun, _, before = slowly
    found = []
    calling = threading.Thread(target=lambda: found.append(kernels.transposed(*EXAMPLE)))
    calling.start()
    calling.join(0.2)
    assert calling.is_alive()
    begun.preparation.done(Compiled("autoregress", 1, 1.0))
    assert kernels.autoregress is before["autoregress"]
    calling.join(0.1)
    assert calling.is_alive()
    begun.preparation.done(Compiled("transposed", 1, 1.0))
    calling.join(60)
    assert found == [None]
    assert (EXAMPLE[2][:, :, 1] == EXAMPLE[0][1]).all()


NEEDED = [*FIRST, "profile"]


@pytest.mark.parametrize("last", NEEDED)
def test_it_is_ready_once_all_is_there_that_every_page_needs_or_that_was_compiled_before(slowly, monkeypatch, last):
    begun, ready, _ = slowly
    monkeypatch.setattr(loading, "make", lambda kernel, name: None)
    for name in NEEDED:
        if name != last:
            begun.preparation.done(Compiled(name, 1, None))
    assert ready == []
    begun.preparation.done(Compiled(last, 1, None))
    assert ready == [True]
    # What is still missing is waited for where nobody is held up.
    assert loading.held()
    for name in [name for name in LATER if name not in NEEDED]:
        begun.preparation.done(Compiled(name, 1, 1.0))
    assert ready == [True]
    assert not loading.held()


def test_once_it_is_told_to_end_nobody_waits_and_it_is_never_ready(slowly):
    begun, ready, _ = slowly
    begun.stop()
    kernels.transposed(*EXAMPLE)
    assert ready == []


class Nothing:
    """A preparation whose compilers all fail."""

    missing: ClassVar = [*SIGNATURES]

    def __init__(self, target, root, done):
        pass

    def run(self):
        pass


class Kernel:
    """A kernel of the test's own.

    Attributes:
        compiled: for which types, in turn.
        wrong: what compiling it raises, once it has been done.
    """

    def __init__(self, *wrong):
        self.compiled, self.wrong = [], list(wrong)

    def compile(self, types):
        self.compiled.append(types)
        if self.wrong:
            raise self.wrong.pop()

    def __call__(self):
        return len(self.compiled)


@pytest.fixture
def load(monkeypatch):
    """Load a few kernels which nobody else can compile; whether all was ready, and how often."""
    monkeypatch.setattr(loading, "Preparation", Nothing)

    def run(**few):
        signatures = {name: SIGNATURES[name] for name in few}
        monkeypatch.setattr(loading, "SIGNATURES", signatures)
        monkeypatch.setattr(loading, "FIRST", {name: signatures[name] for name in few if name in FIRST})
        for name, kernel in few.items():
            monkeypatch.setattr(kernels, name, kernel)
        ready = []
        loading.Loading(lambda: ready.append([kernel.compiled != [] for kernel in few.values()])).run()
        return ready

    return run


def test_what_no_other_process_compiles_is_compiled_here_before_it_is_ready(load, caplog):
    track, lanes = Kernel(), Kernel()
    assert load(track=track, lane_errors=lanes) == [[True, False]]
    for name, kernel in (("track", track), ("lane_errors", lanes)):
        assert set(kernel.compiled) == set(SIGNATURES[name])
        assert getattr(kernels, name) is kernel
    assert not loading.held()
    assert [record.kernel for record in caplog.records] == ["track", "lane_errors"]


def test_what_merely_cannot_be_kept_is_compiled_all_the_same(load):
    lanes = Kernel(*[OSError(28, "No space left on device")] * 3)
    assert load(track=Kernel(OSError(28, "No space left on device")), lane_errors=lanes)
    assert set(lanes.compiled) == set(SIGNATURES["lane_errors"])
    assert not loading.held()


def test_with_one_that_cannot_be_compiled_it_is_not_ready_and_who_calls_it_does_so_in_a_thread(load, caplog):
    broken = Kernel(ValueError("no such instruction"))
    assert load(track=broken, autoregress=Kernel()) == []
    # Nobody waits for ever.
    assert kernels.track() == 1
    assert loading.held()
    assert "A kernel cannot be compiled" in caplog.messages


# The command -------------------------------------------------------------------------------------------------------


def test_the_command_says_what_it_did(few, monkeypatch, tmp_path, capsys):
    from tracker_core.kernels import compiled

    monkeypatch.setattr(compiled, "ROOT", tmp_path)
    assert main(["compile"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert sorted(line.split()[0] for line in out[:-1]) == sorted(SMALL)
    assert out[-1] == f"For {NATIVE.cpu} in {NATIVE.folder(tmp_path)}"
    assert main(["compile", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "cpu": NATIVE.cpu,
        "folder": str(NATIVE.folder(tmp_path)),
        "kernels": dict.fromkeys(SMALL),
    }


def test_a_level_that_is_none_is_refused(capsys):
    assert main(["compile", "--level", "x86-64-v9"]) == 2
    assert "level must be one of native" in capsys.readouterr().err


def test_the_command_fails_where_a_compiler_does(few, monkeypatch, tmp_path, capsys):
    from tracker_core.kernels import compiled

    monkeypatch.setattr(compiled, "ROOT", tmp_path)
    monkeypatch.setattr(preparing, "_ask", lambda process, name: None)
    assert main(["compile"]) == 2
    assert "must be one that transposed, autoregress can be compiled for" in capsys.readouterr().err
