"""With which types every kernel is called: what is compiled before anybody waits for it."""

from __future__ import annotations

from numba import types

_F, _I, _B = types.float64, types.int64, types.boolean
_F1, _F2, _F3, _F4 = _F[::1], _F[:, ::1], _F[:, :, ::1], _F[:, :, :, ::1]
_I1, _B1, _B2 = _I[::1], _B[::1], _B[:, ::1]
_FIXED = types.Array(_F, 2, "C", readonly=True)


def _lanes(measured: types.Array, true: types.Array) -> tuple[types.Type, ...]:
    return (measured, true, _B1, _B2, _F, _F3, _F3, _F2, _F3, _F, _F, _B1, _B, _F4)


Signatures = tuple[tuple[types.Type, ...], ...]

FIRST: dict[str, Signatures] = {
    "least_squares_start": ((_F1, _F1, _F, _F1, _F2, _I, _F2, _F2),),
    "track": ((_F2, _F1, _F1, _F2, _I1, _F, _F3, _F3, _F2),),
    "finish": ((_F2, _I, _F3, _F3, _F2),),
    "step_response": ((_F2, _F, _I, _F1, _F1),),
    "autoregress": ((_F1, _F1),),
}
"""What pages need that are opened for the first time; what takes longest to compile comes first."""

LATER: dict[str, Signatures] = {
    "gated_track": (
        (_F2, _F1, _F1, _F2, _I1, _B1, _F2, _I1, _B1, _F3, _F1, _F, _F, _F, _I, _F, _F, _F3, _F3, _F2, _B1),
    ),
    "lane_errors": (_lanes(_F2, _F2), _lanes(_F3, _F2), _lanes(_F3, _F3)),
    "profile": ((_F2, _B1, _F1, _I, _F1, _F, _I, _F3),),
    "deletions": ((_F2, _B1, _F1, _I, _F, _F, _F2),),
    "track_errors": ((_F2, _F2, _F1, _F2, _F2, _I1, _F2, _F2, _F, _F3),),
    "sample_search": ((_F1, _F1, _F1, _I, _FIXED, _B, _I1, _I1, _F1, _I, _F, _F2, _F2, _F2),),
    "bank_mixture": ((_F2, _F1, _F2, _F3, _I1, _F, _F1, _F3, _F3, _F3, _F2),),
    "scheduled": ((_F1, _F1, _F2, _F1, _I, _F, _F2, _F2, _F2),),
    "bank_choice": ((_F1, _F1, _F2, _F1, _I, _F, _F1, _F2, _F2, _F2, _I1),),
    "candidate_scores": ((_F1, _F1, _F1, _I, _FIXED, _F1, _I, _F, _F1),),
    "window_search": ((_F1, _F1, _F, _I, _I, _I, _I, _B, _F1, _I, _F, _F2, _F2, _F2),),
    "transposed": ((_F3, _I1, _F3, _B1),),
    "weight_costs": ((_F1, _F1, _F2, _F, _F1, _F1, _I, _F, _B, _F1),),
}  # fmt: skip
"""What gates, suggestions, studies and the methods of the papers need."""

SIGNATURES: dict[str, Signatures] = FIRST | LATER
