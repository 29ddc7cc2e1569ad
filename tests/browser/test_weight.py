"""What a visit transfers, the first and every other; where from; and that nothing is tried that the policy forbids."""

from __future__ import annotations

from urllib.parse import urlsplit

import pytest

from layouts.site import PAGES

FIRST, AGAIN = 1_900_000, 60_000
"""Bytes of a visit to a page, headers and all: with nothing kept by the browser, and with what the first one left."""

VISER = 700_000
"""Bytes of viser's page, which a page with a scene in sight needs once more than others."""

PATHS = tuple(page.PATH[1:] for page in PAGES)
READY = """() => ['data', 'papers'].some((name) => document.getElementById(name))
    || document.querySelector('.desk')?.dataset.state === 'settled'"""


class Traffic:
    """What a page asks for, by the network of the browser itself."""

    def __init__(self, page):
        self.urls, self.sizes = {}, {}
        session = page.context.new_cdp_session(page)
        session.on("Network.requestWillBeSent", self._asked)
        session.on("Network.loadingFinished", self._came)
        session.send("Network.enable")

    def _asked(self, event):
        self.urls[event["requestId"]] = event["request"]["url"]

    def _came(self, event):
        self.sizes[event["requestId"]] = event["encodedDataLength"]

    @property
    def bytes(self):
        """Of everything that came from a server."""
        return sum(size for request, size in self.sizes.items() if self.urls.get(request, "").startswith("http"))

    @property
    def hosts(self):
        """Where it came from."""
        return {urlsplit(url).netloc for url in self.urls.values() if url.startswith(("http", "ws"))}


@pytest.fixture
def visit(port):
    """Visits a page in a context until it has drawn everything; gives the traffic.

    Nothing may be complained of but what is forbidden on purpose.
    """

    def go(context, path, ready=READY, forbidden=()):
        page = context.new_page()
        complaints = []
        page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.add_init_script(
            "addEventListener('securitypolicyviolation', (e) => console.error(e.violatedDirective, e.blockedURI))"
        )
        traffic = Traffic(page)
        page.goto(f"http://127.0.0.1:{port}/{path}")
        page.wait_for_function(ready)
        # What a page asks for once it has settled: the picture in its header, a worker.
        page.wait_for_timeout(500)
        page.close()
        assert set(complaints) <= set(forbidden)
        assert traffic.hosts == {f"127.0.0.1:{port}"}
        return traffic

    return go


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("path", PATHS)
def test_a_visit_is_light_and_the_next_one_lighter(browser, visit, path, theme):
    context = browser.new_context(viewport={"width": 1440, "height": 900}, color_scheme=theme)
    first, again = visit(context, path), visit(context, path)
    context.close()
    assert AGAIN < first.bytes <= FIRST
    assert 0 < again.bytes <= AGAIN


EVALUATED = ("script-src eval",)
"""A part of viser that no scene here needs would make code of text."""

DRAWN = """() => document.querySelector('.desk')?.dataset.state === 'settled'
    && document.querySelector('.scene iframe')?.contentDocument?.querySelector('canvas')"""


def test_a_scene_is_light_the_next_time(webgl, visit):
    context = webgl.new_context(viewport={"width": 1000, "height": 760})
    first, again = (visit(context, "3d", DRAWN, EVALUATED) for _ in range(2))
    context.close()
    assert AGAIN < first.bytes <= FIRST + VISER
    assert 0 < again.bytes <= AGAIN


@pytest.mark.parametrize("query", ["websocket=ws://gainscope.invalid", "playbackPath=/x", "showDevSettings"])
def test_visers_page_obeys_nobody_but_this_server(webgl, port, query):
    """It would connect to any server that its address names, and run what that sends."""
    context = webgl.new_context()
    page = context.new_page()
    sockets = []
    page.on("websocket", lambda socket: sockets.append(socket.url))
    token = "0123456789abcdef" * 2
    page.goto(f"http://127.0.0.1:{port}/viser/light/?{query}#{token}")
    page.wait_for_selector("canvas")
    # It says in its address where it has connected to.
    place, _, told = page.url.partition("?")
    assert place == f"http://127.0.0.1:{port}/viser/{token}"
    assert told in ("", f"websocket=ws://127.0.0.1:{port}/viser/{token}")
    assert set(sockets) <= {f"ws://127.0.0.1:{port}/viser/{token}"}
    page.goto(f"http://127.0.0.1:{port}/viser/light/#//gainscope.invalid/{token}")
    page.wait_for_function("() => location.pathname === '/viser/nobody'")
    context.close()
