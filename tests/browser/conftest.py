"""A server and a browser; every test fails on console errors, page errors and responses that say so."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect, sync_playwright

from benchmarks.serving import launch, server, settle

# A busy machine with two processors draws slowly; nothing waits for as long unless it is broken.
PATIENCE = 30_000
expect.set_options(timeout=PATIENCE)


@pytest.fixture(scope="session")
def port() -> Iterator[int]:
    """A running server."""
    with server() as number:
        yield number


@pytest.fixture(scope="session")
def chromium() -> Iterator[Callable[..., Browser]]:
    """Starts Chromium, as the set-up found it."""
    with sync_playwright() as playwright:
        started = []

        def start(*, webgl: bool = False) -> Browser:
            started.append(launch(playwright, webgl=webgl))
            return started[-1]

        yield start
        for browser in started:
            browser.close()


@pytest.fixture(scope="session")
def browser(chromium: Callable[..., Browser]) -> Browser:
    """The browser of most tests: without WebGL."""
    return chromium()


@pytest.fixture(scope="session")
def webgl(chromium: Callable[..., Browser]) -> Browser:
    """A browser that draws in three dimensions."""
    return chromium(webgl=True)


@pytest.fixture
def open_page(browser: Browser, port: int) -> Iterator[Callable[..., Page]]:
    """Opens pages, each in a browser context of its own, and waits until they have drawn everything.

    What has to be there before the page loads is done by `first`; the status `refused` is an answer and no fault.
    """
    contexts, complaints = [], []

    def open_one(
        query: str = "",
        *,
        size: tuple[int, int] = (1440, 1180),
        theme: Any = "light",
        at: int = port,
        using: Browser = browser,
        first: Callable[[Page], object] | None = None,
        refused: int = 0,
        **more: Any,
    ) -> Page:
        # Half the pixels are drawn in less time, and where things stand does not depend on them; what colour they have
        # in a scene does.
        options = {"color_scheme": theme, "device_scale_factor": 0.5 if using is browser else 1, **more}
        context = using.new_context(viewport={"width": size[0], "height": size[1]}, **options)
        context.set_default_timeout(PATIENCE)
        contexts.append(context)
        page = context.new_page()
        told = f"status of {refused} " if refused else None
        page.on(
            "console",
            lambda said: (
                complaints.append(said.text) if said.type == "error" and not (told and told in said.text) else None
            ),
        )
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on(
            "response",
            lambda r: complaints.append(f"{r.status} {r.url}") if r.status >= 400 and r.status != refused else None,
        )
        if first is not None:
            first(page)
        page.goto(f"http://127.0.0.1:{at}/{query}")
        settle(page)
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert complaints == []


WIDTHS = ((1440, 900), (1024, 800), (390, 844), (360, 740))
LIGHT_WIDTH, DARK_WIDTH = 1440, 390
"""Where axe looks, at the one in light and at the other in dark."""


@pytest.fixture
def check_look() -> Callable[..., None]:
    """Looks at a page from wide to narrow: nothing scrolls sideways, axe finds nothing serious in light and in dark."""

    def check(page: Page) -> None:
        for width, height in WIDTHS:
            page.set_viewport_size({"width": width, "height": height})
            # Plots follow the width a moment later.
            page.wait_for_function("() => document.documentElement.scrollWidth <= innerWidth")
            if width == DARK_WIDTH:
                page.click("#theme-switch")
                settle(page)
            if width in (LIGHT_WIDTH, DARK_WIDTH):
                found = Axe().run(page).response["violations"]
                grave = [each for each in found if each["impact"] in ("serious", "critical")]
                assert [(each["id"], each["nodes"][0]["html"]) for each in grave] == []

    return check


class Plot:
    """What a plot of the page shows."""

    def __init__(self, page: Page, name: str) -> None:
        desk = page.evaluate("() => document.querySelector('.desk').id")
        self.page, self.selector = page, f"#{desk}-{name} .js-plotly-plot"

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
