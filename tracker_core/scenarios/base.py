"""What a scenario is: a target, what is known of its true motion, and of the sensor that watched it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from tracker_core.checks import InputError
from tracker_core.types import FloatArray, Truth

_RandomMotion = Callable[[FloatArray, int], FloatArray]


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """Measurements that came with a target.

    Attributes:
        positions: shape (n, n_axes), the measured position of every axis, m; NaN where a measurement is missing.
        interval: s between two samples; their median where it varies.
        times: shape (n,), s, where they do not follow from a constant interval.
        truth: shape (n, n_axes), the true position, m; None where the scenario knows it, or nobody does.
    """

    positions: FloatArray
    interval: float
    times: FloatArray | None = None
    truth: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class Scenario:
    """One target: its motion is given for all time, or drawn, or nothing of it is known but what was recorded.

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
        recording: measurements that came with it, if there are any.

    Raises:
        InputError: unless exactly one of motion and random_motion is given, or neither but a recording.
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
        if self.motion is not None and self.random_motion is not None:
            raise InputError("motion", "must be given where random_motion is not, and only there", self.motion)
        if self.motion is None and self.random_motion is None and self.recording is None:
            raise InputError("motion", "must be given where nothing was recorded", None)

    @property
    def random(self) -> bool:
        """Whether the motion depends on the seed."""
        return self.random_motion is not None

    @property
    def measured(self) -> bool:
        """Whether nothing is known of the motion but what was recorded."""
        return self.motion is None and self.random_motion is None

    @property
    def known_states(self) -> int:
        """How many of the true states, from the position on, are known at every sample."""
        if self.measured:
            known = self.recording.truth if self.recording is not None else None
            return int(known is not None and not np.isnan(known).any())
        return 3 if self.random else 5

    def truth(self, times: FloatArray, seed: int = 0) -> Truth:
        """The true motion at the given times, shape (n,), s; the seed matters where it is random.

        What nobody knows is NaN. Of a measured target the times are those of its first n samples.
        """
        if self.motion is not None:
            return Truth(times=times, states=self.motion(times))
        if self.random_motion is not None:
            return Truth(times=times, states=self.random_motion(times, seed))
        recording = cast("Recording", self.recording)
        states = np.full((len(times), len(self.axes), 5), np.nan)
        if recording.truth is not None:
            states[:, :, 0] = recording.truth[: len(times)]
        return Truth(times=times, states=states)

    def times(self, samples: int, interval: float) -> FloatArray:
        """When the first samples are taken, shape (samples,), s."""
        if self.recording is not None and self.recording.times is not None:
            return self.recording.times[:samples].copy()
        return (self.first_sample + np.arange(samples, dtype=np.float64)) * interval
