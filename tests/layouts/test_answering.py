"""Answers by a helper are those that are computed here, byte for byte."""

import asyncio
import json
import pickle
import signal
import subprocess
import sys
import threading
from dataclasses import replace

import msgspec
import numpy as np
import orjson
import pytest
from dash._utils import to_json

from layouts.answering import KINDS, found_by_helper, give, outputs
from layouts.desk import answer
from layouts.helper import DESKS
from layouts.questions import Question
from layouts.services import Services
from server import metrics
from server.helpers import HelperGoneError, frame
from server.work import Work

TOKEN = "0123456789abcdef" * 2
ANSWER = msgspec.msgpack.Decoder(tuple[bool, bytes]).decode
FOUND = msgspec.msgpack.Decoder(tuple[bytes, bytes, float]).decode


class Asked:
    """A helper as the server starts it."""

    def __init__(self):
        command = [sys.executable, "-m", "layouts.helper", "json", "info"]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        assert self.said() == (True, b"")

    def said(self):
        length = int.from_bytes(self.process.stdout.read(4), "little")
        return ANSWER(self.process.stdout.read(length))

    def ask(self, name, question):
        self.process.stdin.write(frame((name, msgspec.json.encode(question))))
        self.process.stdin.flush()
        return self.said()


@pytest.fixture(scope="module")
def helper():
    asked = Asked()
    with asked.process as process:
        yield asked
        process.kill()


@pytest.fixture(scope="module")
def question(controls_for, request_for):
    """A question that a page with such plots asks, all of which it shows already."""

    def make(desk, moved=None, **more):
        _, rest = answer(desk, request_for(controls_for()))
        return request_for(controls_for(), moved or {"xi": 0.613}, drawn=rest["drawn"], scene="", **more)

    return make


def without_picture(desk):
    return replace(desk, show=None)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("desk", DESKS, ids=lambda desk: desk.page)
def test_a_helper_answers_as_the_server_does(helper, question, desk, kind):
    for moved in ({"xi": 0.613}, {"order": "2"}, {"xi": "much"}):
        asked = question(desk, moved, want=list(desk.plots))
        right, found = helper.ask(f"{desk.page} {kind}", asked)
        assert right
        message, picture, seconds = FOUND(found)
        assert seconds > 0
        assert message == KINDS[kind](without_picture(desk), asked)
        assert picture == b""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("desk", [desk for desk in DESKS if desk.picture], ids=lambda desk: desk.page)
def test_the_picture_for_a_scene_comes_with_the_answer(helper, question, desk, kind):
    asked = msgspec.structs.replace(question(desk), scene=TOKEN)
    shown = []
    message = KINDS[kind](replace(desk, show=lambda *seen: shown.append(seen)), asked)
    found, picture, _ = FOUND(helper.ask(f"{desk.page} {kind}", asked)[1])
    assert found == message
    [(token, here)] = shown
    assert token == TOKEN
    there = pickle.loads(picture)
    assert type(there) is type(here)
    for name in type(here).__dataclass_fields__:
        np.testing.assert_array_equal(getattr(there, name), getattr(here, name))


@pytest.mark.parametrize("where", ["here", "in a helper", "in a thread"])
def test_computing_is_measured_wherever_it_is_done(where):
    class Helpers:
        async def compute(self, name, question):
            return msgspec.msgpack.encode((b"an answer", b"", 1.5)) if where == "in a helper" else None

    def measured():
        read = metrics.REGISTRY.get_sample_value
        return [read(f"gainscope_computing_seconds_{part}", {"work": "answers"}) or 0 for part in ("count", "sum")]

    before = measured()
    services = Services(None, None, Work(), Helpers())
    asked = Question(seq=1, controls={"data": "f" * 32} if where == "in a thread" else {})
    assert asyncio.run(give(services, "a live", lambda _: b"an answer", asked)) == b"an answer"
    count, seconds = (now - then for now, then in zip(measured(), before, strict=True))
    assert count == 1
    assert (seconds >= 1.5) == (where == "in a helper")


def test_what_a_helper_was_lost_to_is_not_computed_where_everybody_waits():
    class Lost:
        async def compute(self, name, question):
            raise HelperGoneError

    services = Services(None, None, Work(name="threads"), Lost())
    where = give(services, "a live", lambda _: threading.current_thread().name, Question(seq=1, controls={}))
    assert asyncio.run(where).startswith("threads")


def test_every_page_with_plots_has_a_helper(dash_app):
    asked = {name.partition("-request")[0] for name in dash_app.backend._readers if name.endswith("-request.data")}
    assert {desk.page for desk in DESKS} == asked - {"papers"}


def test_a_picture_is_that_of_its_own_question(question):
    desk = next(desk for desk in DESKS if desk.picture)
    find = found_by_helper(desk, "live")
    assert FOUND(find(msgspec.structs.replace(question(desk), scene=TOKEN)))[1]
    assert FOUND(find(question(desk)))[1] == b""


def test_what_cannot_be_computed_is_told_and_the_helper_goes_on(helper, question):
    desk = DESKS[0]
    right, said = helper.ask("no such page", question(desk))
    assert not right
    assert b"KeyError" in said
    assert helper.ask(f"{desk.page} live", question(desk))[0]


def test_ctrl_c_is_the_servers_and_the_end_of_questions_the_end(question):
    asked = Asked()
    with asked.process as process:
        process.send_signal(signal.SIGINT)
        assert asked.ask("explore live", question(DESKS[0]))[0]
        process.stdin.close()
        assert process.wait(20) == 0
        assert process.stderr.read() == b""


@pytest.mark.parametrize("desk", DESKS, ids=lambda desk: desk.page)
@pytest.mark.parametrize("want", ["all", "tables", "one"])
def test_a_callback_puts_out_what_dash_would_have_written(question, desk, want):
    wanted = {"all": None, "tables": list(desk.tables), "one": list(desk.plots)[:1]}[want]
    asked = question(desk, want=wanted)
    updates, rest = answer(desk, asked)
    found = outputs(KINDS["full"](desk, asked))
    for given, written in zip((*updates, rest), found, strict=True):
        if isinstance(written, orjson.Fragment):
            # As Dash writes an answer.
            assert json.loads(to_json({"a": written}))["a"] == json.loads(to_json(given))
        else:
            assert written is given


def test_dash_still_means_what_is_taken_from_it():
    """Dash leaves alone what it does not know, and orjson puts it in as it is."""
    assert to_json({"a": orjson.Fragment(b'{"b": 1}')}) == '{"a":{"b": 1}}'
