"""Command line: python -m tracker_core run|design|stability."""

from __future__ import annotations

import argparse
import io
import json
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from tracker_core.checks import POSITIVE, InputError, show
from tracker_core.conventions import CONVENTIONS, Gains
from tracker_core.design import DESIGNS
from tracker_core.experiment import PARAMETERS, Experiment
from tracker_core.exports import track_columns, write_track
from tracker_core.fields import FIELDS, INTERVAL
from tracker_core.merits import MERITS, merits
from tracker_core.metrics import METRICS
from tracker_core.poles import damping_class
from tracker_core.region import nearest_stable
from tracker_core.run import Result, run_experiment
from tracker_core.stability import Condition, assess, printed_conditions
from tracker_core.types import GAIN_NAMES

SHOWN_ROWS = 50


class _Parser(argparse.ArgumentParser):
    """Reports a wrong command line in one line."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **{"allow_abbrev": False, **options})
        # Before Python 3.14 argparse takes -1e-3 for a flag.
        self._negative_number_matcher = re.compile(r"^-(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?$")

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {' '.join(message.split())}\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status: 0, or 2 for bad input."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Greek letters must not stop an output that cannot show them.
            stream.reconfigure(errors="replace")
    parser = _parser()
    options = parser.parse_args(arguments)
    try:
        options.action(options)
        sys.stdout.flush()
    except InputError as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # Whoever read the output has seen enough; nothing more may be written, not even at the end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        print(f"{parser.prog}: {show(error.filename or 'output')}: {error.strerror}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="python -m tracker_core", description="Fixed-gain tracking filters.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="run|design|stability")

    run = commands.add_parser("run", help="run an experiment and print its metrics")
    run.add_argument("--experiment", metavar="FILE", help="experiment as a JSON object; flags override its fields")
    for name in FIELDS:
        _add_field(run, name)
    run.add_argument("--out", metavar="FILE", help="write the track as CSV")
    run.set_defaults(action=_run)

    design = commands.add_parser("design", help="gains of a design method")
    design.add_argument("name", metavar="NAME", help=", ".join(DESIGNS))
    for name in ("order", "convention", *PARAMETERS):
        _add_field(design, name)
    design.add_argument("--process-std", metavar="σ_w", help="manoeuvre noise, m/s²: with the next two, gives Λ")
    design.add_argument("--sensor-std", metavar="σ_v", help="measurement noise, m")
    _add_field(design, "interval")
    design.set_defaults(action=_design)

    stability = commands.add_parser("stability", help="poles, verdict and figures of merit of a gain set")
    for name in ("order", "convention", *GAIN_NAMES, "interval"):
        _add_field(stability, name)
    stability.set_defaults(action=_stability)
    for command in (run, design, stability):
        command.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


def _add_field(parser: argparse.ArgumentParser, name: str) -> None:
    field = FIELDS[name]
    unit = f" [{field.unit}]" if field.unit else ""
    # Values stay text here: reading them is the experiment's business, so that all messages are alike.
    parser.add_argument(f"--{name.replace('_', '-')}", metavar=field.symbol or name.upper(), help=field.sentence + unit)


def _given(options: argparse.Namespace, names: Sequence[str]) -> dict[str, Any]:
    return {name: getattr(options, name) for name in names if getattr(options, name) is not None}


def _run(options: argparse.Namespace) -> None:
    values = {**_file(options.experiment), **_given(options, list(FIELDS))}
    result = run_experiment(Experiment.from_dict(values))
    if options.out:
        with Path(options.out).open("w", encoding="utf-8", newline="") as stream:
            write_track(result, stream)
    _print_json(run_summary(result)) if options.json else _print_run(result)


def _file(path: str | None) -> dict[str, Any]:
    if path is None:
        return {}
    try:
        values = json.loads(Path(path).read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError("experiment", "must be a JSON file", f"{path}: {error}") from None
    if not isinstance(values, dict):
        raise InputError("experiment", "must be a JSON object", values)
    return values


def run_summary(result: Result) -> dict[str, Any]:
    """The result of a run as plain data.

    Keys: experiment, gains (convention, alpha ... eta), stable, spectral_radius, metrics, axes (metrics by axis name),
    missing, stopped_at (sample number counted from 1, or null), method (null for constant gains, else hindsight,
    found, unstable_share).
    """
    stop = result.track.stopped_at
    return {
        "experiment": result.experiment.to_dict(),
        "gains": _gains(result.gains),
        "stable": result.verdict.stable,
        "spectral_radius": result.verdict.spectral_radius,
        "metrics": result.metrics.to_dict(),
        "axes": {
            axis: metrics.to_dict() for axis, metrics in zip(result.scenario.axes, result.axis_metrics(), strict=True)
        },
        "missing": result.track.missing,
        "stopped_at": None if stop is None else stop + 1,
        "method": None
        if result.selection is None
        else {
            "hindsight": result.experiment.hindsight or None,
            "found": {name: list(values) for name, values in result.selection.found.items()},
            "unstable_share": result.unstable_share(),
        },
    }


def _print_run(result: Result) -> None:
    columns = track_columns(result)
    if len(result.truth.times) <= SHOWN_ROWS:
        print("  ".join(f"{name:>14}" for name in columns))
        for row in zip(*(column.tolist() for column in columns.values()), strict=True):
            print("  ".join(f"{value:14.8g}" for value in row))
        print()
    if result.selection is not None:
        _print_selection(result)
    print("  ".join(f"{name} {value:.6g}" for name, value in zip(GAIN_NAMES, result.gains.values, strict=False)))
    print("stable" if result.verdict.stable else "unstable", f"(largest pole {result.verdict.spectral_radius:.6g})")
    if result.track.stopped_at is not None:
        print(f"stopped at sample {result.track.stopped_at + 1}: a position passed {result.track.limit:g} m")
    for name, value in result.metrics.to_dict().items():
        metric = METRICS[name]
        print(f"{metric.title:28}", "-" if value is None else f"{value:.6g} {metric.unit}")


def _print_selection(result: Result) -> None:
    if result.experiment.hindsight:
        print(f"oracle: {result.experiment.hindsight}")
    for name, values in result.selection.found.items() if result.selection else ():
        print(f"found {name}", ", ".join(f"{value:.6g}" for value in values))
    print(f"{100 * result.unstable_share():.3g} % of the corrections use gains that would be unstable if held")
    print(f"gains of the last sample in {result.scenario.axes[0]}:")


def _design(options: argparse.Namespace) -> None:
    if options.name not in DESIGNS:
        raise InputError("design", f"must be one of {', '.join(DESIGNS)}", options.name)
    given = _given(options, PARAMETERS)
    noise = _given(options, ("process_std", "sensor_std", "interval"))
    if noise and "tracking_index" in given:
        raise InputError(
            "tracking_index", "must be left out where it follows from process_std", given["tracking_index"]
        )
    if noise:
        given["tracking_index"] = _tracking_index(noise)
    order = FIELDS["order"].read("order", options.order) if options.order is not None else None
    convention = FIELDS["convention"].read(
        "convention", "normalised" if options.convention is None else options.convention
    )
    gains = Gains.normalised(DESIGNS[options.name].gains(order, **given)).to(convention)
    verdict = assess(gains)
    summary = {"design": options.name, "order": gains.order, **_gains(gains), "poles": _complex(verdict.poles)}
    if options.json:
        _print_json(summary)
        return
    for name, value in zip(GAIN_NAMES, gains.values, strict=False):
        print(f"{name:6} {value:.15g}")
    print(f"convention {convention}: {CONVENTIONS[convention].title}")
    print("poles ", ", ".join(f"{pole:.6g}" for pole in verdict.poles))


def _tracking_index(noise: dict[str, Any]) -> float:
    for name in ("process_std", "sensor_std", "interval"):
        if name not in noise:
            raise InputError(name, "must be given with the other two of process_std, sensor_std, interval", None)
    interval = INTERVAL.check("interval", noise["interval"])
    process, sensor = (POSITIVE.check(name, noise[name]) for name in ("process_std", "sensor_std"))
    return process * interval**2 / sensor


def _stability(options: argparse.Namespace) -> None:
    given = _given(options, GAIN_NAMES)
    order = FIELDS["order"].read("order", max(2, len(given)) if options.order is None else options.order)
    convention = FIELDS["convention"].read(
        "convention", "normalised" if options.convention is None else options.convention
    )
    values = []
    for name in GAIN_NAMES:
        if (name in given) != (GAIN_NAMES.index(name) < order):
            rule = f"must be left out for order {order}" if name in given else f"must be given for order {order}"
            raise InputError(name, rule, given.get(name))
        if name in given:
            values.append(FIELDS[name].read(name, given[name]))
    gains = Gains(tuple(values), convention)
    verdict, printed = assess(gains), printed_conditions(gains)
    nearest = None if verdict.stable else nearest_stable(gains)
    interval = INTERVAL.check("interval", 1.0 if options.interval is None else options.interval)
    figures = merits(gains, interval)
    if options.json:
        _print_json(
            {
                "stable": verdict.stable,
                "spectral_radius": verdict.spectral_radius,
                "poles": _complex(verdict.poles),
                "conditions": [_row(condition) for condition in verdict.conditions],
                "jury": [_row(condition) for condition in verdict.jury],
                "printed": [_row(condition) for condition in printed],
                "damping_class": damping_class(gains),
                "merits": figures,
                "nearest_stable": None if nearest is None else _gains(nearest),
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


def _gains(gains: Gains) -> dict[str, Any]:
    padded = [*gains.values, *[None] * (4 - gains.order)]
    return {"convention": gains.convention, **dict(zip(GAIN_NAMES, padded, strict=True))}


def _complex(roots: Sequence[complex]) -> list[list[float]]:
    """Each as [real, imaginary]: JSON has no complex numbers."""
    return [[root.real, root.imag] for root in roots]


def _print_json(value: Any) -> None:
    print(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))


if __name__ == "__main__":
    sys.exit(main())
