"""Studies over a socket: turns, progress, ends, refusals; a toy study that goes on when the test lets it."""

import asyncio
import json
import threading
from contextvars import copy_context
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import pytest
from fastapi import FastAPI

from layouts import studies
from layouts.studies import AT_ONCE, REMEMBERED, Studies
from server import metrics
from server.clients import CLIENT
from server.limits import share
from server.sockets import MESSAGE_LIMIT
from server.work import Work, busy
from tests.waiting import eventually
from tracker_core import InputError
from tracker_core.tuning import Progress

HOST = "gainscope.test"
WAIT = 10


class Gates:
    """What the toy studies wait for, and what became of them."""

    def __init__(self):
        self.open, self.begun, self.closed = {}, [], []

    def gate(self, name):
        return self.open.setdefault(name, threading.Event())


class Outcome(str):
    """What a toy study has come to; it shows one of ten scores and holds all."""

    __slots__ = ("scores",)

    def __init__(self, text):
        self.scores = np.zeros(10)[:1]


@dataclass(frozen=True)
class Toy:
    """Counts to ten; after the first step it waits at the gate with its name."""

    name: str
    gates: Gates = field(compare=False)

    def stream(self, executor=None):
        self.gates.begun.append(self.name)
        try:
            for step in range(1, 11):
                yield Progress(step, 10, Outcome(f"{self.name} {step}"))
                if step == 1:
                    assert self.gates.gate(self.name).wait(WAIT)
                if self.name == "wrong" and step == 2:
                    raise InputError("runs", "must be fewer", 7)
                if self.name == "broken" and step == 2:
                    raise RuntimeError("a bug")
        except GeneratorExit:
            self.gates.closed.append(self.name)
            raise


class Socket:
    """A browser's end of the socket, without a network."""

    def __init__(self, server, client):
        self.incoming, self.heard = asyncio.Queue(), asyncio.Queue()
        self.incoming.put_nowait({"type": "websocket.connect"})
        scope = {
            "type": "websocket", "path": "/toy/study", "raw_path": b"/toy/study", "query_string": b"", "root_path": "",
            "headers": [], "subprotocols": [], "scheme": "ws", "client": ("test", 1), "server": (HOST, 80),
            "asgi": {"version": "3.0"}, "state": {}, "app": server,
        }  # fmt: skip
        own = copy_context()
        own.run(CLIENT.set, client)
        self.task = asyncio.create_task(server(scope, self.incoming.get, self.heard.put), context=own)

    def say(self, **question):
        self.incoming.put_nowait({"type": "websocket.receive", "text": json.dumps(question)})

    def close(self):
        self.incoming.put_nowait({"type": "websocket.disconnect", "code": 1001})

    async def next(self):
        message = await asyncio.wait_for(self.heard.get(), WAIT)
        return json.loads(message["bytes"]) if message["type"] == "websocket.send" else message

    async def until(self, state, **more):
        """The next answer in that state; others may come before."""
        while True:
            answer = await self.next()
            if answer.get("state") == state and all(answer.get(name) == value for name, value in more.items()):
                return answer


class Stage:
    """A server with one page of toy studies."""

    def __init__(self, seconds=WAIT, **limits):
        self.gates, self.threads, self.busy_once = Gates(), [], None
        self.server, self.studies = FastAPI(), Studies(Work(seconds=seconds), **limits)
        self.studies.attach(self.server, "/toy/study", self.begin)

    def begin(self, question):
        self.threads.append(threading.current_thread().name)
        if question.query == "slow":
            assert self.gates.gate("a").wait(WAIT)
        if question.query == "absurd":
            raise InputError("runs", "must be a whole number >= 1 and <= 10", 10**9)

        def said(progress):
            if question.theme == self.busy_once:
                self.busy_once = None
                raise busy()
            return {"texts": {"said": f"{progress.outcome} {question.theme}"}}

        return Toy(question.query, self.gates), said

    def socket(self, client="one"):
        return Socket(self.server, client)

    def set_for_all(self, **values):
        """Set what is the same for all studies; gives back what it was."""
        before = {name: getattr(studies, name) for name in values}

        def put(those):
            for name, value in those.items():
                setattr(studies, name, value)

        put(values)
        return partial(put, before)


def played(test=None, **limits):
    """Run a test in an event loop of its own, and let what still waits go on afterwards."""
    if test is None:
        return partial(played, **limits)

    def run():
        async def play():
            stage = Stage(**limits)
            try:
                await test(stage)
            finally:
                for name in (*"abcde", "wrong", "broken", *(f"n{i}" for i in range(REMEMBERED + 1))):
                    stage.gates.gate(name).set()

        asyncio.run(play())

    run.__name__, run.__doc__ = test.__name__, test.__doc__
    return run


def measured():
    """Studies whose time has been taken."""
    return metrics.REGISTRY.get_sample_value("gainscope_computing_seconds_count", {"work": "study"}) or 0


@played
async def test_a_study_begins_and_ends(stage):
    before = measured()
    page = stage.socket()
    page.say(seq=1, query="a")
    assert (await page.next())["type"] == "websocket.accept"
    begun = await page.until("running")
    assert begun["seq"] == 1
    stage.gates.gate("a").set()
    done = await page.until("done")
    assert (done["done"], done["of"]) == (10, 10)
    assert done["content"] == {"texts": {"said": "a 10 light"}}
    assert done["remaining"] == 0
    await eventually(lambda: measured() == before + 1)


@played
async def test_a_third_waits_and_hears_its_place(stage):
    first, second, third, fourth = (stage.socket() for _ in range(4))
    for page, name in ((first, "a"), (second, "b")):
        page.say(seq=1, query=name)
        await page.until("running")
    third.say(seq=1, query="c")
    assert (await third.until("queued"))["place"] == 1
    fourth.say(seq=1, query="d")
    assert (await fourth.until("queued"))["place"] == 2
    # A page hears that one runs before it does.
    await eventually(lambda: sorted(stage.gates.begun) == ["a", "b"])
    assert len(stage.gates.begun) == share(AT_ONCE)
    # One that goes away leaves its place to the next.
    third.close()
    assert (await fourth.until("queued"))["place"] == 1
    stage.gates.gate("a").set()
    await first.until("done")
    await fourth.until("running")
    await eventually(lambda: sorted(stage.gates.begun) == ["a", "b", "d"])


@played(waiting=4)
async def test_one_client_leaves_the_others_a_turn_and_room_in_the_line(stage):
    mine = [stage.socket() for _ in range(5)]
    for page, name in zip(mine, "abcde", strict=True):
        page.say(seq=1, query=name)
        await page.until("running" if name in "ab" else "waiting" if name == "e" else "queued")
    first, second = stage.socket("another"), stage.socket("a third")
    first.say(seq=1, query="n0")
    await first.until("running")
    second.say(seq=1, query="n1")
    # It is the next, although two came before it.
    assert (await second.until("queued"))["place"] == 1
    assert (await mine[3].until("queued", place=3))["seq"] == 1
    stage.gates.gate("a").set()
    await second.until("running")


@played
async def test_studies_are_begun_and_shown_in_threads_of_their_own(stage):
    page = stage.socket()
    stage.gates.gate("a").set()
    page.say(seq=1, query="a")
    await page.until("done")
    assert [name.rstrip("0123456789_") for name in stage.threads] == ["study page"]


@played(seconds=0.3)
async def test_a_study_that_cannot_be_begun_in_time_is_to_be_asked_for_later(stage):
    page = stage.socket()
    page.say(seq=1, query="slow")
    assert set(await page.until("waiting", seq=1)) == {"seq", "state"}
    stage.gates.gate("a").set()
    page.say(seq=2, query="a")
    await page.until("done", seq=2)


@played
async def test_stop_ends_it_within_a_step_and_frees_the_turn(stage):
    pages = [stage.socket() for _ in range(3)]
    for page, name in zip(pages, "abc", strict=True):
        page.say(seq=1, query=name)
    await pages[2].until("queued")
    pages[0].say(seq=2, stop=True, query="a")
    assert (await pages[0].until("stopped"))["seq"] == 2
    stage.gates.gate("a").set()
    await pages[2].until("running")
    assert stage.gates.closed == ["a"]
    # What was stopped is not known: it is computed anew.
    pages[0].say(seq=3, query="a")
    for name in "bc":
        stage.gates.gate(name).set()
    await pages[0].until("done", seq=3)
    assert stage.gates.begun.count("a") == 2


@played
async def test_another_question_ends_the_one_before(stage):
    page = stage.socket()
    page.say(seq=1, query="a")
    await page.until("running")
    page.say(seq=2, query="b")
    stage.gates.gate("b").set()
    assert (await page.until("done"))["seq"] == 2
    stage.gates.gate("a").set()
    # Nothing of the first comes after.
    page.say(seq=3, query="b")
    answer = await page.next()
    assert (answer["seq"], answer["state"], answer["content"]) == (3, "done", {"texts": {"said": "b 10 light"}})


@played
async def test_the_same_question_goes_on_with_what_runs(stage):
    page = stage.socket()
    page.say(seq=1, query="a", theme="light")
    await page.until("running")
    page.say(seq=2, query="a", theme="dark")
    stage.gates.gate("a").set()
    done = await page.until("done", seq=2)
    assert done["content"] == {"texts": {"said": "a 10 dark"}}
    assert stage.gates.begun == ["a"]


@played
async def test_what_was_run_lately_is_known(stage):
    page, other = stage.socket(), stage.socket()
    for number, name in enumerate(f"n{i}" for i in range(REMEMBERED + 1)):
        stage.gates.gate(name).set()
        page.say(seq=number, query=name)
        await page.until("done", seq=number)
    other.say(seq=1, query=f"n{REMEMBERED}", theme="dark")
    done = await other.until("done")
    assert done["content"] == {"texts": {"said": f"n{REMEMBERED} 10 dark"}}
    assert stage.gates.begun.count(f"n{REMEMBERED}") == 1
    # The oldest is not.
    other.say(seq=2, query="n0")
    await other.until("done", seq=2)
    assert stage.gates.begun.count("n0") == 2


@played
async def test_a_stopped_study_can_be_looked_at_and_stays_stopped(stage):
    page = stage.socket()
    page.say(seq=1, query="a")
    await page.until("running")
    page.say(seq=2, query="a", stop=True)
    await page.until("stopped", seq=2)
    stage.gates.gate("a").set()
    page.say(seq=3, query="a", theme="dark", look=True)
    looked = await page.until("stopped", seq=3)
    # Nothing had been shown of it yet.
    assert set(looked) == {"seq", "state"}
    slow = stage.set_for_all(STEP=0.0)
    page.say(seq=4, query="b")
    await page.until("running", done=1, of=10)
    page.say(seq=5, query="b", stop=True)
    await page.until("stopped", seq=5)
    page.say(seq=6, query="b", theme="dark", look=True)
    looked = await page.until("stopped", seq=6)
    assert looked["content"] == {"texts": {"said": "b 1 dark"}}
    assert looked["done"] == 1
    slow()
    assert stage.gates.begun == ["a", "b"]


@played
async def test_so_much_of_what_was_stopped_is_kept(stage):
    """By all pages together, and by what it holds and not by what it shows of it."""
    slow = stage.set_for_all(STEP=0.0, REMEMBERED_SCORES=25)
    pages = {name: stage.socket() for name in "abc"}
    for name, page in pages.items():
        page.say(seq=1, query=name)
        await page.until("running", done=1, of=10)
        page.say(seq=2, query=name, stop=True)
        await page.until("stopped", seq=2)
        stage.gates.gate(name).set()
        await eventually(lambda: stage.studies.load() == (0, 0))
    looked = {}
    for name, page in pages.items():
        page.say(seq=3, query=name, look=True)
        looked[name] = "content" in await page.until("stopped", seq=3)
    slow()
    assert looked == {"a": False, "b": True, "c": True}
    # Pages that go take it with them.
    assert len(stage.studies._unfinished) == 2
    for page in pages.values():
        page.close()
    await asyncio.gather(*(page.task for page in pages.values()))
    assert not stage.studies._unfinished


@played
async def test_what_is_known_is_told_as_often_as_it_is_asked_for(stage):
    page = stage.socket()
    stage.gates.gate("a").set()
    for seq, theme in enumerate(("light", "dark", "light", "dark", "dark")):
        page.say(seq=seq, query="a", theme=theme)
        done = await page.until("done", seq=seq)
        assert done["content"] == {"texts": {"said": f"a 10 {theme}"}}
    assert stage.gates.begun == ["a"]


@played
async def test_a_study_goes_on_where_nobody_has_time_to_show_it_anew(stage):
    slow = stage.set_for_all(STEP=0)
    page = stage.socket()
    page.say(seq=1, query="b", theme="light")
    await page.until("running", done=1, of=10)
    stage.busy_once = "dark"
    page.say(seq=2, query="b", theme="dark")
    await eventually(lambda: stage.busy_once is None)
    stage.gates.gate("b").set()
    done = await page.until("done", seq=2)
    assert done["content"] == {"texts": {"said": "b 10 dark"}}
    assert stage.gates.begun == ["b"]
    slow()


@played
async def test_a_page_that_goes_away_ends_its_study_and_leaves_nothing(stage):
    slow = stage.set_for_all(STEP=0.0)
    page = stage.socket()
    page.say(seq=1, query="a")
    await page.until("running", done=1, of=10)
    page.close()
    await asyncio.wait_for(page.task, WAIT)
    stage.gates.gate("a").set()
    await eventually(lambda: stage.studies.load() == (0, 0))
    slow()
    assert stage.gates.closed == ["a"]
    assert not stage.studies._unfinished


@played
async def test_what_cannot_be_run_is_refused_beside_its_field(stage):
    page = stage.socket()
    page.say(seq=1, query="absurd")
    refused = await page.until("refused")
    assert list(refused["errors"]) == ["runs"]
    assert "10" in refused["errors"]["runs"]
    assert stage.gates.begun == []
    # So is what turns out to be wrong on the way.
    stage.gates.gate("wrong").set()
    page.say(seq=2, query="wrong")
    assert list((await page.until("refused", seq=2))["errors"]) == ["runs"]


@played
async def test_a_bug_is_told_and_frees_the_turn(stage):
    page = stage.socket()
    stage.gates.gate("broken").set()
    stage.gates.gate("a").set()
    for number in range(AT_ONCE + 1):
        page.say(seq=number, query="broken")
        assert set(await page.until("failed", seq=number)) == {"seq", "state"}
    page.say(seq=9, query="a")
    await page.until("done", seq=9)


@played(minutes=0)
async def test_a_study_that_has_taken_its_time_ends_with_what_it_came_to(stage):
    page = stage.socket()
    page.say(seq=1, query="a")
    over = await page.until("over")
    assert (over["done"], over["of"], over["minutes"]) == (1, 10, 0)
    assert over["content"] == {"texts": {"said": "a 1 light"}}
    assert stage.gates.closed == ["a"]
    # It can be looked at in another theme, and is not taken for the whole.
    page.say(seq=2, query="a", theme="dark", look=True)
    looked = await page.until("stopped", seq=2)
    assert looked["content"] == {"texts": {"said": "a 1 dark"}}
    page.say(seq=3, query="a")
    await page.until("over", seq=3)
    assert stage.gates.begun == ["a", "a"]


@played(waiting=1)
async def test_a_line_that_is_too_long_is_said(stage):
    first, second, third, fourth = (stage.socket() for _ in range(4))
    for page, name in ((first, "a"), (second, "b")):
        page.say(seq=1, query=name)
        await page.until("running")
    third.say(seq=1, query="c")
    await third.until("queued")
    fourth.say(seq=1, query="d")
    assert set(await fourth.until("waiting")) == {"seq", "state"}
    # Once somebody has gone, there is room.
    third.say(seq=2, query="c", stop=True)
    await third.until("stopped")
    fourth.say(seq=2, query="d")
    assert (await fourth.until("queued", seq=2))["place"] == 1


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("{", 1003), ("[]", 1003), ('{"query": "a"}', 1003), ('{"seq": 1, "query": 5}', 1003),
        ('{"seq": 1, "query": "a", "theme": "<b>"}', 1003), (" " * (MESSAGE_LIMIT + 1), 1009),
    ],
    ids=["no JSON", "no object", "no number", "no link", "no theme", "too long"],
)  # fmt: skip
def test_what_is_no_question_is_said_and_ends_the_connection(text, code):
    async def play():
        page = Stage().socket()
        page.incoming.put_nowait({"type": "websocket.receive", "text": text})
        assert (await page.next())["type"] == "websocket.accept"
        assert (await page.next())["problem"].keys() == {"field", "rule", "received", "message", "request"}
        closed = await page.next()
        assert (closed["type"], closed["code"]) == ("websocket.close", code)

    asyncio.run(play())
