"""A million runs in one browser, a slider in another: how free one leaves the other, and how soon it is ended."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from playwright.sync_api import sync_playwright

from benchmarks.drag import drag
from benchmarks.serving import launch, server, settle

RUNS = 1_000_000
COMPARED = f"/compare?order=2&xi=0.6&pin1=kalata,order:2,tracking_index:0.5&runs={RUNS}"
STATE = "() => document.querySelector('[data-study]')?.dataset.study"
WATCH = """() => {
  const log = window.__study = [];
  const bar = document.querySelector('#compare-study-bar');
  new MutationObserver(() => log.push([performance.now(), bar.value])).observe(
    document.querySelector('#compare-study-text'), {childList: true, characterData: true, subtree: true});
}"""


@dataclass(frozen=True, slots=True)
class LongWork:
    """What was seen.

    Attributes:
        alone, beside: ms from every slider change to its drawing on Explore, without and with the study.
        updates: partial results that arrived while the slider moved.
        share: of the study that was done when it was stopped.
        rate: runs per second while it ran.
        ended: s from the click on Stop to the page that says so.
    """

    alone: np.ndarray
    beside: np.ndarray
    updates: int
    share: float
    rate: float
    ended: float


def measure(moves: int = 240) -> LongWork:
    """Drag the slider, start the study in another browser, drag again, stop the study."""
    with server() as port, sync_playwright() as playwright:
        one, other = launch(playwright), launch(playwright)
        explore = one.new_page(viewport={"width": 1440, "height": 900})
        explore.goto(f"http://127.0.0.1:{port}/")
        settle(explore)
        explore.wait_for_timeout(1000)
        alone = drag(explore, moves, 25)
        explore.reload()
        settle(explore)
        compare = other.new_page(viewport={"width": 1440, "height": 900})
        compare.goto(f"http://127.0.0.1:{port}{COMPARED}")
        compare.wait_for_function(f"({STATE})() === 'running'")
        compare.evaluate(WATCH)
        begun = time.perf_counter()
        beside = drag(explore, moves, 25)
        seconds = time.perf_counter() - begun
        log = np.array(compare.evaluate("() => window.__study"))
        clicked = time.perf_counter()
        compare.click("#compare-study-stop")
        compare.wait_for_function(f"({STATE})() === 'stopped'")
        ended = time.perf_counter() - clicked
        for browser in (one, other):
            browser.close()
    done = float(log[-1, 1] - log[0, 1]) if len(log) > 1 else 0.0
    span = (log[-1, 0] - log[0, 0]) / 1e3 if len(log) > 1 else seconds
    return LongWork(
        alone.delays, beside.delays, len(log), float(log[-1, 1]) if len(log) else 0.0, done * RUNS / span, ended
    )
