"""What the Compare page shows of a run: the filters, and every metric of each beside the reference."""

from __future__ import annotations

from typing import Any

from layouts.desk import Desk, Plot
from layouts.figures import comparison
from layouts.filter_card import SLIDERS
from layouts.pinned import Candidate, candidates, metrics_of, reference_of
from layouts.rules import design_title
from layouts.shown import Shown
from layouts.text import change_text, metric_text, significant
from tracker_core import METRICS, STARTS, Experiment, Metrics
from tracker_core.experiment import DEFAULTS
from tracker_core.fields import FIELDS
from tracker_core.tuning.base import has_chance
from tracker_core.types import GAIN_NAMES

SAME_RUNS = (
    "Every seed would give the same run: nothing of this target and sensor is left to chance. Choose a noise that is "
    "drawn, or manoeuvre noise, to compare over many seeds."
)


def report(shown: Shown) -> dict[str, Any]:
    """The filters that are compared, and the table of their metrics."""
    settings = shown.settings
    factor = shown.view.exaggerate
    experiment = settings.experiment
    return {
        "filters": [filter_row(candidate, shown) for candidate in candidates(settings)],
        "rows": {"metrics": metric_rows(shown)},
        "texts": {
            "scale": "" if factor == 1 else f"deviations × {factor}",
            "chance": "" if has_chance(experiment) else SAME_RUNS,
            "data": f"{experiment.samples:,} samples of {shown.result.scenario.title}, seed {experiment.seed}",
        },
    }


def filter_row(candidate: Candidate, shown: Shown) -> dict[str, Any]:
    """One line of the list: slot, name, gains, design, and what is wrong with it, if anything."""
    experiment = candidate.experiment
    present = shown.settings.experiment
    row = {"slot": candidate.slot, "name": candidate.name, "gains": "", "design": "", "problem": candidate.reason}
    row["reference"] = candidate.slot == reference_of(shown.settings)
    if experiment is not None:
        row["gains"] = gains_text(experiment, present.convention)
        row["design"] = design_text(experiment)
        if run_metrics(candidate, shown) is None:
            row["problem"] = "The run was stopped: it left the world."
    return row


def gains_text(experiment: Experiment, convention: str) -> str:
    """The constant gains, or that a method chooses them."""
    if experiment.method is not None:
        return "gains chosen as it runs"
    gains = experiment.gains().to(convention)
    said = zip(GAIN_NAMES, gains.values, strict=False)
    return ", ".join(f"{FIELDS[name].symbol} {significant(value, 3)}" for name, value in said)


def design_text(experiment: Experiment) -> str:
    """Design, order, an unusual start, and whether it looks in hindsight."""
    said = [f"{'◆ ' if experiment.hindsight else ''}{design_title(experiment.design)}", f"order {experiment.order}"]
    if experiment.start != DEFAULTS["start"]:
        said.append(f"start: {STARTS[experiment.start].title.lower()}")
    return ", ".join(said)


def run_metrics(candidate: Candidate, shown: Shown) -> Metrics | None:
    """How good one of the filters is in the run shown; None where it does not run to the end."""
    if candidate.experiment is None:
        return None
    if candidate.experiment == shown.settings.experiment:
        return shown.result.metrics if shown.result.track.stopped_at is None else None
    return metrics_of(candidate.experiment)


def metric_rows(shown: Shown) -> list[list[Any]]:
    """Per metric its title, and per filter its value with the change from the reference's below it."""
    found = [(candidate, run_metrics(candidate, shown)) for candidate in candidates(shown.settings)]
    reference = reference_of(shown.settings)
    base = next(metrics for candidate, metrics in found if candidate.slot == reference)
    rows: list[list[Any]] = []
    for name, metric in METRICS.items():
        row: list[Any] = [metric.title]
        for candidate, metrics in found:
            value = None if metrics is None else getattr(metrics, name)
            change, tone = "", "same"
            if len(found) > 1 and candidate.slot == reference:
                change = "reference"
            elif metrics is not None and base is not None and len(found) > 1:
                change, tone = change_text(metric, value, getattr(base, name))
            row.append([metric_text(metric, value), tone, change])
        rows.append(row)
    return rows


DESK = Desk(
    page="compare",
    plots={
        "compare-path": Plot(comparison.path_overlay, comparison.PATH_MOVING, comparison.path_key, often=True),
        "compare-close-up": Plot(
            comparison.close_up_overlay, comparison.CLOSE_UP_MOVING, comparison.close_up_key, often=True
        ),
        "compare-error": Plot(comparison.error_overlay, comparison.ERROR_MOVING, comparison.error_key),
        "compare-gains": Plot(comparison.gains_overlay, comparison.GAINS_MOVING, comparison.gains_key),
    },
    tables={},
    report=report,
    sliders=SLIDERS,
)
