"""The same studies on one thread, on four, and on a Dask cluster: the same bits. What a cluster may do wrong."""

import pickle
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import distributed
import numpy as np
import pytest
import yaml

from tracker_core import Experiment, InputError
from tracker_core.measured import SHELF, File
from tracker_core.tuning import Map, MonteCarlo, Search, Sweep, base, evaluate, monte_carlo
from tracker_core.tuning.cluster import Cluster
from tracker_core.tuning.executors import ordered

ROOT = Path(__file__).parents[2]
EXPERIMENT = Experiment.from_dict({"samples": 60, "order": 2, "xi": 0.6, "seed": 3})
TIMES = np.cumsum(np.random.default_rng(5).uniform(0.5, 2, 70))
ROWS = zip(TIMES.tolist(), (30 * np.sin(TIMES / 9) + np.random.default_rng(6).normal(0, 1, 70)).tolist(), strict=True)
# No worker has this file, or ever reads it from anywhere but the parts.
FILE = File("boat.csv", ("t,x\n" + "\n".join(f"{time!r},{place!r}" for time, place in ROWS)).encode())
RECORDING = Experiment.from_dict({"data": SHELF.keep(FILE), "order": 2, "xi": 0.6, "gate": 4})
STUDIES = {
    "recording": Search(RECORDING, "innovation_rmse", budget=2_000),
    "sweep": Sweep(EXPERIMENT, "xi", tuple(np.linspace(0.1, 0.9, 30)), "estimation_rmse", 12, beside=("tracking_max",)),
    "map": Map(EXPERIMENT, ("alpha", "beta"), "innovation_total", 20, 15, runs=6),
    "comparison": MonteCarlo((EXPERIMENT, replace(EXPERIMENT, xi=0.7), replace(EXPERIMENT, order=3)), 400),
    "search": Search(replace(EXPERIMENT, samples=10), "estimation_rmse", 2, budget=2_000),
    "random target": Sweep(
        Experiment.from_dict({"scenario": "singer", "samples": 40, "order": 2, "xi": 0.6, "start": "known"}),
        "alpha", (0.2, 0.5, 0.8), "tracking_rmse", 100,
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def cluster():
    """A scheduler and two workers, each a process of its own."""
    # No port that somebody else may have.
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", host="127.0.0.1"
    ) as running:
        yield running


@pytest.fixture
def small_parts(monkeypatch):
    """Studies of many parts, so that there is something to be computed out of order."""
    for module in (base, evaluate, monte_carlo):
        monkeypatch.setattr(module, "BLOCK_STEPS", 4_000)


def bits(value):
    """Everything that a value is made of, as bytes."""
    if isinstance(value, np.ndarray):
        return value.tobytes()
    if is_dataclass(value):
        return tuple(bits(getattr(value, field.name)) for field in fields(value))
    if isinstance(value, tuple):
        return tuple(bits(item) for item in value)
    return pickle.dumps(value)


def run(study, executor):
    """What the study comes to, and in how many steps."""
    progress = [(stage.done, stage.of, bits(stage.outcome)) for stage in study.stream(executor)]
    return progress[-1], len(progress)


@pytest.mark.usefixtures("small_parts")
@pytest.mark.parametrize("name", STUDIES)
def test_the_same_study_gives_the_same_bits_everywhere(name, cluster):
    study = STUDIES[name]
    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(4) as four, distributed.Client(cluster) as client:
        alone, steps = run(study, one)
        assert steps > 2
        assert run(study, four) == (alone, steps)
        assert run(study, client.get_executor()) == (alone, steps)
        own = Cluster(cluster.scheduler_address)
        assert run(study, own) == (alone, steps)
        own.shutdown()


def test_what_is_closed_leaves_nothing_waiting_on_the_cluster(cluster):
    own = Cluster(cluster.scheduler_address)
    parts = ordered(own, time.sleep, [1.0] * 200)
    next(parts)
    with distributed.Client(cluster) as client:

        def waiting():
            return client.run_on_scheduler(lambda dask_scheduler: len(dask_scheduler.tasks))

        assert waiting() > 10
        parts.close()
        # What is under way on the two workers ends by itself; the others would take a quarter of a minute.
        for _ in range(50):
            if waiting() <= 2:
                break
            time.sleep(0.1)
        assert waiting() <= 2
    own.shutdown()


def test_parts_of_two_studies_are_cancelled_each_for_itself(cluster):
    own = Cluster(cluster.scheduler_address)
    first, second = own.submit(pow, 7, 3), own.submit(pow, 7, 3)
    first.cancel()
    assert second.result(timeout=20) == 343
    own.shutdown()


def test_a_cluster_that_was_lost_is_looked_for_again():
    settings = {
        "n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": ":0", "protocol": "tcp://",
    }  # fmt: skip
    with distributed.LocalCluster(**settings) as lost:
        own = Cluster(lost.scheduler_address)
        assert own.submit(pow, 2, 5).result(timeout=20) == 32
        own._client.close()
        assert own.submit(pow, 2, 6).result(timeout=20) == 64
        own.shutdown()


def test_scheduler_and_worker_of_the_compose_file_do_the_work(tmp_path):
    """Without the container: the commands as they stand there, but for the port."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])
    services = yaml.safe_load((ROOT / "compose.yaml").read_text(encoding="utf-8"))["services"]
    held = yaml.safe_load((ROOT / "deploy" / "contained.yaml").read_text(encoding="utf-8"))["services"]["server"]
    assert held["environment"]["GAINSCOPE_DASK_SCHEDULER"] == "${GAINSCOPE_DASK_SCHEDULER:-}"
    running = []
    try:
        for service in ("scheduler", "worker"):
            changes = {
                "python": sys.executable, "8786": port, "tcp://scheduler:8786": f"tcp://127.0.0.1:{port}",
                "/tmp/dask": str(tmp_path),
            }  # fmt: skip
            command = [changes.get(word, word) for word in services[service]["command"]]
            running.append(subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL))
        own = Cluster(f"tcp://127.0.0.1:{port}", patience=30)
        *_, last = STUDIES["comparison"].stream(own)
        own.shutdown()
    finally:
        for process in running:
            process.terminate()
            process.wait(timeout=30)
    *_, alone = STUDIES["comparison"].stream()
    assert bits(last) == bits(alone)


# Out of reach ------------------------------------------------------------------------------------------------------


def stranger(answer):
    """The address of somebody who listens and answers that to whatever is said; None says nothing."""
    listening = socket.create_server(("127.0.0.1", 0))

    def serve():
        try:
            while True:
                connection, _ = listening.accept()
                if answer is not None:
                    connection.recv(1000)
                    connection.sendall(answer)
                    connection.close()
        except OSError:
            return

    threading.Thread(target=serve, daemon=True).start()
    return listening, f"tcp://127.0.0.1:{listening.getsockname()[1]}"


@pytest.mark.parametrize("address", ["nonsense", "tcp://127.0.0.1", "http://127.0.0.1:80", "tcp://127.0.0.1:1"])
def test_an_address_without_a_scheduler_is_refused(address):
    with pytest.raises(InputError, match=r"^scheduler must be the address of a Dask scheduler that answers within 1 s"):
        Cluster(address, patience=1)


@pytest.mark.filterwarnings("ignore:unclosed:ResourceWarning")
@pytest.mark.parametrize("answer", [None, b"HTTP/1.1 400 Bad Request\r\n\r\n"])
def test_somebody_else_at_the_address_is_refused(answer):
    listening, address = stranger(answer)
    with listening, pytest.raises(InputError, match="must be the address of a Dask scheduler"):
        Cluster(address, patience=1)


def test_dask_is_loaded_only_where_it_is_used():
    code = "import app, sys; print('distributed' in sys.modules, 'cmaes' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, encoding="utf-8", check=True)
    assert done.stdout.split() == ["False", "False"]
