"""What the tests of the papers share: printed cells, poles, and the listing of Garg, worked out without the core."""

from math import factorial

import numpy as np

from tracker_core.papers import papers
from tracker_core.papers.printed import EMPTY, number


def printed(paper, table, column):
    """The numbers of a column by row, exactly."""
    found = papers()[paper].table(table)
    cells = {row.name: found.printed(row.name, column) for row in found.rows}
    return {name: number(cell) for name, cell in cells.items() if cell != EMPTY}


def radius(gains):
    """The largest modulus among the poles of gains for 1, 1/T, 1/T^2, 1/T^3."""
    return np.abs(filter_poles(gains)).max()


def filter_poles(gains):
    order = len(gains)
    transition = [[1 / factorial(j - i) if j >= i else 0 for j in range(order)] for i in range(order)]
    return np.linalg.eigvals((np.eye(order) - np.outer(gains, np.eye(order)[0])) @ np.array(transition))


def garg_filter(ranges, speed, alpha, beta, gamma, exactly=float):
    """The second listing, row by row: smoothed state, predicted range, and range predicted next.

    `exactly` makes the numbers: float, or Decimal for what is compared with printed cells.
    """
    t = exactly(5)
    x, v, a = exactly(30_000), exactly(speed), exactly(0)
    rows = []
    for z in ranges:
        before = x + v * t + a * t * t / 2
        v = v + a * t
        x = before + alpha * (z - before)
        v = v + beta * (z - before) / t
        a = a + 2 * gamma * (z - before) / t / t
        rows.append({"x": x, "v": v, "a": a, "before": before, "next": x + v * t + a * t * t / 2})
    return rows
