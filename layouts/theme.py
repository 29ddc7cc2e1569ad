"""The tokens of assets/tokens.css, and the look of every plot made from them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

TOKENS = Path(__file__).parent.parent / "assets" / "tokens.css"
THEMES = ("light", "dark")

_BLOCK = re.compile(r':root(?P<dark>\[data-theme="dark"\])?\s*{(?P<body>[^}]*)}')
_TOKEN = re.compile(r"--(?P<name>[\w-]+):\s*(?P<value>[^;]+);")

LINES: dict[str, dict[str, Any]] = {
    "truth": {"width": 1.5},
    "predicted": {"width": 1.25, "dash": "4px 3px"},
    "smoothed": {"width": 2.5},
    "counterpart": {"width": 2, "dash": "8px 3px 2px 3px"},
}
"""How each kind of line is drawn, the same on every plot; observed is never joined."""


SCORES = {"tracking": "predicted", "estimation": "smoothed", "innovation": "predicted"}
"""Whose colour an error has: an innovation is what the prediction misses the measurement by."""


PIN_LOOKS: dict[int, tuple[str, str]] = {
    1: ("9px 3px", "circle"),
    2: ("2px 2px", "square"),
    3: ("12px 3px 2px 3px", "diamond"),
    4: ("5px 2px", "triangle-up"),
    5: ("7px 2px 2px 2px 2px 2px", "cross"),
    6: ("16px 4px", "x"),
}
"""Dash and marker of the pin in each slot; its colour is a token."""


@cache
def tokens(theme: str) -> dict[str, str]:
    """The design tokens of one theme by name; dark ones fall back to light ones."""
    blocks = {bool(match["dark"]): match["body"] for match in _BLOCK.finditer(TOKENS.read_text(encoding="utf-8"))}
    values = {match["name"]: match["value"].strip() for match in _TOKEN.finditer(blocks[False])}
    if theme == "dark":
        values.update({match["name"]: match["value"].strip() for match in _TOKEN.finditer(blocks[True])})
    return values


@cache
def _template(theme: str) -> dict[str, Any]:
    t = tokens(theme)
    axis = {
        "gridcolor": t["grid"],
        "linecolor": t["line"],
        "zerolinecolor": t["line"],
        "zerolinewidth": 1,
        "tickcolor": t["line"],
        "automargin": False,
        "title": {"font": {"size": 12}, "standoff": 4},
        "tickfont": {"size": 11},
    }
    return {
        "layout": {
            "paper_bgcolor": t["surface"],
            "plot_bgcolor": t["surface"],
            "font": {"family": t["font"], "color": t["ink-soft"], "size": 12},
            "xaxis": axis,
            "yaxis": axis,
            "legend": {"font": {"color": t["ink"], "size": 12}, "bgcolor": "rgba(0,0,0,0)"},
            "hoverlabel": {
                "bgcolor": t["raised"],
                "bordercolor": t["line"],
                "font": {"color": t["ink"], "family": t["font"], "size": 12},
            },
            "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": t["control"], "activecolor": t["accent"]},
        }
    }


def layout(theme: str, **more: Any) -> dict[str, Any]:
    """A plot's layout in the given theme, with what the plot adds to it."""
    return {
        "template": _template(theme),
        "margin": {"l": 56, "r": 12, "t": 8, "b": 40},
        "hovermode": "closest",
        "dragmode": "pan",
        **more,
    }


def line(kind: str, theme: str) -> dict[str, Any]:
    """The line of one kind of data: truth, predicted or smoothed."""
    return {**LINES[kind], "color": tokens(theme)[kind]}


def pin_line(slot: int, theme: str) -> dict[str, Any]:
    """The line of the pin in a slot, the same on every plot."""
    t = tokens(theme)
    return {"width": 1.75, "dash": PIN_LOOKS[slot][0], "color": t[f"pin-{slot}"]}


def pin_marker(slot: int, theme: str, size: float = 7) -> dict[str, Any]:
    """The marker of the pin in a slot, on some of the points of its line."""
    t = tokens(theme)
    return {"symbol": PIN_LOOKS[slot][1], "size": size, "color": t[f"pin-{slot}"], "maxdisplayed": 14}


def hollow(theme: str, size: float = 4.5) -> dict[str, Any]:
    """The marker of measurements."""
    return {
        "symbol": "circle-open",
        "size": size,
        "color": tokens(theme)["observed"],
        "line": {"width": 1, "color": tokens(theme)["observed"]},
    }
