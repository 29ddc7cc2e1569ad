"""Scenes in three dimensions, one for each browser, shown by viser behind the port of the application."""

from layouts.scenes.host import Scenes
from layouts.scenes.pictures import RegionPicture, TrackPicture
from layouts.scenes.sessions import Stats

__all__ = ["RegionPicture", "Scenes", "Stats", "TrackPicture"]
