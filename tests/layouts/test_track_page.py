"""What the 3-D page shows: the run as its scene is given it."""

import math

import numpy as np
import pytest

from layouts.desk import answer
from layouts.pages.track.answers import DESK, picture
from layouts.shown import Shown
from layouts.state import EXAGGERATIONS, Settings, View
from layouts.theme import THEMES
from tracker_core import SCENARIOS, Experiment, run_experiment

WILD = {"design": "manual", "order": 2, "alpha": 1.9, "beta": 1.5}
SERIES = ("truth", "observed", "predicted", "smoothed")


def made(view=None, theme="light", **values):
    """The picture of a run, and the run."""
    experiment = Experiment.from_dict(values)
    result = run_experiment(experiment)
    return picture(Shown(result, Settings(experiment, view or View()), theme, {})), result


def series_of(result):
    positions = (result.truth.positions, result.measurements.positions,
                 result.track.predicted[:, :, 0], result.track.smoothed[:, :, 0])  # fmt: skip
    return dict(zip(SERIES, positions, strict=True))


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("theme", THEMES)
def test_the_scene_shows_the_run(scenario, theme):
    got, result = made(scenario=scenario, theme=theme, design="fading-memory", order=2, xi=0.6)
    np.testing.assert_array_equal(got.times, result.truth.times)
    for name, values in series_of(result).items():
        drawn = getattr(got, name)
        shown = np.isfinite(drawn).all(axis=1)
        np.testing.assert_array_equal(drawn[shown], values[shown])
        # What is left out is what nobody knows, and what the start throws far off.
        assert shown.mean() > 0.7
    assert np.isfinite(got.truth).all()
    assert got.names == SCENARIOS[scenario].axes
    assert (got.theme, got.trail) == (theme, True)


@pytest.mark.parametrize(("at", "cursor"), [(None, 100), (0, 0), (7, 7), (199, 199)])
def test_the_scene_looks_at_the_sample_of_the_page(at, cursor):
    assert made(View(at=at), samples=200)[0].cursor == cursor


@pytest.mark.parametrize("scenario", ["constant-velocity", "garg-accelerating"])
@pytest.mark.parametrize("factor", [int(factor) for factor in EXAGGERATIONS])
def test_deviations_are_exaggerated_as_on_the_path(factor, scenario):
    got, result = made(View(exaggerate=factor), scenario=scenario, samples=10)
    truth = result.truth.positions
    np.testing.assert_array_equal(got.truth, truth)
    for name, values in series_of(result).items():
        drawn = getattr(got, name)
        inside = np.isfinite(drawn).all(axis=1)
        exact = values if factor == 1 else truth + factor * (values - truth)
        np.testing.assert_array_equal(drawn[inside], exact[inside])
        assert inside.any()


@pytest.mark.parametrize("scenario", ["jeong-ship", "garg-accelerating"])
def test_what_leaves_the_surroundings_of_the_target_is_not_drawn(scenario):
    got, result = made(scenario=scenario, samples=10 if scenario.startswith("garg") else 100, **WILD)
    still = np.concatenate((result.truth.positions, result.measurements.positions))
    low, high = np.nanmin(still, axis=0), np.nanmax(still, axis=0)
    reach = 0.5 * (high - low).max()
    for name, values in series_of(result).items():
        drawn = getattr(got, name)
        for row, exact in zip(drawn, values, strict=True):
            inside = all(a - reach <= value <= b + reach for a, value, b in zip(low, exact, high, strict=True))
            # A point is drawn whole or not at all; NaN is inside nothing.
            assert (row.tolist() == exact.tolist()) if inside else all(map(math.isnan, row))
    assert np.isfinite(got.truth).all()
    assert np.isfinite(got.observed).all()


def test_what_diverges_does_leave():
    got, _ = made(samples=100, **WILD)
    assert np.isnan(got.smoothed[-1]).all()
    assert np.isfinite(got.smoothed[:3]).any()


def test_the_scene_is_drawn_anew_where_the_target_is_another_and_not_where_the_filter_is():
    usual = {"samples": 100, "design": "fading-memory", "order": 3}
    key = made(**usual, xi=0.5)[0].key
    assert made(**usual, xi=0.7)[0].key == made(View(at=3), **usual, xi=0.5)[0].key == key
    others = [
        made(View(exaggerate=5), **usual, xi=0.5),
        made(**{**usual, "samples": 101}, xi=0.5),
        *(made(**usual, xi=0.5, **more) for more in ({"seed": 2}, {"noise_std": 11}, {"interval": 2})),
    ]
    keys = [other.key for other, _ in others]
    assert key not in keys
    assert len(set(keys)) == len(keys)


@pytest.mark.parametrize(("factor", "text"), [(1, ""), (20, "deviations × 20")])
def test_an_exaggeration_is_told(controls_for, request_for, factor, text):
    assert answer(DESK, request_for(controls_for(View(exaggerate=factor))))[1]["texts"]["scale"] == text
