"""The stability map: border, design curves, printed bounds, backgrounds, limits; every plane of every order."""

import math
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layouts.figures import map_background, stability_map
from layouts.figures.common import coordinates, round_up
from layouts.figures.map_background import GRID, exceeded
from layouts.figures.stability_map import (
    BACKGROUND,
    FORBIDDEN,
    POINT,
    axis_range,
    design_curves,
)
from layouts.readouts import slice_text
from layouts.shown import Shown
from layouts.state import LIMIT_FIELDS, Limits, Settings, View
from layouts.theme import THEMES, tokens
from tracker_core import DESIGNS, Experiment, Gains, run_experiment
from tracker_core.design.curves import SPANS, curve_designs
from tracker_core.merits import merits
from tracker_core.region import PLANES
from tracker_core.types import GAIN_NAMES, ORDERS

ALL_PLANES = [(order, plane) for order in ORDERS for plane in PLANES[order]]
# Inside the region of every order, and outside.
INSIDE = {2: (0.6, 0.3), 3: (0.7, 0.4, 0.1), 4: (0.8, 0.6, 0.25, 0.05)}
OUTSIDE = {2: (1.9, 1.5), 3: (0.5, 0.2, 0.5), 4: (0.5, 0.2, 0.3, 0.9)}
SYMBOLS = {"alpha": "α", "beta": "β", "gamma": "γ", "eta": "η"}


def shown(gains, view=None, limits=None, *, live=False, theme="light", interval=1.0):
    """A short run of manual gains, looked at."""
    values = dict(zip(GAIN_NAMES, gains, strict=False))
    experiment = Experiment.from_dict(
        {"design": "manual", "order": len(gains), "samples": 5, "interval": interval, **values}
    )
    view = view or View()
    return Shown(run_experiment(experiment), Settings(experiment, view, None, limits or Limits()), theme, {}, live)


def figure(*arguments, **more):
    return stability_map.stability_map(shown(*arguments, **more))


def points(trace):
    return np.stack([coordinates(trace["x"]), coordinates(trace["y"])], axis=1).astype(float)


def radius(g):
    """The largest pole, from the matrix of the filter written out."""
    order = len(g)
    f = np.array([[1 / math.factorial(j - i) if j >= i else 0.0 for j in range(order)] for i in range(order)])
    return np.abs(np.linalg.eigvals(f - np.outer(g, f[0]))).max()


def is_inside(polygon, x, y):
    """Whether a point lies in a closed polygon: an odd number of edges to its right."""
    (x0, y0), (x1, y1) = polygon[:-1].T, polygon[1:].T
    crosses = (y0 > y) != (y1 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.count_nonzero(crosses & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))) % 2 == 1


# The region --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gains", [INSIDE, OUTSIDE], ids=["inside", "outside"])
@pytest.mark.parametrize(("order", "plane"), ALL_PLANES)
def test_the_border_divides_the_stable_from_the_unstable(order, plane, gains):
    made = figure(gains[order], View(plane=plane))
    border = points(made["data"][0])
    columns = [GAIN_NAMES.index(name) for name in plane]
    ranges = [made["layout"][axis]["range"] for axis in ("xaxis", "yaxis")]
    stable = 0
    for x in np.linspace(*ranges[0], 23):
        for y in np.linspace(*ranges[1], 23):
            vector = np.array(gains[order])
            vector[columns] = x, y
            largest = radius(vector)
            # The line is drawn in 32 bits and straight pieces.
            if abs(largest - 1) > 2e-3:
                assert (len(border) > 0 and is_inside(border, x, y)) == (largest < 1), (x, y)
                stable += largest < 1
    assert stable > 5 or gains is OUTSIDE


@pytest.mark.parametrize(("order", "plane"), ALL_PLANES)
def test_the_point_and_the_region_are_seen(order, plane):
    made = figure(INSIDE[order], View(plane=plane))
    columns = [GAIN_NAMES.index(name) for name in plane]
    (point,) = points(made["data"][POINT])
    assert point == pytest.approx(np.array(INSIDE[order])[columns], rel=1e-6)
    for axis, name, value in zip(("xaxis", "yaxis"), plane, point, strict=True):
        low, high = made["layout"][axis]["range"]
        assert low < 0 < value < high
        assert made["layout"][axis]["title"]["text"] == SYMBOLS[name]


@pytest.mark.parametrize(
    ("gains", "plane", "text"),
    [
        ((0.5, 0.2, -0.1), ("alpha", "beta"), "no α, β is stable with this γ"),
        ((0.5, 0.2, 0.1, -0.1), ("alpha", "beta"), "no α, β is stable with this γ, η"),
        ((2.5, 0.2, 0.1), ("beta", "gamma"), "no β, γ is stable with this α"),
        ((0.5, 0.2, -1, 0.1), ("beta", "eta"), "no β, η is stable with this α, γ"),
    ],
)
def test_where_nothing_is_stable_the_map_says_so(gains, plane, text):
    made = figure(gains, View(plane=plane))
    assert len(points(made["data"][0])) == 0
    assert [note["text"] for note in made["layout"]["annotations"]] == [text]
    assert [note["bgcolor"] for note in made["layout"]["annotations"]] == [tokens("light")["surface"]]


@pytest.mark.parametrize(("order", "plane"), ALL_PLANES)
def test_the_slice_is_told_by_the_gains_that_are_fixed(order, plane):
    text = slice_text(Gains(INSIDE[order]), plane)
    if order == 2:
        assert text == "triangle"
    else:
        fixed = [name for name in GAIN_NAMES[:order] if name not in plane]
        assert [part.split(" = ")[0][-1] for part in text.split(", ")] == [SYMBOLS[name] for name in fixed]


def test_damping_is_told_for_order_2_only():
    """The words lie where their filters do, by their poles."""
    made = figure(INSIDE[2])
    (left, right), (low, high) = (made["layout"][axis]["range"] for axis in ("xaxis", "yaxis"))
    for note in made["layout"]["annotations"]:
        alpha, beta = left + note["x"] * (right - left), low + note["y"] * (high - low)
        assert radius((alpha, beta)) < 1
        poles = np.roots([1, alpha + beta - 2, 1 - alpha])
        expected = "underdamped" if poles[0].imag else "alternating" if poles.real.min() < 0 else "overdamped"
        assert note["text"] == expected
        # What it lies over has any colour.
        assert (note["font"]["color"], note["bgcolor"]) == (tokens("light")["ink"], tokens("light")["surface"])
    assert len(made["layout"]["annotations"]) == 3
    for order in (3, 4):
        other = figure(INSIDE[order])
        assert other["layout"]["annotations"] == []
        assert len(points(other["data"][1])) == 0


# Axes --------------------------------------------------------------------------------------------------------------


@settings(max_examples=60)
@given(
    exponent=st.floats(-9, 2.5),
    sign=st.sampled_from([-1, 1]),
    whole=st.floats(0, 16),
    name=st.sampled_from(["gamma", "eta"]),
)
def test_the_axis_of_a_small_gain_shows_it_and_no_more_than_needed(exponent, sign, whole, name):
    value = sign * 10.0**exponent
    gains = Gains(tuple(value if gain == name else 0.5 for gain in GAIN_NAMES))
    low, high = axis_range(gains, name, np.array([0, whole]))
    top = high / 1.05
    assert low == pytest.approx(-0.05 * top)
    assert abs(value) < high
    # Either the whole region or a good part around the point; in round numbers.
    assert top >= min(whole, 25 * abs(value)) * (1 - 1e-8)
    assert top <= 2.0000001 * max(min(whole, 25 * abs(value)), 1.5 * abs(value), 1e-6)
    assert float(f"{top:.1e}") == pytest.approx(top, rel=1e-12)


@given(value=st.floats(1e-12, 1e12))
def test_a_number_is_rounded_up_to_the_next_round_one(value):
    rounded = round_up(value)
    assert value * (1 - 2e-9) <= rounded <= 1.7 * value
    assert float(f"{rounded:.1e}") == pytest.approx(rounded, rel=1e-12)
    assert round_up(rounded) == pytest.approx(rounded, rel=1e-12)


def test_alpha_and_beta_span_the_region_of_every_order():
    assert axis_range(Gains(INSIDE[2]), "alpha", np.array([0.0, 2.0])) == stability_map.RANGES["alpha"]
    assert axis_range(Gains(INSIDE[2]), "beta", np.array([0.0, 4.0])) == stability_map.RANGES["beta"]
    # The corner of order 4 with the greatest beta.
    made = figure((0.01, 5.2, 0.02, 15.4))
    border = points(made["data"][0])
    assert border[:, 1].max() > 5
    assert made["layout"]["yaxis"]["range"][1] > border[:, 1].max()


# Design curves -----------------------------------------------------------------------------------------------------

# Groups of designs per order.
SAME = {
    2: [["fading-memory", "critically-damped"], ["benedict-bordner"], ["kalata", "steady-kalman"]],
    3: [["fading-memory"], ["gray-murray", "steady-kalman"]],
    4: [["fading-memory"], ["steady-kalman"]],
}


def dense(name, order, plane, count=1500):
    """A design's curve in a plane, straight from the design, with many points."""
    ((parameter, domain),) = DESIGNS[name].parameters.items()
    low, high = SPANS[parameter]
    low, high = max(low, domain.low), min(high, domain.high)
    values = np.geomspace(low, high, count) if parameter == "tracking_index" else np.linspace(low, high, count)
    columns = [GAIN_NAMES.index(gain) for gain in plane]
    return np.array([DESIGNS[name].gains(order, **{parameter: float(v)}) for v in values])[:, columns]


def apart(one, other):
    """How far the points of one curve lie from another at most, where both are drawn; relative to their extent."""
    extent = np.abs(other).max(axis=0)
    one, other = one / extent, other / extent
    common = (one[:, 0] >= other[:, 0].min()) & (one[:, 0] <= other[:, 0].max())
    start, step = other[:-1], np.diff(other, axis=0)
    length = (step**2).sum(axis=1)

    def distance(point):
        along = np.clip(((point - start) * step).sum(axis=1) / length, 0, 1)
        return np.hypot(*(start + along[:, None] * step - point).T).min()

    return max(map(distance, one[common][::25]))


@pytest.mark.parametrize(("order", "plane"), ALL_PLANES)
def test_designs_that_draw_the_same_curve_share_it_and_no_others(order, plane):
    wanted = [" = ".join(DESIGNS[name].title for name in group) for group in SAME[order]]
    assert sorted(title for title, _ in design_curves(order, plane)) == sorted(wanted)
    curves = {name: dense(name, order, plane) for name in curve_designs(order)}
    for one, other in combinations(curves, 2):
        together = any({one, other} <= set(group) for group in SAME[order])
        distance = max(apart(curves[one], curves[other]), apart(curves[other], curves[one]))
        assert distance < 3e-3 if together else distance > 0.02, (one, other)


@pytest.mark.parametrize(("order", "plane"), ALL_PLANES)
@pytest.mark.parametrize("theme", THEMES)
def test_design_curves_are_told_apart(order, plane, theme):
    made = figure(INSIDE[order], View(plane=plane), theme=theme)
    curves = made["data"][POINT + 1 :]
    assert [curve["name"] for curve in curves] == [title for title, _ in design_curves(order, plane)]
    looks = [(curve["line"]["color"], curve["line"]["dash"]) for curve in curves]
    assert len({colour for colour, _ in looks}) == len({dash for _, dash in looks}) == len(curves)
    assert {colour for colour, _ in looks} <= {tokens(theme)[f"curve-{number}"] for number in range(1, 5)}
    for curve, (_, wanted) in zip(curves, design_curves(order, plane), strict=True):
        np.testing.assert_array_equal(points(curve), wanted.astype("f4"))


@pytest.mark.parametrize("order", ORDERS)
def test_an_optimal_filter_lies_on_its_curve(order):
    gains = DESIGNS["steady-kalman"].gains(order, tracking_index=0.7)
    for plane in PLANES[order]:
        curve = next(curve for title, curve in design_curves(order, plane) if "Steady Kalman" in title)
        point = np.array(gains)[[GAIN_NAMES.index(name) for name in plane]]
        extent = np.abs(curve).max(axis=0)
        assert np.hypot(*((curve - point) / extent).T).min() < 0.1


# What was printed --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [3, 4])
def test_the_printed_bounds_are_those_of_the_paper(order):
    """Yu & Wu 2017, eq. 10 to 12: 13/6 (4 - 2 alpha) > beta > gamma (2 - alpha)/(4 alpha), their gamma twice ours."""
    trace = figure(INSIDE[order])["data"][2]
    assert trace["showlegend"] is True
    gamma = 2 * INSIDE[order][2]
    for alpha, beta in points(trace):
        # Across the bounds: the lower one is steep at one end and flat at the other.
        upper = (beta - 13 / 6 * (4 - 2 * alpha)) / np.hypot(13 / 3, 1)
        lower = (4 * alpha * beta - gamma * (2 - alpha)) / np.hypot(4 * beta + gamma, 4 * alpha)
        assert min(abs(upper), abs(lower)) < 1e-4
    assert points(trace)[:, 1].max() > 4


@pytest.mark.parametrize(
    ("order", "plane"), [pair for pair in ALL_PLANES if pair[0] == 2 or pair[1] != ("alpha", "beta")]
)
def test_nothing_is_printed_for_other_planes(order, plane):
    trace = figure(INSIDE[order], View(plane=plane))["data"][2]
    assert len(points(trace)) == 0
    assert trace["showlegend"] is False


# Backgrounds -------------------------------------------------------------------------------------------------------


def cells(trace, gains, plane, every=9):
    """Some cells of a trace that is a grid: the gains there and what is shown for them."""
    columns = [GAIN_NAMES.index(name) for name in plane]
    assert len(trace["z"]) == len(trace["z"][0]) == GRID
    for row in range(0, GRID, every):
        for column in range(0, GRID, every):
            vector = np.array(gains)
            vector[columns] = trace["x0"] + column * trace["dx"], trace["y0"] + row * trace["dy"]
            yield vector, trace["z"][row][column]


@pytest.mark.parametrize(("kind", "merit"), [("noise", "noise_gain"), ("lag", "unit_lag")])
@pytest.mark.parametrize(("order", "plane"), ALL_PLANES)
def test_a_background_shows_the_figure_of_merit(order, plane, kind, merit):
    trace = figure(INSIDE[order], View(plane=plane, background=kind))["data"][BACKGROUND]
    seen = 0
    for vector, value in cells(trace, INSIDE[order], plane):
        if abs(radius(vector) - 1) < 1e-9:
            continue
        wanted = merits(Gains.normalised(vector), 1.0)[merit]
        if wanted is None:
            assert value is None
        else:
            assert value == pytest.approx(max(math.log10(abs(wanted)), trace["zmin"] - 1), abs=1e-3)
            seen += 1
    assert seen > 3


@pytest.mark.parametrize("kind", ["noise", "lag"])
def test_a_background_fills_the_plane_and_says_its_scale(kind):
    made = figure(INSIDE[3], View(background=kind))
    trace = made["data"][BACKGROUND]
    for start, step, axis in (("x0", "dx", "xaxis"), ("y0", "dy", "yaxis")):
        low, high = made["layout"][axis]["range"]
        assert (trace[start], trace[start] + (GRID - 1) * trace[step]) == pytest.approx((low, high))
    bar = trace["colorbar"]
    assert [math.log10(float(text)) for text in bar["ticktext"]] == pytest.approx(bar["tickvals"])
    assert (trace["zmin"], trace["zmax"]) == (bar["tickvals"][0], bar["tickvals"][-1])


def test_where_nothing_lags_there_is_a_colour_all_the_same():
    """At alpha = 1 the lag is 0, which has no logarithm."""
    trace = figure((1.0, 0.5, 0.1), View(plane=("beta", "gamma"), background="lag"))["data"][BACKGROUND]
    values = [value for row in trace["z"] for value in row if value is not None]
    assert values
    assert set(values) == {trace["zmin"] - 1}


@pytest.mark.parametrize(("order", "said"), [(2, "acceleration · T²"), (3, "jerk · T³"), (4, "snap · T⁴")])
def test_a_lag_is_one_of_what_the_filter_does_not_follow(order, said):
    trace = figure(INSIDE[order], View(background="lag"))["data"][BACKGROUND]
    assert trace["colorbar"]["title"]["text"] == f"lag / ({said})"


def test_without_a_background_there_is_none():
    assert figure(INSIDE[3])["data"][BACKGROUND]["visible"] is False


@pytest.mark.parametrize("kind", ["none", "noise", "lag"])
def test_while_a_slider_moves_no_grid_is_computed(monkeypatch, kind):
    view, limits = View(background=kind), Limits(limit_noise=0.1, limit_settling=5.0)
    rests = figure(INSIDE[3], view, limits)
    monkeypatch.setattr(map_background, "_grid", lambda *_: pytest.fail("a grid was computed"))
    moves = figure(INSIDE[3], view, limits, live=True)
    for index, (one, other) in enumerate(zip(rests["data"], moves["data"], strict=True)):
        if index in (BACKGROUND, FORBIDDEN):
            assert other["z"] == [[None]]
            assert set(one) == set(other)
        else:
            assert one == other


# Limits ------------------------------------------------------------------------------------------------------------

MERIT_OF = dict(zip(LIMIT_FIELDS, ("noise_gain", "unit_lag", "overshoot", "settling"), strict=True))
MIDDLING = {"limit_noise": 0.6, "limit_lag": 3.0, "limit_overshoot": 25.0, "limit_settling": 8.0}
INTERVAL = 0.7


def exceeds(figures, limits):
    """Whether stable gains exceed a limit, by their figures of merit; what is not known counts as too much."""
    values = {name: figures[MERIT_OF[name]] for name in limits.given()}
    return any(value is None or abs(value) > getattr(limits, name) for name, value in values.items())


@cache
def known_merits(order):
    """Gains from sluggish to beyond the region, and some that serve well; and the figures of merit of every one."""
    axes = [np.geomspace(0.002 * end, end, 5 if order == 4 else 8) for end in (1.9, 3.1, 1.3, 0.4)[:order]]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, order)
    good = [DESIGNS["fading-memory"].gains(order, xi=xi) for xi in (0, 0.2, 0.4, 0.6, 0.8, 0.9)]
    vectors = np.concatenate((grid, good))
    return vectors, [merits(Gains.normalised(vector), INTERVAL) for vector in vectors]


@pytest.mark.parametrize("names", [*((name,) for name in LIMIT_FIELDS), LIMIT_FIELDS], ids="+".join)
@pytest.mark.parametrize("order", ORDERS)
def test_what_exceeds_a_limit_is_what_its_merit_says(order, names):
    limits = Limits(**{name: MIDDLING[name] for name in names})
    vectors, known = known_merits(order)
    got = exceeded(vectors, limits, INTERVAL)
    counts = {True: 0, False: 0}
    for vector, bad, figures in zip(vectors, got.tolist(), known, strict=True):
        # What is unstable is forbidden anyway.
        stable = figures["noise_gain"] is not None
        assert bad == (stable and exceeds(figures, limits)), vector
        counts[bad] += stable
    assert counts[True] > 0
    assert counts[False] > 0 or len(names) > 1
    # Whatever the shape.
    np.testing.assert_array_equal(exceeded(vectors[:12].reshape(3, 4, order), limits, INTERVAL).ravel(), got[:12])


def test_what_settles_only_in_a_very_long_time_exceeds_every_limit():
    vectors = np.array([[1e-5, 1e-12], [0.5, 0.2]])
    assert exceeded(vectors, Limits(limit_settling=1e6), 1.0).tolist() == [True, False]


@pytest.mark.parametrize("name", LIMIT_FIELDS)
def test_where_nothing_is_stable_nothing_exceeds(name):
    vectors = np.full((4, 4, 3), -1.0)
    assert not exceeded(vectors, Limits(**{name: 1.0}), 1.0).any()


@pytest.mark.parametrize("name", LIMIT_FIELDS)
@pytest.mark.parametrize(("order", "plane"), [(2, ("alpha", "beta")), (3, ("alpha", "gamma")), (4, ("beta", "eta"))])
def test_the_shaded_cells_are_those_that_exceed(order, plane, name):
    limits = Limits(**{name: MIDDLING[name] / 3})
    trace = figure(INSIDE[order], View(plane=plane), limits, interval=INTERVAL)["data"][FORBIDDEN]
    shaded = 0
    for vector, value in cells(trace, INSIDE[order], plane):
        if abs(radius(vector) - 1) < 1e-9:
            continue
        figures = merits(Gains.normalised(vector), INTERVAL)
        assert value == (1 if figures["noise_gain"] is not None and exceeds(figures, limits) else None)
        shaded += value is not None
    assert shaded > 0


def test_without_limits_nothing_is_shaded():
    assert figure(INSIDE[3])["data"][FORBIDDEN]["z"] == [[None]]
