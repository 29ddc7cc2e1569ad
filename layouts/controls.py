"""The rules of the controls that the pages share.

The browser sends every control as it stands and the names of those a hand has moved; `resolve` turns that into a
valid experiment and the controls as they should now stand.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from layouts.state import LIMIT_FIELDS, VIEW_FIELDS, Settings, plane_name, read_limits, read_view
from tracker_core import CONVENTIONS, DESIGNS, SCENARIOS, STARTS, Experiment, InputError
from tracker_core.checks import Domain, check_choice
from tracker_core.conventions import GAIN, rewrite
from tracker_core.design import MANUAL
from tracker_core.experiment import BESIDE, DEFAULTS, PARAMETERS, read_experiment
from tracker_core.fields import FIELDS
from tracker_core.optimal import index_of_noise_gain, path_index, path_share
from tracker_core.papers import papers
from tracker_core.poles import gains_from_poles, move_pole
from tracker_core.region import PLANES
from tracker_core.responses import noise_gain
from tracker_core.types import GAIN_NAMES, ORDERS, STATE_NAMES

STEADY = "steady-kalman"
TEXT_LIMIT = 200
POLES_LIMIT = 400
SHARE = Domain(0, 1)
_OWN = ("exaggerate", "plane", "background", "input")
"""What of the view has nothing to do with the target."""

_KEPT = (*_OWN, *LIMIT_FIELDS, "preset")
"""What a preset leaves as it is."""

_OF_THE_MOMENT = ("point", "pole")
"""What a hand drags: it sets gains, and has no value of its own afterwards."""

SENSOR_FIELDS = ("samples", "interval", "noise", "noise_std")

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
    experiment, axes = settings.experiment, SCENARIOS[settings.experiment.scenario].axes
    controls: dict[str, Any] = {
        name: rewrite(SPARE_GAINS[name], GAIN_NAMES.index(name), "normalised", experiment.convention)
        if name in GAIN_NAMES
        else SPARE_GAINS[name]
        for name in PARAMETERS
    }
    controls.update(experiment.to_dict())
    controls["noise_std"] = _listed(experiment.noise_std or BESIDE["noise_std"][2])
    controls.update(dict(zip(GAIN_NAMES, experiment.gains().values, strict=False)))
    controls["written"] = experiment.convention
    controls["preset"] = preset_of(experiment)
    controls["axis"] = axes[settings.view.axis]
    controls["quantity"] = STATE_NAMES[settings.view.quantity]
    controls["exaggerate"] = str(settings.view.exaggerate)
    controls["at"] = settings.view.cursor(experiment.samples) + 1
    controls["plane"] = plane_name(settings.view.plane)
    controls["background"] = settings.view.background
    controls["input"] = settings.view.input
    controls.update(dict.fromkeys(LIMIT_FIELDS, "") | settings.limits.given())
    controls["responsiveness"] = responsiveness(experiment)
    return controls


def _listed(numbers: Iterable[float]) -> str:
    """Numbers as they stand in a box."""
    return ", ".join(f"{value:g}" if float(f"{value:g}") == value else repr(value) for value in numbers)


def responsiveness(experiment: Experiment) -> float | None:
    """Where a filter stands on the way from smooth (0) to responsive (1): that of the optimal one as noisy as it.

    None for unstable gains.
    """
    if experiment.design == STEADY and experiment.tracking_index is not None:
        return path_share(experiment.tracking_index)
    gains = experiment.gains()
    gain = float(noise_gain(gains.vector))
    return None if gain != gain else path_share(index_of_noise_gain(gains.order, gain))


def preset_of(experiment: Experiment) -> str:
    """Key of the paper's run that this experiment is, or an empty string."""
    return next((key for key, run in presets().items() if run == experiment), "")


def presets() -> dict[str, Experiment]:
    """Every run of the source documents by key."""
    return {f"{paper.name}/{run.name}": run.experiment for paper in papers().values() for run in paper.runs}


def resolve(controls: Mapping[str, Any], changed: Iterable[str], pin: Mapping[str, Any] | None = None) -> Resolution:
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
        pin: an experiment as plain values, if one is pinned.
    """
    draft = _Draft({str(name): _tame(name, value) for name, value in controls.items()}, list(dict.fromkeys(changed)))
    try:
        draft.apply()
    except InputError as error:
        return Resolution(draft.lasting(), None, (error,), draft.note)
    experiment, errors = read_experiment(draft.experiment_values())
    limits, wrong_limits = read_limits(draft.controls)
    if experiment is None or wrong_limits:
        return Resolution(draft.lasting(), None, (*errors, *wrong_limits), draft.note)
    view_values = {name: draft.controls.get(name) for name in VIEW_FIELDS}
    if draft.new_target:
        view_values = {name: view_values[name] for name in _OWN}
    elif "samples" in draft.changed and "at" not in draft.changed:
        view_values.pop("at")
    view, _ = read_view(view_values, experiment)
    if view.at == experiment.samples // 2:
        view = replace(view, at=None)
    pinned = read_experiment(pin)[0] if pin is not None else None
    settings = Settings(experiment, view, pinned, limits)
    kept = {name: draft.controls[name] for name in PARAMETERS if name in draft.controls}
    after = {**controls_of(settings), **_unused(kept, experiment)}
    chosen = draft.controls.get("preset")
    if presets().get(str(chosen)) == experiment:
        # Two documents report the same run; the one that was chosen stays.
        after["preset"] = chosen
    return Resolution(after, settings, (), draft.note)


def _tame(name: str, value: Any) -> Any:
    """Nothing longer than a field needs."""
    limit = POLES_LIMIT if name == "pole" else TEXT_LIMIT
    if isinstance(value, str):
        return value[:limit].strip()
    return value if isinstance(value, int | float | None) and not isinstance(value, bool) else str(value)[:limit]


def numbers_in(name: str, text: Any, count: int) -> list[float]:
    """So many finite numbers of a text, separated by spaces.

    Raises:
        InputError: naming the control, for anything else.
    """
    parts = str(text).split()
    if len(parts) != count:
        raise InputError(name, f"must be {count} numbers", text)
    return [GAIN.check(name, part) for part in parts]


def _unused(kept: dict[str, Any], experiment: Experiment) -> dict[str, Any]:
    """Sliders that the experiment does not use stay where they were, as far as they hold a number."""
    used = set(GAIN_NAMES[: experiment.order])
    if experiment.design != MANUAL:
        used |= set(DESIGNS[experiment.design].parameters)
    return {name: value for name, value in kept.items() if name not in used and _number(value) is not None}


def _number(value: Any) -> float | None:
    try:
        return GAIN.check("", value)
    except InputError:
        return None


@dataclass(slots=True)
class _Draft:
    """Controls while the rules are applied to them."""

    controls: dict[str, Any]
    changed: list[str]
    notes: list[str] = field(default_factory=list)
    new_target: bool = False

    @property
    def note(self) -> str:
        return " ".join(self.notes)

    def apply(self) -> None:
        """Apply every rule; of a preset, a scenario and what else was moved the later one wins."""
        chosen, preset = self.controls.get("scenario"), presets().get(str(self.controls.get("preset")))
        bulk = [name for name in self.changed if name == "scenario" or (name == "preset" and preset is not None)]
        start = self.changed.index(bulk[-1]) + 1 if bulk else 0
        later = {name: self.controls.get(name) for name in self.changed[start:]}
        if preset is not None and "preset" in bulk:
            self.new_target = preset.scenario != chosen
            self.controls.update(controls_of(Settings(preset)) | {name: self.controls.get(name) for name in _KEPT})
            # The preset has settled everything that was moved before it.
            self.changed = list(later)
        if bulk[-1:] == ["scenario"] and chosen in SCENARIOS:
            self.controls["scenario"] = chosen
            self._take_sensor()
        self.controls.update(later)
        self._follow()

    def lasting(self) -> dict[str, Any]:
        """The controls that keep what they were given."""
        return {name: value for name, value in self.controls.items() if name not in _OF_THE_MOMENT}

    def _follow(self) -> None:
        self._rewrite_gains()
        if str(self.controls.get("order")) not in map(str, ORDERS):
            return
        if "order" in self.changed:
            self._keep_design()
        elif "design" in self.changed:
            self._keep_order()
        self._take_hold()
        self._hand_over()
        self._keep_start()

    @property
    def order(self) -> int:
        """The order; where it cannot be read the highest, so that every gain that was given is looked at."""
        try:
            return int(FIELDS["order"].read("order", self.controls.get("order")))
        except InputError:
            return max(ORDERS)

    def _takes(self) -> tuple[str, ...]:
        design = self.controls.get("design")
        return tuple(DESIGNS[design].parameters) if design in DESIGNS else GAIN_NAMES[: self.order]

    def _take_sensor(self) -> None:
        usual = {**DEFAULTS, **SCENARIOS[self.controls["scenario"]].defaults}
        for name in (*SENSOR_FIELDS, "start"):
            self.controls[name] = usual[name]
        self.controls["noise_std"] = ",".join(map(str, usual["noise_std"]))
        self.new_target = True

    def _rewrite_gains(self) -> None:
        written, wanted = self.controls.get("written"), self.controls.get("convention")
        if written == wanted or written not in CONVENTIONS or wanted not in CONVENTIONS:
            return
        for index, name in enumerate(GAIN_NAMES):
            value = _number(self.controls.get(name))
            if value is not None:
                self.controls[name] = rewrite(value, index, written, wanted)
        self.controls["written"] = wanted

    def _keep_design(self) -> None:
        """After a change of order: the same design, its counterpart of that order, or manual."""
        design = self.controls.get("design")
        if design not in DESIGNS or self.order in DESIGNS[design].formulas:
            return
        counterpart = index_design(self.order)
        if "tracking_index" in DESIGNS[design].parameters and counterpart is not None:
            self.controls["design"] = counterpart
        else:
            self.controls["design"] = MANUAL
        self.notes.append(
            f"{DESIGNS[design].title} has no order {self.order}; "
            f"the design is now {design_title(self.controls['design'])}."
        )

    def _keep_order(self) -> None:
        """After a change of design: an order that it serves."""
        design = self.controls.get("design")
        if design in DESIGNS and self.order not in DESIGNS[design].formulas:
            self.controls["order"] = DESIGNS[design].orders[0]
            self.notes.append(f"{DESIGNS[design].title} is a filter of order {self.controls['order']}.")

    def _take_hold(self) -> None:
        """Gains that a hand has set by dragging; one that was moved by its own slider since stays."""
        for name in [name for name in self.changed if name in (*_OF_THE_MOMENT, "responsiveness")]:
            place = self.changed.index(name)
            moved: Mapping[str, float | str]
            if name == "responsiveness":
                moved = self._on_the_path()
            else:
                moved = self._point() if name == "point" else self._pole()
            moved = {gain: value for gain, value in moved.items() if gain not in self.changed[place + 1 :]}
            self.controls.update(moved)
            earlier = [item for item in self.changed[:place] if item not in moved]
            self.changed = [*earlier, *moved, *self.changed[place + 1 :]]

    def _point(self) -> dict[str, float]:
        """`plane x y`, normalised."""
        planes = {plane_name(plane): plane for plane in PLANES[self.order]}
        name, _, coordinates = str(self.controls.get("point")).partition(" ")
        plane = planes[check_choice("point", name, planes)]
        return self._written(dict(zip(plane, numbers_in("point", coordinates, 2), strict=True)))

    def _pole(self) -> dict[str, float]:
        """`index re im` of the target, then `re im` of every pole as the hand took hold."""
        index, *numbers = numbers_in("pole", self.controls["pole"], 3 + 2 * self.order)
        target, *held = map(complex, numbers[::2], numbers[1::2])
        chosen = int(Domain(0, self.order - 1, whole=True).check("pole", index))
        gains = gains_from_poles(move_pole(held, chosen, target))
        return self._written(dict(zip(GAIN_NAMES, gains.tolist(), strict=False)))

    def _written(self, normalised: dict[str, float]) -> dict[str, float]:
        convention = self.controls.get("convention")
        if convention not in CONVENTIONS:
            return normalised
        return {
            name: rewrite(value, GAIN_NAMES.index(name), "normalised", convention) for name, value in normalised.items()
        }

    def _on_the_path(self) -> dict[str, float | str]:
        share = SHARE.check("responsiveness", self.controls["responsiveness"])
        return {"design": STEADY, "tracking_index": path_index(share)}

    def _hand_over(self) -> None:
        """A control moved by hand, since the design was chosen, that the design does not read changes it."""
        before, note = self.controls.get("design"), ""
        since = self.changed.index("design") + 1 if "design" in self.changed else 0
        for name in [name for name in self.changed[since:] if name in PARAMETERS]:
            if name in self._takes():
                continue
            if name == "xi":
                self.controls["design"] = "fading-memory"
            elif name == "tracking_index":
                design = index_design(self.order)
                if design is None:
                    continue
                self.controls["design"] = design
            elif GAIN_NAMES.index(name) < self.order:
                self.controls["design"] = MANUAL
            else:
                continue
            note = f"You moved {FIELDS[name].symbol}: the design is now {design_title(self.controls['design'])}."
        if self.controls.get("design") != before:
            self.notes.append(note)

    def _keep_start(self) -> None:
        start = self.controls.get("start")
        if start in STARTS and self.order < STARTS[start].least_order:
            self.controls["start"] = "two-point"
            self.notes.append(
                f"{STARTS[start].title} needs order {STARTS[start].least_order}: starting with two points."
            )

    def experiment_values(self) -> dict[str, Any]:
        """The fields that the present design reads, none of the others."""
        read = {name for name in FIELDS if name not in PARAMETERS} | set(self._takes())
        return {
            name: ("" if self.controls.get(name) is None else self.controls[name])
            for name in FIELDS
            if name in read and name in self.controls
        }


def index_design(order: int) -> str | None:
    """The design from a tracking index for an order, None where there is none."""
    return {2: "kalata", 3: "gray-murray", 4: STEADY}.get(order)


def design_title(name: str) -> str:
    """Title of a design for sentences and menus."""
    return DESIGNS[name].title if name in DESIGNS else "Manual"
