"""Numbers and messages as a person reads them."""

from __future__ import annotations

import re
import unicodedata
from math import floor, isfinite, log10

from tracker_core import InputError
from tracker_core.adaptive import PARAMETERS as METHOD_PARAMETERS
from tracker_core.fields import FIELDS
from tracker_core.metrics import Metric

GREAT = 10
"""A change of so many times the pinned value is given as a factor instead of in percent."""


STEM_LENGTH = 40


RARE = ("Whiteness, p",)
RAREST = 1e-4
"""Probabilities that are told to be less than this when they are."""

LABELS = {
    "at": "The sample",
    "limit_noise": "Greatest noise gain",
    "limit_lag": "Greatest lag",
    "limit_overshoot": "Greatest overshoot",
    "limit_settling": "Longest settling",
    "point": "The point",
    "pole": "The pole",
    "tune_for": "What is tuned for",
    "against": "What is varied",
    "from": "The first value",
    "to": "The last value",
    "points": "Values",
    "cells": "Cells a side",
    "budget": "Gain sets",
    "tune_runs": "Runs",
    "noise_weight": "The weight of the noise",
    "plane": "The plane",
    "runs": "Runs",
}
"""What is called by another name than its control."""


def significant(value: float, digits: int = 4) -> str:
    """A number to some significant digits, thousands grouped, an exponent only for the very small and the very large.

    Whole digits before the point are never rounded away below 10 million.
    """
    if not isfinite(value):
        return "–"
    if value == 0:
        return "0"
    magnitude = floor(log10(abs(value)))
    if not -5 < magnitude < max(7, digits + 3):
        mantissa, exponent = f"{value:.{min(digits, 3) - 1}e}".split("e")
        return f"{mantissa}e{int(exponent)}".replace("-", "−")
    # As it is shown it may be the next power of ten: 0.99996 is 1.000.
    shown = int(f"{value:.{max(0, digits - 1)}e}".partition("e")[2])
    return f"{value:,.{max(0, digits - 1 - shown)}f}".replace("-", "−")


_SUBSCRIPT = re.compile(r"(?<=[A-Za-zα-ωΛ])_([A-Za-z]+)")


def subscripts(text: str) -> list[tuple[str, bool]]:
    """A text in pieces, each with whether it stands below the line: σ_w is σ with a low w."""
    pieces = [(piece, index % 2 == 1) for index, piece in enumerate(_SUBSCRIPT.split(text))]
    return [(piece, low) for piece, low in pieces if piece]


def metric_text(metric: Metric, value: float | None) -> str:
    """A metric with its unit; a dash where it is not defined."""
    if value is None:
        return "–"
    if metric.title in RARE and value < RAREST:
        return f"< {RAREST:.4f}"
    digits = 4 if abs(value) >= 0.01 else 3
    return f"{significant(value, digits)} {metric.unit}".rstrip()


def change_text(metric: Metric, value: float | None, pinned: float | None) -> tuple[str, str]:
    """The change of a metric since a pin, and its tone: "better", "worse" or "same"."""
    if value is None or pinned is None or not (isfinite(value) and isfinite(pinned)):
        return "–", "same"
    difference = value - pinned
    if abs(difference) <= 1e-12 * max(abs(value), abs(pinned)):
        return "no change", "same"
    sign = "+" if difference > 0 else "−"
    text = f"{sign}{significant(abs(difference), 2)}"
    if metric.unit != "%" and pinned:
        share = abs(difference / pinned)
        text += f" ({sign}{share * 100:.1f} %)" if share < GREAT else f" (× {significant(value / pinned, 2)})"
    better = (difference < 0) == metric.lower_is_better
    return text, "better" if better else "worse"


def error_text(error: InputError) -> str:
    """A message for beside the field: the field by its label, the rule, the value received."""
    field = FIELDS.get(error.field)
    # The symbols of gains say enough; those of a method's parameters are used by others too.
    short = field is not None and field.symbol and error.field not in METHOD_PARAMETERS
    label = LABELS.get(error.field, error.field) if field is None else field.symbol if short else field.title
    received = error.received
    text = f"{received:.12g}" if isinstance(received, float) else str(received)[:40]
    shown = "nothing" if received in (None, "") else f"“{text}”"
    return f"{label} {error.rule}, got {shown}."


def file_stem(title: str) -> str:
    """A title as the beginning of a file's name, which any system takes: ASCII letters, digits, dots and hyphens."""
    plain = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode()
    name = re.sub(r"(\.(csv|tsv|txt|dat|log|gz))+$", "", plain, flags=re.IGNORECASE)
    return re.sub(r"[^A-Za-z0-9.]+", "-", name).strip("-.")[:STEM_LENGTH] or "gainscope"
