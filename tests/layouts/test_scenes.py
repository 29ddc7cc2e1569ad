"""Scenes through the proxy: who is let in, what each browser sees, how sessions end, and that nothing stays behind.

A real server and real sockets, whose browsers speak viser's protocol as far as they need.
"""

import asyncio
import contextlib
import re
import secrets
import time
from contextvars import copy_context
from pathlib import Path

import msgspec
import numpy as np
import pytest
import websockets.exceptions
from fastapi import FastAPI
from viser import _messages

from benchmarks.scene_browser import PROTOCOL, View, camera, scene
from benchmarks.scenes import serving
from layouts.scenes import RegionPicture, Scenes, Stats, TrackPicture
from layouts.scenes.host import LIMIT, REMEMBERED
from layouts.scenes.proxy import IDLE_END, MESSAGE_LIMIT, is_camera
from layouts.scenes.region import BOX
from layouts.scenes.sessions import RefusedError
from layouts.theme import tokens
from server import guard
from server.clients import CLIENT
from server.descriptors import OF_A_SCENE
from server.settings import Settings
from tests.leaving import there, without_the_collector
from tests.waiting import eventually
from tracker_core.checks import InputError

STABLE = RegionPicture((0.5, 0.3, 0.05), stable=True)
UNSTABLE = RegionPicture((1.5, 3.0, 6.0), stable=False)


@pytest.fixture(scope="module")
def scenes():
    """Scenes that are served for all tests of this file."""
    return Scenes()


@pytest.fixture(scope="module")
def port(scenes):
    """The port on which they are served."""
    with serving(scenes) as number:
        yield number


@pytest.fixture
def token():
    return secrets.token_hex(16)


def track(cursor=20, *, trail=False, shift=0.0, key="run", theme="light", samples=60, refused=None):
    times = np.arange(samples) * 1.0
    truth = np.stack((1000 * np.cos(times / 9), 800 * np.sin(times / 7)), axis=1)
    predicted = truth + 5 + shift
    predicted[0] = np.nan
    gone = None if refused is None else np.isin(np.arange(samples), refused)
    lines = (truth, truth + 9, predicted, truth + 2 + shift)
    return TrackPicture(key, times, *lines, cursor, trail, theme=theme, refused=gone)


def shown_gains(view):
    """The operating point as a browser sees it, in true numbers; the first vertex is the top of the ball."""
    vertices = np.reshape(view.nodes["/gains"]["vertices"], (-1, 3))[: 9 * 16]
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return tuple((middle[i] + axis.size / 2) * (axis.high - axis.low) / axis.size for i, axis in enumerate(BOX))


def at(gains):
    """Whether a browser sees the operating point there."""
    return lambda view: "/gains" in view.nodes and np.allclose(shown_gains(view), gains, atol=1e-4)


def run(work):
    return asyncio.run(asyncio.wait_for(work, 120))


async def refused(port, token, **more):
    """The HTTP status with which a socket is refused."""
    with pytest.raises(websockets.exceptions.InvalidStatus) as caught:
        async with scene(port, token, **more):
            pass
    return caught.value.response.status_code


async def closed(socket):
    """The code with which a connection ends."""
    with contextlib.suppress(websockets.exceptions.ConnectionClosed):
        while True:
            await asyncio.wait_for(socket.recv(), 30)
    return socket.close_code


# Who is let in -----------------------------------------------------------------------------------------------------


MALFORMED = ["0" * 31, "0" * 33, "g" * 32, "A" * 32, "0" * 31 + "%0a", "..", "x"]


@pytest.mark.parametrize("name", MALFORMED)
def test_what_is_no_token_is_refused(port, name):
    assert run(refused(port, name)) == 403


@pytest.mark.parametrize("protocols", [None, ["viser-v0.0.0"], ["chat"]])
def test_a_page_of_another_version_is_refused(port, token, protocols):
    assert run(refused(port, token, subprotocols=protocols)) == 403


def test_a_token_that_nobody_knows_is_accepted(port, scenes, token):
    """As after a restart: the scene is empty until something is shown."""

    async def look():
        async with scene(port, token) as socket:
            assert socket.subprotocol == PROTOCOL
            view = await View().until_quiet(socket)
            assert "/gains" not in view.nodes
            scenes.show(token, STABLE)
            await view.until(socket, at(STABLE.gains))

    run(look())


@pytest.mark.parametrize("name", ["", "0" * 31, "Z" * 32, "0" * 32 + "\n"])
def test_nothing_is_shown_for_what_is_no_token(scenes, name):
    with pytest.raises(InputError) as caught:
        scenes.show(name, STABLE)
    assert caught.value.field == "token"
    assert not name or name not in str(caught.value)


# What is seen ------------------------------------------------------------------------------------------------------


def test_two_browsers_see_two_operating_points(port, scenes):
    first, second = secrets.token_hex(16), secrets.token_hex(16)

    async def look():
        async with scene(port, first) as one, scene(port, second) as other:
            scenes.show(first, STABLE)
            scenes.show(second, UNSTABLE)
            views = [await View().until(one, at(STABLE.gains)), await View().until(other, at(UNSTABLE.gains))]
            scenes.show(first, RegionPicture((0.9, 0.8, 0.2), stable=True))
            await views[0].until(one, at((0.9, 0.8, 0.2)))
            await views[1].until_quiet(other)
            assert at(UNSTABLE.gains)(views[1])
            return [view.nodes["/gains"]["color"] for view in views]

    good, bad = run(look())
    assert "#{:02x}{:02x}{:02x}".format(*good) == tokens("light")["good"]
    assert "#{:02x}{:02x}{:02x}".format(*bad) == tokens("light")["bad"]


def test_a_picture_shown_before_the_browser_connects_is_there_when_it_does(port, scenes, token):
    async def look():
        scenes.show(token, STABLE)
        scenes.show(token, UNSTABLE)
        async with scene(port, token) as socket:
            view = await View().until(socket, at(UNSTABLE.gains))
            assert {"/region", "/region/edges", "/box/grid", "/box/axes"} <= set(view.nodes)
            texts = {node.get("text") for node in view.nodes.values()}
            assert {"α", "β", "γ", "0.5", "8"} <= texts
            assert "SetCameraPositionMessage" in view.said

    run(look())


def test_the_verdict_is_the_colour_of_the_point(port, scenes, token):
    async def look():
        async with scene(port, token) as socket:
            view, colours = View(), []
            for picture in (STABLE, UNSTABLE, STABLE):
                scenes.show(token, picture)
                await view.until(socket, at(picture.gains))
                await view.until_quiet(socket, 0.2)
                colours.append("#{:02x}{:02x}{:02x}".format(*view.nodes["/gains"]["color"]))
            assert colours == [tokens("light")[name] for name in ("good", "bad", "good")]

    run(look())


def test_a_cursor_that_moves_sends_little(port, scenes, token):
    async def look():
        async with scene(port, token) as socket:
            scenes.show(token, track(20, trail=True))
            view = await View().until(socket, lambda view: "/cursor/smoothed" in view.nodes)
            await view.until_quiet(socket)
            assert {"/truth", "/observed", "/predicted", "/smoothed", "/cursor/trail"} <= set(view.nodes)
            before, frames = dict(view.nodes), len(view.sizes)
            where = np.array(view.nodes["/cursor/smoothed"]["vertices"])
            for cursor in range(21, 31):
                scenes.show(token, track(cursor, trail=True))
                await asyncio.sleep(0.02)
            await view.until_quiet(socket)
            assert {kind for kinds in view.kinds[frames:] for kind in kinds} == {"SceneNodeUpdateMessage"}
            assert max(view.sizes[frames:]) < 6_000
            for name in ("/truth", "/observed", "/predicted", "/smoothed"):
                assert view.nodes[name] is before[name]
                np.testing.assert_array_equal(view.nodes[name]["points"], before[name]["points"])
            assert not np.allclose(view.nodes["/cursor/smoothed"]["vertices"], where)

    run(look())


def test_other_gains_change_the_lines_of_the_filter_alone(port, scenes, token):
    async def look():
        async with scene(port, token) as socket:
            scenes.show(token, track())
            view = await View().until(socket, lambda view: "/cursor/smoothed" in view.nodes)
            await view.until_quiet(socket)
            frames, before = len(view.kinds), {name: np.array(view.nodes[name]["points"]) for name in LINES}
            scenes.show(token, track(shift=50.0))
            await view.until_quiet(socket)
            assert {kind for kinds in view.kinds[frames:] for kind in kinds} == {"SceneNodeUpdateMessage"}
            same = {name: np.array_equal(view.nodes[name]["points"], before[name]) for name in LINES}
            assert same == {"/truth": True, "/observed": True, "/predicted": False, "/smoothed": False}

    run(look())


LINES = ("/truth", "/observed", "/predicted", "/smoothed")


def test_what_a_gate_refuses_is_marked_among_what_was_observed(port, scenes, token):
    async def look():
        async with scene(port, token) as socket:
            view = View()
            for refused in (None, [7, 30], [30], []):
                scenes.show(token, track(refused=refused))
                await view.until(socket, lambda view: "/cursor/smoothed" in view.nodes)
                await view.until_quiet(socket)
                assert view.visible["/refused"] == bool(refused)
                if not refused:
                    continue
                node = view.nodes["/refused"]
                observed = np.reshape(view.nodes["/observed"]["points"], (-1, 3))
                np.testing.assert_array_equal(np.reshape(node["points"], (-1, 3)), observed[refused])
                assert "#{:02x}{:02x}{:02x}".format(*node["colors"][:3]) == tokens("light")["bad"]

    run(look())


@pytest.mark.parametrize(
    "then",
    [track(key="another"), track(theme="dark"), STABLE, RegionPicture(UNSTABLE.gains, stable=False, theme="dark")],
)
def test_another_kind_of_picture_replaces_the_scene(port, scenes, token, then):
    async def look():
        async with scene(port, token) as socket:
            scenes.show(token, track())
            view = await View().until(socket, lambda view: "/truth" in view.nodes)
            await view.until_quiet(socket)
            before = list(view.nodes.values())
            scenes.show(token, then)
            await view.until_quiet(socket, 1)
            assert ("/truth" in view.nodes) == isinstance(then, TrackPicture)
            assert ("/gains" in view.nodes) == isinstance(then, RegionPicture)
            kept = [name for name, node in view.nodes.items() if any(node is old for old in before)]
            # The axes that viser makes itself, hidden.
            assert kept == ["/WorldAxes"]

    run(look())


# What a browser may say --------------------------------------------------------------------------------------------


def test_where_the_camera_stands_is_all_a_browser_may_say():
    assert is_camera(camera())
    assert is_camera(camera(image_height=600.5, position=(1, 2, 3)))


NOT_A_CAMERA = {
    "empty": b"",
    "text": b"hello",
    "a number": msgspec.msgpack.encode(5),
    "tunnel": msgspec.msgpack.encode(_messages.ShareUrlRequest().as_serializable_dict()),
    "tunnel shut": msgspec.msgpack.encode(_messages.ShareUrlDisconnect().as_serializable_dict()),
    "no type": msgspec.msgpack.encode({"position": [0, 0, 0]}),
    "not finite": camera(position=(float("nan"), 0.0, 0.0)),
    "too long a place": msgspec.msgpack.encode(msgspec.msgpack.decode(camera()) | {"position": [0.0] * 4}),
    "too short a place": msgspec.msgpack.encode(msgspec.msgpack.decode(camera()) | {"look_at": [0.0] * 2}),
    "more than a place": msgspec.msgpack.encode(msgspec.msgpack.decode(camera()) | {"name": "x"}),
    "no numbers": msgspec.msgpack.encode({"type": "ViewerCameraMessage", "fov": "wide"}),
    "deep": b"\x91" * 3000,
}


@pytest.mark.parametrize("message", NOT_A_CAMERA.values(), ids=NOT_A_CAMERA)
def test_everything_else_is_dropped(port, scenes, token, message):
    assert not is_camera(message)

    async def look():
        async with scene(port, token) as socket:
            scenes.show(token, STABLE)
            view = await View().until(socket, at(STABLE.gains))
            await socket.send(message)
            await socket.send("text")
            scenes.show(token, UNSTABLE)
            await view.until(socket, at(UNSTABLE.gains))
            assert "ShareUrlUpdated" not in view.said

    run(look())


@pytest.mark.parametrize("message", [b"x" * (MESSAGE_LIMIT + 1), "x" * (MESSAGE_LIMIT + 1)])
def test_a_message_that_is_too_long_ends_the_session(port, scenes, token, message):
    async def look():
        async with scene(port, token) as socket:
            await socket.send(message)
            assert await closed(socket) == 1009

    run(look())


# How sessions end --------------------------------------------------------------------------------------------------


def test_of_two_with_one_token_the_newest_stays(port, scenes, token):
    async def look():
        scenes.show(token, STABLE)
        async with scene(port, token) as old:
            await View().until(old, at(STABLE.gains))
            async with scene(port, token) as new:
                view = await View().until(new, at(STABLE.gains))
                assert await closed(old) == 1001
                await eventually(lambda: scenes.stats().sessions == 1)
                scenes.show(token, UNSTABLE)
                await view.until(new, at(UNSTABLE.gains))
        await eventually(lambda: scenes.stats().sessions == 0)

    run(look())


def test_an_idle_session_ends_and_stays_ended_until_something_is_shown(token):
    idle = Scenes(idle=0.8)
    with serving(idle) as port:

        async def look():
            idle.show(token, STABLE)
            async with scene(port, token) as socket:
                assert await closed(socket) == IDLE_END
            await eventually(lambda: idle.stats().sessions == 0)
            assert await refused(port, token) == 403
            assert await refused(port, token) == 403
            idle.show(token, UNSTABLE)
            async with scene(port, token) as socket:
                await View().until(socket, at(UNSTABLE.gains))

        run(look())


@pytest.mark.parametrize("sign", ["camera", "picture"])
def test_a_session_in_use_does_not_end(token, sign):
    busy = Scenes(idle=2.0)
    with serving(busy) as port:

        async def look():
            async with scene(port, token) as socket:
                begun = time.monotonic()
                while time.monotonic() - begun < 5:
                    if sign == "camera":
                        await socket.send(camera())
                    else:
                        busy.show(token, STABLE)
                    await asyncio.sleep(0.1)
                assert socket.close_code is None
                assert busy.stats().sessions == 1

        run(look())


def test_no_more_than_the_limit_are_let_in(monkeypatch):
    monkeypatch.setattr("layouts.scenes.host.share", lambda most: most)
    few = Scenes(limit=2)
    tokens = [secrets.token_hex(16) for _ in range(3)]
    with serving(few) as port:

        async def look():
            async with scene(port, tokens[0]), scene(port, tokens[1]):
                await eventually(lambda: few.stats().sessions == 2)
                assert await refused(port, tokens[2]) == 403
                # A token that is in already replaces itself.
                async with scene(port, tokens[1]) as again:
                    await View().until_quiet(again)
            await eventually(lambda: few.stats().sessions == 0)
            async with scene(port, tokens[2]) as late:
                await View().until_quiet(late)

        run(look())


def test_one_client_has_its_share_and_no_more():
    one, two, three, four = (f"{number:032x}" for number in range(4))

    async def play():
        scenes = Scenes(limit=3)

        def comes(token, client):
            CLIENT.set(client)
            try:
                return scenes.admit(token)
            except RefusedError:
                return None

        first = comes(one, "a")
        assert comes(two, "a")
        assert not comes(three, "a")
        assert comes(three, "b")
        assert not comes(four, "b"), "there are three"
        # One that comes again takes no other place, whoever it is of by now.
        assert comes(two, "a")
        assert comes(two, "b")
        assert not comes(one, "b")
        scenes.release(first)
        assert comes(four, "a")

    run(play())


def test_a_scene_is_of_the_client_that_the_guard_knows(token):
    """The addresses of one network are one client's."""
    sent = []

    async def receive():
        return {"type": "websocket.connect"}

    async def send(message):
        sent.append(message)

    async def play():
        scenes, server = Scenes(limit=2), FastAPI()
        scenes.attach(server)
        guard.attach(server, Settings())
        CLIENT.set("2001:db8::/64")
        scenes.admit("0" * 32)
        headers = [(b"host", b"gainscope.test"), (b"origin", b"http://gainscope.test")]
        path = f"/viser/{token}"
        await server(
            {
                "type": "websocket", "path": path, "raw_path": path.encode(), "query_string": b"", "headers": headers,
                "subprotocols": [PROTOCOL], "client": ("2001:db8::7", 1), "root_path": "", "scheme": "ws",
            },
            receive, send,
        )  # fmt: skip

    run(play())
    assert [message["code"] for message in sent] == [1013]


def test_a_scene_takes_no_more_descriptors_than_are_counted_for_it(port, scenes):
    def taken():
        return sum(1 for _ in Path("/proc/self/fd").iterdir())

    async def look():
        async with visitor(port, scenes):
            before = taken()
            async with visitor(port, scenes), visitor(port, scenes):
                # Both ends of a browser's socket are in this process.
                assert taken() - before <= 2 * (2 + OF_A_SCENE)

    run(look())


def test_after_a_restart_the_same_token_works(token):
    async def look(scenes, port):
        scenes.show(token, STABLE)
        async with scene(port, token) as socket:
            await View().until(socket, at(STABLE.gains))

    for _ in range(2):
        scenes = Scenes()
        with serving(scenes) as port:
            run(look(scenes, port))
        assert scenes.stats().sessions == 0


def test_closing_ends_the_sessions(token):
    scenes = Scenes()
    with serving(scenes) as port:

        async def look():
            async with scene(port, token) as socket:
                await View().until_quiet(socket)
                await asyncio.to_thread(scenes.close)
                assert await closed(socket) == 1001

        run(look())


def test_closing_what_was_never_used_starts_nothing():
    unused = Scenes()
    unused.close()
    assert unused._server is None
    assert unused.stats().sessions == 0


# What stays behind -------------------------------------------------------------------------------------------------


@contextlib.asynccontextmanager
async def visitor(port, scenes):
    """A browser that nobody knows looks at a track, for as long as this lasts."""
    token = secrets.token_hex(16)
    scenes.show(token, track())
    async with scene(port, token) as socket:
        await View().until(socket, lambda view: "/truth" in view.nodes)
        yield


def test_nothing_stays_behind(port, scenes):
    async def look():
        for _ in range(5):
            async with visitor(port, scenes):
                pass
        await eventually(lambda: scenes.stats().sessions == 0)
        viser = scenes._server
        await eventually(lambda: not viser.get_clients())
        kept = viser._websock_server
        await eventually(lambda: not kept._live_connections)
        assert not kept._client_state_from_id
        assert not kept._broadcast_buffer.generator_cursors
        assert not scenes._waiting
        # The axes that viser makes itself, hidden.
        assert set(viser.scene._handle_from_node_name) == {"/WorldAxes"}

    run(look())


ENDING = {
    "_message_producer", "LineSegmentsProps", "MeshProps", "ClientHandle", "CameraHandle", "ServerConnection",
}  # fmt: skip
"""What holds compressors, points or buffers of a connection, by the name of its type, or of what it computes."""


def test_a_scene_goes_without_the_collector(port, scenes):
    async def look():
        async with without_the_collector(ENDING):
            for _ in range(3):
                async with visitor(port, scenes):
                    opened = there(ENDING)
                    assert {"_message_producer", "LineSegmentsProps", "ClientHandle", "ServerConnection"} <= opened

    run(look())


def test_pictures_are_forgotten_in_time_and_beyond_a_number(monkeypatch):
    """Of one client half of them, whose own are forgotten then and nobody else's."""
    scenes, most = Scenes(), REMEMBERED * LIMIT

    def remembered(client, first, number):
        def shown():
            CLIENT.set(client)
            for token in range(first, first + number):
                scenes.show(f"{token:032x}", STABLE)
            return scenes.stats().pictures

        return copy_context().run(shown)

    assert remembered("a", 0, 3) == 3
    assert remembered("b", 1000, most) == 3 + most // 2
    # The same again is no further one.
    assert remembered("b", 1000 + most - 1, 1) == 3 + most // 2
    assert {f"{token:032x}" for token in range(3)} <= set(scenes._pictures)
    assert remembered("c", 2000, most) == most
    now = time.monotonic()
    monkeypatch.setattr(time, "monotonic", lambda: now + 7 * 3600)
    scenes.show("f" * 32, STABLE)
    assert scenes.stats().pictures == 1


def test_showing_needs_no_server(monkeypatch):
    monkeypatch.setattr("layouts.scenes.host._start", lambda: pytest.fail("it must not come to this"))
    scenes = Scenes()
    scenes.show("0" * 32, track())
    assert scenes.stats() == Stats(sessions=0, pictures=1)


def test_viser_listens_on_the_loopback_alone_and_prints_nothing(port, scenes, token, capfd):
    async def look():
        async with scene(port, token) as socket:
            await View().until_quiet(socket)
            bound = scenes._server._websock_server._host
            assert bound == "127.0.0.1"

    run(look())
    fresh = Scenes()
    fresh.port()
    fresh.close()
    assert capfd.readouterr() == ("", "")


def test_who_comes_to_viser_itself_gets_nothing(port, scenes, token):
    """A process of this machine may reach its port, but has no key, and opens no tunnel."""

    async def look():
        scenes.show(token, STABLE)
        async with scene(port, token) as socket:
            await View().until(socket, at(STABLE.gains))
            address = f"ws://127.0.0.1:{scenes.port()}/{token}"
            async with websockets.connect(address, subprotocols=[PROTOCOL], proxy=None) as stranger:
                await stranger.send(camera())
                await stranger.send(NOT_A_CAMERA["tunnel"])
                view = await View().until_quiet(stranger, 1)
                assert "/gains" not in view.nodes
                assert "ShareUrlUpdated" not in view.said

    run(look())


def test_no_token_is_in_what_a_session_says_of_itself(scenes, token):
    async def admit():
        session = scenes.admit(token)
        scenes.release(session)
        return repr(session)

    assert not re.search(r"[0-9a-f]{32}", run(admit()))
