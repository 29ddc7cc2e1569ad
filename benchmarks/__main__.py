"""python -m benchmarks: the core against C and other packages, and what the server and its pages cost."""

from __future__ import annotations

import os
import platform
import statistics
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace
from playwright.sync_api import sync_playwright

from benchmarks import long_work, scenes
from benchmarks.delay import Delay
from benchmarks.documents import measure_documents
from benchmarks.drag import Drag, drag
from benchmarks.memory import measure_memory
from benchmarks.serving import launch, server, settle
from benchmarks.speed import measure_speed
from benchmarks.startup import measure_startup
from layouts.controls import controls_of
from layouts.desk import Desk, answer, live_answer
from layouts.live import framed
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.questions import Question
from layouts.state import from_query
from tracker_core import Experiment, Gains, run_experiment, run_filter
from tracker_core.adaptive import METHODS
from tracker_core.adaptive.sample_search import candidates
from tracker_core.merits import merits
from tracker_core.region import nearest_stable
from tracker_core.run import observe

ROUNDS = 400
PACKAGES = ("numpy", "numba", "dash", "plotly", "filterpy", "simdkalman")
UNSTABLE = Gains((0.5, 2.0, 0.9, 0.3))


def timed(work: Callable[[], Any], rounds: int = ROUNDS) -> tuple[float, float]:
    """Median and 95th percentile of the duration of a call, ms."""
    work()
    durations = []
    for _ in range(rounds):
        begun = time.perf_counter()
        work()
        durations.append((time.perf_counter() - begun) * 1e3)
    return statistics.median(durations), float(np.percentile(durations, 95))


def row(name: str, median: float, high: float, bound: str = "") -> None:
    """Print one line of figures."""
    print(f"{name:<58} {median:8.2f} {high:8.2f}   {bound}")


def measure_server() -> None:
    """The core and the answers, without a browser."""
    experiment = Experiment.from_dict({"order": 4, "xi": 0.74})
    _, measurements, _ = observe(experiment)
    gains = experiment.gains()
    print(f"\n{'1,000 samples, two axes, order 4':<58} {'median':>8} {'p95':>8}   ms")
    row("the filter alone", *timed(lambda: run_filter(measurements, gains)))
    row("core: run with metrics and stability", *timed(lambda: run_experiment(experiment)), "at most 1 median")
    row("figures of merit of the gains", *timed(lambda: merits(gains, 1.0)))
    row("nearest stable gains", *timed(lambda: nearest_stable(UNSTABLE)))
    for desk in (EXPLORE, STABILITY):
        request = moved(desk)
        often = [name for name, plot in desk.plots.items() if plot.often]
        in_turn = [name for name in desk.plots if name not in often]
        live = replace(request, want=[*often, in_turn[0]])
        full = replace(request, want=list(desk.plots))
        row(f"{desk.page}: answer to a moving slider", *timed(lambda d=desk, q=live: framed(*live_answer(d, q))))
        row(f"{desk.page}: answer to the callback, all patches", *timed(lambda d=desk, q=full: answer(d, q)))


def measure_methods() -> None:
    """Every method on a long run, and the search at every sample beside the same in plain Python."""
    rest = {"scenario": "yu-wu", "interval": 0.0125, "samples": 8_000, "noise_std": 10.0}
    print(f"\n{'8,000 samples, two axes':<58} {'median':>8} {'p95':>8}   ms")
    truth, measurements, _ = observe(Experiment.from_dict(rest))
    for method in METHODS.values():
        order = method.orders[-1]
        row(
            f"{method.name}, order {order}",
            *timed(lambda m=method, o=order: m.run(measurements, o, truth=truth), rounds=20),
        )
    search = METHODS["sample-search"]
    sets, _ = candidates(4, 4, 6, "interior", "printed")
    row(
        f"sample-search, order 4, all {len(sets)} sets",
        *timed(lambda: search.run(measurements, 4, truth=truth, bound="printed", limit=1e300), rounds=20),
    )


def moved(desk: Desk) -> Question:
    """What a page asks after a slider has moved and everything has been drawn."""
    settings, _ = from_query({"order": "4", "xi": "0.74"})
    first = Question(seq=1, controls=controls_of(settings))
    _, rest = answer(desk, first)
    return replace(first, changed=["xi"], drawn=rest["drawn"])


def measure_scenes() -> None:
    """From a picture that is shown to the frame that a browser has, through the proxy."""
    print(f"\n{'scene updated to frame received, 25 moves a second each':<58} {'median':>8} {'p95':>8}   ms")
    for sessions, bound in ((10, ""), (40, "at most 10 median")):
        outcome = scenes.measure(sessions)
        name = f"{sessions} scenes: {outcome.frames:,} frames for {len(outcome.delays):,} moves"
        row(name, *np.percentile(outcome.delays, [50, 95]), bound)


def measure_browser() -> None:
    """The drag, in Chromium."""
    print(f"\n{'slider to drawn plot, 240 mouse moves':<58} {'median':>8} {'p95':>8}   ms")
    with server() as port, sync_playwright() as playwright, Delay(port, 0.08) as line:
        browser = launch(playwright)
        for name, at, rate, point, bound in (
            ("25 moves a second", port, 25, False, "at most 40 median, 100 p95"),
            ("25 moves a second, 80 ms of added latency", line.port, 25, False, "at least 30 drawn, the last one too"),
            ("60 moves a second", port, 60, False, ""),
            ("the point in the map, 25 moves a second", port, 25, True, "at most 100 p95"),
        ):
            context = browser.new_context(viewport={"width": 1440, "height": 900})
            page = context.new_page()
            page.goto(f"http://127.0.0.1:{at}/{'?order=2&design=manual&alpha=0.6&beta=0.3' if point else ''}")
            settle(page)
            page.wait_for_timeout(1000)
            outcome = drag(page, moves=240, rate=rate, point=point)
            row(f"{name}: {summary(outcome)}", *np.percentile(outcome.delays, [50, 95]), bound)
            context.close()
        browser.close()


def summary(outcome: Drag) -> str:
    """How many changes were drawn."""
    return f"{outcome.drawn} of {outcome.changes} drawn, last {'drawn' if outcome.last_drawn else 'MISSING'}"


def measure_long_work() -> None:
    """A million runs in one browser beside a slider in another."""
    seen = long_work.measure()
    print(f"\n{'slider to drawn plot on Explore, 25 moves a second':<58} {'median':>8} {'p95':>8}   ms")
    row("alone", *np.percentile(seen.alone, [50, 95]))
    row("beside a million runs in another browser", *np.percentile(seen.beside, [50, 95]), "at most 150 p95")
    print(f"partial results meanwhile: {seen.updates}; {seen.rate:,.0f} runs a second of two filters")
    print(f"stopped {seen.ended:.2f} s after the click, at most 1, with {100 * seen.share:.0f} % done")


PARTS: dict[str, Callable[[], None]] = {
    "speed": measure_speed,
    "memory": measure_memory,
    "startup": measure_startup,
    "server": measure_server,
    "methods": measure_methods,
    "documents": measure_documents,
    "scenes": measure_scenes,
    "browser": measure_browser,
    "long-work": measure_long_work,
}


def main() -> None:
    """Measure everything, or the parts that are named, and print it."""
    wanted = sys.argv[1:] or list(PARTS)
    for name in wanted:
        if name not in PARTS:
            raise SystemExit(f"python -m benchmarks [{'|'.join(PARTS)} ...]")
    packages = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    print(f"{processor()}, {os.cpu_count()} processors, Python {platform.python_version()}, {packages}")
    for name in wanted:
        PARTS[name]()


def processor() -> str:
    """What the machine calls its processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.machine())


if __name__ == "__main__":
    main()
