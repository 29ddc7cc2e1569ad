"""How good a run is, in cards: the figures that pages show above their plots."""

from __future__ import annotations

from layouts.pinned import last_pinned, metrics_of
from layouts.state import Settings
from layouts.text import change_text, metric_text
from tracker_core import METRICS, Result

CARDS = {
    "tracking_total": "Tracking error",
    "estimation_total": "Estimation error",
    "tracking_rmse": "Tracking RMSE",
    "estimation_rmse": "Estimation RMSE",
    "estimation_max": "Greatest error",
    "estimation_l2": "L2",
    "noise_reduction": "Noise reduction",
    "lag": "Steady lag",
}


def cards(result: Result, settings: Settings) -> dict[str, list[str]]:
    """Per metric its value, its change since the last pin, and the tone of the change."""
    if result.track.stopped_at is not None:
        # Sums up to an arbitrary stop compare with nothing.
        return {name: ["–", "", ""] for name in CARDS}
    metrics = result.metrics.to_dict()
    pin = last_pinned(settings)
    pinned = metrics_of(pin) if pin is not None else None
    shown = {}
    for name in CARDS:
        change, tone = change_text(METRICS[name], metrics[name], getattr(pinned, name)) if pinned else ("", "")
        shown[name] = [metric_text(METRICS[name], metrics[name]), change, tone]
    return shown
