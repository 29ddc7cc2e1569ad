"""The tuned filter as source code that needs nothing: Python, C, MATLAB and Octave, and a FilterPy configuration."""

from tracker_core.exports.code.sources import sources
from tracker_core.exports.code.tuned import TunedFilter, tuned_filter

__all__ = ["TunedFilter", "sources", "tuned_filter"]
