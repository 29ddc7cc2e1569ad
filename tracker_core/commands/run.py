"""The command `run`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from tracker_core.commands.base import Commands, add_experiment, experiment_values, gains_dict, print_json
from tracker_core.experiment import Experiment
from tracker_core.exports import track_columns, write_track
from tracker_core.innovations import EVIDENCE
from tracker_core.measured import recorded
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


def run_summary(result: Result) -> dict[str, Any]:
    """The result of a run as plain data.

    Keys: experiment, gains (convention, alpha ... eta), stable, spectral_radius, metrics, evidence (what the
    innovations say, by name), axes (metrics by axis name), missing, refused (samples that the gate did not believe;
    null without one), stopped_at (sample number counted from 1, or null), found (in the file, counts by kind; null for
    a simulated target), method (null for constant gains, else hindsight, found, unstable_share).
    """
    stop, refused = result.track.stopped_at, result.track.rejected
    return {
        "experiment": result.experiment.to_dict(),
        "gains": gains_dict(result.gains),
        "stable": result.verdict.stable,
        "spectral_radius": result.verdict.spectral_radius,
        "metrics": result.metrics.to_dict(),
        "evidence": result.evidence().to_dict(),
        "axes": {
            axis: metrics.to_dict() for axis, metrics in zip(result.scenario.axes, result.axis_metrics(), strict=True)
        },
        "missing": result.track.missing,
        "refused": None if refused is None else int(refused.sum()),
        "stopped_at": None if stop is None else stop + 1,
        "found": found_in(result.experiment),
        "method": None
        if result.selection is None
        else {
            "hindsight": result.experiment.hindsight or None,
            "found": {name: list(values) for name, values in result.selection.found.items()},
            "unstable_share": result.unstable_share(),
        },
    }


def found_in(experiment: Experiment) -> dict[str, int] | None:
    """What was found in the file that was read, counts by kind of finding; None for a simulated target."""
    if experiment.data is None or experiment.reading is None:
        return None
    return dict(recorded(experiment.data, experiment.reading).counts)


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
