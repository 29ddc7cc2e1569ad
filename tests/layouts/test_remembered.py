"""What is remembered of a target is what would be found anew."""

from dataclasses import replace

import numpy as np
import pytest

from layouts.figures import remembered
from layouts.figures.remembered import of_target
from layouts.figures.track import position_grain
from tracker_core import Experiment, run_experiment


@pytest.fixture
def counted():
    """A function of a run that is remembered, and for what it has been asked."""
    asked = []

    @of_target
    def highest(result, factor=1.0):
        asked.append(factor)
        return factor * float(result.measurements.positions.max())

    return highest, asked


def run(**values):
    return run_experiment(Experiment.from_dict({"samples": 50, **values}))


def test_gains_do_not_matter(counted):
    highest, asked = counted
    first, second = run(xi=0.5), run(xi=0.7)
    assert first.measurements.positions is second.measurements.positions
    assert highest(first) == highest(second) == first.measurements.positions.max()
    assert asked == [1.0]


@pytest.mark.parametrize("change", [{"seed": 5}, {"samples": 60}, {"noise_std": 3.0}])
def test_another_target_is_another_matter(counted, change):
    highest, asked = counted
    first, second = run(), run(**change)
    assert highest(second) == second.measurements.positions.max()
    assert highest(first) == first.measurements.positions.max()
    assert len(asked) == 2


def test_arguments_matter(counted):
    highest, asked = counted
    first = run()
    assert highest(first, 2.0) == 2 * highest(first) == highest(first, factor=2.0)
    assert asked == [2.0, 1.0, 2.0]


def test_the_same_numbers_in_another_place_are_found_again(counted):
    """Identity is what counts, and an array that is gone may leave its identity to another."""
    highest, asked = counted
    first = run()
    for _ in range(20):
        positions = first.measurements.positions.copy()
        positions[0] = 1e6 * (1 + len(asked))
        other = replace(first, measurements=replace(first.measurements, positions=positions))
        assert highest(other) == positions.max()
    assert len(asked) == 20


def test_of_long_runs_nothing_is_kept(counted, monkeypatch):
    highest, asked = counted
    monkeypatch.setattr(remembered, "MOST_SAMPLES", 49)
    assert highest(run()) == highest(run())
    assert len(asked) == 2


def test_so_many_are_kept_and_no_more(counted, monkeypatch):
    highest, asked = counted
    monkeypatch.setattr(remembered, "TARGETS", 3)
    runs = [run(seed=seed) for seed in range(4)]
    for each in (*runs, *runs[1:], runs[0], runs[3], runs[1]):
        highest(each)
    # The fourth put the first out, and the first the second.
    assert len(asked) == 6


def test_the_grain_of_positions_is_that_of_truth_and_measurements():
    result = run(seed=8)
    both = np.concatenate((result.truth.positions, result.measurements.positions))
    span = both.max(axis=0) - both.min(axis=0)
    step = position_grain(result)
    assert ((2.0**-17 * span <= step) & (step <= 2.0**-16 * span)).all()
    assert (np.log2(step) % 1 == 0).all()
