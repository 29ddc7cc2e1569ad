"""What every socket passes: who may open one, how many, how fast it may speak, and what goes wrong in it."""

import asyncio
import json
import logging
from dataclasses import replace

import pytest
from fastapi import FastAPI, WebSocket, WebSocketDisconnect
from uvicorn.protocols.utils import ClientDisconnected

from server import channel, guard, metrics, untaken
from server.channel import AT_A_TIME, Channel, Hearing
from server.guard import Guard
from server.limits import Rate
from server.settings import Settings
from server.untaken import Untaken

HOST = "gainscope.test:8050"
SETTINGS = Settings(requests_per_second=1e6, requests_at_once=1_000_000)


def made(settings=SETTINGS, sockets=()):
    server = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    @server.websocket("/echo/{name}")
    async def echo(websocket: WebSocket):
        await websocket.accept()
        sockets and sockets[0].update(open=count("gainscope_sockets", route="/echo/{name}"))
        async for text in websocket.iter_text():
            await websocket.send_text(text)

    @server.websocket("/broken")
    async def broken(websocket: WebSocket):
        await websocket.accept()
        raise ZeroDivisionError("a secret")

    @server.websocket("/broken-before")
    async def broken_before(websocket: WebSocket):
        raise ZeroDivisionError("a secret")

    @server.websocket("/left")
    async def left(websocket: WebSocket):
        raise WebSocketDisconnect

    @server.websocket("/full/{code}")
    async def full(websocket: WebSocket, code: int):
        await websocket.close(code)

    guard.attach(server, settings)
    return server


def count(name, **labels):
    return metrics.REGISTRY.get_sample_value(name, labels) or 0


def answered(sent, status, field):
    """What is said in place of opening a socket."""
    start, body = sent
    assert (start["type"], start["status"]) == ("websocket.http.response.start", status)
    headers = dict(start["headers"])
    assert headers[b"x-content-type-options"] == b"nosniff"
    said = json.loads(body["body"])
    assert said["request"] == headers[b"x-request-id"].decode()
    assert said["field"] == field
    return headers


@pytest.fixture(scope="module")
def app():
    return made()


def test_what_is_said_passes_both_ways(app, talk):
    before = count("gainscope_socket_messages_total", route="/echo/{name}")
    accepted, *echoed = talk(app, "/echo/a", said=["one", "two"])
    assert dict(accepted["headers"]).keys() == {b"x-request-id"}
    assert [message["text"] for message in echoed] == ["one", "two"]
    assert count("gainscope_socket_messages_total", route="/echo/{name}") == before + 2


def test_open_ones_are_counted_by_their_route(talk):
    seen = {}
    talk(made(sockets=(seen,)), "/echo/a")
    assert seen["open"] == 1
    assert count("gainscope_sockets", route="/echo/{name}") == 0


@pytest.mark.parametrize("origin", [None, "", "null", "http://elsewhere.test", "http://gainscope.test"])
def test_a_page_of_another_server_opens_none(app, talk, origin):
    for path in ("/echo/a", "/nowhere", "/broken-before"):
        answered(talk(app, path, headers={"origin": origin}), 403, "origin")


def test_who_can_be_told_nothing_is_told_by_a_code(app, talk):
    sent = talk(app, "/echo/a", headers={"origin": "null"}, extensions=None)
    assert sent == [{"type": "websocket.close", "code": 1008}]
    full = talk(made(replace(SETTINGS, sockets=0)), "/echo/a", extensions=None)
    assert full == [{"type": "websocket.close", "code": 1013}]


def test_a_route_that_opens_none_is_an_answer_like_any_other(app, talk):
    answered(talk(app, "/nowhere"), 403, "socket")
    answered(talk(app, "/full/1008"), 403, "socket")
    assert answered(talk(app, "/full/1013"), 503, "socket")[b"retry-after"] == b"5"


def test_an_error_ends_a_socket_and_is_in_the_log_alone(app, talk, caplog):
    assert talk(app, "/broken")[1:] == [{"type": "websocket.close", "code": 1011}]
    answered(talk(app, "/broken-before"), 500, "server")
    logged = [record for record in caplog.records if record.name == "server.errors"]
    assert [record.exc_info[0] for record in logged] == [ZeroDivisionError, ZeroDivisionError]
    assert talk(app, "/left") == []
    assert [record for record in caplog.records if record.levelno >= logging.WARNING] == logged


def test_a_rate_limit_counts_sockets_as_well(talk):
    app = made(replace(SETTINGS, requests_per_second=0.1, requests_at_once=2))
    assert [talk(app, "/echo/a")[0]["type"] for _ in range(2)] == ["websocket.accept"] * 2
    assert answered(talk(app, "/echo/a"), 429, "requests")[b"retry-after"] == b"10"


# Many at a time ------------------------------------------------------------------------------------------------------


def scope(client):
    return {
        "type": "websocket", "path": "/", "raw_path": b"/", "query_string": b"", "subprotocols": [],
        "headers": [(b"host", HOST.encode()), (b"origin", f"http://{HOST}".encode())], "client": (client, 1),
    }  # fmt: skip


async def waiting(scope, receive, send):
    await send({"type": "websocket.accept"})
    await receive()
    if scope["client"][0] == "192.0.2.3":
        raise ZeroDivisionError


def test_sockets_have_a_number_in_all_and_for_each_client():
    async def play():
        guarded = Guard(waiting, replace(SETTINGS, sockets=4, sockets_per_client=2))
        outcomes, ends = [], []

        def opened(client):
            end, sent = asyncio.Event(), []
            ends.append(end)

            async def receive():
                await end.wait()
                return {"type": "websocket.disconnect"}

            async def send(message):
                sent.append(message["type"])

            outcomes.append(sent)
            return asyncio.create_task(guarded(scope(client), receive, send))

        clients = ["192.0.2.1"] * 3 + ["192.0.2.2", "192.0.2.3", "192.0.2.4"]
        tasks = [opened(client) for client in clients]
        for _ in range(5):
            await asyncio.sleep(0)
        first = [sent[0] for sent in outcomes]
        for end in ends:
            end.set()
        await asyncio.gather(*tasks)
        # Every place is free again, that of the one that failed as well.
        tasks = [opened(client) for client in ("192.0.2.1", "192.0.2.2", "192.0.2.3", "192.0.2.4")]
        ends[-1].set()
        for _ in range(5):
            await asyncio.sleep(0)
        second = [sent[0] for sent in outcomes[6:]]
        for end in ends:
            end.set()
        await asyncio.gather(*tasks)
        return first, second

    first, second = asyncio.run(play())
    accept, close = "websocket.accept", "websocket.close"
    assert first == [accept, accept, close, accept, accept, close]
    assert second == [accept] * 4


# How they are heard --------------------------------------------------------------------------------------------------


def speaking(hearing, client="192.0.2.1", most=1000):
    """A socket that has numbers to say, all of them at once."""
    numbers = iter(range(most))

    async def receive():
        return {"type": "websocket.receive", "text": next(numbers)}

    async def send(message):
        assert message["type"] == "websocket.send"

    return Channel({"type": "websocket"}, receive, send, None, "1", client, hearing, Untaken())


async def heard(socket):
    return (await socket.receive())["text"]


async def others():
    """Everybody has a turn, and more than one."""
    for _ in range(10):
        await asyncio.sleep(0)


@pytest.fixture
def clock(monkeypatch):
    """What time it is, which goes on by waiting alone."""

    class Clock:
        now = 1000.0
        gives_up = False

        async def sleep(self, seconds):
            if seconds and self.gives_up:
                self.gives_up = False
                raise asyncio.CancelledError
            self.now += seconds

    clock = Clock()
    monkeypatch.setattr(channel.time, "monotonic", lambda: clock.now)
    monkeypatch.setattr(channel.asyncio, "sleep", clock.sleep)
    return clock


def test_one_that_says_too_much_is_heard_in_time(monkeypatch, clock):
    """More than may be said at once waits, nothing is lost, and giving up waiting loses nothing either."""
    monkeypatch.setattr(channel, "PACE", Rate(per_second=10, at_once=3))
    clock.gives_up = True
    found = []

    async def play():
        socket = speaking(Hearing())
        while len(found) < 8:
            try:
                found.append((await heard(socket), round(clock.now - 1000, 6)))
            except asyncio.CancelledError:
                assert clock.now == 1000

    asyncio.run(play())
    assert found == [(0, 0), (1, 0), (2, 0), (3, 0.1), (4, 0.2), (5, 0.3), (6, 0.4), (7, 0.5)]
    assert not clock.gives_up


def test_all_sockets_of_a_client_are_heard_together(monkeypatch, clock):
    """Each is one ahead at most, and they have the same share; nobody else waits for them."""
    monkeypatch.setattr(channel, "PACE_OF_ALL", Rate(per_second=10, at_once=3))

    async def play():
        hearing = Hearing()
        mine = [speaking(hearing) for _ in range(2)] * 5
        found = [(await heard(socket), round(clock.now - 1000, 6)) for socket in mine]
        began, stranger = clock.now, speaking(hearing, "192.0.2.2")
        for _ in range(3):
            await heard(stranger)
        return found, clock.now - began

    found, waited = asyncio.run(play())
    times = [0, 0, 0, 0, 0, 0.1, 0.2, 0.3, 0.4, 0.5]
    assert found == [(place // 2, time) for place, time in enumerate(times)]
    assert waited == 0


async def answers(socket):
    await socket.send({"type": "websocket.send", "text": "an answer"})


async def asks_for_the_next(socket):
    asyncio.ensure_future(socket.receive())  # noqa: RUF006 - nobody waits for it


async def goes(socket):
    socket.end()


@pytest.mark.parametrize("done", [answers, asks_for_the_next, goes])
def test_so_many_messages_of_a_client_are_worked_on_at_a_time(monkeypatch, done):
    monkeypatch.setattr(channel, "AT_A_TIME", 2)

    async def play():
        hearing = Hearing()
        mine = [speaking(hearing) for _ in range(4)]
        tasks = [asyncio.create_task(heard(socket)) for socket in mine]
        await others()
        assert [task.done() for task in tasks] == [True, True, False, False]
        assert await heard(speaking(hearing, "192.0.2.2")) == 0
        # Who gives up waiting for a turn is given the same message later.
        tasks[2].cancel()
        await done(mine[0])
        await others()
        assert [task.done() for task in tasks] == [True, True, True, True]
        for socket in mine:
            socket.end()
        assert await asyncio.wait_for(heard(mine[2]), 20) == 0

    asyncio.run(play())


def test_whoever_asks_waits_for_no_more_of_another_client_than_may_be_worked_on(monkeypatch):
    """Also where the event loop computes the answers itself, and no message ever waits to be worked on."""
    monkeypatch.setattr(channel, "PACE", Rate(1e9, 1e9))
    monkeypatch.setattr(channel, "PACE_OF_ALL", Rate(1e9, 1e9))
    monkeypatch.setattr(channel, "AT_A_TIME", 8)

    async def play():
        hearing, computed = Hearing(), []

        async def answering(socket, client):
            while True:
                await socket.receive()
                computed.append(client)
                await socket.send({"type": "websocket.send"})

        many = [speaking(hearing, most=10**6) for _ in range(50)]
        questions, answered = asyncio.Queue(), asyncio.Queue()
        one = Channel({"type": "websocket"}, questions.get, answered.put, None, "2", "192.0.2.2", hearing, Untaken())
        tasks = [asyncio.create_task(answering(socket, "many")) for socket in many]
        tasks.append(asyncio.create_task(answering(one, "one")))
        between = []
        # A question may come at any moment of what goes on for the others.
        for moment in range(10):
            for _ in range(10 + moment):
                await asyncio.sleep(0)
            computed.clear()
            questions.put_nowait({"type": "websocket.receive"})
            await answered.get()
            between.append(computed.index("one"))
        for task in tasks:
            task.cancel()
        return between

    between = asyncio.run(play())
    assert 0 < max(between) <= 8


def test_between_two_messages_of_one_socket_others_have_their_turn():
    async def play():
        loop, turns = asyncio.get_running_loop(), [0]

        def turn():
            turns[-1] += 1
            loop.call_soon(turn)

        turn()
        socket = speaking(Hearing())
        for number in range(20):
            turns.append(0)
            assert await heard(socket) == number
        return turns[1:]

    assert min(asyncio.run(play())) > 0


def test_forty_sliders_that_are_moved_behind_one_address_wait_for_nothing():
    said = Hearing().said
    assert not any(said.book("a", 100 + beat / 60) for beat in range(60 * 5) for _ in range(40))
    assert AT_A_TIME > 40


def test_a_client_is_the_same_for_all_of_its_sockets(monkeypatch):
    """The addresses of one network are one machine's."""
    monkeypatch.setattr(channel, "AT_A_TIME", 1)

    async def play():
        found, end = [], asyncio.Event()

        async def app(scope, receive, send):
            await send({"type": "websocket.accept"})
            await receive()
            found.append(scope["client"][0])
            await end.wait()

        async def receive():
            return {"type": "websocket.receive", "text": ""}

        async def send(message):
            pass

        guarded = Guard(app, SETTINGS)
        clients = ["2001:db8::1", "2001:db8::2", "2001:db8:0:1::1"]
        tasks = [asyncio.create_task(guarded(scope(client), receive, send)) for client in clients]
        await others()
        first = list(found)
        end.set()
        await asyncio.gather(*tasks)
        return first, found

    first, last = asyncio.run(play())
    assert first == ["2001:db8::1", "2001:db8:0:1::1"]
    assert last == [*first, "2001:db8::2"]


# What nobody takes ---------------------------------------------------------------------------------------------------


def test_a_client_that_takes_nothing_is_left(monkeypatch, counted):
    """While its other sockets hold all that may wait for it to be taken; whoever takes what he is sent is not."""
    monkeypatch.setattr(untaken, "MOST_OF_ONE", 2 * untaken.LARGE)
    large = {"type": "websocket.send", "bytes": bytes(untaken.LARGE + 1)}
    counted("gainscope_refusals_total", reason="untaken")

    async def play():
        answers, taken, told = Untaken(), asyncio.Event(), []

        async def stalls(_):
            await taken.wait()

        async def hears(message):
            told.append(message)

        def one(send, client="192.0.2.1"):
            return Channel({"type": "websocket"}, None, send, None, "1", client, Hearing(), answers)

        waiting, mine = asyncio.create_task(one(stalls).send(large)), one(hears)
        await others()
        await mine.send({"type": "websocket.send", "text": "small"})
        # For the application it has left.
        for message in (large, large, {"type": "websocket.send", "text": "too late"}):
            with pytest.raises(ClientDisconnected):
                await mine.send(message)
        await one(hears, "192.0.2.2").send(large)
        taken.set()
        await waiting
        await one(hears).send(large)
        return told, metrics.REGISTRY.get_sample_value("gainscope_untaken_bytes")

    told, left = asyncio.run(play())
    assert [message.get("code") or len(message.get("text") or message["bytes"]) for message in told] == [
        len("small"),
        1013,
        untaken.LARGE + 1,
        untaken.LARGE + 1,
    ]
    assert left == 0
    assert counted("gainscope_refusals_total", reason="untaken") == 1
