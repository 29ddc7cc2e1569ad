"""The numbers behind the plots of a run, as tables; they are made only while somebody looks at them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dash.development.base_component import Component

from layouts.components import table
from layouts.figures.common import every
from layouts.figures.track import close_up_rows
from layouts.state import Settings
from layouts.text import significant
from tracker_core import METRICS, Result
from tracker_core.exports import track_columns
from tracker_core.innovations import EVIDENCE
from tracker_core.metrics import Metric
from tracker_core.types import STATE_NAMES

MOST_ROWS = 60
"""Of a longer series a table has every n-th."""


def listed(count: int) -> slice:
    """The rows of a series of that length that a table has: all, or every n-th."""
    return every(count, MOST_ROWS)


def run_numbers(result: Result, settings: Settings) -> list[Component]:
    """Every metric jointly and per axis, what the innovations say, and the samples around the one looked at."""
    axes, several = result.scenario.axes, len(result.scenario.axes) > 1
    columns = [result.metrics.to_dict(), *(metrics.to_dict() for metrics in result.axis_metrics() if several)]
    evidence = result.evidence()
    said = [evidence.to_dict(), *(part.to_dict() for part in evidence.axes if several)]
    head = ["", "joint", *(axes if several else ())]
    return [
        table("Metrics", head, _metric_rows(METRICS, columns)),
        table("What the innovations say", head, _metric_rows(EVIDENCE, said)),
        _samples(result, settings),
    ]


def _samples(result: Result, settings: Settings) -> Component:
    rows = close_up_rows(len(result.truth.times), settings.view.cursor(len(result.truth.times)))
    cells = {
        name: values[rows]
        for name, values in track_columns(result).items()
        if not any(state in name for state in STATE_NAMES[1:])
    }
    sample_rows = [
        [f"{int(row[0]):,}", *(significant(value, 7) for value in row[1:])]
        for row in zip(*(values.tolist() for values in cells.values()), strict=True)
    ]
    return table("Samples around the chosen one (m, s)", [name.replace("_", " ") for name in cells], sample_rows)


def _metric_rows(metrics: Mapping[str, Metric], columns: Sequence[Mapping[str, float | None]]) -> list[list[str]]:
    """Every metric in each of the columns."""
    return [
        [f"{metric.title}" + (f" ({metric.unit})" if metric.unit else "")]
        + ["–" if (value := column[name]) is None else significant(value, 6) for column in columns]
        for name, metric in metrics.items()
    ]
