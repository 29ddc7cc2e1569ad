"""What a scenario is: a target's true motion, and what is known of the sensor that watched it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from tracker_core.types import FloatArray, Truth


@dataclass(frozen=True, slots=True)
class Recording:
    """Measurements that were published with a scenario.

    Attributes:
        positions: per sample the measured position of every axis, m.
        interval: s between two samples.
    """

    positions: tuple[tuple[float, ...], ...]
    interval: float


@dataclass(frozen=True, slots=True)
class Scenario:
    """One target.

    Attributes:
        name: key in the registry.
        title: for menus.
        axes: names of its axes, for labels and columns.
        motion: from times of shape (n,) in s to states of shape (n, n_axes, 5): position to snap, SI units.
        description: one or two sentences.
        source: where it comes from.
        first_sample: index of the first sample: it is taken at first_sample * interval.
        defaults: fields of the experiment that this scenario sets where the user does not.
        recording: published measurements, if there are any.
    """

    name: str
    title: str
    axes: tuple[str, ...]
    motion: Callable[[FloatArray], FloatArray]
    description: str
    source: str
    first_sample: int = 0
    defaults: Mapping[str, Any] = field(default_factory=dict)
    recording: Recording | None = None

    def truth(self, times: FloatArray) -> Truth:
        """The true motion at the given times, shape (n,), s."""
        return Truth(times=times, states=self.motion(times))
