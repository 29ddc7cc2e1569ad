"""How loops are compiled: kept on disk, without the interpreter's lock, with the arithmetic as written."""

from numba import njit

compiled = njit(cache=True, nogil=True, fastmath=False, error_model="numpy", boundscheck=False)
