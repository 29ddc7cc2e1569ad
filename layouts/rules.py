"""The rules by which a change of one control changes others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType
from typing import Any

from layouts.comparing import COMPARING_FIELDS
from layouts.fitting import fit, target_said, value_of
from layouts.reading import follow_reading
from layouts.state import LIMIT_FIELDS, plane_name
from layouts.tuning import TUNING_FIELDS
from tracker_core import CONVENTIONS, DESIGNS, SCENARIOS, STARTS, Experiment, InputError
from tracker_core.adaptive import METHODS
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.checks import Domain, check_choice
from tracker_core.conventions import GAIN, rewrite
from tracker_core.design import MANUAL
from tracker_core.experiment import BESIDE, DEFAULTS, PARAMETERS, orders_of
from tracker_core.fields import FIELDS
from tracker_core.measured import RECORDING
from tracker_core.optimal import path_index
from tracker_core.papers import papers
from tracker_core.poles import gains_from_poles, move_pole
from tracker_core.region import PLANES
from tracker_core.types import GAIN_NAMES, ORDERS

STEADY = "steady-kalman"
SHARE = Domain(0, 1)
OF_THE_MOMENT = ("point", "pole")
"""What a hand drags: it sets gains, and has no value of its own afterwards."""

OWN_VIEW = ("exaggerate", "plane", "background", "input", "beside", *COMPARING_FIELDS, *TUNING_FIELDS)
"""What of the view has nothing to do with the target."""

KEPT = (*OWN_VIEW, *LIMIT_FIELDS, "preset")
"""What a preset leaves as it is."""

TARGET = ("scenario", "data", "reading")
"""What says which target it is."""

SENSOR_FIELDS = ("samples", "interval", "noise", "noise_level", "noise_std", "manoeuvre")


@dataclass(slots=True)
class Draft:
    """Controls while the rules are applied to them.

    Attributes:
        controls: every control by name; changed by the rules.
        changed: names of those that a hand has moved, in its order.
        standing: from an experiment to every control as it stands for it.
        notes: what the rules have changed on their own, in sentences.
        new_target: whether the target is another one now.
    """

    controls: dict[str, Any]
    changed: list[str]
    standing: Callable[[Experiment], dict[str, Any]]
    notes: list[str] = field(default_factory=list)
    new_target: bool = False

    @property
    def note(self) -> str:
        """What the rules have changed, in sentences."""
        return " ".join(self.notes)

    def apply(self) -> None:
        """Apply every rule; of a preset, a scenario and what else was moved the later one wins."""
        self.changed = follow_reading(self.controls, self.changed)
        chosen, preset = self.controls.get("scenario"), presets().get(str(self.controls.get("preset")))
        bulk = [name for name in self.changed if name in TARGET or (name == "preset" and preset is not None)]
        start = self.changed.index(bulk[-1]) + 1 if bulk else 0
        later = {name: self.controls.get(name) for name in self.changed[start:]}
        if preset is not None and "preset" in bulk:
            self.new_target = preset.scenario != chosen
            self.controls.update(self.standing(preset) | {name: self.controls.get(name) for name in KEPT})
            # The preset has settled everything that was moved before it.
            self.changed = list(later)
        if bulk and bulk[-1] in TARGET:
            # Another file, or the same one read in another way, is meant to be looked at.
            self.controls["scenario"] = chosen if bulk[-1] == "scenario" else RECORDING
            if "data" in self.changed and "reading" not in self.changed:
                self.controls["reading"] = ""
            if self.controls["scenario"] in (*SCENARIOS, RECORDING):
                self._take_sensor()
        self.controls.update(later)
        self._follow()

    def lasting(self) -> dict[str, Any]:
        """The controls that keep what they were given."""
        return {name: value for name, value in self.controls.items() if name not in OF_THE_MOMENT}

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
        self._keep_gate()
        self._keep_manoeuvre()
        self.notes += fit(self.controls, self.changed, self.order)

    @property
    def order(self) -> int:
        """The order; where it cannot be read the highest, so that every gain that was given is looked at."""
        return int(value_of(self.controls, "order") or max(ORDERS))

    def _takes(self) -> tuple[str, ...]:
        design = self.controls.get("design")
        if design in DESIGNS:
            return tuple(DESIGNS[design].parameters)
        return tuple(METHODS[design].parameters) if design in METHODS else GAIN_NAMES[: self.order]

    def _take_sensor(self) -> None:
        usual = {**DEFAULTS, **target_said(self.controls).defaults}
        for name in (*SENSOR_FIELDS, "start"):
            self.controls[name] = usual[name]
        self.controls["noise_std"] = ",".join(map(str, usual["noise_std"]))
        self.new_target = True

    def _rewrite_gains(self) -> None:
        written, wanted = self.controls.get("written"), self.controls.get("convention")
        if written == wanted or written not in CONVENTIONS or wanted not in CONVENTIONS:
            return
        for index, name in enumerate(GAIN_NAMES):
            value = number(self.controls.get(name))
            if value is not None:
                self.controls[name] = rewrite(value, index, written, wanted)
        self.controls["written"] = wanted

    def _keep_design(self) -> None:
        """After a change of order: the same design, its counterpart of that order, or manual."""
        design = str(self.controls.get("design"))
        if self.order in orders_of(design):
            return
        counterpart = index_design(self.order)
        if design in DESIGNS and "tracking_index" in DESIGNS[design].parameters and counterpart is not None:
            self.controls["design"] = counterpart
        else:
            self.controls["design"] = MANUAL
        self.notes.append(
            f"{design_title(design)} has no order {self.order}; "
            f"the design is now {design_title(self.controls['design'])}."
        )

    def _keep_order(self) -> None:
        """After a change of design: an order that it serves."""
        design = str(self.controls.get("design"))
        if self.order not in orders_of(design):
            self.controls["order"] = orders_of(design)[0]
            self.notes.append(f"{design_title(design)} is a filter of order {self.controls['order']}.")

    def _take_hold(self) -> None:
        """Gains that a hand has set by dragging; one that was moved by its own slider since stays."""
        for name in [name for name in self.changed if name in (*OF_THE_MOMENT, "responsiveness")]:
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
        elif start == "expanding" and self.controls.get("design") in METHODS.keys() - DESIGNS.keys():
            self.controls["start"] = "two-point"
            self.notes.append("Expanding memory is such a method itself: starting with two points.")

    def _keep_gate(self) -> None:
        adaptive = self.controls.get("design") in METHODS.keys() - DESIGNS.keys()
        if adaptive and self.controls.get("gate") not in (None, "") and "gate" not in self.changed:
            self.controls["gate"] = ""
            self.notes.append("Only constant gains have an outlier gate: it is off.")

    def _keep_manoeuvre(self) -> None:
        pushed = self.controls.get("manoeuvre") not in (None, "", "none")
        if pushed and self.controls.get("noise") == "recorded" and "manoeuvre" not in self.changed:
            self.controls["manoeuvre"] = "none"
            self.notes.append("What was recorded nobody pushed: manoeuvre noise is off.")

    def experiment_values(self) -> dict[str, Any]:
        """The fields that mean something now, none of the others."""
        takes, unread = self._takes(), {*PARAMETERS, *METHOD_PARAMETERS}
        read = {name for name in FIELDS if name not in unread} | set(takes)
        read -= {name for name, (other, values, _) in BESIDE.items() if self.controls.get(other) not in values}
        values = {name: self.controls[name] for name in FIELDS if name in read and name in self.controls}
        # An empty box is an error, but where it means that the number is searched.
        return {
            name: "" if value is None else value
            for name, value in values.items()
            if name not in MAY_BE_EMPTY or value not in (None, "")
        }


SEARCHED = frozenset(
    name for method in METHODS.values() for name, default in method.parameters.items() if default is None
)
"""Parameters that may be left empty."""

MAY_BE_EMPTY = SEARCHED | {"data", "gate", "reading"}
"""What says nothing where it is empty."""


def index_design(order: int) -> str | None:
    """The design from a tracking index for an order, None where there is none."""
    return {2: "kalata", 3: "gray-murray", 4: STEADY}.get(order)


def design_title(name: str) -> str:
    """Title of a design or a method for sentences and menus."""
    if name in DESIGNS:
        return DESIGNS[name].title
    return METHODS[name].title if name in METHODS else "Manual"


@cache
def presets() -> Mapping[str, Experiment]:
    """Every run of the source documents by key."""
    runs = {f"{paper.name}/{run.name}": run.experiment for paper in papers().values() for run in paper.runs}
    return MappingProxyType(runs)


@cache
def preset_keys() -> Mapping[Experiment, str]:
    """The other way round; of several documents that report the same run the first."""
    return MappingProxyType({experiment: key for key, experiment in reversed(list(presets().items()))})


def number(value: Any) -> float | None:
    """A finite number of a moderate size, or None."""
    try:
        return GAIN.check("", value)
    except InputError:
        return None


def numbers_in(name: str, text: Any, count: int) -> list[float]:
    """So many finite numbers of a text, separated by spaces.

    Raises:
        InputError: naming the control, for anything else.
    """
    parts = str(text).split()
    if len(parts) != count:
        raise InputError(name, f"must be {count} numbers", text)
    return [GAIN.check(name, part) for part in parts]
