"""Helpers: that they come when they are needed and go when not, and that losing one loses nothing."""

import asyncio
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from server import helpers
from server.helpers import ComputingError, HelperGoneError, Helpers
from server.work import NoAnswerError
from tests.waiting import eventually, is_running

ROOT = Path(__file__).parents[2]

HELPER = """
import os, sys, time
from server.helpers import frame, question_in

def say(right, answer):
    sys.stdout.buffer.write(frame((right, answer)))
    sys.stdout.flush()

{start}
say(True, b"")
while (asked := question_in(sys.stdin.buffer.read)) is not None:
    name, question = asked
    if name == "pid":
        say(True, str(os.getpid()).encode())
    elif name == "wrong":
        say(False, b"Traceback: " + question)
    elif name == "die":
        os._exit(3)
    elif name == "hang":
        time.sleep(60)
    elif name == "twice":
        say(True, b"once")
        say(True, b"again")
    elif name == "babble":
        sys.stdout.buffer.write(b"\\x03\\x00\\x00\\x00abc")
        sys.stdout.flush()
    elif name == "where":
        say(True, os.getcwd().encode())
    else:
        say(True, name.encode() + question)
"""


until = partial(eventually, patience=60.0)
KEPT = {"return_exceptions": True}


@pytest.fixture
def hurried(monkeypatch):
    """Every loop counts as late, and helpers come at once."""
    monkeypatch.setattr(helpers, "EVERY", 0.005)
    monkeypatch.setattr(helpers, "LOOKS", 1)
    monkeypatch.setattr(helpers, "LATE", -1.0)
    monkeypatch.setattr(helpers, "AGAIN", 0.005)


def with_helpers(play, most=1, start=""):
    """What `play` gives, a coroutine function of helpers; they are ended afterwards."""

    async def whole():
        some = Helpers(most, (sys.executable, "-c", HELPER.format(start=start)))
        try:
            async with asyncio.timeout(60):
                return await play(some)
        finally:
            some.stop()
            await until(lambda: not some.running())

    return asyncio.run(whole())


async def answered(some, name="pid", question=b""):
    """The first answer of a helper, and how often there was none before."""
    without = 0
    while (found := await some.compute(name, lambda: question)) is None:
        without += 1
        await asyncio.sleep(0.01)
    return found, without


async def until_ready(some, number):
    await answered(some)
    await until(lambda: sum(helper.is_ready for helper in some._helpers) == number)


def test_one_is_started_where_it_is_said(hurried, monkeypatch, tmp_path):
    async def whole():
        some = Helpers(1, (sys.executable, "-c", HELPER.format(start="")), ROOT)
        monkeypatch.chdir(tmp_path)
        found, _ = await answered(some, "where")
        some.stop()
        await until(lambda: not some.running())
        return found

    assert asyncio.run(whole()).decode() == str(ROOT)


def test_where_none_are_allowed_none_come(hurried):
    async def play(some):
        for _ in range(20):
            assert await some.compute("pid", lambda: b"") is None
            await asyncio.sleep(0.005)
        return some.running()

    assert with_helpers(play, most=0) == 0


def test_a_quiet_server_has_none(monkeypatch):
    monkeypatch.setattr(helpers, "EVERY", 0.005)
    monkeypatch.setattr(helpers, "LATE", 1.0)

    async def play(some):
        for _ in range(20):
            assert await some.compute("pid", lambda: b"") is None
            await asyncio.sleep(0.005)
        return some.running()

    assert with_helpers(play) == 0


def test_a_late_loop_calls_one_and_it_answers(hurried):
    async def play(some):
        found, without = await answered(some, "say ", b"hello")
        # While it starts, the question is not kept waiting.
        assert without > 0
        assert found == b"say hello"
        assert some.running() == 1

    with_helpers(play)


def test_lateness_is_what_calls(monkeypatch):
    monkeypatch.setattr(helpers, "EVERY", 0.01)
    monkeypatch.setattr(helpers, "LOOKS", 2)

    async def play(some):
        while not some.running():
            assert await some.compute("pid", lambda: b"") is None
            # What computes here holds up everybody.
            time.sleep(0.06)  # noqa: ASYNC251
            await asyncio.sleep(0)
        return await answered(some)

    assert int(with_helpers(play)[0]) > 0


def test_many_questions_get_their_own_answers(hurried):
    async def play(some):
        await answered(some)
        asked = [some.compute(f"{number}:", lambda number=number: b"x" * 997 * number) for number in range(90)]
        return await asyncio.gather(*asked)

    assert with_helpers(play) == [b"%d:" % number + b"x" * 997 * number for number in range(90)]


def test_what_one_cannot_take_yet_waits(hurried, monkeypatch):
    monkeypatch.setattr(helpers, "DEPTH", 2)
    given = []

    async def play(some):
        await answered(some)
        asked = [
            asyncio.create_task(some.compute(f"{number}", lambda number=number: given.append(number) or b"!"))
            for number in range(9)
        ]
        await asyncio.sleep(0)
        assert given == [0, 1]
        # Who goes away in the line takes no time.
        asked[4].cancel()
        return [await each for number, each in enumerate(asked) if number != 4]

    assert with_helpers(play) == [b"%d!" % number for number in range(9) if number != 4]
    assert given == [0, 1, 2, 3, 5, 6, 7, 8]


def test_a_line_has_an_end(hurried, monkeypatch):
    monkeypatch.setattr(helpers, "DEPTH", 1)
    monkeypatch.setattr(helpers, "WAITING", 2)

    async def play(some):
        await answered(some)
        asked = [asyncio.create_task(some.compute("a", lambda: b"")) for _ in range(4)]
        return await asyncio.gather(*asked, **KEPT)

    *found, refused = with_helpers(play)
    assert found == [b"a"] * 3
    assert isinstance(refused, NoAnswerError)
    assert (refused.status, refused.again) == (503, 2)


def test_what_waits_for_one_that_is_lost_hears_of_it(hurried, monkeypatch):
    monkeypatch.setattr(helpers, "DEPTH", 1)

    async def play(some):
        await answered(some)
        monkeypatch.setattr(helpers, "AGAIN", 60.0)
        return await asyncio.gather(*(some.compute(name, lambda: b"") for name in ("die", "a", "b")), **KEPT)

    assert [type(each) for each in with_helpers(play)] == [HelperGoneError] * 3


def test_two_share_what_there_is(hurried):
    async def play(some):
        await until_ready(some, 2)
        asked = [some.compute("pid", lambda: b"") for _ in range(40)]
        return await asyncio.gather(*asked)

    numbers = with_helpers(play, most=2)
    # Whoever is done first takes the next.
    assert len(set(numbers)) == 2
    assert all(numbers.count(number) > 5 for number in set(numbers))


def test_answers_that_wait_call_another_one(monkeypatch):
    monkeypatch.setattr(helpers, "EVERY", 0.01)
    monkeypatch.setattr(helpers, "AGAIN", 0.01)
    monkeypatch.setattr(helpers, "LOOKS", 1)
    monkeypatch.setattr(helpers, "LATE", -1.0)

    async def play(some):
        await answered(some)
        # The loop is not late any more, but what it has been asked is not answered.
        monkeypatch.setattr(helpers, "LATE", 0.5)
        some._most = 2
        assert some.running() == 1
        hanging = asyncio.create_task(some.compute("hang", lambda: b""))
        await until(lambda: some.running() == 2)
        hanging.cancel()

    with_helpers(play)


def test_there_are_no_more_than_allowed(hurried):
    async def play(some):
        await answered(some)
        await until(lambda: some.running() == 2)
        await asyncio.sleep(0.1)
        return some.running()

    assert with_helpers(play, most=2) == 2


def test_what_fails_there_fails_here_and_it_goes_on(hurried):
    async def play(some):
        first, _ = await answered(some)
        with pytest.raises(ComputingError, match="Traceback: it"):
            await some.compute("wrong", lambda: b"it")
        assert await some.compute("pid", lambda: b"") == first

    with_helpers(play)


@pytest.mark.parametrize("end", ["die", "babble"])
def test_one_that_is_lost_costs_no_answer(hurried, caplog, end):
    async def play(some):
        first, _ = await answered(some)
        # Asked before it is known to be lost.
        first_found, *lost = await asyncio.gather(
            *(some.compute(name, lambda: b"") for name in ("a", end, "b", "c")), **KEPT
        )
        assert first_found == b"a"
        assert [type(each) for each in lost] == [HelperGoneError] * 3
        second, _ = await answered(some)
        assert first != second
        assert not is_running(int(first))

    with_helpers(play)
    assert "A helper is gone" in caplog.text


def test_one_that_answers_what_nobody_asked_is_ended(hurried, caplog):
    async def play(some):
        first, _ = await answered(some)
        assert await some.compute("twice", lambda: b"") == b"once"
        await until(lambda: not is_running(int(first)))

    with_helpers(play)
    assert "nobody has asked for it" in caplog.text


def test_what_one_hangs_on_is_given_up_and_it_is_ended(hurried, caplog):
    async def play(some):
        first, _ = await answered(some)
        asked = []
        # The second has time left when the helper is ended.
        for name, seconds in (("hang", 0.2), ("behind", 60.0)):
            some._seconds = seconds
            asked.append(asyncio.create_task(some.compute(name, lambda: b"")))
            await asyncio.sleep(0)
        some._seconds = 0.2
        found = await asyncio.gather(*asked, **KEPT)
        await until(lambda: not is_running(int(first)))
        return found

    given_up, lost = with_helpers(play)
    assert isinstance(given_up, NoAnswerError)
    assert (given_up.status, given_up.again, given_up.message) == (504, None, "it has tried for 0.2 s")
    assert isinstance(lost, HelperGoneError)
    assert "has not answered hang within 0.2 s" in caplog.text


def test_who_waits_in_the_line_for_too_long_gives_up_too(hurried, monkeypatch):
    monkeypatch.setattr(helpers, "DEPTH", 1)

    async def play(some):
        await answered(some)
        some._seconds = 0.2
        return await asyncio.gather(*(some.compute("hang", lambda: b"") for _ in range(2)), **KEPT)

    assert [each.status for each in with_helpers(play)] == [504, 504]


def test_who_goes_away_leaves_the_others_their_answers(hurried):
    async def play(some):
        await answered(some)
        gone, stays = (asyncio.create_task(some.compute(name, lambda: b"")) for name in ("gone", "stays"))
        await asyncio.sleep(0)
        gone.cancel()
        return await stays

    assert with_helpers(play) == b"stays"


def test_one_that_nobody_needs_is_ended(hurried, monkeypatch, caplog):
    monkeypatch.setattr(helpers, "IDLE", 0.3)

    async def play(some):
        first, _ = await answered(some)
        monkeypatch.setattr(helpers, "LATE", 1.0)
        await until(lambda: not some.running())
        await until(lambda: not is_running(int(first)))

    with_helpers(play)
    assert not caplog.text


@pytest.mark.parametrize("start", ["sys.exit(1)", "raise RuntimeError('no')"])
def test_one_that_does_not_start_costs_nothing(hurried, caplog, start):
    async def play(some):
        await some.compute("a", lambda: b"")
        await until(lambda: "A helper is gone" in caplog.text)
        assert await some.compute("a", lambda: b"") is None

    with_helpers(play, start=start)


def test_a_command_that_there_is_not_costs_nothing(hurried, caplog):
    async def whole():
        some = Helpers(1, ("/there/is/no/such/command",))
        assert await some.compute("a", lambda: b"") is None
        await until(lambda: "A helper is gone: FileNotFoundError" in caplog.text)
        some.stop()
        return await some.compute("a", lambda: b"")

    assert asyncio.run(whole()) is None


def test_at_the_end_none_is_left(hurried):
    async def play(some):
        return (await answered(some))[0]

    number = int(with_helpers(play))
    for _ in range(100):
        if not is_running(number):
            break
        time.sleep(0.05)
    assert not is_running(number)
