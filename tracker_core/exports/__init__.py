"""Results on their way out: tracks as CSV."""

from tracker_core.exports.track import track_columns, write_track

__all__ = ["track_columns", "write_track"]
