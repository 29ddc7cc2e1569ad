"""The filter that a recording asks for, as a study of the page: computed once, beside whatever filter is set."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import Any
from urllib.parse import parse_qsl

from layouts.asked import Content
from layouts.questions import StudyQuestion
from layouts.state import Settings, from_query
from layouts.text import significant
from tracker_core import Experiment, InputError
from tracker_core.run import observe
from tracker_core.suggestion import Suggestion, suggest
from tracker_core.tuning import Progress

DIGITS = 6
"""Of the tracking index that is taken; its interval is far wider."""

NOISE_DIGITS = 4


@dataclass(frozen=True, slots=True)
class Suggesting:
    """The question which filter suits a recording.

    Attributes:
        experiment: the recording under the usual filter, which does not matter.
    """

    experiment: Experiment

    def stream(self, executor: Executor | None = None) -> Iterator[Progress[Suggestion | None]]:
        """The answer, when it is there."""
        del executor  # Not worth the way.
        yield Progress(0, 1, None)
        _, measurements, _ = observe(self.experiment)
        interval, axes = self.experiment.interval, self.experiment.target.axes
        yield Progress(1, 1, suggest(measurements, interval=interval, axes=axes))


def begin(question: StudyQuestion) -> tuple[Suggesting, Content]:
    """From the page's question to its study, and what the page shows of that.

    Raises:
        InputError: where there is no recording.
    """
    settings, _ = from_query(dict(parse_qsl(question.query)))
    experiment = settings.experiment
    if not experiment.target.measured:
        raise InputError("study", "needs a recording", experiment.scenario)
    values = {"data": experiment.data, "reading": experiment.reading, "samples": experiment.samples}
    return Suggesting(Experiment.from_dict(values)), partial(content, settings)


def content(settings: Settings, progress: Progress[Suggestion | None]) -> dict[str, Any]:
    """The suggestion: why, in sentences; the noise of every axis; and a button that takes the filter."""
    found = progress.outcome
    if found is None:
        return {}
    return {
        "texts": {"why": "\n".join(found.why).replace("σ_w", "σw")},
        "rows": {"estimates": noise_rows(found, settings.experiment.target.axes)},
        "offers": {"use": {"text": "Use this filter", "controls": controls_of(found)}},
    }


def controls_of(found: Suggestion) -> dict[str, Any]:
    """The controls of the filter and the sensor that are suggested."""
    values = found.values
    return {
        "order": str(values["order"]),
        "design": values["design"],
        "tracking_index": float(f"{values['tracking_index']:.{DIGITS}g}"),
        "start": values["start"],
        "noise_std": ", ".join(f"{std:.{NOISE_DIGITS}g}" for std in values["noise_std"]),
        "gate": "" if values["gate"] is None else values["gate"],
    }


def noise_rows(found: Suggestion, axes: tuple[str, ...]) -> list[list[str]]:
    """Per axis the noise of the sensor and of the manoeuvre."""
    chosen, unit = found.chosen, "m/s³" if found.chosen.order == 4 else "m/s²"
    return [
        [axis, f"{significant(sensor, 3)} m", f"{significant(process, 3)} {unit}"]
        for axis, sensor, process in zip(axes, chosen.sensor_std, chosen.process_std, strict=True)
    ]
