"""One request and its answer as their parts pass: the network is given no more of an answer than the client takes."""

import asyncio
import contextlib
import json
import socket

import pytest
import uvicorn
from starlette.responses import Response

from server import metrics, untaken
from server.exchange import PIECE, Exchange
from server.guard import Guard
from server.headers import Headers
from server.routes import Served
from server.settings import Settings
from server.untaken import Untaken
from tests.serving import on_a_port
from tests.waiting import eventually

LARGE = 64_000_000
"""Bytes that no system keeps for a client that takes nothing."""


def passed(*messages, method="GET", untaken=None, **more):
    """What the network is given of an answer, one after the other."""
    given = []

    async def send(message):
        given.append(message)

    async def play():
        scope = {"type": "http", "method": method, "state": {}, **more}
        exchange = Exchange(scope, None, send, Headers(), "1", "a", untaken or Untaken())
        for message in messages:
            await exchange.send(message)
        return exchange.size

    return given, asyncio.run(play())


def part(body, more=False):
    return {"type": "http.response.body", "body": body, "more_body": more}


START = {"type": "http.response.start", "status": 200, "headers": []}


@pytest.mark.parametrize("size", [0, 1, PIECE, PIECE + 1, 3 * PIECE, 3 * PIECE + 5])
@pytest.mark.parametrize("more", [True, False])
def test_an_answer_is_passed_on_in_pieces_and_whole(size, more):
    body = bytes(range(251)) * (size // 251 + 1)
    (_, *given), counted = passed(START, part(body[:size], more))
    assert b"".join(each["body"] for each in given) == body[:size]
    assert max(len(each["body"]) for each in given) <= PIECE
    assert [each["more_body"] for each in given] == [True] * (len(given) - 1) + [more]
    assert counted == size


def test_of_what_has_no_body_nothing_is_passed_on():
    given, _ = passed(START, part(bytes(3 * PIECE)), method="HEAD")
    assert [len(each.get("body", b"")) for each in given] == [0, 0]


def test_a_client_that_takes_nothing_is_sent_little():
    """Over a network: what is not taken stays one object of the server's, however many do not take it."""
    given = []

    async def app(scope, receive, send):
        async def counting(message):
            given.append(0)
            await send(message)
            given[-1] = len(message.get("body", b""))

        await Guard(Response(bytes(LARGE)), Settings())(scope, receive, counting)

    config = uvicorn.Config(app, host="127.0.0.1", port=0, log_level="critical", lifespan="off")
    with on_a_port(config) as address, socket.create_connection(address) as connection:
        connection.sendall(b"GET / HTTP/1.1\r\nHost: test\r\n\r\n")
        seen = []

        def stands():
            seen.append(len(given))
            return len(given) > 2 and given[-1] == 0 and seen[-5:] == [len(given)] * 5

        asyncio.run(eventually(stands))
        assert sum(given) < LARGE / 2


# What nobody takes ---------------------------------------------------------------------------------------------------


def bytes_untaken():
    return metrics.REGISTRY.get_sample_value("gainscope_untaken_bytes")


def test_so_much_of_a_clients_answers_waits_to_be_taken(monkeypatch):
    """What goes beyond that is refused in its place, and another client has room all the same."""
    monkeypatch.setattr(untaken, "MOST", 10 * PIECE)
    monkeypatch.setattr(untaken, "MOST_OF_ONE", 5 * PIECE)
    answers = Untaken()
    with answers.held("a", 4 * PIECE):
        (start, said, end), size = passed(START, part(bytes(2 * PIECE)), part(b"no more"), untaken=answers)
        assert start["status"] == 503
        assert dict(start["headers"])[b"retry-after"] == b"5"
        assert json.loads(said["body"])["field"] == "answers"
        assert (size, end["more_body"]) == (len(said["body"]), False)
        # What is small, and what lies in memory for everybody, is not counted.
        for rest in ((part(bytes(PIECE)),), (part(bytes(PIECE), more=True), part(bytes(PIECE)))):
            assert passed(START, *rest, untaken=answers)[0][0]["status"] == 200
        assert passed(START, part(bytes(9 * PIECE)), untaken=answers, route=Served("/a"))[0][0]["status"] == 200
        with answers.held("b", 5 * PIECE) as has_room, answers.held("c", 2 * PIECE) as is_left:
            assert (has_room, is_left) == (True, False)
    assert bytes_untaken() == 0
    assert passed(START, part(bytes(5 * PIECE)), untaken=answers)[0][0]["status"] == 200


def test_one_that_has_begun_breaks_off(monkeypatch):
    monkeypatch.setattr(untaken, "MOST_OF_ONE", 2 * PIECE)
    given, _ = passed(START, part(b"one", more=True), part(bytes(3 * PIECE)))
    assert [each.get("body") for each in given] == [None, b"one"]


@pytest.mark.parametrize("end", ["taken", "left"])
def test_what_is_taken_makes_room(end):
    answers = Untaken()

    async def send(message):
        seen.append(bytes_untaken())
        if end == "left":
            raise OSError

    async def play():
        exchange = Exchange({"type": "http", "method": "GET", "state": {}}, None, send, Headers(), "1", "a", answers)
        await exchange.send(START)
        with contextlib.suppress(OSError):
            await exchange.send(part(bytes(3 * PIECE)))

    seen = []
    asyncio.run(play())
    assert set(seen) == {3 * PIECE}
    assert bytes_untaken() == 0
