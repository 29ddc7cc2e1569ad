"""The command `run`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from tracker_core.checks import InputError
from tracker_core.commands.base import Commands, add_field, given, print_json
from tracker_core.experiment import Experiment
from tracker_core.exports import run_summary, track_columns, write_track
from tracker_core.fields import FIELDS
from tracker_core.metrics import METRICS
from tracker_core.run import Result, run_experiment
from tracker_core.types import GAIN_NAMES

SHOWN_ROWS = 50


def add(commands: Commands) -> None:
    """Add the command to a parser."""
    run = commands.add_parser("run", help="run an experiment and print its metrics")
    run.add_argument("--experiment", metavar="FILE", help="experiment as a JSON object; flags override its fields")
    for name in FIELDS:
        add_field(run, name)
    run.add_argument("--out", metavar="FILE", help="write the track as CSV")
    run.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> None:
    values = {**experiment_file(options.experiment), **given(options, list(FIELDS))}
    result = run_experiment(Experiment.from_dict(values))
    if options.out:
        with Path(options.out).open("w", encoding="utf-8", newline="") as stream:
            write_track(result, stream)
    print_json(run_summary(result)) if options.json else _print_run(result)


def experiment_file(path: str | None) -> dict[str, Any]:
    """The fields of an experiment that a file holds as a JSON object; none without a file.

    Raises:
        InputError: for a file that holds something else.
    """
    if path is None:
        return {}
    try:
        values = json.loads(Path(path).read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError("experiment", "must be a JSON file", f"{path}: {error}") from None
    if not isinstance(values, dict):
        raise InputError("experiment", "must be a JSON object", values)
    return values


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
