"""What the 3-D page shows of a run."""

from __future__ import annotations

from typing import Any

import numpy as np

from layouts.desk import Desk, Plot
from layouts.figures import error, track
from layouts.filter_card import SLIDERS
from layouts.numbers import run_numbers
from layouts.scenes import TrackPicture
from layouts.shown import Shown

NUMBERS = "track-numbers"


def report(shown: Shown) -> dict[str, Any]:
    """How much larger deviations are drawn, what the errors are, and whether a gate refused anything."""
    factor, refused = shown.view.exaggerate, shown.result.track.rejected
    return {
        "texts": {
            "scale": "" if factor == 1 else f"deviations × {factor}",
            "error-title": error.title(shown.result),
        },
        "fields": {"refused": refused is not None and bool(refused.any())},
    }


def picture(shown: Shown) -> TrackPicture:
    """The run for the scene, deviations from the truth exaggerated as the view asks.

    What leaves the surroundings of truth and measurements is not drawn: a diverging filter would cross the whole scene.
    """
    times, series = shown.result.truth.times, track.positions(shown.result, shown.view)
    still = np.concatenate((series["truth"], series["observed"]))
    low, high = np.nanmin(still, axis=0), np.nanmax(still, axis=0)
    reach = 0.5 * float((high - low).max())
    inside = {
        name: np.where(((values >= low - reach) & (values <= high + reach)).all(axis=1)[:, None], values, np.nan)
        for name, values in series.items()
    }
    return TrackPicture(
        key=track.path_key(shown),
        times=times,
        **inside,
        cursor=shown.view.cursor(len(times)),
        trail=True,
        names=shown.result.scenario.axes,
        theme=shown.theme,
        refused=shown.result.track.rejected,
    )


DESK = Desk(
    page="track",
    plots={
        "track-path": Plot(track.path_figure, track.PATH_MOVING, track.path_key, often=True),
        "track-error": Plot(error.error_figure, error.MOVING, error.error_key),
    },
    tables={NUMBERS: run_numbers},
    report=report,
    sliders=SLIDERS,
    picture=picture,
)
