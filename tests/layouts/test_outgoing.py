"""Files on their way out: whole, within their room, and without a trace whatever became of them."""

import asyncio
import io
from concurrent.futures import ThreadPoolExecutor
from contextlib import AsyncExitStack

import pytest
from starlette.requests import ClientDisconnect

from layouts import outgoing
from layouts.outgoing import PIECE, STEP, FullError, Outgoing, Sent
from server.limits import Places


@pytest.fixture
def room():
    """Room for four steps, three of them one client's."""
    return Places(4 * STEP, 3 * STEP)


def sent(stream, size, take):
    """Send a file to a client; what had become of it when it was over."""
    over = []

    async def play():
        with ThreadPoolExecutor(1) as readers:
            ending = AsyncExitStack()
            ending.callback(over.append, True)
            scope = {"type": "http", "asgi": {"spec_version": "2.3"}}
            await Sent(stream, size, readers, ending, media_type="text/csv")(scope, asyncio.Event().wait, take)

    try:
        asyncio.run(play())
    finally:
        assert over == [True]


@pytest.mark.parametrize("size", [0, 1, PIECE, PIECE + 1, STEP, STEP + 1, 2 * STEP + 5])
def test_what_is_written_is_sent_whole_and_takes_room_until_it_is_let_go(room, size):
    content, told = bytes(range(251)) * (size // 251 + 1), []

    async def take(message):
        told.append(message)

    file = Outgoing(room, "a", None)
    for start in range(0, size, 100_000):
        file.write(content[start : min(start + 100_000, size)])
    assert (file.size, room.total) == (size, -(-size // STEP) * STEP)
    sent(file.begin(), file.size, take)
    assert dict(told[0]["headers"])[b"content-length"] == b"%d" % size
    assert b"".join(each.get("body", b"") for each in told) == content[:size]
    assert max(len(each.get("body", b"")) for each in told) <= PIECE
    file.close()
    file.close()
    assert room.total == 0


@pytest.mark.parametrize("others", [0, 2])
def test_there_is_no_more_room_than_there_is_for_all_and_for_one(room, others):
    room.enter("b", others * STEP)
    file = Outgoing(room, "a", None)
    mine = min(3, 4 - others)
    file.write(bytes(mine * STEP))
    with pytest.raises(FullError):
        file.write(b"x")
    file.close()
    assert room.total == others * STEP


def test_who_still_writes_what_nobody_wants_is_stopped(room):
    file = Outgoing(room, "a", None)
    file.write(b"x")
    file.close()
    with pytest.raises(BrokenPipeError):
        file.write(b"y")


def test_a_small_one_needs_no_disk_and_a_large_one_says_that_there_is_none(room, tmp_path):
    file = Outgoing(room, "a", tmp_path / "nowhere")
    file.write(bytes(PIECE))
    with pytest.raises(FileNotFoundError):
        file.write(b"x")
    file.close()
    assert room.total == 0


def test_who_takes_too_long_has_left(monkeypatch):
    monkeypatch.setattr(outgoing, "LONGEST", 0.02)

    async def take(message):
        await asyncio.Event().wait()

    with pytest.raises(ClientDisconnect):
        sent(io.BytesIO(b"x"), 1, take)
