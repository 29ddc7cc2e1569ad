"""A filter for measured data: the order, tracking index and noise that the data themselves ask for, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import exp
from typing import Any

from tracker_core.checks import InputError
from tracker_core.identification import BELIEVED, MOST_SET_ASIDE, Identified, fitted, identify
from tracker_core.likelihood import likelihood
from tracker_core.types import GAIN_NAMES, ORDERS, BoolArray, Measurements

GATE = 4.0
"""Width of the gate that is suggested where there are outliers, in standard deviations."""

SYMBOLS = dict(zip(GAIN_NAMES, "αβγη", strict=True))


@dataclass(frozen=True, slots=True)
class Suggestion:
    """A filter that suits measurements.

    Attributes:
        values: fields of the experiment: order, design, tracking_index, start, noise_std (one per axis, m), and gate
            (width, or None for no gate).
        why: what speaks for it, in sentences with numbers.
        chosen: the estimates that it rests on.
        identified: the estimates of every order.
        bic: Schwarz's criterion of every order on the same measurements, less is better; None where an order explains
            every axis but for rounding.
    """

    values: Mapping[str, Any]
    why: tuple[str, ...]
    chosen: Identified
    identified: Mapping[int, Identified]
    bic: Mapping[int, float | None]


def suggest(
    measurements: Measurements,
    *,
    orders: Sequence[int] = ORDERS,
    interval: float | None = None,
    axes: Sequence[str] | None = None,
) -> Suggestion:
    """Suggest a filter: identify the noise for every order, and choose the order by Schwarz's criterion (BIC).

    All orders are compared on the same measurements: those that no order can believe are left out for all. As every
    order has as many parameters, the difference of two BICs is twice the logarithm of how much likelier the one makes
    them (Kass & Raftery 1995, J. American Statistical Association 90, 773-795). An order that explains more axes to the
    last digit goes first.

    Args:
        measurements: n_samples by n_axes positions, NaN where one is missing; ten of each axis or more.
        orders: to choose from.
        interval: s, that the tracking index shall belong to; by default that of the measurements, or the median one.
        axes: their names, for the sentences.

    Raises:
        InputError: for measurements that do not fit together, too few, no orders, or an unknown one.
    """
    if not orders:
        raise InputError("orders", "must hold one order or more", list(orders))
    identified = {order: identify(measurements, order, interval=interval) for order in orders}
    beyond = set_aside_by_all(identified)
    bic = {order: _bic(measurements, found, beyond) for order, found in identified.items()}

    def rank(order: int) -> tuple[int, float, int]:
        score = bic[order]
        return -identified[order].sensor_std.count(0.0), 0.0 if score is None else score, order

    ranked = sorted(identified, key=rank)
    chosen = identified[ranked[0]]
    values = {
        "order": chosen.order,
        "design": "steady-kalman",
        "tracking_index": chosen.suggested_index,
        # Two points of a smooth filter are felt for as long as it remembers.
        "start": "expanding",
        "noise_std": chosen.sensor_std,
        "gate": GATE if chosen.rejected and 0 not in chosen.sensor_std else None,
    }
    names = [f"axis {axis + 1}" for axis in range(len(chosen.sensor_std))] if axes is None else axes
    why = (
        *_of_the_order(ranked, identified, bic),
        *_of_the_noise(chosen, names, constant=measurements.interval is not None),
        *_of_the_samples(chosen, measurements),
    )
    return Suggestion(values, why, chosen, identified, bic)


def set_aside_by_all(identified: Mapping[int, Identified]) -> BoolArray:
    """The samples, shape (n_samples,), that are outliers whatever the order."""
    first, *others = (found.set_aside for found in identified.values())
    for other in others:
        first = first & other
    return first


def _bic(measurements: Measurements, found: Identified, beyond: BoolArray) -> float | None:
    """The criterion of one order where only certain samples are left out."""
    if (found.set_aside == beyond).all() or found.bic is None:
        return found.bic
    model = likelihood(measurements, found.order, found.interval)
    return fitted(model.believing(~beyond[model.rows])).bic


def _of_the_order(
    ranked: Sequence[int], identified: Mapping[int, Identified], bic: Mapping[int, float | None]
) -> tuple[str, ...]:
    order, others = ranked[0], ranked[1:]
    if not others:
        return (f"Order {order} was asked for.",)
    exact = identified[order].sensor_std.count(0.0)
    if exact > identified[others[0]].sensor_std.count(0.0):
        return (
            f"Order {order}: it leaves nothing but rounding on {exact} of {len(identified[order].sensor_std)} axes.",
        )
    best = bic[order]
    if best is None:
        return (f"Order {order}, the lowest that leaves nothing but rounding.",)
    ahead = ", ".join(f"{(bic[other] or 0.0) - best:,.1f} over order {other}" for other in others)
    lead = (bic[others[0]] or 0.0) - best
    times = exp(min(lead, 60) / 2)
    likelier = (
        "far likelier than"
        if lead > 27
        else f"{times:,.0f} times likelier than"
        if times > 10
        else (f"{times:.2g} times as likely as")
    )
    close = " The difference is small: both will do." if lead < 2 else ""
    return (
        f"Order {order}: with it the measurements are {likelier} with order {others[0]} (BIC ahead by {ahead}).{close}",
    )


def _of_the_noise(chosen: Identified, names: Sequence[str], *, constant: bool) -> tuple[str, ...]:
    push, power = ("acceleration", "m/s²") if chosen.order == 2 else ("acceleration step", "m/s²")
    push, power = (push, power) if chosen.order < 4 else ("jerk step", "m/s³")
    sensor = ", ".join(f"{std:.3g} m ({name})" for name, std in zip(names, chosen.sensor_std, strict=True))
    low, high = chosen.index_interval
    if chosen.log_likelihood is None:
        degree = chosen.order - 1
        return (
            f"No noise was found: a polynomial of degree {degree} goes through all measurements, as the filter may.",
        )
    found = [f"Measurement noise σ: {sensor}."]
    if chosen.manoeuvre_found and not chosen.noise_found:
        found.append("Measurements without any noise would be as likely: the filter follows them closely.")
    if chosen.manoeuvre_found:
        process = ", ".join(f"{std:.3g} {power} ({name})" for name, std in zip(names, chosen.process_std, strict=True))
        found.append(f"Manoeuvre noise σ_w, the {push} of every {chosen.interval:.3g} s: {process}.")
        bounds = f"from {low:.3g} to {high:.3g}" if chosen.noise_found else f"of {low:.3g} or more"
        found.append(f"Tracking index Λ = {chosen.tracking_index:.3g}, with 95 % {bounds}.")
    elif chosen.noise_found:
        found.append(
            f"No manoeuvre was found: Λ is {high:.3g} at most (95 %), and that is used, so that one would be followed."
        )
    else:
        found.append(f"Too little is known to tell noise from manoeuvre; Λ = {chosen.suggested_index:.3g} is a guess.")
    gains = ", ".join(
        f"{SYMBOLS[name]} = {gain:.4g}" for name, gain in zip(GAIN_NAMES, chosen.gains.tolist(), strict=False)
    )
    if constant:
        found.append(f"The best constant gains for that: {gains} (steady Kalman filter, normalised).")
    else:
        found.append(
            f"The best constant gains for that at a constant interval of {chosen.interval:.3g} s: {gains} (steady "
            "Kalman filter, normalised). Here the intervals vary, and others may predict better: see what Tune finds."
        )
    return tuple(found)


def _of_the_samples(chosen: Identified, measurements: Measurements) -> tuple[str, ...]:
    found = []
    total = len(measurements.positions)
    if chosen.rejected:
        found.append(
            f"{chosen.rejected:,} of {chosen.samples:,} samples lie more than {BELIEVED:g} standard deviations from "
            "what all others say and were set aside."
        )
        if 0 not in chosen.sensor_std:
            found.append(f"A gate of {GATE:g} standard deviations keeps such ones out of the track.")
    if chosen.crowded:
        found.append(
            f"More than {MOST_SET_ASIDE:.0%} of the samples look like outliers of the others: none was set aside, and "
            "the estimates are not to be trusted far."
        )
    if chosen.samples < total:
        found.append(f"Estimated from {chosen.samples:,} of the {total:,} samples, in blocks spread evenly over them.")
    return tuple(found)
