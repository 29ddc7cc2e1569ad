"""The α-β filter itself: how it starts from two measurements, and where it is stable and how damped."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from layouts.figures.common import Figure, packed
from layouts.figures.papers.look import frame, path, titled
from layouts.figures.stability_map import underdamped
from layouts.theme import hollow, line, tokens
from tracker_core import run_experiment
from tracker_core.papers import Paper
from tracker_core.types import FloatArray

TIME = "time (s)"


def initialisation(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """Two measurements, the velocity that they give, and the prediction for the third sample."""
    result = run_experiment(paper.run(options["runs"][0]).experiment)
    axis = options["axis"]
    letter = result.scenario.axes[axis]
    titles = (TIME, f"{letter} (m)")
    times, observed = result.truth.times[:3], result.measurements.positions[:3, axis]
    true, predicted = result.truth.states[:3, axis, 0], float(result.track.predicted[2, axis, 0])
    velocity = float(result.track.smoothed[1, axis, 1])
    t = tokens(theme)
    ray = np.array([observed[0], observed[1], predicted])
    points = path("Observed", times, observed, titles, {})
    points |= {"mode": "markers", "marker": hollow(theme, 11)}
    prediction = path("Predicted for sample 3", times[2:], np.array([predicted]), titles, {})
    prediction |= {"mode": "markers", "marker": {"size": 11, "symbol": "x", "color": t["predicted"]}}
    slope = path("Smoothed velocity", times, ray, titles, line("smoothed", theme))
    notes = [
        (0, f"{letter}<sub>m</sub>(1) = {observed[0]:.1f} m", observed[0], 26, 15, "left"),
        (1, f"{letter}<sub>m</sub>(2) = {observed[1]:.1f} m<br>v<sub>s</sub>(2) = {velocity:.1f} m/s", observed[1], -14,
         -34, "right"),
        (2, f"{letter}<sub>p</sub>(3) = {predicted:.1f} m", predicted, -16, -16, "right"),
    ]  # fmt: skip
    seen = np.concatenate((true, ray, observed))
    low, span = float(seen.min()), float(np.ptp(seen))
    begin, step = float(times[0]), float(times[1] - times[0])
    return {
        "data": [path("True", times, true, titles, line("truth", theme)), slope, points, prediction],
        "layout": frame(
            theme,
            xaxis=titled(TIME, range=[begin - 0.12 * step, begin + 2.12 * step], dtick=step),
            yaxis=titled(titles[1], range=[low - 0.2 * span, low + 1.25 * span]),
            annotations=[
                {
                    "x": float(times[sample]), "y": float(y), "text": text.replace("-", "−"),
                    "ax": ax, "ay": ay, "xanchor": anchor, "align": anchor, "showarrow": True, "arrowhead": 0,
                    "arrowwidth": 1, "arrowcolor": t["control"], "standoff": 6,
                    "font": {"color": t["ink"], "size": 12},
                }
                for sample, text, y, ax, ay, anchor in notes
            ],
        ),
    }  # fmt: skip


def triangle(_: Paper, __: Mapping[str, Any], theme: str) -> Figure:
    """The stable triangle with its three kinds of response, critical damping, and the bound at α = 1.

    With two gains the poles are the roots of z² + (α + β − 2) z + 1 − α. They are complex inside the curve
    β = 2 − α ± 2√(1 − α); beyond its right end, at α = 1, their product is negative.
    """
    t = tokens(theme)
    alpha, beta = underdamped()
    half = len(alpha) // 2
    lower, upper = (alpha[:half], beta[:half]), (alpha[half:], beta[half:])
    # Below the lower branch of the curve, and above its upper one.
    calm = np.concatenate((lower[0], [1, 0])), np.concatenate((lower[1], [0, 0]))
    swinging = np.concatenate((upper[0], [0, 1])), np.concatenate((upper[1], [4, 2]))
    beyond = np.array([1.0, 1, 2, 1]), np.array([0.0, 2, 0, 0])
    critical = path("Critically damped", alpha, beta, ("α", "β"), {"color": t["ink"], "width": 2})
    edge = path("Edge of stability", np.array([0.0, 0, 2, 0]), np.array([0.0, 4, 0, 0]), ("α", "β"),
                {"color": t["region-line"], "width": 1.5})  # fmt: skip
    bound = path("α = 1 (eq. 21)", np.array([1.0, 1]), np.array([0.0, 2]), ("α", "β"),
                 {"color": t["bad"], "width": 2, "dash": "6px 3px"})  # fmt: skip
    return {
        "data": [
            _area("Underdamped", (alpha, beta), t["curve-1"]),
            _area("Overdamped", calm, t["curve-3"]),
            _area("Both poles negative", swinging, t["curve-2"]),
            _area("One pole negative", beyond, t["curve-4"]),
            edge | {"showlegend": False}, critical, bound,
        ],
        "layout": frame(
            theme, xaxis=titled("α", range=[-0.08, 2.08]), yaxis=titled("β", range=[-0.16, 4.16])
        ),
    }  # fmt: skip


def _area(name: str, corners: tuple[FloatArray, FloatArray], colour: str) -> dict[str, Any]:
    return {
        "type": "scatter", "mode": "lines", "name": name, "x": packed(corners[0]), "y": packed(corners[1]),
        "fill": "toself", "fillcolor": colour, "opacity": 0.35, "line": {"width": 0, "color": colour},
        "hoveron": "fills", "hoverinfo": "name",
    }  # fmt: skip
