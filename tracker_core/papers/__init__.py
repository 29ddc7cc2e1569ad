"""The source documents: their citations and the runs they report, as data."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from tracker_core.experiment import Experiment


@dataclass(frozen=True, slots=True)
class Run:
    """One run that a document reports.

    Attributes:
        name: key within the document.
        title: for menus.
        note: what to look at, or where the document and the run differ.
        experiment: its description.
    """

    name: str
    title: str
    note: str
    experiment: Experiment


@dataclass(frozen=True, slots=True)
class Paper:
    """One source document.

    Attributes:
        name: key in the registry.
        title: short, for menus.
        citation: in full.
        runs: in the order of the document.
    """

    name: str
    title: str
    citation: str
    runs: tuple[Run, ...]


NAMES = ("jeong2017", "njonjo2016", "yu2017", "alwagih", "garg2021")


@cache
def papers() -> dict[str, Paper]:
    """All source documents that have runs, by name."""
    return {name: _load(name) for name in NAMES}


def _load(name: str) -> Paper:
    data: dict[str, Any] = tomllib.loads(files(__package__).joinpath(f"{name}.toml").read_text(encoding="utf-8"))
    runs = tuple(
        Run(run["name"], run["title"], run["note"], Experiment.from_dict(run["experiment"])) for run in data["runs"]
    )
    return Paper(name, data["title"], data["citation"], runs)
