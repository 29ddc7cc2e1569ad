"""A server and a browser; every test fails on console errors, page errors and responses that say so."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

ROOT = Path(__file__).parents[2]
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
# A busy machine with two processors draws slowly; nothing waits for as long unless it is broken.
PATIENCE = 30_000
expect.set_options(timeout=PATIENCE)

SETTLED = "() => document.querySelector('#explore')?.dataset.state === 'settled'"


@pytest.fixture(scope="session")
def port() -> Iterator[int]:
    """A running server."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1]
    environment = os.environ | {"GAINSCOPE_PORT": str(number), "GAINSCOPE_HOST": "127.0.0.1"}
    with subprocess.Popen([sys.executable, "app.py"], cwd=ROOT, env=environment) as process:
        try:
            _wait_until_ready(number, process)
            yield number
        finally:
            process.terminate()


def _wait_until_ready(number: int, process: subprocess.Popen[bytes]) -> None:
    for _ in range(600):
        assert process.poll() is None, "the server stopped"
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{number}/readyz") as answer:
                if answer.status == 200:
                    return
        except OSError:
            pass
        time.sleep(0.1)
    pytest.fail("the server did not become ready")


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium, as the set-up found it."""
    path = os.environ.get("GAINSCOPE_CHROMIUM") or shutil.which("chromium")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def open_page(browser: Browser, port: int) -> Iterator[Callable[..., Page]]:
    """Opens pages, each in a browser context of its own, and waits until they have drawn everything."""
    contexts, complaints = [], []

    def open_one(
        query: str = "", *, size: tuple[int, int] = (1440, 1180), theme: Any = "light", at: int = port, **more: Any
    ) -> Page:
        context = browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=theme, **more)
        context.set_default_timeout(PATIENCE)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("response", lambda r: complaints.append(f"{r.status} {r.url}") if r.status >= 400 else None)
        page.goto(f"http://127.0.0.1:{at}/{query}")
        settle(page)
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert complaints == []


def settle(page: Page) -> None:
    """Wait until the page says that every plot shows the last change."""
    page.wait_for_function(SETTLED)


class Plot:
    """What a plot of the page shows."""

    def __init__(self, page: Page, name: str) -> None:
        self.page, self.selector = page, f"#explore-{name} .js-plotly-plot"

    def _ask(self, expression: str) -> Any:
        return self.page.evaluate(
            f"(s) => {{const gd = document.querySelector(s); return {expression}}}", self.selector
        )

    @property
    def meta(self) -> dict[str, Any]:
        """What the server said of the drawing."""
        return self._ask("gd._fullLayout.meta")

    def line(self, trace: int) -> list[list[float | None]]:
        """Coordinates of a trace, NaN as None."""
        return self._ask(
            f"['x', 'y'].map(a => Array.from(gd._fullData[{trace}][a], v => Number.isFinite(v) ? v : null))"
        )

    def range(self, axis: str) -> list[float]:
        """Range of an axis."""
        return self._ask(f"gd._fullLayout.{axis}axis.range")

    def outline(self, trace: int) -> str:
        """The line as it is drawn."""
        return self._ask(
            f"gd.querySelector('.scatterlayer .trace' + gd._fullData[{trace}].uid + ' .js-line').getAttribute('d')"
        )


@pytest.fixture(name="settle")
def settle_fixture() -> Callable[[Page], None]:
    """The waiting function."""
    return settle


@pytest.fixture
def plot() -> Callable[[Page, str], Plot]:
    """Looks into a plot by name."""
    return Plot
