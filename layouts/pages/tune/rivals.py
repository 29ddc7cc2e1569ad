"""What a search has found beside every design at its best, and beside the present filter."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from layouts.pages.tune import words
from layouts.pages.tune.present import scores_in
from layouts.pages.tune.studies import by_hand
from layouts.text import significant
from tracker_core import Experiment, Gains
from tracker_core.fields import FIELDS
from tracker_core.statistics import Interval, mean_interval, percent_more
from tracker_core.tuning import SearchOutcome
from tracker_core.types import GAIN_NAMES

HEAD = ["", "gains", "in the search (m)", "in fresh runs (m)", "more than found (%)", "Take"]
DIGITS = 5
"""Of gains that are taken: runs leave fewer certain."""


def gains_controls(gains: Gains) -> dict[str, Any]:
    """The controls of a filter by hand."""
    values = (float(f"{value:.{DIGITS}g}") for value in gains.values)
    return {"design": "manual", **dict(zip(GAIN_NAMES, values, strict=False))}


def rival_rows(outcome: SearchOutcome, present: Experiment) -> list[list[Any]]:
    """A row for the found gains, for every design, the best first, and for the present filter."""
    if outcome.gains is None or not outcome.rivals:
        return []
    search, fresh, convention = outcome.search, outcome.fresh, outcome.gains.convention
    found = _cells(outcome.gains, outcome.score, fresh.score if fresh else None, None)
    rows = [["Found", *found, use("the found gains", gains_controls(outcome.gains))]]
    for number in np.argsort([rival.score for rival in outcome.rivals], kind="stable"):
        rival = outcome.rivals[number]
        gains = Gains.normalised(np.array(rival.vector)).to(convention)
        seen = (fresh.rivals[number], fresh.percents[number]) if fresh else (None, _only(outcome, rival.score))
        title = f"{rival.title}, {FIELDS[rival.parameter].symbol} = {significant(rival.value, 3)}"
        controls = {"design": rival.design, rival.parameter: float(f"{rival.value:.{DIGITS}g}")}
        rows.append([title, *_cells(gains, rival.score, *seen), use(rival.title, controls)])
    if fresh and (own := _present(outcome, present)) is not None:
        rows.append(["Present", *_cells(present.gains(), None, *own), ""])
    elif not outcome.search.compared and (scores := scores_in(search.experiment, search, 1, present)) is not None:
        score = float(scores[0])
        rows.append(["Present", *_cells(present.gains(), score, None, _only(outcome, score)), ""])
    return rows


def _only(outcome: SearchOutcome, score: float) -> Interval | None:
    """How many percent more a filter has where there is one run only; None where fresh runs are to tell."""
    if outcome.search.compared or not outcome.score:
        return None
    return Interval(100 * (score / outcome.score - 1), float("nan"), float("nan"))


def use(name: str, controls: dict[str, Any]) -> dict[str, Any]:
    """A cell with a button that takes a filter."""
    return {"text": "Use this", "label": f"Use {name}", "controls": controls}


def _cells(gains: Gains, score: float | None, fresh: Interval | None, more: Interval | None) -> list[Any]:
    gains_said = ", ".join(significant(value, 3) for value in gains.values)
    worse = more is not None and more.low > 0
    return [
        gains_said, "" if score is None else significant(score, 4), _interval_text(fresh),
        [_interval_text(more, 2), "bad" if worse else ""],
    ]  # fmt: skip


def _interval_text(interval: Interval | None, digits: int = 0) -> str:
    if interval is None:
        return ""
    low, high = interval.low, interval.high
    mean, least, most = (significant(part, digits) for part in (interval.mean, low, high))
    if not digits:
        mean, least, most = words.number(interval.mean, low, high)
    return f"{mean} ({least} to {most})" if isfinite(low) else mean


def _present(outcome: SearchOutcome, present: Experiment) -> tuple[Interval, Interval] | None:
    """Score of the present filter in the fresh runs, and how many percent more that is than the found gains have."""
    search, fresh = outcome.search, outcome.fresh
    if outcome.gains is None or fresh is None:
        return None
    runs_of = replace(search.experiment, seed=search.experiment.seed + search.drawn)
    values = dict(zip(GAIN_NAMES, outcome.gains.values, strict=False))
    scores = scores_in(runs_of, search, fresh.runs, by_hand(search.experiment, values), present)
    if scores is None:
        return None
    found, own = scores.reshape(2, -1)
    mean, width = map(float, mean_interval(own))
    return Interval(mean, mean - width, mean + width), percent_more(own, found)
