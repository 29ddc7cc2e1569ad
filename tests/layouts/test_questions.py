"""What the pages' scripts send is read as it is; all else is refused in the one shape, and nothing breaks."""

import json
from typing import get_args
from urllib.parse import parse_qsl

import msgspec
import pytest
from dash.development.base_component import Component
from hypothesis import given, settings
from hypothesis import strategies as st

from layouts import questions
from layouts.controls import controls_of
from layouts.desk import beginning
from layouts.pages.compare.answers import DESK as COMPARE
from layouts.pages.data.answers import DESK as DATA
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pages.track.answers import DESK as TRACK
from layouts.pages.tune.answers import DESK as TUNE
from layouts.questions import CONTROLS, LINK_LENGTH, TEXT_LIMIT, TEXT_LIMITS, page_reader, read_study_question
from layouts.site import PAGES
from layouts.state import LINK_LIMIT, Settings, to_query
from layouts.theme import THEMES
from tracker_core.checks import InputError

DESKS = (EXPLORE, STABILITY, TUNE, COMPARE, DATA, TRACK)
ON_EVERY_PAGE = pytest.mark.parametrize("desk", DESKS, ids=lambda desk: desk.page)
SHAPE = {"field", "rule", "received", "message", "request"}
TOKEN = "0123456789abcdef" * 2


def read(desk, question):
    return page_reader([*desk.plots, *desk.tables])(json.dumps(question))


def asked_first(desk, link=""):
    """What the page's script asks once the page is there."""
    begun = beginning(desk, dict(parse_qsl(link)))
    return {
        "seq": 1, "controls": begun["controls"], "changed": [], "pins": begun["pins"], "pinning": [], "drawn": {},
        "want": None, "theme": "light", "scene": "",
    }  # fmt: skip


def body(desk, question):
    """What Dash's script sends to have that answered."""
    places = [*((plot, "figure") for plot in desk.plots), *((place, "children") for place in desk.tables)]
    outputs = [{"id": place, "property": name} for place, name in [*places, (f"{desk.page}-answer", "data")]]
    return {
        "output": "..{}..".format("...".join(f"{each['id']}.{each['property']}" for each in outputs)),
        "outputs": outputs,
        "inputs": [{"id": f"{desk.page}-request", "property": "data", "value": question}],
        "changedPropIds": [f"{desk.page}-request.data"],
        "parsedChangedPropsIds": [f"{desk.page}-request.data"],
    }


PAGE_BODY = {
    "output": ".._pages_content.children..._pages_store.data..",
    "outputs": [{"id": "_pages_content", "property": "children"}, {"id": "_pages_store", "property": "data"}],
    "inputs": [
        {"id": "_pages_location", "property": "pathname", "value": "/tune"},
        {"id": "_pages_location", "property": "search", "value": "?xi=0.5"},
    ],
    "changedPropIds": ["_pages_location.pathname", "_pages_location.search"],
    "parsedChangedPropsIds": ["_pages_location.pathname", "_pages_location.search"],
}


@pytest.fixture(scope="module")
def post(http):
    return lambda asked: http("POST", "/_dash-update-component", json=asked)


# All that a page sends is a question ---------------------------------------------------------------------------------


@given(wanted=st.from_type(Settings))
def test_every_control_is_known(wanted):
    assert set(controls_of(wanted)) <= CONTROLS


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.NAME)
def test_every_control_of_a_page_is_known(page):
    given = {vars(part).get("data-control") for part in page.layout()._traverse() if isinstance(part, Component)}
    assert given - {None} <= CONTROLS


def test_themes_are_those_of_the_plots():
    assert get_args(questions.Theme) == THEMES


@settings(max_examples=50)
@given(wanted=st.from_type(Settings), theme=st.sampled_from(THEMES), seq=st.integers(0, 2**53), scene=st.just(TOKEN))
def test_what_stands_on_a_page_is_read_as_it_is(wanted, theme, seq, scene):
    question = {
        "seq": seq, "controls": controls_of(wanted), "changed": sorted(CONTROLS),
        "pins": [[pin.slot, pin.text()] for pin in wanted.pins], "theme": theme, "scene": scene,
        "pinning": [["add"], ["start"], ["remove", 3], ["use", 1], ["rename", 6, "name"]],
        "drawn": dict.fromkeys(EXPLORE.plots, "key"), "want": [*EXPLORE.plots, *EXPLORE.tables],
        "link": to_query(wanted),
    }  # fmt: skip
    found = read(EXPLORE, question)
    again = msgspec.json.decode(msgspec.json.encode(found))
    assert [list(filter(None, action)) for action in again.pop("pinning")] == question.pop("pinning")
    assert again == json.loads(json.dumps(question))
    study = read_study_question(json.dumps({"seq": seq, "query": to_query(wanted), "theme": theme, "stop": True}))
    assert (study.seq, study.query, study.theme, study.stop, study.look) == (seq, to_query(wanted), theme, True, False)


def test_links_of_ours_are_far_shorter_than_what_is_read():
    assert LINK_LIMIT <= LINK_LENGTH / 4


@ON_EVERY_PAGE
def test_the_first_question_of_a_page_is_answered(post, desk):
    answered = post(body(desk, asked_first(desk, "xi=0.5&samples=60&pin2=kalata")))
    assert answered.status_code == 200
    rest = answered.json()["response"][f"{desk.page}-answer"]["data"]
    assert (rest["ok"], rest["controls"]["xi"]) == (True, 0.5)


@ON_EVERY_PAGE
@pytest.mark.parametrize("number", [2**63, -(2**63) - 1, 10**20, -(10**300)])
def test_a_number_that_no_answer_could_hold_is_wrong_in_its_place(post, talk, desk, number):
    question = asked_first(desk) | {"changed": ["seed"]}
    question["controls"]["seed"] = number
    answered = post(body(desk, question))
    assert answered.status_code == 200
    _, said = talk(json.dumps(question), path=f"/{desk.page}/live")
    moved = json.loads(said["bytes"][4 : 4 + int.from_bytes(said["bytes"][:4], "little")])
    for rest in (answered.json()["response"][f"{desk.page}-answer"]["data"], moved):
        assert (rest["ok"], rest["errors"].keys(), rest["controls"]["seed"]) == (False, {"seed"}, float(number))


@pytest.mark.parametrize("number", [2**63 - 1, -(2**63)])
def test_a_number_that_an_answer_can_hold_stays_whole(number):
    question = asked_first(EXPLORE)
    question["controls"]["seed"] = number
    held = read(EXPLORE, question).controls["seed"]
    assert (type(held), held) == (int, number)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.NAME)
@pytest.mark.parametrize("search", ["", "?", "?xi=0.5&xi=0.6", "?nonsense", "?function=1&self=2&func=3&data=x", "no"])
def test_every_page_is_laid_out_for_any_link(post, page, search):
    values = [{**given, "value": value} for given, value in zip(PAGE_BODY["inputs"], (page.PATH, search), strict=True)]
    answered = post({**PAGE_BODY, "inputs": values})
    assert answered.status_code == 200
    assert answered.json()["response"]["_pages_store"]["data"]["title"] == page.TITLE


# Nothing else is -----------------------------------------------------------------------------------------------------

WRONG = {
    "no number": ("question", {"seq": ...}),
    "a number that is none": ("seq", {"seq": "1"}),
    "a number below zero": ("seq", {"seq": -1}),
    "no controls": ("question", {"controls": ...}),
    "a control that there is not": ("controls", {"controls": {"gamma_ray": 1}}),
    "a control in a list": ("controls[...]", {"controls": {"alpha": [1]}}),
    "a control that is true": ("controls[...]", {"controls": {"alpha": True}}),
    "a number too long": ("controls.alpha", {"controls": {"alpha": 10**400}}),
    "a text too long": ("controls.alpha", {"controls": {"alpha": "1" * (TEXT_LIMIT + 1)}}),
    "poles too long": ("controls.pole", {"controls": {"pole": "1" * (TEXT_LIMITS["pole"] + 1)}}),
    "a reading too long": ("controls.reading", {"controls": {"reading": "1" * (TEXT_LIMITS["reading"] + 1)}}),
    "a change of nothing": ("changed", {"changed": ["gamma_ray"]}),
    "too many changes": ("changed", {"changed": ["alpha"] * (len(CONTROLS) + 1)}),
    "a seventh slot": ("pins[0][0]", {"pins": [[7, "kalata"]]}),
    "a pin without a text": ("pins[0]", {"pins": [[1]]}),
    "seven pins": ("pins", {"pins": [[1, "kalata"]] * 7}),
    "an action that is none": ("pinning[0][0]", {"pinning": [["shred"]]}),
    "an action of no slot": ("pinning[0][1]", {"pinning": [["remove", "1"]]}),
    "a plot of another page": ("want", {"want": ["stability-map"]}),
    "a drawing of another page": ("drawn", {"drawn": {"stability-map": ""}}),
    "no plot": ("want[0]", {"want": [None]}),
    "another theme": ("theme", {"theme": "sepia"}),
    "half a token": ("scene", {"scene": TOKEN[:16]}),
    "a token and more": ("scene", {"scene": TOKEN + "\n"}),
    "more": ("question", {"more": 1}),
}


@pytest.mark.parametrize(("field", "wrong"), WRONG.values(), ids=WRONG)
def test_what_is_no_question_is_refused_by_its_part(field, wrong):
    question = {name: value for name, value in (asked_first(EXPLORE) | wrong).items() if value is not ...}
    with pytest.raises(InputError) as caught:
        read(EXPLORE, question)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("place", "value", "field"),
    [
        (0, "tune", "pathname"), (0, None, "pathname"), (0, "/" * 1_001, "pathname"), (1, 5, "search"),
        (1, ["?xi=1"], "search"), (1, "?" + "x" * LINK_LENGTH, "search"),
    ],
)  # fmt: skip
def test_an_address_that_cannot_be_is_refused(post, place, value, field):
    values = [dict(given) for given in PAGE_BODY["inputs"]]
    values[place]["value"] = value
    answered = post({**PAGE_BODY, "inputs": values})
    assert (answered.status_code, answered.json()["field"]) == (400, field)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=10)
    | st.sampled_from(["explore-request", "data", "alpha", "..", "x" * 700, 10**400, 2**63, -(10**20), -1]),
    lambda deeper: st.lists(deeper, max_size=3) | st.dictionaries(st.text(max_size=5), deeper, max_size=3),
    max_leaves=6,
)  # fmt: skip


def places_in(value, path=()):
    """The way to every part of a value of JSON, itself last."""
    children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, child in children:
        yield from places_in(child, (*path, name))
    yield path


def changed(value, path, become):
    """A copy with another thing at the end of a way; nothing there for ..."""
    if not path:
        return become
    copy = dict(value) if isinstance(value, dict) else list(value)
    if len(path) == 1 and become is ...:
        del copy[path[0]]
    else:
        copy[path[0]] = changed(copy[path[0]], path[1:], become)
    return copy


BODIES = [PAGE_BODY, *(body(desk, asked_first(desk, "samples=30&pin1=kalata")) for desk in (EXPLORE, COMPARE))]


@settings(max_examples=300)
@given(data=st.data())
def test_any_change_of_a_good_body_is_answered_or_refused(post, data):
    asked = data.draw(st.sampled_from(BODIES), label="body")
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from([*places_in(asked)][:-1]), label="place")
        asked = changed(asked, path, data.draw(st.just(...) | JSON, label="becomes"))
    answered = post(asked)
    assert answered.status_code in (200, 400)
    if answered.status_code == 400:
        assert answered.json().keys() == SHAPE


@settings(max_examples=100)
@given(asked=JSON)
def test_any_body_is_answered_or_refused(http, asked):
    answered = http(
        "POST", "/_dash-update-component", content=json.dumps(asked), headers={"Content-Type": "application/json"}
    )
    assert answered.status_code == 400
    assert answered.json().keys() == SHAPE


@settings(max_examples=150)
@given(data=st.data())
def test_any_change_of_a_good_message_is_answered_or_refused(talk, data):
    asked = asked_first(EXPLORE, "samples=30")
    for _ in range(data.draw(st.integers(1, 2))):
        path = data.draw(st.sampled_from([*places_in(asked)][:-1]), label="place")
        asked = changed(asked, path, data.draw(st.just(...) | JSON, label="becomes"))
    _, said, *closed = talk(json.dumps(asked))
    rest = json.loads(said["bytes"][4 : 4 + int.from_bytes(said["bytes"][:4], "little")])
    assert closed == [] if "ok" in rest else rest["problem"].keys() == SHAPE
    assert all(message["code"] == 1003 for message in closed)
