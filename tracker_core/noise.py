"""Measurement noise. Every axis draws from a stream of its own, so adding an axis changes no other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tracker_core.types import FloatArray


def white(shape: tuple[int, int], std: tuple[float, ...], seed: int) -> FloatArray:
    """Zero-mean white Gaussian noise.

    Args:
        shape: (n_samples, n_axes).
        std: standard deviation per axis, m; one number serves all axes.
        seed: whole number >= 0. The same seed gives the same bits, and a longer run begins with the shorter one.

    Returns:
        Array of that shape, m.
    """
    samples, axes = shape
    per_axis = std * axes if len(std) == 1 else std
    columns = []
    for axis in range(axes):
        stream = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(axis,)))
        columns.append(per_axis[axis] * stream.standard_normal(samples))
    return np.stack(columns, axis=1)


@dataclass(frozen=True, slots=True)
class Noise:
    """One kind of measurement noise.

    Attributes:
        title: for menus.
        draw: the function that draws it from shape, standard deviations and seed; None where nothing is drawn.
    """

    title: str
    draw: Callable[[tuple[int, int], tuple[float, ...], int], FloatArray] | None


NOISES: dict[str, Noise] = {
    "white": Noise("White Gaussian", white),
    "none": Noise("None", None),
    "recorded": Noise("As recorded", None),
}
