"""The fields of the experiment: what they are called, what they admit. Menus, flags, links and messages read this."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tracker_core.checks import Domain, InputError, check_choice
from tracker_core.conventions import CONVENTIONS, GAIN
from tracker_core.design import DESIGNS, MANUAL
from tracker_core.noise import NOISES
from tracker_core.scenarios import SCENARIOS
from tracker_core.starts import STARTS
from tracker_core.types import ORDERS

SAMPLES = Domain(3, 200_000, whole=True)
INTERVAL = Domain(1e-6, 1e6)
NOISE_STD = Domain(0, 1e9)
SEED = Domain(0, 2**53 - 1, whole=True)


@dataclass(frozen=True, slots=True)
class Field:
    """One field of the experiment.

    Attributes:
        symbol: as in formulas; empty where there is none.
        title: for labels.
        unit: SI symbol; empty for a pure number.
        sentence: what it is, plainly.
        kind: "number", "whole", "numbers" (one per axis) or "choice".
        domain: the numbers it admits; a design may narrow it.
        choices: the names it admits.
    """

    symbol: str
    title: str
    unit: str
    sentence: str
    kind: str
    domain: Domain = Domain()
    choices: tuple[str, ...] = ()

    def read(self, name: str, value: Any) -> Any:
        """`value` as this field's type.

        Raises:
            InputError: naming the field, the rule and the value.
        """
        if self.kind == "choice":
            return check_choice(name, value, self.choices)
        if self.kind == "numbers":
            return tuple(self.domain.check(name, item) for item in _items(name, value))
        number = self.domain.check(name, value)
        return int(number) if self.kind == "whole" else number


def _items(name: str, value: Any) -> list[Any]:
    if isinstance(value, str):
        return value.split(",")
    if isinstance(value, Iterable) and not isinstance(value, Mapping):
        items = list(value)
        if not 1 <= len(items) <= 8:
            raise InputError(name, "must be one number, or one per axis", f"{len(items)} values")
        return items
    return [value]


def _choice(title: str, sentence: str, choices: Iterable[str]) -> Field:
    return Field("", title, "", sentence, "choice", choices=tuple(choices))


FIELDS: dict[str, Field] = {
    "scenario": _choice("Scenario", "The target and its true motion.", SCENARIOS),
    "samples": Field("n", "Samples", "", "How many measurements are taken.", "whole", SAMPLES),
    "interval": Field("T", "Interval", "s", "Time between two measurements.", "number", INTERVAL),
    "noise": _choice("Noise", "What kind of error the measurements carry.", NOISES),
    "noise_std": Field(
        "σ", "Noise std", "m", "Standard deviation of the measurement error; one number, or one per axis.",
        "numbers", NOISE_STD),
    "seed": Field("", "Seed", "", "The same seed draws the same noise, everywhere.", "whole", SEED),
    "start": _choice("Start", "Where the filter's first state comes from.", STARTS),
    "order": Field(
        "", "Order", "", "Number of states per axis: 2 tracks velocity, 3 acceleration, 4 jerk.",
        "whole", Domain(min(ORDERS), max(ORDERS), whole=True)),
    "convention": _choice(
        "Gain convention", "What γ and η multiply; changing it rewrites the numbers and leaves the filter.",
        CONVENTIONS),
    "design": _choice("Design", "The formula that computes the gains, or manual.", [MANUAL, *DESIGNS]),
    "alpha": Field("α", "Position gain", "", "Share of the innovation that corrects the position.", "number", GAIN),
    "beta": Field("β", "Velocity gain", "", "Corrects the velocity by β e/T.", "number", GAIN),
    "gamma": Field("γ", "Acceleration gain", "", "Corrects the acceleration.", "number", GAIN),
    "eta": Field("η", "Jerk gain", "", "Corrects the jerk.", "number", GAIN),
    "xi": Field("ξ", "Fading factor", "", "Weight of the past per sample: near 1 smooth, near 0 responsive.",
                "number"),
    "tracking_index": Field(
        "Λ", "Tracking index", "", "Λ = σ_w T²/σ_v: manoeuvre against measurement noise.", "number"),
}  # fmt: skip
