"""M4 of Al-Wagih & Abdulla: alpha chosen anew by the innovations of the last samples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tracker_core.adaptive.base import Draft, Method, Problem, Selection, Shape, check_work
from tracker_core.checks import InputError


def rule(shape: Shape, parameters: Mapping[str, Any]) -> None:
    """The window must fit into the run, and the searches into a few seconds."""
    window = parameters["window"]
    if window >= shape.samples:
        raise InputError("window", f"must be < {shape.samples:,}, the number of samples", window)
    tried = parameters["levels"] * (parameters["refinements"] + 1)
    check_work("window", window, shape.samples * shape.axes * window * tried // parameters["step"])


def work(
    problem: Problem, *, fixed_alpha: float, window: int, step: int, levels: int, refinements: int, criterion: str
) -> Selection:
    """See `kernels.window_search`."""
    from tracker_core import kernels  # compiled code is loaded when the first filter runs

    draft, setting = Draft.of(problem), problem.setting
    for axis in range(problem.shape[1]):
        state, begin = draft.begin(axis)
        draft.stops.append(
            kernels.window_search(
                setting.column(axis), setting.dt, fixed_alpha, window, step, levels, refinements,
                criterion == "mean-absolute", state, begin, setting.limit,
                draft.predicted[axis], draft.smoothed[axis], draft.used[axis],
            )
        )  # fmt: skip
    return draft.selection()


METHOD = Method(
    name="moving-window",
    title="Moving window (M4)",
    orders=(2,),
    parameters={
        "fixed_alpha": 0.05, "window": 20, "step": 1, "levels": 20, "refinements": 1, "criterion": "mean-square",
    },
    work=work,
    rule=rule,
    sentence="Begins with α₀; then the last W samples are filtered again with every α of a grid, and the one with the "
    "least innovations serves the samples to come. β = α²/(2 − α).",
    source="Al-Wagih & Abdulla, algorithm 2, method M4",
)  # fmt: skip
