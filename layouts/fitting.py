"""What was said to one method or of one target, made to fit another that has been chosen since."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from tracker_core import DESIGNS, InputError
from tracker_core.adaptive import METHODS, Method
from tracker_core.experiment import BESIDE, target_of
from tracker_core.fields import FIELDS
from tracker_core.noise import DECIBEL
from tracker_core.scenarios import Scenario
from tracker_core.types import STATE_NAMES


def fit(controls: dict[str, Any], changed: Collection[str], order: int) -> Iterator[str]:
    """Change what does not fit and was not just moved by a hand.

    Args:
        controls: every control by name; changed in place.
        changed: names of those that a hand has moved.
        order: of the filter.

    Yields:
        A sentence for every change that is to be told.
    """
    design = controls.get("design")
    if design in METHODS and design not in DESIGNS:
        method = METHODS[design]
        if "design" in changed:
            _take_defaults(method, controls, changed)
        if "objective" in method.parameters and "objective" not in changed:
            yield from _keep_objective(controls, order)
        if "window" in method.parameters and "window" not in changed and {"design", "scenario"} & {*changed}:
            yield from _keep_window(controls)
    if "noise_level" in changed and "snr" not in changed:
        yield from _keep_ratio(controls)


def value_of(controls: dict[str, Any], name: str) -> Any:
    """What a field holds, None where it cannot be read."""
    try:
        return FIELDS[name].read(name, controls.get(name))
    except InputError:
        return None


def target_said(controls: dict[str, Any]) -> Scenario:
    """What the controls say is tracked.

    Raises:
        InputError: for an unknown scenario, a recording that is nowhere, or one that cannot be read like this.
    """
    data, reading = (str(controls.get(name) or "") or None for name in ("data", "reading"))
    return target_of(str(controls.get("scenario")), data, reading)


def _take_defaults(method: Method, controls: dict[str, Any], changed: Collection[str]) -> None:
    """What stands where another method would begin stands where this one does."""
    interval = value_of(controls, "interval")
    if interval is None:
        return
    usual = [other.defaults(interval) for other in METHODS.values()]
    for name, default in method.defaults(interval).items():
        present = value_of(controls, name)
        if name not in changed and any(name in defaults and defaults[name] == present for defaults in usual):
            controls[name] = default


def _keep_objective(controls: dict[str, Any], order: int) -> Iterator[str]:
    """A search follows a state that the filter has, and that is known of the target."""
    objective = controls.get("objective")
    try:
        scenario = target_said(controls)
    except InputError:
        # Refused beside the field that is wrong.
        return
    if objective not in STATE_NAMES:
        return
    followed = STATE_NAMES[: min(order, scenario.known_states)]
    if followed and objective not in followed:
        controls["objective"] = followed[-1]
        yield f"The true {objective} is not known or followed here: the objective is {followed[-1]}."


def _keep_window(controls: dict[str, Any]) -> Iterator[str]:
    """The window fits into the run: the page does not show its field before the method runs."""
    window, samples = value_of(controls, "window"), value_of(controls, "samples")
    if window is not None and samples is not None and window >= samples:
        # Half of the run is left to use what the window has found.
        controls["window"] = max(2, samples // 2)
        yield f"The window is longer than the run: W is now {controls['window']:,}."


def _keep_ratio(controls: dict[str, Any]) -> Iterator[str]:
    """A signal-to-noise ratio left from the other way of giving it has a meaning in this one."""
    level, ratio, usual = controls.get("noise_level"), value_of(controls, "snr"), BESIDE["snr"][2]
    if ratio is not None and ((level == "snr" and ratio <= 0) or (level == "snr-decibel" and ratio not in DECIBEL)):
        controls["snr"] = usual
        yield f"An SNR of {ratio:g} means nothing here: it is now {usual:g}."
