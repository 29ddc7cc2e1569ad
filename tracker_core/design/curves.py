"""Designs of one parameter as curves: the gains while it runs through its domain, for drawing."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from tracker_core.checks import check_choice
from tracker_core.design import DESIGNS
from tracker_core.types import FloatArray

SPANS = {"xi": (0.0, 0.999), "alpha": (0.001, 1.999), "tracking_index": (1e-4, 100.0)}
"""What of a parameter's domain is drawn."""

RECONSTRUCTIONS = ("jeong-gray-murray", "jeong-gray-murray-as-run", "jeong-fading-memory-as-run")
"""Designs that repeat what somebody ran; they are not among the curves that one compares with."""


def curve_designs(order: int) -> tuple[str, ...]:
    """The designs that draw a curve for an order, in the order of the registry."""
    return tuple(
        name
        for name, design in DESIGNS.items()
        if order in design.formulas and len(design.parameters) == 1 and name not in RECONSTRUCTIONS
    )


@lru_cache(maxsize=32)
def design_curve(name: str, order: int, points: int = 120) -> FloatArray:
    """The gains of a design while its parameter runs through its domain.

    Args:
        name: one of `curve_designs(order)`.
        order: of the filter.
        points: along the curve.

    Returns:
        Normalised gains, shape (points, order), read-only.

    Raises:
        InputError: for another design.
    """
    check_choice("design", name, curve_designs(order))
    curve = along_curve(name, order, curve_values(name, points))
    curve.setflags(write=False)
    return curve


def along_curve(name: str, order: int, values: FloatArray) -> FloatArray:
    """The gains of a design of one parameter at values of it, shape (p,): normalised, shape (p, order)."""
    design = DESIGNS[name]
    (parameter,) = design.parameters
    return np.array([design.gains(order, **{parameter: float(value)}) for value in values])


def curve_values(name: str, points: int) -> FloatArray:
    """Values of a design's one parameter through what is drawn of its domain: even, or by equal factors."""
    ((parameter, domain),) = DESIGNS[name].parameters.items()
    low, high = SPANS[parameter]
    if parameter == "tracking_index":
        return np.geomspace(low, high, points)
    # A design may admit less.
    return np.linspace(max(low, domain.low), min(high, domain.high), points)
