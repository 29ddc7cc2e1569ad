"""Studies: many runs of many filters, in parts that any executor can compute, with the same bits everywhere."""

from tracker_core.tuning.base import Progress
from tracker_core.tuning.maps import Map, MapOutcome
from tracker_core.tuning.monte_carlo import Comparison, MonteCarlo
from tracker_core.tuning.objectives import OBJECTIVES, Objective
from tracker_core.tuning.rivals import Rival
from tracker_core.tuning.search import Fresh, Search, SearchOutcome
from tracker_core.tuning.sweeps import PARAMETERS, Optimum, Sweep, SweepOutcome

__all__ = [
    "OBJECTIVES",
    "PARAMETERS",
    "Comparison",
    "Fresh",
    "Map",
    "MapOutcome",
    "MonteCarlo",
    "Objective",
    "Optimum",
    "Progress",
    "Rival",
    "Search",
    "SearchOutcome",
    "Sweep",
    "SweepOutcome",
]
