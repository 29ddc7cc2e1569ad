"""What the proofs share: runs over seeds, printed cells, numbers as text, poles as points."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from decimal import Decimal
from typing import Any

import numpy as np

from tracker_core.conventions import Gains
from tracker_core.design import MANUAL
from tracker_core.experiment import PARAMETERS, Experiment
from tracker_core.papers.document import papers
from tracker_core.papers.printed import number
from tracker_core.papers.proof import Chart, Series
from tracker_core.papers.reproduce import agrees
from tracker_core.run import Result, run_experiment
from tracker_core.types import GAIN_NAMES, FloatArray

SEEDS = range(1, 21)
HUNDRED = range(1, 101)
"""For totals that are compared to a few percent: those of the tables of Jeong et al."""

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def experiment_of(paper: str, run: str) -> Experiment:
    """The experiment of a document's run."""
    return papers()[paper].run(run).experiment


def with_gains(experiment: Experiment, gains: Gains) -> Experiment:
    """The same experiment with gains set by hand."""
    changes: dict[str, Any] = dict.fromkeys(PARAMETERS) | dict(zip(GAIN_NAMES, gains.values, strict=False))
    return replace(experiment, design=MANUAL, order=gains.order, convention=gains.convention, **changes)


def results(experiment: Experiment, seeds: Iterable[int] = SEEDS) -> list[Result]:
    """The runs of an experiment with every seed."""
    return [run_experiment(replace(experiment, seed=seed)) for seed in seeds]


def compare(experiments: Sequence[Experiment], *metrics: str, seeds: Iterable[int] = SEEDS) -> FloatArray:
    """Figures of merit of several filters on the same measurements.

    Returns:
        Shape (len(experiments), len(metrics), number of seeds); NaN where a run has none.
    """
    # Seed by seed: what is observed with one is remembered for the next filter.
    runs = [[run_experiment(replace(one, seed=seed)).metrics for one in experiments] for seed in seeds]
    found = [[[getattr(run, metric) for run in row] for row in runs] for metric in metrics]
    return np.array(found, dtype=np.float64).transpose(2, 0, 1)


def median(experiment: Experiment, metric: str, seeds: Iterable[int] = SEEDS) -> float:
    """The median of one figure of merit over the seeds."""
    return float(np.median(compare([experiment], metric, seeds=seeds)))


def cell(paper: str, table: str, row: str, column: str) -> str:
    """A cell as printed."""
    return papers()[paper].table(table).printed(row, column)


def exact(paper: str, table: str, row: str, column: str) -> Decimal:
    """The number in a cell, exactly."""
    return number(cell(paper, table, row, column))


def printed(paper: str, table: str, row: str, column: str) -> float:
    """The number in a cell."""
    return float(exact(paper, table, row, column))


def agree(text: str, value: float | Decimal) -> bool:
    """Whether a value, rounded, is what is printed."""
    return agrees(float(value), text)


def plain(value: float | Decimal, decimals: int = 0) -> str:
    """A number with grouped thousands, a true minus sign and so many decimals."""
    return f"{value:,.{decimals}f}".replace("-", "−")


def digits(value: float, count: int = 4) -> str:
    """A number with so many significant digits."""
    return f"{value:.{count}g}".replace("-", "−")


def power(value: float, decimals: int = 2) -> str:
    """A number as mantissa and power of ten; zero as 0."""
    if value == 0:
        return "0"
    mantissa, exponent = f"{value:.{decimals}e}".split("e")
    return f"{mantissa.replace('-', '−')} × {decade(int(exponent))}"


def decade(exponent: int) -> str:
    """A power of ten."""
    return f"10{str(exponent).translate(_RAISED)}"


def metres(value: float | Decimal, decimals: int = 0) -> str:
    """A length."""
    return f"{plain(value, decimals)} m"


def listed(values: Iterable[float], decimals: int) -> str:
    """Numbers in one line."""
    return ", ".join(plain(value, decimals) for value in values)


def pole_list(poles: Iterable[complex], decimals: int = 3) -> str:
    """Poles in one line, a conjugate pair as one."""
    texts = []
    for pole in poles:
        # Gains that are printed with a few digits part equal poles.
        if abs(pole.imag) < 1e-3:
            texts.append(plain(pole.real, decimals))
        elif pole.imag > 0:
            texts.append(f"{plain(pole.real, decimals)} ± {plain(pole.imag, decimals)}i")
    return ", ".join(texts)


def pole_series(name: str, role: str, poles: Iterable[complex]) -> Series:
    """Poles as points of the z-plane."""
    points = tuple(poles)
    return Series(name, "points", role, tuple(pole.real for pole in points), tuple(pole.imag for pole in points))


def bars(name: str, role: str, values: dict[str, float]) -> Series:
    """Named numbers as bars."""
    return Series(name, "bars", role, tuple(values), tuple(values.values()))


def line(name: str, role: str, x: Iterable[float], y: Iterable[float]) -> Series:
    """A curve."""
    return Series(name, "line", role, tuple(map(float, x)), tuple(map(float, y)))


def plane(title: str, *series: Series) -> Chart:
    """A chart of poles."""
    return Chart(title, "real part", "imaginary part", series, z_plane=True)
