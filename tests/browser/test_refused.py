"""What the server does not answer: the page says so, keeps what was moved, and asks again where that makes sense."""

from __future__ import annotations

import json
import struct
from typing import Any

import pytest
from playwright.sync_api import Page, Route, WebSocketRoute, expect

CALLBACK = "**/_dash-update-component*"
PROBLEM = {"field": "server", "rule": "must rest", "received": "1", "message": "it must rest", "request": "7"}

pytestmark = pytest.mark.browser


class Refusing:
    """Refuses the callbacks of a page while it is told to, and remembers the bodies of all."""

    def __init__(self, page: Page, status: int, **headers: str) -> None:
        self.status, self.headers, self.left = status, headers, 0
        self.asked: list[Any] = []
        page.route(CALLBACK, self._handle)

    def _handle(self, route: Route) -> None:
        self.asked.append(json.loads(route.request.post_data or ""))
        if not self.left:
            route.continue_()
            return
        self.left -= 1
        route.fulfill(status=self.status, headers=self.headers, json=PROBLEM)


def type_into(page: Page, name: str, text: str) -> None:
    page.fill(f"#explore-{name}", text)
    page.press(f"#explore-{name}", "Enter")


def test_a_busy_server_is_asked_again_after_the_time_it_says(open_page, settle):
    page = open_page(refused=503)
    refusing = Refusing(page, 503, **{"Retry-After": "2"})
    refusing.left = 1
    type_into(page, "xi", "0.5")
    expect(page.locator("#explore-note")).to_have_text("The server does not answer: it must rest; trying again.")
    # What is moved meanwhile waits as well.
    type_into(page, "seed", "5")
    settle(page)
    first, second, *_ = (asked["inputs"][0]["value"] for asked in refusing.asked)
    assert first["changed"] == ["xi"]
    assert second["changed"] == ["xi", "seed"]
    expect(page.locator("#explore-note")).to_have_text("")
    assert page.url.partition("?")[2] == "seed=5&xi=0.5"


def test_what_is_not_understood_is_said_and_nothing_is_lost(open_page, settle):
    page = open_page(refused=400)
    refusing = Refusing(page, 400)
    refusing.left = 1
    type_into(page, "xi", "0.5")
    expect(page.locator("#explore-note")).to_have_text("The server does not answer: it must rest.")
    settle(page)
    assert len(refusing.asked) == 1
    type_into(page, "seed", "5")
    expect(page.locator("#explore-note")).to_have_text("")
    settle(page)
    assert refusing.asked[1]["inputs"][0]["value"]["changed"] == ["xi", "seed"]
    assert page.url.partition("?")[2] == "seed=5&xi=0.5"


def test_what_is_wrong_with_a_control_that_the_page_does_not_show_is_said_every_time(open_page, settle):
    page = open_page()
    message = "The data must be somewhere."

    def refuse(route: Route) -> None:
        response = route.fetch()
        answer = response.json()
        answer["response"]["explore-answer"]["data"] |= {"ok": False, "errors": {"nowhere": message}, "drawn": {}}
        route.fulfill(response=response, json=answer)

    page.route(CALLBACK, refuse)
    for name, text in (("xi", "0.5"), ("seed", "5")):
        type_into(page, name, text)
        expect(page.locator("#explore-note")).to_have_text(message)
        settle(page)
    page.unroute(CALLBACK)
    # The same box again, which leaves other notes alone.
    type_into(page, "seed", "6")
    expect(page.locator("#explore-note")).to_have_text("")
    settle(page)


def test_a_page_comes_once_the_server_has_time(open_page, settle):
    page = open_page(refused=429)
    refusing = Refusing(page, 429, **{"Retry-After": "1"})
    refusing.left = 2
    page.click("#to-stability")
    page.wait_for_selector("#stability")
    settle(page)
    assert [asked["output"].startswith(".._pages_content.") for asked in refusing.asked[:3]] == [True] * 3


def test_a_socket_that_answers_with_a_problem_is_asked_again(open_page, settle):
    refused: list[int] = []

    def route(socket: WebSocketRoute) -> None:
        server = socket.connect_to_server()

        def on_message(message: str | bytes) -> None:
            if refused:
                server.send(message)
                return
            refused.append(json.loads(message)["seq"])
            text = json.dumps({"seq": refused[0], "problem": PROBLEM, "again": 1}).encode()
            text += b" " * (-len(text) % 4)
            socket.send(struct.pack("<I", len(text)) + text)

        socket.on_message(on_message)

    page = open_page(first=lambda page: page.route_web_socket("**/explore/live", route))
    page.focus("#explore-xi-slider")
    page.keyboard.press("ArrowRight")
    expect(page.locator("#explore-note")).to_have_text("The server does not answer: it must rest; trying again.")
    settle(page)
    expect(page.locator("#explore-note")).to_have_text("")
    assert refused
    assert page.url.partition("?")[2].startswith("xi=0.6")
