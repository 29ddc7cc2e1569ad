"""The compiled recursions: textbook loops, one axis after the other.

Every kernel fills arrays made by its caller. Gains are normalised; `dt` holds the interval before each sample, or one
number if it is constant; a NaN measurement is bridged by prediction. The state after the start stands in `state` and
the recursion begins at sample `begin`. Nothing is validated here.
"""

from tracker_core.kernels.banks import bank_choice, bank_mixture
from tracker_core.kernels.errors import track_errors
from tracker_core.kernels.gate import gated_track
from tracker_core.kernels.lanes import lane_errors, transposed
from tracker_core.kernels.likelihood import deletions, profile
from tracker_core.kernels.recursions import autoregress, finish, least_squares_start, step_response, track
from tracker_core.kernels.selections import (
    candidate_scores,
    sample_search,
    scheduled,
    weight_costs,
    window_search,
)
from tracker_core.kernels.steps import LANES

__all__ = [
    "LANES",
    "autoregress",
    "bank_choice",
    "bank_mixture",
    "candidate_scores",
    "deletions",
    "finish",
    "gated_track",
    "lane_errors",
    "least_squares_start",
    "profile",
    "sample_search",
    "scheduled",
    "step_response",
    "track",
    "track_errors",
    "transposed",
    "weight_costs",
    "window_search",
]
