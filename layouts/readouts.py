"""What every page says of a run: verdict, formula, menus, the way back into the stable region, link."""

from __future__ import annotations

from functools import lru_cache
from math import inf, log10
from typing import Any

from layouts.state import Settings, inputs_of, plane_name, to_query
from layouts.text import error_text, file_stem, significant
from tracker_core import DESIGNS, STARTS, Experiment, Gains, InputError, Result
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.conventions import rewrite
from tracker_core.design import MANUAL
from tracker_core.experiment import BESIDE, PARAMETERS
from tracker_core.fields import FIELDS
from tracker_core.manoeuvre import MANOEUVRES
from tracker_core.noise import NOISES, signal_to_noise
from tracker_core.optimal import distance_from_optimal
from tracker_core.region import PLANES, nearest_stable
from tracker_core.types import GAIN_NAMES, STATE_NAMES

NEARLY = 0.999
MANY_REFUSED = 0.1
"""A gate that refuses a greater share of the samples refuses right ones."""

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
    cursor = settings.view.cursor(experiment.samples)
    tone, status = status_text(result, settings)
    return {
        "tone": tone,
        "pins": [[pin.slot, pin.text()] for pin in settings.pins],
        "gains": list(result.gains.values),
        "link": to_query(settings),
        "stem": file_stem(result.scenario.title),
        "owned": owned(experiment),
        "offers": offers(experiment),
        "fields": fields_shown(experiment),
        "method": experiment.design if experiment.method is not None else "",
        "samples": experiment.samples,
        "offer": None if live or result.verdict.stable else way_back(result.gains),
        "texts": {
            "status": status,
            "since": since_text(settings),
            "formula": formula_text(experiment),
            "oracle": f"Oracle. {experiment.hindsight}" if experiment.hindsight else "",
            "found": found_text(result),
            "level": level_text(result),
            "manoeuvre_std-unit": push_unit(experiment),
            "distance": distance_text(result),
            "description": f"{result.scenario.description} {result.scenario.source}.",
            "slice": slice_text(result.gains, settings.view.plane),
            "at-text": f"of {experiment.samples:,}, {significant(float(result.truth.times[cursor]))} s",
        },
    }


def since_text(settings: Settings) -> str:
    """Since which pin figures have changed, or why that cannot be said."""
    if not settings.pins:
        return ""
    pin = settings.pins[-1]
    try:
        pin.on(settings.experiment)
    except InputError as error:
        return f"{pin.name}: {error_text(error)}"
    return f"since {pin.name}"


def status_text(result: Result, settings: Settings) -> tuple[str, str]:
    """The tone of the verdict, "good" or "bad", and the verdict in a sentence."""
    tone, text = _verdict_text(result)
    if result.selection is not None:
        view = settings.view
        where = f"{result.scenario.axes[view.axis]}, sample {view.cursor(result.experiment.samples) + 1:,}"
        share = result.unstable_share()
        text = f"Gains at {where}: {text[0].lower()}{text[1:]}"
        if share:
            text += f" {significant(100 * share, 2)} % of all corrections use gains that would be unstable if held."
    refused = 0.0 if result.track.rejected is None else float(result.track.rejected.mean())
    if refused > MANY_REFUSED:
        tone = "bad"
        text += (
            f" The gate refuses {significant(100 * refused, 2)} % of the samples: it is too narrow, σ too small, "
            "or the filter too slow for this target."
        )
    if result.measurements.interval is None:
        text += " That is so at a constant interval; here it varies."
    return (tone, text) if result.track.stopped_at is None else ("bad", f"{text} {_stop_text(result)}")


def _verdict_text(result: Result) -> tuple[str, str]:
    verdict, radius = result.verdict, result.verdict.spectral_radius
    if not verdict.stable:
        failed = ", ".join(f"{c.text} fails by {significant(-c.margin, 3)}" for c in verdict.conditions if not c.holds)
        return "bad", f"Unstable: {failed} (normalised gains)."
    if radius >= NEARLY:
        # With three digits it would look like 1.
        return "good", "Stable, barely: the largest pole is within 0.001 of the unit circle."
    return "good", f"Stable: the largest pole has magnitude {significant(radius, 3)}."


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
    if experiment.method is not None:
        return experiment.method.sentence
    design = DESIGNS[experiment.design]
    return " ".join(part for part in (f"{design.formula[experiment.order]}.", design.remark) if part)


def found_text(result: Result) -> str:
    """What a method has searched over the whole run, per axis; gains in the convention of the run."""
    if result.selection is None:
        return ""
    parts, convention = [], result.experiment.convention
    for name, found in result.selection.found.items():
        index = GAIN_NAMES.index(name) if name in GAIN_NAMES else None
        values = found if index is None else [rewrite(gain, index, "normalised", convention) for gain in found]
        said = ", ".join(
            f"{significant(value, 3)} in {axis}" if len(values) > 1 else significant(value, 3)
            for axis, value in zip(result.scenario.axes, values, strict=False)
        )
        parts.append(f"{FIELDS[name].symbol} = {said}")
    return f"Found: {'; '.join(parts)}." if parts else ""


def level_text(result: Result) -> str:
    """The level of the noise in its other reading."""
    experiment, axes = result.experiment, result.scenario.axes
    if experiment.noise in ("none", "recorded"):
        return ""
    if experiment.noise_std is None:
        return "σ " + ", ".join(
            f"{significant(std, 3)} m in {axis}" for axis, std in zip(axes, result.noise_std, strict=True)
        )
    ratios = signal_to_noise(result.truth.positions, result.noise_std)
    said = [
        f"{significant(10 * log10(ratio), 3)} dB in {axis}"
        for axis, ratio in zip(axes, ratios, strict=True)
        if 0 < ratio < inf
    ]
    return f"SNR {', '.join(said)}" if said else ""


def push_unit(experiment: Experiment) -> str:
    """The unit of the pushes, as it stands behind what they are called."""
    unit = MANOEUVRES[experiment.manoeuvre].unit
    return f" ({unit})" if unit else ""


def fields_shown(experiment: Experiment) -> dict[str, bool]:
    """Of the fields that do not always mean something whether they do now."""
    takes = set() if experiment.method is None else set(experiment.method.parameters)
    if experiment.order < 4:
        takes.discard("grid_eta")
    shown = {name: name in takes for name in METHOD_PARAMETERS}
    shown |= {name: getattr(experiment, other) in values for name, (other, values, _) in BESIDE.items()}
    measured, known = experiment.target.measured, bool(experiment.target.known_states)
    # Nothing is drawn where everything was measured.
    shown |= dict.fromkeys(("interval", "noise", "noise_level", "seed"), not measured)
    # Nobody pushed the target that measurements were recorded of.
    shown["manoeuvre"] = experiment.noise != "recorded"
    shown |= {"gate": experiment.method is None, "exaggerate": known, "with-truth": known, "without-truth": not known}
    return shown | {"beside": bool(experiment.hindsight)}


def owned(experiment: Experiment) -> dict[str, str]:
    """How each slider stands to the design: "free", "computed" or "unused"."""
    if experiment.design == MANUAL:
        free = GAIN_NAMES[: experiment.order]
    else:
        free = () if experiment.method is not None else tuple(DESIGNS[experiment.design].parameters)
    computed = set(GAIN_NAMES[: experiment.order]) - set(free)
    return {name: "free" if name in free else "computed" if name in computed else "unused" for name in PARAMETERS}


def offers(experiment: Experiment) -> dict[str, list[str]]:
    """Per menu the choices that make sense now."""
    scenario = experiment.target
    return {
        "axis": list(scenario.axes),
        "quantity": list(STATE_NAMES[: experiment.order]),
        "noise": [name for name in NOISES if name != "recorded" or scenario.recording],
        "start": [
            start.name
            for start in STARTS.values()
            if experiment.order >= start.least_order
            and (experiment.method is None or start.name != "expanding")
            and not (scenario.measured and start.name == "known")
        ],
        "plane": [plane_name(plane) for plane in PLANES[experiment.order]],
        "input": list(inputs_of(experiment.order)),
        "objective": list(STATE_NAMES[: min(experiment.order, scenario.known_states)]),
    }


def slice_text(gains: Gains, plane: tuple[str, str]) -> str:
    """Which slice of the stable region is shown."""
    values = dict(zip(GAIN_NAMES, gains.to("normalised").values, strict=False))
    fixed = [f"{FIELDS[name].symbol} = {significant(values[name], 3)}" for name in values if name not in plane]
    return f"slice at {', '.join(fixed)}" if fixed else "triangle"
