"""Pages whose parts are worked out once: the same to a browser, and nobody's link is in another's page."""

import importlib
import json
import re

import pytest
from dash._utils import to_json

from layouts.pages import learn, papers
from layouts.site import PAGES

ON_EVERY_PAGE = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.NAME)


def view_of(page):
    return importlib.import_module(f"{page.__name__}.view")


@ON_EVERY_PAGE
def test_a_prepared_page_is_the_page(monkeypatch, page):
    """To the last byte, and every time."""
    view = view_of(page)
    visits = [to_json(page.layout()) for _ in range(2)]
    monkeypatch.setattr(view, "prepared", lambda *parts: parts)
    monkeypatch.setattr(view, "_parts", view._parts.__wrapped__)
    assert visits == [to_json(page.layout())] * 2


@pytest.mark.parametrize("page", [page for page in PAGES if page is not learn], ids=lambda page: page.NAME)
def test_a_link_is_in_no_page_but_its_own(page):
    before = to_json(page.layout())
    words = {"seeds": "37"} if page is papers else {"xi": "0.7310", "pin1": "fading-memory,xi:0.5,name:Mine alone"}
    theirs = to_json(page.layout(**words))
    assert theirs != before
    assert "Mine alone" in theirs or page is papers
    assert to_json(page.layout()) == before


def test_no_more_documents_are_remembered_than_fit():
    """A link may ask for any number of runs."""
    remembered = view_of(papers)._parts
    for seeds in range(20, 40):
        papers.layout(seeds=str(seeds))
    assert remembered.cache_info().currsize <= 8


def test_the_document_of_a_page_is_without_the_pages(get):
    """Dash would put all of them into each, for its scripts to look for what callbacks name."""
    document = get("/").text
    assert len(document) < 20_000
    assert "explore-path" not in document


def ids_in(part):
    """Every id in a tree as the browser gets it."""
    if isinstance(part, dict):
        yield from [part["id"]] if isinstance(part.get("id"), str) else []
        for value in part.values():
            yield from ids_in(value)
    elif isinstance(part, list):
        for value in part:
            yield from ids_in(value)


def test_what_callbacks_name_stands_on_a_page(get):
    """What Dash's scripts would look for."""
    there = set(ids_in(json.loads(get("/_dash-layout").text)))
    for page in PAGES:
        there |= set(ids_in(json.loads(to_json(page.layout()))))
    named = set()
    for callback in json.loads(get("/_dash-dependencies").text):
        named |= {part["id"] for part in (*callback["inputs"], *callback["state"])}
        named |= {
            output.split("@")[0].rpartition(".")[0] for output in re.split(r"\.{2,3}", callback["output"]) if output
        }
    assert len(named) > 50
    assert named - there == set()
