"""The command `sweep`."""

from __future__ import annotations

import argparse
from math import isfinite
from typing import Any

from tracker_core.checks import Domain
from tracker_core.commands.base import Commands, add_experiment, experiment_values, print_json
from tracker_core.experiment import Experiment
from tracker_core.statistics import Interval
from tracker_core.tuning import OBJECTIVES, PARAMETERS, Sweep, SweepOutcome
from tracker_core.tuning.objectives import usual_objective
from tracker_core.tuning.sweeps import POINTS, RUNS, usual_values

NUMBER = Domain()


def add(commands: Commands) -> None:
    """Add the command to a parser."""
    sweep = commands.add_parser("sweep", help="vary one number of a filter over many runs and print the best value")
    sweep.add_argument("parameter", help=f"what is varied: {', '.join(PARAMETERS)}")
    sweep.add_argument("--for", dest="objective_for", metavar="OBJECTIVE",
                       help="what is to be small; estimation_rmse, or without a truth innovation_rmse, if left out: "
                       f"{', '.join(OBJECTIVES)}")  # fmt: skip
    sweep.add_argument("--from", dest="low", metavar="VALUE", help="the first value")
    sweep.add_argument("--to", dest="high", metavar="VALUE", help="the last value")
    sweep.add_argument("--points", metavar="N", default="101", help="how many values")
    sweep.add_argument("--runs", metavar="N", default="20", help="how many runs, each with a seed of its own")
    sweep.add_argument("--noise-weight", metavar="W", default="0.5", help="of the noise against the lag, 0 to 1")
    add_experiment(sweep)
    sweep.set_defaults(action=_sweep)


def _sweep(options: argparse.Namespace) -> None:
    experiment = Experiment.from_dict(experiment_values(options))
    low, high = (
        None if value is None else NUMBER.check(name, value)
        for name, value in (("low", options.low), ("high", options.high))
    )
    points = int(POINTS.check("points", options.points))
    study = Sweep(
        experiment,
        options.parameter,
        usual_values(experiment, options.parameter, low, high, points),
        options.objective_for or usual_objective(experiment),
        int(RUNS.check("runs", options.runs)),
        NUMBER.check("weight", options.noise_weight),
    )
    *_, progress = study.stream()
    print_json(summary(progress.outcome)) if options.json else _print(progress.outcome)


def summary(outcome: SweepOutcome) -> dict[str, Any]:
    """A sweep as plain data.

    Keys: experiment, parameter, objective, runs, values, mean, low, high (per value; null where a run stopped), stable,
    optimum (value, low, high, score, at_edge; null where no value has one).
    """
    mean, width = outcome.mean()
    return {
        "experiment": outcome.sweep.experiment.to_dict(),
        "parameter": outcome.sweep.parameter,
        "objective": outcome.sweep.objective,
        "runs": outcome.runs,
        "values": list(outcome.sweep.values),
        "mean": [_finite(value) for value in mean.tolist()],
        "low": [_finite(value) for value in (mean - width).tolist()],
        "high": [_finite(value) for value in (mean + width).tolist()],
        "stable": outcome.stable.tolist(),
        "optimum": _optimum(outcome),
    }


def _optimum(outcome: SweepOutcome) -> dict[str, Any] | None:
    found = outcome.optimum()
    if not isfinite(found.value):
        return None
    return {
        "value": found.value,
        "low": _finite(found.low),
        "high": _finite(found.high),
        "score": _interval(found.score),
        "at_edge": found.at_edge,
    }


def _interval(interval: Interval) -> dict[str, float | None]:
    return {"mean": _finite(interval.mean), "low": _finite(interval.low), "high": _finite(interval.high)}


def _finite(value: float) -> float | None:
    """JSON has no NaN."""
    return value if isfinite(value) else None


def _print(outcome: SweepOutcome) -> None:
    parameter, objective = PARAMETERS[outcome.sweep.parameter], OBJECTIVES[outcome.sweep.objective]
    mean, width = outcome.mean()
    print(f"{parameter.symbol:>14}  {objective.title} (m), 95 %")
    for value, middle, half, stable in zip(
        outcome.sweep.values, mean.tolist(), width.tolist(), outcome.stable.tolist(), strict=True
    ):
        interval = f"  {middle - half:.6g} to {middle + half:.6g}" if isfinite(half) else ""
        score = f"{middle:.6g}{interval}" if isfinite(middle) else "-"
        print(f"{value:14.6g}  {score}{'' if stable else '  unstable'}")
    found = outcome.optimum()
    if not isfinite(found.value):
        print("\nno value has a score")
        return
    interval = f", 95 %: {found.low:.6g} to {found.high:.6g}" if isfinite(found.low) else ""
    edge = " (the end of what was looked at)" if found.at_edge else ""
    print(f"\nbest: {parameter.symbol} = {found.value:.6g}{interval}{edge}, over {outcome.runs:,} runs")
