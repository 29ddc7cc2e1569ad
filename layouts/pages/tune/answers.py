"""What the Tune page shows of a run, beside its study."""

from __future__ import annotations

from typing import Any

from layouts.desk import Desk, Plot
from layouts.figures import error
from layouts.figures.handles import gains_handle
from layouts.filter_card import SLIDERS
from layouts.pages.tune.content import PLOT
from layouts.pages.tune.present import present_value
from layouts.pages.tune.words import data_note, gains_text
from layouts.run_cards import cards
from layouts.shown import Shown
from layouts.tuning import fields_in_use, objectives_offered
from tracker_core.tuning.sweeps import offered


def report(shown: Shown) -> dict[str, Any]:
    """Cards, what can be chosen, and where the present filter stands in the study's plot."""
    tuning, experiment = shown.view.tuning, shown.settings.experiment
    parameter = tuning.parameter(experiment)
    handle = gains_handle(shown.result.gains, shown.view.plane)
    # As the boxes and the sentences have them; the plane is normalised.
    handle |= {"labels": [f"Present gains: {gains_text(shown.result.gains)}"]}
    if tuning.study != "map":
        handle |= {"points": [], "labels": [], "tones": []}
    return {
        "cards": cards(shown.result, shown.settings),
        "handles": {PLOT: handle},
        "fields": fields_in_use(tuning, experiment),
        "offers": {"tune_for": objectives_offered(tuning, experiment), "against": list(offered(experiment))},
        "texts": {
            "data-note": data_note(shown.result),
            "error-title": f"The present filter's {error.title(shown.result).lower()}",
        },
        "blind": not shown.result.truth.known,
        "present": {"parameter": parameter, "value": present_value(experiment, parameter)},
    }


DESK = Desk(
    page="tune",
    plots={"tune-error": Plot(error.error_figure, error.MOVING, error.error_key, often=True)},
    tables={},
    report=report,
    sliders=SLIDERS | {"noise_weight": {"low": 0, "high": 1, "curve": 1}},
)
