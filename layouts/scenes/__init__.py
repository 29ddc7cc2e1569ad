"""Scenes in three dimensions, one for each browser, shown by viser behind the port of the application."""

from layouts.scenes.host import Scenes
from layouts.scenes.page import publish
from layouts.scenes.pictures import RegionPicture, TrackPicture
from layouts.scenes.sessions import TOKEN, Stats

__all__ = ["TOKEN", "RegionPicture", "Scenes", "Stats", "TrackPicture", "publish"]
