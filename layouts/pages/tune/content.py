"""What the Tune page shows of how far a study has come."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from math import isfinite
from typing import Any
from urllib.parse import parse_qsl

from layouts.figures.tuning.map import map_figure
from layouts.figures.tuning.sweep import sweep_figure
from layouts.pages.tune import words
from layouts.pages.tune.present import present_scores, present_value
from layouts.pages.tune.studies import Study, study_of
from layouts.state import Settings, from_query
from layouts.studies import Content
from layouts.theme import THEMES
from tracker_core import Experiment, Gains
from tracker_core.experiment import PARAMETERS
from tracker_core.tuning import PARAMETERS as VARIED
from tracker_core.tuning import Map, MapOutcome, Progress, Sweep, SweepOutcome
from tracker_core.tuning.evaluate import effective_runs
from tracker_core.types import GAIN_NAMES

PLOT = "tune-plot"
DIGITS = 5
"""Of an optimum that is taken; its interval leaves fewer certain."""

ROUNDING = 10
"""Digits of what belongs to it: gains that are held, a tracking index that follows."""


def begin(question: Mapping[str, Any]) -> tuple[Study, Content]:
    """From the page's question to its study, and what the page shows of that.

    Raises:
        InputError: naming the control, for what cannot be studied.
    """
    settings, _ = from_query(dict(parse_qsl(str(question["query"]))))
    theme = str(question.get("theme"))
    study = study_of(settings)
    return study, partial(content, study, settings, theme if theme in THEMES else THEMES[0])


def content(study: Study, settings: Settings, theme: str, progress: Progress[Any]) -> dict[str, Any]:
    """The study as it stands.

    Returns:
        `figures` by the id of their place, `texts` by name, and `offers`: what a button says and the controls it sets.
    """
    complete = progress.done >= progress.of
    shown = _sweep if isinstance(study, Sweep) else _map
    texts, offers, figure = shown(study, settings, theme, progress.outcome, complete)  # type: ignore[arg-type]
    wanted = effective_runs(study.experiment, study.objective, study.runs)
    runs = words.runs_text(min(progress.outcome.runs, wanted), wanted)
    return {
        "figures": {PLOT: figure},
        "texts": {"best": "", "cost": "", "runs": runs, **texts},
        "offers": {"use": None, **offers},
    }


Shown = tuple[dict[str, str], dict[str, Any], dict[str, Any]]


def _sweep(study: Sweep, settings: Settings, theme: str, outcome: SweepOutcome, complete: bool) -> Shown:
    experiment, best = settings.experiment, outcome.optimum()
    figure = sweep_figure(outcome, theme, present_value(experiment, study.parameter))
    said = words.best_value_text(outcome)
    if not isfinite(best.value):
        return {"best": said}, {}, figure
    texts = {"best": f"{said}."}
    if complete:
        present = present_scores(study, experiment)
        texts["best"] = f"{said}{words.gain_text(outcome.scores[0][:, best.index], present)}."
    if len(study.objectives) > 1:
        texts["cost"] = words.cost_text(_values(outcome), outcome.cost(0, 1), outcome.runs)
    return texts, {"use": _offer(study.at(float(f"{best.value:.{DIGITS}g}")), settings)}, figure


def _values(outcome: SweepOutcome) -> list[str]:
    """The best values by each objective, in words."""
    parameter, found = VARIED[outcome.sweep.parameter], []
    for row in range(2):
        best = outcome.optimum(row)
        value, *_ = words.number(best.value, best.low, best.high)
        found.append(f"{words.symbol_of(parameter.name)} = {value} {parameter.unit}".rstrip())
    return found


def _map(study: Map, settings: Settings, theme: str, outcome: MapOutcome, complete: bool) -> Shown:
    figure, best = map_figure(study, outcome, theme), outcome.best()
    if best is None:
        return {"best": "In no cell all runs went to the end."}, {}, figure
    gains = study.at(outcome.vectors[best])
    said = f"Best cell: {words.gains_text(gains)}: {words.score_text(study.objective, outcome.score(best))}"
    if complete:
        scores = outcome.scores[0][:, best]
        said += words.gain_text(scores, present_scores(study, settings.experiment))
    near = int(outcome.near_best().sum())
    if near > 1:
        said += f". Outlined: the {near:,} cells that {outcome.runs:,} runs do not show to be worse"
    texts = {"best": f"{said}."}
    if len(study.objectives) > 1:
        found = [
            words.gains_text(study.at(outcome.vectors[cell]))
            for row in range(2)
            if (cell := outcome.best(row)) is not None
        ]
        if len(found) > 1:
            texts["cost"] = words.cost_text(found, outcome.cost(0, 1), outcome.runs)
    return texts, {"use": {"text": "Use this", "controls": gains_controls(gains)}}, figure


def gains_controls(gains: Gains) -> dict[str, Any]:
    """The controls of a filter by hand."""
    values = (float(f"{value:.{DIGITS}g}") for value in gains.values)
    return {"design": "manual", **dict(zip(GAIN_NAMES, values, strict=False))}


def _offer(best: Experiment, settings: Settings) -> dict[str, Any]:
    """A button that takes a filter; a design as it is already need not be chosen again."""
    design = {} if best.design == settings.experiment.design else {"design": best.design}
    given = {name: getattr(best, name) for name in PARAMETERS if getattr(best, name) is not None}
    values = {name: float(f"{value:.{ROUNDING}g}") for name, value in given.items()}
    return {"text": "Use this", "controls": design | values}
