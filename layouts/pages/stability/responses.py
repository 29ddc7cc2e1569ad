"""The responses of a filter as tables: the numbers that its plots are drawn from, some of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from dash.development.base_component import Component

from layouts.components import table
from layouts.figures.responses import FREQUENCIES, LOWEST, decibels, degrees, span
from layouts.numbers import listed
from layouts.state import INPUTS, Settings
from layouts.text import significant
from tracker_core import Result
from tracker_core.responses import frequency_response, time_response
from tracker_core.types import FloatArray

DIGITS = 5


def response_tables(result: Result, settings: Settings) -> Iterator[Component]:
    """What the filter makes of the chosen input, and where it is stable of every frequency."""
    interval, name = settings.experiment.interval, settings.view.input
    degree, samples = INPUTS.index(name), span(result.gains)
    response, unit = time_response(result.gains, degree, samples), interval**degree
    parts = (unit * part for part in (response.input, response.predicted, response.smoothed))
    head = ["time (s)", "input (m)", "predicted (m)", "smoothed (m)"]
    yield table(f"Response: {name}", head, _rows(interval * np.arange(samples, dtype=np.float64), *parts))
    if not result.verdict.stable:
        return
    frequency = np.geomspace(LOWEST, 0.5, FREQUENCIES)
    answer = frequency_response(result.gains, frequency)
    both = (answer.predicted, answer.smoothed)
    head = ["frequency (Hz)", *(f"{kind} ({unit})" for unit in ("dB", "°") for kind in ("predicted", "smoothed"))]
    yield table("Frequency response", head, _rows(frequency / interval, *map(decibels, both), *map(degrees, both)))


def _rows(*columns: FloatArray) -> list[list[str]]:
    some = [column[listed(len(column))].tolist() for column in columns]
    return [[significant(value, DIGITS) for value in row] for row in zip(*some, strict=True)]
