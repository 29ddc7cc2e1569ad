"""Long answers: few at a time, a line that ends, a limit on the waiting."""

import asyncio
import contextlib
import json
import threading

import pytest

from server.clients import CLIENT
from server.problem import REQUEST
from server.work import AGAIN, NoAnswerError, Work
from tests.leaving import without_the_collector
from tracker_core.checks import InputError

WAIT = 10


def refused(error):
    """Status, header and body of the answer of HTTP."""
    response = error.response()
    return response.status_code, response.headers.get("retry-after"), json.loads(response.body)


@pytest.fixture
def go_on():
    """What work waits for; it goes on after the test in any case."""
    event = threading.Event()
    yield event
    event.set()


def test_work_is_done_in_a_thread_that_knows_the_request():
    def where(*arguments):
        return arguments, threading.current_thread().name, REQUEST.get()

    async def play():
        token = REQUEST.set("abc")
        try:
            return await Work(name="here").run(where, 1, "a")
        finally:
            REQUEST.reset(token)

    arguments, thread, request = asyncio.run(play())
    assert arguments == (1, "a")
    assert thread.startswith("here")
    assert request == "abc"


@pytest.mark.parametrize("work", [lambda: 1, lambda: 1 / 0], ids=["succeeds", "fails"])
def test_what_is_done_is_measured_under_its_name(work, counted):
    counted("gainscope_computing_seconds_count", work="measured")
    with contextlib.suppress(ZeroDivisionError):
        asyncio.run(Work().beside("measured", 1).run(work))
    assert counted("gainscope_computing_seconds_count", work="measured") == 1


@pytest.mark.parametrize("error", [InputError("a", "must be b", 3), TimeoutError("a socket's"), ZeroDivisionError()])
def test_what_work_raises_is_raised(error):
    def fail():
        raise error

    with pytest.raises(type(error)) as caught:
        asyncio.run(Work(seconds=WAIT).run(fail))
    assert str(caught.value) == str(error)


def test_what_is_refused_is_not_left_for_the_collector():
    """The error that is raised holds the frames that it came through."""

    def fail():
        raise InputError("field", "must be right", "wrong")

    async def ask():
        async with without_the_collector({"_Asked"}):
            for _ in range(3):
                with contextlib.suppress(InputError):
                    await Work(seconds=WAIT).run(fail)

    asyncio.run(ask())


def test_whoever_comes_to_a_full_line_is_sent_away_and_finds_room_later(go_on):
    work, begun = Work(threads=1, waiting=1), threading.Event()

    def long():
        begun.set()
        return go_on.wait(WAIT)

    async def play():
        first = asyncio.create_task(work.run(long))
        await asyncio.to_thread(begun.wait, WAIT)
        second = asyncio.create_task(work.run(go_on.wait, WAIT))
        await asyncio.sleep(0)
        with pytest.raises(NoAnswerError) as caught:
            await work.run(go_on.wait, WAIT)
        go_on.set()
        assert await first
        assert await second
        assert await work.run(lambda: 5) == 5
        return caught.value

    status, again, said = refused(asyncio.run(play()))
    assert (status, again) == (503, str(AGAIN))
    assert (said["field"], said["message"]) == ("server", "it is busy with other answers")


def test_what_takes_too_long_is_given_up_and_keeps_its_thread_until_it_ends(go_on):
    work, ended = Work(threads=1, waiting=0, seconds=0.05), threading.Event()

    def long():
        go_on.wait(WAIT)
        ended.set()

    async def play():
        with pytest.raises(NoAnswerError) as caught:
            await work.run(long)
        # Its thread is still at it: nobody else is let in.
        with pytest.raises(NoAnswerError) as sent_away:
            await work.run(int)
        assert sent_away.value.status == 503
        go_on.set()
        assert await asyncio.to_thread(ended.wait, WAIT)
        return caught.value

    status, again, said = refused(asyncio.run(play()))
    assert (status, again) == (504, None)
    assert (said["field"], said["message"]) == ("answer", "it has tried for 0.05 s")


def test_what_is_given_up_in_the_line_is_never_begun(go_on):
    work, begun, done = Work(threads=1, waiting=1, seconds=0.05), threading.Event(), []

    def long():
        begun.set()
        go_on.wait(WAIT)

    async def play():
        first = asyncio.create_task(work.run(long))
        await asyncio.to_thread(begun.wait, WAIT)
        with pytest.raises(NoAnswerError):
            await work.run(done.append, "late")
        with pytest.raises(NoAnswerError):
            await first
        go_on.set()
        # The one thread comes to this after all that was in the line before.
        while True:
            try:
                return await work.run(done.append, "next")
            except NoAnswerError:
                await asyncio.sleep(0.01)

    asyncio.run(play())
    assert done == ["next"]


def test_clients_take_turns_however_much_one_of_them_asks(go_on):
    work, begun, done = Work(threads=1, waiting=20, seconds=WAIT), threading.Event(), []

    def long():
        begun.set()
        go_on.wait(WAIT)

    async def as_client(name, *what):
        CLIENT.set(name)
        return await work.run(*what)

    async def play():
        first = asyncio.create_task(as_client("a", long))
        await asyncio.to_thread(begun.wait, WAIT)
        asked = [asyncio.create_task(as_client("a", done.append, f"a{number}")) for number in range(11)]
        await asyncio.sleep(0)
        asked.append(asyncio.create_task(as_client("b", done.append, "b")))
        await asyncio.sleep(0)
        go_on.set()
        await first
        return await asyncio.gather(*asked, return_exceptions=True)

    *_, last_of_a, of_b = asyncio.run(play())
    assert done == ["b", *(f"a{number}" for number in range(10))]
    # Half of the line is one client's, the other half is for others.
    assert isinstance(last_of_a, NoAnswerError)
    assert of_b is None


def test_what_is_refused_is_counted(go_on, counted):
    async def play():
        work = Work(threads=1, waiting=0, seconds=0.05)
        for _ in range(2):
            with pytest.raises(NoAnswerError):
                await work.run(go_on.wait, WAIT)

    def refusals():
        return [counted("gainscope_refusals_total", reason=reason) for reason in ("late", "busy")]

    assert refusals() == [0, 0]
    asyncio.run(play())
    assert refusals() == [1, 1]


def test_threads_beside_have_their_own_line(go_on):
    work = Work(threads=1, waiting=0, seconds=WAIT)
    other = work.beside("other", 1)

    async def play():
        busy = asyncio.create_task(work.run(go_on.wait, WAIT))
        await asyncio.sleep(0)
        assert await other.run(lambda: 5) == 5
        go_on.set()
        await busy

    asyncio.run(play())
