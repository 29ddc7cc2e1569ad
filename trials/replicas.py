"""Three servers behind the proxy of deploy/Caddyfile: who stays where, and what is seen of one that goes.

Run by itself: `python -m trials.replicas`. Needs Caddy and, for what a page does, Chromium.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import shutil
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Sequence
from pathlib import Path
from subprocess import Popen

from playwright.sync_api import Browser, Page, sync_playwright
from websockets.asyncio.client import connect
from websockets.typing import Origin

from benchmarks.serving import launch, settle
from trials.behind import SERVERS, Behind
from trials.page import Site
from trials.report import Finding, at_most, machine, none_of, percentiles, row
from trials.wire import Client

WITHOUT = "NOT TRIED: there is no caddy on the path (Debian: apt-get install caddy)"

RECOVERS_WITHIN = 30.0
"""Seconds until a page whose server is gone draws again; a socket is tried again after two."""

PACE = 0.2
"""Seconds between two requests of each of those who go on while servers are replaced."""

RECORDING = b"t,x,y\n" + b"".join(b"%d,%d,%d\n" % (row, 3 * row, row * row // 50) for row in range(300))


def trial(short: bool = False) -> Iterator[Finding]:  # noqa: ARG001 - as long as it is, it is short
    """Who stays where; recordings; a page whose server stops, and is killed; all servers replaced one by one."""
    if shutil.which("caddy") is None:
        yield Finding("three servers behind a proxy", WITHOUT, "tried", held=False)
        return
    with tempfile.TemporaryDirectory(prefix="gainscope-replicas-") as folder, tempfile.TemporaryFile() as log:
        behind = Behind(str(Path(folder) / "recordings"), log)
        try:
            behind.wait()
            yield from asyncio.run(_homes(behind))
            yield from _pages(behind)
            yield from asyncio.run(_replaced(behind))
        finally:
            behind.end()


# Who stays where ------------------------------------------------------------------------------------------------------


async def _homes(behind: Behind) -> list[Finding]:
    cookies = set()
    for _ in range(60):
        cookies.add(await _cookie(behind.port))
    found = [Finding("newcomers", f"come to {len(cookies)} servers", f"all {SERVERS}", len(cookies) == SERVERS)]
    moved = []
    for cookie in sorted(cookies):
        client = Client(behind.port)
        for _ in range(20):
            answer = await client.ask("GET", "/livez", headers={"Cookie": cookie})
            moved += [answer.headers["set-cookie"]] if "set-cookie" in answer.headers else []
    found.append(none_of("who has come once and moves on", moved, f"{20 * len(cookies)} requests"))
    async with contextlib.AsyncExitStack() as sockets:
        for cookie in sorted(cookies):
            await sockets.enter_async_context(
                connect(
                    f"ws://127.0.0.1:{behind.port}/explore/live", origin=Origin(f"http://127.0.0.1:{behind.port}"),
                    additional_headers={"Cookie": cookie}, proxy=None,
                )
            )  # fmt: skip
        held = [behind.sockets(number) for number in range(SERVERS)]
    spread = Finding("sockets, one for each cookie", f"at the servers: {held}", "one each", held == [1] * SERVERS)
    return [*found, spread, await _shared(behind, sorted(cookies))]


async def _cookie(port: int) -> str:
    """What somebody who comes for the first time is given."""
    answer = await Client(port).ask("GET", "/livez")
    return answer.headers.get("set-cookie", "").partition(";")[0]


async def _shared(behind: Behind, cookies: Sequence[str]) -> Finding:
    body = RECORDING + b"%d,0,0\n" % time.time_ns()
    put = await Client(behind.port).ask("PUT", "/recordings?name=walk.csv", body, {"Cookie": cookies[0]})
    path = f"/recordings/{json.loads(put.body).get('data')}"
    got = [await Client(behind.port).ask("GET", path, headers={"Cookie": cookie}) for cookie in cookies]
    whole = sum(answer.status == 200 and answer.body == body for answer in got)
    return Finding("a recording that one server took", f"whole from {whole}", f"all {SERVERS}", whole == SERVERS)


# Pages ----------------------------------------------------------------------------------------------------------------


def _pages(behind: Behind) -> Iterator[Finding]:
    """A page whose server stops, and one whose server is killed."""
    with sync_playwright() as playwright:
        browser = launch(playwright)
        for word, end in (("stops", Popen.terminate), ("is killed", Popen.kill)):
            yield from _orphaned(behind, browser, word, end)
        browser.close()


def _orphaned(behind: Behind, browser: Browser, word: str, end: Callable[[Popen[bytes]], None]) -> Iterator[Finding]:
    broken: list[str] = []
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    context.set_default_timeout(60_000)
    page = context.new_page()
    page.on("pageerror", lambda error: broken.append(str(error)))
    page.goto(f"http://127.0.0.1:{behind.port}/")
    settle(page)
    number = next(number for number in range(SERVERS) if behind.sockets(number))
    _move(page, "ArrowRight")
    end(behind.servers[number].process)
    begun = time.perf_counter()
    _move(page, "ArrowLeft")
    drawn = time.perf_counter() - begun
    yield at_most(f"a page whose server {word} draws again after", drawn, RECOVERS_WITHIN, "s")
    elsewhere = _has_socket(behind, number)
    yield Finding(f"its socket, when its server {word}", "at another" if elsewhere else "none", "at another", elsewhere)
    yield none_of("errors in the page", broken, "all of it")
    context.close()
    behind.replace(number)


def _move(page: Page, key: str) -> None:
    """Move a slider by a step, and wait until every plot shows it."""
    page.focus("#explore-xi-slider")
    before = page.evaluate("location.search")
    page.keyboard.press(key)
    page.wait_for_function("before => location.search !== before", arg=before)
    settle(page)


def _has_socket(behind: Behind, gone: int) -> bool:
    others = [number for number in range(SERVERS) if number != gone]
    until = time.monotonic() + RECOVERS_WITHIN
    while time.monotonic() < until:
        if any(map(behind.sockets, others)):
            return True
        time.sleep(0.2)
    return False


# Upgrade --------------------------------------------------------------------------------------------------------------


async def _replaced(behind: Behind) -> list[Finding]:
    """All servers are replaced, one after the other, while somebody at each goes on asking, and newcomers do."""
    cookies = {await _cookie(behind.port) for _ in range(60)}
    faults: list[str] = []
    seconds: list[float] = []
    over = asyncio.Event()
    async with _asking(behind.port, sorted(cookies), over, faults, seconds):
        for number in range(SERVERS):
            await asyncio.to_thread(behind.replace, number)
    _, _, longest = percentiles(seconds)
    return [
        none_of("requests that fail while all are replaced", faults, f"{len(seconds)} requests"),
        at_most("the longest of them", longest / 1e3, 15.0, "s", timed=True),
    ]


@contextlib.asynccontextmanager
async def _asking(
    port: int, cookies: Sequence[str], over: asyncio.Event, faults: list[str], seconds: list[float]
) -> AsyncIterator[None]:
    async def ask(cookie: str) -> None:
        client = Client(port)
        site = await Site.load(client)
        asks: list[Callable[[], Awaitable[object]]] = [
            lambda: client.ask("GET", "/export/metrics.json", headers={"Cookie": cookie}),
            lambda: site.content(client, "/stability"),
        ]
        while not over.is_set():
            for one in asks:
                begun = time.perf_counter()
                try:
                    answer = await one()
                    status = getattr(answer, "status", 200)
                    faults.extend([f"status {status}"] if status != 200 else [])
                except Exception as error:  # noqa: BLE001 - whatever it was, it counts
                    faults.append(f"{type(error).__name__}: {error}")
                seconds.append(time.perf_counter() - begun)
                await asyncio.sleep(PACE)

    async with asyncio.TaskGroup() as group:
        for cookie in cookies:
            group.create_task(ask(cookie))
        try:
            yield
        finally:
            over.set()


def main() -> int:
    print(machine(), flush=True)
    held = True
    for finding in trial():
        print(row("replicas", finding), flush=True)
        held &= finding.held
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
