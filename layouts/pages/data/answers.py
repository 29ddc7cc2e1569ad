"""What the Data page shows of a recording, and of how it is read whether or not that works."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from layouts.desk import Desk, Plot
from layouts.figures import recording
from layouts.figures.track import path_key
from layouts.pages.data.file import file_shown
from layouts.pages.data.numbers import numbers
from layouts.pages.data.words import counts_rows, facts_rows, findings_rows, found_text, gate_text
from layouts.run_cards import cards
from layouts.shown import Shown
from tracker_core.checks import InputError

NUMBERS = "data-numbers"


def report(shown: Shown) -> dict[str, Any]:
    """What was found in the recording, and how good the run is."""
    found = recording.recording_of(shown.settings.experiment)
    if found is None:
        return {"fields": {}, "rows": {name: [] for name in ("facts", "counts", "findings")}}
    return {
        "cards": cards(shown.result, shown.settings),
        "rows": {
            "facts": facts_rows(found, shown.result),
            "counts": counts_rows(found),
            "findings": findings_rows(found),
        },
        "texts": {"found-text": found_text(found), "gate-text": gate_text(shown.result)},
    }


def beside(controls: Mapping[str, Any]) -> dict[str, Any]:
    """The file that the controls name, its columns and first rows; nothing where it is not there."""
    data = str(controls.get("data") or "")
    try:
        return {"recording": file_shown(data, controls) if data else None}
    except InputError:
        return {"recording": None}


DESK = Desk(
    page="data",
    plots={
        "data-path": Plot(recording.marked_path_figure, recording.MARKED_PATH_MOVING, path_key),
        "data-intervals": Plot(recording.intervals_figure, recording.INTERVALS_MOVING, recording.intervals_key),
        "data-innovation": Plot(recording.innovation_figure, recording.INNOVATION_MOVING, recording.innovation_key),
    },
    tables={NUMBERS: numbers},
    report=report,
    sliders={},
    beside=beside,
)
