"""The web laboratory on top of tracker_core."""
