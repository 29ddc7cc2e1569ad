"""The command `suggest`."""

from __future__ import annotations

import argparse
from typing import Any

from tracker_core.commands.base import Commands, add_experiment, experiment_values, print_json
from tracker_core.experiment import Experiment
from tracker_core.exports import gains_dict
from tracker_core.identification import Identified
from tracker_core.run import observe, suited
from tracker_core.suggestion import Suggestion, suggest


def add(commands: Commands) -> None:
    """Add the command to a parser."""
    parser = commands.add_parser("suggest", help="estimate the noise of measurements and suggest a filter, with why")
    add_experiment(parser)
    parser.set_defaults(action=_suggest)


def _suggest(options: argparse.Namespace) -> None:
    experiment = Experiment.from_dict(experiment_values(options))
    _, measurements, _ = observe(experiment)
    found = suggest(measurements, interval=experiment.interval, axes=experiment.target.axes)
    better = suited(experiment, found)
    print_json(summary(better, found)) if options.json else _print(better, found)


def summary(better: Experiment, found: Suggestion) -> dict[str, Any]:
    """A suggestion as plain data.

    Keys: experiment (with the suggested filter; an experiment file again), gains, why (sentences), orders (by order
    sensor_std and process_std per axis, tracking_index and its 95 % interval as low and high, bic, set_aside).
    """
    return {
        "experiment": better.to_dict(),
        "gains": gains_dict(better.gains()),
        "why": list(found.why),
        "orders": {
            str(order): _plain(identified) | {"bic": found.bic[order]} for order, identified in found.identified.items()
        },
    }


def _plain(found: Identified) -> dict[str, Any]:
    low, high = found.index_interval
    return {
        "sensor_std": list(found.sensor_std),
        "process_std": list(found.process_std),
        "tracking_index": found.tracking_index,
        "low": low,
        "high": high,
        "set_aside": found.rejected,
    }


def _print(better: Experiment, found: Suggestion) -> None:
    for sentence in found.why:
        print(sentence)
    values = {name: better.to_dict().get(name) for name in found.values}
    said = {name: ",".join(map(repr, v)) if isinstance(v, list) else v for name, v in values.items() if v is not None}
    print("As flags:", " ".join(f"--{name.replace('_', '-')} {value}" for name, value in said.items()))
