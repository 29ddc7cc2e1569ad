"""A figure in words: what its series are, how far they reach, and where single points are."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from layouts.figures.common import Figure, coordinates
from layouts.text import significant
from tracker_core.types import FloatArray

HEAD = ("Series", "Points", "Across", "Upwards")

FEW = 3
"""So many points are told one by one."""

_BREAK, _MARKUP = re.compile(r"<br>"), re.compile(r"<[^>]+>")


def summary_rows(figure: Figure) -> list[list[str]]:
    """A row as in HEAD for every series: its name, how many points it has, and what they span along both axes."""
    return [_row(trace, figure["layout"]) for trace in figure["data"] if trace.get("name")]


def _row(trace: dict[str, Any], layout: dict[str, Any]) -> list[str]:
    across, upwards = (_title(trace, layout, axis) for axis in ("x", "y"))
    name, x, y = _plain(trace["name"]), trace["x"], coordinates(trace["y"])
    if isinstance(x, list) and isinstance(x[0], str):
        said = (f"{_plain(word)} {significant(value)}" for word, value in zip(x, y.tolist(), strict=True))
        return [name, f"{len(y):,}", across, f"{upwards}: {', '.join(said)}"]
    x = coordinates(x)
    known = np.isfinite(x) & np.isfinite(y)
    return [name, f"{int(known.sum()):,}", f"{across}: {_span(x[known])}", f"{upwards}: {_span(y[known])}"]


def _span(values: FloatArray) -> str:
    if len(values) <= FEW:
        return ", ".join(map(significant, values.tolist())) or "–"
    low, high = significant(float(values.min())), significant(float(values.max()))
    return low if low == high else f"{low} to {high}"


def _title(trace: dict[str, Any], layout: dict[str, Any], axis: str) -> str:
    """Of the axis that a series is drawn over."""
    number = trace.get(f"{axis}axis", axis)[1:]
    return _plain(layout[f"{axis}axis{number}"]["title"]["text"])


def _plain(text: str) -> str:
    """Without plotly's markup."""
    return _MARKUP.sub("", _BREAK.sub(" ", text))
