"""What a scenario is: a target's true motion, and what is known of the sensor that watched it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from tracker_core.checks import InputError
from tracker_core.types import FloatArray, Truth

_RandomMotion = Callable[[FloatArray, int], FloatArray]


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
    """One target: its motion is either given for all time, or drawn.

    Attributes:
        name: key in the registry.
        title: for menus.
        axes: names of its axes, for labels and columns.
        description: one or two sentences.
        source: where it comes from.
        motion: from times of shape (n,) in s to states of shape (n, n_axes, 5): position to snap, SI units; None
            where the motion is random.
        random_motion: the same from times, which do not decrease, and a seed. A longer grid of times begins with the
            states of the shorter one. Before time zero the state at zero is continued with constant acceleration,
            and its draws are those of the run. What a motion does not have, such as the jerk of an acceleration that
            is nowhere differentiable, is NaN. None where the motion is not random.
        first_sample: index of the first sample: it is taken at first_sample * interval.
        defaults: fields of the experiment that this scenario sets where the user does not.
        recording: published measurements, if there are any.

    Raises:
        InputError: unless exactly one of motion and random_motion is given.
    """

    name: str
    title: str
    axes: tuple[str, ...]
    description: str
    source: str
    motion: Callable[[FloatArray], FloatArray] | None = None
    random_motion: _RandomMotion | None = None
    first_sample: int = 0
    defaults: Mapping[str, Any] = field(default_factory=dict)
    recording: Recording | None = None

    def __post_init__(self) -> None:
        if (self.motion is None) == (self.random_motion is None):
            raise InputError("motion", "must be given where random_motion is not, and only there", self.motion)

    @property
    def random(self) -> bool:
        """Whether the motion depends on the seed."""
        return self.random_motion is not None

    @property
    def known_states(self) -> int:
        """How many of the true states, from the position on, are known at every sample."""
        return 3 if self.random else 5

    def truth(self, times: FloatArray, seed: int = 0) -> Truth:
        """The true motion at the given times, shape (n,), s; the seed matters where it is random."""
        if self.motion is not None:
            return Truth(times=times, states=self.motion(times))
        return Truth(times=times, states=cast("_RandomMotion", self.random_motion)(times, seed))
