"""The filter of an experiment on its own: taken out, put on another target, the same filter everywhere."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import DESIGNS, SCENARIOS, STARTS, Experiment, InputError
from tracker_core.adaptive import METHODS, PARAMETERS
from tracker_core.experiment import FILTER_FIELDS, read_filter
from tracker_core.fields import FIELDS

GAINS = ("alpha", "beta", "gamma", "eta")
TOLD = {
    "fixed_alpha": 0.11, "weight": 0.25, "criterion": "mean-absolute", "window": 7, "step": 3, "levels": 9, "grid": 5,
    "grid_eta": 3, "refinements": 2, "members": 7, "memory": 9.5, "shortest": 2.5, "longest": 77.0,
    "objective": "velocity", "end_points": "middle", "ties": "last", "bound": "triangle", "parabola": "printed",
}  # fmt: skip


@st.composite
def filters(draw):
    """The values of a filter that fits every target with a known acceleration."""
    design = draw(st.sampled_from(["manual", *DESIGNS, *METHODS]))
    orders = DESIGNS[design].orders if design in DESIGNS else METHODS[design].orders if design in METHODS else (2, 3, 4)
    order = draw(st.sampled_from(orders))
    values = {"design": design, "order": order, "convention": draw(st.sampled_from(["normalised", "taylor", "half"]))}
    if design in DESIGNS:
        values |= {name: draw(st.floats(0.1, 0.9)) for name in DESIGNS[design].parameters}
    elif design == "manual":
        values |= {name: draw(st.floats(-27, 27)) for name in GAINS[:order]}
    else:
        chosen = draw(st.sets(st.sampled_from(sorted(PARAMETERS)))) & set(METHODS[design].parameters)
        values |= {name: TOLD[name] for name in sorted(chosen)}
        if chosen & {"shortest", "longest"}:
            values |= {"shortest": 2.5, "longest": 77.0}
    starts = [name for name, start in STARTS.items() if order >= start.least_order]
    return values | {"start": draw(st.sampled_from([s for s in starts if s != "expanding" or design not in METHODS]))}


TARGETS = st.sampled_from([name for name, scenario in SCENARIOS.items() if scenario.known_states >= 3])


@given(values=filters(), one=TARGETS, other=TARGETS)
def test_a_filter_is_the_same_on_every_target(values, one, other):
    first = Experiment.from_dict({"scenario": one, "noise": "white", "samples": 60, **values})
    said = first.filter_values()
    assert first.with_filter(said) == first
    assert first.with_filter(json.loads(json.dumps({name: str(value) for name, value in said.items()}))) == first
    target = Experiment.from_dict({"scenario": other, "noise": "white", "samples": 60})
    second = target.with_filter(said)
    assert second.filter_values() == said == read_filter(said)
    for name in FIELDS:
        assert getattr(second, name) == getattr(first if name in FILTER_FIELDS else target, name)


@given(values=filters())
def test_nothing_goes_unsaid_that_is_not_the_same_everywhere(values):
    """Every value that is left out, read alone, is filled in whatever the target's own defaults are."""
    said = read_filter(values)
    for scenario in ("jeong-ship", "garg-accelerating", "yu-wu"):
        target = Experiment.from_dict({"scenario": scenario, "noise": "white", "samples": 60})
        made = target.with_filter(said)
        assert {name: getattr(made, name) for name in values} == values


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({}, {"design": "fading-memory", "xi": 0.64}),
        ({"order": 2}, {"design": "fading-memory", "order": 2, "xi": 0.64}),
        ({"alpha": 0.5, "beta": 0.2}, {"design": "manual", "alpha": 0.5, "beta": 0.2}),
        ({"design": "kalata", "tracking_index": 1}, {"design": "kalata", "tracking_index": 1.0}),
        ({"design": "moving-window"}, {"design": "moving-window"}),
        ({"design": "moving-window", "window": 7}, {"design": "moving-window", "window": 7}),
        # The interval of the ship's radar is 3 s.
        ({"design": "parallel-bank-causal"}, {"design": "parallel-bank-causal", "memory": 30.0}),
        ({"scenario": "garg-accelerating"},
         {"design": "manual", "alpha": 0.5, "beta": 0.4, "gamma": 0.1, "convention": "taylor", "start": "known"}),
    ],
)  # fmt: skip
def test_a_filter_says_what_is_not_usual(values, said):
    assert Experiment.from_dict(values).filter_values() == said


def test_what_depends_on_the_interval_is_filled_in_where_it_is_left_out():
    target = Experiment.from_dict({"interval": 0.25})
    assert target.with_filter({"design": "parallel-bank-causal"}).memory == 2.5


@pytest.mark.parametrize(
    ("values", "design", "order"),
    [
        ({}, "fading-memory", None),
        ({"xi": 0.5}, "fading-memory", 3),
        ({"alpha": 0.5, "beta": 0.2}, "manual", 2),
        ({"alpha": 0.5, "beta": 0.2, "gamma": 0.1}, "manual", 3),
        ({"tracking_index": 0.5}, "gray-murray", 3),
        ({"order": 2, "tracking_index": 0.5}, "kalata", 2),
        ({"design": "kalata", "tracking_index": 0.5}, "kalata", 2),
    ],
)
def test_the_parameters_choose_the_design_whatever_the_target(values, design, order):
    target = Experiment.from_dict({"scenario": "garg-accelerating"})
    if order is None:
        with pytest.raises(InputError, match="^xi must be given"):
            target.with_filter(values)
        return
    made = target.with_filter(values)
    assert (made.design, made.order, made.scenario) == (design, order, "garg-accelerating")


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"seed": 1}, "seed"), ({"colour": 1}, "colour"), ({"design": "best"}, "design"), ({"xi": 1}, "xi"),
        ({"xi": "x"}, "xi"), ({"order": 5}, "order"), ({"design": "kalata", "order": 3, "tracking_index": 1}, "order"),
        ({"design": "moving-window", "window": 10}, "window"), ({"alpha": 0.5}, "beta"),
        ({"design": "growing-memory", "start": "expanding"}, "start"), ({"design": "growing-memory", "xi": 0.5}, "xi"),
    ],
)  # fmt: skip
def test_what_is_no_filter_or_does_not_fit_is_refused(values, field):
    with pytest.raises(InputError) as caught:
        Experiment.from_dict({"samples": 10}).with_filter(values)
    assert caught.value.field == field
