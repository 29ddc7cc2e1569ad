"""What the Tune page shows of how far a study has come."""

from __future__ import annotations

from functools import partial
from math import isfinite
from typing import Any
from urllib.parse import parse_qsl

from layouts.asked import Content
from layouts.figures.common import Figure
from layouts.figures.tuning.map import map_figure
from layouts.figures.tuning.search import search_figure
from layouts.figures.tuning.sweep import sweep_figure
from layouts.pages.tune import numbers, words
from layouts.pages.tune.present import present_scores, present_value
from layouts.pages.tune.rivals import DIGITS, gains_controls, rival_rows
from layouts.pages.tune.studies import Study, study_of
from layouts.questions import StudyQuestion
from layouts.state import Settings, from_query
from tracker_core import Experiment
from tracker_core.experiment import PARAMETERS
from tracker_core.tuning import Map, MapOutcome, Optimum, Progress, Search, SearchOutcome, Sweep, SweepOutcome
from tracker_core.tuning.base import knows_truth
from tracker_core.tuning.evaluate import effective_runs
from tracker_core.types import FloatArray

PLOT = "tune-plot"

ROUNDING = 10
"""Digits of what belongs to an optimum: gains that are held, a tracking index that follows."""

Said = tuple[dict[str, str], dict[str, Any] | None]
"""Texts by name, and the controls of the best filter."""


def begin(question: StudyQuestion) -> tuple[Study, Content]:
    """From the page's question to its study, and what the page shows of that.

    Raises:
        InputError: naming the control, for what cannot be studied.
    """
    settings, _ = from_query(dict(parse_qsl(question.query)))
    study = study_of(settings)
    return study, partial(content, study, settings, question.theme)


def content(study: Study, settings: Settings, theme: str, progress: Progress[Any]) -> dict[str, Any]:
    """The study as it stands.

    Returns:
        `figures` by the id of their place, `texts` by name, `rows` of tables: of the rivals in a search and of what
        the plot shows, and `offers`: what a button says and the controls that it sets.
    """
    outcome, complete = progress.outcome, progress.done >= progress.of
    rows: dict[str, list[list[Any]]] = {name: [] for name in ("rivals", *numbers.TABLES)}
    figure: Figure
    if isinstance(study, Sweep):
        # Drawing the runs anew takes its time.
        best = outcome.optimum()
        figure = sweep_figure(outcome, best, theme, present_value(settings.experiment, study.parameter))
        rows["told-values"] = numbers.value_rows(outcome, best)
        texts, controls = _sweep(study, settings, outcome, best, complete=complete)
    elif isinstance(study, Map):
        figure = map_figure(study, outcome, theme)
        rows["told-cells"] = numbers.cell_rows(study, outcome)
        texts, controls = _map(study, settings, outcome, complete=complete)
    else:
        figure = search_figure(outcome, theme)
        rows |= {
            "rivals": rival_rows(outcome, settings.experiment),
            "told-generations": numbers.generation_rows(outcome),
        }
        texts, controls = _search(settings, outcome, complete=complete)
    return {
        "figures": {PLOT: figure},
        "texts": {"best": "", "cost": "", "runs": _runs(study, outcome), **texts},
        "rows": rows,
        "offers": {"use": None if controls is None else {"text": "Use this", "controls": controls}},
    }


def _runs(study: Study, outcome: Any) -> str:
    if isinstance(study, Search):
        return f"{outcome.tried:,} of at most {study.budget:,} gain sets"
    wanted = effective_runs(study.experiment, study.objective, study.runs)
    return words.runs_text(min(outcome.runs, wanted), wanted)


def _sweep(study: Sweep, settings: Settings, outcome: SweepOutcome, best: Optimum, *, complete: bool) -> Said:
    said = words.best_value_text(study, best, complete=complete)
    if not isfinite(best.value):
        return {"best": said}, None
    if complete:
        said += _gain(study, settings, outcome.scores[0][:, best.index], "value")
    texts = {"best": f"{said}."}
    if len(study.objectives) > 1:
        found = [words.value_text(study, each) for each in (best, outcome.optimum(1))]
        texts["cost"] = words.cost_text(found, outcome.cost(0, 1), outcome.runs)
    at = study.at(float(f"{best.value:.{DIGITS}g}"))
    return texts, design_controls(at, settings.experiment)


def _map(study: Map, settings: Settings, outcome: MapOutcome, *, complete: bool) -> Said:
    best, ranges = outcome.best(), outcome.near_ranges()
    if best is None or ranges is None:
        return {"best": "In no cell all runs went to the end."}, None
    gains = study.at(outcome.vectors[best])
    place = words.gains_text(gains, dict(zip(study.plane, ranges, strict=True)))
    score = words.score_text(study.objective, outcome.score(best))
    said = f"{words.best_word('Best cell', complete=complete)}: {place}: {score}"
    if complete:
        said += _gain(study, settings, outcome.scores[0][:, best], "cell")
    near = int(outcome.near_best().sum())
    if near > 1:
        said += f". Outlined: the {near:,} cells that {outcome.runs:,} runs do not show to be worse"
    texts = {"best": f"{said}."}
    knowing = outcome.best(1) if len(study.objectives) > 1 else None
    if knowing is not None:
        found = [words.gains_text(study.at(outcome.vectors[cell])) for cell in (best, knowing)]
        texts["cost"] = words.cost_text(found, outcome.cost(0, 1), outcome.runs)
    return texts, gains_controls(gains)


def _gain(study: Sweep | Map, settings: Settings, best: FloatArray, what: str) -> str:
    """How much better the best filter is than the present one; `best` has its scores, shape (runs,)."""
    chance = effective_runs(study.experiment, study.objective, 2) > 1
    return words.gain_text(best, present_scores(study, settings.experiment), what, chance=chance)


def _search(settings: Settings, outcome: SearchOutcome, *, complete: bool) -> Said:
    if outcome.gains is None:
        return {"best": "The designs are tried."}, None
    texts = {"best": words.found_text(outcome, complete=complete)}
    if settings.view.tuning.without_truth and knows_truth(settings.experiment):
        texts["cost"] = "What not knowing the truth costs is told where one parameter or two gains are varied."
    return texts, gains_controls(outcome.gains)


def design_controls(best: Experiment, present: Experiment) -> dict[str, Any]:
    """The controls of a filter; a design as it is already need not be chosen again."""
    design = {} if best.design == present.design else {"design": best.design}
    given = {name: getattr(best, name) for name in PARAMETERS if getattr(best, name) is not None}
    return design | {name: float(f"{value:.{ROUNDING}g}") for name, value in given.items()}
