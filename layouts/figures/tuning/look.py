"""What the figures of studies share: whose colour a score has, what it is called, upright lines."""

from __future__ import annotations

from math import ceil, floor, log10
from typing import Any

from layouts.figures.common import round_up
from layouts.figures.papers.charts import typeset
from layouts.theme import SCORES, tokens
from tracker_core.conventions import rewrite
from tracker_core.fields import FIELDS
from tracker_core.tuning import OBJECTIVES
from tracker_core.types import GAIN_NAMES

KINDS = {**SCORES, "": "counterpart"}
"""The colour of a score is that of what it is the error of."""


def kind_of(objective: str) -> str:
    """The token of an objective's colour."""
    return KINDS[OBJECTIVES[objective].kind]


def name_of(objective: str) -> str:
    """An objective on an axis and in a legend."""
    return OBJECTIVES[objective].title.removeprefix("Worst case: ").capitalize().replace("rmse", "RMSE")


def axis_name(gain: str, convention: str) -> str:
    """A gain along a plane, which is always normalised: said where the filter's own is written in another way."""
    symbol = FIELDS[gain].symbol
    return f"{symbol} (normalised)" if rewrite(1.0, GAIN_NAMES.index(gain), "normalised", convention) != 1 else symbol


def hover(name: str, symbol: str, unit: str) -> str:
    """What a point says: whose it is, the parameter, the score."""
    return f"{name} %{{y:.5~g}} m<br>{typeset(symbol)} = %{{x:.4~g}} {unit}".rstrip() + "<extra></extra>"


def upright(x: float | None, text: str, colour: str, theme: str, end: str) -> dict[str, Any]:
    """A line over the whole height with its name along it, at its upper "end" or in the "middle".

    In the middle it is solid, and dashed otherwise; without a place it is hidden.
    """
    return {
        "type": "line", "x0": x or 0, "x1": x or 0, "y0": 0, "y1": 1, "yref": "paper", "visible": x is not None,
        "line": {"color": colour, "width": 2, "dash": "solid" if end == "middle" else "6px 3px"},
        "label": {
            "text": text, "textposition": end, "font": {"size": 11, "color": tokens(theme)["ink"]},
            "yanchor": "bottom", "xanchor": "right" if end == "end" else "center",
        },
    }  # fmt: skip


WIDE = 6
"""Of a scale whose ends stand in a greater ratio, 1, 2 and 5 times the powers of ten are marked."""


def ticks(low: float, high: float) -> list[tuple[float, str]]:
    """Some four to seven round numbers from `low` to `high`, both positive, each with its text."""
    if high / low > WIDE:
        powers = range(floor(log10(low)), ceil(log10(high)) + 1)
        values = [step * 10.0**power for power in powers for step in (1, 2, 5)]
    else:
        step = round_up((high - low) / 6)
        values = [step * count for count in range(ceil(low / step), floor(high / step) + 1)]
    return [(value, f"{value:.6g}") for value in values if low <= value <= high]
