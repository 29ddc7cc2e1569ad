"""What an exported filter says of itself."""

from __future__ import annotations

from math import factorial

from tracker_core.conventions import CONVENTIONS
from tracker_core.exports.code.tuned import TunedFilter
from tracker_core.gating import PATIENCE
from tracker_core.starts import STARTS
from tracker_core.types import GAIN_NAMES

SYMBOLS = ("x", "v", "a", "j")


def head(tuned: TunedFilter) -> list[str]:
    """The comment at the top: where the filter comes from, its gains and formulas, its start and its gate."""
    gains, gate = tuned.gains, tuned.gate
    named = ", ".join(f"{name} = {value!r}" for name, value in zip(GAIN_NAMES, gains.values, strict=False))
    lines = [
        *([f"Experiment: {tuned.title}"] if tuned.title else []),
        *([f"From: {tuned.origin}"] if tuned.origin else []),
        f"Axes: {', '.join(tuned.axes)}",
        f"Interval: T = {tuned.interval!r} s",
        f"Gains: {named}",
        f"    in the convention '{gains.convention}': the state is corrected by {_terms(tuned)}",
        f"Start: {STARTS[tuned.start].sentence}",
        f"Stop: where a smoothed position passes {tuned.limit:g} m.",
        "",
        "Over an interval t the filter predicts, then corrects by the innovation e = measured x - x:",
        *_formulas(gains.order),
        "where g are the normalised gains below. A missing measurement is bridged by prediction.",
        "They suit intervals near T: after a much shorter one they correct the derivatives too hard, so that",
        "measurements of one moment are better averaged before.",
    ]
    if gate is not None:
        stds = ", ".join(repr(float(value)) for value in gate.stds(len(tuned.axes)))
        lines += [
            "",
            f"Gate: a measurement is refused where sqrt(sum over the axes of e^2/S) > {float(gate.width)!r}.",
            "    It is bridged like a missing one. S is the variance that these gains give the innovation,",
            f"    for a sensor noise of {stds} m",
            f"    and a tracking index of {float(gate.tracking_index)!r} at T = {float(gate.interval)!r} s.",
            f"    From refusal {PATIENCE} in a row on, each doubts the track more, until it finds its way back.",
            *([] if tuned.start == "known" else [f"    It watches once every axis was measured {gains.order} times."]),
        ]
    return lines


def _terms(tuned: TunedFilter) -> str:
    """What is added to position, velocity, ..., in the convention of the gains."""
    terms = []
    for i, name in enumerate(GAIN_NAMES[: tuned.gains.order]):
        factor = CONVENTIONS[tuned.gains.convention].factors[i]
        times, below = (round(factor), 1) if factor >= 1 else (1, round(1 / factor))
        divisor = " ".join(part for part in (str(below) if below > 1 else "", f"T^{i}" if i > 1 else "T" * i) if part)
        above = f"{times} {name} e" if times > 1 else f"{name} e"
        terms.append(f"{above}/({divisor})" if " " in divisor else f"{above}/{divisor}" if divisor else above)
    return ", ".join(terms)


def _formulas(order: int) -> list[str]:
    """Prediction and correction of every state."""
    lines = []
    for i, symbol in enumerate(SYMBOLS[:order]):
        terms = [symbol]
        for k in range(1, order - i):
            power = "t" if k == 1 else f"t^{k}"
            terms.append(f"{power} {SYMBOLS[i + k]}" + (f"/{factorial(k)}" if k > 1 else ""))
        below = "" if i == 0 else "/t" if i == 1 else f"/t^{i}"
        moved = f"{symbol} = {' + '.join(terms)}" if len(terms) > 1 else f"{symbol} stays"
        lines.append(f"    {moved}, then {symbol} = {symbol} + g{i} e{below}")
    return lines


def begin_sentence(tuned: TunedFilter) -> str:
    """What an axis does before its gains rule."""
    if tuned.growing:
        return "Start of an axis: the polynomial through all measurements, until they are enough for least squares."
    if tuned.points == 1:
        return "Start of an axis: at its first measurement, at rest."
    return f"Start of an axis: the polynomial through its first {tuned.points} measurements."


def leaves(tuned: TunedFilter) -> list[str]:
    """What FilterPy does not do."""
    lines = [f"- the start ({STARTS[tuned.start].title.lower()}): give each filter the state from which it goes on;"]
    if tuned.gate is not None:
        lines.append("- the gate: in the self-test the measurements that it refused are missing;")
    return [*lines, f"- the stop where a smoothed position passes {tuned.limit:g} m."]
