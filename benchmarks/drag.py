"""How attached the slider feels: from the change of a slider to the drawn plot, in a real browser.

The xi slider is dragged by mouse events at a given rate. The page is watched from inside: when the slider changed,
and when the path plot that shows that value (or a newer one) had been drawn and the next frame began.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from playwright.sync_api import Page

WATCH = """() => {
  const slider = document.getElementById('explore-xi-slider');
  const page = document.getElementById('explore');
  const log = window.__drag = {changes: [], drawn: []};
  slider.addEventListener('input', () => log.changes.push([performance.now(), slider.value / 1000 * 0.999]));
  new MutationObserver(() => {
    const xi = Math.cbrt(1 - Number(page.dataset.gains.split(' ')[0]));
    requestAnimationFrame(() => log.drawn.push([performance.now(), xi]));
  }).observe(page, {attributes: true, attributeFilter: ['data-seq']});
}"""


@dataclass(frozen=True, slots=True)
class Drag:
    """The outcome of one drag.

    Attributes:
        changes: slider changes that the browser reported.
        drawn: of these, how many values were drawn themselves.
        delays: ms from every change to the first drawing of it or of a newer one.
        last_drawn: whether the last value of all was drawn.
    """

    changes: int
    drawn: int
    delays: np.ndarray
    last_drawn: bool


def drag(page: Page, moves: int, rate: float) -> Drag:
    """Drag the xi slider there and back.

    Args:
        page: the Explore page with a fading-memory filter of order 3, drawn.
        moves: mouse moves in all.
        rate: moves per second.
    """
    page.evaluate(WATCH)
    slider = page.locator("#explore-xi-slider")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    assert box is not None
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.5 * box["width"], y)
    page.mouse.down()
    begun = time.perf_counter()
    for i in range(moves):
        share = 0.5 + 0.35 * np.sin(2 * np.pi * (i + 1) / 120)
        page.mouse.move(box["x"] + share * box["width"], y)
        time.sleep(max(0.0, begun + (i + 1) / rate - time.perf_counter()))
    page.mouse.up()
    page.wait_for_timeout(1500)
    log = page.evaluate("() => window.__drag")
    changed, drawn = np.array(log["changes"]), np.array(log["drawn"])
    # Which change a drawing shows: the newest one before it with that value.
    shown = [
        max((i for i, (at, xi) in enumerate(changed) if at < moment and abs(xi - value) < 1e-3), default=-1)
        for moment, value in drawn
    ]
    delays = []
    for i, (at, _) in enumerate(changed):
        later = [moment for (moment, _), index in zip(drawn, shown, strict=True) if index >= i]
        if later:
            delays.append(min(later) - at)
    return Drag(
        changes=len(changed),
        drawn=len(set(shown) - {-1}),
        delays=np.array(delays),
        last_drawn=bool(shown) and shown[-1] == len(changed) - 1,
    )
