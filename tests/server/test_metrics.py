"""Figures of the server's own work: who sees them, and that their labels take few values."""

import math
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from fastapi import FastAPI
from fastapi.staticfiles import StaticFiles
from hypothesis import given
from hypothesis import strategies as st
from prometheus_client.parser import text_string_to_metric_families

from server import guard, metrics
from server.clients import FORWARDED
from server.settings import Settings

SETTINGS = Settings(requests_per_second=1e6, requests_at_once=1_000_000)
HERE = ("127.0.0.1", 5)


def made(settings=SETTINGS, folder=None):
    server = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    @server.get("/thing/{name}")
    async def thing(name: str):
        return {}

    if folder:
        server.mount("/folder", StaticFiles(directory=folder))
    metrics.attach(server, settings.metrics_token)
    guard.attach(server, settings)
    return server


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    folder = tmp_path_factory.mktemp("folder")
    (folder / "file.txt").write_text("text")
    return made(folder=folder)


def figures(body):
    """Value by name and labels."""
    families = text_string_to_metric_families(body.decode())
    return {
        (sample.name, *sorted(sample.labels.items())): sample.value for family in families for sample in family.samples
    }


@pytest.mark.parametrize("client", [HERE, ("::1", 5), ("::ffff:127.0.0.1", 5)])
def test_this_machine_sees_them(app, ask, client):
    answer = ask(app, path="/metrics", client=client)
    assert answer.status == 200
    found = figures(answer.body)
    assert found["process_resident_memory_bytes",] > 1e6
    assert found["process_open_fds",] > 0
    assert answer.headers["content-type"].startswith("text/plain")


@pytest.mark.parametrize("name", FORWARDED)
def test_nobody_else_does(app, ask, name):
    assert ask(app, path="/metrics").status == 404
    assert ask(app, path="/metrics", client=None).status == 404
    assert ask(app, path="/metrics", client=HERE, headers={name.decode(): "127.0.0.1"}).status == 404
    # Not even where a proxy that is trusted passes on that it is this machine.
    trusting = made(replace(SETTINGS, proxies="192.0.2.7"))
    assert ask(trusting, path="/metrics", headers={"x-forwarded-for": "127.0.0.1"}).status == 404


@pytest.mark.parametrize(
    ("said", "status"),
    [
        ("Bearer a secret", 200),
        ("Bearer a secre", 401),
        ("Bearer a secret ", 401),
        ("Bearer Ä", 401),
        ("a secret", 401),
        ("", 401),
        (None, 401),
    ],
)
def test_who_has_the_token_sees_them_from_anywhere(ask, said, status):
    app = made(replace(SETTINGS, metrics_token="a secret"))
    headers = {} if said is None else {"authorization": said}
    for client in (HERE, ("192.0.2.7", 5)):
        answer = ask(app, path="/metrics", headers=headers, client=client)
        assert answer.status == status
        assert status == 200 or answer.headers["www-authenticate"] == "Bearer"


def test_a_route_is_counted_by_its_template(app, ask):
    before = figures(ask(app, path="/metrics", client=HERE).body)
    for name in "abc":
        assert ask(app, path=f"/thing/{name}").status == 200
        assert ask(app, path=f"/{name}").status == 404
    assert ask(app, path="/folder/file.txt").status == 200
    assert ask(app, path="/folder/nothing.txt").status == 404
    after = figures(ask(app, path="/metrics", client=HERE).body)
    for route, status, count in [
        ("/thing/{name}", 200, 3), ("none", 404, 3), ("/folder", 200, 1), ("/folder", 404, 1),
    ]:  # fmt: skip
        key = ("gainscope_requests_total", ("method", "GET"), ("route", route), ("status", str(status)))
        assert after[key] - before.get(key, 0) == count
    key = ("gainscope_request_seconds_count", ("route", "/thing/{name}"))
    assert after[key] - before.get(key, 0) == 3


@given(
    st.text("/thingmecrsfold.%", max_size=30),
    st.text("GETPOSTBREW", min_size=1, max_size=10),
    st.sampled_from([None, "", "null", "http://elsewhere.test"]),
)
def test_nobody_adds_to_the_figures_by_asking(app, ask, path, method, origin):
    def counted():
        return [
            sample.labels
            for family in metrics.REGISTRY.collect()
            if family.name in ("gainscope_requests", "gainscope_request_seconds")
            for sample in family.samples
        ]

    # Other applications of this process count in the same figures.
    before = {label["route"] for label in counted()}
    headers = {} if origin is None else {"origin": origin}
    ask(app, method, f"/{path}", headers=headers)
    labels = counted()
    routes = {label["route"] for label in labels} - before
    known = {"none", "/metrics", "/thing/{name}", "/folder", "/body", "/own", "/number/{value}", "/broken", "/late"}
    assert routes <= known | {"/left", "/livez", "/teapot", "/_dash-update-component", "/"}
    methods = {label["method"] for label in labels if "method" in label}
    assert methods <= {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "other"}


def test_a_figure_that_is_watched_is_read_when_somebody_asks(app, ask, caplog):
    values = []
    metrics.watch("gainscope_tested", "Of this test.", lambda: 0)
    metrics.watch("gainscope_tested", "Of this test.", lambda: 6 / values[-1])

    def read(value):
        values.append(value)
        return figures(ask(app, path="/metrics", client=HERE).body)["gainscope_tested",]

    found = [read(value) for value in (3, 2, 0)]
    assert found[:2] == [2, 3]
    # The others are there whatever becomes of one of them.
    assert math.isnan(found[2])
    assert [record.exc_info[0] for record in caplog.records if record.exc_info] == [ZeroDivisionError]
    metrics.watch("gainscope_tested", "Of this test.", lambda: 0)


SPENDING = """
import time
held = bytearray(b"x") * 60_000_000
while time.process_time() < 0.1: pass
print(time.process_time(), flush=True)
input()
"""


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="the system does not say who is whose child")
def test_what_other_processes_take_is_there_while_they_run_and_what_they_took_stays():
    def read():
        names = ("gainscope_children_resident_memory_bytes", "gainscope_children_cpu_seconds_total")
        return [metrics.REGISTRY.get_sample_value(name) for name in names]

    memory, seconds = read()
    with subprocess.Popen([sys.executable, "-c", SPENDING], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        taken = float(process.stdout.readline()) - 0.02
        held, running = read()
        process.stdin.close()
    left, ended = read()
    assert held - memory > 6e7
    assert left < held - 6e7
    assert ended >= running >= seconds + taken


def test_computing_is_measured_in_any_thread():
    def read(name):
        return metrics.REGISTRY.get_sample_value(f"gainscope_computing_seconds_{name}", {"work": "tested"}) or 0

    @metrics.computing("tested")
    def compute():
        with metrics.computing("tested"):
            pass

    before = read("count")
    thread = threading.Thread(target=compute)
    thread.start()
    thread.join()
    assert read("count") == before + 2
    with pytest.raises(ZeroDivisionError), metrics.computing("tested"):
        raise ZeroDivisionError
    assert read("count") == before + 3
