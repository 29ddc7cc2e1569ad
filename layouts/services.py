"""What the server has beside its pages, and pages may use."""

from __future__ import annotations

from dataclasses import dataclass

from fastapi import FastAPI

from layouts.scenes import Scenes
from layouts.studies import Studies
from server import metrics
from server.helpers import Helpers
from server.work import Work


@dataclass(frozen=True, slots=True)
class Services:
    """What is handed to every page when it is registered.

    Attributes:
        scenes: scenes in three dimensions.
        studies: what takes minutes.
        work: answers that take more than a moment.
        helpers: other processes for those that take none, where there are many.
    """

    scenes: Scenes
    studies: Studies
    work: Work
    helpers: Helpers

    def attach(self, server: FastAPI) -> None:
        """Serve what is no page's, and show how much there is to do."""
        self.scenes.attach(server)
        watch = metrics.watch
        watch("gainscope_scenes", "Scenes in three dimensions that are open.", lambda: self.scenes.stats().sessions)
        watch("gainscope_studies_running", "Studies that run.", lambda: self.studies.load()[0])
        watch("gainscope_studies_waiting", "Studies that wait for their turn.", lambda: self.studies.load()[1])
        watch("gainscope_study_processes", "Other processes that compute studies.", self.studies.processes)
        watch("gainscope_helpers", "Other processes that compute answers.", self.helpers.running)
