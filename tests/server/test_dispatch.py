"""Dash's callbacks asked as declared, or refused; of an application of two callbacks."""

import asyncio
import threading
from typing import Annotated

import httpx
import pytest
from dash import Dash, Input, Output, State
from fastapi.routing import APIWebSocketRoute
from msgspec import Meta, Struct

from server.dispatch import Dispatch, describe, finish
from server.typed import reader
from server.work import NoAnswerError, Work
from tracker_core.checks import InputError

SHAPE = {"field", "rule", "received", "message", "request"}
URL = "/_dash-update-component"


class Number(Struct, forbid_unknown_fields=True):
    """What the first input holds."""

    value: Annotated[int, Meta(ge=0)]


def made(describing=("in.data", "also.value")):
    """An application that answers "out" and "both", and one thing in the browser alone."""
    app = Dash("toy", backend=Dispatch)
    app.layout = []

    @app.callback(Output("out", "children"), Input("in", "data"), State("also", "value"))
    async def out(number, also):
        if number.value == 99:
            raise NoAnswerError(InputError("server", "must rest", 1), "it rests", 503, 7)
        return f"{type(number).__name__} {number.value} {also}"

    @app.callback(Output("both", "children"), Output("both", "title"), Input("in", "data"))
    def both(number):
        return number.value, threading.current_thread() is threading.main_thread()

    app.clientside_callback("a => a", Output("browser", "children"), Input("in", "data"))
    readers = {"in.data": reader(Number, "number"), "also.value": reader(str, "also")}
    for place in describing:
        describe(app, place, readers[place])
    finish(app, Work())
    return app


@pytest.fixture(scope="module")
def app():
    return made()


@pytest.fixture(scope="module")
def ask(app):
    def request(method, path, **more):
        async def once():
            transport = httpx.ASGITransport(app=app.server)
            async with httpx.AsyncClient(transport=transport, base_url="http://toy.test") as client:
                return await client.request(method, path, **more)

        return asyncio.run(once())

    return request


def given(place, **value):
    component, name = place.split(".")
    return {"id": component, "property": name, **value}


def body(**more):
    """As Dash's script asks for "out"."""
    return {
        "output": "out.children",
        "outputs": given("out.children"),
        "inputs": [given("in.data", value={"value": 5})],
        "changedPropIds": ["in.data"],
        "parsedChangedPropsIds": ["in.data"],
        "state": [given("also.value", value="x")],
        **more,
    }


def both(**more):
    outputs = [given("both.children"), given("both.title")]
    return body(output="..both.children...both.title..", outputs=outputs, state=[], **more)


def test_a_callback_is_given_what_is_described(ask):
    answer = ask("POST", URL, json=body())
    assert answer.status_code == 200
    assert answer.json()["response"] == {"out": {"children": "Number 5 x"}}


def test_one_that_does_not_await_runs_in_a_thread(ask):
    answer = ask("POST", URL, json=both())
    assert answer.status_code == 200
    assert answer.json()["response"] == {"both": {"children": 5, "title": False}}


def test_one_that_has_no_answer_says_when_to_ask_again(ask):
    answer = ask("POST", URL, json=body(inputs=[given("in.data", value={"value": 99})]))
    assert (answer.status_code, answer.headers["retry-after"]) == (503, "7")
    assert answer.json() == {
        "field": "server", "rule": "must rest", "received": "1", "message": "it rests", "request": "",
    }  # fmt: skip


WRONG = {
    "no such output": ("output", body(output="nowhere.children")),
    "one of the browser's": ("output", body(output="browser.children", outputs=given("browser.children"), state=[])),
    "an output of another kind": ("output", body(output=["out.children"])),
    "other outputs": ("outputs", body(outputs=given("both.children"))),
    "a list for one": ("outputs", body(outputs=[given("out.children")])),
    "one for a list": ("outputs", {**both(), "outputs": given("both.children")}),
    "outputs the other way round": ("outputs", {**both(), "outputs": both()["outputs"][::-1]}),
    "no outputs": ("body", {name: value for name, value in body().items() if name != "outputs"}),
    "no inputs": ("inputs", body(inputs=[])),
    "an input twice": ("inputs", body(inputs=body()["inputs"] * 2)),
    "another input": ("inputs", body(inputs=[given("out.children", value=1)])),
    "an input without a value": ("inputs[0]", body(inputs=[given("in.data")])),
    "no state": ("state", body(state=[])),
    "a state too many": ("state", {**both(), "state": body()["state"]}),
    "a change elsewhere": ("changedPropIds", body(changedPropIds=["also.value"], parsedChangedPropsIds=[])),
    "changes that are not the same": ("parsedChangedPropsIds", body(parsedChangedPropsIds=["also.value"])),
    "a wild card": ("inputs[0].id", body(inputs=[{"id": {"type": "in"}, "property": "data", "value": 1}])),
    "a value of another type": ("value", body(inputs=[given("in.data", value={"value": "5"})])),
    "a value out of range": ("value", body(inputs=[given("in.data", value={"value": -1})])),
    "a value with more": ("number", body(inputs=[given("in.data", value={"value": 5, "more": 1})])),
    "no value": ("number", body(inputs=[given("in.data", value=None)])),
    "a state of another type": ("also", body(state=[given("also.value", value=5)])),
    "more than Dash sends": ("body", body(more=1)),
    "a list": ("body", [body()]),
}


@pytest.mark.parametrize(("field", "asked"), WRONG.values(), ids=WRONG)
def test_what_is_not_as_declared_is_refused(ask, field, asked):
    answer = ask("POST", URL, json=asked)
    assert answer.status_code == 400
    assert answer.json().keys() == SHAPE
    assert answer.json()["field"] == field


@pytest.mark.parametrize(
    "content", ["", "{", "null", "[" * 100_000, b"\xff", '"\ud83d"'.encode("utf-8", "surrogatepass")]
)
def test_what_is_no_json_is_refused(ask, content):
    answer = ask("POST", URL, content=content, headers={"Content-Type": "application/json"})
    assert answer.status_code == 400
    assert answer.json()["field"] == "body"


@pytest.mark.parametrize("kind", ["", "text/plain", "application/x-www-form-urlencoded", "application/jsonp"])
def test_another_type_of_content_is_refused(ask, kind):
    answer = ask("POST", URL, content=b"{}", headers={"Content-Type": kind})
    assert answer.status_code == 415
    assert answer.json().keys() == SHAPE


def test_a_charset_may_be_named(ask):
    answer = ask("POST", URL, json=body(), headers={"Content-Type": "application/json; charset=utf-8"})
    assert answer.status_code == 200


@pytest.mark.parametrize("described", [["in.data"], ["also.value"], []])
def test_an_input_that_nothing_describes_stops_the_start(described):
    with pytest.raises(LookupError, match="nothing describes (also.value|in.data)"):
        made(described)


def test_dash_of_another_make_is_refused():
    with pytest.raises(TypeError, match="must be made with backend=Dispatch"):
        finish(Dash("other"), Work())


def test_there_is_no_socket_of_dash_s(app):
    assert not [route for route in app.server.routes if isinstance(route, APIWebSocketRoute)]
    assert "websocket" not in app._config()
