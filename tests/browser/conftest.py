"""A server and a browser; every test fails on console errors, page errors and responses that say so."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Page, Response, expect, sync_playwright

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


class Tab:
    """A page, and what it complained of.

    Args:
        context: of its own.
        refused: a status that is an answer and no fault.
        is_usual: whether there is nothing about it that the next test would not expect.
    """

    def __init__(self, context: BrowserContext, refused: int, *, is_usual: bool) -> None:
        self.is_usual = is_usual
        context.set_default_timeout(PATIENCE)
        self.page = context.new_page()
        self.complaints: list[str] = []
        self._refused = refused
        self.page.on("console", self._hear)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("response", self._look)

    def _hear(self, message: ConsoleMessage) -> None:
        # The browser says itself that a request was refused, or a socket.
        said = (f"status of {self._refused} ", f"response code: {self._refused}")
        if message.type == "error" and not any(part in message.text for part in said):
            self.complaints.append(message.text)

    def _look(self, response: Response) -> None:
        if response.status >= 400 and response.status != self._refused:
            self.complaints.append(f"{response.status} {response.url}")

    def leave(self, origin: str) -> None:
        """End what runs in the page; an address of the same site leaves it to the process that knows the scripts."""
        self.page.unroute_all(behavior="ignoreErrors")
        self.page.goto(f"{origin}/livez")

    def forget(self, origin: str) -> None:
        """Have nothing stored, as if nobody had been here."""
        self.leave(origin)
        self.complaints.clear()
        self.page.evaluate("() => { localStorage.clear(); sessionStorage.clear(); }")
        self.page.mouse.move(0, 0)


@pytest.fixture(scope="session")
def idle_tabs() -> list[Tab]:
    """Pages of the usual browser that no test uses now: they know the scripts, so they start in half the time."""
    return []


@pytest.fixture
def open_page(browser: Browser, port: int, idle_tabs: list[Tab]) -> Iterator[Callable[..., Page]]:
    """Opens pages that nobody has used, and waits until they have drawn everything.

    What has to be there before the page loads is done by `first`; the status `refused` is an answer and no fault. A
    page with anything unusual about it has a browser context that goes with it.
    """
    tabs: list[Tab] = []

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
        origin = f"http://127.0.0.1:{at}"
        # Half the pixels are drawn in less time, and where things stand does not depend on them; what colour they have
        # in a scene does.
        options = {"device_scale_factor": 0.5 if using is browser else 1, **more}
        is_usual = using is browser and first is None and not refused and not more
        if is_usual and idle_tabs:
            tab = idle_tabs.pop()
            tab.forget(origin)
        else:
            tab = Tab(using.new_context(**options), refused, is_usual=is_usual)
        tabs.append(tab)
        tab.page.set_viewport_size({"width": size[0], "height": size[1]})
        tab.page.emulate_media(color_scheme=theme)
        if first is not None:
            first(tab.page)
        tab.page.goto(f"{origin}/{query}")
        settle(tab.page)
        return tab.page

    yield open_one
    for tab in tabs:
        if tab.is_usual and not tab.page.is_closed():
            tab.leave(f"http://127.0.0.1:{port}")
            idle_tabs.append(tab)
        else:
            tab.page.context.close()
    complaints = [said for tab in tabs for said in tab.complaints]
    assert complaints == []


WIDTHS = ((1440, 900), (1024, 800), (390, 844), (360, 740))
LIGHT_WIDTH, DARK_WIDTH = 1440, 390
"""Where axe looks, at the one in light and at the other in dark."""


EXPLAINED = (1440, 360)
"""Where the pointer goes over every term and every label."""

UNSEEN = """() => {
  const root = document.documentElement, bubble = document.querySelector('.bubble'), bad = [];
  const over = (place) => place.dispatchEvent(new PointerEvent('pointerover', {bubbles: true}));
  for (const term of document.querySelectorAll('.tip, label')) {
    if (!term.checkVisibility()) continue;
    if (!term.closest('.visually-hidden') && term.offsetWidth < 5) bad.push(`no label to see: ${term.textContent}`);
    if (!term.matches('.tip')) continue;
    term.scrollIntoView({block: 'center'});
    over(term);
    const {left, right, top, bottom} = bubble.getBoundingClientRect();
    const isInside = left >= 0 && top >= 0 && right <= root.clientWidth && bottom <= root.clientHeight;
    if (bubble.hidden || !isInside || root.scrollWidth > innerWidth) bad.push(`no explanation: ${term.textContent}`);
  }
  over(document.body);
  scrollTo(0, 0);
  return bad;
}"""


COVERED = """() => [...document.querySelectorAll('.js-plotly-plot')].filter((plot) => {
  const box = (part) => plot.querySelector(part)?.getBoundingClientRect();
  const legend = box('.legend'), drawn = box('.nsewdrag');
  return legend && drawn && legend.bottom > drawn.top + 1 && legend.top < drawn.bottom - 1;
}).map((plot) => plot.parentElement.id)"""
"""Plots whose legend lies over what is drawn."""


@pytest.fixture
def check_look() -> Callable[..., None]:
    """Looks at a page from wide to narrow.

    No legend lies over a plot, nothing scrolls sideways, labels are seen and every explanation with them, axe finds
    nothing serious in light and in dark.
    """

    def check(page: Page) -> None:
        assert page.evaluate(COVERED) == []
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
            if width in EXPLAINED:
                assert page.evaluate(UNSEEN) == []

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
