"""The socket: who may speak, what is understood, and that one bad question leaves the server as it was."""

import asyncio
import json
import threading
from functools import partial

import msgspec
import numpy as np
import pytest
from fastapi import FastAPI
from msgspec.structs import replace

from layouts import answering, desk, live
from layouts.live import framed
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pages.track.answers import DESK as TRACK
from layouts.questions import LONG_RUN, Question, page_reader
from layouts.services import Services
from server.helpers import Helpers
from server.sockets import MESSAGE_LIMIT, TOO_LARGE, UNREADABLE
from server.work import Work

HOST = "gainscope.test:8050"
PLOTS = list(EXPLORE.plots)
answer, live_answer = (partial(function, EXPLORE) for function in (desk.answer, desk.live_answer))

# Parts -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rest", [{}, {"a": 1}, {"ab": 1}, {"abc": "ξ"}, {"abcd": "🙂"}, {"long": "x" * 1000}])
@pytest.mark.parametrize("lengths", [[], [3], [3, 0, 2]])
def test_a_message_is_length_text_padding_and_numbers(rest, lengths):
    arrays = [np.arange(length, dtype="f4") + 0.5 for length in lengths]
    message = framed(rest, arrays)
    length = int.from_bytes(message[:4], "little")
    # A typed array begins at a multiple of four bytes only.
    assert (4 + length) % 4 == 0
    assert json.loads(message[4 : 4 + length].decode("utf-8")) == rest
    np.testing.assert_array_equal(
        np.frombuffer(message[4 + length :], dtype="<f4"), np.concatenate([[], *arrays]).astype("f4")
    )


# Over the application ----------------------------------------------------------------------------------------------

ACCEPT = {"type": "websocket.accept"}


def kinds(sent):
    return [message["type"] for message in sent]


def text(question):
    """A question as the page's script sends it."""
    return msgspec.json.encode(question).decode()


def closed_with(sent):
    """Code of the close that ends a connection."""
    assert sent[-1]["type"] == "websocket.close"
    return sent[-1]["code"]


@pytest.fixture(scope="session")
def question(controls_for, request_for):
    """A good question about a page that shows everything already."""
    _, rest = answer(request_for(controls_for()))
    return request_for(controls_for(), {"xi": 0.5}, drawn=rest["drawn"], want=list(PLOTS)[:3])


def test_a_good_question_is_answered(talk, question):
    sent = talk(text(question))
    assert kinds(sent) == ["websocket.accept", "websocket.send"]
    assert sent[1]["bytes"] == framed(*live_answer(question))
    assert len(sent[1]["bytes"]) > 10_000


@pytest.mark.parametrize("page", [EXPLORE, STABILITY, TRACK], ids=lambda desk: desk.page)
def test_every_page_has_a_socket_of_its_own(talk, controls_for, request_for, page):
    _, rest = desk.answer(page, request_for(controls_for()))
    asked = request_for(controls_for(), {"xi": 0.5}, drawn=rest["drawn"], want=list(page.plots), scene="")
    assert len(text(asked)) < MESSAGE_LIMIT / 4
    sent = talk(text(asked), path=f"/{page.page}/live")
    assert kinds(sent) == ["websocket.accept", "websocket.send"]
    assert sent[1]["bytes"] == framed(*desk.live_answer(page, asked))
    assert list(text_of(sent[1])["lines"]) == list(page.plots)


def test_questions_are_answered_in_their_order(talk, question):
    sent = talk(*(text(replace(question, seq=seq)) for seq in (1, 2, 3)))
    assert [text_of(message)["seq"] for message in sent[1:]] == [1, 2, 3]


def text_of(message):
    """The text part of an answer."""
    data = message["bytes"]
    return json.loads(data[4 : 4 + int.from_bytes(data[:4], "little")])


def test_an_entry_that_is_wrong_is_an_answer_like_any_other(talk, question):
    wrong = replace(question, controls={**question.controls, "samples": "2"})
    sent = talk(text(wrong), text(question))
    first, second = (text_of(message) for message in sent[1:])
    assert (first["ok"], list(first["errors"])) == (False, ["samples"])
    assert second["ok"]


UNREADABLE_MESSAGES = {
    "empty": "",
    "no JSON": "hello",
    "half": '{"seq": 1',
    "a number": "5",
    "null": "null",
    "a text": '"text"',
    "a list": "[]",
    "nothing in it": "{}",
    "no controls": '{"seq": 1}',
    "no number": '{"controls": {}}',
    "controls that are none": '{"seq": 1, "controls": 5}',
    "controls in a list": '{"seq": 1, "controls": [1]}',
    "controls null": '{"seq": 1, "controls": null}',
    "changes that are none": '{"seq": 1, "controls": {}, "changed": 5}',
    "changes that are no names": '{"seq": 1, "controls": {}, "changed": [[1]]}',
    "a pin that is none": '{"seq": 1, "controls": {}, "pins": [1]}',
    "a drawing that is none": '{"seq": 1, "controls": {}, "want": ["explore-path"], "drawn": 5}',
    "a wish that is none": '{"seq": 1, "controls": {}, "want": 5}',
    "a number without end": '{"seq": 1, "controls": {"samples": ' + "9" * 5000 + "}}",
    "bytes": b"\x00\xff",
    "good JSON as bytes": b"{}",
    "deep": "[" * (MESSAGE_LIMIT - 1),
    "a control that there is not": '{"seq": 1, "controls": {"gamma_ray": 1}}',
    "a plot of another page": '{"seq": 1, "controls": {}, "want": ["stability-map"]}',
    "a text that is too long": '{"seq": 1, "controls": {"alpha": "' + "1" * 201 + '"}}',
    "more than is known": '{"seq": 1, "controls": {}, "more": 1}',
}


def refused(sent):
    """What the page is told before a connection is closed, the one message there is."""
    assert kinds(sent) == ["websocket.accept", "websocket.send", "websocket.close"]
    rest = text_of(sent[1])
    assert rest.keys() == {"problem", "again"}
    assert rest["problem"].keys() == {"field", "rule", "received", "message", "request"}
    return rest["problem"]


@pytest.mark.parametrize("message", UNREADABLE_MESSAGES.values(), ids=UNREADABLE_MESSAGES)
def test_what_cannot_be_understood_ends_the_connection_and_nothing_else(talk, question, message):
    sent = talk(message, text(question))
    assert refused(sent)["rule"].startswith("must ")
    assert closed_with(sent) == UNREADABLE == 1003
    assert kinds(talk(text(question))) == ["websocket.accept", "websocket.send"]


@pytest.mark.parametrize("extra", [1, 1_000_000])
def test_a_message_that_is_too_long_ends_the_connection(talk, question, extra):
    asked = text(question)
    sent = talk(asked + " " * (MESSAGE_LIMIT - len(asked) + extra), asked)
    assert refused(sent)["rule"] == "must have at most 20,000 characters"
    assert closed_with(sent) == TOO_LARGE == 1009
    assert kinds(talk(asked)) == ["websocket.accept", "websocket.send"]


def test_a_message_of_just_the_limit_is_answered(talk, question):
    asked = text(question)
    assert kinds(talk(asked + " " * (MESSAGE_LIMIT - len(asked))))[-1] == "websocket.send"


def test_the_largest_honest_question_is_well_below_the_limit(question):
    largest = replace(question, changed=list(question.controls), pins=[(1, "x" * 300)] * 6)
    assert len(text(largest)) < MESSAGE_LIMIT / 3


def test_a_connection_without_a_question_ends_quietly(talk):
    assert kinds(talk()) == ["websocket.accept"]


def test_there_is_no_other_socket(talk, question):
    sent = talk(text(question), path="/explore/other")
    assert kinds(sent) == ["websocket.close"]


# Long answers ------------------------------------------------------------------------------------------------------


@pytest.fixture
def played():
    """One question on a socket of a server of its own, and what is sent."""

    def play(answer, work, question):
        server = FastAPI()
        services = Services(None, None, work, Helpers(0, ()))
        give = partial(answering.give, services, "a live", lambda asked: framed(*answer(asked)))
        live.attach(server, "/live", page_reader(["a"]), give)
        asked = {"type": "websocket.receive", "text": text(question)}
        incoming = iter([{"type": "websocket.connect"}, asked, {"type": "websocket.disconnect", "code": 1000}])
        sent = []

        async def receive():
            return next(incoming)

        async def send(message):
            sent.append(message)

        scope = {"type": "websocket", "path": "/live", "query_string": b"", "headers": [], "subprotocols": []}
        asyncio.run(server(scope, receive, send))
        return sent

    return play


@pytest.mark.parametrize(
    ("long", "more"),
    [
        (False, {}),
        (False, {"samples": LONG_RUN}),
        (False, {"samples": "many"}),
        (True, {"samples": LONG_RUN + 1}),
        (True, {"samples": str(LONG_RUN + 1)}),
        (True, {"data": "f" * 32}),
    ],
)
def test_a_long_answer_is_made_in_a_thread(played, long, more):
    """So that nobody else waits for it."""
    where = []

    def respond(asked):
        where.append(threading.current_thread() is threading.main_thread())
        return {"got": asked.seq}, []

    sent = played(respond, Work(), Question(seq=3, controls=more))
    assert where == [not long]
    assert text_of(sent[-1]) == {"got": 3}


def test_what_takes_too_long_is_said_and_the_connection_stays(played):
    go_on = threading.Event()
    sent = played(lambda _: go_on.wait(10), Work(seconds=0.05), Question(seq=3, controls={}, pins=[(1, "kalata")]))
    go_on.set()
    assert kinds(sent) == ["websocket.accept", "websocket.send"]
    rest = text_of(sent[1])
    assert (rest["seq"], rest["again"]) == (3, None)
    assert rest["problem"]["message"] == "it has tried for 0.05 s"


def test_a_bug_is_left_to_the_guard(played):
    with pytest.raises(ZeroDivisionError):
        played(lambda _: 1 / 0, Work(), Question(seq=3, controls={}))


@pytest.mark.parametrize("samples", [LONG_RUN, LONG_RUN + 1, str(LONG_RUN + 2)])
def test_long_runs_are_answered_over_the_socket_like_short_ones(talk, controls_for, request_for, samples):
    rest = text_of(talk(text(request_for(controls_for(), {"samples": samples})))[-1])
    assert rest["ok"]
    assert rest["samples"] == int(samples)
