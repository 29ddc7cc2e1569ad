"""What a study has found, in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import floor, isfinite, log10

import numpy as np

from layouts.figures.tuning.look import name_of
from layouts.text import significant
from tracker_core import Gains, Result
from tracker_core.conventions import rewrite
from tracker_core.fields import FIELDS
from tracker_core.statistics import Interval, percent_more
from tracker_core.tuning import PARAMETERS, Optimum, SearchOutcome, Sweep
from tracker_core.tuning.base import has_chance
from tracker_core.types import GAIN_NAMES, FloatArray

NOTHING = 0.05
"""A change of fewer percent is none."""


SAME = 1e-9
"""Scores of designs that differ by less are those of the same filter."""


def runs_text(complete: int, wanted: int) -> str:
    """How many runs are in what is shown."""
    if complete < wanted:
        return f"{complete:,} of {wanted:,} runs"
    return "1 run" if wanted == 1 else f"{wanted:,} runs"


def number(value: float, low: float, high: float) -> tuple[str, str, str]:
    """A number and its interval, with as many digits as the interval leaves certain, and one more."""
    digits = 4
    if isfinite(low) and high > low and value:
        digits = min(7, max(3, floor(log10(abs(value))) - floor(log10(high - low)) + 2))
    return significant(value, digits), significant(low, digits), significant(high, digits)


def symbol_of(parameter: str) -> str:
    """The symbol of a parameter in plain text."""
    return PARAMETERS[parameter].symbol.replace("_", "")


def score_text(objective: str, score: Interval) -> str:
    """An objective with its interval."""
    mean, low, high = number(score.mean, score.low, score.high)
    name = name_of(objective)
    said = f"{name[0].lower()}{name[1:]} {mean} m"
    return f"{said} ({low} to {high})" if isfinite(score.low) else said


def best_value_text(sweep: Sweep, best: Optimum, *, complete: bool) -> str:
    """The best value of a sweep with its interval, and the score there."""
    if not isfinite(best.value):
        return "No value that was looked at gives a stable filter whose runs went to the end."
    _, low, high = number(best.value, best.low, best.high)
    said = f"{best_word('Best', complete=complete)}: {value_text(sweep, best)}"
    said += f" (95 %: {low} to {high})" if isfinite(best.low) and best.high > best.low else ""
    if best.at_edge:
        side = "first" if best.index == 0 else "last"
        said += f", the {side} value that was looked at"
    return f"{said}: {score_text(sweep.objective, best.score)}"


def best_word(word: str, *, complete: bool) -> str:
    """What the best is called: while a study runs nothing is so for good."""
    return word if complete else f"{word} so far"


def value_text(sweep: Sweep, best: Optimum) -> str:
    """The best value of a sweep."""
    value, *_ = number(best.value, best.low, best.high)
    return at_text(sweep, value)


def at_text(sweep: Sweep, value: str) -> str:
    """A value of a sweep with its symbol and its unit."""
    unit = PARAMETERS[sweep.parameter].unit_at(sweep.experiment.order)
    return f"{symbol_of(sweep.parameter)} = {value} {unit}".rstrip()


def found_text(outcome: SearchOutcome, *, complete: bool) -> str:
    """The gains that a search has found, and at its end what they are worth where nothing was chosen by."""
    search, gains = outcome.search, outcome.gains
    if gains is None:
        return ""
    score, fresh = Interval(outcome.score, float("nan"), float("nan")), outcome.fresh
    if not complete:
        return f"Best so far: {gains_text(gains)}: {score_text(search.objective, score)}."
    if fresh is None:
        return f"Best: {gains_text(gains)}: {score_text(search.objective, score)}."
    runs = runs_text(fresh.runs, fresh.runs).replace("run", "fresh run")
    said = f"Best: {gains_text(gains)}: {score_text(search.objective, fresh.score)} in {runs}"
    rival, kalman = outcome.best_rival, outcome.kalman
    if rival is None:
        return f"{said}."
    if kalman is not None and outcome.rivals[kalman].score <= outcome.rivals[rival].score * (1 + SAME):
        # Of designs that draw the same curve the one whose name says what it is.
        rival = kalman
    more, title = fresh.percents[rival], outcome.rivals[rival].title
    if not fresh.worse(rival):
        return f"{said}. The best design, {title}, is not shown to be worse."
    interval = f" ({significant(more.low, 2)} to {significant(more.high, 2)})"
    return f"{said}. The best design, {title}, has {significant(more.mean, 2)} %{interval} more."


def data_note(result: Result) -> str:
    """What must be known of the target's data to read a study on them; empty where everything is as usual."""
    experiment, unknown = result.experiment, np.asarray(np.isnan(result.truth.positions).any(axis=1))
    said = []
    if not result.truth.known:
        said.append(
            "Nobody knows where this target really was: filters are tuned on what they see, the innovations, and the "
            "least innovation need not be the least error."
        )
    elif unknown.any():
        known, samples = int((~unknown).sum()), len(unknown)
        said.append(f"The truth is known at {known:,} of {samples:,} samples; errors at the others do not count.")
    if not has_chance(experiment):
        run = "One recording" if experiment.target.measured else "Every seed gives the same run"
        said.append(f"{run}: there is no second run to compare with, and so no interval of any score.")
    if result.measurements.interval is None:
        middle = significant(experiment.interval, 4)
        said.append(f"The intervals vary: where T counts, as in Λ and the variances, it is the middle one, {middle} s.")
    if experiment.gate is not None:
        said.append("What the present filter's gate refuses is left out for all filters: they see the same data.")
    return " ".join(said)


def gains_text(gains: Gains, ranges: Mapping[str, tuple[float, float]] | None = None) -> str:
    """Gains in their convention, with the range of those that have one (normalised)."""
    said = []
    for index, (name, value) in enumerate(zip(GAIN_NAMES, gains.values, strict=False)):
        text = significant(value, 3)
        if ranges and name in ranges:
            low, high = (rewrite(end, index, "normalised", gains.convention) for end in ranges[name])
            text, least, most = number(value, low, high)
            text += f" ({least} to {most})"
        said.append(f"{FIELDS[name].symbol} = {text}")
    return ", ".join(said)


def gain_text(best: FloatArray, present: FloatArray | None, what: str, *, chance: bool) -> str:
    """How much less the best filter has than the present one, in percent, with the interval of the paired runs.

    Args:
        best, present: their scores in the same runs, shape (runs,).
        what: "value" or "cell", of which the best was chosen.
        chance: whether other runs would give other scores; of a single one nothing is told then.
    """
    if present is None or len(present) != len(best) or (chance and len(best) == 1):
        return ""
    more = percent_more(best, present)
    mean = -more.mean
    if not isfinite(mean):
        return ""
    width = more.high - more.mean if chance else 0.0
    if abs(mean) + width < NOTHING:
        return f", the same as with the present gains within {NOTHING} %"
    share, less = _share_text(mean, width), "less" if mean > 0 else "more"
    if mean <= width:
        shown = "shown to be " if chance else ""
        return f". No {what} is {shown}better than the present filter: the best one has {share} {less}"
    return f", {share} less than with the present gains" + (" in the runs it was chosen by" if chance else "")


def _share_text(mean: float, width: float) -> str:
    """A change in percent, whichever way it goes, with its interval where it has one."""
    interval = f" ({significant(abs(mean) - width, 2)} to {significant(abs(mean) + width, 2)})" if width else ""
    return f"{significant(abs(mean), 2)} %{interval}"


def cost_text(found: Sequence[str], cost: Interval, runs: int) -> str:
    """What not knowing the truth costs.

    Args:
        found: what is best without and with the truth, in words.
        cost: percent of the judge's own best; NaN where that is zero.
        runs: in which both were tried.
    """
    blind, knowing = found
    if blind == knowing:
        return "Tuned on the truth it would be the same: not knowing the truth costs nothing here."
    said = f"Tuned on the truth it would be {knowing}"
    if not isfinite(cost.mean):
        return f"{said}, with no estimation error left: no percentage says what not knowing it costs."
    if abs(cost.mean) < NOTHING:
        return f"{said}; not knowing it costs next to nothing: less than {NOTHING} % of estimation RMSE."
    interval = (
        f" ({significant(cost.low, 2)} to {significant(cost.high, 2)})" if runs > 1 and isfinite(cost.low) else ""
    )
    return f"{said}; not knowing it costs {significant(cost.mean, 2)} %{interval} of estimation RMSE."
