"""A browser's end of a scene, without a browser: says where its camera stands and reads what viser sends."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from typing import Any

import msgspec
import numpy as np
import zstandard
from viser import __version__ as viser_version
from viser._messages import ViewerCameraMessage
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

PROTOCOL = Subprotocol(f"viser-v{viser_version}")


def camera(**changed: Any) -> bytes:
    """Where the camera stands, in viser's own words."""
    stands: dict[str, Any] = {
        "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (3.0, 3.0, 3.0), "fov": 1.3, "near": 0.01, "far": 1000.0,
        "image_height": 600, "image_width": 800, "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
    }  # fmt: skip
    return msgspec.msgpack.encode(ViewerCameraMessage(**stands | changed).as_serializable_dict())


def decoded(frame: bytes) -> list[dict[str, Any]]:
    """The messages of a frame: sizes (8 bytes each), packed messages, then arrays at multiples of 8 bytes."""
    size, packed = int.from_bytes(frame[:8], "little"), int.from_bytes(frame[8:16], "little")
    text = zstandard.ZstdDecompressor().decompress(frame[16 : 16 + packed], max_output_size=size)
    content = msgspec.msgpack.decode(text)
    arrays, at = [], 16 + packed
    for length in content["binaryBufferLengths"]:
        at += -at % 8
        arrays.append(frame[at : at + length])
        at += length
    return [_with_arrays(message, arrays) for message in content["messages"]]


def _with_arrays(value: Any, arrays: list[bytes]) -> Any:
    if isinstance(value, dict):
        if "__binary_index" in value:
            return np.frombuffer(arrays[value["__binary_index"]], dtype=value["dtype"])
        return {key: _with_arrays(part, arrays) for key, part in value.items()}
    return [_with_arrays(part, arrays) for part in value] if isinstance(value, list) else value


@contextlib.asynccontextmanager
async def scene(port: int, token: str, **more: Any) -> AsyncIterator[ClientConnection]:
    """An open scene whose camera has been placed."""
    options: dict[str, Any] = {"origin": Origin(f"http://127.0.0.1:{port}"), "subprotocols": [PROTOCOL]} | more
    async with connect(
        f"ws://127.0.0.1:{port}/viser/{token}", compression=None, max_size=None, proxy=None, **options
    ) as socket:
        await socket.send(camera())
        yield socket


class View:
    """What a browser shows: every node of its scene with its properties, and the types of messages that came.

    Attributes:
        nodes: properties by name.
        visible: by name whether a node is, as far as that was said.
        kinds: types of the messages of each frame.
        sizes: bytes of each frame.
    """

    def __init__(self) -> None:
        self.nodes: dict[str, dict[str, Any]] = {}
        self.visible: dict[str, bool] = {}
        self.kinds: list[list[str]] = []
        self.sizes: list[int] = []

    @property
    def said(self) -> set[str]:
        """Types of all messages that came."""
        return {kind for kinds in self.kinds for kind in kinds}

    def take(self, frame: bytes) -> None:
        """Do what a frame says."""
        got = decoded(frame)
        self.kinds.append([message["type"] for message in got])
        self.sizes.append(len(frame))
        for message in got:
            if "props" in message and "name" in message:
                self.nodes[message["name"]] = dict(message["props"])
            elif message["type"] == "SceneNodeUpdateMessage":
                self.nodes[message["name"]] |= message["updates"]
            elif message["type"] == "SetSceneNodeVisibilityMessage":
                self.visible[message["name"]] = message["visible"]
            elif message["type"] == "RemoveSceneNodeMessage":
                self.nodes.pop(message["name"], None)

    async def until(self, socket: ClientConnection, shows: Callable[[View], bool], patience: float = 30) -> View:
        """Take frames until it shows something."""
        while not shows(self):
            frame = await asyncio.wait_for(socket.recv(), patience)
            assert isinstance(frame, bytes)
            self.take(frame)
        return self

    async def until_quiet(self, socket: ClientConnection, quiet: float = 0.5) -> View:
        """Take frames until none has come for so many seconds."""
        with contextlib.suppress(TimeoutError):
            while True:
                frame = await asyncio.wait_for(socket.recv(), quiet)
                assert isinstance(frame, bytes)
                self.take(frame)
        return self
