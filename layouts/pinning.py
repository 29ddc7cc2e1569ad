"""What a hand does with pins: keep the present filter, let one go, name it, make it the present one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Annotated, Literal

from msgspec import Meta, Struct

from layouts.comparing import PRESENT
from layouts.pins import SLOTS, Pin, Slot, pin_of
from layouts.rules import index_design
from layouts.state import LINK_LIMIT, Settings, to_query
from layouts.text import error_text
from tracker_core import InputError

Outcome = tuple[Settings, str]

NAME_TYPED = 200
"""Characters that may be typed for a name; fewer of them are kept."""


class Action(Struct, array_like=True, forbid_unknown_fields=True, frozen=True):
    """What a hand does with a pin: a list of its name and what it is about.

    Attributes:
        name: one of ACTIONS.
        slot: of the pin, where it is about one.
        text: what the pin is to be called.
    """

    name: Literal["add", "remove", "rename", "use", "start"]
    slot: Slot | None = None
    text: Annotated[str, Meta(max_length=NAME_TYPED)] = ""


FULL = "Six filters are pinned at most:"


def apply(settings: Settings, actions: Iterable[Action]) -> Outcome:
    """Settings after some actions, and what there is to say of them.

    An action of a slot without a pin does nothing. None is done that would make the link too long.
    """
    notes = []
    for action in actions:
        after, note = ACTIONS[action.name](settings, action)
        if len(to_query(after)) > max(LINK_LIMIT, len(to_query(settings))):
            note = f"That was not done: the link would grow beyond {LINK_LIMIT:,} characters."
        else:
            settings = after
        notes.append(note)
    return settings, " ".join(filter(None, notes))


def add(settings: Settings, _: Action) -> Outcome:
    """The present filter becomes the last pin; the last of six makes room for it."""
    return _added(settings, pin_of(0, settings.experiment))


def _added(settings: Settings, pin: Pin) -> Outcome:
    pins, note = list(settings.pins), ""
    same = [other for other in pins if other.values == pin.values]
    if same:
        pins.remove(same[0])
        return replace(settings, pins=(*pins, same[0])), ""
    if len(pins) == len(SLOTS):
        note = f"{FULL} {pins[-1].name} has made room."
        slot = pins.pop().slot
    else:
        slot = min(set(SLOTS) - {other.slot for other in pins})
    return replace(settings, pins=(*pins, replace(pin, slot=slot))), note


def remove(settings: Settings, action: Action) -> Outcome:
    """One pin less; whoever was compared with it is compared with the present filter."""
    view = settings.view
    if view.comparing.reference == action.slot:
        view = replace(view, comparing=replace(view.comparing, reference=PRESENT))
    return replace(settings, view=view, pins=tuple(pin for pin in settings.pins if pin.slot != action.slot)), ""


def rename(settings: Settings, action: Action) -> Outcome:
    """Another name for a pin; without one its usual name."""
    pins = (pin.named(action.text) if pin.slot == action.slot else pin for pin in settings.pins)
    return replace(settings, pins=tuple(pins)), ""


def use(settings: Settings, action: Action) -> Outcome:
    """A pinned filter becomes the present one; the pin stays."""
    for pin in settings.pins:
        if pin.slot == action.slot:
            try:
                return replace(settings, experiment=pin.on(settings.experiment)), ""
            except InputError as error:
                return settings, f"{pin.name} does not fit here: {error_text(error)}"
    return settings, ""


def start(settings: Settings, _: Action) -> Outcome:
    """Three filters of the present order to begin with: a constant memory, an optimal one, one that adapts."""
    order, note = settings.experiment.order, ""
    for values in (
        {"design": "fading-memory", "xi": 0.5},
        {"design": index_design(order), "tracking_index": 0.1},
        {"design": "critically-damped-bank"},
    ):
        filtered = settings.experiment.with_filter({**values, "order": order})
        settings, said = _added(settings, pin_of(0, filtered))
        note = note or said
    return settings, note


ACTIONS: dict[str, Callable[[Settings, Action], Outcome]] = {
    "add": add, "remove": remove, "rename": rename, "use": use, "start": start,
}  # fmt: skip
