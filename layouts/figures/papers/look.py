"""What the figures of papers share: rows over one axis, traces that say what they are, marks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import ceil, floor, log10
from typing import Any

from layouts.figures.common import NAMES, Figure, packed, thinned, trace
from layouts.theme import hollow, layout, tokens
from tracker_core.papers import Paper
from tracker_core.types import FloatArray

Draw = Callable[[Paper, Mapping[str, Any], str], Figure]
"""Draws one kind of illustration: from the document, the options and the theme."""

HEIGHT = 340
"""Of a figure of one row, px; every further row adds ROW."""

ROW = 80
GAP = 0.07
"""Between two rows, as a part of all of them."""

LOOKS = (
    ("curve-2", "solid"), ("curve-1", "8px 3px"), ("curve-3", "2px 2px"), ("curve-4", "6px 2px 2px 2px"),
    ("accent", "12px 3px"),
)  # fmt: skip
"""Colour and dash of filters that stand side by side."""

FEW = 30
"""Of so few samples every one is marked."""

UNITS = ("m", "m/s", "m/s²", "m/s³")


def hover(name: str, x: str, y: str) -> str:
    """What a point says: whose it is, and its coordinates with the titles of their axes as "quantity (unit)"."""
    return f"{name}<br>{_said(x, 'x')}<br>{_said(y, 'y')}<extra></extra>"


def _said(title: str, axis: str) -> str:
    quantity, _, unit = title.partition(" (")
    return f"{quantity} %{{{axis}:.5~g}} {unit.rstrip(')')}".rstrip()


def path(name: str, x: FloatArray, y: FloatArray, titles: tuple[str, str], line: dict[str, Any]) -> dict[str, Any]:
    """A named line."""
    return {
        "type": "scatter", "mode": "lines", "name": name, "x": packed(x), "y": packed(y), "line": line,
        "hovertemplate": hover(name, *titles),
    }  # fmt: skip


def filter_line(index: int, theme: str, width: float = 2) -> dict[str, Any]:
    """The line of the index-th of several filters."""
    colour, dash = LOOKS[index]
    return {"color": tokens(theme)[colour], "dash": dash, "width": width}


def four(kind: str, x: FloatArray, y: FloatArray, titles: tuple[str, str], theme: str, **more: Any) -> dict[str, Any]:
    """One of the four series of a track, measurements thinned out where there are many."""
    if kind == "observed":
        some = thinned(len(x))
        x, y = x[some], y[some]
        more = {"marker": hollow(theme, 4 if len(x) > FEW else 7)} | more
    elif len(x) <= FEW:
        more = {"mode": "lines+markers", "marker": {"size": 5, "color": tokens(theme)[kind]}} | more
    return trace(kind, x, y, theme, hovertemplate=hover(NAMES[kind], *titles), **more)


def marks(name: str, x: Sequence[float], y: Sequence[float], titles: tuple[str, str], theme: str) -> dict[str, Any]:
    """Points that are pointed out."""
    return {
        "type": "scatter", "mode": "markers", "name": name, "x": list(x), "y": list(y),
        "marker": {
            "symbol": "diamond", "size": 10, "color": tokens(theme)["marker"],
            "line": {"width": 1, "color": tokens(theme)["surface"]},
        },
        "hovertemplate": hover(name, *titles),
    }  # fmt: skip


def upright(name: str, x: float, low: float, high: float, theme: str) -> dict[str, Any]:
    """A vertical line at a number that is printed."""
    return {
        "type": "scatter", "mode": "lines", "name": name, "x": [x, x], "y": [low, high],
        "line": {"color": tokens(theme)["ink-soft"], "width": 1.5, "dash": "3px 3px"},
        "hovertemplate": f"{name}<extra></extra>",
    }  # fmt: skip


def in_row(row: int, traces: Sequence[dict[str, Any]], *, listed: bool = True) -> list[dict[str, Any]]:
    """Traces for the row-th row from the top, over the axis that all rows share."""
    placed: list[dict[str, Any]] = [one | ({"yaxis": f"y{row + 1}"} if row else {}) for one in traces]
    return placed if listed else [one | {"showlegend": False} for one in placed]


def rows(
    theme: str,
    data: list[dict[str, Any]],
    x_axis: dict[str, Any],
    y_axes: Sequence[dict[str, Any]],
    **more: Any,
) -> Figure:
    """A figure of rows, from the top, over one horizontal axis."""
    last = len(y_axes) - 1
    share = (1 - GAP * last) / len(y_axes)
    axes: dict[str, Any] = {"xaxis": x_axis | ({"anchor": f"y{last + 1}"} if last else {})}
    for row, y_axis in enumerate(y_axes):
        bottom = (last - row) * (share + GAP)
        axes[f"yaxis{row + 1 if row else ''}"] = y_axis | {"domain": [bottom, min(bottom + share, 1)]}
    return {"data": data, "layout": frame(theme, height=HEIGHT + ROW * last, **axes, **more)}


def frame(theme: str, **more: Any) -> dict[str, Any]:
    """The layout of a figure with its legend above, which makes room for itself."""
    return layout(
        theme,
        **(
            {
                "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
                "margin": {"l": 60, "r": 14, "t": 34, "b": 44},
                "height": HEIGHT,
                "showlegend": True,
            }
            | more
        ),
    )


def log_axis(title: str, low: float, high: float) -> dict[str, Any]:
    """A logarithmic axis from `low` to `high` with ticks that can be read: 1, 2, 5, or decades where there are many."""
    decades = log10(high / low)
    steps = (1, 2, 5) if decades < 2.5 else (1,)
    every = 2 if decades > 6 else 1
    powers = [power for power in range(floor(log10(low)), ceil(log10(high)) + 1) if power % every == 0]
    values = [step * 10.0**power for power in powers for step in steps]
    values = [value for value in values if low * (1 - 1e-9) <= value <= high * (1 + 1e-9)]
    return titled(
        title,
        type="log",
        range=[log10(low), log10(high)],
        tickvals=values,
        ticktext=[_tick(value) for value in values],
    )


def _tick(value: float) -> str:
    """1, 2 or 5 times a power of ten, short."""
    power = floor(log10(value) + 1e-9)
    if not -4 < power < 9:
        return f"{value / 10.0**power:.0f} × 10{str(power).translate(_RAISED)}".removeprefix("1 × ")
    if power < 3:
        return f"{value:.{max(0, -power)}f}"
    return f"{value / 1e3:.0f}k" if power < 6 else f"{value / 1e6:.0f}M"


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def titled(title: str, **more: Any) -> dict[str, Any]:
    """An axis with its title."""
    return {"title": {"text": title}, **more}
