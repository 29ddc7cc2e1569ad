"""What the Stability page shows of a run."""

from __future__ import annotations

from typing import Any

import numpy as np
from dash.development.base_component import Component

from layouts.components import table
from layouts.desk import Desk, Plot
from layouts.figures import poles, responses, stability_map, track
from layouts.figures.handles import gains_handle, pole_handles, pole_text
from layouts.filter_card import SLIDERS
from layouts.pages.stability.responses import response_tables
from layouts.pinned import last_pinned, merits_of
from layouts.readouts import LEAST_DISTANCE
from layouts.scenes import RegionPicture
from layouts.shown import Shown
from layouts.state import LIMIT_FIELDS, Settings
from layouts.text import change_text, metric_text, significant
from tracker_core import InputError, Result
from tracker_core.consistency import average, error_squared, model_covariance
from tracker_core.merits import MERITS, merits
from tracker_core.optimal import distance_from_optimal
from tracker_core.poles import damping_class, damping_ratio
from tracker_core.responses import step_figures, variance_reduction
from tracker_core.stability import Condition, printed_conditions
from tracker_core.types import STATE_NAMES

CARDS = {
    "noise_gain": "Noise gain",
    "predicted_noise_gain": "Noise, predicted",
    "unit_lag": "Lag per unit",
    "overshoot": "Overshoot",
    "settling": "Settling time",
    "damping": "Damping ratio",
    "spectral_radius": "Largest pole",
    "optimal_distance": "From optimal",
}
NUMBERS = "stability-numbers"
LIMITED = dict(zip(LIMIT_FIELDS, ("noise_gain", "unit_lag", "overshoot", "settling"), strict=True))
"""The figure of merit that each limit is about."""

SPACE = {
    2: "a filter of order 2 lies on the floor, γ = 0",
    3: "normalised gains",
    4: "of a filter of order 4 its α, β, γ; its own region has four dimensions",
}


def cards(result: Result, settings: Settings) -> dict[str, list[str]]:
    """Per figure of merit its value, its change since the last pin or the limit it exceeds, and the tone of that."""
    figures = merits(result.gains, settings.experiment.interval)
    pin = last_pinned(settings)
    pinned = merits_of(pin) if pin is not None else None
    limits = {LIMITED[name]: limit for name, limit in settings.limits.given().items()}
    shown = {}
    for name in CARDS:
        change, tone = change_text(MERITS[name], figures[name], pinned[name]) if pinned else ("", "")
        value = figures[name]
        if name in limits and value is not None and value > limits[name]:
            change, tone = f"over your {metric_text(MERITS[name], limits[name])}", "worse"
        shown[name] = [metric_text(MERITS[name], value), change, tone]
    distance = figures["optimal_distance"]
    if distance is not None and distance < LEAST_DISTANCE:
        shown["optimal_distance"][0] = "0 %"
    return shown


def report(shown: Shown) -> dict[str, Any]:
    """Cards, what can be dragged, and the tables of the two tests."""
    result, verdict = shown.result, shown.result.verdict
    return {
        "cards": cards(result, shown.settings),
        "handles": {
            "stability-map": gains_handle(result.gains, shown.view.plane),
            "stability-poles": pole_handles(verdict.poles),
        },
        "rows": {
            "conditions": [_condition_row(condition) for condition in verdict.conditions],
            "printed": [_condition_row(condition) for condition in printed_conditions(result.gains)],
            "jury": [_jury_row(condition) for condition in verdict.jury],
        },
        "texts": {
            "damping": damping_class(result.gains) if verdict.stable else "unstable",
            "space": SPACE[result.gains.order],
        },
    }


def picture(shown: Shown) -> RegionPicture:
    """The operating point for the scene of order 3; a filter of order 2 is one of order 3 without gamma."""
    alpha, beta, gamma = (*shown.result.gains.vector.tolist(), 0.0)[:3]
    return RegionPicture((alpha, beta, gamma), shown.result.verdict.stable, shown.theme)


def _condition_row(condition: Condition) -> list[Any]:
    return [condition.text, significant(condition.margin, 4), verdict_cell(condition)]


def _jury_row(condition: Condition) -> list[Any]:
    numbers = "  ".join(significant(number, 4) for number in condition.numbers)
    return [condition.text, numbers, significant(condition.margin, 4), verdict_cell(condition)]


def verdict_cell(condition: Condition) -> list[str]:
    """A cell that says whether a condition holds, with its tone."""
    return ["holds", "good"] if condition.holds else ["fails", "bad"]


def numbers(result: Result, settings: Settings) -> list[Component]:
    """The tables: what follows from the gains, and what they make of the inputs that are drawn."""
    return [*_merit_tables(result, settings), *response_tables(result, settings)]


def _merit_tables(result: Result, settings: Settings) -> list[Component]:
    """Poles, variance of every state, and whether the run looks like the model that suits the gains."""
    interval = settings.experiment.interval
    pole_rows = [
        [pole_text(pole), significant(abs(pole), 5), significant(damping_ratio(pole), 4)]
        for pole in result.verdict.poles
    ]
    tables = [table("Poles", ["", "magnitude", "damping ratio ζ"], pole_rows)]
    if not result.verdict.stable:
        return tables
    try:
        variances = variance_reduction(result.gains, interval)
    except InputError:
        # Stable by less than rounding.
        return tables
    rows = [
        [f"{state} (1{unit})", significant(float(value), 6)]
        for state, unit, value in zip(STATE_NAMES, ("", "/s²", "/s⁴", "/s⁶"), variances.smoothed, strict=False)
    ]
    rows.append(["predicted position (1)", significant(variances.predicted, 6)])
    tables.append(table("Variance per variance of the measurements", ["", "variance"], rows))
    return tables + _consistency(result)


def _consistency(result: Result) -> list[Component]:
    """Whether the innovations and errors of the run are as large as the model that suits the gains says."""
    experiment, evidence = result.experiment, result.evidence()
    nis, settling = evidence.nis, float(step_figures(result.gains.vector)[1])
    if nis is None or result.selection is not None or not settling < experiment.samples:
        return []
    index = distance_from_optimal(result.gains).tracking_index
    rows = [
        ["NIS, innovations", significant(nis.mean), f"{significant(nis.low)} to {significant(nis.high)}",
         "as the model says" if nis.holds else "larger" if nis.mean > nis.high else "smaller"],
    ]  # fmt: skip
    nees = _nees(result, index, int(settling))
    if nees is not None:
        order = experiment.order
        times = f"{significant(nees / order, 3)} times"
        rows.append(["NEES, errors of the state", significant(nees), f"{order} on average", times])
    caption = (
        f"Consistency with the model of tracking index Λ = {significant(index, 3)}, after the start; "
        "the interval allows for the correlation that gains which are not optimal leave in the innovations"
    )
    return [table(caption, ["", "mean", "if the model is right", ""], rows)]


def _nees(result: Result, index: float, settling: int) -> float | None:
    """The mean NEES of the axes after the start; None without a truth, or a steady covariance of the errors."""
    experiment, track = result.experiment, result.track
    if not result.measurements.is_even or (track.rejected is not None and track.rejected.any()):
        return None
    order = experiment.order
    errors = (track.smoothed - result.truth.states[:, :, :order]) * experiment.interval ** np.arange(order)
    covariance = model_covariance(result.gains, index).smoothed
    # What the start has left behind is none of the model's.
    nees = average(error_squared(errors[settling:] / np.array(result.noise_std)[:, None], covariance).ravel(), order)
    # Of a recording nobody knows the true velocity.
    return nees.mean if nees.count else None


DESK = Desk(
    page="stability",
    plots={
        "stability-map": Plot(stability_map.stability_map, stability_map.MOVING, stability_map.map_key, often=True),
        "stability-poles": Plot(poles.pole_figure, poles.MOVING, lambda _: "", often=True),
        "stability-path": Plot(track.path_figure, track.PATH_MOVING, track.path_key, often=True),
        "stability-response": Plot(responses.time_figure, responses.TIME_MOVING, responses.time_key),
        "stability-frequency": Plot(responses.frequency_figure, responses.FREQUENCY_MOVING, responses.frequency_key),
    },
    tables={NUMBERS: numbers},
    report=report,
    sliders=SLIDERS,
    picture=picture,
)
