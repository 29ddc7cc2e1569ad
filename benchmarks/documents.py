"""How long the source documents take: every table, figure and proof once, nothing remembered."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from layouts.figures.papers import illustration_figure
from tracker_core import DESIGNS, Experiment, Gains, run_filter
from tracker_core.batch import batch_errors
from tracker_core.papers import papers, prove, reproduce
from tracker_core.papers.proofs import PROOFS
from tracker_core.run import observe


def seconds(work: Callable[[], Any]) -> float:
    """Duration of one call."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def slowest(durations: dict[str, float], kind: str, bound: str = "") -> None:
    """Print the sum and the slowest of a kind."""
    name = max(durations, key=durations.__getitem__)
    total, longest = sum(durations.values()), durations[name]
    print(f"{f'{len(durations)} {kind}s':<20} {total:6.2f}   slowest {longest:5.2f}: {name}   {bound}")


def measure_documents() -> None:
    """Tables with their default seeds, figures, proofs; and many gain sets at once beside one after the other."""
    print("\nsource documents, seconds, once each in one process")
    for paper in papers().values():
        for table in paper.tables:
            # What is compiled and loaded is not what is measured; what one seed came to is remembered.
            reproduce(paper, table, 1)
    durations = {
        f"{paper.name}, table {table.name}": seconds(lambda p=paper, t=table: reproduce(p, t))
        for paper in papers().values()
        for table in paper.tables
    }
    slowest(durations, "table", "at most 5")
    durations = {
        f"{paper.name}, figure {figure.name}": seconds(lambda p=paper, f=figure: illustration_figure(p, f, "light"))
        for paper in papers().values()
        for figure in paper.figures
    }
    slowest(durations, "figure")
    slowest({name: seconds(lambda n=name: prove(n)) for name in PROOFS}, "proof")
    truth, measurements, _ = observe(Experiment.from_dict({"samples": 1_000, "order": 3}))
    sets = np.array([DESIGNS["fading-memory"].gains(3, xi=xi) for xi in np.linspace(0.3, 0.9, 200).tolist()])
    together = seconds(lambda: batch_errors(measurements, truth, sets))
    alone = seconds(lambda: [run_filter(measurements, Gains.normalised(one)) for one in sets])
    print(
        f"200 gain sets, 1,000 samples, two axes: errors in {1e3 * together:.1f} ms, tracks alone {1e3 * alone:.1f} ms"
    )
