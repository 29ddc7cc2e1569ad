"""How loops are compiled: kept on disk, without the interpreter's lock, with the arithmetic as written."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any, cast

from numba import config, njit, types
from numba.extending import intrinsic


def _keep_by_source() -> None:
    """Keep compiled loops in a folder that is named after the source of all of them.

    Numba compiles a loop anew when the file of that loop has changed, but not when one that it calls has.
    """
    here = Path(__file__).parent
    source = b"".join(path.read_bytes() for path in sorted(here.glob("*.py")))
    settings: Any = config
    settings.CACHE_DIR = str(Path(settings.CACHE_DIR or here / "__pycache__") / sha256(source).hexdigest()[:16])


_keep_by_source()

compiled = njit(cache=True, nogil=True, fastmath=False, error_model="numpy", boundscheck=False)

inlined = njit(inline="always", cache=True, nogil=True, fastmath=False, error_model="numpy", boundscheck=False)
"""A part of a loop, compiled anew wherever it is called: the compiler then knows the shapes of what it works on."""


def _fma(_typing: Any, _a: Any, _b: Any, _c: Any) -> Any:
    def build(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), build


fma: Callable[[float, float, float], float] = cast("Any", intrinsic(_fma))
"""a b + c with one rounding, hence with the same bits on every processor; one instruction on most."""
