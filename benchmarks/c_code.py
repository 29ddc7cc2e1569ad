"""reference.c, compiled on the spot with gcc -O3 -march=native and called with NumPy's arrays."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tracker_core.types import FloatArray

SOURCE = Path(__file__).with_name("reference.c")
FLAGS = ("-O3", "-march=native", "-shared", "-fPIC")

_ARRAY, _LONG, _REAL = np.ctypeslib.ndpointer(np.float64, flags="C"), ctypes.c_long, ctypes.c_double
_WHOLE = np.ctypeslib.ndpointer(np.int64, flags="C")


class Track(ctypes.Structure):
    """What `run_track` makes: pointers to its arrays."""

    _fields_ = [(name, ctypes.POINTER(_REAL)) for name in ("predicted", "smoothed", "innovation")]


@cache
def library() -> Any:
    """The compiled functions."""
    folder = tempfile.mkdtemp(prefix="gainscope-c-")
    path = f"{folder}/reference.so"
    subprocess.run(["gcc", *FLAGS, "-o", path, str(SOURCE), "-lm"], check=True)
    made = ctypes.CDLL(path)
    made.run_track.restype = Track
    made.run_track.argtypes = [_LONG, _LONG, _LONG, _ARRAY, _REAL, _ARRAY]
    made.free_track.argtypes = [Track]
    made.map_rmse.argtypes = [_LONG, _LONG, _LONG, _ARRAY, _ARRAY, _REAL, _ARRAY, _ARRAY]
    made.monte_carlo.argtypes = [
        _LONG, _LONG, _LONG, _LONG, _ARRAY, _ARRAY, _REAL, _ARRAY, _WHOLE, _ARRAY, _ARRAY,
    ]  # fmt: skip
    made.sample_search.argtypes = [_LONG, _LONG, _LONG, _LONG, _ARRAY, _ARRAY, _REAL, _ARRAY, _ARRAY, _ARRAY]
    for name in ("free_track", "map_rmse", "monte_carlo", "sample_search"):
        getattr(made, name).restype = None
    return made


def compiler() -> str:
    """Which gcc it is."""
    return subprocess.run(["gcc", "--version"], check=True, capture_output=True, text=True).stdout.splitlines()[0]


def track(z: FloatArray, t: float, g: FloatArray, *, keep: bool = False) -> tuple[FloatArray, ...]:
    """Filter every axis of z (n, axes): predicted and smoothed (n, axes, order), innovation (n, axes).

    Without `keep` the arrays are made, filled and thrown away.
    """
    n, axes = z.shape
    made = library().run_track(len(g), n, axes, z, t, g)
    found: tuple[FloatArray, ...] = ()
    if keep:
        states = (
            np.ctypeslib.as_array(part, (axes, n, len(g))).transpose(1, 0, 2).copy()
            for part in (made.predicted, made.smoothed)
        )
        found = (*states, np.ctypeslib.as_array(made.innovation, (n, axes)).copy())
    library().free_track(made)
    return found


def map_rmse(z: FloatArray, truth: FloatArray, t: float, gains: FloatArray) -> FloatArray:
    """Estimation RMSE of gain sets (m, 2), shape (m,)."""
    found = np.empty(len(gains))
    library().map_rmse(len(gains), *z.shape, z, truth, t, gains, found)
    return found


def monte_carlo(z: FloatArray, truth: FloatArray, t: float, gains: list[FloatArray], state: FloatArray) -> FloatArray:
    """Total, RMSE, greatest and L2 of tracking, estimation and innovation: shape (filters, runs, 3, 4)."""
    padded = np.array([np.pad(g, (0, 4 - len(g))) for g in gains])
    orders = np.array([len(g) for g in gains])
    found = np.empty((len(gains), len(z), 3, 4))
    library().monte_carlo(*z.shape, len(gains), z, truth, t, padded, orders, state, found)
    return found


def sample_search(
    z: FloatArray, wanted: FloatArray, t: float, sets: FloatArray, which: int
) -> tuple[FloatArray, FloatArray]:
    """Predicted and smoothed states (axes, n, 4); what lies before the third sample is not filled in."""
    n, axes = z.shape
    predicted, smoothed = np.empty((axes, n, 4)), np.empty((axes, n, 4))
    library().sample_search(len(sets), which, n, axes, z, wanted, t, sets, predicted, smoothed)
    return predicted, smoothed
