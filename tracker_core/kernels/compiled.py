"""How loops are compiled: kept on disk, without the interpreter's lock, with the arithmetic as written."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from numba import config, njit, types
from numba.extending import intrinsic

from tracker_core.kernels.target import settle

TARGET, ROOT = settle(config)
"""What the loops of this process are compiled for, and the folder of the folders that they are kept in."""

compiled = njit(cache=True, nogil=True, fastmath=False, error_model="numpy", boundscheck=False)

inlined = njit(inline="always", cache=True, nogil=True, fastmath=False, error_model="numpy", boundscheck=False)
"""A part of a loop, compiled anew wherever it is called: the compiler then knows the shapes of what it works on."""


def _fma(_typing: Any, _a: Any, _b: Any, _c: Any) -> Any:
    def build(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), build


fma: Callable[[float, float, float], float] = cast("Any", intrinsic(_fma))
"""a b + c with one rounding, hence with the same bits on every processor; one instruction on most."""
