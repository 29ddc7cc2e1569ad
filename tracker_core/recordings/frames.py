"""Positions as a file gives them to metres along axes."""

from __future__ import annotations

import numpy as np

from tracker_core.recordings.bounds import FAR
from tracker_core.recordings.geodesy import to_local
from tracker_core.recordings.reading import Reading
from tracker_core.recordings.units import ANGLES, LENGTHS
from tracker_core.types import BoolArray, FloatArray

Place = tuple[float, float, float]

_HIGHEST = {"latitude": 90.0, "longitude": 360.0}
_TURN = 2 * np.pi
_NEAR_ZERO = 1.0
"""Degrees: a track whose middle lies within so much of latitude 0 and longitude 0 may well pass there."""


def beyond(values: FloatArray, reading: Reading) -> BoolArray:
    """Which values cannot be: too far away, no place on Earth, a negative range; shape of `values`, (n, axes)."""
    with np.errstate(over="ignore"):
        size = np.abs(values)
        if reading.frame == "plane":
            return np.asarray(size * scale(reading) > FAR)
        if reading.frame == "geographic":
            limits = [_HIGHEST["latitude"], _HIGHEST["longitude"], FAR / LENGTHS[reading.units[0]]]
            return (size > limits[: values.shape[1]]) | _no_fix(values)
        turn = _TURN / ANGLES[reading.angle]
        limits = [FAR / LENGTHS[reading.units[0]], turn, turn / 4 * (1 + 1e-9)]
        wrong = np.asarray(size > limits[: values.shape[1]])
    return wrong | (np.arange(values.shape[1]) == 0) & (values < 0)


def _no_fix(values: FloatArray) -> BoolArray:
    """Latitude 0 and longitude 0, which receivers write before they know where they are."""
    zero: BoolArray = np.all(values[:, :2] == 0, axis=1)
    if zero.any() and not zero.all():
        others = np.abs(values[~zero, :2])
        with np.errstate(invalid="ignore"):
            known = others[np.isfinite(others).all(axis=1)]
        if len(known) and np.median(known, axis=0).max() <= _NEAR_ZERO:
            zero[:] = False
    return np.repeat(zero[:, None], values.shape[1], axis=1)


def scale(reading: Reading) -> FloatArray:
    """Metres in a unit of every axis of a plane."""
    return np.array([LENGTHS[unit] for unit in reading.units])


def joined(values: FloatArray, reading: Reading) -> FloatArray:
    """`values` with NaN for numbers that mean nothing without a missing one: a latitude without its longitude."""
    if reading.frame == "plane":
        return values
    needed = values[:, :2] if reading.frame == "geographic" else values
    return np.where(np.isnan(needed).any(axis=1, keepdims=True), np.nan, values)


def origin_of(values: FloatArray, reading: Reading) -> Place | None:
    """Latitude, longitude (degrees) and altitude (m) of the first whole place; None where the frame has no such."""
    if reading.frame != "geographic":
        return None
    whole = np.flatnonzero(np.isfinite(values).all(axis=1))
    if not len(whole):
        whole = np.flatnonzero(np.isfinite(values[:, :2]).all(axis=1))
    if not len(whole):
        return None
    latitude, longitude, *altitude = np.nan_to_num(values[whole[0]]).tolist()
    return latitude, longitude, altitude[0] * LENGTHS[reading.units[0]] if altitude else 0.0


def to_metres(values: FloatArray, reading: Reading, origin: Place | None) -> FloatArray:
    """Positions along the axes of a reading.

    A polar position is r sin(b) cos(e) east, r cos(b) cos(e) north and r sin(e) up, with the bearing b clockwise from
    north and the elevation angle e. A geographic place whose altitude alone is missing lies at the altitude between
    those of its neighbours, and has no position along the axis up.

    Args:
        values: shape (n, axes), in the units of the reading.
        reading: which says what they are.
        origin: of local axes, where values are geographic.

    Returns:
        Shape (n, axes), m; NaN where a number is missing.
    """
    if reading.frame == "plane":
        return values * scale(reading)
    if reading.frame == "polar":
        distance, bearing = values[:, 0] * LENGTHS[reading.units[0]], values[:, 1] * ANGLES[reading.angle]
        raised = values[:, 2] * ANGLES[reading.angle] if values.shape[1] == 3 else np.zeros(len(values))
        flat = distance * np.cos(raised)
        parts = [flat * np.sin(bearing), flat * np.cos(bearing), distance * np.sin(raised)]
        return np.stack(parts[: values.shape[1]], axis=1)
    if origin is None:
        return np.full(values.shape, np.nan)
    if values.shape[1] == 2:
        level = np.full((len(values), 1), origin[2])
        return to_local(np.hstack((values, level)), origin)[:, :2]
    altitude = values[:, 2] * LENGTHS[reading.units[0]]
    unknown = np.isnan(altitude)
    local = to_local(np.column_stack((values[:, :2], _filled(altitude, origin[2]))), origin)
    local[unknown, 2] = np.nan
    return local


def _filled(altitude: FloatArray, level: float) -> FloatArray:
    known = np.flatnonzero(np.isfinite(altitude))
    if not len(known):
        return np.full(len(altitude), level)
    return np.interp(np.arange(len(altitude)), known, altitude[known])
