"""The server as a whole: health, the page's document, settings from the environment."""

import html.parser
import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import msgspec
import orjson
import pytest

import app
from layouts.desk import answer
from layouts.pages.compare.answers import DESK as COMPARE
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pages.track.answers import DESK as TRACK
from layouts.pages.tune.answers import DESK as TUNE
from layouts.state import View
from tracker_core import Experiment

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


def test_the_server_says_when_nobody_waits_for_a_compiler_any_more(get, monkeypatch):
    monkeypatch.setattr(app, "READY", threading.Event())
    assert (get("/livez").status_code, get("/livez").json()) == (200, {"status": "alive"})
    assert (get("/readyz").status_code, get("/readyz").json()) == (503, {"status": "compiling"})
    app.warm_up()
    assert (get("/readyz").status_code, get("/readyz").json()) == (200, {"status": "ready"})
    assert get("/livez").status_code == 200


def test_warming_up_runs_every_order_and_start(monkeypatch):
    monkeypatch.setattr(app, "READY", threading.Event())
    runs = []

    def run(experiment):
        assert isinstance(experiment, Experiment)
        # What only some need is compiled later.
        assert app.READY.is_set() == (experiment.gate is not None)
        if experiment.gate is None:
            runs.append((experiment.order, experiment.start))

    monkeypatch.setattr(app, "run_experiment", run)
    app.warm_up()
    starts = ["known", "first", "two-point", "expanding"]
    assert sorted(runs) == sorted(
        [(o, s) for o in (2, 3, 4) for s in starts] + [(3, "three-point"), (4, "three-point")]
    )
    assert app.READY.is_set()


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
        assert "openapi" not in get(path).text.lower()


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

BAD_PORTS = ["0", "65536", "-1", "80.5", "http", "", "8050 8051", "nan", "inf", "1e9"]


@pytest.mark.parametrize("port", BAD_PORTS)
def test_a_port_that_is_none_is_refused_in_one_line(monkeypatch, capsys, port):
    monkeypatch.setenv("GAINSCOPE_PORT", port)
    monkeypatch.setattr(app, "build", lambda *_: pytest.fail("it must not come to this"))
    assert app.main() == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err == f"gainscope: GAINSCOPE_PORT must be a whole number >= 1 and <= 65,535, got {port!r}\n"


@pytest.mark.parametrize(
    ("environment", "host", "port"),
    [
        ({}, "127.0.0.1", 8050),
        ({"GAINSCOPE_PORT": "1"}, "127.0.0.1", 1),
        ({"GAINSCOPE_PORT": "65535", "GAINSCOPE_HOST": "0.0.0.0"}, "0.0.0.0", 65535),
    ],
)
def test_the_server_listens_where_it_is_told(monkeypatch, capsys, environment, host, port):
    for name in ("GAINSCOPE_HOST", "GAINSCOPE_PORT", "GAINSCOPE_DASK_SCHEDULER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("GAINSCOPE_DATA", "")
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    served = {}
    monkeypatch.setattr(app, "build", lambda *_: type("Built", (), {"server": "the server"}))
    monkeypatch.setattr(app, "warm_up", lambda: served.update(warm=True))
    monkeypatch.setattr(app.uvicorn, "run", lambda server, **options: served.update(options, server=server))
    assert app.main() == 0
    assert (served["server"], served["host"], served["port"]) == ("the server", host, port)
    assert capsys.readouterr().out == f"Gainscope on http://{host}:{port}\n"


def test_studies_are_computed_where_the_setting_says(monkeypatch):
    built = []
    monkeypatch.setattr(
        app, "build", lambda executor, *_: built.append(executor) or type("Built", (), {"server": None})
    )
    monkeypatch.setenv("GAINSCOPE_DATA", "")
    monkeypatch.setattr(app, "warm_up", lambda: None)
    monkeypatch.setattr(app.uvicorn, "run", lambda *_, **__: None)
    monkeypatch.setattr(app, "Cluster", lambda address: f"the cluster at {address}")
    for address, executor in (("", None), ("tcp://here:8786", "the cluster at tcp://here:8786")):
        monkeypatch.setenv("GAINSCOPE_DASK_SCHEDULER", address)
        assert app.main() == 0
        assert built.pop() == executor


def test_a_cluster_out_of_reach_is_said_in_one_line(monkeypatch, capsys):
    monkeypatch.setenv("GAINSCOPE_DASK_SCHEDULER", "nonsense")
    monkeypatch.setenv("GAINSCOPE_DATA", "")
    monkeypatch.setattr(app, "build", lambda *_: pytest.fail("it must not come to this"))
    assert app.main() == 2
    assert capsys.readouterr().err == (
        "gainscope: GAINSCOPE_DASK_SCHEDULER must be the address of a Dask scheduler that answers within 5 s, such as "
        "tcp://host:8786, got 'nonsense'\n"
    )


@pytest.fixture
def started(monkeypatch):
    """What the server is built with."""
    built = []
    monkeypatch.setattr(app, "build", lambda *given: built.append(given) or type("Built", (), {"server": None}))
    monkeypatch.setattr(app, "warm_up", lambda: None)
    monkeypatch.setattr(app.uvicorn, "run", lambda *_, **__: None)
    return built


def test_recordings_are_kept_where_and_as_the_settings_say(monkeypatch, started, tmp_path, capsys):
    for name, value in {"DATA": str(tmp_path / "here"), "DATA_MB": "2.5", "DATA_DAYS": "7", "UPLOAD_MB": "0.5"}.items():
        monkeypatch.setenv(f"GAINSCOPE_{name}", value)
    assert app.main() == 0
    [(_, store, upload_bytes)] = started
    assert (store.directory, store.most_bytes, store.days) == (tmp_path / "here", 2_500_000, 7)
    assert (store.problem, upload_bytes) == ("", 500_000)
    assert capsys.readouterr().err == ""


def test_recordings_are_kept_in_the_user_s_data_else_in_memory(monkeypatch, started, tmp_path, capsys):
    monkeypatch.delenv("GAINSCOPE_DATA", raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert app.main() == 0
    assert started.pop()[1].directory == tmp_path / "gainscope"
    monkeypatch.setenv("GAINSCOPE_DATA", "")
    assert app.main() == 0
    assert started.pop()[1] is None
    (tmp_path / "file").touch()
    monkeypatch.setenv("GAINSCOPE_DATA", str(tmp_path / "file"))
    capsys.readouterr()
    assert app.main() == 0
    assert capsys.readouterr().err == (
        f"gainscope: recordings are kept in memory alone: {tmp_path / 'file'}: File exists\n"
    )


@pytest.mark.parametrize(
    ("name", "value"), [("DATA_MB", "0"), ("DATA_MB", "much"), ("DATA_DAYS", "0.5"), ("UPLOAD_MB", "11")]
)
def test_a_bound_that_is_none_is_refused_in_one_line(monkeypatch, started, capsys, name, value):
    monkeypatch.setenv(f"GAINSCOPE_{name}", value)
    assert app.main() == 2
    assert started == []
    assert capsys.readouterr().err.startswith(f"gainscope: GAINSCOPE_{name} must be a finite number")


def test_a_bad_port_ends_the_program_with_status_2():
    done = subprocess.run(
        [sys.executable, "app.py"], cwd=ROOT, env=os.environ | {"GAINSCOPE_PORT": "eighty"}, capture_output=True,
        encoding="utf-8", timeout=60, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "gainscope: GAINSCOPE_PORT must be a whole number >= 1 and <= 65,535, got 'eighty'\n"
