"""Gainscope's core: fixed-gain tracking filters, their design, stability and figures of merit.

>>> from tracker_core import Experiment, run_experiment
>>> result = run_experiment(Experiment.from_dict({"scenario": "garg-constant-velocity"}))
>>> round(float(result.track.smoothed[0, 0, 0]), 1)
30194.2
"""

from tracker_core.checks import InputError
from tracker_core.consistency import model_covariance
from tracker_core.conventions import CONVENTIONS, Gains
from tracker_core.design import DESIGNS
from tracker_core.experiment import Experiment
from tracker_core.filters import run_filter
from tracker_core.gating import Gate
from tracker_core.metrics import METRICS, Metrics
from tracker_core.optimal import distance_from_optimal, optimal_gains
from tracker_core.poles import gains_from_poles
from tracker_core.region import nearest_stable, region_slice
from tracker_core.responses import frequency_response, step_figures, time_response, variance_reduction
from tracker_core.run import Result, run_experiment
from tracker_core.scenarios import SCENARIOS
from tracker_core.stability import Verdict, assess
from tracker_core.starts import STARTS
from tracker_core.types import Measurements, Track, Truth

__all__ = [
    "CONVENTIONS",
    "DESIGNS",
    "METRICS",
    "SCENARIOS",
    "STARTS",
    "Experiment",
    "Gains",
    "Gate",
    "InputError",
    "Measurements",
    "Metrics",
    "Result",
    "Track",
    "Truth",
    "Verdict",
    "assess",
    "distance_from_optimal",
    "frequency_response",
    "gains_from_poles",
    "model_covariance",
    "nearest_stable",
    "optimal_gains",
    "region_slice",
    "run_experiment",
    "run_filter",
    "step_figures",
    "time_response",
    "variance_reduction",
]
