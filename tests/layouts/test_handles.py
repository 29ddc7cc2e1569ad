"""What a hand can take hold of: points in the planes of gains, poles, the smooth-responsive knob; and what it does."""

import json

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from layouts.controls import controls_of, resolve
from layouts.desk import live_answer
from layouts.figures.handles import gains_handle, pole_handles, pole_text
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.rules import STEADY, presets
from layouts.state import Settings, View, plane_name
from tracker_core import CONVENTIONS, DESIGNS, Experiment, Gains, run_experiment
from tracker_core.optimal import path_index
from tracker_core.poles import gains_from_poles
from tracker_core.region import PLANES
from tracker_core.stability import assess
from tracker_core.types import GAIN_NAMES, ORDERS

ALL_PLANES = [(order, plane) for order in ORDERS for plane in PLANES[order]]
G = (0.5123456789012345, 0.4234567890123456, 0.0812345678901234, 0.0123456789012345)
PARAMETERS = [*GAIN_NAMES, "xi", "tracking_index"]


def drag(controls, **moved):
    """What the script sends while a hand holds something."""
    return resolve({**controls, **moved}, list(moved))


def manual(order, convention="normalised", gains=G):
    """Controls of these normalised gains, written in a convention."""
    written = Gains(tuple(gains[:order])).to(convention).values
    values = dict(zip(GAIN_NAMES, written, strict=False))
    return controls_of(
        Settings(Experiment.from_dict({"design": "manual", "order": order, "convention": convention, **values}))
    )


def said_of_pole(index, target, poles):
    """What assets/handles.js says of a pole that is held."""
    numbers = [target.real, target.imag, *(part for pole in poles for part in (pole.real, pole.imag))]
    return " ".join([str(index), *map(repr, numbers)])


def poles_of(got):
    """The poles of a resolution."""
    return assess(got.settings.experiment.gains()).poles


# What the server says of handles -----------------------------------------------------------------------------------


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize(("order", "plane"), ALL_PLANES)
def test_a_point_lies_where_the_normalised_gains_are(order, plane, convention):
    gains = Gains(G[:order]).to(convention)
    handle = gains_handle(gains, plane)
    expected = [float(gains.vector[GAIN_NAMES.index(name)]) for name in plane]
    assert json.loads(json.dumps(handle["points"])) == [expected]
    assert (handle["control"], handle["prefix"]) == ("point", plane_name(plane))
    assert 0 < handle["step"] < 0.1


def test_a_point_is_called_by_its_gains():
    assert gains_handle(Gains((0.51234, -0.2)), ("alpha", "beta"))["labels"] == ["Operating point: α 0.512, β −0.200"]
    assert gains_handle(Gains(G[:3], "half"), ("beta", "gamma"))["labels"] == ["Operating point: β 0.423, γ 0.0406"]


@pytest.mark.parametrize("run", presets().values(), ids=presets())
def test_the_handles_of_the_poles_are_the_poles(request_for, run):
    rest, _ = live_answer(STABILITY, request_for(controls_of(Settings(run))))
    handle = json.loads(json.dumps(rest["handles"]["stability-poles"]))
    view = Settings(run).view
    poles = run_experiment(run).at(view.cursor(run.samples), view.axis).verdict.poles
    # To the last digit: what is not moved must not change.
    assert [complex(*point) for point in handle["points"]] == list(poles)
    assert handle["labels"] == [f"Pole {i}: {pole_text(pole)}" for i, pole in enumerate(poles, 1)]
    assert handle["control"] == "pole"


@pytest.mark.parametrize(
    ("pole", "text"),
    [(0.5, "0.500"), (-0.25, "−0.250"), (0, "0"), (0.5 + 0.1j, "0.500 + 0.100i"), (-0.5 - 0.1j, "−0.500 − 0.100i")],
)
def test_a_pole_is_written_as_a_reader_would(pole, text):
    assert pole_text(complex(pole)) == text
    assert pole_handles((complex(pole),))["labels"] == [f"Pole 1: {text}"]


@pytest.mark.parametrize(("order", "plane"), ALL_PLANES)
def test_the_map_is_held_in_the_plane_that_is_looked_at(controls_for, request_for, order, plane):
    controls = controls_for(View(plane=plane), design="fading-memory", order=order, xi=0.6)
    rest, _ = live_answer(STABILITY, request_for(controls))
    assert rest["handles"]["stability-map"]["prefix"] == plane_name(plane)
    rest, _ = live_answer(EXPLORE, request_for(controls))
    assert rest["handles"]["explore-stability"]["prefix"] == "alpha-beta"


# A point in a plane ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize(("order", "plane"), ALL_PLANES)
def test_dragging_in_a_plane_sets_its_gains_and_leaves_the_others_bit_for_bit(order, plane, convention):
    controls = manual(order, convention)
    got = drag(controls, point=f"{plane_name(plane)} 0.377 0.0123")
    vector = dict(zip(GAIN_NAMES, got.settings.experiment.gains().vector.tolist(), strict=False))
    for name, wanted in zip(plane, (0.377, 0.0123), strict=True):
        # A sixth of eta has no finite binary form.
        np.testing.assert_array_max_ulp(np.array(vector[name]), np.array(wanted), 1 if name == "eta" else 0)
    for name in PARAMETERS:
        assert got.controls[name] == controls[name] or name in plane
    assert "point" not in got.controls
    assert (got.errors, got.note) == ((), "")


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("design", [name for name in DESIGNS if name not in ("simpson", "benedict-bordner")])
def test_dragging_the_point_of_a_design_makes_it_manual(controls_for, design, convention):
    order, parameters = DESIGNS[design].orders[0], DESIGNS[design].parameters
    controls = controls_for(design=design, order=order, convention=convention, **dict.fromkeys(parameters, 0.4))
    got = drag(controls, point="alpha-beta 0.55 0.25")
    assert got.settings.experiment.design == "manual"
    assert got.settings.experiment.gains().values[:2] == (0.55, 0.25)
    assert got.settings.experiment.gains().values[2:] == tuple(controls[name] for name in GAIN_NAMES[2:order])
    assert got.note.startswith("You moved ")
    assert got.note.endswith("the design is now Manual.")


@settings(max_examples=60)
@given(wanted=st.from_type(Settings))
def test_a_point_put_where_it_is_moves_nothing(wanted):
    handle = gains_handle(wanted.experiment.gains(), wanted.view.plane)
    (x, y) = json.loads(json.dumps(handle["points"]))[0]
    got = drag(controls_of(wanted), point=f"{handle['prefix']} {x!r} {y!r}")
    np.testing.assert_array_max_ulp(got.settings.experiment.gains().vector, wanted.experiment.gains().vector, maxulp=2)


# A pole ------------------------------------------------------------------------------------------------------------

LAID = {
    "two real": (0.7, 0.2),
    "two real, one negative": (0.6, -0.4),
    "a pair": (0.6 + 0.3j, 0.6 - 0.3j),
    "three real": (0.8, 0.45, 0.1),
    "a pair and one": (0.7 + 0.25j, 0.7 - 0.25j, 0.2),
    "four real": (0.85, 0.55, 0.2, -0.3),
    "a pair and two": (0.6 + 0.4j, 0.6 - 0.4j, 0.8, 0.1),
    "two pairs": (0.7 + 0.2j, 0.7 - 0.2j, 0.1 + 0.6j, 0.1 - 0.6j),
}


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("laid", LAID.values(), ids=LAID)
@settings(max_examples=15)
@given(data=st.data())
def test_a_pole_there_and_back_gives_the_gains(convention, laid, data):
    """From one hold to the next, as a hand that comes back later: only well-apart poles keep all digits."""
    before = gains_from_poles(laid)
    controls = manual(len(laid), convention, before.tolist())
    poles = poles_of(resolve(controls, []))
    index = data.draw(st.integers(0, len(laid) - 1))
    target = complex(data.draw(st.floats(-0.9, 0.95)), data.draw(st.floats(0.1, 0.8)) if poles[index].imag else 0)
    assume(all(abs(target - pole) > 0.1 for pole in poles if pole != poles[index]))
    there = drag(controls, pole=said_of_pole(index, target, poles))
    assert there.errors == ()
    moved = poles_of(there)
    assert min(abs(pole - target) for pole in moved) < 1e-9
    # Those that nobody held are where they were.
    kept = [pole for pole in poles if pole not in (poles[index], poles[index].conjugate())]
    assert all(min(abs(pole - other) for other in moved) < 1e-9 for pole in kept)
    held = min(range(len(moved)), key=lambda i: abs(moved[i] - target))
    back = drag(there.controls, pole=said_of_pole(held, poles[index], moved))
    np.testing.assert_allclose(back.settings.experiment.gains().vector, before, rtol=0, atol=1e-9)


@pytest.mark.parametrize("laid", LAID.values(), ids=LAID)
def test_within_one_hold_the_way_does_not_matter(laid):
    """Every message says where all poles were when the hand took hold."""
    controls = manual(len(laid), gains=gains_from_poles(laid).tolist())
    poles = poles_of(resolve(controls, []))
    straight = drag(controls, pole=said_of_pole(0, 0.4 + 0.3j, poles))
    around = drag(controls, pole=said_of_pole(0, -0.8 + 0.1j, poles))
    around = drag(around.controls, pole=said_of_pole(0, 0.4 + 0.3j, poles))
    assert around.settings.experiment == straight.settings.experiment


@pytest.mark.parametrize("order", ORDERS)
def test_dragging_the_pole_of_a_design_makes_it_manual(controls_for, order):
    controls = controls_for(design="fading-memory", order=order, xi=0.5)
    got = drag(controls, pole=said_of_pole(0, 0.3 + 0.4j, [0.5] * order))
    assert (got.settings.experiment.design, got.settings.experiment.order) == ("manual", order)
    assert "pole" not in got.controls
    wanted = [0.3 + 0.4j, 0.3 - 0.4j, *[0.5] * (order - 2)]
    np.testing.assert_allclose(np.sort(np.round(poles_of(got), 5)), np.sort(wanted), atol=1e-5)


# The knob ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("order", ORDERS)
def test_the_knob_chooses_the_optimal_filter_there(controls_for, order, convention):
    controls = controls_for(design="fading-memory", order=order, xi=0.5, convention=convention)
    noise = []
    for share in (0, 0.25, 0.5, 0.75, 1):
        got = drag(controls, responsiveness=share)
        experiment = got.settings.experiment
        assert (experiment.design, experiment.order, experiment.convention) == (STEADY, order, convention)
        assert experiment.tracking_index == pytest.approx(10.0 ** (6 * share - 4), rel=1e-12)
        assert got.controls["responsiveness"] == pytest.approx(share, abs=1e-12)
        assert got.note == ""
        noise.append(experiment.gains().vector[0])
    assert noise == sorted(noise)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("share", [0.05, 0.4, 0.8])
def test_the_knob_stands_at_the_optimal_filter_that_is_as_noisy(order, share):
    """The steady Kalman gains entered by hand are the same filter."""
    gains = DESIGNS[STEADY].gains(order, tracking_index=path_index(share))
    assert manual(order, gains=gains)["responsiveness"] == pytest.approx(share, abs=1e-4)


def test_the_knob_stands_nowhere_for_unstable_gains():
    assert manual(2, gains=(1.9, 1.5))["responsiveness"] is None


# Wrong texts -------------------------------------------------------------------------------------------------------

NO_POINT = ["", " ", "alpha-beta", "alpha-beta 1", "alpha-beta 1 2 3", "alpha-beta x y", "alpha-beta nan 1",
            "alpha-beta 1 inf", "alpha-beta 1e9 1", "beta-alpha 1 2", "xi-beta 1 2", "1 2", "alpha-beta\t", None, 5,
            0.5, [0.5, 0.2], {"alpha": 1}, True, "alpha-beta " + "1" * 500]  # fmt: skip


@pytest.mark.parametrize("entry", NO_POINT, ids=lambda entry: repr(entry)[:30])
@pytest.mark.parametrize("order", ORDERS)
def test_a_point_that_is_none_is_an_error(order, entry):
    controls = manual(order)
    got = drag(controls, point=entry)
    assert (got.settings, [error.field for error in got.errors]) == (None, ["point"])
    assert got.controls == controls


@pytest.mark.parametrize(("order", "plane"), [(2, "beta-gamma"), (2, "gamma-eta"), (3, "alpha-eta")])
def test_a_point_in_a_plane_that_the_order_does_not_have_is_an_error(order, plane):
    got = drag(manual(order), point=f"{plane} 0.1 0.1")
    assert (got.settings, [error.field for error in got.errors]) == (None, ["point"])


NO_POLE = {
    "nothing": "",
    "no text": None,
    "too few": "0 0.5 0.1",
    "too many": "0" + " 0.5" * 11,
    "no number": "0 x 0 0.5 0 0.5 0",
    "not finite": "0 nan 0 0.5 0 0.5 0",
    "no such pole": "2 0.5 0 0.5 0 0.5 0",
    "negative": "-1 0.5 0 0.5 0 0.5 0",
    "half a pole": "0.5 0.5 0 0.5 0 0.5 0",
    "far outside": "0 5000 0 0.5 0 0.2 0",
    "gains too large": "0 900 0 900 0 900 0",
}


@pytest.mark.parametrize("entry", NO_POLE.values(), ids=NO_POLE)
def test_a_pole_that_is_none_is_an_error(entry):
    controls = manual(2)
    got = drag(controls, pole=entry)
    assert got.settings is None
    assert got.errors
    assert "pole" not in got.controls


def test_poles_without_their_conjugates_are_an_error():
    got = drag(manual(3), pole="0 0.5 0.3  0.2 0.1  0.2 -0.1  0.7 0.4")
    assert (got.settings, [error.field for error in got.errors]) == (None, ["poles"])


@pytest.mark.parametrize("entry", ["", None, "-0.1", "1.1", "nan", "smooth", [0.5]])
def test_the_knob_beyond_its_ends_is_an_error_beside_it(controls_for, entry):
    got = drag(controls_for(), responsiveness=entry)
    assert (got.settings, [error.field for error in got.errors]) == (None, ["responsiveness"])
    assert got.controls["design"] == controls_for()["design"]


@pytest.mark.parametrize("moved", [{"point": "alpha-beta 1 1"}, {"pole": "0 1 1"}], ids=str)
def test_under_a_wrong_order_nothing_is_dragged(controls_for, moved):
    got = resolve({**controls_for(), **moved, "order": "five"}, ["order", *moved])
    assert [error.field for error in got.errors] == ["order"]


# What was moved last wins ------------------------------------------------------------------------------------------

POINT, POLE = "alpha-beta 0.4 0.3", "0 0.3 0  0.5 0  0.2 0"
WON = tuple(gains_from_poles([0.3, 0.2]).tolist())


@pytest.mark.parametrize(
    ("moved", "design", "gains"),
    [
        ({"point": POINT, "alpha": 0.9}, "manual", (0.9, 0.3)),
        ({"alpha": 0.9, "point": POINT}, "manual", (0.4, 0.3)),
        ({"pole": POLE, "beta": 0.7}, "manual", (WON[0], 0.7)),
        ({"beta": 0.7, "pole": POLE}, "manual", WON),
        ({"point": POINT, "pole": POLE}, "manual", WON),
        ({"pole": POLE, "point": POINT}, "manual", (0.4, 0.3)),
        ({"xi": 0.3, "point": POINT}, "manual", (0.4, 0.3)),
        ({"xi": 0.3, "pole": POLE}, "manual", WON),
        ({"point": POINT, "xi": 0.3}, "fading-memory", (0.91, 0.49)),
        ({"responsiveness": 0.5, "point": POINT}, "manual", (0.4, 0.3)),
        ({"responsiveness": 0.5, "pole": POLE}, "manual", WON),
        ({"point": POINT, "convention": "half"}, "manual", (0.4, 0.3)),
        ({"point": POINT, "design": "fading-memory"}, "fading-memory", (0.75, 0.25)),
        ({"design": "kalata", "point": POINT}, "manual", (0.4, 0.3)),
    ],
)
def test_of_a_drag_and_a_slider_the_later_one_stands(controls_for, moved, design, gains):
    got = drag(controls_for(design="fading-memory", order=2, xi=0.5), **moved)
    assert got.settings.experiment.design == design
    assert got.settings.experiment.gains().values == pytest.approx(gains, rel=1e-15)


@pytest.mark.parametrize("earlier", [{"alpha": 0.9}, {"point": POINT}, {"pole": POLE}, {"xi": 0.2}], ids=str)
def test_after_the_knob_nothing_earlier_stands(controls_for, earlier):
    controls = controls_for(design="fading-memory", order=2, xi=0.5)
    got = drag(controls, **earlier, responsiveness=0.5)
    assert got.settings == drag(controls, responsiveness=0.5).settings
    assert got.note == ""


@pytest.mark.parametrize("drag_", [{"point": POINT}, {"responsiveness": 0.5}], ids=str)
def test_a_preset_after_a_drag_is_the_run_of_the_paper_and_before_it_is_dragged(controls_for, drag_):
    run = presets()["garg2021/accelerating"]
    assert drag(controls_for(), **drag_, preset="garg2021/accelerating").settings.experiment == run
    got = drag(controls_for(), preset="garg2021/accelerating", **drag_).settings.experiment
    assert got == drag(controls_of(Settings(run)), **drag_).settings.experiment
    assert got != run
