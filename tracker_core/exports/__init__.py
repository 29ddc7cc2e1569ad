"""Results on their way out: tracks as CSV, runs as JSON, the tuned filter as code, and all of it in one zip."""

from tracker_core.exports.archive import Part, run_parts, write_archive
from tracker_core.exports.code import TunedFilter, sources, tuned_filter
from tracker_core.exports.summary import found_in, gains_dict, run_summary, write_columns, write_json
from tracker_core.exports.track import track_columns, write_track

__all__ = [
    "Part",
    "TunedFilter",
    "found_in",
    "gains_dict",
    "run_parts",
    "run_summary",
    "sources",
    "track_columns",
    "tuned_filter",
    "write_archive",
    "write_columns",
    "write_json",
    "write_track",
]
