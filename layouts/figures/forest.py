"""Differences of several filters to a reference over many runs, each with its interval: a forest plot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from math import isnan
from typing import Any

from layouts.comparing import PRESENT
from layouts.figures.common import Figure
from layouts.text import significant
from layouts.theme import PIN_LOOKS, layout, tokens
from tracker_core.metrics import Metric
from tracker_core.statistics import Interval
from tracker_core.tuning.monte_carlo import Difference

LABEL = 22
"""Characters of a name beside the axis; all of it stands in the list, and under the pointer."""


FAR = 10
"""A filter this many times as far off as all nearer ones is named at the edge: it would press them into one line."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One filter's line.

    Attributes:
        slot: of the pin; PRESENT for the present filter.
        name: what it is called.
        difference: to the reference.
    """

    slot: int
    name: str
    difference: Difference


def forest_figure(entries: Sequence[Entry], metric: Metric, reference: str, theme: str, *, final: bool) -> Figure:
    """Per filter the difference in one metric with its interval; hollow where it may be chance.

    In percent of the reference's mean, or in the metric's unit where that is percent itself or percent are not known.

    Args:
        entries: the filters, from above.
        metric: which one.
        reference: name of the filter that they are compared with.
        theme: "light" or "dark".
        final: whether the last run is in; before it nothing is told from chance, and all are hollow.
    """
    t = tokens(theme)
    in_percent = metric.unit != "%" and not any(isnan(entry.difference.percent.mean) for entry in entries)
    unit = "%" if in_percent else "percentage points" if metric.unit == "%" else metric.unit
    means = [_interval(entry, in_percent=in_percent).mean for entry in entries]
    span = _span(means)
    near = [span is None or isnan(mean) or span[0] <= mean <= span[1] for mean in means]
    data = [
        _line(entry, -row, unit, theme, in_percent=in_percent, final=final)
        for row, entry in enumerate(entries)
        if near[row]
    ]
    notes = [] if entries else [_note("Pin a filter to compare it with.", t["ink-soft"])]
    notes += [
        _beyond(mean, -row, f"{significant(mean, 3)} {unit}", t["ink"])
        for row, mean in enumerate(means)
        if not near[row]
    ]
    return {
        "data": data,
        "layout": layout(
            theme,
            uirevision="forest",
            showlegend=False,
            annotations=notes,
            margin={"l": 150, "r": 16, "t": 8, "b": 60},
            shapes=[
                {
                    "type": "line", "x0": 0, "x1": 0, "y0": 0, "y1": 1, "yref": "paper",
                    "line": {"color": t["truth"], "width": 1.5}, "visible": bool(entries),
                }
            ],
            xaxis={
                "title": {"text": f"difference to<br>{escape(_short(reference), quote=False)} ({unit})"},
                "rangemode": "tozero",
                "zeroline": False,
                "visible": bool(entries),
                **({} if span is None else {"range": span}),
            },
            yaxis={
                "tickvals": [-row for row in range(len(entries))],
                "ticktext": [escape(_short(entry.name), quote=False) for entry in entries],
                "range": [0.6 - max(1, len(entries)), 0.6],
                "showgrid": False,
                "zeroline": False,
                "fixedrange": True,
            },
        ),
    }  # fmt: skip


def _interval(entry: Entry, *, in_percent: bool) -> Interval:
    return entry.difference.percent if in_percent else entry.difference.interval


def _span(means: Sequence[float]) -> list[float] | None:
    """What the axis spans where some filters are far beyond the others; None where it follows from all of them."""
    sizes = sorted(abs(mean) for mean in means if not isnan(mean))
    for nearer, farther in pairwise(sizes):
        if nearer and farther > FAR * nearer:
            inside = [mean for mean in means if abs(mean) <= nearer]
            low, high = min(0.0, *inside), max(0.0, *inside)
            pad = 0.15 * (high - low)
            return [low - pad, high + pad]
    return None


def _beyond(mean: float, y: int, text: str, colour: str) -> dict[str, Any]:
    """Where a filter lies that is not in the picture."""
    right = mean > 0
    return {
        "x": float(right), "xref": "paper", "xanchor": "right" if right else "left", "y": y, "showarrow": False,
        "text": f"{text} →" if right else f"← {text}", "font": {"color": colour, "size": 12},
    }  # fmt: skip


def _line(entry: Entry, y: int, unit: str, theme: str, *, in_percent: bool, final: bool) -> dict[str, Any]:
    difference, t = entry.difference, tokens(theme)
    interval = _interval(entry, in_percent=in_percent)
    colour = t["smoothed"] if entry.slot == PRESENT else t[f"pin-{entry.slot}"]
    symbol = "circle" if entry.slot == PRESENT else PIN_LOOKS[entry.slot][1]
    known = not isnan(interval.low)
    verdict = (": significant" if difference.significant else ": not significant") if final else ""
    said = f"{significant(interval.mean, 3)} {unit}, {significant(interval.low, 3)} to {significant(interval.high, 3)}"
    return {
        "type": "scatter", "mode": "markers", "x": [interval.mean], "y": [y], "name": escape(entry.name, quote=False),
        "marker": {
            "symbol": symbol if final and difference.significant else f"{symbol}-open", "size": 12, "color": colour,
            "line": {"width": 2, "color": colour},
        },
        "error_x": {
            "type": "data", "symmetric": False, "array": [interval.high - interval.mean if known else 0],
            "arrayminus": [interval.mean - interval.low if known else 0], "color": colour, "thickness": 2, "width": 6,
        },
        "hovertemplate": f"{said}{verdict}",
        "hoverlabel": {"namelength": -1},
    }  # fmt: skip


def _short(name: str) -> str:
    return name if len(name) <= LABEL else f"{name[: LABEL - 1].rstrip()}…"


def _note(text: str, colour: str) -> dict[str, Any]:
    return {
        "text": text, "x": 0.5, "y": 0.5, "xref": "paper", "yref": "paper", "showarrow": False,
        "font": {"color": colour, "size": 13},
    }  # fmt: skip
