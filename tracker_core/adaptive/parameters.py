"""What selection methods are told: names, domains and words of their parameters, which are fields of the experiment."""

from __future__ import annotations

from tracker_core.checks import Domain, Field, choice
from tracker_core.types import STATE_NAMES

CRITERIA = {"mean-square": "mean square", "mean-absolute": "mean absolute"}
END_POINTS = {
    "interior": "inside: i/(m+1)",
    "middle": "middles: (i−½)/m",
    "upper": "with the upper end: i/m",
    "both": "with both ends: (i−1)/(m−1)",
}
TIES = {"first": "the first", "last": "the last"}
BOUNDS = {
    "exact": "stable sets only (Jury)",
    "triangle": "β < 4 − 2α, rest as printed",
    "printed": "as printed: β < 13/6 (4 − 2α)",
}
PARABOLAS = {"none": "no", "printed": "yes (eq. 25–26)"}

PARAMETERS: dict[str, Field] = {
    "fixed_alpha": Field(
        "α₀", "Fixed α₀", "", "The α that the method begins with; its β is that of Benedict and Bordner.", "number",
        Domain(0, 1, low_open=True)),
    "weight": Field(
        "w", "Weight", "", "Share of the fixed β; the rest is that of the growing memory. Empty: searched.", "number",
        Domain(0, 1)),
    "criterion": choice("Criterion", "Which mean of the innovations the search makes least.", CRITERIA),
    "window": Field(
        "W", "Window", "samples", "How many samples are filtered again.", "whole", Domain(2, 10_000, whole=True)),
    "step": Field(
        "", "Step", "samples", "How often the gains are chosen anew.", "whole", Domain(1, 10_000, whole=True)),
    "levels": Field(
        "", "Levels of α", "", "How many α the window is filtered with: i/m of (0, 1].", "whole",
        Domain(1, 200, whole=True)),
    "grid": Field("m", "Grid", "", "Levels of every gain that is searched.", "whole", Domain(1, 200, whole=True)),
    "grid_eta": Field("", "Grid of η", "", "Levels of η.", "whole", Domain(1, 50, whole=True)),
    "refinements": Field(
        "", "Refinements", "", "How often the grid is drawn closer around the best.", "whole",
        Domain(0, 10, whole=True)),
    "members": Field(
        "K", "Members", "", "Filters in the bank; with several orders, of each.", "whole", Domain(1, 200, whole=True)),
    "memory": Field(
        "", "Memory", "s", "Time constant of the window over past innovations.", "number", Domain(1e-6, 1e9)),
    "shortest": Field(
        "τ", "Shortest τ", "s", "Time constant of the fastest member: its poles are e^(−T/τ).", "number",
        Domain(1e-6, 1e9)),
    "longest": Field("τ", "Longest τ", "s", "Time constant of the slowest member.", "number", Domain(1e-6, 1e9)),
    "objective": choice("Objective", "The true state that the chosen gains come nearest to.", STATE_NAMES),
    "end_points": choice("End points", "Where the levels lie between the bounds of a gain.", END_POINTS),
    "ties": choice("Ties", "Which of equally good sets is taken; they are ordered by level of γ, α, β, η.", TIES),
    "bound": choice("Bounds", "Which sets are admitted.", BOUNDS),
    "parabola": choice("Parabola", "Whether a parabola through the neighbours moves the gain.", PARABOLAS),
}  # fmt: skip

TITLES: dict[str, dict[str, str]] = {
    "criterion": CRITERIA,
    "objective": {name: name for name in STATE_NAMES},
    "end_points": END_POINTS,
    "ties": TIES,
    "bound": BOUNDS,
    "parabola": PARABOLAS,
}
"""Per choice what its names mean, for menus."""
