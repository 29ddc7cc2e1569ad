"""How attached the hand feels: from the change of a slider to the drawn plot, in a real browser.

The xi slider, or the operating point in the stability map, is dragged by mouse events at a given rate. The page is
watched from inside: when the slider or the point moved, and when the path plot that shows that value (or a newer one)
had been drawn and the next frame began.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from playwright.sync_api import Page

# What is dragged, which value its present place stands for, and which value a drawing shows.
SLIDER = """{
  selector: '#explore-xi-slider', change: 'input',
  wanted: (part) => part.value / 1000 * 0.999,
  drawn: (gains) => Math.cbrt(1 - gains[0]),
}"""
POINT = """{
  selector: '#explore-stability-card .handle', change: 'pointermove',
  wanted: (part) => {
    const axis = document.querySelector('#explore-stability .js-plotly-plot')._fullLayout.xaxis;
    const x = Number(part.style.transform.match(/translate\\(([\\d.]+)px/)[1]);
    return axis.range[0] + (x - axis._offset) / axis._length * (axis.range[1] - axis.range[0]);
  },
  drawn: (gains) => gains[0],
}"""
WATCH = """({selector, change, wanted, drawn}) => {
  const part = document.querySelector(selector), page = document.getElementById('explore');
  const log = window.__drag = {changes: [], drawn: []};
  document.addEventListener(change, () => {
    const value = wanted(part), before = log.changes.at(-1);
    if (!before || before[1] !== value) log.changes.push([performance.now(), value]);
  });
  new MutationObserver(() => {
    const value = drawn(page.dataset.gains.split(' ').map(Number));
    requestAnimationFrame(() => log.drawn.push([performance.now(), value]));
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


def drag(page: Page, moves: int, rate: float, *, point: bool = False) -> Drag:
    """Drag the xi slider, or the operating point in the stability map, there and back.

    Args:
        page: the Explore page, drawn, with a fading-memory filter of order 3; for the point with one of order 2.
        moves: mouse moves in all.
        rate: moves per second.
        point: whether the point is dragged.
    """
    page.evaluate(f"() => ({WATCH})({POINT if point else SLIDER})")
    part = page.locator("#explore-stability-card .handle" if point else "#explore-xi-slider")
    part.scroll_into_view_if_needed()
    box = part.bounding_box()
    assert box is not None
    y = box["y"] + box["height"] / 2
    # The point has the slider's way to go, on both sides of where it is.
    left, width = (box["x"] + box["width"] / 2 - 60, 120) if point else (box["x"], box["width"])
    page.mouse.move(left + 0.5 * width, y)
    page.mouse.down()
    begun = time.perf_counter()
    for i in range(moves):
        share = 0.5 + 0.35 * np.sin(2 * np.pi * (i + 1) / 120)
        page.mouse.move(left + share * width, y)
        time.sleep(max(0.0, begun + (i + 1) / rate - time.perf_counter()))
    page.mouse.up()
    page.wait_for_timeout(1500)
    log = page.evaluate("() => window.__drag")
    changed, drawn = np.array(log["changes"]), np.array(log["drawn"])
    # Which change a drawing shows: the newest one before it with that value.
    shown = [
        max((i for i, (at, wanted) in enumerate(changed) if at < moment and abs(wanted - value) < 1e-3), default=-1)
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
