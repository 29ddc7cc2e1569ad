"""What the tests of the proofs share: lines of a proof as numbers, and filters, gains and totals worked out anew.

Textbook loops over many seeds at once; truth, measurements and printed cells are the core's.
"""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from math import sqrt

import numpy as np
import pytest

from tracker_core.papers import papers
from tracker_core.papers.proofs import prove
from tracker_core.run import observe

TRANSITION = {
    2: np.array([[1.0, 1], [0, 1]]),
    3: np.array([[1, 1, 1 / 2], [0, 1, 1], [0, 0, 1]]),
    4: np.array([[1, 1, 1 / 2, 1 / 6], [0, 1, 1, 1 / 2], [0, 0, 1, 1], [0, 0, 0, 1]]),
}


def numbers(text):
    """The numbers in a text: thousands grouped, true minus signs, powers of ten."""
    found = re.findall(r"(−?[\d,]*\d(?:\.\d+)?)(?: × 10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?", text)
    raised = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    return [
        float(value.replace("−", "-").replace(",", "")) * 10.0 ** int(power.translate(raised) or 0)
        for value, power in found
    ]


def value(name, label):
    """The value of the one line whose label begins so, as text."""
    (text,) = [text for title, text in prove(name).lines if title.startswith(label)]
    return text


def values(name, label):
    return numbers(value(name, label))


def curve(name, title):
    """x and y of one series of the chart."""
    (series,) = [series for series in prove(name).chart.series if series.name == title]
    return series.x, np.array(series.y)


def cell(paper, table, row, column):
    return papers()[paper].table(table).printed(row, column)


def assert_close(found, expected, decimals):
    """Numbers that a line prints with so many decimals are those expected."""
    assert found == pytest.approx(expected, rel=1e-9, abs=0.5000001 * 10.0**-decimals)


@cache
def seen(paper, run, seeds):
    """True and measured positions of every seed, shape (seeds, samples, axes), and the interval."""
    experiment = papers()[paper].run(run).experiment
    pairs = [observe(replace(experiment, seed=seed))[:2] for seed in range(1, seeds + 1)]
    true, measured = (np.array([pair[i].positions for pair in pairs]) for i in (0, 1))
    return true, measured, experiment.interval


def filtered(g, z, interval):
    """Predicted and smoothed positions from the third sample on, started from two points; derivatives times T^i."""
    state = np.zeros((len(g), *z[:, 0].shape))
    state[0], state[1] = z[:, 1], z[:, 1] - z[:, 0]
    predicted, smoothed = [], []
    for measured in z[:, 2:].swapaxes(0, 1):
        state = np.einsum("ij,j...->i...", TRANSITION[len(g)], state)
        predicted.append(state[0])
        state = state + np.multiply.outer(np.asarray(g), measured - state[0])
        smoothed.append(state[0])
    return np.array(predicted).swapaxes(0, 1), np.array(smoothed).swapaxes(0, 1)


def total(one, other):
    return np.sqrt(((one - other) ** 2).sum(axis=2)).sum(axis=1)


def ship(g, seeds=100):
    """Totals of the ship for every seed: tracking, innovation, and estimation, in which the start counts."""
    true, measured, interval = seen("jeong2017", "benedict-bordner", seeds)
    predicted, smoothed = filtered(g, measured, interval)
    started = total(measured[:, :2], true[:, :2])
    ahead, behind = total(predicted, true[:, 2:]), total(smoothed, true[:, 2:])
    return ahead, total(predicted, measured[:, 2:]), behind + started


def fading(xi, order):
    """Normalised gains with every pole at xi, from the polynomial (z - xi)^order: the gains are linear in it."""
    step = np.array([np.poly(TRANSITION[order] @ keep(unit)) for unit in np.eye(order)])
    base = np.poly(TRANSITION[order])
    return np.linalg.solve((step - base)[:, 1:].T, (np.poly([xi] * order) - base)[1:])


def keep(g):
    """I - K H."""
    matrix = np.eye(len(g))
    matrix[:, 0] -= g
    return matrix


def kalata(index):
    """Eq. 10-12 of Jeong et al., and eq. 13's gamma."""
    r = (4 + index - sqrt(8 * index + index**2)) / 4
    alpha = 1 - r**2
    beta = 2 * (2 - alpha) - 4 * sqrt(1 - alpha)
    return alpha, beta, beta**2 / (2 * alpha)
