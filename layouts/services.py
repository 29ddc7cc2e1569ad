"""What the server has beside its pages, and pages may use."""

from __future__ import annotations

from dataclasses import dataclass

from layouts.scenes import Scenes
from layouts.studies import Studies
from server.work import Work


@dataclass(frozen=True, slots=True)
class Services:
    """What is handed to every page when it is registered.

    Attributes:
        scenes: scenes in three dimensions.
        studies: what takes minutes.
        work: answers that take more than a moment.
    """

    scenes: Scenes
    studies: Studies
    work: Work
