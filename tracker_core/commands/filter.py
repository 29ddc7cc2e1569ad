"""The commands `design` and `stability`."""

from __future__ import annotations

import argparse
from typing import Any

from tracker_core.checks import POSITIVE, InputError, check_choice
from tracker_core.commands.base import Commands, add_field, complex_pairs, given, print_json
from tracker_core.conventions import CONVENTIONS, Gains
from tracker_core.design import DESIGNS, Design
from tracker_core.design.steady_kalman import tracking_index_of
from tracker_core.experiment import PARAMETERS
from tracker_core.exports import gains_dict
from tracker_core.fields import FIELDS, INTERVAL
from tracker_core.merits import MERITS, merits
from tracker_core.poles import damping_class
from tracker_core.region import nearest_stable
from tracker_core.stability import Condition, assess, printed_conditions
from tracker_core.types import GAIN_NAMES


def add(commands: Commands) -> None:
    """Add the commands to a parser."""
    design = commands.add_parser("design", help="gains of a design method")
    design.add_argument("name", metavar="NAME", help=", ".join(DESIGNS))
    for name in ("order", "convention", *PARAMETERS):
        add_field(design, name)
    design.add_argument(
        "--process-std", metavar="σ_w", help="manoeuvre noise, m/s², order 4 m/s³: with the next two, gives Λ"
    )
    design.add_argument("--sensor-std", metavar="σ_v", help="measurement noise, m")
    add_field(design, "interval")
    design.set_defaults(action=_design)

    stability = commands.add_parser("stability", help="poles, verdict and figures of merit of a gain set")
    for name in ("order", "convention", *GAIN_NAMES, "interval"):
        add_field(stability, name)
    stability.set_defaults(action=_stability)


def _design(options: argparse.Namespace) -> None:
    design = DESIGNS[check_choice("design", options.name, DESIGNS)]
    values = given(options, PARAMETERS)
    noise = given(options, ("process_std", "sensor_std", "interval"))
    if noise and "tracking_index" in values:
        raise InputError(
            "tracking_index", "must be left out where it follows from process_std", values["tracking_index"]
        )
    order = FIELDS["order"].read("order", options.order) if options.order is not None else None
    if noise:
        values["tracking_index"] = _tracking_index(design, order, noise)
    convention = FIELDS["convention"].read(
        "convention", "normalised" if options.convention is None else options.convention
    )
    gains = Gains.normalised(design.gains(order, **values)).to(convention)
    verdict = assess(gains)
    summary = {"design": design.name, "order": gains.order, **gains_dict(gains), "poles": complex_pairs(verdict.poles)}
    if options.json:
        print_json(summary)
        return
    for name, value in zip(GAIN_NAMES, gains.values, strict=False):
        print(f"{name:6} {value:.15g}")
    print(f"convention {convention}: {CONVENTIONS[convention].title}")
    print("poles ", ", ".join(f"{pole:.6g}" for pole in verdict.poles))


def _tracking_index(design: Design, order: int | None, noise: dict[str, Any]) -> float:
    if "tracking_index" not in design.parameters:
        name, value = next(iter(noise.items()))
        raise InputError(name, f"must be left out for the design '{design.name}'", value)
    for name in ("process_std", "sensor_std", "interval"):
        if name not in noise:
            raise InputError(name, "must be given with the other two of process_std, sensor_std, interval", None)
    interval = INTERVAL.check("interval", noise["interval"])
    process, sensor = (POSITIVE.check(name, noise[name]) for name in ("process_std", "sensor_std"))
    return tracking_index_of(order or design.orders[0], process, sensor, interval)


def _stability(options: argparse.Namespace) -> None:
    values = given(options, GAIN_NAMES)
    order = FIELDS["order"].read("order", max(2, len(values)) if options.order is None else options.order)
    convention = FIELDS["convention"].read(
        "convention", "normalised" if options.convention is None else options.convention
    )
    gain_values = []
    for name in GAIN_NAMES:
        if (name in values) != (GAIN_NAMES.index(name) < order):
            rule = f"must be left out for order {order}" if name in values else f"must be given for order {order}"
            raise InputError(name, rule, values.get(name))
        if name in values:
            gain_values.append(FIELDS[name].read(name, values[name]))
    gains = Gains(tuple(gain_values), convention)
    verdict, printed = assess(gains), printed_conditions(gains)
    nearest = None if verdict.stable else nearest_stable(gains)
    interval = INTERVAL.check("interval", 1.0 if options.interval is None else options.interval)
    figures = merits(gains, interval)
    if options.json:
        print_json(
            {
                "stable": verdict.stable,
                "spectral_radius": verdict.spectral_radius,
                "poles": complex_pairs(verdict.poles),
                "conditions": [_row(condition) for condition in verdict.conditions],
                "jury": [_row(condition) for condition in verdict.jury],
                "printed": [_row(condition) for condition in printed],
                "damping_class": damping_class(gains),
                "merits": figures,
                "nearest_stable": None if nearest is None else gains_dict(nearest),
            }
        )
        return
    print("stable" if verdict.stable else "unstable", f"(largest pole {verdict.spectral_radius:.9g})")
    for condition in (*verdict.conditions, *verdict.jury):
        _print_condition(condition)
    if printed:
        print("as printed by Yu & Wu 2017, in the convention half:")
    for condition in printed:
        _print_condition(condition)
    print("poles ", ", ".join(f"{pole:.6g}" for pole in verdict.poles), f"({damping_class(gains)})")
    if nearest is not None:
        pairs = zip(GAIN_NAMES, nearest.values, strict=False)
        print("nearest stable gains ", "  ".join(f"{name} {value:.9g}" for name, value in pairs))
    for name, value in figures.items():
        if value is not None and name != "spectral_radius":
            print(f"{MERITS[name].title:28} {value:.6g} {MERITS[name].unit}".rstrip())


def _print_condition(condition: Condition) -> None:
    print(f"{'holds' if condition.holds else 'FAILS':6} {condition.text:36} margin {condition.margin:.6g}")


def _row(condition: Condition) -> dict[str, Any]:
    row: dict[str, Any] = {"condition": condition.text, "margin": condition.margin, "holds": condition.holds}
    return {**row, "numbers": list(condition.numbers)} if condition.numbers else row
