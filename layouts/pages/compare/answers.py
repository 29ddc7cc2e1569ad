"""What the Compare page shows of a run: the filters, and every figure of each beside the reference."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from layouts.desk import Desk, Plot
from layouts.figures import comparison
from layouts.filter_card import SLIDERS
from layouts.pages.compare.numbers import numbers
from layouts.pinned import Candidate, candidates, errors_of, evidence_of, reference_of
from layouts.rules import design_title
from layouts.run_cards import UNDIRECTED
from layouts.shown import Shown
from layouts.text import change_text, metric_text, significant
from tracker_core import METRICS, STARTS, Experiment
from tracker_core.batch import KINDS
from tracker_core.experiment import DEFAULTS
from tracker_core.fields import FIELDS
from tracker_core.innovations import EVIDENCE
from tracker_core.metrics import Metric
from tracker_core.tuning.base import has_chance
from tracker_core.types import GAIN_NAMES

NUMBERS = "compare-numbers"

SAME_RUNS = (
    "Every seed would give the same run: nothing of this target and sensor is left to chance. Choose a noise that is "
    "drawn, or manoeuvre noise, to compare over many seeds."
)

ONE_RUN = (
    "This target was measured once, and no second run tells what was chance: of the differences above none is called "
    "significant. A simulated target can be compared over many seeds."
)

NEEDS_TRUTH = (
    "Where a dash stands a truth is needed, and nobody knows where this target really was. The innovations need none; "
    "the least of them need not be the least error."
)

OWN_GATES = (
    "What a filter's own gate refused does not count among its innovations: filters with different gates are not "
    "judged by the same measurements."
)


Figures = dict[str, float | None]
"""How good a run is, by name."""


def report(shown: Shown) -> dict[str, Any]:
    """The filters that are compared, and the table of their metrics."""
    settings = shown.settings
    factor = shown.view.exaggerate
    experiment = settings.experiment
    measured, known = experiment.target.measured, shown.result.truth.known
    seed = "" if measured else f", seed {experiment.seed}"
    found = [(candidate, run_figures(candidate, shown)) for candidate in candidates(settings)]
    reference = reference_of(settings)
    return {
        "filters": [filter_row(each, figures, reference, experiment.convention) for each, figures in found],
        "rows": {"metrics": metric_rows(found, reference, known=known)},
        "texts": {
            "scale": "" if factor == 1 or not known else f"deviations × {factor}",
            "chance": ONE_RUN if measured else "" if has_chance(experiment) else SAME_RUNS,
            "counted": " ".join(_counted(shown)),
            "error-title": "Innovation" if shown.view.comparing.compared == "innovation" else "Error",
            "data": f"{experiment.samples:,} samples of {shown.result.scenario.title}{seed}",
        },
        "fields": dict.fromkeys(("over-seeds", "figure"), not measured),
        "offers": {"compared": list(KINDS) if known else ["innovation"]},
    }


def _counted(shown: Shown) -> Iterator[str]:
    """What must be known to read the table of this run."""
    if not shown.result.truth.known:
        yield NEEDS_TRUTH
    runs = [candidate.experiment for candidate in candidates(shown.settings) if candidate.experiment is not None]
    if len({experiment.gate for experiment in runs}) > 1:
        yield OWN_GATES


def filter_row(candidate: Candidate, figures: Figures | None, reference: int, convention: str) -> dict[str, Any]:
    """One line of the list: slot, name, which filter it is, gains, design, and what is wrong with it, if anything."""
    experiment = candidate.experiment
    row = {"slot": candidate.slot, "name": candidate.name, "key": candidate.key, "gains": "", "design": ""}
    row["problem"] = candidate.reason
    row["reference"] = candidate.slot == reference
    if experiment is not None:
        row["gains"] = gains_text(experiment, convention)
        row["design"] = design_text(experiment)
        if figures is None:
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
    """Design, order, an unusual start, a gate, and whether it looks in hindsight."""
    said = [f"{'◆ ' if experiment.hindsight else ''}{design_title(experiment.design)}", f"order {experiment.order}"]
    if experiment.start != DEFAULTS["start"]:
        said.append(f"start: {STARTS[experiment.start].title.lower()}")
    if experiment.gate is not None:
        said.append(f"gate {experiment.gate:g} σ")
    return ", ".join(said)


def run_figures(candidate: Candidate, shown: Shown) -> Figures | None:
    """How good one of the filters is in the run shown, by name; None where it does not run to the end.

    Where nobody knows the truth, what its innovations say as well.
    """
    experiment, result = candidate.experiment, shown.result
    if experiment is None:
        return None
    if experiment != shown.settings.experiment:
        errors, evidence = errors_of(experiment), None if result.truth.known else evidence_of(experiment)
    elif result.track.stopped_at is not None:
        return None
    else:
        errors, evidence = result.metrics.to_dict(), None if result.truth.known else result.evidence().to_dict()
    return None if errors is None else (evidence or {}) | errors


def figures_shown(*, known: bool) -> dict[str, Metric]:
    """The figures of the table; where the truth is not known those that need none come first."""
    if known:
        return METRICS
    return EVIDENCE | dict(sorted(METRICS.items(), key=lambda item: not item[0].startswith("innovation")))


def metric_rows(found: list[tuple[Candidate, Figures | None]], reference: int, *, known: bool) -> list[list[Any]]:
    """Per figure its title, and per filter its value with the change from the reference's below it."""
    base = next(figures for candidate, figures in found if candidate.slot == reference)
    rows: list[list[Any]] = []
    for name, metric in figures_shown(known=known).items():
        row: list[Any] = [metric.title]
        nowhere = all(figures is None or figures[name] is None for _, figures in found)
        for candidate, figures in found:
            value = None if figures is None else figures[name]
            change, tone = "", "same"
            if nowhere or len(found) == 1:
                pass
            elif candidate.slot == reference:
                change = "reference"
            elif figures is not None and base is not None:
                change, tone = change_text(metric, value, base[name])
            row.append([metric_text(metric, value), "same" if name in UNDIRECTED else tone, change])
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
    tables={NUMBERS: numbers},
    report=report,
    sliders=SLIDERS,
)
