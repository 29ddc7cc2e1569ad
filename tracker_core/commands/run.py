"""The command `run`."""

from __future__ import annotations

import argparse
from pathlib import Path

from tracker_core.commands.base import Commands, add_experiment, experiment_values, print_json
from tracker_core.experiment import Experiment
from tracker_core.exports import found_in, run_summary, track_columns, write_track
from tracker_core.innovations import EVIDENCE
from tracker_core.metrics import METRICS
from tracker_core.recordings import KINDS
from tracker_core.run import Result, run_experiment
from tracker_core.types import GAIN_NAMES

SHOWN_ROWS = 50


def add(commands: Commands) -> None:
    """Add the command to a parser."""
    run = commands.add_parser("run", help="run an experiment and print its metrics")
    add_experiment(run)
    run.add_argument("--out", metavar="FILE", help="write the track as CSV")
    run.set_defaults(action=_run)


def _run(options: argparse.Namespace) -> None:
    result = run_experiment(Experiment.from_dict(experiment_values(options)))
    if options.out:
        with Path(options.out).open("w", encoding="utf-8", newline="") as stream:
            write_track(result, stream)
    print_json(run_summary(result)) if options.json else _print_run(result)


def _print_run(result: Result) -> None:
    columns = track_columns(result)
    if len(result.truth.times) <= SHOWN_ROWS:
        print("  ".join(f"{name:>14}" for name in columns))
        for row in zip(*(column.tolist() for column in columns.values()), strict=True):
            print("  ".join(f"{value:14.8g}" for value in row))
        print()
    for kind, count in (found_in(result.experiment) or {}).items():
        print(f"{count:,} x {KINDS[kind].title.lower()}: {KINDS[kind].done}")
    if result.selection is not None:
        _print_selection(result)
    print("  ".join(f"{name} {value:.6g}" for name, value in zip(GAIN_NAMES, result.gains.values, strict=False)))
    print("stable" if result.verdict.stable else "unstable", f"(largest pole {result.verdict.spectral_radius:.6g})")
    if result.track.stopped_at is not None:
        print(f"stopped at sample {result.track.stopped_at + 1}: a position passed {result.track.limit:g} m")
    if result.track.rejected is not None:
        print(f"{int(result.track.rejected.sum()):,} samples were not believed by the gate")
    metrics, values = (METRICS, result.metrics.to_dict())
    if not result.truth.known:
        print("nobody knows the truth: this is what the innovations say")
        metrics, values = EVIDENCE, result.evidence().to_dict()
    for name, value in values.items():
        metric = metrics[name]
        print(f"{metric.title:28}", "-" if value is None else f"{value:.6g} {metric.unit}")


def _print_selection(result: Result) -> None:
    if result.experiment.hindsight:
        print(f"oracle: {result.experiment.hindsight}")
    for name, values in result.selection.found.items() if result.selection else ():
        print(f"found {name}", ", ".join(f"{value:.6g}" for value in values))
    print(f"{100 * result.unstable_share():.3g} % of the corrections use gains that would be unstable if held")
    print(f"gains of the last sample in {result.scenario.axes[0]}:")
