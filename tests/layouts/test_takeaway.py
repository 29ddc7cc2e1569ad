"""Results out over HTTP: the same run as the page's, whole, in pieces, or refused with a reason."""

import asyncio
import contextlib
import csv
import io
import json
import subprocess
import sys
import threading
import zipfile
from dataclasses import replace
from pathlib import Path

import httpx
import numpy as np
import pytest
from fastapi import FastAPI

from layouts import takeaway
from layouts.outgoing import STEP
from layouts.text import file_stem
from server.work import Work
from tests.waiting import eventually
from tracker_core import SCENARIOS, Experiment, run_experiment
from tracker_core.__main__ import main
from tracker_core.measured import SHELF, File, content_name, proposed, target

RECORDINGS = Path(__file__).parents[2] / "assets" / "recordings"


@pytest.fixture
def dirty():
    # A file of its own: one that is known already keeps the name that it came with.
    content = (RECORDINGS / "dirty.csv").read_bytes() + b"# taken home\n"
    return SHELF.keep(File("dirty landing <b>.csv", content))


def filter_of(data):
    return {"data": data, "design": "steady-kalman", "tracking_index": "0.0026", "noise_std": "12,12,4", "gate": "4"}


def ask(http, path, **query):
    return http("GET", path, params=query)


def test_the_track_is_the_page_s(http, dirty):
    answer = ask(http, "/export/track.csv", **filter_of(dirty), quantity="velocity", pin1="kalata,tracking_index:1")
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "text/csv; charset=utf-8"
    assert answer.headers["content-disposition"].startswith('attachment; filename="dirty-landing-b-track.csv"')
    table = list(csv.DictReader(io.StringIO(answer.text)))
    track = run_experiment(Experiment.from_dict(filter_of(dirty))).track
    got = np.array([float(row["north_smoothed"] or "nan") for row in table])
    np.testing.assert_array_equal(got, track.smoothed[:, 1, 0])


def test_the_json_files_are_json(http, dirty):
    query = filter_of(dirty)
    result = run_experiment(Experiment.from_dict(query))
    got = {name: ask(http, f"/export/{name}.json", **query).json() for name in ("track", "metrics", "experiment")}
    assert Experiment.from_dict(got["experiment"]) == result.experiment
    assert got["metrics"]["rejected"] == int(result.track.rejected.sum())
    assert len(got["track"]["time"]) == 420


def test_findings_are_listed_with_their_lines(http, dirty):
    answer = ask(http, "/export/findings.csv", **filter_of(dirty))
    rows = list(csv.reader(io.StringIO(answer.text)))
    assert rows[0] == ["line", "kind", "reason", "what is done"]
    assert all(cell[:1] not in "=+-@" for row in rows for cell in row if not cell.isdecimal())
    refused = ask(http, "/export/findings.csv", xi="0.5")
    assert (refused.status_code, refused.json()["field"]) == (422, "data")


def test_the_zip_holds_a_filter_that_tests_itself(http, dirty, tmp_path):
    answer = ask(http, "/export.zip", **filter_of(dirty))
    assert answer.headers["content-type"] == "application/zip"
    assert answer.content == ask(http, "/export.zip", **filter_of(dirty)).content
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        assert archive.testzip() is None
        assert {"track.csv", "metrics.json", "experiment.json", "findings.csv", "README.txt"} <= {*archive.namelist()}
        assert json.loads(archive.read("experiment.json"))["data"] == dirty
        assert dirty in archive.read("README.txt").decode()
        archive.extractall(tmp_path)
    ran = subprocess.run([sys.executable, tmp_path / "filter" / "tuned_filter.py"], timeout=60, check=False)
    assert ran.returncode == 0


def test_a_simulated_target_goes_out_as_well(http):
    answer = ask(http, "/export.zip", xi="0.5", samples="40")
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        assert "findings.csv" not in archive.namelist()


def columns_of(answer, axes, kind):
    """Positions of an exported track, shape (n_samples, n_axes)."""
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    return np.array([[float(row[f"{axis}_{kind}"] or "nan") for axis in axes] for row in rows])


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_a_track_that_comes_back_as_a_recording_is_the_same(http, scenario):
    """Taken home, sent in again, filtered by the same gains and taken home once more: nothing is lost on the way."""
    tuned = {"start": "first", "order": "3", "xi": "0.6"}
    out = ask(http, "/export/track.csv", scenario=scenario, **tuned)
    said = {"name": f"{scenario}.csv", "keep": "browser"}
    sent = http("PUT", "/recordings", params=said, content=out.content)
    assert sent.status_code == 200
    assert sent.json()["data"] == content_name(out.content)
    back = ask(http, "/export/track.csv", data=sent.json()["data"], **tuned)
    axes = SCENARIOS[scenario].axes
    there = target(sent.json()["data"], proposed(sent.json()["data"])).axes
    for kind in ("observed", "predicted", "smoothed", "true"):
        before, after = columns_of(out, axes, kind), columns_of(back, there, kind)
        np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-9 * np.nanmax(np.abs(before)))


@pytest.mark.parametrize(
    ("path", "query", "status", "field"),
    [
        ("/export.zip", {"xi": "2"}, 422, "xi"),
        ("/export.zip", {"data": "f" * 32}, 422, "data"),
        ("/export.zip", {"data": "nonsense"}, 422, "data"),
        ("/export/track.csv", {"samples": "1e9"}, 422, "samples"),
        ("/export/nothing.csv", {}, 404, "export"),
        ("/export/all.zip", {"order": "7"}, 422, "order"),
    ],
)
def test_what_cannot_be_run_names_the_field(http, path, query, status, field):
    answer = ask(http, path, **query)
    assert answer.status_code == status
    assert answer.json()["field"] == field
    assert answer.json().keys() == {"field", "rule", "received", "message", "request"}


def test_too_many_waiting_are_refused(monkeypatch):
    monkeypatch.setattr(takeaway, "AT_ONCE", 1)
    going_on = threading.Event()
    export = replace(takeaway.EXPORTS["track.csv"], write=lambda result, stream, link: going_on.wait(20))
    monkeypatch.setitem(takeaway.EXPORTS, "track.csv", export)
    server = FastAPI()
    takeaway.attach(server, Work(waiting=1))

    async def run():
        transport = httpx.ASGITransport(app=server)
        async with httpx.AsyncClient(transport=transport, base_url="http://test", timeout=60) as client:
            several = [asyncio.ensure_future(client.get("/export/track.csv")) for _ in range(3)]
            done, _ = await asyncio.wait(several, return_when=asyncio.FIRST_COMPLETED)
            going_on.set()
            return done.pop().result(), await asyncio.gather(*several)

    refused, several = asyncio.run(run())
    assert (refused.status_code, refused.headers["retry-after"]) == (503, "2")
    assert sorted(one.status_code for one in several) == [200, 200, 503]


def test_a_disk_that_is_not_there_is_said(tmp_path):
    server = FastAPI()
    takeaway.attach(server, Work(), tmp_path / "nowhere")

    async def run():
        transport = httpx.ASGITransport(app=server)
        async with httpx.AsyncClient(transport=transport, base_url="http://test", timeout=60) as client:
            return [await client.get(f"/export/track.csv?samples={count}") for count in (20, 5000)]

    small, large = asyncio.run(run())
    assert small.status_code == 200
    assert (large.status_code, large.json()["field"]) == (507, "export")
    assert large.json()["received"] == "'No such file or directory'"


@pytest.mark.parametrize(
    ("title", "stem"),
    [
        ("dirty.csv", "dirty"),
        ("log 2024-05-04.csv.gz", "log-2024-05-04"),
        ("../../etc/passwd", "etc-passwd"),
        ("<img src=x>.CSV", "img-src-x"),
        ("Höhenflug über Köln.txt", "Hohenflug-uber-Koln"),
        ("日本", "gainscope"),
        (".csv", "gainscope"),
        ("x" * 100, "x" * 40),
    ],
)
def test_names_of_files_suit_any_system(title, stem):
    assert file_stem(title) == stem


# Several at once -----------------------------------------------------------------------------------------------------


def test_many_at_once_arrive_whole_and_stop_nobody_else(monkeypatch):
    """More than there are threads: all come in full, and what needs a thread itself does not wait for them."""
    server = FastAPI()
    takeaway.attach(server, Work())
    running, go_on = [], threading.Event()
    usual = takeaway.run_experiment

    def held(experiment):
        running.append(experiment)
        assert go_on.wait(60)
        return usual(experiment)

    @server.get("/thread")
    async def thread():
        return await asyncio.to_thread(lambda: "ran")

    async def run():
        transport = httpx.ASGITransport(app=server)
        async with httpx.AsyncClient(transport=transport, base_url="http://test", timeout=60) as client:
            link = "/export/track.csv?samples=4000&order=4&xi=0.8"
            alone = await client.get(link)
            monkeypatch.setattr(takeaway, "run_experiment", held)
            several = [asyncio.ensure_future(client.get(link)) for _ in range(16)]
            await eventually(lambda: len(running) == takeaway.AT_ONCE)
            assert (await client.get("/thread")).json() == "ran"
            late = sum(not one.done() for one in several)
            go_on.set()
            return alone, await asyncio.gather(*several), late

    alone, several, late = asyncio.run(run())
    assert late == len(several)
    assert {one.content for one in several} == {alone.content}


def test_a_place_is_free_again_however_an_export_ended(monkeypatch):
    monkeypatch.setattr(takeaway, "MOST_BYTES", 2 * STEP)
    server = FastAPI()
    takeaway.attach(server, Work(waiting=0))

    async def gone():
        return {"type": "http.disconnect"}

    async def refuse(message):
        raise OSError("gone")

    async def run():
        transport = httpx.ASGITransport(app=server)
        async with httpx.AsyncClient(transport=transport, base_url="http://test", timeout=60) as client:
            for _ in range(2):
                assert (await client.get("/export/track.csv?samples=20")).status_code == 200
                assert (await client.get("/export/findings.csv?samples=20")).status_code == 422
                scope = {
                    "type": "http", "method": "GET", "path": "/export/track.csv", "query_string": b"samples=20",
                    "headers": [], "asgi": {"version": "3.0", "spec_version": "2.4"}, "http_version": "1.1",
                    "raw_path": b"/export/track.csv", "scheme": "http", "server": ("test", 80), "root_path": "",
                }  # fmt: skip
                with contextlib.suppress(Exception):
                    await server(scope, gone, refuse)

    asyncio.run(run())


def test_the_list_in_the_zip_says_how_to_repeat_a_recording(http, dirty, tmp_path, capsys):
    with zipfile.ZipFile(io.BytesIO(ask(http, "/export.zip", **filter_of(dirty)).content)) as archive:
        archive.extractall(tmp_path)
    (line,) = [part for part in (tmp_path / "README.txt").read_text("utf-8").splitlines() if "To repeat it" in part]
    command = line.partition("python -m tracker_core ")[2].partition(",")[0].split()
    recording = tmp_path / "recording.csv"
    recording.write_bytes((RECORDINGS / "dirty.csv").read_bytes() + b"# taken home\n")
    files = {"experiment.json": str(tmp_path / "experiment.json"), "FILE": str(recording)}
    assert main([*(files.get(part, part) for part in command), "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["metrics"] == json.loads((tmp_path / "metrics.json").read_text("utf-8"))["metrics"]
