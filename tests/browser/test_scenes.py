"""The scenes in three dimensions in a real browser."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect
from websockets.sync.client import connect

from benchmarks.scene_browser import View
from benchmarks.serving import server
from layouts.scenes.page import protocol
from layouts.scenes.stage import channels
from layouts.theme import tokens

TRACK = "3d?samples=120"
SMALL = (1000, 760)
"""A scene is drawn by the processor: the fewer pixels the better."""


@pytest.fixture
def told():
    """What viser tells the scene of a page."""

    def listen(page):
        view = View()

        def watch(socket):
            if "/viser/" in socket.url:
                socket.on("framereceived", view.take)

        page.on("websocket", watch)
        return view

    return listen


def point(view):
    """Where the operating point is in a scene: the corners of its mesh."""
    return tuple(np.ravel(view.nodes["/gains"]["vertices"])) if "/gains" in view.nodes else None


def visit(page, place):
    """Scroll the scene into sight and wait until its client runs."""
    page.locator(place).scroll_into_view_if_needed()
    page.wait_for_selector(f"{place} iframe")


def wait_for(page, condition):
    """Wait until something holds on this side."""
    for _ in range(600):
        if condition():
            return
        page.wait_for_timeout(50)
    pytest.fail("it did not come")


def share_of(shot, colour, tolerance=40):
    """How much of a picture has a colour of the tokens."""
    pixels = np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), dtype=int)
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
    return float((np.abs(pixels - wanted).max(axis=-1) <= tolerance).mean())


def test_two_browsers_see_two_operating_points(webgl, open_page, told, settle):
    pages = [open_page(query, using=webgl, size=SMALL) for query in ("stability", "stability?xi=0.3")]
    heard = [told(page) for page in pages]
    for page in pages:
        visit(page, "#stability-scene-card .scene")
    wait_for(pages[0], lambda: all(map(point, heard)))
    first, second = map(point, heard)
    assert first != second
    # One moves; the other does not.
    pages[0].fill("#stability-xi", "0.1")
    pages[0].press("#stability-xi", "Enter")
    settle(pages[0])
    wait_for(pages[0], lambda: point(heard[0]) != first)
    assert point(heard[1]) == second


def test_the_region_is_drawn_and_the_point_has_the_colour_of_the_verdict(webgl, open_page, settle):
    page = open_page("stability?design=manual&order=3&alpha=0.5&beta=0.5&gamma=0.1", using=webgl, size=SMALL)
    visit(page, "#stability-scene-card .scene")
    scene = page.locator("#stability-scene-card .scene")
    good, bad = tokens("light")["good"], tokens("light")["bad"]

    def seen(colour):
        scene.scroll_into_view_if_needed()
        return share_of(page.screenshot(clip=scene.bounding_box()), colour) * 1e4

    wait_for(page, lambda: seen(good) > 1)
    assert seen(bad) < 1
    page.fill("#stability-gamma", "5")
    page.press("#stability-gamma", "Enter")
    settle(page)
    wait_for(page, lambda: seen(bad) > 1)
    assert seen(good) < 1


def test_the_track_is_drawn_played_and_scrubbed(webgl, open_page, told, settle):
    page = open_page(TRACK, using=webgl, size=SMALL)
    view = told(page)
    page.reload()
    settle(page)
    visit(page, "#track-scene-card .scene")
    scene = page.locator("#track-scene-card .scene")
    for kind in ("observed", "smoothed"):
        wait_for(
            page,
            lambda kind=kind: share_of(page.screenshot(clip=scene.bounding_box()), tokens("light")[kind], 60) > 5e-4,
        )
    page.focus("#track-at-slider")
    page.keyboard.press("Home")
    settle(page)
    expect(page.locator("#track-at")).to_have_value("1")
    said = len(view.sizes)
    page.select_option('[data-part="speed"]', "60")
    page.click('[data-part="play"]')
    expect(page.locator('[data-part="play"]')).to_have_text("Pause")
    wait_for(page, lambda: len(view.sizes) > said + 10)
    page.click('[data-part="play"]')
    expect(page.locator('[data-part="play"]')).to_have_text("Play")
    settle(page)
    at = int(page.input_value("#track-at"))
    assert 1 < at < 120
    assert f"at={at}" in page.url


def test_without_webgl_the_page_says_so_and_shows_the_plane(open_page, plot):
    page = open_page("stability")
    page.locator("#stability-scene-card").scroll_into_view_if_needed()
    expect(page.locator('#stability-scene-card [data-part="missing"]')).to_contain_text("no WebGL")
    assert page.locator("iframe").count() == 0
    assert len(plot(page, "map").line(0)[0]) > 100


def test_a_scene_is_let_go_and_comes_back(webgl, open_page, told):
    page = open_page("stability", using=webgl, size=SMALL)
    view = told(page)
    visit(page, "#stability-scene-card .scene")
    wait_for(page, lambda: point(view))
    page.clock.install()
    page.mouse.move(5, 5)
    page.clock.fast_forward(11 * 60 * 1000)
    expect(page.locator('#stability-scene-card [data-part="resume"]')).to_be_visible()
    assert page.locator("iframe").count() == 0
    view.nodes.clear()
    page.click('[data-part="show"]')
    wait_for(page, lambda: point(view))


def test_a_scene_that_is_refused_says_so_and_is_tried_again(webgl, open_page):
    with server(GAINSCOPE_SCENES="1") as port:
        place, origin = f"127.0.0.1:{port}/viser/{'0' * 32}", f"http://127.0.0.1:{port}"
        with connect(f"ws://{place}", origin=origin, subprotocols=[protocol()]):
            page = open_page("stability", using=webgl, size=SMALL, at=port, refused=403)
            visit(page, "#stability-scene-card .scene")
            refused, again = (
                page.locator(f'#stability-scene-card [data-part="{part}"]') for part in ("refused", "again")
            )
            expect(refused).to_contain_text("The scene has no connection")
            before = page.get_attribute(".scene", "data-token")
            again.click()
            expect(again).to_have_text("Try again")
            assert page.get_attribute(".scene", "data-token") != before
        # Once there is room it comes by itself.
        expect(refused).to_be_hidden()
        page.close()


def test_a_scene_whose_connection_does_not_come_says_so(webgl, open_page):
    page = open_page("stability", using=webgl, size=SMALL, first=lambda page: page.clock.install())
    page.route(
        "**/viser/light/", lambda route: route.fulfill(body="<p>nothing that connects</p>", content_type="text/html")
    )
    visit(page, "#stability-scene-card .scene")
    refused = page.locator('#stability-scene-card [data-part="refused"]')
    page.clock.fast_forward(10_000)
    expect(refused).to_be_hidden()
    page.clock.fast_forward(6_000)
    expect(refused).to_be_visible()


def test_it_looks_right_at_every_width_in_both_themes(open_page, check_look):
    page = open_page(TRACK)
    for theme in ("light", "dark"):
        # The key shows lines and points as the scene draws them: it has no dashes, and no points that are hollow.
        for kind, look in (("predicted", "borderTopStyle"), ("observed", "backgroundColor")):
            drawn = page.locator(f'.scene-key [data-kind="{kind}"]').evaluate(
                f"key => getComputedStyle(key, '::before').{look}"
            )
            assert drawn in ("solid", f"rgb{channels(tokens(theme)['observed'])}")
        if theme == "light":
            # It ends in the other one.
            check_look(page)
