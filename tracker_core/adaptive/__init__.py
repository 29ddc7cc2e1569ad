"""Methods that choose the gains while the filter runs: one file each, and the ordered registry."""

from tracker_core.adaptive import (
    bank,
    benedict_bordner,
    critically_damped_bank,
    growing_memory,
    linear_combination,
    moving_window,
    sample_search,
)
from tracker_core.adaptive.base import Method, Selection, Shape
from tracker_core.adaptive.parameters import PARAMETERS

METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        benedict_bordner.METHOD,
        growing_memory.METHOD,
        linear_combination.METHOD,
        moving_window.METHOD,
        bank.CAUSAL,
        critically_damped_bank.METHOD,
        bank.ORACLE,
        sample_search.PER_SAMPLE,
        sample_search.FOR_THE_RUN,
    )
}

__all__ = ["METHODS", "PARAMETERS", "Method", "Selection", "Shape"]
