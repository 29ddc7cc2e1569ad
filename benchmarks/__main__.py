"""python -m benchmarks: what a slider move, a method, a source document and a scene cost."""

from __future__ import annotations

import platform
import statistics
import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

from benchmarks import scenes
from benchmarks.delay import Delay
from benchmarks.documents import measure_documents
from benchmarks.drag import Drag, drag
from benchmarks.serving import launch, server, settle
from layouts.controls import controls_of
from layouts.desk import Desk, answer, live_answer
from layouts.live import framed
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.state import from_query
from tracker_core import Experiment, Gains, Measurements, Truth, run_experiment, run_filter
from tracker_core.adaptive import METHODS
from tracker_core.adaptive.sample_search import candidates
from tracker_core.merits import merits
from tracker_core.region import nearest_stable
from tracker_core.run import observe
from tracker_core.types import FloatArray

ROUNDS = 400
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
        live = {**request, "want": [*often, in_turn[0]]}
        full = {**request, "want": list(desk.plots)}
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
    few = Measurements(measurements.times[:200], measurements.positions[:200], measurements.interval)
    known = Truth(truth.times[:200], truth.states[:200])
    sets, _ = candidates(4, 4, 6, "interior", "printed")
    name = f"sample-search, order 4, all {len(sets)} sets"
    row(
        name,
        *timed(lambda: search.run(measurements, 4, truth=truth, bound="printed", limit=1e300), rounds=20),
        "at most 50 median",
    )
    compiled = timed(lambda: search.run(few, 4, truth=known, bound="printed", limit=1e300), rounds=20)[0]
    plain = timed(lambda: plain_search(few, known, sets), rounds=3)[0]
    print(f"{'the same in plain Python, 200 samples: times as long':<58} {plain / compiled:8.0f}")


def plain_search(measurements: Measurements, truth: Truth, sets: FloatArray) -> list[float]:
    """The search at every sample as one would write it down: least error of the acceleration, order 4."""
    t, rows, positions = float(measurements.interval or 1), sets.tolist(), list[float]()
    for axis in range(2):
        z, wanted = measurements.positions[:, axis].tolist(), truth.states[:, axis, 2].tolist()
        x, v, a, j = z[1], (z[1] - z[0]) / t, 0.0, 0.0
        for i in range(2, len(z)):
            x, v, a = x + t * v + t * t / 2 * a + t**3 / 6 * j, v + t * a + t * t / 2 * j, a + t * j
            e = z[i] - x
            g0, g1, g2, g3 = min(rows, key=lambda g: abs(a + g[2] * e / t**2 - wanted[i]))
            x, v, a, j = x + g0 * e, v + g1 * e / t, a + g2 * e / t**2, j + g3 * e / t**3
            positions.append(x)
    return positions


def moved(desk: Desk) -> dict[str, Any]:
    """What a page asks after a slider has moved and everything has been drawn."""
    settings, _ = from_query({"order": "4", "xi": "0.74"})
    first = {"seq": 1, "controls": controls_of(settings), "changed": [], "theme": "light"}
    _, rest = answer(desk, first)
    return {**first, "changed": ["xi"], "drawn": rest["drawn"]}


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


def main() -> None:
    """Measure everything and print it."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba", "dash", "plotly"))
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, {packages}")
    measure_server()
    measure_methods()
    measure_documents()
    measure_scenes()
    measure_browser()


if __name__ == "__main__":
    main()
