"""One browser that goes from page to page: what its scripts keep of pages that are gone."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import cycle, islice

from playwright.sync_api import CDPSession, Page, sync_playwright

from benchmarks.serving import launch, running, settle
from trials.page import PATHS
from trials.report import Finding, at_most, none_of

CHANGES, SHORT = 200, len(PATHS)
GROWTH = 20.0
"""Megabytes."""

PAGES = (*[path for path in PATHS.values() if path != "/"], "/")
PATIENCE = 120_000.0

ROUNDS = 10
"""Of letting go, until nothing more is let go."""


@dataclass(frozen=True, slots=True)
class Kept:
    """What a page's scripts hold: megabytes, nodes of documents, listeners."""

    megabytes: float
    nodes: int
    listeners: int


def trial(short: bool = False) -> Iterator[Finding]:
    """Pages one after the other by the links in the header, their scenes drawn."""
    changes = SHORT if short else CHANGES
    with tempfile.TemporaryFile() as log, running(log) as it, sync_playwright() as playwright:
        browser = launch(playwright, webgl=True)
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        said: list[str] = []
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
        before, after = walk(page, f"http://127.0.0.1:{it.port}/", changes)
        browser.close()
    growth = after.megabytes - before.megabytes
    more = f"{after.megabytes:.0f} MB, nodes {before.nodes} to {after.nodes}"
    yield at_most(f"{changes} changes of the page: heap", growth, GROWTH, "MB", more=more)
    yield Finding("listeners", f"{before.listeners} to {after.listeners}")
    yield none_of("errors in the browser", said, f"{changes} pages")


def walk(page: Page, address: str, changes: int) -> tuple[Kept, Kept]:
    """Open every page once, then go on so many times; what is kept before and after."""
    page.set_default_timeout(PATIENCE)
    page.goto(address)
    settle(page)
    session = page.context.new_cdp_session(page)
    _go(page, len(PAGES), PAGES)
    before = _kept(page, session)
    _go(page, changes, PAGES)
    # The last page is another one than before: the same page is compared with itself.
    _go(page, -changes % len(PAGES), PAGES[changes % len(PAGES) :])
    return before, _kept(page, session)


def _go(page: Page, changes: int, pages: tuple[str, ...]) -> None:
    for path in islice(cycle(pages), changes):
        page.click(f'.page-link[href^="{path}"]' if path != "/" else "#to-explore")
        page.wait_for_function("path => location.pathname === path", arg=path)
        # Of a page that has gone nothing is waited for.
        page.wait_for_function("name => document.querySelector('.desk')?.id === name", arg=_desk(path))
        settle(page)


def _desk(path: str) -> str:
    return {"/": "explore", "/3d": "track"}.get(path, path[1:])


def _kept(page: Page, session: CDPSession) -> Kept:
    counted: dict[str, int] = {}
    for _ in range(ROUNDS):
        last = counted
        # What is still to be done for a page holds it; what is let go by what is collected is collected the next time.
        page.evaluate("() => new Promise(done => requestIdleCallback(() => done()))")
        session.send("HeapProfiler.collectGarbage")
        counted = session.send("Memory.getDOMCounters")
        if counted == last:
            break
    used = session.send("Runtime.getHeapUsage")["usedSize"]
    return Kept(used / 1e6, counted["nodes"], counted["jsEventListeners"])
