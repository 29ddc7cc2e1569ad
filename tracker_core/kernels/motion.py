"""What the compiled recursions of any order share."""

from __future__ import annotations

from tracker_core.kernels.compiled import compiled
from tracker_core.types import FloatArray


@compiled
def powers_of(t: float, forward: FloatArray, back: FloatArray) -> None:
    """forward[d] = t^d/d!, back[d] = 1/t^d."""
    forward[0] = back[0] = 1.0
    for d in range(1, forward.shape[0]):
        forward[d] = forward[d - 1] * t / d
        back[d] = back[d - 1] / t
