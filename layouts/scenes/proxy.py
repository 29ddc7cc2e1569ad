"""The way to viser: its socket at /viser/<token> of this server, and nothing else of it.

Only what the page must say passes towards viser, that is where its camera stands: viser obeys every message, and one
of them opens a tunnel to the internet. Everything passes towards the browser.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from typing import TYPE_CHECKING

import msgspec
from fastapi import FastAPI, WebSocket
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed
from websockets.typing import Subprotocol

from layouts.scenes.page import protocol
from layouts.scenes.parting import unbind
from layouts.scenes.sessions import TOKEN, RefusedError, Session
from server.sockets import POLICY, TOO_LARGE

if TYPE_CHECKING:
    from layouts.scenes.host import Scenes

MESSAGE_LIMIT = 4_096
"""Bytes of one message of a browser; where its camera stands takes 250."""

NORMAL, GOING_AWAY, TRY_LATER = 1000, 1001, 1013

Three = tuple[float, float, float]


class Camera(msgspec.Struct, tag="ViewerCameraMessage", forbid_unknown_fields=True):
    """Where a camera stands, as viser's page says it.

    Attributes:
        wxyz: its orientation.
        position: where it is.
        fov: vertical field of view, rad.
        near: nearest distance that is drawn.
        far: farthest distance that is drawn.
        image_height: of the view, pixels.
        image_width: of the view, pixels.
        look_at: the point that it turns around.
        up_direction: of the view.
    """

    wxyz: tuple[float, float, float, float]
    position: Three
    fov: float
    near: float
    far: float
    image_height: float
    image_width: float
    look_at: Three
    up_direction: Three


CAMERA = msgspec.msgpack.Decoder(Camera)


def is_camera(message: bytes) -> bool:
    """Whether a message says where the camera stands, in finite numbers, and nothing else."""
    try:
        camera = CAMERA.decode(message)
    except (msgspec.MsgspecError, RecursionError):
        return False
    numbers = (*camera.wxyz, *camera.position, *camera.look_at, *camera.up_direction)
    rest = (camera.fov, camera.near, camera.far, camera.image_height, camera.image_width)
    return all(map(math.isfinite, (*numbers, *rest)))


def attach(server: FastAPI, scenes: Scenes) -> None:
    """Serve viser's socket."""

    @server.websocket("/viser/{token}")
    async def socket(websocket: WebSocket, token: str) -> None:
        if not TOKEN.fullmatch(token) or protocol() not in websocket.scope.get("subprotocols", ()):
            await websocket.close(POLICY)
            return
        try:
            session = scenes.admit(token)
        except RefusedError as refused:
            await websocket.close(TRY_LATER if refused.full else POLICY)
            return
        asleep = False
        try:
            asleep = await _serve(websocket, session, scenes)
        finally:
            scenes.release(session, asleep=asleep)


async def _serve(websocket: WebSocket, session: Session, scenes: Scenes) -> bool:
    """Copy both ways until either end closes; whether it ended idle."""
    port = await asyncio.to_thread(scenes.port)
    address = f"ws://127.0.0.1:{port}/{session.key}"
    # No proxy of the environment may stand between this process and itself.
    async with connect(
        address, subprotocols=[Subprotocol(protocol())], compression=None, max_size=None, ping_interval=None, proxy=None
    ) as viser:
        unbind(viser)
        await websocket.accept(viser.subprotocol)
        tasks = [
            asyncio.create_task(work)
            for work in (_down(viser, websocket), _up(websocket, viser, session), _watch(session, scenes.idle))
        ]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        code = next((task.result() for task in tasks if task in done and not task.exception()), GOING_AWAY)
        if code is not None:
            with contextlib.suppress(RuntimeError):  # the browser may have closed at the same moment
                await websocket.close(code)
    return code == IDLE_END


IDLE_END = 4000
"""Close code of a session that was idle."""


async def _down(viser: ClientConnection, websocket: WebSocket) -> int:
    """What viser says."""
    try:
        async for message in viser:
            await websocket.send_bytes(message if isinstance(message, bytes) else message.encode())
    except ConnectionClosed:
        pass
    return GOING_AWAY


async def _up(websocket: WebSocket, viser: ClientConnection, session: Session) -> int | None:
    """What the browser says, if it may; None when it has closed."""
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            return None
        data = message.get("bytes")
        if len(data or message.get("text") or "") > MESSAGE_LIMIT:
            return TOO_LARGE
        if data is not None and is_camera(data):
            session.touch()
            try:
                await viser.send(data)
            except ConnectionClosed:
                return GOING_AWAY


async def _watch(session: Session, idle: float) -> int:
    """Wait until the session must end."""
    while True:
        left = session.active + idle - time.monotonic()
        if left <= 0:
            return IDLE_END
        try:
            await asyncio.wait_for(session.ended.wait(), left)
        except TimeoutError:
            continue
        return GOING_AWAY
