"""The errors of the measurements of one axis, sample by sample, and how they are distributed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from layouts.figures.common import Figure, packed, round_up
from layouts.figures.papers.look import frame, hover, titled
from layouts.theme import hollow, line, tokens
from tracker_core import run_experiment
from tracker_core.papers import Paper

REACH = 4
"""How many standard deviations are shown to either side, at least."""

BINS_PER_STD = 4


def noise(paper: Paper, options: Mapping[str, Any], theme: str) -> Figure:
    """Measured minus true position against the sample, with a histogram beside it and the normal curve over that."""
    result = run_experiment(paper.run(options["run"]).experiment)
    axis = options["axis"]
    errors = (result.measurements.positions - result.truth.positions)[:, axis]
    std = result.noise_std[axis]
    reach = max(REACH, int(np.ceil(np.abs(errors).max() / std)))
    edges = np.linspace(-reach, reach, 2 * reach * BINS_PER_STD + 1) * std
    counts, middles = np.histogram(errors, edges)[0], (edges[:-1] + edges[1:]) / 2
    width = std / BINS_PER_STD
    along = np.linspace(-reach, reach, 161) * std
    normal = len(errors) * width * np.exp(-((along / std) ** 2) / 2) / (std * np.sqrt(2 * np.pi))
    top = float(max(counts.max(), normal.max()))
    # Without the zero, which would stand in the last number of the other axis.
    tick = round_up(top / 3)
    y_title, count_title = f"error of {result.scenario.axes[axis]} (m)", "number"
    t = tokens(theme)
    return {
        "data": [
            {
                "type": "scatter", "mode": "markers", "name": "Observed − true", "marker": hollow(theme, 3),
                "x": packed(np.arange(1.0, len(errors) + 1)), "y": packed(errors),
                "hovertemplate": hover("Observed − true", "sample", y_title),
            },
            {
                "type": "bar", "orientation": "h", "name": f"Number in {width:g} m", "x": counts.tolist(),
                "y": middles.tolist(), "width": 0.92 * width, "marker": {"color": t["observed"]}, "opacity": 0.55,
                "xaxis": "x2", "hovertemplate": hover(f"Within {width:g} m", count_title, y_title),
            },
            {
                "type": "scatter", "mode": "lines", "name": f"Normal, σ = {std:g} m", "x": packed(normal),
                "y": packed(along), "line": line("truth", theme), "xaxis": "x2",
                "hovertemplate": hover("Normal", count_title, y_title),
            },
        ],
        "layout": frame(
            theme,
            bargap=0,
            xaxis=titled("sample", domain=[0, 0.71], range=[0, len(errors) + 1]),
            xaxis2=titled(count_title, domain=[0.76, 1], range=[0, 1.08 * top], tickvals=[tick, 2 * tick]),
            yaxis=titled(y_title, range=[-reach * std, reach * std]),
        ),
    }  # fmt: skip
