"""What the server has beside its pages, and pages may use."""

from __future__ import annotations

from dataclasses import dataclass

from layouts.scenes import Scenes
from layouts.studies import Studies


@dataclass(frozen=True, slots=True)
class Services:
    """What is handed to every page when it is registered.

    Attributes:
        scenes: scenes in three dimensions.
        studies: work that takes long.
    """

    scenes: Scenes
    studies: Studies
