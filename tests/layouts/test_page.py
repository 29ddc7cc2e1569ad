"""The page before anything is computed: it fits its script, the rules and the experiment; and documentation."""

import ast
import json
import re
from pathlib import Path

import pytest
from dash.development.base_component import Component
from hypothesis import given
from hypothesis import strategies as st

import layouts
from layouts.components import select_field, table
from layouts.controls import controls_of, resolve
from layouts.pages.explore.answers import CARDS, NUMBERS, PLOTS, answer, live_answer
from layouts.pages.explore.view import SLIDERS, layout
from layouts.shell import frame
from layouts.state import from_query
from tracker_core import CONVENTIONS, DESIGNS, METRICS, Experiment
from tracker_core.experiment import PARAMETERS
from tracker_core.fields import FIELDS

ROOT = Path(__file__).parents[2]
SCRIPT = (ROOT / "assets" / "explore.js").read_text(encoding="utf-8")
MODULES = sorted(Path(layouts.__file__).parent.glob("**/*.py"))


def walk(part):
    """Every component of a tree, from the top."""
    if isinstance(part, list | tuple):
        for child in part:
            yield from walk(child)
    elif isinstance(part, Component):
        yield part
        yield from walk(getattr(part, "children", None))


def text_of(part):
    """All text under a component."""
    if isinstance(part, str):
        return part
    if isinstance(part, list | tuple):
        return "".join(text_of(child) for child in part)
    return text_of(getattr(part, "children", "") or "") if isinstance(part, Component) else ""


def attribute(part, name):
    """An attribute, also of those that Python cannot name."""
    return part.to_plotly_json()["props"].get(name)


@pytest.fixture(scope="module")
def page():
    return list(walk(layout()))


@pytest.fixture(scope="module")
def ids(page):
    """Every id of the page, those that the script makes included."""
    own = [attribute(part, "id") for part in page] + [attribute(part, "data-id") for part in page]
    return [name for name in own if name]


@pytest.fixture(scope="module")
def beginning(page):
    return next(part.data for part in page if attribute(part, "id") == "explore-beginning")


# Page and script ---------------------------------------------------------------------------------------------------


def test_ids_are_unique(ids):
    assert sorted(set(ids)) == sorted(ids)


def test_the_script_finds_every_element_that_it_asks_for(ids):
    named = set(re.findall(r"\b(?:element|text)\(\"([\w-]+)\"", SCRIPT))
    asked = {f"explore-{name}" for name in named}
    asked |= set(re.findall(r"getElementById\(\"([\w-]+)\"\)", SCRIPT)) | set(
        re.findall(r"\.id (?:!|=)== \"([\w-]+)\"", SCRIPT)
    )
    asked |= set(re.findall(r"set_props\(\"([\w-]+)\"", SCRIPT))
    assert len(asked) > 12
    assert asked - set(ids) == set()


def test_page_script_and_answers_agree_on_the_plots(page, ids):
    listed = {
        name: re.findall(r"\"([\w-]+)\"", re.search(rf"const {name} = \[(.*?)\]", SCRIPT, re.DOTALL)[1])
        for name in ("ALWAYS", "OTHERS")
    }
    assert sorted(listed["ALWAYS"] + listed["OTHERS"]) == sorted(PLOTS)
    assert {attribute(part, "id") for part in page if type(part).__name__ == "Graph"} == set(PLOTS)
    assert f'const NUMBERS = "{NUMBERS}"' in SCRIPT
    assert NUMBERS in ids


def test_the_answer_says_all_that_the_script_reads(controls_for, request_for):
    read = set(re.findall(r"\banswer\.(\w+)", SCRIPT))
    question = request_for(controls_for())
    given_slow, given_live = set(answer(question)[1]), set(live_answer(question)[0])
    assert {"controls", "status", "link"} <= read
    assert read - given_slow == {"lines", "outdated"}
    assert read - given_live == {"drawn"}
    # Whether or not the entries are right, these are read first.
    refusal = set(live_answer(request_for(controls_for(), {"samples": "x"}))[0])
    assert {"seq", "ok", "controls", "errors", "note"} == refusal


def test_the_script_begins_with_what_the_page_gives_it(beginning):
    read = set(re.findall(r"\bdata\.(\w+)", SCRIPT[SCRIPT.index("function begin") : SCRIPT.index("function finish")]))
    assert read == set(beginning)
    json.dumps(beginning, allow_nan=False)


def test_the_script_knows_how_each_slider_stands(controls_for, request_for):
    states = set(answer(request_for(controls_for()))[1]["owned"].values())
    words = re.search(r"const words = \{(.*?)\}", SCRIPT)[1]
    assert states == set(re.findall(r"(\w+):", words))


def test_every_card_and_every_menu_offered_is_on_the_page(page, controls_for, request_for):
    rest = answer(request_for(controls_for()))[1]
    assert [attribute(part, "data-metric") for part in page if attribute(part, "data-metric")] == list(CARDS)
    menus = {attribute(part, "data-control") for part in page if type(part).__name__ == "Select"}
    assert set(rest["offers"]) <= menus


# Controls ----------------------------------------------------------------------------------------------------------


def test_there_is_a_control_for_every_value_and_no_other(page, beginning):
    controls = {attribute(part, "data-control") for part in page} - {None}
    assert controls == set(beginning["controls"]) - {"written"}
    assert set(FIELDS) <= controls


def test_every_label_belongs_to_something_and_every_field_has_a_place_for_its_error(page, ids):
    labels = [part for part in page if type(part).__name__ == "Label"]
    assert len(labels) > 15
    for label in labels:
        assert attribute(label, "htmlFor") in ids
        assert text_of(label).strip()
    for name in FIELDS:
        place = next(part for part in page if attribute(part, "id") == f"explore-{name}-error")
        assert attribute(place, "role") == "alert"


def test_what_has_no_visible_label_has_a_spoken_one(page):
    for part in page:
        if attribute(part, "data-input"):
            assert attribute(part, "data-label").strip()
        if attribute(part, "role") in ("img", "region"):
            assert attribute(part, "aria-label").strip()
        if type(part).__name__ == "Button":
            assert (attribute(part, "aria-label") or text_of(part)).strip()


@pytest.mark.parametrize("name", [name for name, field in FIELDS.items() if field.choices])
def test_a_menu_has_every_choice_of_its_field(page, name):
    select = next(part for part in page if attribute(part, "data-control") == name)
    options = [part for part in walk(select) if type(part).__name__ == "Option"]
    assert [attribute(option, "value") for option in options] == list(FIELDS[name].choices)
    titles = [text_of(option) for option in options]
    assert len(set(titles)) == len(titles)
    assert all(titles)


def test_every_menu_holds_the_value_that_it_shows(page, beginning):
    for part in page:
        if type(part).__name__ == "Select":
            values = [attribute(option, "value") for option in walk(part) if type(option).__name__ == "Option"]
            assert str(beginning["controls"][attribute(part, "data-control")]) in values


def test_menus_can_be_divided_by_headings():
    field = select_field("p", "n", "L", "S", [("", "–"), ("a", "A"), ("b", "B"), ("c", "C")], ["", "One", "One", "Two"])
    select = next(part for part in walk(field) if type(part).__name__ == "Select")
    shape = [(type(part).__name__, attribute(part, "label") or attribute(part, "value")) for part in walk(select)][1:]
    assert shape == [
        ("Option", ""), ("Optgroup", "One"), ("Option", "a"), ("Option", "b"), ("Optgroup", "Two"), ("Option", "c"),
    ]  # fmt: skip


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_slider_reaches_every_value_that_makes_sense(name):
    span = SLIDERS[name]
    for convention in CONVENTIONS.values():
        index = PARAMETERS.index(name)
        factor = convention.factors[index] if index < 4 else 1
        assert span.get("factors", {}).get(convention.name, 1) == factor
    domains = [design.parameters[name] for design in DESIGNS.values() if name in design.parameters]
    for domain in domains:
        low, high = max(span["low"], 1e-9), min(span["high"], domain.high)
        assert (low + high) / 2 in domain
    if name == "xi":
        assert span["high"] in domains[0]
    if span["curve"] == "log":
        assert span["low"] > 0


def test_sentences_are_sentences(page):
    tips = {attribute(part, "data-tip") for part in page} - {None}
    assert len(tips) > 20
    for sentence in tips:
        assert sentence[0].isupper()
        assert sentence.strip() == sentence
    for metric in METRICS.values():
        assert metric.sentence.endswith((".", ")"))


def test_a_table_names_its_rows_and_columns():
    parts = list(walk(table("Caption", ["", "a"], [["row", "1"], ["other", "2"]])))
    scopes = [attribute(part, "scope") for part in parts if type(part).__name__ == "Th"]
    assert scopes == ["col", "col", "row", "row"]
    frame_ = parts[0]
    assert (attribute(frame_, "tabIndex"), attribute(frame_, "role")) == (0, "region")
    assert attribute(frame_, "aria-label") == "Caption"


# What a link does to the page --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "query",
    [
        {},
        {"scenario": "garg-accelerating", "seed": "3"},
        {"order": "2", "xi": "0.5", "axis": "y", "at": "7", "pin": "default"},
        {"samples": "2", "colour": "red", "pin": "seed=x"},
    ],
    ids=str,
)
def test_the_page_begins_as_the_link_says(query):
    data = next(part.data for part in walk(layout(**query)) if attribute(part, "id") == "explore-beginning")
    settings, notes = from_query(query)
    assert data["controls"] == controls_of(settings)
    assert data["notes"] == notes
    assert (Experiment.from_dict(data["pin"]) if data["pin"] else None) == settings.pin
    # The script sends them back as its first question.
    got = resolve(json.loads(json.dumps(data["controls"])), [], data["pin"])
    assert got.settings == settings


@given(query=st.dictionaries(st.text(max_size=20), st.text(max_size=40) | st.lists(st.text(max_size=5), max_size=2)))
def test_no_link_breaks_the_page(query):
    """A field given twice arrives as a list."""
    data = next(part.data for part in walk(layout(**query)) if attribute(part, "id") == "explore-beginning")
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_a_field_given_twice_is_named(page):
    data = next(part.data for part in walk(layout(seed=["1", "2"])) if attribute(part, "id") == "explore-beginning")
    assert data["controls"]["seed"] == 1
    assert [note.split()[0] for note in data["notes"]] == ["seed"]


# Around the page ---------------------------------------------------------------------------------------------------


def test_the_frame_holds_the_page_and_the_two_buttons(dash_app):
    parts = list(walk(frame()))
    assert {"main", "copy-link", "theme-switch"} <= {attribute(part, "id") for part in parts}
    assert [type(part).__name__ for part in parts if type(part).__name__ in ("Header", "Main")] == ["Header", "Main"]
    for script in ("copy-link", "theme-switch"):
        assert f'"{script}"' in (ROOT / "assets" / "shell.js").read_text(encoding="utf-8")


# Documentation -----------------------------------------------------------------------------------------------------


def public_definitions(path):
    """Every public function, class and method of a file, as (name, node)."""

    def search(node, prefix):
        for child in node.body:
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and child.name[0] != "_":
                yield prefix + child.name, child
                if isinstance(child, ast.ClassDef):
                    yield from search(child, f"{prefix}{child.name}.")

    return list(search(ast.parse(path.read_text(encoding="utf-8")), ""))


DEFINITIONS = [
    pytest.param(node, id=f"{path.relative_to(ROOT)}:{name}")
    for path in [*MODULES, ROOT / "app.py"]
    for name, node in public_definitions(path)
]


def test_the_search_for_definitions_finds_them():
    names = {parameter.id for parameter in DEFINITIONS}
    assert {"layouts/controls.py:resolve", "layouts/state.py:View.cursor", "app.py:build"} <= names


@pytest.mark.parametrize("node", DEFINITIONS)
def test_everything_public_is_documented(node):
    doc = ast.get_docstring(node)
    assert doc
    first = doc.splitlines()[0]
    assert first.endswith((".", ";", ":"))
    assert len(first) > 10


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_file_says_what_it_is_for(path):
    assert len(ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "") > 20


def test_every_field_of_what_is_passed_around_is_explained():
    """Classes of data list their attributes."""
    for path in MODULES:
        for name, node in public_definitions(path):
            if isinstance(node, ast.ClassDef):
                fields = [part.target.id for part in node.body if isinstance(part, ast.AnnAssign)]
                doc = ast.get_docstring(node)
                missing = [field for field in fields if f"{field}:" not in doc and len(fields) > 3]
                assert missing == [], f"{path.name}: {name}"
