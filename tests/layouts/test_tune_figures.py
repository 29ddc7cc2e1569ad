"""The figures of studies: what they draw is what came out, in the colours of the tokens."""

import json
from dataclasses import replace

import numpy as np
import pytest

from layouts.figures.common import coordinates
from layouts.figures.stability_map import design_curves
from layouts.figures.tuning.look import KINDS, name_of, ticks
from layouts.figures.tuning.map import FIRST_LEVEL, REACH, map_figure, outline
from layouts.figures.tuning.search import search_figure
from layouts.figures.tuning.sweep import FEW_RUNS, stretches, sweep_figure
from layouts.theme import THEMES, tokens
from tracker_core import Experiment
from tracker_core.region import region_slice
from tracker_core.tuning import OBJECTIVES, Map, Search, Sweep
from tracker_core.tuning.sweeps import usual_values

SHIP = {"samples": 60}


def end_of(study):
    *_, last = study.stream()
    return last.outcome


def sweep(parameter="xi", objective="estimation_rmse", runs=4, points=31, beside=(), **values):
    experiment = Experiment.from_dict(SHIP | values)
    usual = usual_values(experiment, parameter, points=points)
    return end_of(Sweep(experiment, parameter, usual, objective, runs, beside=beside))


def drawn_sweep(outcome, theme, present):
    return sweep_figure(outcome, outcome.optimum(), theme, present)


def named(figure, name):
    return next(trace for trace in figure["data"] if trace["name"] == name)


def table(values):
    """A table of numbers as it was packed."""
    rows, columns = map(int, values["shape"].split(","))
    return coordinates(values).reshape(rows, columns)


def colours(part):
    """Everything in a figure that is a colour."""
    if isinstance(part, dict):
        for key, value in part.items():
            if key.endswith("color") and isinstance(value, str):
                yield value
            elif key == "colorscale":
                yield from (colour for _, colour in value)
            elif key != "template":
                yield from colours(value)
    elif isinstance(part, list):
        for each in part:
            yield from colours(each)


@pytest.fixture(scope="module")
def searched():
    return end_of(Search(Experiment.from_dict(SHIP | {"order": 2}), "estimation_rmse", runs=3, budget=2_000))


@pytest.fixture(scope="module")
def mapped():
    study = Map(Experiment.from_dict(SHIP | {"order": 2}), ("alpha", "beta"), "estimation_rmse", 24, 20, runs=3)
    return study, end_of(study)


# Sweep -------------------------------------------------------------------------------------------------------------


def test_a_sweep_draws_mean_interval_and_runs():
    outcome = sweep()
    figure = drawn_sweep(outcome, "light", 0.64)
    mean, width = outcome.mean()
    values = outcome.sweep.values
    curve = named(figure, "Estimation RMSE")
    np.testing.assert_allclose(coordinates(curve["x"]), values, rtol=1e-6)
    np.testing.assert_allclose(coordinates(curve["y"]), mean, rtol=1e-6)
    band = coordinates(named(figure, "95 % of the mean")["y"])
    expected = np.concatenate((mean - width, (mean + width)[::-1], [np.nan]))
    np.testing.assert_allclose(band, expected, rtol=1e-6)
    runs = coordinates(named(figure, "Single runs")["y"]).reshape(4, -1)
    np.testing.assert_allclose(runs[:, :-1], outcome.scores[0], rtol=1e-6)
    assert np.isnan(runs[:, -1]).all()
    best = outcome.optimum()
    assert (named(figure, "Best")["x"], named(figure, "Best")["y"]) == ([best.value], [best.score.mean])


def test_the_present_value_is_a_line_that_can_be_moved():
    for value in (0.64, None, 0.0):
        figure = drawn_sweep(sweep(), "light", value)
        shape = figure["layout"]["shapes"][figure["layout"]["meta"]["present"]]
        assert shape["label"]["text"] == "present"
        assert shape["visible"] == (value is not None)
        assert shape["x0"] == shape["x1"] == (value or 0)


def test_the_interval_of_the_best_value_is_shaded():
    outcome = sweep()
    best = outcome.optimum()
    (band,) = (s for s in drawn_sweep(outcome, "light", None)["layout"]["shapes"] if s.get("opacity"))
    assert (band["x0"], band["x1"]) == (best.low, best.high)
    single = sweep(runs=1)
    assert not [s for s in drawn_sweep(single, "light", None)["layout"]["shapes"] if s.get("opacity")]
    names = [trace["name"] for trace in drawn_sweep(single, "light", None)["data"]]
    assert "Single runs" not in names


def test_unstable_values_are_shaded_and_not_drawn():
    """Benedict-Bordner gains are stable up to alpha = 4 - sqrt(8)."""
    outcome = sweep("alpha", order=2, design="benedict-bordner", alpha=0.5)
    figure = drawn_sweep(outcome, "light", 0.5)
    (shade,) = (s for s in figure["layout"]["shapes"] if s.get("label", {}).get("text") == "unstable")
    step = outcome.sweep.values[1] - outcome.sweep.values[0]
    assert shade["x0"] == pytest.approx(4 - np.sqrt(8), abs=step / 2)
    assert shade["x1"] == outcome.sweep.values[-1]
    drawn = coordinates(named(figure, "Estimation RMSE")["y"])
    np.testing.assert_array_equal(np.isfinite(drawn), outcome.stable)


def test_axes_follow_the_parameter_and_the_span_of_the_score():
    figure = drawn_sweep(sweep("tracking_index"), "light", None)
    assert figure["layout"]["xaxis"]["type"] == "log"
    np.testing.assert_allclose(figure["layout"]["xaxis"]["range"], [-4, 2])
    assert figure["layout"]["yaxis"]["type"] == "log"
    narrow = drawn_sweep(sweep("xi", objective="innovation_rmse"), "light", None)
    assert "type" not in narrow["layout"]["xaxis"]
    flat = end_of(Sweep(Experiment.from_dict(SHIP), "xi", (0.5, 0.55, 0.6), "estimation_rmse", 3))
    low, high = drawn_sweep(flat, "light", None)["layout"]["yaxis"]["range"]
    mean, width = flat.mean()
    assert low < (mean - width).min()
    assert high > (mean + width).max()


def test_what_is_known_beside_it_is_drawn_beside_it():
    outcome = sweep(objective="innovation_rmse", beside=("estimation_rmse",))
    figure = drawn_sweep(outcome, "light", None)
    mean, _ = outcome.mean(1)
    np.testing.assert_allclose(coordinates(named(figure, "Estimation RMSE")["y"]), mean, rtol=1e-6)
    assert named(figure, "Estimation RMSE")["line"]["dash"] == "4px 3px"
    assert figure["layout"]["yaxis"]["title"]["text"] == "RMSE (m)"


def test_many_runs_are_not_drawn_one_by_one():
    outcome = sweep(points=5, runs=FEW_RUNS + 1)
    assert "Single runs" not in [trace["name"] for trace in drawn_sweep(outcome, "light", None)["data"]]


def test_nothing_that_can_be_drawn_is_still_a_figure():
    """A filter that is unstable everywhere."""
    experiment = Experiment.from_dict(SHIP | {"order": 2, "alpha": 0.5, "beta": 0.2})
    outcome = end_of(Sweep(experiment, "alpha", (1.95, 1.97, 1.99), "estimation_rmse", 2))
    assert not outcome.stable.any()
    figure = drawn_sweep(outcome, "light", None)
    assert figure["layout"]["yaxis"]["range"] == [0, 1]
    assert "Best" not in [trace["name"] for trace in figure["data"]]
    json.dumps(figure, allow_nan=False)


def test_stretches_of_marked_places():
    assert stretches(np.array([True, False, True, True, False, True])) == [(0, 1), (2, 4), (5, 6)]
    assert stretches(np.zeros(3, dtype=bool)) == []


# Map ---------------------------------------------------------------------------------------------------------------


def test_a_map_is_coloured_by_the_logarithm_and_keeps_the_scores(mapped):
    study, outcome = mapped
    heat = map_figure(study, outcome, "light")["data"][0]
    mean = outcome.mean()
    np.testing.assert_allclose(table(heat["customdata"]), mean, rtol=1e-6)
    low = np.nanmin(mean)
    np.testing.assert_allclose(table(heat["z"]), np.log10(np.minimum(mean, REACH * low)), rtol=1e-6)
    assert heat["zmin"] == pytest.approx(np.log10(low))
    bar = heat["colorbar"]
    for place, text in zip(bar["tickvals"], bar["ticktext"], strict=True):
        assert 10**place == pytest.approx(float(text))
    np.testing.assert_allclose(coordinates(heat["x"]), outcome.x, rtol=1e-6)
    assert json.dumps(map_figure(study, outcome, "dark"), allow_nan=False)


def test_level_lines_are_multiples_of_the_best_score(mapped):
    study, outcome = mapped
    lines = map_figure(study, outcome, "light")["data"][1]
    ratio = outcome.mean() / np.nanmin(outcome.mean())
    drawn = table(lines["z"])
    for level in range(int(lines["contours"]["end"]) + 1):
        inside = ratio <= FIRST_LEVEL ** (2**level)
        np.testing.assert_array_equal(drawn[outcome.stable] <= level + 1e-6, inside[outcome.stable])
    assert lines["name"] == "5, 10, 22, 48, 118 % above the best"


def test_a_map_has_border_curves_and_the_best_cell(mapped):
    study, outcome = mapped
    figure = map_figure(study, outcome, "light")
    border = region_slice(study.experiment.gains(), study.plane)
    np.testing.assert_allclose(coordinates(named(figure, "Edge of stability")["x"]), border[0], atol=1e-6)
    for name, curve in design_curves(2, ("alpha", "beta")):
        np.testing.assert_allclose(coordinates(named(figure, name)["y"]), curve[:, 1], atol=1e-6)
    best = named(figure, "Best cell")
    assert [best["x"][0], best["y"][0]] == outcome.vectors[outcome.best()].tolist()
    assert figure["layout"]["meta"] == {"study": "map", "theme": "light", "runs": 3, "plane": ["alpha", "beta"]}


def test_a_plane_is_normalised_and_says_so_where_gains_are_written_otherwise():
    experiment = Experiment.from_dict(SHIP | {"order": 3, "convention": "half"})
    study = Map(experiment, ("beta", "gamma"), "estimation_rmse", 6, 6, runs=1)
    figure = map_figure(study, end_of(study), "light")
    titles = [figure["layout"][axis]["title"]["text"] for axis in ("xaxis", "yaxis")]
    assert titles == ["β", "γ (normalised)"]
    assert "β %{x:.3~g}, γ (normalised) %{y:.3~g}" in figure["data"][0]["hovertemplate"]
    plain = replace(study, experiment=replace(experiment, convention="normalised"))
    assert map_figure(plain, end_of(plain), "light")["layout"]["yaxis"]["title"]["text"] == "γ"
    # Two of three gains: the designs' third one is their own.
    curves = [f"{name}, projected" for name, _ in design_curves(3, ("beta", "gamma"))]
    assert {trace["name"] for trace in figure["data"]} >= set(curves)


def test_the_outline_goes_round_the_marked_cells():
    x, y = np.array([0.5, 1.5, 2.5]), np.array([10.0, 30.0])
    marked = np.array([[True, True, False], [False, False, False]])
    found_x, found_y = outline(x, y, marked)
    edges = {
        tuple(sorted(zip(found_x[i : i + 2].tolist(), found_y[i : i + 2].tolist(), strict=True)))
        for i in range(0, len(found_x), 3)
    }
    assert edges == {
        ((0, 0), (0, 20)), ((2, 0), (2, 20)),
        ((0, 0), (1, 0)), ((1, 0), (2, 0)), ((0, 20), (1, 20)), ((1, 20), (2, 20)),
    }  # fmt: skip
    assert np.isnan(found_x[2::3]).all()


def test_a_map_whose_runs_all_stop_is_still_a_figure(mapped):
    study, outcome = mapped
    nothing = replace(outcome, scores=np.full_like(outcome.scores, np.nan))
    figure = map_figure(study, nothing, "light")
    assert "Best cell" not in [trace["name"] for trace in figure["data"]]
    json.dumps(figure, allow_nan=False)


# Search ------------------------------------------------------------------------------------------------------------


def test_a_search_is_drawn_beside_the_designs(searched):
    figure = search_figure(searched, "light")
    line = named(figure, "Best found so far")
    np.testing.assert_allclose(coordinates(line["y"]), searched.history, rtol=1e-6)
    assert coordinates(line["x"])[0] == 1
    low, high = figure["layout"]["yaxis"]["range"]
    assert low < searched.score < high
    for rival in searched.rivals:
        assert named(figure, rival.title)["y"] == [rival.score, rival.score]
    begun = replace(searched, history=(), rivals=(), gains=None, score=np.inf, fresh=None)
    assert search_figure(begun, "light")["layout"]["yaxis"]["range"] == [0, 1]


# Look --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("theme", THEMES)
def test_every_colour_is_a_token(theme, mapped, searched):
    known = set(tokens(theme).values()) | {"rgba(0,0,0,0)"}
    unstable = sweep("alpha", order=2, design="benedict-bordner", alpha=0.5)
    for figure in (
        drawn_sweep(sweep(), theme, 0.5),
        drawn_sweep(unstable, theme, 0.5),
        map_figure(*mapped, theme),
        search_figure(searched, theme),
    ):
        assert set(colours(figure)) <= known
        assert figure["layout"]["meta"]["theme"] == theme


def test_every_objective_has_a_colour_and_a_name():
    for name, objective in OBJECTIVES.items():
        assert KINDS[objective.kind] in tokens("light")
        assert f"{KINDS[objective.kind]}-faint" in tokens("light")
        assert name_of(name)[0].isupper()
    assert name_of("estimation_rmse") == "Estimation RMSE"
    assert name_of("tracking_max") == "Greatest tracking error"


@pytest.mark.parametrize(("low", "high"), [(11.9, 13.2), (12, 70), (3, 5000), (0.01, 0.02), (99.5, 101)])
def test_a_scale_has_some_round_numbers(low, high):
    found = ticks(low, high)
    assert 3 <= len(found) <= 12
    for value, text in found:
        assert low <= value <= high
        assert float(text) == pytest.approx(value)
        assert len(text) <= 5
