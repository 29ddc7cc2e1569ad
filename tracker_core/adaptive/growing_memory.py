"""M2 of Al-Wagih & Abdulla: least squares over all measurements so far, whose gains fall with their number n.

That is what these gains are for an even series. Over gaps and at intervals that vary they are not, and errors are
larger than those of least squares, whose gains would depend on when it was measured (see `tracker_core.starts`).

With D = n(n+1)...(n+m-1), m the order:

    m = 2   alpha = 2(2n-1)/D               beta = 6/D
    m = 3   alpha = 3(3n^2-3n+2)/D          beta = 18(2n-1)/D           gamma = 60/D
    m = 4   alpha = 8(2n^3-3n^2+7n-3)/D     beta = 20(6n^2-6n+5)/D      gamma = 240(2n-1)/D     eta = 840/D
"""

from __future__ import annotations

import numpy as np

from tracker_core.adaptive.base import Method, Problem, Selection
from tracker_core.adaptive.scheduled import run_schedule
from tracker_core.types import FloatArray, IntArray


def growing_gains(order: int, counts: IntArray) -> FloatArray:
    """Normalised gains after so many measurements, shape (n_samples, order).

    Args:
        order: 2, 3 or 4.
        counts: shape (n_samples,), number of measurements, whole. With fewer than `order` the polynomial through them
            is of lower degree.
    """
    gains = np.zeros((len(counts), order))
    for degree in range(1, order + 1):
        rows = counts >= degree if degree == order else counts == degree
        n = counts[rows].astype(np.float64)
        gains[rows, :degree] = np.stack(_formulas(degree, n), axis=1)
    return gains


def _formulas(order: int, n: FloatArray) -> tuple[FloatArray, ...]:
    if order == 1:
        return (1 / n,)
    if order == 2:
        divisor = n * (n + 1)
        return 2 * (2 * n - 1) / divisor, 6 / divisor
    if order == 3:
        divisor = n * (n + 1) * (n + 2)
        return 3 * (3 * n**2 - 3 * n + 2) / divisor, 18 * (2 * n - 1) / divisor, 60 / divisor
    divisor = n * (n + 1) * (n + 2) * (n + 3)
    return (
        8 * (2 * n**3 - 3 * n**2 + 7 * n - 3) / divisor,
        20 * (6 * n**2 - 6 * n + 5) / divisor,
        240 * (2 * n - 1) / divisor,
        840 / divisor,
    )


def work(problem: Problem) -> Selection:
    """The gains of each measurement's number."""
    return run_schedule(problem, lambda _, counts: growing_gains(problem.setting.order, counts))


METHOD = Method(
    name="growing-memory",
    title="Growing memory (M2)",
    orders=(2, 3, 4),
    parameters={},
    work=work,
    sentence="Least squares over all measurements of an even series so far: the gains fall as their number n grows, "
    "and never stop falling. Order 2: α = 2(2n − 1)/n(n + 1), β = 6/n(n + 1).",
    source="Al-Wagih & Abdulla, eq. 24, method M2; Brookner 1998, expanding-memory polynomial filters",
)
