"""How good a run is, in cards: the figures that pages show above their plots."""

from __future__ import annotations

from dash import html
from dash.development.base_component import Component

from layouts.filter_card import metric_cards, metrics_card
from layouts.pinned import errors_of, evidence_of, last_pinned
from layouts.state import Settings
from layouts.text import change_text, metric_text
from tracker_core import METRICS, Result
from tracker_core.innovations import EVIDENCE

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

EVIDENCE_CARDS = {name: metric.title for name, metric in EVIDENCE.items()}

UNDIRECTED = ("nis", "smoothness", "rejected")
"""Figures of which less is not better: as much as the model says, as the target moves, as there are outliers."""

WITHOUT_TRUTH = (
    "Nobody knows where this target really was: errors, noise reduction and lag need a truth. "
    "This is what the measurements themselves say of the filter."
)


def run_card(page: str) -> Component:
    """The figures of a run: its errors, or where nobody knows the truth what its innovations say."""
    instead = html.Div(
        [html.P(WITHOUT_TRUTH), html.Div(metric_cards(EVIDENCE_CARDS, EVIDENCE), className="metrics")],
        className="without-truth field-without-truth",
        hidden=True,
    )
    return metrics_card(page, CARDS, METRICS, instead)


def cards(result: Result, settings: Settings) -> dict[str, list[str]]:
    """Per metric its value, its change since the last pin, and the tone of the change."""
    known = result.truth.known
    names, metrics = (CARDS, METRICS) if known else (EVIDENCE_CARDS, EVIDENCE)
    if result.track.stopped_at is not None:
        # Sums up to an arbitrary stop compare with nothing.
        return {name: ["–", "", ""] for name in names}
    values = result.metrics.to_dict() if known else result.evidence().to_dict()
    pin = last_pinned(settings)
    pinned = None if pin is None else errors_of(pin) if known else evidence_of(pin)
    shown = {}
    for name in names:
        change, tone = change_text(metrics[name], values[name], pinned[name]) if pinned else ("", "")
        tone = "same" if name in UNDIRECTED else tone
        shown[name] = [metric_text(metrics[name], values[name]), change, tone]
    return shown
