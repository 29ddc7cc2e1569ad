"""The rules of the controls that the pages share.

The browser sends every control as it stands and the names of those a hand has moved; `resolve` turns that into a
valid experiment and the controls as they should now stand.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from layouts.comparing import comparing_controls, read_comparing
from layouts.pinning import Action
from layouts.pinning import apply as pinning_done
from layouts.pins import read_pins
from layouts.reading import reading_controls
from layouts.rules import OWN_VIEW, STEADY, Draft, number, preset_keys, presets
from layouts.state import LIMIT_FIELDS, SWITCH, VIEW_FIELDS, Settings, View, plane_name, read_limits, read_view
from layouts.tuning import follow, read_tuning, tuning_controls
from tracker_core import Experiment, Gains, InputError, run_experiment
from tracker_core.adaptive import METHODS
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.conventions import rewrite
from tracker_core.experiment import BESIDE, PARAMETERS, read_experiment
from tracker_core.fields import FIELDS
from tracker_core.optimal import index_of_noise_gain, path_share
from tracker_core.recordings import Reading
from tracker_core.responses import smoothed_variance, steady_variance
from tracker_core.types import GAIN_NAMES, STATE_NAMES

SPARE_GAINS: dict[str, float] = {
    "alpha": 0.5,
    "beta": 0.2,
    "gamma": 0.05,
    "eta": 0.005,
    "xi": 0.64,
    "tracking_index": 0.1,
}
"""Where a slider stands that nothing has set yet; gains normalised."""


@dataclass(frozen=True, slots=True)
class Resolution:
    """The outcome of one change of the controls.

    Attributes:
        controls: every control as it should stand now; numbers at full precision, rejected entries as they came.
        settings: what they describe, or None while something is wrong.
        errors: what is wrong.
        note: what the rules changed on their own, in one sentence; may be empty.
    """

    controls: dict[str, Any]
    settings: Settings | None
    errors: tuple[InputError, ...]
    note: str = ""


def controls_of(settings: Settings) -> dict[str, Any]:
    """Every control as it stands for these settings."""
    experiment, axes = settings.experiment, settings.experiment.target.axes
    gains = present_gains(settings)
    controls = {**spare_controls(experiment.convention, experiment.interval), **experiment.to_dict()}
    if experiment.method is not None:
        # What is searched stands empty.
        searched = set(experiment.method.parameters) - set(experiment.parameters())
        controls |= dict.fromkeys(searched, "")
    controls["noise_std"] = _listed(experiment.noise_std or BESIDE["noise_std"][2])
    controls.update(dict(zip(GAIN_NAMES, gains.values, strict=False)))
    if experiment.reading is not None:
        controls |= reading_controls(Reading.from_text(experiment.reading))
    controls["written"] = experiment.convention
    controls["preset"] = preset_of(experiment)
    controls["axis"] = axes[settings.view.axis]
    controls["quantity"] = STATE_NAMES[settings.view.quantity]
    controls["exaggerate"] = str(settings.view.exaggerate)
    controls["at"] = settings.view.cursor(experiment.samples) + 1
    controls["plane"] = plane_name(settings.view.plane)
    controls["background"] = settings.view.background
    controls["input"] = settings.view.input
    controls["beside"] = SWITCH[settings.view.beside]
    controls |= comparing_controls(settings.view.comparing)
    controls |= tuning_controls(settings.view.tuning, experiment)
    controls.update(dict.fromkeys(LIMIT_FIELDS, "") | settings.limits.given())
    controls["responsiveness"] = responsiveness(experiment, gains)
    return controls


@lru_cache(maxsize=64)
def spare_controls(convention: str, interval: float) -> Mapping[str, Any]:
    """Where controls stand that no experiment in this convention and at this interval has set."""
    gains = {name: rewrite(SPARE_GAINS[name], index, "normalised", convention) for index, name in enumerate(GAIN_NAMES)}
    beside = {name: "" if default is None else default for name, (_, _, default) in BESIDE.items()}
    parameters = {name: spare_parameter(name, interval) for name in METHOD_PARAMETERS}
    return MappingProxyType({**SPARE_GAINS, **gains, **beside, "gate": "", **parameters})


def spare_parameter(name: str, interval: float) -> Any:
    """Where a parameter stands that no method uses: its default at this interval; empty where it is searched."""
    default = next(method.parameters[name] for method in METHODS.values() if name in method.parameters)
    value = default(interval) if callable(default) else default
    return "" if value is None else value


def present_gains(settings: Settings) -> Gains:
    """The gains that the sliders show: constant ones, or those of the sample and the axis looked at."""
    experiment, view = settings.experiment, settings.view
    if experiment.method is None:
        return experiment.gains()
    return run_experiment(experiment).at(view.cursor(experiment.samples), view.axis).gains


def _listed(numbers: Iterable[float]) -> str:
    """Numbers as they stand in a box."""
    return ", ".join(f"{value:g}" if float(f"{value:g}") == value else repr(value) for value in numbers)


def responsiveness(experiment: Experiment, gains: Gains) -> float | None:
    """Where a filter stands on the way from smooth (0) to responsive (1): that of the optimal one as noisy as it.

    None for unstable gains.
    """
    if experiment.design == STEADY and experiment.tracking_index is not None:
        return path_share(experiment.tracking_index)
    try:
        noise = steady_variance(gains, smoothed_variance)
    except InputError:
        return None
    return path_share(index_of_noise_gain(gains.order, noise))


def preset_of(experiment: Experiment) -> str:
    """Key of the paper's run that this experiment is, or an empty string."""
    return preset_keys().get(experiment, "")


def resolve(
    controls: Mapping[str, Any],
    changed: Iterable[str],
    pins: Iterable[tuple[int, str]] = (),
    pinning: Iterable[Action] = (),
) -> Resolution:
    """Apply the rules of the page to a change of its controls.

    A design owns the gains it computes: moving one of them by hand makes the design manual; moving xi or the tracking
    index in a design without it chooses one that has it. Changing the order keeps the design where it serves that
    order. Changing the convention rewrites the gains. A scenario brings its own sensor settings, a preset everything.

    A point dragged in a plane of two gains (`point`) and a pole dragged in
    the z-plane (`pole`) set the gains; the smooth-responsive knob chooses the optimal filter there.

    Args:
        controls: every control by name, as `controls_of` gave them or as the user left them.
        changed: names of the controls that were moved since the last call, in the order of the hand: what came after
            a preset or a scenario stands.
        pins: the pinned filters, pairs of slot and text.
        pinning: what is done with them once everything else is done: see `layouts.pinning`.
    """
    moved = list(dict.fromkeys(changed))
    draft = Draft(
        {name: value.strip() if isinstance(value, str) else value for name, value in controls.items()},
        list(moved),
        lambda experiment: controls_of(Settings(experiment)),
    )
    pinning = list(pinning)
    try:
        draft.apply()
    except InputError as error:
        return _refused(draft, [error.kept()], pinning)
    experiment, errors = read_experiment(draft.experiment_values())
    if experiment is not None:
        follow(draft.controls, moved)
    limits, wrong_limits = read_limits(draft.controls)
    wrong = [*wrong_limits, *read_comparing(draft.controls)[1], *read_tuning(draft.controls)[1]]
    if experiment is None or wrong:
        return _refused(draft, [*errors, *wrong], pinning)
    view_values = {name: draft.controls.get(name) for name in VIEW_FIELDS}
    if draft.new_target:
        view_values = {name: view_values[name] for name in OWN_VIEW}
    elif "samples" in draft.changed:
        # A sample that was chosen meanwhile stays if there is one.
        view_values["at"] = view_values["at"] if "at" in draft.changed else None
    elif "at" in draft.changed and (wrong := _wrong_sample(view_values["at"], experiment)):
        return _refused(draft, wrong, pinning)
    view = _view(view_values, experiment)
    settings, said = pinning_done(Settings(experiment, view, read_pins(pins), limits), pinning)
    if settings.experiment != experiment:
        experiment = settings.experiment
        settings = replace(settings, view=_view(view_values, experiment))
    kept = {name: draft.controls[name] for name in (*PARAMETERS, *METHOD_PARAMETERS, *BESIDE) if name in draft.controls}
    after = {**controls_of(settings), **_unused(kept, experiment)}
    chosen = draft.controls.get("preset")
    if presets().get(str(chosen)) == experiment:
        # Two documents report the same run; the one that was chosen stays.
        after["preset"] = chosen
    return Resolution(after, settings, (), " ".join(filter(None, (draft.note, said))))


def _refused(draft: Draft, errors: Iterable[InputError], pinning: Collection[Action]) -> Resolution:
    if pinning:
        draft.notes.append("The pins stay as they are while an entry is wrong.")
    return Resolution(draft.lasting(), None, tuple(errors), draft.note)


def _wrong_sample(value: Any, experiment: Experiment) -> list[InputError]:
    """Why there is no such sample; nothing where there is, or an empty box means the middle one."""
    return read_view({"at": value}, experiment)[1]


def _view(values: Mapping[str, Any], experiment: Experiment) -> View:
    view, _ = read_view(values, experiment)
    return replace(view, at=None) if view.at == experiment.samples // 2 else view


def _unused(kept: dict[str, Any], experiment: Experiment) -> dict[str, Any]:
    """Controls that the experiment does not use stay where they were, as far as what they hold is admitted."""
    used = {*GAIN_NAMES[: experiment.order], *experiment.to_dict()}
    if experiment.method is not None:
        used |= set(experiment.method.parameters)
    # What depends on the interval is not kept for another one.
    used |= {name for method in METHODS.values() for name, default in method.parameters.items() if callable(default)}
    return {name: value for name, value in kept.items() if name not in used and _admitted(name, value)}


@lru_cache(maxsize=1024)
def _admitted(name: str, value: str | float | None) -> bool:
    # Of all controls one or two have moved since this was last asked.
    if name in PARAMETERS:
        return number(value) is not None
    try:
        FIELDS[name].read(name, value)
    except InputError:
        return False
    return True
