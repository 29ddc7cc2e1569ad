"""Errors of many gain sets at once: those of every set alone, over orders, axes, starts and gaps."""

from dataclasses import replace

import numpy as np
import pytest

from tracker_core import DESIGNS, Experiment, Gains, InputError
from tracker_core.batch import KINDS, batch_errors
from tracker_core.filters import run_filter
from tracker_core.metrics import measure
from tracker_core.run import known_state, observe
from tracker_core.starts import STARTS

SCENARIOS = ("jeong-ship", "climbing-turn", "constant-velocity")
XI = (0.3, 0.64, 0.9)


def case(scenario, order, start):
    """Truth, measurements with gaps at the start, in the middle and in one axis alone, and the state before."""
    experiment = Experiment.from_dict({"scenario": scenario, "order": order, "xi": 0.7, "start": start, "samples": 90})
    truth, seen, _ = observe(experiment)
    positions = seen.positions.copy()
    positions[0] = positions[40:45] = np.nan
    positions[60, -1] = np.nan
    return truth, replace(seen, positions=positions), known_state(experiment)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_every_set_has_the_errors_of_its_track(scenario, order, start):
    if order < STARTS[start].least_order:
        pytest.skip("the start asks for a higher order")
    truth, seen, before = case(scenario, order, start)
    sets = np.array([DESIGNS["fading-memory"].gains(order, xi=xi) for xi in XI])
    found = batch_errors(seen, truth, sets, start=start, initial_state=before)
    for index, vector in enumerate(sets):
        gains = Gains.normalised(vector)
        track = run_filter(seen, gains, start=start, initial_state=before)
        expected = measure(track, seen, truth, gains, stable=True)
        for kind in KINDS:
            for how in ("total", "rmse", "max", "l2"):
                if hasattr(expected, f"{kind}_{how}"):
                    value = getattr(found[kind], how)[index]
                    assert value == pytest.approx(getattr(expected, f"{kind}_{how}"), rel=1e-11), (kind, how)


def test_a_set_that_diverges_has_no_errors_and_spoils_no_other():
    truth, seen, _ = case("jeong-ship", 2, "two-point")
    sets = np.array([[0.5, 0.2], [1.9, 3.9], [0.5, 0.2]])
    found = batch_errors(seen, truth, sets, limit=1e6)
    for errors in found.values():
        assert np.isnan(errors.total).tolist() == [False, True, False]
        assert errors.rmse[0] == errors.rmse[2]


def test_nothing_measured_after_the_start_leaves_no_error():
    truth, seen, _ = case("constant-velocity", 2, "two-point")
    positions = np.full_like(seen.positions, np.nan)
    positions[:2] = seen.positions[:2]
    positions[:2] = 1.0
    found = batch_errors(replace(seen, positions=positions), truth, np.array([[0.5, 0.2]]))
    assert np.isnan(found["innovation"].total).all()
    assert np.isnan(found["innovation"].l2).all()
    assert np.isfinite(found["tracking"].rmse).all()


@pytest.mark.parametrize(
    ("sets", "message"),
    [
        (np.zeros(3), "gains must have shape"),
        (np.zeros((2, 5)), "gains must have shape"),
        (np.zeros((1, 1)), "gains must have shape"),
    ],
)
def test_gains_of_another_shape_are_refused(sets, message):
    truth, seen, _ = case("constant-velocity", 2, "two-point")
    with pytest.raises(InputError, match=message):
        batch_errors(seen, truth, sets)
