"""Figures of methods: the gains over the run, their trail on the map, the causal counterpart; live as well."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layouts.desk import answer, live_answer
from layouts.figures import error, gains, stability_map, track
from layouts.figures.common import coordinates, moving_traces
from layouts.figures.stability_map import POINT, TRAIL, TRAIL_POINTS, trail
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pages.track.answers import DESK as TRACK
from layouts.shown import Shown
from layouts.state import Settings, View
from tracker_core import CONVENTIONS, DESIGNS, Experiment, run_experiment
from tracker_core.adaptive import METHODS
from tracker_core.region import PLANES
from tracker_core.types import GAIN_NAMES

NAMES = [name for name in METHODS if name not in DESIGNS]
SERVED = [(name, order) for name in NAMES for order in METHODS[name].orders]
PLANES_SERVED = [(name, order, plane) for name, order in SERVED for plane in PLANES[order]]
SHORT = {"samples": 90}
COUNTERPART = {"path": 5, "close-up": 5, "error": 6}


def shown(view=None, theme="light", **values):
    """A run as a page shows it, its counterpart beside it where the view says so."""
    experiment, view = Experiment.from_dict(values), view or View()
    result = run_experiment(experiment).at(view.cursor(experiment.samples), view.axis)
    causal = experiment.counterpart() if view.beside else None
    beside = None if causal is None else run_experiment(causal)
    return Shown(result, Settings(experiment, view), theme, {"seq": 1}, beside=beside)


def points(trace):
    return np.stack([coordinates(trace["x"]), coordinates(trace["y"])], axis=1)


# The gains over the run --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize(("method", "order"), SERVED)
def test_the_gains_of_the_axis_are_drawn_in_the_convention_of_the_run(method, order, convention):
    for axis in (0, 1):
        made = shown(View(axis=axis), **SHORT, design=method, order=order, convention=convention)
        figure, result = gains.gains_figure(made), made.result
        for index in range(4):
            trace = figure["data"][index]
            assert trace["showlegend"] == (index < order)
            if index >= order:
                assert points(trace).size == 0
                continue
            used = result.selection.gains[:, axis, index]
            # The first measurements make the state that is corrected from then on.
            assert np.isnan(used[0])
            written = (used / CONVENTIONS[convention].factors[index]).astype("f4")
            np.testing.assert_array_equal(coordinates(trace["x"]), result.truth.times.astype("f4"))
            np.testing.assert_array_equal(coordinates(trace["y"]), written)
            assert trace["name"] == "αβγη"[index]
        low, high = figure["layout"]["yaxis"]["range"]
        assert low < 0 < np.nanmax([np.nanmax(coordinates(t["y"])) for t in figure["data"][:order]]) <= high
        assert figure["layout"]["yaxis"]["title"]["text"] == f"gains in {'xy'[axis]}"


def test_a_missing_measurement_leaves_a_gap():
    """Where nothing is corrected nothing is drawn."""
    made = shown(**SHORT, design="growing-memory", order=3)
    used = made.result.selection.gains.copy()
    used[40:45] = np.nan
    result = replace(made.result, selection=replace(made.result.selection, gains=used))
    figure = gains.gains_figure(replace(made, result=result))
    for trace in figure["data"][:3]:
        y = coordinates(trace["y"])
        assert np.isnan(y[40:45]).all()
        assert np.isfinite(y[[39, 45]]).all()
        # The line is broken there, not joined.
        assert not trace.get("connectgaps")


@pytest.mark.parametrize("at", [None, 0, 17, 89])
def test_the_cursor_stands_at_the_sample_looked_at(at):
    made = shown(View(at=at), **SHORT, design="parallel-bank", interval=0.5)
    figure = gains.gains_figure(made)
    cursor = made.result.truth.times[45 if at is None else at]
    np.testing.assert_allclose(coordinates(figure["data"][4]["x"]), [cursor, cursor], rtol=1e-6)
    assert coordinates(figure["data"][4]["y"])[1] == pytest.approx(figure["layout"]["yaxis"]["range"][1])


@pytest.mark.parametrize("values", [{}, {"design": "manual", "order": 2, "alpha": 1.9, "beta": 1.5}], ids=str)
def test_constant_gains_are_not_drawn_over_time(values):
    figure = gains.gains_figure(shown(**values))
    assert [points(trace).size for trace in figure["data"]] == [0] * 5
    assert not any(trace["showlegend"] for trace in figure["data"])
    assert figure["layout"]["yaxis"]["title"]["text"] == ""
    assert gains.gains_key(shown(**values)) == ""


def test_a_long_run_is_thinned_and_its_rows_are_still_its_own():
    made = shown(samples=12_000, design="moving-window", window=5, levels=3, refinements=0)
    figure = gains.gains_figure(made)
    every = figure["layout"]["meta"]["every"]
    assert every == 3
    y = coordinates(figure["data"][0]["y"])
    assert len(y) <= 5_000
    np.testing.assert_array_equal(y, made.result.selection.gains[::every, 0, 0].astype("f4"))


# The trail ---------------------------------------------------------------------------------------------------------


def without_repeats(rows):
    """Rows of numbers, each that is as the one before left out."""
    kept = []
    for row in rows:
        if not kept or kept[-1] != row:
            kept.append(row)
    return kept


@pytest.mark.parametrize(("method", "order", "plane"), PLANES_SERVED)
def test_the_trail_is_the_gains_used_in_that_plane(method, order, plane):
    columns = [GAIN_NAMES.index(name) for name in plane]
    for axis in (0, 1):
        made = shown(View(axis=axis, plane=plane), **SHORT, design=method, order=order, convention="taylor")
        rows = [row[columns].tolist() for row in made.result.selection.gains[:, axis] if not np.isnan(row).any()]
        drawn = points(stability_map.stability_map(made)["data"][TRAIL])
        np.testing.assert_array_equal(drawn, np.array(without_repeats(rows), dtype="f4"))
        small = points(stability_map.small_map(made)["data"][TRAIL])
        if plane == ("alpha", "beta"):
            np.testing.assert_array_equal(small, drawn)
    if method == "run-search":
        assert len(drawn) == 1


@pytest.mark.parametrize("samples", [1_400, 1_600, 12_000])
def test_a_long_trail_is_thinned(samples):
    made = shown(samples=samples, design="growing-memory", order=3)
    x, y = trail(made.result, 0, ("alpha", "beta"))
    used = made.result.selection.gains[:, 0]
    used = used[~np.isnan(used[:, 0])]
    assert len(x) == len(y) <= TRAIL_POINTS == 1_500
    assert len(x) > 750
    step = -(-len(used) // 1_500)
    np.testing.assert_array_equal(np.stack([x, y], axis=1), used[::step, :2])


def test_the_point_lies_on_the_trail_and_constant_gains_leave_none():
    made = shown(View(axis=1, at=20), **SHORT, design="sample-search", order=3)
    figure = stability_map.small_map(made)
    (point,) = points(figure["data"][POINT])
    assert point.tolist() in points(figure["data"][TRAIL]).tolist()
    np.testing.assert_array_equal(point, made.result.selection.gains[20, 1, :2].astype("f4"))
    assert figure["data"][TRAIL]["showlegend"] is True
    plain = stability_map.stability_map(shown(**SHORT))["data"][TRAIL]
    assert (points(plain).size, plain["showlegend"]) == (0, False)


@settings(max_examples=60)
@given(rows=st.lists(st.sampled_from([0.1, 0.2, 0.3, np.nan]), min_size=0, max_size=25), repeat=st.integers(1, 200))
def test_any_run_of_gains_has_a_trail_without_repeats(rows, repeat):
    made = shown(samples=5, design="growing-memory", order=2).result
    column = np.repeat(np.array(rows, dtype=float), repeat)
    used = np.stack([column, column / 2], axis=1)[:, None, :]
    x, y = trail(replace(made, selection=replace(made.selection, gains=used)), 0, ("alpha", "beta"))
    expected = without_repeats([value for value in column.tolist() if not np.isnan(value)])
    assert x.tolist() == expected
    assert y.tolist() == [value / 2 for value in expected]


# The causal counterpart --------------------------------------------------------------------------------------------

ORACLES = {
    "linear-combination": ("growing-memory", {}),
    "parallel-bank": ("parallel-bank-causal", {"members": 7}),
    "sample-search": ("critically-damped-bank", {}),
    "run-search": ("critically-damped-bank", {}),
}
"""Per oracle its counterpart, and what both are told."""


def oracle_figures(made):
    return {"path": track.path_figure(made), "close-up": track.close_up_figure(made), "error": error.error_figure(made)}


@pytest.mark.parametrize("scenario", ["jeong-ship", "singer"])
@pytest.mark.parametrize("factor", [1, 20])
@pytest.mark.parametrize("oracle", ORACLES)
def test_the_counterpart_is_drawn_beside_the_oracle(oracle, factor, scenario):
    causal, told = ORACLES[oracle]
    # A run so short that the error is drawn sample by sample.
    values = {"scenario": scenario, "samples": 70, "order": METHODS[oracle].orders[0]}
    made = shown(View(beside=True, exaggerate=factor), **values, design=oracle, **told)
    alone = run_experiment(Experiment.from_dict(values | {"design": causal} | told))
    truth = alone.truth.positions
    smoothed = alone.track.smoothed[:, :, 0]
    path = truth + factor * (smoothed - truth)
    figures = oracle_figures(made)
    kind = {name: figures[name]["data"][index] for name, index in COUNTERPART.items()}
    assert {trace["name"] for trace in kind.values()} == {"Causal"}
    assert all(trace["showlegend"] is True for trace in kind.values())
    np.testing.assert_allclose(points(kind["path"]), path, rtol=2e-7, atol=1e-3)
    rows = slice(35 - 15, 35 + 16)
    np.testing.assert_allclose(points(kind["close-up"]), path[rows], rtol=2e-7, atol=1e-3)
    distance = np.sqrt(((smoothed - truth) ** 2).sum(axis=1))
    np.testing.assert_allclose(points(kind["error"])[:, 0], alone.truth.times, rtol=1e-6)
    # Drawn to a step of at most 2^-16 of the axis.
    top = figures["error"]["layout"]["yaxis"]["range"][1]
    np.testing.assert_allclose(points(kind["error"])[:, 1], distance, rtol=1e-6, atol=top * 2**-17)
    # It is another line than the oracle's own; but the best weight for the target of Singer is none.
    own = {0.0} == {*made.result.selection.found.get("weight", (1.0,))}
    assert own == (oracle == "linear-combination" and scenario == "singer")
    assert own or np.nanmax(np.abs(points(kind["path"]) - points(figures["path"]["data"][3]))) > 0.1


@pytest.mark.parametrize(
    ("view", "values"),
    [
        (View(), {"design": "parallel-bank"}),
        (View(beside=True), {"design": "parallel-bank-causal"}),
        (View(beside=True), {"design": "linear-combination", "weight": 0.3}),
        (View(beside=True), {"design": "fading-memory", "xi": 0.5}),
    ],
    ids=str,
)
def test_nothing_stands_beside_what_is_causal_or_not_asked_for(view, values):
    figures = oracle_figures(shown(view, **SHORT, **values))
    for name, index in COUNTERPART.items():
        trace = figures[name]["data"][index]
        assert np.isnan(points(trace)[:, 1]).all()
        assert trace["showlegend"] is False


# Live --------------------------------------------------------------------------------------------------------------

SLIDES = {
    "parallel-bank": {"members": 9},
    "linear-combination": {"fixed_alpha": 0.4},
    "sample-search": {"grid": 3},
    "run-search": {"grid": 3},
    "moving-window": {"window": 8},
    "critically-damped-bank": {"shortest": 9},
}


@pytest.mark.parametrize("desk", [EXPLORE, STABILITY, TRACK], ids=lambda desk: desk.page)
@pytest.mark.parametrize("method", SLIDES)
def test_a_slider_of_a_method_moves_its_lines(controls_for, request_for, desk, method):
    controls = controls_for(View(beside=True, exaggerate=5, at=20), **SHORT, design=method)
    before, rest = answer(desk, request_for(controls))
    after, _ = answer(desk, request_for(controls, SLIDES[method]))
    question = request_for(controls, SLIDES[method], drawn=rest["drawn"], want=list(desk.plots))
    text, arrays = live_answer(desk, question)
    assert set(text["outdated"]) <= {"stability-response"}
    lines, moved = iter(arrays), set()
    for name, traces in text["lines"].items():
        place = list(desk.plots).index(name)
        assert [index for index, _ in traces] == moving_traces(desk.plots[name].moving)
        for index, length in traces:
            x, y = next(lines), next(lines)
            assert len(x) == len(y) == length
            np.testing.assert_array_equal(np.stack([x, y], axis=1), points(after[place]["data"][index]))
            if not np.array_equal(y, coordinates(before[place]["data"][index]["y"]), equal_nan=True):
                moved.add((name.partition("-")[2], index))
    assert next(lines, None) is None
    # The smoothed path, and everything that a method adds.
    assert ("path", 3) in moved
    if desk is EXPLORE:
        assert {("gains", 1), ("stability", TRAIL)} <= moved
    if method == "parallel-bank" and desk is not STABILITY:
        # The counterpart is told the same.
        assert {(name, index) for name, index in COUNTERPART.items() if f"{desk.page}-{name}" in desk.plots} <= moved
