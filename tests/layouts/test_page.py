"""The pages before anything is computed: they fit their scripts, the rules and the experiment; and documentation."""

import ast
import json
import re
from functools import cache
from pathlib import Path

import pytest
from dash.development.base_component import Component
from hypothesis import given, settings
from hypothesis import strategies as st

import layouts
from layouts.components import GRAPH_CONFIG, table
from layouts.desk import answer, beginning, live_answer
from layouts.figures.handles import gains_handle, pole_handles
from layouts.filter_card import SLIDERS
from layouts.inputs import select_field
from layouts.pages import compare, data, explore, stability, track, tune
from layouts.pages.compare.answers import DESK as COMPARE
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import CARDS as STABILITY_CARDS
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pages.track.answers import DESK as TRACK
from layouts.pages.tune.answers import DESK as TUNE
from layouts.pages.tune.content import PLOT as STUDY_PLOT
from layouts.rules import SHARE
from layouts.run_cards import CARDS as RUN_CARDS
from layouts.run_cards import EVIDENCE_CARDS
from layouts.shell import frame
from layouts.state import BACKGROUNDS, EXAGGERATIONS, INPUTS
from tracker_core import CONVENTIONS, DESIGNS, METRICS, SCENARIOS, Gains
from tracker_core.experiment import PARAMETERS
from tracker_core.fields import FIELDS
from tracker_core.measured import AXES
from tracker_core.merits import MERITS
from tracker_core.types import GAIN_NAMES, STATE_NAMES

ROOT = Path(__file__).parents[2]
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


PAGES = (explore, stability, compare, track, tune)
DESKS = {"explore": EXPLORE, "stability": STABILITY, "compare": COMPARE, "track": TRACK, "tune": TUNE}
ON_EVERY_PAGE = pytest.mark.parametrize("name", DESKS)


@cache
def parts_of(name):
    """Every component of a page, from the top."""
    return list(walk(next(page for page in PAGES if page.__name__.endswith(name)).layout()))


@cache
def ids_of(name):
    """Every id of a page, those that the script makes included."""
    own = [attribute(part, key) for part in parts_of(name) for key in ("id", "data-id")]
    return [found for found in own if found]


def part_with(name, key, value):
    """The only component of a page that has an attribute of some value."""
    (part,) = (part for part in parts_of(name) if attribute(part, key) == value)
    return part


def beginning_of(name):
    return part_with(name, "id", f"{name}-beginning").data


def controls_on(name):
    """Every control of a page by name."""
    return {found for part in parts_of(name) if (found := attribute(part, "data-control"))}


def script(name):
    return (ROOT / "assets" / name).read_text(encoding="utf-8")


# Page and script ---------------------------------------------------------------------------------------------------


def test_no_two_elements_share_an_id(dash_app):
    """Neither on a page nor around it nor on different pages."""
    around = [found for part in walk(frame()) if (found := attribute(part, "id"))]
    ids = [*around, *(found for name in DESKS for found in ids_of(name))]
    assert len(ids) > 150
    assert sorted(set(ids)) == sorted(ids)


@ON_EVERY_PAGE
def test_every_id_of_a_page_begins_with_its_name(name):
    assert [found for found in ids_of(name) if found != name and not found.startswith(f"{name}-")] == []


# What a page may lack: the script looks before it speaks.
OPTIONAL = {"unpin"}


@ON_EVERY_PAGE
def test_the_script_finds_every_element_that_it_asks_for(name):
    desk = script("desk.js")
    named = set(re.findall(r"\belement\(\"([\w-]+)\"", desk))
    assert {"verdict", "offer", "unpin"} <= named
    for optional in OPTIONAL:
        assert f'if (element("{optional}"))' in desk
    assert {f"{name}-{found}" for found in named - OPTIONAL} - set(ids_of(name)) == set()
    # A message has a place everywhere.
    assert {f"{name}-{found}" for found in re.findall(r"\btext\(\"([\w-]+)\"", desk)} - set(ids_of(name)) == set()
    # Of every parameter a row and a place for the design's say.
    rows = re.findall(r"\b(?:element|text)\(`\$\{name\}-(row|owner)`", desk)
    assert sorted(rows) == ["owner", "row"]
    assert {f"{name}-{parameter}-{row}" for parameter in PARAMETERS for row in rows} <= set(ids_of(name))
    # What it hands to Dash.
    assert set(re.findall(r"set_props\(`\$\{page\.name\}-([\w-]+)`", desk)) == {"request"}
    assert f"{name}-request" in ids_of(name)


def test_every_button_that_the_script_listens_to_is_somewhere(dash_app):
    every = {found for name in DESKS for found in ids_of(name)}
    buttons = set(re.findall(r"button\.id === `\$\{page\.name\}-([\w-]+)`", script("desk.js")))
    assert buttons == {"pin", "unpin", "new-seed", "offer"}
    for button in buttons:
        assert any(f"{name}-{button}" in every for name in DESKS)
    around = {attribute(part, "id") for part in walk(frame())}
    sources = script("desk.js") + script("shell.js")
    asked = set(re.findall(r"button\.id === \"([\w-]+)\"", sources))
    asked |= set(re.findall(r"getElementById\(\"([a-z][\w-]*)\"\)", sources))
    assert {"undo", "redo", "copy-link", "copy-said", "theme-switch", "main"} == asked
    assert asked <= around


@ON_EVERY_PAGE
def test_page_and_answers_agree_on_the_plots(name):
    desk = DESKS[name]
    assert {attribute(part, "id") for part in parts_of(name) if type(part).__name__ == "Graph"} == set(desk.plots)
    places = [attribute(part, "data-tables") for part in parts_of(name) if attribute(part, "data-tables")]
    assert places == list(desk.tables)
    assert set(desk.tables) <= set(ids_of(name))


@ON_EVERY_PAGE
def test_the_answer_says_all_that_the_script_reads(controls_for, request_for, name):
    scripts = (
        script("desk.js") + script("compare.js") + script("figures.js") + (script("tune.js") if name == "tune" else "")
    )
    read = set(re.findall(r"\banswer\.(\w+)", scripts))
    question = request_for(controls_for())
    given_slow, given_live = set(answer(DESKS[name], question)[1]), set(live_answer(DESKS[name], question)[0])
    assert {"controls", "texts", "link", "handles", "offer"} <= read
    assert read - given_slow == {"lines", "outdated", "problem", "again"}
    assert read - given_live == {"drawn", "problem", "again"}
    # Whether or not the entries are right, these are read first.
    refusal = set(live_answer(DESKS[name], request_for(controls_for(), {"samples": "x"}))[0])
    assert {"seq", "ok", "controls", "errors", "note", "missing"} == refusal
    # And nothing is said that is not read.
    assert (given_slow | given_live) - read == set()


@ON_EVERY_PAGE
def test_the_script_begins_with_what_the_page_gives_it(name):
    desk = script("desk.js")
    read = set(re.findall(r"\bdata\.(\w+)", desk[desk.index("function begin") : desk.index("function finish")]))
    assert read == set(beginning_of(name))
    json.dumps(beginning_of(name), allow_nan=False)


def test_the_script_knows_how_each_slider_stands(controls_for, request_for):
    states = set(answer(EXPLORE, request_for(controls_for()))[1]["owned"].values())
    words = re.search(r"const words = \{(.*?)\}", script("desk.js"))[1]
    assert states == set(re.findall(r"(\w+):", words))


CARDS = {"explore": RUN_CARDS, "stability": STABILITY_CARDS, "compare": (), "track": (), "tune": RUN_CARDS}


@ON_EVERY_PAGE
def test_every_card_and_every_menu_offered_is_on_the_page(controls_for, request_for, name):
    rest = answer(DESKS[name], request_for(controls_for()))[1]
    cards = [attribute(part, "data-metric") for part in parts_of(name) if attribute(part, "data-metric")]
    assert list(CARDS[name]) == list(rest["cards"])
    # Where nobody knows the truth, others take their place.
    assert cards == [*CARDS[name], *(EVIDENCE_CARDS if CARDS[name] == RUN_CARDS else ())]
    # A page shows some of the menus, and together they show them all.
    menus = [attribute(p, "data-control") for n in DESKS for p in parts_of(n) if type(p).__name__ == "Select"]
    assert set(rest["offers"]) <= set(menus)
    for rows in rest["rows"]:
        assert type(part_with(name, "id", f"{name}-{rows}")).__name__ == "Tbody"
    assert set(rest["handles"]) <= {*DESKS[name].plots, *(found for found in ids_of(name) if found == STUDY_PLOT)}


def test_every_text_of_an_answer_has_a_place_and_every_place_a_text(controls_for, request_for):
    """An empty element with an id waits for something: a text of the answer or of a study, or one the script makes.

    A heading has a text of its own until an answer gives it another.
    """
    said, waiting = set(), set()
    # A study fills in places of its own: its texts, its plot, how far it has come.
    of_study = {"best", "cost", "runs", "plot", "study-text", "study-said", "forest", "runs-text"}
    for name, desk in DESKS.items():
        texts = set(answer(desk, request_for(controls_for()))[1]["texts"])
        said |= texts
        for part in parts_of(name):
            if type(part).__name__ == "H2" and attribute(part, "id"):
                waiting.add(attribute(part, "id").removeprefix(f"{name}-"))
            if type(part).__name__ in ("Span", "P", "Output", "Div") and attribute(part, "id"):
                place = attribute(part, "id").removeprefix(f"{name}-")
                if getattr(part, "children", None) is None and place not in {t.partition("-")[2] for t in desk.tables}:
                    waiting.add(place)
                    assert place in texts | {"note", "live"} | of_study or place.endswith(("-error", "-owner")), place
    assert said <= waiting


@ON_EVERY_PAGE
def test_every_figure_can_be_saved(name):
    frames = [part for part in parts_of(name) if "plot-frame" in str(attribute(part, "className")).split()]
    assert frames
    for frame_of in frames:
        inside = list(walk(frame_of))
        assert [attribute(part, "data-save") for part in inside if attribute(part, "data-save")] == ["svg", "png"]
        # The script looks for the one plot of the frame.
        assert sum("plot" in str(attribute(part, "className")).split() for part in inside) == 1


def test_the_handles_say_all_that_the_script_reads():
    read = set(re.findall(r"\bspec\.(\w+)", script("handles.js"))) | {"step"}
    assert ".spec.step" in script("handles.js")
    for handles in (
        gains_handle(Gains((0.5, 0.2)), ("alpha", "beta")),
        pole_handles((0.5 + 0.1j, 0.5 - 0.1j)),
    ):
        assert set(handles) == read
        assert handles["control"] in re.search(r"for \(const name of \[(.*?)\]", script("desk.js"))[1]


@pytest.mark.parametrize("name", ["stability", "track"])
def test_a_scene_has_the_parts_that_its_script_asks_for(name):
    place = part_with(name, "data-scene", name)
    assert attribute(place, "data-title").strip()
    (card,) = (part for part in parts_of(name) if type(part).__name__ == "Section" and place in list(walk(part)))
    asked = set(re.findall(r"part\(\"(\w+)\"\)", script("scene.js")))
    asked |= set(re.findall(r"dataset\.part === \"(\w+)\"", script("scene.js")))
    assert asked == {"missing", "refused", "again", "resume", "show", "play", "speed"}
    found = {attribute(part, "data-part") for part in walk(card)} - {None}
    assert found == (asked if name == "track" else asked - {"play", "speed"})


# Controls ----------------------------------------------------------------------------------------------------------


@ON_EVERY_PAGE
def test_there_is_a_control_for_every_value_and_no_other(name):
    # Which file it is, and how it is read, is set by other means.
    values = set(beginning_of(name)["controls"]) - {"written", "data", "reading"}
    assert controls_on(name) <= values
    # Every page has the filter, and between them they have everything.
    assert {"preset", "order", "convention", "design", "responsiveness", *PARAMETERS} <= controls_on(name)
    assert set().union(*map(controls_on, DESKS)) == values
    assert set(FIELDS) - {"data", "reading"} <= values


@ON_EVERY_PAGE
def test_every_placeholder_becomes_an_input_of_a_control(name):
    places = [part for part in parts_of(name) if attribute(part, "data-input")]
    assert len(places) >= 13
    for part in places:
        control = attribute(part, "data-control")
        assert control in beginning_of(name)["controls"]
        kind = attribute(part, "data-input")
        ending = {"box": "", "switch": "", "slider": "-slider", "radio": f"-{attribute(part, 'data-value')}"}[kind]
        assert attribute(part, "data-id") == f"{name}-{control}{ending}"
        # What the script finds the travel of a slider by.
        assert kind != "slider" or control in {*beginning_of(name)["sliders"], "at"}
    for part in parts_of(name):
        if type(part).__name__ == "Select" and attribute(part, "data-control"):
            assert attribute(part, "id") == f"{name}-{attribute(part, 'data-control')}"


@ON_EVERY_PAGE
def test_every_label_belongs_to_something_and_every_field_has_a_place_for_its_error(name):
    labels = [part for part in parts_of(name) if type(part).__name__ == "Label"]
    assert len(labels) > 10
    for label in labels:
        assert attribute(label, "htmlFor") in ids_of(name)
        assert text_of(label).strip()
    # The sample looked at is never wrong: what is none of the run's is its middle.
    for control in controls_on(name) - {"at"}:
        assert attribute(part_with(name, "id", f"{name}-{control}-error"), "role") == "alert"


@ON_EVERY_PAGE
def test_what_has_no_visible_label_has_a_spoken_one(name):
    for part in parts_of(name):
        if attribute(part, "data-input"):
            assert attribute(part, "data-label").strip()
        if attribute(part, "role") in ("img", "region", "figure"):
            assert attribute(part, "aria-label").strip()
        if type(part).__name__ == "Button" and attribute(part, "id") != f"{name}-offer":
            assert (attribute(part, "aria-label") or text_of(part)).strip()
        if type(part).__name__ == "Select" and not attribute(part, "data-control"):
            assert attribute(part, "aria-label").strip()


CHOICES = {
    **{name: list(field.choices) for name, field in FIELDS.items() if field.choices},
    "plane": ["alpha-beta", "alpha-gamma", "beta-gamma", "alpha-eta", "beta-eta", "gamma-eta"],
    "background": list(BACKGROUNDS),
    "input": list(INPUTS),
    "exaggerate": list(EXAGGERATIONS),
    "quantity": list(STATE_NAMES),
    "axis": list(dict.fromkeys([*(axis for scenario in SCENARIOS.values() for axis in scenario.axes), *AXES])),
}


@pytest.mark.parametrize("control", CHOICES)
def test_a_menu_has_every_choice_of_its_field(control):
    menus = [part_with(name, "data-control", control) for name in DESKS if control in controls_on(name)]
    assert menus
    for menu in menus:
        options = [part for part in walk(menu) if type(part).__name__ == "Option"]
        assert sorted(attribute(option, "value") for option in options) == sorted(map(str, CHOICES[control]))
        titles = [text_of(option) for option in options]
        assert len(set(titles)) == len(titles)
        assert all(titles)


@ON_EVERY_PAGE
def test_every_menu_holds_the_value_that_it_shows(name):
    for part in parts_of(name):
        if type(part).__name__ == "Select" and attribute(part, "data-control"):
            values = [attribute(option, "value") for option in walk(part) if type(option).__name__ == "Option"]
            assert str(beginning_of(name)["controls"][attribute(part, "data-control")]) in values


def test_menus_can_be_divided_by_headings():
    field = select_field("p", "n", "L", "S", [("", "–"), ("a", "A"), ("b", "B"), ("c", "C")], ["", "One", "One", "Two"])
    select = next(part for part in walk(field) if type(part).__name__ == "Select")
    shape = [(type(part).__name__, attribute(part, "label") or attribute(part, "value")) for part in walk(select)][1:]
    assert shape == [
        ("Option", ""), ("Optgroup", "One"), ("Option", "a"), ("Option", "b"), ("Optgroup", "Two"), ("Option", "c"),
    ]  # fmt: skip


@pytest.mark.parametrize("name", [*PARAMETERS, "responsiveness"])
def test_a_slider_reaches_every_value_that_makes_sense(name):
    span = SLIDERS[name]
    for convention in CONVENTIONS.values():
        factor = convention.factors[GAIN_NAMES.index(name)] if name in GAIN_NAMES else 1
        assert span.get("factors", {}).get(convention.name, 1) == factor
    domains = [design.parameters[name] for design in DESIGNS.values() if name in design.parameters]
    for domain in domains:
        low, high = max(span["low"], 1e-9), min(span["high"], domain.high)
        assert (low + high) / 2 in domain
    if name == "xi":
        assert span["high"] in domains[0]
    if name == "responsiveness":
        assert (span["low"], span["high"]) == (SHARE.low, SHARE.high)
    if span["curve"] == "log":
        assert span["low"] > 0


@pytest.mark.parametrize("page", [*PAGES, data], ids=lambda page: page.NAME)
def test_what_explains_a_field_is_told_with_its_control(page):
    """Of inputs the script does it, by the same ids."""
    name, parts = page.__name__.rpartition(".")[2], list(walk(page.layout()))
    with_id = {found: part for part in parts for key in ("id", "data-id") if (found := attribute(part, key))}
    labels = [part for part in parts if type(part).__name__ == "Label" and attribute(part, "className") == "tip"]
    assert len(labels) > 15
    for label in labels:
        control = with_id[attribute(label, "htmlFor")]
        about = f"{name}-{attribute(control, 'data-control')}-about"
        assert text_of(with_id[about])
        assert attribute(with_id[about], "hidden")
        if type(control).__name__ == "Select":
            told, error = attribute(control, "aria-describedby").split()
            assert told == about
            assert attribute(with_id[error], "role") == "alert"
    assert '["about", "error"]' in script("desk.js")


@ON_EVERY_PAGE
def test_what_changes_all_the_time_is_not_read_out(name):
    for part in parts_of(name):
        if type(part).__name__ == "Output":
            assert attribute(part, "aria-live") == "off"
    if any(attribute(part, "data-study") is not None for part in parts_of(name)):
        assert attribute(part_with(name, "id", f"{name}-study-text"), "role") is None
        assert attribute(part_with(name, "id", f"{name}-study-said"), "role") == "status"


@ON_EVERY_PAGE
def test_sentences_are_sentences(name):
    tips = {attribute(part, "data-tip") for part in parts_of(name)} - {None}
    tips |= {text_of(part) for part in parts_of(name) if str(attribute(part, "id")).endswith("-about")}
    assert len(tips) > 15
    for sentence in tips:
        assert sentence[0].isupper()
        assert sentence.strip() == sentence
    for metric in [*METRICS.values(), *MERITS.values()]:
        assert metric.sentence.endswith((".", ")"))


def test_a_table_names_its_rows_and_columns():
    parts = list(walk(table("Caption", ["", "a"], [["row", "1"], ["other", "2"]])))
    scopes = [attribute(part, "scope") for part in parts if type(part).__name__ == "Th"]
    assert scopes == ["col", "col", "row", "row"]
    frame_ = parts[0]
    assert (attribute(frame_, "tabIndex"), attribute(frame_, "role")) == (0, "region")
    assert attribute(frame_, "aria-label") == "Caption"


# What a link does to the page --------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.NAME)
@settings(max_examples=40)
@given(query=st.dictionaries(st.text(max_size=20), st.text(max_size=40) | st.lists(st.text(max_size=5), max_size=2)))
def test_no_link_breaks_the_page(page, query):
    """A field given twice arrives as a list."""
    data = next(part.data for part in walk(page.layout(**query)) if attribute(part, "id").endswith("-beginning"))
    assert json.loads(json.dumps(data, allow_nan=False)) == data


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.NAME)
def test_a_field_given_twice_is_named(page):
    data = beginning(DESKS[page.__name__.rpartition(".")[2]], {"seed": ["1", "2"], "limit_lag": ["1", "2"]})
    assert data["controls"]["seed"] == 1
    assert data["controls"]["limit_lag"] == ""
    assert [note.split()[0] for note in data["notes"]] == ["seed", "limit_lag"]


# Around the page ---------------------------------------------------------------------------------------------------


def test_the_frame_holds_the_page_and_the_buttons(dash_app):
    parts = list(walk(frame()))
    assert {"main", "copy-link", "theme-switch", "undo", "redo"} <= {attribute(part, "id") for part in parts}
    assert [type(part).__name__ for part in parts if type(part).__name__ in ("Header", "Main")] == ["Header", "Main"]
    for button in (part for part in parts if type(part).__name__ == "Button" and attribute(part, "id") != "copy-link"):
        assert attribute(button, "aria-label").strip()


def test_every_page_can_be_gone_to(dash_app):
    links = [part for part in walk(frame()) if type(part).__name__ == "Link"]
    assert [(text_of(link), attribute(link, "href")) for link in links] == [
        ("Explore", "/"), ("Stability", "/stability"), ("Tune", "/tune"), ("Compare", "/compare"), ("Data", "/data"),
        ("3-D", "/3d"), ("Papers", "/papers"), ("Learn", "/learn"),
    ]  # fmt: skip
    for link in links:
        # What the script finds them by, so that those of pages with a filter carry the present one.
        carries = " carries" if text_of(link) not in ("Papers", "Learn") else ""
        assert attribute(link, "className") == f"page-link{carries}"
        assert re.fullmatch(r"[a-z][\w-]*", attribute(link, "id"))


def test_the_scripts_find_the_links_of_the_pages():
    assert 'querySelectorAll(".page-link.carries")' in script("desk.js")
    assert 'querySelectorAll(".page-link")' in script("shell.js")


def test_pages_have_names_and_titles_of_their_own():
    for said in ("PATH", "NAME", "TITLE"):
        assert len({getattr(page, said) for page in PAGES}) == len(PAGES)


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
    """Classes of our own data list their attributes."""
    for path in MODULES:
        for name, node in public_definitions(path):
            if isinstance(node, ast.ClassDef) and any("dataclass" in ast.dump(mark) for mark in node.decorator_list):
                fields = [part.target.id for part in node.body if isinstance(part, ast.AnnAssign)]
                doc = ast.get_docstring(node)
                # Several of a kind may share a line.
                missing = [field for field in fields if not re.search(rf"\b{field}(, \w+)*:", doc) and len(fields) > 3]
                assert missing == [], f"{path.name}: {name}"


def test_no_plot_offers_to_send_itself_to_another_server():
    assert "sendChartToCloud" in GRAPH_CONFIG["modeBarButtonsToRemove"]
    assert GRAPH_CONFIG["plotlyServerURL"] == ""
    config = script("study.js").partition("const CONFIG = {")[2].partition("};")[0]
    buttons = re.search(r"modeBarButtonsToRemove: (\[.*?\])", config)[1]
    assert json.loads(buttons) == GRAPH_CONFIG["modeBarButtonsToRemove"]
    assert 'plotlyServerURL: ""' in config
