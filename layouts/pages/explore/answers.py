"""What the Explore page shows of a run."""

from __future__ import annotations

from typing import Any

from layouts.desk import Desk, Plot
from layouts.figures import error, gains, stability_map, track
from layouts.figures.handles import gains_handle
from layouts.figures.stability_map import ALPHA_BETA
from layouts.filter_card import SLIDERS
from layouts.numbers import run_numbers
from layouts.readouts import slice_text
from layouts.rules import design_title
from layouts.run_cards import cards
from layouts.shown import Shown
from layouts.text import metric_text, significant
from tracker_core import METRICS, Result

NUMBERS = "explore-numbers"


def report(shown: Shown) -> dict[str, Any]:
    """Cards, the point that can be dragged, and how much larger deviations are drawn."""
    factor = shown.settings.view.exaggerate
    return {
        "cards": cards(shown.result, shown.settings),
        "rows": {"compared": compared_rows(shown)},
        "handles": {"explore-stability": gains_handle(shown.result.gains, ALPHA_BETA)},
        "texts": {
            "scale": "" if factor == 1 else f"deviations × {factor}",
            "slice": slice_text(shown.result.gains, ALPHA_BETA),
            "error-title": error.title(shown.result),
            "compared-text": compared_text(shown),
        },
    }


COMPARED = {"tracking_rmse": "Predicted", "estimation_rmse": "Smoothed", "estimation_max": "Greatest"}


def compared_rows(shown: Shown) -> list[list[Any]]:
    """An oracle beside its causal counterpart and the raw measurement: per row a name and COMPARED, in m."""
    result, beside = shown.result, shown.beside
    if not result.experiment.hindsight:
        return []
    measured, raw = METRICS["observation_rmse"], result.metrics.observation_rmse
    rows = [["◆ Oracle", *_compared(result)]]
    if beside is not None:
        rows.append(["Causal", *_compared(beside)])
    rows.append([measured.title, "–", metric_text(measured, raw), "–"])
    return rows


def _compared(result: Result) -> list[str]:
    if result.track.stopped_at is not None:
        return ["–" for _ in COMPARED]
    return [metric_text(METRICS[name], getattr(result.metrics, name)) for name in COMPARED]


def compared_text(shown: Shown) -> str:
    """What looking in hindsight gained over not filtering at all, in a sentence or two."""
    result, beside = shown.result, shown.beside
    raw = result.metrics.observation_rmse
    if not result.experiment.hindsight or raw is None or result.metrics.estimation_rmse is None:
        return ""
    if not raw:
        return "The measurements carry no error: no filter can gain anything over taking them as they are."
    text = f"With the answer in hand this {_gained(result, raw)}"
    if beside is None or beside.metrics.estimation_rmse is None:
        return text
    causal = design_title(beside.experiment.design)
    return f"{text} Without it, the {causal[0].lower()}{causal[1:]} {_gained(beside, raw)}"


def _gained(result: Result, raw: float) -> str:
    """What its RMSE means beside that of the raw measurement, m."""
    if result.track.stopped_at is not None:
        return "leaves the world: the run was stopped."
    ratio = (result.metrics.estimation_rmse or 0.0) / raw
    if ratio >= 1:
        return f"is no better than the raw measurement: {significant(ratio, 3)} times its error."
    return f"removes {significant(100 * (1 - ratio), 3)} % of the measurement's error."


DESK = Desk(
    page="explore",
    plots={
        "explore-path": Plot(track.path_figure, track.PATH_MOVING, track.path_key, often=True),
        "explore-close-up": Plot(track.close_up_figure, track.CLOSE_UP_MOVING, track.close_up_key, often=True),
        "explore-time": Plot(track.axis_figure, track.AXIS_MOVING, track.axis_key),
        "explore-gains": Plot(gains.gains_figure, gains.MOVING, gains.gains_key),
        "explore-error": Plot(error.error_figure, error.MOVING, error.error_key),
        "explore-stability": Plot(stability_map.small_map, stability_map.SMALL_MOVING, stability_map.small_key),
    },
    tables={NUMBERS: run_numbers},
    report=report,
    sliders=SLIDERS,
)
