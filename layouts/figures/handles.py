"""What of a plot can be taken hold of: where the handles are, and what moving one sets.

The browser draws a handle as a button over the plot (assets/handles.js): mouse, touch and arrow keys.
"""

from __future__ import annotations

from typing import Any

from layouts.state import plane_name
from layouts.text import significant
from tracker_core import Gains
from tracker_core.fields import FIELDS
from tracker_core.stability import is_stable
from tracker_core.types import GAIN_NAMES

STEP = 0.01
"""What one arrow key moves; with Shift a tenth of it."""


def gains_handle(gains: Gains, plane: tuple[str, str]) -> dict[str, Any]:
    """The operating point in a plane of two gains (normalised).

    Returns:
        `control` that it sets; `prefix` of the value set, before the coordinates; `points` (x, y), their `labels` and
        `tones`; `step` of an arrow key.
    """
    vector = gains.vector
    x, y = (float(vector[GAIN_NAMES.index(name)]) for name in plane)
    said = ", ".join(
        f"{FIELDS[name].symbol} {significant(value, 3)}" for name, value in zip(plane, (x, y), strict=True)
    )
    return {
        "control": "point",
        "prefix": plane_name(plane),
        "points": [[x, y]],
        "labels": [f"Operating point: {said}"],
        "tones": ["good" if is_stable(gains) else "bad"],
        "step": STEP,
    }


def pole_handles(poles: tuple[complex, ...]) -> dict[str, Any]:
    """The poles in the z-plane; of a conjugate pair either can be taken. Returns as `gains_handle`."""
    return {
        "control": "pole",
        "prefix": "",
        "points": [[pole.real, pole.imag] for pole in poles],
        "labels": [f"Pole {i}: {pole_text(pole)}" for i, pole in enumerate(poles, 1)],
        "tones": ["good" if abs(pole) < 1 else "bad" for pole in poles],
        "step": STEP,
    }


def pole_text(pole: complex) -> str:
    """A pole as a reader writes it."""
    real = significant(pole.real, 3)
    if not pole.imag:
        return real
    return f"{real} {'+' if pole.imag > 0 else '−'} {significant(abs(pole.imag), 3)}i"
