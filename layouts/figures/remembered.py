"""What figures need to know of a target and its measurements, remembered while the gains move."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from functools import update_wrapper
from typing import Any, Concatenate, ParamSpec, TypeVar

from tracker_core import Result
from tracker_core.run import CACHED_TARGETS
from tracker_core.types import FloatArray

P = ParamSpec("P")
T = TypeVar("T")

TARGETS = CACHED_TARGETS
"""As many as the core remembers: one that it draws anew has other arrays."""

MOST_SAMPLES = 2_000
"""Of longer ones nothing is remembered: it would take much memory, and not much of the time that they take."""


def of_target(function: Callable[Concatenate[Result, P], T]) -> Callable[Concatenate[Result, P], T]:
    """Remember what a function of a run finds, as long as truth and measurements are the same arrays.

    Args:
        function: of a run and hashable arguments; of the run, truth and measurements alone may matter. What it gives is
            not to be changed by anybody.
    """
    found: OrderedDict[Any, tuple[FloatArray, FloatArray, T]] = OrderedDict()
    lock = threading.Lock()

    def remembered(result: Result, /, *args: P.args, **more: P.kwargs) -> T:
        truth, measured = result.truth.states, result.measurements.positions
        if len(truth) > MOST_SAMPLES:
            return function(result, *args, **more)
        # While the arrays are kept here, nothing else has their identities.
        key = id(truth), id(measured), args, *more.items()
        with lock:
            known = found.get(key)
            if known is not None:
                found.move_to_end(key)
                return known[2]
        value = function(result, *args, **more)
        with lock:
            found[key] = truth, measured, value
            while len(found) > TARGETS:
                found.popitem(last=False)
        return value

    update_wrapper(remembered, function)
    return remembered
