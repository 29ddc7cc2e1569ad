"""Targets: derivatives belong together, published numbers come out, recordings are the printed ones."""

import math

import mpmath as mp
import numpy as np
import pytest

from tracker_core import SCENARIOS, Experiment, InputError, run_experiment
from tracker_core.scenarios import Scenario, coordinated_turn
from tracker_core.scenarios.jeong_ship import parameters
from tracker_core.scenarios.polynomial import polynomial

NAMES = list(SCENARIOS)
DETERMINISTIC = [name for name in NAMES if not SCENARIOS[name].random]
RANDOM = [name for name in NAMES if SCENARIOS[name].random]
# Times at which some target's acceleration jumps.
JUMPS = np.array([15.0, 20.0, *coordinated_turn.JOINTS])


@pytest.mark.parametrize("name", NAMES)
def test_scenario_is_described(name):
    scenario = SCENARIOS[name]
    assert scenario.name == name
    assert scenario.title
    assert scenario.source
    assert scenario.description.endswith(".")
    assert len(set(scenario.axes)) == len(scenario.axes) >= 1


@pytest.mark.parametrize("name", NAMES)
def test_scenario_runs_as_it_comes(name):
    result = run_experiment(Experiment.from_dict({"scenario": name}))
    assert result.verdict.stable
    assert result.track.stopped_at is None
    assert result.truth.states.shape == (result.experiment.samples, len(SCENARIOS[name].axes), 5)
    # A random motion need not have the derivative that its filter's steady lag is proportional to.
    undefined = {name for name, value in result.metrics.to_dict().items() if value is None}
    assert undefined == (set() if np.isfinite(result.truth.states[:, :, result.experiment.order]).all() else {"lag"})


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("start", [-20.0, 0.0])
def test_states_are_finite(name, start):
    """All of a motion that is given, position to acceleration of one that is drawn."""
    states = SCENARIOS[name].truth(start + np.arange(50.0), 3).states
    assert np.isfinite(states[:, :, :3]).all()
    assert np.isfinite(states).all() or SCENARIOS[name].random


@pytest.mark.parametrize("name", DETERMINISTIC)
@pytest.mark.parametrize("derivative", range(4))
def test_every_state_is_the_derivative_of_the_one_before(name, derivative):
    """Central differences; the jumps of an acceleration are kept out of their span."""
    times = np.linspace(1.3, 700.3, 400)
    times = times[(np.abs(times[:, None] - JUMPS) > 1).all(axis=1)]
    step = 0.02
    before, at, after = (SCENARIOS[name].truth(times + shift).states for shift in (-step, 0, step))
    slope = (after - before)[:, :, derivative] / (2 * step)
    # The error of a difference: a third derivative times step^2/6, and the rounding of the larger state.
    scale = np.abs(at[:, :, derivative]).max() * 1e-16 / step + np.abs(at[:, :, derivative + 1]).max() * 1e-6
    assert np.abs(slope - at[:, :, derivative + 1]).max() <= 10 * scale + 1e-12


@pytest.mark.parametrize("name", DETERMINISTIC)
def test_truth_depends_on_time_alone(name):
    times = np.array([5.0, 10.0, 400.0])
    together = SCENARIOS[name].truth(times, 1).states
    for row, time in enumerate(times):
        assert np.array_equal(SCENARIOS[name].truth(np.array([time]), 2).states[0], together[row])


@pytest.mark.parametrize("name", RANDOM)
@pytest.mark.parametrize("interval", [0.1, 1.0, 7.0])
def test_random_truth_depends_on_seed_and_grid_alone(name, interval):
    """The same bits again, others for another seed, and a longer run begins with the shorter one."""
    times = np.arange(200) * interval
    states = SCENARIOS[name].truth(times, 5).states
    assert np.array_equal(SCENARIOS[name].truth(times, 5).states, states, equal_nan=True)
    for length in (1, 2, 77):
        assert np.array_equal(SCENARIOS[name].truth(times[:length], 5).states, states[:length], equal_nan=True)
    assert not np.isin(SCENARIOS[name].truth(times, 6).states[:, :, 2], states[:, :, 2]).any()


@pytest.mark.parametrize("name", RANDOM)
@pytest.mark.parametrize("interval", [0.1, 4.0])
def test_a_random_motion_comes_from_where_its_first_state_points(name, interval):
    """Before time zero: constant acceleration, whether that time is asked for alone or with the run."""
    grid = np.arange(-3, 6) * interval
    together = SCENARIOS[name].truth(grid, 9).states
    assert np.array_equal(SCENARIOS[name].truth(grid[3:], 9).states, together[3:], equal_nan=True)
    for row in range(3):
        alone = SCENARIOS[name].truth(grid[[row]], 9).states[0]
        assert np.array_equal(alone, together[row])
        t = grid[row]
        position, velocity, acceleration = together[3, :, :3].T
        assert alone[:, 0] == pytest.approx(position + velocity * t + acceleration * t**2 / 2, rel=1e-14, abs=0)
        assert alone[:, 1] == pytest.approx(velocity + acceleration * t, rel=1e-14, abs=0)
        assert np.array_equal(alone[:, 2], acceleration)
        assert not alone[:, 3:].any()


@pytest.mark.parametrize("motions", [(), ("motion", "random_motion")])
def test_a_scenario_has_exactly_one_motion(motions):
    with pytest.raises(InputError) as caught:
        Scenario(
            name="n", title="t", axes=("x",), description="d.", source="s",
            **dict.fromkeys(motions, lambda *_: np.zeros((1, 1, 5))),
        )  # fmt: skip
    assert caught.value.field == "motion"


# The ship of Jeong, Njonjo & Pan 2017 ------------------------------------------------------------------------------


def test_jeong_parameters_follow_from_the_printed_numbers():
    a, b, w = parameters()
    assert a == pytest.approx(31.8333, abs=5e-5)
    assert b == pytest.approx(51.92, abs=1e-12)
    assert w == pytest.approx(0.016507563, abs=5e-10)
    # What they follow from: 18a, 20b and the first speed.
    assert 18 * a == pytest.approx(573, rel=1e-14, abs=0)
    assert 20 * b == pytest.approx(1038.4, rel=1e-14, abs=0)
    assert math.hypot(44.6 * a * w + 10, 44 * b * w) == pytest.approx(50.4, rel=1e-14, abs=0)


def test_jeong_first_position_and_speed_are_the_printed_ones():
    first = SCENARIOS["jeong-ship"].truth(np.array([0.0])).states[0]
    assert first[:, 0] == pytest.approx([573, 1038.4], rel=1e-13, abs=0)
    assert math.hypot(*first[:, 1]) == pytest.approx(50.4, rel=1e-13, abs=0)


def test_jeong_mean_and_greatest_speed():
    """30.1 and 53.3 m/s over the thousand samples of the paper."""
    experiment = Experiment.from_dict({"scenario": "jeong-ship"})
    assert (experiment.samples, experiment.interval) == (1000, 3.0)
    speeds = np.hypot(*run_experiment(experiment).truth.states[:, :, 1].T)
    assert speeds.mean() == pytest.approx(30.1, abs=0.05)
    assert speeds.max() == pytest.approx(53.3, abs=0.05)


@pytest.mark.parametrize("time", [0, 3, 333, 2997])
@pytest.mark.parametrize("derivative", range(5))
def test_jeong_motion_is_equations_29_and_30(time, derivative):
    """Written out again, and differentiated by mpmath."""
    a, b, w = map(mp.mpf, parameters())

    def x(t):
        return (
            a
            * (
                10 * mp.sin(mp.mpf("1.2") * w * t)
                + 7 * mp.cos(mp.mpf(".99") * w * t)
                + 8 * mp.sin(mp.mpf(".7") * w * t)
                + 6 * mp.cos(2 * w * t)
                + 9 * mp.sin(3 * w * t)
                + 5 * mp.cos(3 * w * t)
            )
            + 10 * t
        )

    def y(t):
        return b * (20 * mp.cos(mp.mpf(".3") * w * t) + 22 * mp.sin(2 * w * t))

    with mp.workdps(50):
        expected = [float(mp.diff(axis, time, derivative)) for axis in (x, y)]
    found = SCENARIOS["jeong-ship"].truth(np.array([float(time)])).states[0, :, derivative]
    # A sum of sines cancels: the scale is that of its amplitudes.
    scale = [31.8 * 45 * (3 * float(w)) ** derivative + 10 * time, 52 * 42 * (2 * float(w)) ** derivative]
    assert (np.abs(found - expected) <= 1e-13 * np.array(scale)).all()


# Garg's aircraft ---------------------------------------------------------------------------------------------------

RANGES = {
    "garg-constant-velocity": "30171 30353 30756 30799 31018 31278 31276 31379 31748 32175",
    "garg-constant-velocity-earlier": "30110 30265 30740 30750 31135 31015 31180 31610 31960 31865",
    "garg-accelerating": "30221 30453 30906 30999 31368 31978 32526 33379 34698 36275",
    "garg-accelerating-earlier": "30160 30365 30890 31050 31785 32215 33130 34510 36010 37265",
}


@pytest.mark.parametrize("name", RANGES)
def test_garg_ranges_are_the_recorded_ones(name):
    recording = SCENARIOS[name].recording
    assert recording.interval == 5
    assert [value for (value,) in recording.positions] == [float(text) for text in RANGES[name].split()]


@pytest.mark.parametrize("name", RANGES)
def test_garg_samples_are_at_five_ten_fifteen_seconds(name):
    result = run_experiment(Experiment.from_dict({"scenario": name}))
    assert result.truth.times.tolist() == [5.0 * k for k in range(1, 11)]


@pytest.mark.parametrize("name", ["garg-constant-velocity", "garg-constant-velocity-earlier"])
def test_garg_constant_velocity_truth(name):
    """30 km away, receding at 40 m/s."""
    truth = SCENARIOS[name].truth(np.array([0.0, 5.0, 50.0]))
    assert truth.positions[:, 0].tolist() == [30_000, 30_200, 32_000]
    assert truth.states[:, 0, 1:].tolist() == [[40, 0, 0, 0]] * 3


def test_garg_accelerating_truth():
    """50 m/s for 20 s, then 8 m/s^2."""
    truth = SCENARIOS["garg-accelerating"].truth(np.array([0.0, 20.0, 30.0, 50.0]))
    assert truth.positions[:, 0].tolist() == [30_000, 31_000, 31_900, 36_100]
    assert truth.states[:, 0, 1].tolist() == [50, 50, 130, 290]
    assert truth.states[:, 0, 2].tolist() == [0, 0, 8, 8]


# The climbing turn -------------------------------------------------------------------------------------------------


def test_the_climbing_turn_is_a_helix():
    """Constant speed, constant climb, an acceleration g tan(bank) towards the centre; it starts along x."""
    times = np.linspace(0, 500, 37)
    states = SCENARIOS["climbing-turn"].truth(times).states
    position, velocity, acceleration = states[:, :, 0], states[:, :, 1], states[:, :, 2]
    assert position[0] == pytest.approx([8000, 4000, 1000], rel=1e-14, abs=0)
    assert velocity[0] == pytest.approx([180, 0, 12], rel=1e-14, abs=1e-12)
    assert np.hypot(*velocity[:, :2].T) == pytest.approx(180, rel=1e-14, abs=0)
    assert np.hypot(*acceleration[:, :2].T) == pytest.approx(9.80665 * math.tan(math.radians(25)), rel=1e-14, abs=0)
    # Across the course, to the left throughout: the horizontal part of lift in a coordinated turn.
    assert np.einsum("ij,ij->i", velocity, acceleration) == pytest.approx(0, abs=1e-10)
    assert (velocity[:, 0] * acceleration[:, 1] - velocity[:, 1] * acceleration[:, 0] > 0).all()
    assert position[:, 2] == pytest.approx(1000 + 12 * times, rel=1e-14, abs=0)
    assert not states[:, 2, 2:].any()
    radius = 180**2 / (9.80665 * math.tan(math.radians(25)))
    distance = np.hypot(position[:, 0] - 8000, position[:, 1] - 4000 - radius)
    assert distance == pytest.approx(radius, rel=1e-13, abs=0)


def test_the_noise_of_the_climbing_turn_is_larger_in_height():
    result = run_experiment(Experiment.from_dict({"scenario": "climbing-turn", "samples": 20_000}))
    errors = result.measurements.positions - result.truth.positions
    assert errors.std(axis=0) == pytest.approx([30, 30, 60], rel=0.03)


# The coordinated turns ---------------------------------------------------------------------------------------------


def test_the_turns_are_straight_legs_and_arcs():
    """Rate of turn from velocity and acceleration, course from the velocity."""
    times = np.array([-30, 0, 59, 61, 90, 119, 121, 179, 181, 209, 211, 900.0])
    states = SCENARIOS["coordinated-turn"].truth(times).states
    (vx, vy), (ax, ay) = states[:, :, 1].T, states[:, :, 2].T
    rates = np.degrees((vx * ay - vy * ax) / (vx**2 + vy**2))
    assert rates == pytest.approx([0, 0, 0, 3, 3, 3, 0, 0, -3, -3, 0, 0], rel=1e-12, abs=1e-12)
    courses = np.degrees(np.unwrap(np.arctan2(vy, vx)))
    assert courses == pytest.approx([0, 0, 0, 3, 90, 177, 180, 180, 177, 93, 90, 90], rel=1e-12, abs=1e-12)


def test_the_turns_are_flown_at_constant_speed():
    times = np.linspace(-100, 700, 2001)
    states = SCENARIOS["coordinated-turn"].truth(times).states
    assert np.hypot(*states[:, :, 1].T) == pytest.approx(120, rel=1e-12, abs=0)
    # Straight ahead nothing accelerates, exactly.
    straight = (times < 60) | ((times >= 120) & (times < 180)) | (times >= 210)
    assert not states[straight, :, 2:].any()
    sizes = np.linalg.norm(states[~straight, :, 2:], axis=1)
    rate = math.radians(3)
    assert sizes == pytest.approx(np.tile(120 * rate ** np.arange(1, 4), (len(sizes), 1)), rel=1e-12, abs=0)


@pytest.mark.parametrize("joint", coordinated_turn.JOINTS)
def test_legs_join(joint):
    """Position and velocity are continuous, and the acceleration is already that of the leg that begins."""
    before, at, after = SCENARIOS["coordinated-turn"].truth(joint + np.array([-1e-9, 0, 1e-9])).states
    for beside in (before, after):
        assert beside[:, 0] == pytest.approx(at[:, 0], rel=0, abs=2e-7)
        assert beside[:, 1] == pytest.approx(at[:, 1], rel=0, abs=2e-8)
    assert after[:, 2:] == pytest.approx(at[:, 2:], rel=0, abs=1e-9)
    assert np.hypot(*(at - before)[:, 2]) == pytest.approx(120 * math.radians(3), rel=1e-9, abs=0)


def test_the_turns_end_where_geometry_says():
    """Out 7.2 km along x, a half circle of 2 V/w to the left, back, and a quarter circle to the right."""
    radius = 120 / math.radians(3)
    found = SCENARIOS["coordinated-turn"].truth(np.array([0, 60, 120, 180, 210, 310.0])).positions
    expected = [
        (-8000, 3000), (-800, 3000), (-800, 3000 + 2 * radius), (-8000, 3000 + 2 * radius),
        (-8000 - radius, 3000 + 3 * radius), (-8000 - radius, 3000 + 3 * radius + 12_000),
    ]  # fmt: skip
    assert found == pytest.approx(np.array(expected), rel=1e-13, abs=1e-9)


# Polynomial targets ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("length", [1, 2, 3, 4, 5])
def test_polynomial_motion_is_the_taylor_series(length):
    start = np.array([700.0, -12.0, 3.0, 0.4, -0.05])[:length]
    times = np.linspace(-20, 60, 33)
    states = polynomial((tuple(start), (1.0,)), times)
    series = np.polynomial.Polynomial([value / math.factorial(k) for k, value in enumerate(start)])
    for derivative in range(5):
        expected = series.deriv(derivative)(times)
        assert states[:, 0, derivative] == pytest.approx(expected, rel=1e-12, abs=1e-9)
    assert states[:, 1].tolist() == [[1, 0, 0, 0, 0]] * 33


def test_constant_velocity_and_acceleration_are_what_they_say():
    times = np.linspace(0, 200, 7)
    straight, curved = (SCENARIOS[f"constant-{kind}"].truth(times).states for kind in ("velocity", "acceleration"))
    assert (straight[:, :, 1] == straight[0, :, 1]).all()
    assert not straight[:, :, 2:].any()
    assert (curved[:, :, 2] == curved[0, :, 2]).all()
    assert np.hypot(*curved[0, :, 2]) == pytest.approx(1.8, abs=0.05)
    assert np.hypot(*straight[0, :, 1]) == pytest.approx(128, abs=0.5)
    assert not curved[:, :, 3:].any()
