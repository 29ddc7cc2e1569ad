"""The document that every page begins with: what it says, what it leaves out, and that all it names is there."""

import json
import re
import sys

import dash
import orjson
import plotly
import pytest
from dash import page_registry
from dash.development.base_component import Component

from layouts.document import TOLD, UNUSED, document_policy
from layouts.shell import frame
from server.files import ASK, IMMUTABLE
from server.policy import source

PATHS = ("/", "/stability", "/tune", "/compare", "/data", "/3d", "/papers", "/learn")


@pytest.fixture(scope="module")
def text(get):
    """The document."""
    return get("/").text


@pytest.fixture(scope="module")
def settings(text):
    """What it tells Dash's script."""
    return json.loads(re.search(r'id="_dash-config" type="application/json">(.*?)</script>', text, re.DOTALL)[1])


def addresses(text):
    """All that the document asks for."""
    return [found[1] for found in re.finditer(r'(?:src|href)="(/[^"]*)"', text)]


def test_every_page_has_the_same_document(get, text):
    assert set(PATHS) == {page["path"] for page in page_registry.values()}
    for path in (*PATHS, "/?order=3&alpha=0.5", "/3d/"):
        answer = get(path)
        assert (answer.status_code, answer.text) == (200, text), path
        assert answer.headers["Cache-Control"] == ASK
        assert answer.headers["Content-Security-Policy"] == f"{document_policy(text)}; frame-ancestors 'self'"


@pytest.mark.parametrize("path", ["/nothing", "/3d/more", "/favicon.ico", "/%2e%2e/app.py", "/index.html"])
def test_an_unknown_address_says_so_and_shows_the_pages(get, text, path):
    assert (get(path).status_code, get(path).text) == (404, text)


def test_all_that_it_names_is_kept_for_ever(get, text):
    assert len(addresses(text)) > 15
    for address in addresses(text):
        answer = get(address)
        assert (answer.status_code, answer.headers["Cache-Control"]) == (200, IMMUTABLE), address


def test_what_its_scripts_ask_for_is_there_beside_them(get, text, settings):
    graph = next(address for address in addresses(text) if "async-graph" in address)
    main = next(address for address in addresses(text) if "dash_core_components.js" in address)
    assert graph.rpartition("/")[0] == main.rpartition("/")[0]
    assert settings["plotlyjs_url"] in addresses(text)
    assert settings["serve_locally"] is False
    assert get(settings["plotlyjs_url"]).headers["Cache-Control"] == IMMUTABLE
    assert "websocket" not in settings


def test_the_browser_is_told_of_plotly_before_a_plot_asks_for_it(text, settings):
    head = text[: text.index("</head>")]
    assert f'<link rel="preload" as="script" href="{settings["plotlyjs_url"]}"' in head


def test_no_version_is_told(text, settings):
    assert not set(TOLD) & settings.keys()
    for version in (dash.__version__, plotly.__version__, sys.version.split()[0]):
        assert version not in text


def test_what_no_page_needs_is_not_asked_for(text, get):
    assert UNUSED
    for unused in UNUSED:
        assert unused not in text
    assert len(text) < 12_000


def test_dashs_own_ways_to_files_are_closed(get):
    for path in (
        "/_dash-component-suites/dash/dcc/dash_core_components.js",
        "/_dash-component-suites/plotly/package_data/plotly.min.js",
        "/_dash-component-suites/nonsense/../../x",
        "/_favicon.ico",
        "/_reload-hash",
        "/assets/../app.py",
    ):
        assert get(path).status_code == 404, path


def test_what_dash_asks_for_at_its_beginning_is_what_dash_would_say(get, dash_app):
    assert get("/_dash-layout").json() == orjson.loads(json.dumps(frame(), cls=plotly.utils.PlotlyJSONEncoder))
    assert get("/_dash-dependencies").json() == json.loads(dash_app.dependencies().body)
    for name in ("layout", "dependencies"):
        assert get(f"/_dash-{name}").headers["Cache-Control"] == ASK


def test_its_policy_names_the_scripts_that_stand_in_it(text, dash_app):
    given = {part.split()[0]: part.split()[1:] for part in document_policy(text).split("; ")}
    inline = re.findall(r"<script(?! src)(?![^>]*json)[^>]*>(.*?)</script>", text, re.DOTALL)
    assert len(inline) == 2
    assert given["script-src"] == ["'self'", *map(source, inline)]
    # Dash names the same.
    assert set(dash_app.csp_hashes()) == set(map(source, inline))
    assert not {"'unsafe-eval'", "'unsafe-inline'", "*", "https:"} & set(given["script-src"])
    assert given["default-src"] == ["'self'"]
    assert given["object-src"] == given["base-uri"] == given["form-action"] == ["'none'"]


def names(part):
    """The ids of all components."""
    if isinstance(part, list | tuple):
        return set().union(*map(names, part))
    if not isinstance(part, Component):
        return set()
    own = {part.id} if getattr(part, "id", None) else set()
    return own | names(getattr(part, "children", None))


def test_all_that_callbacks_name_is_on_a_page(dash_app, get):
    """Dash is told not to look: it would send every browser all pages for it."""
    there = names(frame()) | set().union(*(names(page["layout"]()) for page in page_registry.values()))
    named = set()
    for callback in get("/_dash-dependencies").json():
        outputs = callback["output"].strip(".").split("...")
        parts = [output.rpartition(".")[0] for output in outputs]
        named |= {*parts, *(part["id"] for part in (*callback["inputs"], *callback["state"]))}
    assert len(named) > 30
    assert named <= there
