"""A simulated user: a hand on the pages, and the pages' scripts behind it.

Such a user opens a page, drags sliders, chooses from menus, saves results and goes on to the next page. What a hand
does once is one action: a step of a slider, a choice, a page. A drag is some steps and then a rest, in which the page
draws its plots anew, as assets/desk.js does.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
from collections.abc import Awaitable, Callable, Iterator, Sequence
from functools import partial
from random import Random
from time import perf_counter
from typing import Any

import orjson
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Origin

from benchmarks.scene_browser import camera, scene
from trials.page import STUDYING, Desk, RefusedError, Site, text_part, whole
from trials.tally import Tally
from trials.wire import PATIENCE, Client

DESIGNS = {"fading-memory": "xi", "kalata": "tracking_index", "manual": "alpha"}
"""What is chosen most, and the slider that goes with it."""

CHOICES = ("design", "order", "quantity", "axis", "start", "convention", "seed")

RECORDING = b"t,x,y\n" + b"".join(b"%d,%d,%d\n" % (row, 3 * row, row * row // 50) for row in range(300))

Act = tuple[str, Callable[[], Awaitable[None]]]
"""An action: its kind, and what is done."""


class User:
    """One browser and who sits before it.

    Args:
        port: of the server.
        address: of the browser.
        seed: by which everything is chosen.
        tally: where it is counted.
        pages: that are opened.
    """

    def __init__(self, port: int, address: str, seed: int, tally: Tally, pages: Sequence[str]) -> None:
        self._client = Client(port, address)
        self._random = Random(seed)
        self._tally = tally
        self._pages = pages
        self._site: Site | None = None
        self._desk: Desk | None = None
        self._parts: list[str] = []
        self._live: ClientConnection | None = None
        self._scene = ""
        self._beside: set[asyncio.Task[None]] = set()

    async def live(self, pace: float, until: Callable[[], bool]) -> None:
        """Do one thing after the other until it is over.

        Args:
            pace: seconds from action to action; what takes longer makes those after it late.
            until: says whether it is over.
        """
        due = perf_counter()
        for kind, act in self._acts():
            if until():
                break
            await asyncio.sleep(due - perf_counter())
            try:
                await act()
            except Exception as error:  # noqa: BLE001 - whatever it was, it counts
                self._tally.errors[f"{kind}: {type(error).__name__} {error}"[:300]] += 1
                await self._leave()
            self._tally.count(kind, perf_counter() - due)
            due += pace
        await self._leave()
        await self._client.close()

    # What a hand does ---------------------------------------------------------------------------------------------

    def _acts(self) -> Iterator[Act]:
        """Page after page, on each some gestures."""
        yield "load", self._load
        while True:
            page = self._random.choice(self._pages)
            if page == "papers":
                yield "page", self._open_papers
                for _ in range(self._random.randint(4, 10)):
                    yield "part", self._part
                continue
            if page == "learn":
                yield "page", self._open_learn
                continue
            yield "page", partial(self._open, page)
            for _ in range(self._random.randint(3, 6)):
                yield from self._gesture()

    def _gesture(self) -> Iterator[Act]:
        gesture = self._random.choices(("drag", "choose", "export", "upload"), (60, 25, 12, 3))[0]
        if gesture == "upload":
            yield "upload", self._upload
        elif gesture == "export":
            yield "export", self._export
        elif gesture == "choose" or self._desk is None or not self._desk.sliders:
            yield "choose", self._choose
        else:
            for _ in range(self._random.randint(3, 9)):
                yield "move", self._move
            yield "rest", self._rest

    async def _load(self) -> None:
        self._site = await Site.load(self._client)

    async def _turn_to(self, page: str, link: str = "") -> dict[str, Any]:
        """Leave the page for another; what its script begins with."""
        if self._site is None:
            await self._load()
        assert self._site is not None
        await self._leave()
        return await self._site.beginning(self._client, page, link)

    async def _open(self, page: str) -> None:
        self._desk = Desk(await self._turn_to(page, self._desk.link if self._desk else ""))
        if page == "track":
            self._scene = secrets.token_hex(16)
            self._go(partial(self._watch, self._scene))
        answered, opened = await asyncio.gather(self._ask({}), self._socket(f"/{page}/live"), return_exceptions=True)
        # Kept in any case, so that it is closed.
        self._live = opened if isinstance(opened, ClientConnection) else None
        for outcome in (answered, opened):
            if isinstance(outcome, BaseException):
                raise outcome
        if page in STUDYING:
            self._go(partial(self._study, page))

    async def _open_papers(self) -> None:
        self._desk = None
        beginning = await self._turn_to("papers")
        self._parts = [f"/papers/{beginning['paper']}/{part}.json?theme=light" for part in beginning["tables"]]

    async def _open_learn(self) -> None:
        self._desk = None
        # All that is asked there is answered in the browser.
        await self._turn_to("learn")

    async def _part(self) -> None:
        if self._parts:
            answer = whole(await self._client.ask("GET", self._random.choice(self._parts)), "part")
            orjson.loads(answer.body)

    async def _ask(self, changed: dict[str, Any], want: Sequence[str] = ()) -> None:
        """A question to the callback."""
        desk = self._desk
        assert desk is not None
        assert self._site is not None
        question = desk.question(changed, want=want, scene=self._scene)
        answer = await self._site.call(self._client, f"{desk.name}-request.data", [question])
        self._tally.refused += not desk.take(answer[f"{desk.name}-answer"]["data"])

    async def _move(self) -> None:
        desk = await self._at_desk()
        name = DESIGNS.get(desk.values["design"], "xi")
        slider = desk.sliders[name]
        high = min(slider["high"], 1.0)
        value = slider["low"] + (high - slider["low"]) * self._random.uniform(0.05, 0.95)
        question = desk.question({name: round(value, 5)}, live=True, scene=self._scene)
        assert self._live is not None
        await self._live.send(orjson.dumps(question).decode())
        async with asyncio.timeout(PATIENCE):
            message = await self._live.recv(decode=False)
        self._tally.refused += not desk.take(text_part(message), live=True)

    async def _rest(self) -> None:
        desk = await self._at_desk()
        if desk.stale:
            await self._ask({}, want=desk.stale)

    async def _choose(self) -> None:
        desk = await self._at_desk()
        name = self._random.choice(CHOICES)
        choices = {"design": list(DESIGNS), "order": ["2", "3"], "seed": [str(self._random.randrange(10**6))]}
        offered = choices.get(name) or desk.offers.get(name) or [desk.values[name]]
        await self._ask({name: self._random.choice(offered)})

    async def _export(self) -> None:
        desk = await self._at_desk()
        whole(await self._client.ask("GET", f"/export/metrics.json?{desk.link}"), "export")

    async def _upload(self) -> None:
        # Another recording every time: the same one is known already.
        body = RECORDING + b"%d,0,0\n" % self._random.randrange(10**6, 10**9)
        path = "/recordings?name=walk.csv&keep=browser"
        headers = {"Content-Type": "application/octet-stream"}
        whole(await self._client.ask("PUT", path, body, headers), "upload")

    async def _at_desk(self) -> Desk:
        """The page; opened again where something has gone wrong."""
        if self._desk is None or self._live is None:
            await self._open("explore" if self._desk is None else self._desk.name)
        assert self._desk is not None
        return self._desk

    # Sockets ------------------------------------------------------------------------------------------------------

    async def _socket(self, path: str) -> ClientConnection:
        return await connect(
            f"ws://127.0.0.1:{self._client.port}{path}", origin=Origin(self._client.origin), max_size=None,
            local_addr=(self._client.address, 0), open_timeout=PATIENCE, ping_interval=None, proxy=None,
        )  # fmt: skip

    def _go(self, work: Callable[[], Awaitable[None]]) -> None:
        """Beside everything else, until the page is left."""
        task = asyncio.create_task(self._counted(work))
        self._beside.add(task)
        task.add_done_callback(self._beside.discard)

    async def _counted(self, work: Callable[[], Awaitable[None]]) -> None:
        try:
            await work()
        except Exception as error:  # noqa: BLE001 - whatever it was, it counts
            self._tally.errors[f"beside: {type(error).__name__} {error}"[:300]] += 1

    async def _study(self, page: str) -> None:
        """Ask for the page's study as it stands, until there is an outcome."""
        assert self._desk is not None
        async with await self._socket(f"/{page}/study") as socket:
            await socket.send(orjson.dumps({"seq": 1, "query": self._desk.link, "theme": "light"}).decode())
            async for message in socket:
                state = orjson.loads(message)["state"]
                if state == "failed":
                    raise RefusedError("study: failed")

    async def _watch(self, token: str) -> None:
        """The page's scene: its frames come, and the camera turns now and then."""
        async with scene(self._client.port, token, local_addr=(self._client.address, 0)) as socket:
            turning = asyncio.create_task(self._turn(socket))
            try:
                async for _ in socket:
                    pass
            finally:
                turning.cancel()

    async def _turn(self, socket: ClientConnection) -> None:
        with contextlib.suppress(OSError, EOFError):
            while True:
                await asyncio.sleep(self._random.uniform(1, 5))
                await socket.send(camera(position=tuple(self._random.uniform(-5, 5) for _ in range(3))))

    async def _leave(self) -> None:
        """Let go of the page's sockets."""
        for task in list(self._beside):
            task.cancel()
        await asyncio.gather(*self._beside, return_exceptions=True)
        live, self._live, self._scene = self._live, None, ""
        if live is not None:
            await live.close()
