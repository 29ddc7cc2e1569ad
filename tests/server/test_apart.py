"""Work in another process: what comes back, what is done here instead, and that nothing of it is left."""

import contextlib
import operator
import os
import pickle
import resource
import signal
import subprocess
import sys
import time
from concurrent.futures import CancelledError, Executor, Future
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from server import apart, child
from server.apart import Apart
from tests.waiting import is_running
from tracker_core import Experiment, InputError
from tracker_core.checks import POSITIVE
from tracker_core.tuning import Sweep, base, evaluate

THREADS = 2
PROGRAM = """
from tracker_core.kernels import signatures
# Compiled code is loaded when it is called: the process is there sooner.
signatures.SIGNATURES = {}
from server.apart import main
main()
"""
COMMAND = (sys.executable, "-c", PROGRAM, "json", "info", str(THREADS))
PATIENCE = 60


class Here(Executor):
    """Does nothing, and says so."""

    def __init__(self):
        self.calls = []

    def submit(self, work, /, *arguments, **named):
        self.calls.append(partial(work, *arguments, **named))
        future = Future()
        future.set_result("here")
        return future


class Failing(Executor):
    def submit(self, work, /, *arguments, **named):
        future = Future()
        future.set_exception(InputError("seed", "must be done here", 1))
        return future


def until(condition):
    for _ in range(PATIENCE * 50):
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError("it did not come to that")


def made_ready(some):
    """A process that answers; its number."""
    until(lambda: some.submit(os.getpid).result(PATIENCE) != "here")
    return some.submit(os.getpid).result(PATIENCE)


@pytest.fixture
def some():
    """An executor that has its process."""
    executor = Apart(COMMAND, THREADS, Here())
    made_ready(executor)
    yield executor
    executor.shutdown()
    until(lambda: not executor.running())


@pytest.fixture
def hurried(monkeypatch):
    monkeypatch.setattr(apart, "AGAIN", 0.0)


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """On a machine where others want the processors too, the process may be a while without any."""
    monkeypatch.setattr(apart, "HURRY", 60.0)


def test_until_it_is_there_work_is_done_here():
    here = Here()
    executor = Apart(COMMAND, THREADS, here)
    assert not executor.running()
    assert executor.submit(os.getpid).result(PATIENCE) == "here"
    assert executor.running()
    assert made_ready(executor) not in ("here", os.getpid())
    executor.shutdown()


def test_answers_belong_to_their_questions(some):
    slow = some.submit(time.sleep, 0.3)
    quick = [some.submit(operator.mul, "abc", number) for number in range(200)]
    assert [future.result(PATIENCE) for future in quick] == ["abc" * number for number in range(200)]
    # There is a thread for them beside the one that sleeps.
    assert not slow.done()
    assert slow.result(PATIENCE) is None


def test_what_is_large_comes_whole(some):
    sent = np.random.default_rng(1).normal(size=1_300_000)
    assert np.array_equal(some.submit(np.negative, sent).result(PATIENCE), -sent)


def test_an_error_comes_as_it_was_raised(some):
    future = some.submit(POSITIVE.check, "interval", -1.5)
    with pytest.raises(InputError) as caught:
        future.result(PATIENCE)
    assert (caught.value.field, caught.value.received) == ("interval", -1.5)
    assert "in check" in caught.value.__notes__[0]
    assert some.submit(os.getpid).result(PATIENCE)


def test_what_cannot_be_sent_is_refused_at_once(some):
    with pytest.raises((pickle.PicklingError, AttributeError)):
        some.submit(lambda: 1)
    assert some.submit(abs, -3).result(PATIENCE) == 3


def test_it_computes_when_nobody_else_does(some):
    assert some.submit(os.sched_getscheduler, 0).result(PATIENCE) == os.SCHED_IDLE
    assert os.sched_getscheduler(0) != os.SCHED_IDLE


def test_one_that_is_killed_costs_no_work(some, hurried, caplog):
    first = made_ready(some)
    futures = [some.submit(time.sleep, 30) for _ in range(3)]
    os.kill(first, signal.SIGKILL)
    assert [future.result(PATIENCE) for future in futures] == ["here"] * 3
    assert [call.args for call in some._here.calls[-3:]] == [(30,)] * 3
    assert "is done here" in caplog.text
    # Another one takes its place.
    assert made_ready(some) != first
    assert not is_running(first)


def test_what_fails_here_in_its_place_fails(some, hurried):
    some._here = Failing()
    future = some.submit(os._exit, 3)
    with pytest.raises(InputError, match="must be done here"):
        future.result(PATIENCE)


def test_one_that_cannot_live_is_not_started_again_and_again(tmp_path):
    log = tmp_path / "starts"
    code = f"open({str(log)!r}, 'a').write('x')"
    executor = Apart((sys.executable, "-c", code), THREADS, Here())
    executor.submit(abs, 1)
    until(lambda: not executor.running())
    assert {executor.submit(abs, 1).result(PATIENCE) for _ in range(50)} == {"here"}
    assert log.read_text() == "x"
    executor.shutdown()


@pytest.mark.parametrize(
    "said",
    [b"\x03\x00\x00\x00abc", b"\x05\x00\x00\x00ab", child.framed(pickle.dumps(7)), child.framed(pickle.dumps((1, 2)))],
)
def test_one_that_babbles_is_ended(said, caplog):
    code = (
        "import sys, time; from server.child import framed; sys.stdout.buffer.write(framed(b'')); "
        f"sys.stdout.flush(); sys.stdin.buffer.read(1); sys.stdout.buffer.write({said!r}); sys.stdout.flush()"
    )
    executor = Apart((sys.executable, "-c", code), THREADS, Here())
    executor.submit(abs, 1)
    until(lambda: executor._process is None or executor._process._ready)
    assert executor.submit(abs, -2).result(PATIENCE) == "here"
    until(lambda: not executor.running())
    executor.shutdown()


def test_a_command_that_there_is_not_costs_nothing(caplog):
    executor = Apart(("/there/is/no/such/command",), THREADS, Here())
    assert executor.submit(abs, 1).result(PATIENCE) == "here"
    assert not executor.running()
    assert "could not be started: FileNotFoundError" in caplog.text


def test_its_pipe_may_have_any_number():
    """A server has more sockets than `select` can look at."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < 1200:
        pytest.skip("there are no such numbers here")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, 1200), hard))
    with contextlib.ExitStack() as held:
        held.callback(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        while (number := os.dup(2)) < 1024:
            held.callback(os.close, number)
        held.callback(os.close, number)
        executor = Apart(COMMAND, THREADS, Here())
        made_ready(executor)
        assert executor.submit(abs, -1).result(PATIENCE) == 1
        executor.shutdown()
        until(lambda: not executor.running())


def test_an_answer_that_nobody_waits_for_is_no_fault(some):
    number = made_ready(some)
    late = some.submit(time.sleep, 0.2)
    assert late.cancel()
    time.sleep(0.3)
    assert made_ready(some) == number


def test_what_nobody_wants_any_more_is_not_begun(some, tmp_path):
    held = [some.submit(time.sleep, 0.5) for _ in range(THREADS)]
    unwanted = some.submit((tmp_path / "begun").touch)
    assert unwanted.cancel()
    assert [future.result(PATIENCE) for future in held] == [None] * THREADS
    assert some.submit(abs, -1).result(PATIENCE) == 1
    assert not (tmp_path / "begun").exists()


def test_where_no_answer_comes_the_oldest_is_done_here_one_at_a_time(some, monkeypatch):
    monkeypatch.setattr(apart, "HURRY", 0.2)
    doing = []

    class Slow(Executor):
        def submit(self, work, /, *arguments, **named):
            future = Future()
            doing.append((work, future))
            return future

    some._here = Slow()
    first, second, third = (some.submit(time.sleep, 30) for _ in range(3))
    until(lambda: len(doing) == 1)
    time.sleep(0.6)
    ((call, here),) = doing
    assert call.args == (30,)
    here.set_result("first")
    assert first.result(PATIENCE) == "first"
    until(lambda: len(doing) == 2)
    doing[1][1].set_exception(InputError("seed", "must be done here", 1))
    with pytest.raises(InputError):
        second.result(PATIENCE)
    assert not third.done()
    # The third was not begun there: with the others given up, both threads are busy with them still.
    until(lambda: len(doing) == 3)
    third.cancel()
    doing[2][1].set_result("too late")
    assert third.cancelled()


def test_as_long_as_answers_come_none_is_overdue(some, monkeypatch):
    monkeypatch.setattr(apart, "HURRY", 2.0)
    some._here.calls.clear()
    futures = [some.submit(time.sleep, 0.1) for _ in range(25 * THREADS)]
    assert [future.result(PATIENCE) for future in futures] == [None] * 25 * THREADS
    assert some._here.calls == []


def test_whoever_is_first_is_heard(some, monkeypatch):
    monkeypatch.setattr(apart, "HURRY", 0.1)
    never = Future()

    class Never(Executor):
        def submit(self, work, /, *arguments, **named):
            return never

    some._here = Never()
    assert some.submit(time.sleep, 0.8).result(PATIENCE) is None
    never.set_result("too late")


def test_one_that_does_not_listen_holds_nobody_up(some, monkeypatch):
    number = made_ready(some)
    os.kill(number, signal.SIGSTOP)
    try:
        monkeypatch.setattr(apart, "HURRY", 0.5)
        # More than a pipe holds.
        assert some.submit(np.negative, np.zeros(1_000_000)).result(PATIENCE) == "here"
        assert some.submit(np.negative, np.zeros(1_000_000)).result(PATIENCE) == "here"
    finally:
        monkeypatch.setattr(apart, "HURRY", 60.0)
        os.kill(number, signal.SIGCONT)
    assert made_ready(some) == number


def test_it_is_started_where_it_is_said(tmp_path):
    executor = Apart(COMMAND, THREADS, Here(), folder=Path(__file__).parents[2])
    before = Path.cwd()
    os.chdir(tmp_path)
    try:
        made_ready(executor)
    finally:
        os.chdir(before)
    assert executor.submit(os.getcwd).result(PATIENCE) == str(Path(__file__).parents[2])
    executor.shutdown()


def test_where_it_may_not_start_yet_it_does_not():
    executor = Apart(COMMAND, THREADS, Here(), lambda: False)
    assert executor.submit(abs, 1).result(PATIENCE) == "here"
    assert not executor.running()


def test_one_that_nobody_needs_is_ended(hurried, monkeypatch, caplog):
    monkeypatch.setattr(apart, "IDLE", 0.2)
    executor = Apart(COMMAND, THREADS, Here())
    number = made_ready(executor)
    # What takes longer is waited for.
    assert executor.submit(time.sleep, 0.4).result(PATIENCE) is None
    until(lambda: not executor.running())
    assert not is_running(number)
    assert not caplog.text
    # It is there again when it is needed.
    assert made_ready(executor) != number
    executor.shutdown()


def test_at_the_end_nothing_is_left(caplog):
    executor = Apart(COMMAND, THREADS, Here())
    number = made_ready(executor)
    given_up = executor.submit(time.sleep, 30)
    executor.shutdown()
    with pytest.raises(CancelledError):
        given_up.result(PATIENCE)
    until(lambda: not is_running(number))
    assert executor.submit(abs, 1).result(PATIENCE) == "here"
    until(lambda: not executor.running())
    assert not caplog.text


def test_without_a_server_it_ends_whatever_it_does():
    with subprocess.Popen(COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert child.text_in(process.stdout.read) == pickle.dumps(None, 5)
        call = partial(time.sleep, 60)
        process.stdin.write(child.framed(pickle.dumps((0, call), 5)))
        process.stdin.close()
        assert process.wait(PATIENCE) == 0


def test_who_asks_and_goes_away_leaves_the_others_their_answers(some):
    gone, stays = some.submit(time.sleep, 0.1), some.submit(abs, -1)
    assert gone.cancel()
    assert stays.result(PATIENCE) == 1
    assert some.submit(abs, -2).result(PATIENCE) == 2


def test_a_study_comes_to_the_same_bits(some, monkeypatch):
    for module in (base, evaluate):
        monkeypatch.setattr(module, "BLOCK_STEPS", 4_000)
    experiment = Experiment.from_dict({"samples": 60, "order": 2, "xi": 0.6, "seed": 3})
    sweep = Sweep(experiment, "xi", tuple(np.linspace(0.1, 0.9, 30)), "estimation_rmse", 12)
    there, here = ([step.outcome.scores.copy() for step in sweep.stream(where)] for where in (some, None))
    assert len(there) == len(here) > 3
    assert all(one.tobytes() == other.tobytes() for one, other in zip(there, here, strict=True))
    # None of it was done here.
    assert all(call.func is os.getpid for call in some._here.calls)
