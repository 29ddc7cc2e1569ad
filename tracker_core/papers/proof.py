"""What a proof of an erratum is: a formula, numbers computed for it, and what they look like."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Series:
    """One line, one set of points or one set of bars of a chart.

    Attributes:
        name: for the legend.
        kind: "line", "points" or "bars".
        role: whose colour it has: "truth", "observed", "predicted", "smoothed", "counterpart", "marker" or "bad".
        x: numbers, or names of bars.
        y: numbers.
    """

    name: str
    kind: str
    role: str
    x: tuple[float, ...] | tuple[str, ...]
    y: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Chart:
    """What a proof looks like.

    Attributes:
        title: what is shown.
        x_title, y_title: of the axes, with units.
        series: in the order in which they are drawn.
        logarithmic: whether the vertical axis is.
        z_plane: whether it shows poles: with the unit circle, on equal scales.
    """

    title: str
    x_title: str
    y_title: str
    series: tuple[Series, ...]
    logarithmic: bool = False
    z_plane: bool = False


@dataclass(frozen=True, slots=True)
class Proof:
    """A proof of an erratum, computed.

    Attributes:
        formula: what is computed, in one line.
        lines: names and values of numbers, as text.
        holds: whether the numbers prove it.
        chart: what they look like; None where there is nothing to see.
    """

    formula: str
    lines: tuple[tuple[str, str], ...]
    holds: bool
    chart: Chart | None = None
