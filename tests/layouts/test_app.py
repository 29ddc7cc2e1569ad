"""The server as a whole: health, the page's document, settings from the environment."""

import asyncio
import contextlib
import html.parser
import json
import os
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import httpx
import msgspec
import orjson
import pytest
from fastapi import FastAPI

import app
from layouts.desk import answer
from layouts.pages.compare.answers import DESK as COMPARE
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pages.track.answers import DESK as TRACK
from layouts.pages.tune.answers import DESK as TUNE
from layouts.state import View
from server.lifecycle import Life
from server.settings import Settings
from tracker_core import kernels

ROOT = Path(__file__).parents[2]
DESKS = (EXPLORE, STABILITY, COMPARE, TRACK, TUNE)
ON_EVERY_PAGE = pytest.mark.parametrize("desk", DESKS, ids=lambda desk: desk.page)


class Document(html.parser.HTMLParser):
    """Every element of a document with its attributes, and the text of the title."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.title, self.open = [], "", ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        self.open = tag

    def handle_endtag(self, tag):
        self.open = ""

    def handle_data(self, data):
        if self.open == "title":
            self.title += data

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.fixture(scope="module")
def document(get):
    answer = get("/")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/html")
    return Document(answer.text)


# Health ------------------------------------------------------------------------------------------------------------


def test_the_server_says_how_far_it_has_come():
    life = Life()
    server = app.build(Settings(work_seconds=7.5), life=life).server

    def get(path):
        answer = asked(server, path)
        return answer.status_code, answer.json()

    # And pages know how long they may have to wait for an answer.
    assert get("/_dash-layout")[1]["props"]["data-answer-seconds"] == "7.5"

    for state, status in (("starting", 503), ("compiling", 503), ("ready", 200)):
        life.reach(state)
        assert get("/livez") == (200, {"status": "alive"})
        assert get("/readyz") == (status, {"status": state})
    life.stop()
    assert get("/readyz") == (503, {"status": "stopping"})
    assert get("/livez") == (200, {"status": "alive"})


def asked(server, path):
    async def once():
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app=server), base_url="http://gainscope") as client:
            return await client.get(path)

    return asyncio.run(once())


def test_the_server_is_ready_when_its_kernels_are_loaded():
    life, told = Life(), threading.Event()
    reach = life.reach
    life.reach = lambda state: (reach(state), told.set() if state == "ready" else None)
    app.prepare(life)
    assert life.state in ("compiling", "ready")
    assert told.wait(600)
    assert life.state == "ready"


# The document ------------------------------------------------------------------------------------------------------


def test_the_document_says_language_title_and_how_wide_it_is(document):
    assert document.all("html")[0]["lang"] == "en"
    assert document.title == "Gainscope"
    meta = {attributes.get("name"): attributes.get("content") for attributes in document.all("meta")}
    assert meta["viewport"] == "width=device-width, initial-scale=1"


def test_everything_comes_from_this_server(document, get):
    addresses = [
        attributes[name] for _, attributes in document.elements for name in ("src", "href") if attributes.get(name)
    ]
    assert len(addresses) > 5
    for address in addresses:
        assert "//" not in address
    for name in (
        "app.css",
        "tokens.css",
        "desk.js",
        "handles.js",
        "scene.js",
        "live.js",
        "shell.js",
        "theme.js",
        "favicon",
    ):
        assert any(name in address for address in addresses), name
    for address in addresses:
        if not address.startswith("#"):
            assert get(address if address.startswith("/") else f"/{address}").status_code == 200, address


def test_the_theme_is_chosen_before_anything_is_painted(document):
    """Its script comes before the styles, once, and does not wait."""
    order = [
        attributes.get("src") or attributes.get("href") or ""
        for tag, attributes in document.elements
        if tag in ("script", "link")
    ]
    theme = [index for index, address in enumerate(order) if "theme.js" in address]
    first_style = next(index for index, address in enumerate(order) if ".css" in address)
    assert len(theme) == 1
    assert theme[0] < first_style
    assert not {"async", "defer"} & set(document.all("script")[0])


def test_one_can_skip_to_the_page(document):
    assert document.all("a")[0] == {"class": "skip", "href": "#main"}
    assert len(document.all("noscript")) == 1


def test_the_api_tells_no_more_than_it_must(get):
    for path in ("/docs", "/redoc", "/openapi.json"):
        assert "swagger" not in get(path).text.lower()
        assert '"openapi"' not in get(path).text.lower()


def test_the_layout_is_served_with_what_a_link_says(get, dash_app):
    layout = json.loads(get("/_dash-layout").text)
    assert '"main"' in json.dumps(layout)
    dependencies = json.loads(get("/_dash-dependencies").text)
    outputs = " ".join(dependency["output"] for dependency in dependencies)
    for desk in DESKS:
        wanted = [f"{desk.page}-{name}.data" for name in ("begun", "answered", "answer")]
        wanted += [f"{plot}.figure" for plot in desk.plots] + [f"{place}.children" for place in desk.tables]
        assert [name for name in wanted if name not in outputs] == []


# The way of the callbacks ------------------------------------------------------------------------------------------


@pytest.fixture
def call(http):
    """What Dash's front end does with a request of a page: the response to the callback."""

    def post(desk, question):
        outputs = [
            *({"id": plot, "property": "figure"} for plot in desk.plots),
            *({"id": place, "property": "children"} for place in desk.tables),
            {"id": f"{desk.page}-answer", "property": "data"},
        ]
        return http(
            "POST",
            "/_dash-update-component",
            json={
                "output": "..{}..".format("...".join(f"{o['id']}.{o['property']}" for o in outputs)),
                "outputs": outputs,
                "inputs": [{"id": f"{desk.page}-request", "property": "data", "value": msgspec.to_builtins(question)}],
                "changedPropIds": [f"{desk.page}-request.data"],
            },
        )

    return post


@ON_EVERY_PAGE
@pytest.mark.parametrize("samples", [50, 20_000])
def test_the_callback_gives_figures_tables_and_the_rest(call, controls_for, request_for, desk, samples):
    view = View(background="lag")
    question = request_for(controls_for(view, samples=samples), want=[*desk.plots, *desk.tables])
    answered = call(desk, question)
    assert answered.status_code == 200
    got = json.loads(answered.text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))["response"]
    updates, rest = answer(desk, question)
    for plot, figure in zip(desk.plots, updates, strict=False):
        assert got[plot]["figure"] == json.loads(orjson.dumps(figure))
    for place in desk.tables:
        assert {table["type"] for table in got[place]["children"]} == {"Div"}
    assert got[f"{desk.page}-answer"]["data"] == json.loads(json.dumps(rest))


@ON_EVERY_PAGE
def test_the_callback_leaves_plots_alone_after_an_error(call, controls_for, request_for, desk):
    answered = call(desk, request_for(controls_for(), {"samples": "2"})).json()["response"]
    assert list(answered) == [f"{desk.page}-answer"]
    assert answered[f"{desk.page}-answer"]["data"]["errors"].keys() == {"samples"}


@ON_EVERY_PAGE
def test_the_callback_sends_what_moved_as_patches(call, controls_for, request_for, desk):
    controls = controls_for(samples=50)
    drawn = call(desk, request_for(controls)).json()["response"][f"{desk.page}-answer"]["data"]["drawn"]
    got = call(desk, request_for(controls, {"xi": 0.3}, drawn=drawn)).json()["response"]
    for plot in desk.plots:
        operations = got[plot]["figure"]["operations"]
        assert {"Assign"} == {operation["operation"] for operation in operations}, plot


# Settings ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def served(monkeypatch, tmp_path):
    """What the server is built and served with, once for each call of `app.main`."""
    seen = []

    class Quiet:
        def __init__(self, config, life, drain_seconds):
            seen[-1] |= {"config": config, "life": life, "drain": drain_seconds}

        def run(self):
            seen[-1]["ran"] = True

    def build(settings, executor, store, life):
        seen.append({"settings": settings, "executor": executor, "store": store, "life": life})
        return type("Built", (), {"server": FastAPI()})

    for name in [name for name in os.environ if name.startswith("GAINSCOPE_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("GAINSCOPE_DATA", "")
    monkeypatch.setattr(app, "build", build)
    monkeypatch.setattr(app, "prepare", lambda life: None)
    monkeypatch.setattr(app, "Server", Quiet)
    monkeypatch.setattr(app.logs, "start", lambda form, level: None)
    monkeypatch.setattr(app.descriptors, "provide", lambda settings: settings.sockets + 1)
    monkeypatch.setattr(app.lifecycle, "leave_at_once_until_served", lambda: None)
    return seen


@pytest.mark.parametrize("port", ["0", "http", "", "1e9"])
def test_a_port_that_is_none_is_refused_in_one_line(monkeypatch, served, capsys, port):
    monkeypatch.setenv("GAINSCOPE_PORT", port)
    assert app.main() == 2
    assert served == []
    out, err = capsys.readouterr()
    assert out == ""
    assert err == f"gainscope: GAINSCOPE_PORT must be a whole number >= 1 and <= 65,535, got {port!r}\n"


def test_dash_s_tools_are_refused_in_production(monkeypatch, served, capsys):
    monkeypatch.setenv("DASH_MCP_ENABLED", "true")
    assert app.main() == 2
    assert served == []
    said = "gainscope: DASH_MCP_ENABLED must be false or left out in production, got 'true'\n"
    assert capsys.readouterr().err == said
    monkeypatch.setenv("GAINSCOPE_MODE", "development")
    assert app.main() == 0


def test_the_server_listens_where_it_is_told_and_says_what_is_set(monkeypatch, served, caplog):
    monkeypatch.setenv("GAINSCOPE_PORT", "65535")
    monkeypatch.setenv("GAINSCOPE_HOST", "0.0.0.0")
    monkeypatch.setenv("GAINSCOPE_METRICS_TOKEN", "kept-from-all")
    monkeypatch.setenv("GAINSCOPE_DRAIN_SECONDS", "3")
    with caplog.at_level("INFO"):
        assert app.main() == 0
    [seen] = served
    assert (seen["config"].host, seen["config"].port, seen["drain"], seen["ran"]) == ("0.0.0.0", 65535, 3, True)
    assert caplog.messages == ["Gainscope on http://0.0.0.0:65535"]
    assert caplog.records[0].settings["GAINSCOPE_METRICS_TOKEN"] == "set"
    assert caplog.records[0].descriptors == seen["settings"].sockets + 1
    assert "kept-from-all" not in str(vars(caplog.records[0]))


def test_studies_are_computed_where_the_setting_says(monkeypatch, served):
    class Cluster:
        def __init__(self, address):
            self.address = address

        def shutdown(self, **how):
            pass

    monkeypatch.setattr(app, "Cluster", Cluster)
    monkeypatch.setenv("GAINSCOPE_DASK_SCHEDULER", "tcp://here:8786")
    assert app.main() == 0
    assert served.pop()["executor"].address == "tcp://here:8786"


def test_without_a_cluster_studies_are_computed_by_another_process_once_all_is_compiled(monkeypatch, served):
    assert app.main() == 0
    executor = served.pop()["executor"]
    monkeypatch.setattr(kernels.loading, "held", lambda: True)
    assert executor.submit(os.getpid).result() == os.getpid()
    assert not executor.running()
    monkeypatch.setattr(kernels.loading, "held", lambda: False)
    assert executor.submit(os.getpid).result() == os.getpid()
    assert executor.running()
    for _ in range(600):
        if (number := executor.submit(os.getpid).result()) != os.getpid():
            break
        time.sleep(0.05)
    assert number != os.getpid()
    executor.shutdown()


def test_a_cluster_out_of_reach_is_said_in_one_line_without_its_password(monkeypatch, served, capsys):
    monkeypatch.setenv("GAINSCOPE_DASK_SCHEDULER", "user:kept-from-all@nonsense")
    assert app.main() == 2
    assert served == []
    assert capsys.readouterr().err == (
        "gainscope: GAINSCOPE_DASK_SCHEDULER must be the address of a Dask scheduler that answers within 5 s, such as "
        "tcp://host:8786, got '…@nonsense'\n"
    )


def test_recordings_are_kept_where_and_as_the_settings_say(monkeypatch, served, tmp_path, caplog):
    for name, value in {"DATA": str(tmp_path / "here"), "DATA_MB": "2.5", "DATA_DAYS": "7", "UPLOAD_MB": "0.5"}.items():
        monkeypatch.setenv(f"GAINSCOPE_{name}", value)
    assert app.main() == 0
    store = served[0]["store"]
    assert (store.directory, store.most_bytes, store.days, store.problem) == (tmp_path / "here", 2_500_000, 7, "")
    assert served[0]["settings"].upload_mb == 0.5
    assert caplog.messages == []


def test_recordings_are_kept_in_the_user_s_data_else_in_memory(monkeypatch, served, tmp_path, caplog):
    monkeypatch.delenv("GAINSCOPE_DATA")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert app.main() == 0
    assert served.pop()["store"].directory == tmp_path / "gainscope"
    monkeypatch.setenv("GAINSCOPE_DATA", "")
    assert app.main() == 0
    assert served.pop()["store"] is None
    (tmp_path / "file").touch()
    monkeypatch.setenv("GAINSCOPE_DATA", str(tmp_path / "file"))
    assert app.main() == 0
    assert caplog.messages == [f"Recordings are kept in memory alone: {tmp_path / 'file'}: File exists"]


def test_a_bad_port_ends_the_program_with_status_2():
    done = subprocess.run(
        [sys.executable, "app.py"], cwd=ROOT, env=os.environ | {"GAINSCOPE_PORT": "eighty"}, capture_output=True,
        encoding="utf-8", timeout=60, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "gainscope: GAINSCOPE_PORT must be a whole number >= 1 and <= 65,535, got 'eighty'\n"


def test_told_to_stop_while_others_compile_it_leaves_nobody_behind(tmp_path):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    settings = {"GAINSCOPE_PORT": str(port), "GAINSCOPE_DATA": "", "NUMBA_CACHE_DIR": str(tmp_path)}
    with subprocess.Popen([sys.executable, "app.py"], cwd=ROOT, env=os.environ | settings) as process:
        try:
            while True:
                assert process.poll() is None
                with contextlib.suppress(httpx.TransportError):
                    httpx.get(f"http://127.0.0.1:{port}/livez")
                    break
                time.sleep(0.1)
            tasks = Path(f"/proc/{process.pid}/task")
            while not (compiling := {child for task in tasks.iterdir() for child in ids(task / "children")}):
                time.sleep(0.1)
            process.terminate()
            assert process.wait(60) == 0
        finally:
            process.kill()
    for _ in range(100):
        if not any(Path(f"/proc/{child}").exists() for child in compiling):
            break
        time.sleep(0.1)
    assert not any(Path(f"/proc/{child}").exists() for child in compiling)


def ids(file):
    return file.read_text(encoding="utf-8").split()
