"""The poles in the z-plane."""

from __future__ import annotations

from math import cos, exp, sin, sqrt
from typing import Any

import numpy as np

from layouts.figures.common import META, Figure, packed, xy
from layouts.shown import Shown
from layouts.theme import layout, tokens
from tracker_core.types import FloatArray

POLES = 3
MOVING = (META, *xy(POLES), ("data", POLES, "marker", "color"), ("data", POLES, "marker", "line", "color"))
DAMPING_RATIOS = (0.2, 0.4, 0.6, 0.8)
REACH = 1.3


def pole_figure(shown: Shown) -> Figure:
    """The poles, the unit circle around the stable ones, and curves of equal damping ratio."""
    t, verdict = tokens(shown.theme), shown.result.verdict
    angle = np.linspace(0, 2 * np.pi, 181)
    curves = equal_damping()
    poles = np.array(verdict.poles)
    colours = [t["good"] if abs(pole) < 1 else t["bad"] for pole in verdict.poles]
    return {
        "data": [
            _curve(np.cos(angle), np.sin(angle), t["region-line"], 1.5, fill=t["region"]),
            _curve(*curves, t["control"], 0.75),
            _curve(0.5 * np.cos(angle), 0.5 * np.sin(angle), t["control"], 0.75),
            {
                "type": "scatter", "mode": "markers", "x": poles.real.tolist(), "y": poles.imag.tolist(),
                "marker": {"symbol": "x-thin", "size": 12, "color": colours, "line": {"width": 3, "color": colours}},
                "name": "Poles", "hovertemplate": "%{x:.4g} + %{y:.4g}i<extra></extra>",
            },
        ],
        "layout": layout(
            shown.theme,
            uirevision="poles",
            meta=shown.meta,
            showlegend=False,
            annotations=_labels(t),
            xaxis={"title": {"text": "real part"}, "range": [-REACH, REACH], "dtick": 0.5},
            yaxis={
                "title": {"text": "imaginary part"}, "range": [-REACH, REACH], "dtick": 0.5, "scaleanchor": "x",
            },
        ),
    }  # fmt: skip


def _curve(x: FloatArray, y: FloatArray, colour: str, width: float, fill: str = "") -> dict[str, Any]:
    curve: dict[str, Any] = {
        "type": "scatter", "mode": "lines", "x": packed(x), "y": packed(y),
        "line": {"color": colour, "width": width}, "hoverinfo": "skip",
    }  # fmt: skip
    return curve | {"fill": "toself", "fillcolor": fill} if fill else curve


def equal_damping() -> tuple[FloatArray, FloatArray]:
    """Where poles have the damping ratios of DAMPING_RATIOS, upper and lower half, NaN between the curves.

    With z = exp(s) and s = -zeta w + i w sqrt(1 - zeta^2), the damped angle running from 0 to pi.
    """
    angle = np.linspace(0, np.pi, 60)
    pieces = []
    for ratio in DAMPING_RATIOS:
        radius = np.exp(-angle * ratio / np.sqrt(1 - ratio**2))
        for sign in (1, -1):
            pieces += [radius * np.exp(sign * 1j * angle), np.array([complex(np.nan, np.nan)])]
    curve = np.concatenate(pieces)
    return curve.real, curve.imag


def _labels(t: dict[str, str]) -> list[dict[str, Any]]:
    labels, angle = [], 1.15
    for ratio in DAMPING_RATIOS:
        radius = exp(-angle * ratio / sqrt(1 - ratio**2))
        labels.append(
            {
                "x": radius * cos(angle), "y": radius * sin(angle), "text": f"ζ {ratio}", "showarrow": False,
                "font": {"size": 10, "color": t["ink-soft"]},
            }
        )  # fmt: skip
    return labels
