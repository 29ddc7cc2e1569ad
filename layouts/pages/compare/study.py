"""The Compare page's study: the same filters over many seeds, what each comes to and which differences are real."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import floor, isnan, log10
from typing import Any
from urllib.parse import parse_qsl

from layouts.comparing import CHOICES, PRESENT
from layouts.figures.forest import Entry, forest_figure
from layouts.pinned import Candidate, candidates, reference_of
from layouts.questions import StudyQuestion
from layouts.state import Settings, from_query
from layouts.text import metric_text, significant
from tracker_core import METRICS
from tracker_core.metrics import Metric
from tracker_core.statistics import Interval
from tracker_core.tuning import Comparison, MonteCarlo, Progress
from tracker_core.tuning.monte_carlo import FIGURES, Difference


def begin(question: StudyQuestion) -> tuple[MonteCarlo, partial[dict[str, Any]]]:
    """The study that a link asks for, and what the page shows of it.

    Raises:
        InputError: for what cannot be run.
    """
    settings, _ = from_query(dict(parse_qsl(question.query)))
    filters = [candidate for candidate in candidates(settings) if candidate.experiment is not None]
    experiments = tuple(candidate.experiment for candidate in filters if candidate.experiment is not None)
    study = MonteCarlo(experiments, settings.view.comparing.runs)
    return study, partial(content, settings, filters, question.theme)


def content(settings: Settings, filters: list[Candidate], theme: str, progress: Progress[Comparison]) -> dict[str, Any]:
    """The forest plot, the table and the sentence above it; what is significant is said with the last run only.

    Looking again and again until something is significant finds something sooner or later: the confidence holds for
    a number of runs fixed beforehand.

    Args:
        settings: of the page.
        filters: those that are run, in the study's order.
        theme: of the plot.
        progress: of the study.
    """
    outcome, slot = progress.outcome, reference_of(settings)
    reference = [candidate.slot for candidate in filters].index(slot)
    figure, final = settings.view.comparing.figure, progress.done >= progress.of
    forest = partial(forest_figure, reference=called(filters[reference]), theme=theme, final=final)
    entries = [
        Entry(candidate.slot, called(candidate), outcome.difference(figure, number, reference))
        for number, candidate in enumerate(filters)
        if number != reference
    ]
    return {
        "figures": {"compare-forest": forest(entries, METRICS[figure])},
        "texts": {"runs-text": runs_text(settings, outcome, filters[reference], final=final)},
        "rows": {"over-runs": rows(outcome, filters, reference, final=final)},
        "columns": {"over-runs": columns(filters)},
    }


def columns(filters: Sequence[Candidate]) -> list[tuple[int, str]]:
    """Per column of the table its slot, and which filter was run in it; empty for none.

    The page has a column for every filter there can be, and shows those that there are: meanwhile other ones, perhaps.
    """
    keys = {candidate.slot: candidate.key for candidate in filters}
    return [(slot, keys.get(slot, "")) for slot in CHOICES]


def called(candidate: Candidate) -> str:
    """How a filter is spoken of."""
    return "Present" if candidate.slot == PRESENT else candidate.name


def runs_text(settings: Settings, outcome: Comparison, reference: Candidate, *, final: bool) -> str:
    """What the figures are made of, and what significant means here, in plain words."""
    first = settings.experiment.seed
    others = outcome.filters - 1
    text = f"{outcome.runs:,} runs, seeds {first:,} to {first + outcome.runs - 1:,}"
    if not final:
        text += ", so far; verdicts come with the last run" if others else ", so far"
    text += ". Means with their 95 % intervals."
    if not others:
        return f"{text} Pin a filter to see differences."
    text += f" Below each: its difference to {called(reference)} in the same runs, run by run."
    if not final:
        return text
    text += " It is called significant where zero lies outside its interval"
    if others == 1:
        return f"{text}, which has 95 %."
    level = significant(100 - 5 / others, 3)
    return (
        f"{text}; the intervals are widened to {level} % each, so that all {others} comparisons of a row are right "
        "together with 95 % (Bonferroni)."
    )


def rows(outcome: Comparison, filters: list[Candidate], reference: int, *, final: bool) -> list[list[Any]]:
    """Per metric its title, and per slot its mean with the difference below it; last the runs that were stopped.

    Args:
        outcome: of the study.
        filters: those of the study.
        reference: number of the one the others are compared with.
        final: whether the last run is in.
    """
    number = {candidate.slot: place for place, candidate in enumerate(filters)}
    table: list[list[Any]] = []
    for name in FIGURES:
        metric = METRICS[name]
        row: list[Any] = [metric.title]
        for slot in CHOICES:
            place = number.get(slot)
            if place is None:
                row.append(["–", "", ""])
                continue
            below, tone = "", "same"
            if len(filters) > 1:
                below, tone = "reference", "same"
                if place != reference:
                    below, tone = difference_text(outcome.difference(name, place, reference), metric, final=final)
            row.append([mean_text(outcome.own(name, place), metric), tone, below])
        table.append(row)
    stopped = [number.get(slot) for slot in CHOICES]
    table.append(["Stopped runs", *("–" if place is None else f"{int(outcome.stopped[place]):,}" for place in stopped)])
    return table


def mean_text(interval: Interval, metric: Metric) -> str:
    """A mean, to the digits that its interval leaves it, and how far that reaches to both sides."""
    if isnan(interval.mean):
        return "–"
    half = (interval.high - interval.low) / 2
    if not half > 0:
        return metric_text(metric, interval.mean)
    digits = max(0, 1 - floor(log10(half)))
    mean = f"{interval.mean:,.{min(digits, 12)}f}".replace("-", "−")
    return f"{mean} ± {significant(half, 2)} {metric.unit}".rstrip()


def difference_text(difference: Difference, metric: Metric, *, final: bool) -> tuple[str, str]:
    """A difference with its interval and, with the last run, whether it is more than chance; and its tone."""
    in_percent = metric.unit != "%" and not isnan(difference.percent.mean)
    interval, unit = (difference.percent, "%") if in_percent else (difference.interval, metric.unit)
    if isnan(interval.low):
        return "–", "same"
    text = f"{signed(interval.mean)} {unit} ({signed(interval.low)} to {signed(interval.high)})"
    if not final:
        return text, "same"
    if not difference.significant:
        return f"{text}\nnot significant", "same"
    better = (difference.interval.mean < 0) == metric.lower_is_better
    return f"{text}\nsignificant", "better" if better else "worse"


def signed(value: float) -> str:
    """A number with its sign."""
    text = significant(value, 3)
    return f"+{text}" if value > 0 else text
