"""What the Explore page shows after a change of its controls."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Any

from dash import Patch, no_update
from dash.development.base_component import Component

from layouts.components import table
from layouts.controls import Resolution, resolve
from layouts.figures import error, stability_map, track
from layouts.figures.common import Figure, Path, coordinates, moving, moving_traces
from layouts.state import Settings, to_query
from layouts.text import change_text, error_text, metric_text, significant
from layouts.theme import THEMES
from tracker_core import DESIGNS, METRICS, SCENARIOS, STARTS, Experiment, Metrics, Result, run_experiment
from tracker_core.design import MANUAL
from tracker_core.experiment import PARAMETERS
from tracker_core.exports import track_columns
from tracker_core.fields import FIELDS
from tracker_core.noise import NOISES
from tracker_core.types import GAIN_NAMES, STATE_NAMES, FloatArray

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
PLOTS: dict[str, tuple[Path, ...]] = {
    "explore-path": track.PATH_MOVING,
    "explore-close-up": track.CLOSE_UP_MOVING,
    "explore-time": track.AXIS_MOVING,
    "explore-error": error.MOVING,
    "explore-stability": stability_map.MOVING,
}
NUMBERS = "explore-numbers"
NEARLY = 0.999


@lru_cache(maxsize=64)
def _pinned_metrics(experiment: Experiment) -> Metrics | None:
    """What a pinned experiment is compared by; None if its run was stopped."""
    result = run_experiment(experiment)
    return result.metrics if result.track.stopped_at is None else None


def figures(
    result: Result, settings: Settings, theme: str, meta: dict[str, Any], wanted: Iterable[str]
) -> dict[str, Figure]:
    """The wanted plots of the page by id."""
    view, key = settings.view, target_key(settings.experiment)
    makers: dict[str, Callable[[], Figure]] = {
        "explore-path": lambda: track.path_figure(result, view, theme, key, meta),
        "explore-close-up": lambda: track.close_up_figure(result, view, theme, key, meta),
        "explore-time": lambda: track.axis_figure(result, view, theme, key, meta),
        "explore-error": lambda: error.error_figure(result, view, theme, key, meta),
        "explore-stability": lambda: stability_map.stability_figure(result, theme, meta),
    }
    return {plot: makers[plot]() for plot in wanted}


def target_key(experiment: Experiment) -> str:
    """What must stay the same for a zoom to keep its meaning."""
    return f"{experiment.scenario}|{experiment.samples}|{experiment.interval!r}"


def drawing_keys(settings: Settings, theme: str) -> dict[str, str]:
    """Per plot what must stay the same for its unmoved parts to stay right."""
    e, v = settings.experiment, settings.view
    seen = f"{target_key(e)}|{e.noise}|{e.noise_std}|{e.seed}|{theme}"
    return {
        "explore-path": f"{seen}|{v.exaggerate}",
        "explore-close-up": f"{seen}|{v.exaggerate}|{v.at}",
        "explore-time": f"{seen}|{v.axis}|{v.quantity}",
        "explore-error": seen,
        "explore-stability": theme,
    }


def answer(request: Mapping[str, Any]) -> tuple[list[Any], dict[str, Any]]:
    """What the page shows after a change of its controls.

    Args:
        request: `seq` of the request, `controls` by name, `changed` names, `pin` (an experiment as plain values),
            `drawn` (per plot the key of what it shows now), `want` (plots to update, all if left out) and `theme`.

    Returns:
        One update per plot (a figure; a Patch where only lines have moved; no_update where nothing is wanted or
        something is wrong) and one for the tables, and the rest of the answer.
    """
    theme, resolution = _theme(request), _resolution(request)
    if resolution.settings is None:
        return [no_update] * (len(PLOTS) + 1), _refusal(request, resolution)
    settings = resolution.settings
    result = run_experiment(settings.experiment)
    keys, shown, updates = drawing_keys(settings, theme), request.get("drawn") or {}, list[Any]()
    wanted = [plot for plot in PLOTS if plot in (request.get("want") or PLOTS)]
    drawn = figures(result, settings, theme, _meta(request, result, theme), wanted)
    for plot, paths in PLOTS.items():
        if plot not in drawn:
            updates.append(no_update)
        else:
            same = shown.get(plot) == keys[plot]
            updates.append(_patch(drawn[plot], paths) if same else drawn[plot])
    now = {plot: keys[plot] for plot in drawn}
    updates.append(no_update)
    if NUMBERS in (request.get("want") or ()):
        updates[-1], now[NUMBERS] = numbers(result, settings), ""
    return updates, _report(request, resolution, settings, result) | {"drawn": now}


def live_answer(request: Mapping[str, Any]) -> tuple[dict[str, Any], list[FloatArray]]:
    """What moves on the page while a slider does: the readouts, and the lines of the wanted plots.

    Args:
        request: as for `answer`; a plot in `want` gets its lines only if what it shows fits them.

    Returns:
        The rest of the answer, whose `lines` say per plot which traces follow, and their coordinates: x and y of each,
        32-bit floats.
    """
    theme, resolution = _theme(request), _resolution(request)
    if resolution.settings is None:
        return _refusal(request, resolution), []
    settings = resolution.settings
    result = run_experiment(settings.experiment)
    keys, shown = drawing_keys(settings, theme), request.get("drawn") or {}
    wanted = [plot for plot in PLOTS if plot in (request.get("want") or ()) and shown.get(plot) == keys[plot]]
    drawn = figures(result, settings, theme, _meta(request, result, theme), wanted)
    lines: dict[str, list[list[int]]] = {}
    arrays: list[FloatArray] = []
    for plot, figure in drawn.items():
        lines[plot] = []
        for index in moving_traces(PLOTS[plot]):
            x, y = (coordinates(figure["data"][index][axis]) for axis in ("x", "y"))
            lines[plot].append([index, len(x)])
            arrays += [x, y]
    outdated = [plot for plot in PLOTS if shown.get(plot) != keys[plot]]
    return _report(request, resolution, settings, result) | {"lines": lines, "outdated": outdated}, arrays


def _theme(request: Mapping[str, Any]) -> str:
    theme = str(request.get("theme"))
    return theme if theme in THEMES else THEMES[0]


def _resolution(request: Mapping[str, Any]) -> Resolution:
    return resolve(request["controls"], request.get("changed") or (), request.get("pin"))


def _meta(request: Mapping[str, Any], result: Result, theme: str) -> dict[str, Any]:
    return {
        "seq": request["seq"],
        "gains": list(result.gains.values),
        "stable": result.verdict.stable,
        "theme": theme,
    }


def _patch(figure: Figure, paths: tuple[Path, ...]) -> Patch:
    patch = Patch()
    for path, value in moving(figure, paths):
        part = patch
        for step in path[:-1]:
            part = part[step]
        part[path[-1]] = value
    return patch


def _refusal(request: Mapping[str, Any], resolution: Resolution) -> dict[str, Any]:
    """The last good plot stays; the messages stand beside their fields."""
    return {
        "seq": request["seq"],
        "ok": False,
        "controls": resolution.controls,
        "errors": {wrong.field: error_text(wrong) for wrong in resolution.errors},
        "note": resolution.note,
    }


def _report(request: Mapping[str, Any], resolution: Resolution, settings: Settings, result: Result) -> dict[str, Any]:
    experiment, metrics = settings.experiment, result.metrics.to_dict()
    pinned = _pinned_metrics(settings.pin) if settings.pin else None
    tone, status = status_text(result)
    cards = {}
    for name in CARDS:
        change, change_tone = change_text(name, metrics[name], getattr(pinned, name)) if pinned else ("", "")
        cards[name] = [metric_text(name, metrics[name]), change, change_tone]
    if result.track.stopped_at is not None:
        # Sums up to an arbitrary stop compare with nothing.
        cards = {name: ["–", "", ""] for name in CARDS}
    cursor = settings.view.cursor(experiment.samples)
    return {
        "seq": request["seq"],
        "ok": True,
        "controls": resolution.controls,
        "errors": {},
        "note": resolution.note,
        "status": status,
        "tone": tone,
        "cards": cards,
        "pinned": settings.pin is not None,
        "gains": list(result.gains.values),
        "experiment": experiment.to_dict(),
        "link": to_query(settings),
        "formula": formula_text(experiment),
        "description": f"{result.scenario.description} {result.scenario.source}.",
        "owned": owned(experiment),
        "offers": offers(experiment),
        "slice": slice_text(result),
        "scale": "" if settings.view.exaggerate == 1 else f"deviations × {settings.view.exaggerate}",
        "cursor": f"{cursor + 1:,} of {experiment.samples:,}, {significant(float(result.truth.times[cursor]))} s",
        "samples": experiment.samples,
    }


def numbers(result: Result, settings: Settings) -> list[Component]:
    """The tables: every metric jointly and per axis, and the samples around the one looked at."""
    axes, several = result.scenario.axes, len(result.scenario.axes) > 1
    columns = [result.metrics.to_dict(), *(metrics.to_dict() for metrics in result.axis_metrics() if several)]
    metric_rows = [
        [f"{metric.title}" + (f" ({metric.unit})" if metric.unit else "")]
        + ["–" if column[name] is None else significant(float(column[name] or 0), 6) for column in columns]
        for name, metric in METRICS.items()
    ]
    rows = track.close_up_rows(len(result.truth.times), settings.view.cursor(len(result.truth.times)))
    cells = {
        name: values[rows]
        for name, values in track_columns(result).items()
        if not any(state in name for state in STATE_NAMES[1:])
    }
    head = [name.replace("_", " ") for name in cells]
    sample_rows = [
        [f"{int(row[0]):,}", *(significant(value, 7) for value in row[1:])]
        for row in zip(*(values.tolist() for values in cells.values()), strict=True)
    ]
    return [
        table("Metrics", ["", "joint", *(axes if several else ())], metric_rows),
        table("Samples of the close-up (m, s)", head, sample_rows),
    ]


def status_text(result: Result) -> tuple[str, str]:
    """The verdict in a sentence, and its tone: "good" or "bad"."""
    verdict, stop, radius = result.verdict, result.track.stopped_at, result.verdict.spectral_radius
    if verdict.stable:
        text = f"Stable: the largest pole has magnitude {significant(radius, 3)}."
        if radius >= NEARLY:
            # Equal poles are known to a ten-thousandth at best: no more digits than that.
            text = "Stable, barely: the largest pole is within 0.001 of the unit circle."
        return ("good", text) if stop is None else ("bad", f"{text} {_stop_text(result)}")
    failed = ", ".join(f"{c.text} fails by {significant(-c.margin, 3)}" for c in verdict.conditions if not c.holds)
    text = f"Unstable: {failed} (normalised gains)."
    return "bad", f"{text} {_stop_text(result)}" if stop is not None else text


def _stop_text(result: Result) -> str:
    stop = result.track.stopped_at
    return (
        "" if stop is None else f"The run stopped at sample {stop + 1:,}: a position passed {result.track.limit:.0e} m."
    )


def formula_text(experiment: Experiment) -> str:
    """The formula of the design, for under its menu."""
    if experiment.design == MANUAL:
        return "The gains are set by hand."
    design = DESIGNS[experiment.design]
    return " ".join(part for part in (f"{design.formula[experiment.order]}.", design.remark) if part)


def owned(experiment: Experiment) -> dict[str, str]:
    """How each slider stands to the design: "free", "computed" or "unused"."""
    free = (
        GAIN_NAMES[: experiment.order] if experiment.design == MANUAL else tuple(DESIGNS[experiment.design].parameters)
    )
    computed = set(GAIN_NAMES[: experiment.order]) - set(free)
    return {name: "free" if name in free else "computed" if name in computed else "unused" for name in PARAMETERS}


def offers(experiment: Experiment) -> dict[str, list[str]]:
    """Per menu the choices that make sense now."""
    scenario = SCENARIOS[experiment.scenario]
    return {
        "axis": list(scenario.axes),
        "quantity": list(STATE_NAMES[: experiment.order]),
        "noise": [name for name in NOISES if name != "recorded" or scenario.recording],
        "start": [start.name for start in STARTS.values() if experiment.order >= start.least_order],
    }


def slice_text(result: Result) -> str:
    """Which slice of the stable region is shown."""
    values = dict(zip(GAIN_NAMES, result.gains.values, strict=False))
    fixed = [f"{FIELDS[name].symbol} = {significant(values[name], 3)}" for name in ("gamma", "eta") if name in values]
    return f"slice at {', '.join(fixed)}" if fixed else "triangle"
