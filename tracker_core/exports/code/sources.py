"""The source files of a tuned filter, from templates and what each language writes in its own way."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tracker_core.exports.code.head import begin_sentence, head, leaves
from tracker_core.exports.code.template import comment, render
from tracker_core.exports.code.tuned import TunedFilter
from tracker_core.gating import DOUBT, PATIENCE
from tracker_core.types import HANDOVER, FloatArray


@dataclass(frozen=True, slots=True)
class Language:
    """How a language writes.

    Attributes:
        prefix: of the lines of a comment.
        missing: the number that is none.
        row: brackets of a list of numbers.
        line: brackets of such a list within a table.
        table: brackets of a table.
        comma: between the lines of a table.
        first: what the language counts from.
    """

    prefix: str
    missing: str
    row: tuple[str, str]
    line: tuple[str, str]
    table: tuple[str, str]
    comma: str
    first: int = 0

    def number(self, value: float) -> str:
        """A number with all its digits."""
        return self.missing if value != value else repr(float(value))

    def numbers(self, values: Iterable[float]) -> str:
        """A list of few numbers."""
        return ", ".join(self.number(value) for value in values).join(self.row)

    def rows(self, values: FloatArray) -> str:
        """A table, a line for each row; of shape (n,) one number a line."""
        brackets = self.line if values.ndim == 2 else ("", "")
        lines = [", ".join(map(self.number, row)).join(brackets) for row in values.reshape(len(values), -1).tolist()]
        inner = f"{self.comma}\n".join("    " + line for line in lines)
        return f"\n{inner}\n".join(self.table) if lines else "".join(self.table)


PYTHON = Language("# ", "nan", ("[", "]"), ("[", "]"), ("[", "]"), ",")
C = Language("   ", "NAN", ("{", "}"), ("{", "}"), ("{", "}"), ",")
MATLAB = Language("% ", "NaN", ("[", "]"), ("", ""), ("[", "]"), ";", first=1)

FILES: dict[str, tuple[Language, str]] = {
    "tuned_filter.py": (PYTHON, "The filter in Python, without any package. Self-test: python tuned_filter.py"),
    "tuned_filter.c": (
        C,
        "The filter in C99. Self-test: cc -std=c99 -DSELF_TEST tuned_filter.c -o self_test -lm && ./self_test",
    ),
    "tuned_filter.h": (C, "What a program that uses the filter in C includes."),
    "tuned_filter.m": (MATLAB, "The filter for MATLAB and Octave."),
    "tuned_filter_test.m": (
        MATLAB,
        "Its self-test: octave-cli tuned_filter_test.m, or tuned_filter_test in MATLAB.",
    ),
    "filterpy_filter.py": (
        PYTHON,
        "The filter as a configuration of FilterPy's KalmanFilter. Self-test: python filterpy_filter.py",
    ),
}
"""The files, the language of each, and what it is."""


def sources(tuned: TunedFilter) -> dict[str, str]:
    """The text of every file in FILES, by name."""
    facts = _facts(tuned)
    texts = {name: render(f"{name}.in", _parts(tuned, language, facts), facts) for name, (language, _) in FILES.items()}
    # What was left out may leave a gap.
    return {name: re.sub(r"\n{4,}", "\n\n\n", text) for name, text in texts.items()}


def _facts(tuned: TunedFilter) -> dict[str, bool]:
    """What the templates ask of a filter."""
    gate, points = tuned.gate is not None, tuned.points
    # The gate needs to know how wrong a state is that began with fewer measurements.
    beside = gate and 0 < points < tuned.gains.order
    return {
        "gate": gate,
        "known": tuned.start == "known",
        # The start: one measurement, several, or least squares from several on.
        "first": points == 1,
        "several": points > 1,
        "waiting": points > 1 and not tuned.growing,
        "growing": tuned.growing,
        # Least squares beside the filter; either kind of it; measurements that are kept for one or for the start.
        "beside": beside,
        "learning": beside or tuned.growing,
        "collecting": beside or points > 1,
        # The covariance of a start, and one that moves.
        "covariance": points > 1 and (tuned.growing or (gate and not beside)),
        "covariances": gate or tuned.growing,
    }


def _parts(tuned: TunedFilter, language: Language, facts: Mapping[str, bool]) -> dict[str, str]:
    """What is filled in."""
    order, gate, trial = tuned.gains.order, tuned.gate, tuned.trial
    number, row = language.number, language.row
    powers = ["1.0", "t", "t * t / 2", "t * t * t / 6"]
    divisors = ["", " / t", " / (t * t)", " / (t * t * t)"]
    drive = {2: [2, 1], 3: [2, 1, 0], 4: [3, 2, 1, 0]}[order]
    parts = {
        "head": comment(head(tuned), language.prefix),
        "leaves": comment(leaves(tuned), ""),
        "begin_sentence": begin_sentence(tuned),
        "imports": ", hypot, sqrt" if facts["beside"] else ", sqrt" if gate else "",
        "axes": str(len(tuned.axes)),
        "order": str(order),
        "points": str(tuned.points),
        "points_constant": f",\n    TUNED_FILTER_POINTS = {tuned.points}" if tuned.points > 1 else "",
        "kept": "ORDER" if facts["beside"] else "POINTS",
        "points_alias": ", POINTS = TUNED_FILTER_POINTS" if tuned.points > 1 else "",
        "interval": number(tuned.interval),
        "limit": number(tuned.limit),
        "gains": language.numbers(tuned.gains.vector),
        "move": ", ".join(powers[:order]).join(row),
        "gain": ", ".join(f"GAINS[{i}]{divisors[i]}" for i in range(order)).join(row),
        "drive": (", " if language.first == 0 else "; ").join(powers[i] for i in drive).join(row),
        "power": "NOISE_INTERVAL / t" if order == 2 else "t / NOISE_INTERVAL",
        "handover": number(HANDOVER),
        "alpha": ", GAINS(1)" if facts["learning"] else "",
        "first_interval": " The first one is that since the initial state." if tuned.start == "known" else "",
        "trial": str(len(trial.intervals)),
        "trial_intervals": language.rows(trial.intervals),
        "trial_measured": language.rows(trial.measured),
        "trial_smoothed": language.rows(trial.smoothed),
        "state": language.rows(trial.state),
        "onward_intervals": language.rows(trial.onward_intervals),
        "onward_measured": language.rows(trial.onward),
        "onward_smoothed": language.rows(trial.onward_smoothed),
    }
    if tuned.initial_state is not None:
        parts["initial_state"] = language.rows(tuned.initial_state)
    if gate is not None:
        parts |= {
            "width": number(gate.width),
            "sensor_std": language.numbers(gate.stds(len(tuned.axes))),
            "noise_variance": number(gate.noise_variance(order)),
            "noise_interval": number(gate.interval),
            "patience": str(PATIENCE),
            "doubt": number(DOUBT),
        }
    return parts
