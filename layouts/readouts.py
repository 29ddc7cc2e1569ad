"""What every page says of a run: verdict, formula, menus, the way back into the stable region, link."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from layouts.state import Settings, plane_name, to_query
from layouts.text import significant
from tracker_core import DESIGNS, SCENARIOS, STARTS, Experiment, Gains, InputError, Result
from tracker_core.design import MANUAL
from tracker_core.experiment import PARAMETERS
from tracker_core.fields import FIELDS
from tracker_core.noise import NOISES
from tracker_core.optimal import distance_from_optimal
from tracker_core.region import PLANES, nearest_stable
from tracker_core.types import GAIN_NAMES, STATE_NAMES

NEARLY = 0.999
LEAST_DISTANCE = 0.01
"""A distance from the optimum of fewer percent is none."""


def common_report(result: Result, settings: Settings, *, live: bool) -> dict[str, Any]:
    """The part of an answer that is the same on every page.

    Args:
        result: the run.
        settings: what it follows from.
        live: whether a slider is moving; what takes long is left for when it rests.
    """
    experiment = settings.experiment
    tone, status = status_text(result)
    cursor = settings.view.cursor(experiment.samples)
    return {
        "tone": tone,
        "pinned": settings.pin is not None,
        "gains": list(result.gains.values),
        "experiment": experiment.to_dict(),
        "link": to_query(settings),
        "owned": owned(experiment),
        "offers": offers(experiment),
        "samples": experiment.samples,
        "offer": None if live or result.verdict.stable else way_back(result.gains),
        "texts": {
            "status": status,
            "formula": formula_text(experiment),
            "distance": distance_text(result),
            "description": f"{result.scenario.description} {result.scenario.source}.",
            "slice": slice_text(result.gains, settings.view.plane),
            "at-text": f"{cursor + 1:,} of {experiment.samples:,}, {significant(float(result.truth.times[cursor]))} s",
        },
    }


def status_text(result: Result) -> tuple[str, str]:
    """The tone of the verdict, "good" or "bad", and the verdict in a sentence."""
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


@lru_cache(maxsize=256)
def way_back(gains: Gains) -> dict[str, Any]:
    """The nearest stable gains: what a button says, and the controls that it sets."""
    nearest = nearest_stable(gains)
    names = GAIN_NAMES[: gains.order]
    said = ", ".join(
        f"{FIELDS[name].symbol} {significant(value, 3)}" for name, value in zip(names, nearest.values, strict=True)
    )
    return {
        "text": f"Take the nearest stable gains: {said}",
        "controls": {"design": MANUAL, **dict(zip(names, nearest.values, strict=True))},
    }


def distance_text(result: Result) -> str:
    """How far the gains are from the best ones, for under the smooth-responsive knob."""
    if not result.verdict.stable:
        return ""
    try:
        distance = distance_from_optimal(result.gains)
    except InputError:
        # Stable by less than rounding.
        return ""
    if distance.percent < LEAST_DISTANCE:
        return "optimal"
    return f"{significant(distance.percent, 3)} % more error variance than optimal"


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
        "plane": [plane_name(plane) for plane in PLANES[experiment.order]],
    }


def slice_text(gains: Gains, plane: tuple[str, str]) -> str:
    """Which slice of the stable region is shown."""
    values = dict(zip(GAIN_NAMES, gains.to("normalised").values, strict=False))
    fixed = [f"{FIELDS[name].symbol} = {significant(values[name], 3)}" for name in values if name not in plane]
    return f"slice at {', '.join(fixed)}" if fixed else "triangle"
