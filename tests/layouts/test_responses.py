"""Poles in the z-plane, the answers to powers of the time, and the frequency response, against plain loops."""

import json
import math

import numpy as np
import pytest

from layouts.figures import poles, responses
from layouts.figures.common import coordinates
from layouts.figures.poles import DAMPING_RATIOS, equal_damping
from layouts.figures.responses import DECIBELS, SPANS, decibels, degrees, error_reach, span
from layouts.shown import Shown
from layouts.state import INPUTS, Settings, View, inputs_of
from layouts.theme import THEMES, line, tokens
from tracker_core import DESIGNS, Experiment, Gains, run_experiment
from tracker_core.types import GAIN_NAMES, ORDERS

STABLE = {
    "order 2": (0.5, 0.2),
    "ringing": (0.2, 1.5),
    "alternating": (1.6, 0.3),
    "order 3": (0.6, 0.3, 0.05),
    "order 4": (0.8, 0.6, 0.25, 0.05),
    "sluggish": (0.02, 0.0002),
}
UNSTABLE = {"order 2": (1.9, 1.5), "order 3": (0.5, 0.2, 0.5), "order 4": (0.5, 0.2, 0.3, 0.9)}
ALL = {**{f"stable, {key}": g for key, g in STABLE.items()}, **{f"unstable, {key}": g for key, g in UNSTABLE.items()}}


def shown(gains, view=None, *, theme="light", interval=1.0):
    values = dict(zip(GAIN_NAMES, gains, strict=False))
    experiment = Experiment.from_dict(
        {"design": "manual", "order": len(gains), "samples": 5, "interval": interval, **values}
    )
    return Shown(run_experiment(experiment), Settings(experiment, view or View()), theme, {})


def motion(order):
    """F at T = 1, written out."""
    return np.array([[1 / math.factorial(j - i) if j >= i else 0.0 for j in range(order)] for i in range(order)])


def xs(trace):
    return coordinates(trace["x"]).astype(float)


def ys(trace):
    return coordinates(trace["y"]).astype(float)


# Poles -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gains", ALL.values(), ids=ALL)
def test_the_poles_are_the_eigenvalues_of_the_filter(gains):
    trace = poles.pole_figure(shown(gains))["data"][poles.POLES]
    f = motion(len(gains))
    expected = np.linalg.eigvals(f - np.outer(gains, f[0]))
    drawn = np.array(trace["x"]) + 1j * np.array(trace["y"])
    np.testing.assert_allclose(np.sort(np.round(drawn, 9)), np.sort(np.round(expected, 9)), atol=2e-9)


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize(("gains", "tone"), [(STABLE["order 3"], "good"), (UNSTABLE["order 3"], "bad")])
def test_the_poles_say_whether_they_are_stable(gains, tone, theme):
    marker = poles.pole_figure(shown(gains, theme=theme))["data"][poles.POLES]["marker"]
    assert marker["color"] == marker["line"]["color"]
    inside = [abs(pole) < 1 for pole in shown(gains).result.verdict.poles]
    assert marker["color"] == [tokens(theme)["good" if within else "bad"] for within in inside]
    assert all(inside) == (tone == "good")


def test_the_region_of_the_poles_is_the_unit_circle():
    figure = poles.pole_figure(shown(STABLE["order 2"]))
    circle = figure["data"][0]
    np.testing.assert_allclose(np.hypot(xs(circle), ys(circle)), 1, atol=1e-6)
    assert circle["fill"] == "toself"
    # A circle that is drawn as one.
    assert figure["layout"]["yaxis"]["scaleanchor"] == "x"
    for axis in ("xaxis", "yaxis"):
        low, high = figure["layout"][axis]["range"]
        assert low < -1
        assert high > 1


def damping(x, y):
    """-ln r/sqrt(ln^2 r + angle^2) of x + yi."""
    decay = -math.log(math.hypot(x, y))
    return decay / math.hypot(decay, math.atan2(y, x))


def test_poles_on_a_curve_of_equal_damping_have_that_damping_ratio():
    x, y = equal_damping()
    gaps = np.flatnonzero(np.isnan(x))
    np.testing.assert_array_equal(gaps, np.flatnonzero(np.isnan(y)))
    pieces = np.split(np.stack((x, y), axis=1), gaps)
    pieces = [piece[~np.isnan(piece[:, 0])] for piece in pieces]
    pieces = [piece for piece in pieces if len(piece)]
    assert len(pieces) == 2 * len(DAMPING_RATIOS)
    for piece, ratio in zip(pieces, np.repeat(DAMPING_RATIOS, 2), strict=True):
        # All begin at z = 1, where every ratio meets, and end on the negative axis.
        assert piece[0] == pytest.approx([1, 0])
        assert piece[-1, 1] == pytest.approx(0, abs=1e-12)
        np.testing.assert_allclose([damping(*point) for point in piece[1:]], ratio, rtol=1e-9)
    upper, lower = pieces[::2], pieces[1::2]
    for one, other in zip(upper, lower, strict=True):
        np.testing.assert_allclose(one, other * [1, -1])


def test_every_curve_of_equal_damping_is_labelled_where_it_is():
    notes = poles.pole_figure(shown(STABLE["order 2"]))["layout"]["annotations"]
    assert [note["text"] for note in notes] == [f"ζ {ratio}" for ratio in DAMPING_RATIOS]
    for note, ratio in zip(notes, DAMPING_RATIOS, strict=True):
        assert damping(note["x"], note["y"]) == pytest.approx(ratio, rel=1e-9)


# Time --------------------------------------------------------------------------------------------------------------


def loop(gains, degree, samples):
    """Input, prediction and smoothed position from rest, T = 1, sample by sample."""
    order, rows = len(gains), []
    state = np.zeros(order)
    for k in range(samples):
        z = k**degree / math.factorial(degree)
        if k:
            state = motion(order) @ state
        predicted = state[0]
        state = state + np.array(gains) * (z - predicted)
        rows.append((z, predicted, state[0]))
    return np.array(rows).T


def with_inputs(named):
    """Every set of gains with every input that its order has use for."""
    return [
        pytest.param(gains, kind, id=f"{name}, {kind}")
        for name, gains in named.items()
        for kind in inputs_of(len(gains))
    ]


@pytest.mark.parametrize(("gains", "kind"), with_inputs(STABLE))
def test_the_response_is_that_of_a_plain_loop(gains, kind):
    interval = 0.7
    figure = responses.time_figure(shown(gains, View(input=kind), interval=interval))
    samples = len(xs(figure["data"][0]))
    assert samples == span(Gains(gains))
    degree = INPUTS.index(kind)
    # A position of t^degree/degree! metres.
    z, *_ = expected = [part * interval**degree for part in loop(gains, degree, samples)]
    drawn = figure["data"][:3]
    assert [trace["name"] for trace in drawn] == ["Input", "Predicted", "Smoothed"]
    scale = max(1.0, z[-1])
    for trace, values in zip(drawn, expected, strict=True):
        np.testing.assert_allclose(xs(trace), np.arange(samples) * interval, rtol=1e-6)
        np.testing.assert_allclose(ys(trace), values, atol=1e-5 * scale)
    for trace, values in zip(figure["data"][3:], expected[1:], strict=True):
        assert trace["yaxis"] == "y2"
        np.testing.assert_allclose(ys(trace), z - values, atol=1e-5 * scale)


@pytest.mark.parametrize("theme", THEMES)
def test_responses_look_like_the_same_series_elsewhere(theme):
    for figure in (responses.time_figure(shown(STABLE["order 3"], theme=theme)),
                   responses.frequency_figure(shown(STABLE["order 3"], theme=theme))):  # fmt: skip
        for trace in figure["data"]:
            kind = {"Input": "truth"}.get(trace["name"], trace["name"].lower())
            assert trace["line"] == line(kind, theme)
        # Each series once in the legend.
        listed = [trace["name"] for trace in figure["data"] if trace.get("showlegend", True)]
        assert len(set(listed)) == len(listed)


@pytest.mark.parametrize(("gains", "kind"), with_inputs(ALL))
def test_whatever_the_gains_the_axes_are_finite_and_hold_the_input(gains, kind):
    figure = responses.time_figure(shown(gains, View(input=kind)))
    json.dumps(figure, allow_nan=False)
    layout, entered = figure["layout"], ys(figure["data"][0])
    for axis in ("xaxis", "yaxis", "xaxis2", "yaxis2"):
        low, high = layout[axis]["range"]
        assert -1e9 < low < high < 1e9
    assert layout["xaxis"]["range"] == layout["xaxis2"]["range"]
    assert layout["yaxis"]["range"][0] < 0 < entered.max() < layout["yaxis"]["range"][1]
    for trace in figure["data"]:
        assert not np.isinf(ys(trace)).any()


@pytest.mark.parametrize(
    ("gains", "kind"), with_inputs({name: STABLE[name] for name in ("order 2", "alternating", "order 3", "order 4")})
)
def test_what_is_missing_to_the_input_is_seen(gains, kind):
    degree = INPUTS.index(kind)
    figure = responses.time_figure(shown(gains, View(input=kind)))
    low, high = figure["layout"]["yaxis2"]["range"]
    z, predicted, _ = loop(gains, degree, len(xs(figure["data"][0])))
    greatest = np.abs(z - predicted).max()
    assert low == -high
    # The errors fill a good part of the axis.
    assert greatest <= high * (1 + 1e-9)
    assert high <= 2.5 * greatest


def test_the_axis_of_the_errors_is_cut_where_a_filter_runs_away():
    error = np.array([1.0, -1e9, np.nan])
    assert error_reach(Gains(UNSTABLE["order 2"]), 0, error) <= 120
    assert error_reach(Gains(UNSTABLE["order 2"]), 0, np.zeros(3)) > 0


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("xi", [0, 0.3, 0.6, 0.8, 0.9, 0.95, 0.98])
def test_a_response_is_shown_until_it_has_settled(order, xi):
    gains = DESIGNS["fading-memory"].gains(order, xi=xi)
    shown_ = span(Gains(tuple(gains)))
    _, _, smoothed = loop(gains, 0, 2_000)
    missing = np.flatnonzero(np.abs(1 - smoothed) > 0.02)
    settled = (missing[-1] if len(missing) else 0) + 1
    assert shown_ in SPANS
    assert settled <= shown_ or shown_ == SPANS[-1]
    # In steps no coarser than need be.
    shorter = [samples for samples in SPANS if samples < shown_]
    assert not shorter or 1.5 * settled + 2 > shorter[-1]


def test_a_response_that_hardly_settles_is_shown_at_length_and_one_that_never_does_in_short():
    assert span(Gains(DESIGNS["fading-memory"].gains(2, xi=0.9999))) == SPANS[-1]
    assert span(Gains((1e-6, 1e-13))) == SPANS[-1]
    assert {span(Gains(gains)) for gains in UNSTABLE.values()} == {SPANS[0]}


# Frequency ---------------------------------------------------------------------------------------------------------


def ratio(gains, frequency):
    """Estimated over measured position at cycles per sample, from the equations of the filter as a linear system."""
    order, f = len(gains), motion(len(gains))
    a, k = f - np.outer(gains, f[0]), np.array(gains)
    smoothed, predicted = [], []
    for w in frequency:
        z = np.exp(2j * np.pi * w)
        # x(k) = A x(k-1) + K z(k)
        x = np.linalg.solve(np.eye(order) - a / z, k)
        smoothed.append(x[0])
        predicted.append((f @ x)[0] / z)
    return np.array(predicted), np.array(smoothed)


@pytest.mark.parametrize("gains", STABLE.values(), ids=STABLE)
def test_magnitude_and_phase_are_those_of_the_linear_system(gains):
    interval = 0.25
    figure = responses.frequency_figure(shown(gains, interval=interval))
    frequency = np.geomspace(1e-3, 0.5, len(xs(figure["data"][0])))
    for index, expected in enumerate(ratio(gains, frequency)):
        magnitude, phase = figure["data"][index], figure["data"][index + 2]
        np.testing.assert_allclose(xs(magnitude), frequency / interval, rtol=1e-5)
        np.testing.assert_array_equal(xs(phase), xs(magnitude))
        np.testing.assert_allclose(ys(magnitude), 20 * np.log10(np.abs(expected)), atol=1e-3)
        turned = (ys(phase) - np.degrees(np.angle(expected)) + 180) % 360 - 180
        np.testing.assert_allclose(turned, 0, atol=0.05)


@pytest.mark.parametrize("gains", ALL.values(), ids=ALL)
def test_an_unstable_filter_has_no_frequency_response_and_that_is_said(gains):
    figure = responses.frequency_figure(shown(gains))
    stable = gains in STABLE.values()
    assert all(np.isfinite(ys(trace)).any() == stable for trace in figure["data"])
    assert [note["text"] for note in figure["layout"]["annotations"]] == (
        [] if stable else ["unstable: there is no frequency response"]
    )


@pytest.mark.parametrize("gains", STABLE.values(), ids=STABLE)
def test_the_phase_does_not_jump_by_a_turn(gains):
    figure = responses.frequency_figure(shown(gains))
    json.dumps(figure, allow_nan=False)
    for trace in figure["data"][2:]:
        assert np.abs(np.diff(ys(trace))).max() <= 180
        assert not np.isinf(ys(trace)).any()


@pytest.mark.parametrize("gains", [g for name, g in STABLE.items() if name != "sluggish"], ids=str)
def test_slow_motion_passes_as_it_is(gains):
    """At the lowest frequency drawn the estimate is the measurement: 0 dB, no phase."""
    figure = responses.frequency_figure(shown(gains))
    assert [ys(trace)[0] for trace in figure["data"]] == pytest.approx([0] * 4, abs=0.5)


def test_the_axes_of_the_frequency_response_follow_the_interval_alone():
    for interval in (0.01, 1.0, 600.0):
        layouts = [responses.frequency_figure(shown(gains, interval=interval))["layout"] for gains in STABLE.values()]
        assert all(layout == layouts[0] for layout in layouts)
        for axis in ("xaxis", "xaxis2"):
            low, high = layouts[0][axis]["range"]
            assert (10**low, 10**high) == pytest.approx((1e-3 / interval, 0.5 / interval))
        assert layouts[0]["yaxis"]["range"] == list(DECIBELS)


def test_a_ratio_of_nothing_has_a_magnitude_that_can_be_drawn():
    assert decibels(np.array([0, 1e-9, 1, -10j])).tolist() == [-120, -120, 0, 20]


def test_a_phase_goes_on_beyond_half_a_turn():
    turns = np.exp(-1j * np.linspace(0, 4 * np.pi, 40))
    assert degrees(turns)[-1] == pytest.approx(-720)
