"""Distance from the optimum and the smooth-responsive path: against Riccati solutions and a general minimiser."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov
from scipy.optimize import minimize_scalar

from tracker_core import DESIGNS, Gains, InputError
from tracker_core.design.steady_kalman import prediction_variance
from tracker_core.optimal import (
    MOST_RESPONSIVE,
    SMOOTHEST,
    distance_from_optimal,
    index_of_noise_gain,
    optimal_gains,
    path_index,
    path_share,
    process_gain,
    process_input,
)
from tracker_core.responses import noise_gain
from tracker_core.stability import is_stable

ORDERS = [2, 3, 4]
DRIVE = {2: [1 / 2, 1], 3: [1 / 2, 1, 1], 4: [1 / 6, 1 / 2, 1, 1]}


def position_variance(closed_loop, g, tracking_index):
    """Predicted, of any gains on the model, by scipy."""
    order = len(g)
    f = closed_loop(np.zeros(order))
    keep = np.eye(order) - np.outer(g, np.eye(order)[0])
    noise = tracking_index * np.array(DRIVE[order])
    drive = keep @ noise
    p = solve_discrete_lyapunov(keep @ f, np.outer(drive, drive) + np.outer(g, g))
    return (f @ p @ f.T)[0, 0] + noise[0] ** 2


def best_variance(closed_loop, order, tracking_index):
    """Predicted, of the Kalman filter, by scipy."""
    f, h = closed_loop(np.zeros(order)), np.eye(order)[:, :1]
    drive = tracking_index * np.array(DRIVE[order])
    return solve_discrete_are(f.T, h, np.outer(drive, drive), [[1.0]])[0, 0]


@pytest.mark.parametrize("order", ORDERS)
def test_process_noise_enters_as_the_model_says(order):
    assert process_input(order).tolist() == DRIVE[order]


@pytest.mark.parametrize("order", ORDERS)
def test_process_gain_is_what_the_process_noise_adds(closed_loop, stable_gains, order):
    for g in stable_gains(order, 30, seed=order, radius=0.9):
        added = position_variance(closed_loop, g, 2.0) - position_variance(closed_loop, g, 0.0)
        assert 4 * process_gain(Gains.normalised(g)) == pytest.approx(added, rel=1e-8, abs=1e-12)


def exact_process_gain(g):
    """In eighty digits: the sum of A^k L L' A'^k by doubling, L what the filter leaves of the process noise."""
    with mp.workdps(80):
        n = len(g)
        gain = mp.matrix([mp.mpf(float(value)) for value in g])
        drive = mp.matrix([mp.mpf(1) / round(1 / value) for value in DRIVE[n]])
        f = mp.matrix(n, n)
        for i in range(n):
            for j in range(i, n):
                f[i, j] = 1 / mp.factorial(j - i)
        a, left = f - gain * f[0, :], drive - gain * drive[0]
        p = left * left.T
        for _ in range(60):
            p, a = p + a * p * a.T, a * a
        return float((f * p * f.T)[0, 0] + drive[0] ** 2)


@pytest.mark.parametrize("order", ORDERS)
def test_process_gain_keeps_its_digits(stable_gains, order):
    """Of slow and quick filters, and of any with poles up to 0.9."""
    optimal = [optimal_gains(order, index) for index in (1e-12, 1e-6, 0.01, 1, 100)]
    for g in [*optimal, *stable_gains(order, 15, seed=order, radius=0.9)]:
        assert process_gain(Gains.normalised(g)) == pytest.approx(exact_process_gain(g), rel=1e-13, abs=0)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(
    "tracking_index", [1e-12, 1e-9, 1e-6, 1e-3, 0.3, 20.784609690826528, 1e3, 1e6], ids="{:.3g}".format
)
def test_least_variance_keeps_its_digits(order, tracking_index):
    """By spectral factorisation in sixty digits: the innovation's variance is 1 over the product of the poles."""
    with mp.workdps(60):
        square = mp.mpf(tracking_index) ** 2
        polynomial = {
            2: [square, square / 4, 1],
            3: [-square, -square / 4, 0, 1],
            4: [square, square / 3, square / 36, 0, 1],
        }[order]
        sums = mp.polyroots(polynomial, maxsteps=500, extraprec=600, asc=True)
        poles = [min(((s + 2 + sign * mp.sqrt(s * (s + 4))) / 2 for sign in (1, -1)), key=abs) for s in sums]
        expected = float(mp.re(1 / mp.fprod(poles)) - 1)
    assert prediction_variance(order, tracking_index) == pytest.approx(expected, rel=1e-13, abs=0)


# Distance ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tracking_index", np.geomspace(1e-9, 100, 12), ids="{:.1e}".format)
def test_optimal_gains_are_at_no_distance(order, tracking_index):
    found = distance_from_optimal(Gains.normalised(optimal_gains(order, tracking_index)))
    assert 0 <= found.percent <= 1e-9
    assert found.tracking_index == pytest.approx(tracking_index, rel=1e-5)


@pytest.mark.parametrize("order", ORDERS)
def test_distance_is_the_least_that_a_general_minimiser_finds(closed_loop, stable_gains, order):
    for g in stable_gains(order, 5, seed=order, radius=0.85):

        def excess(at, g=g):
            index = math.exp(at)
            return position_variance(closed_loop, g, index) / best_variance(closed_loop, order, index) - 1

        grid = np.linspace(math.log(1e-5), math.log(1e6), 50)
        values = [excess(at) for at in grid]
        best = int(np.argmin(values))
        ends = grid[max(best - 1, 0)], grid[min(best + 1, 49)]
        expected = minimize_scalar(excess, bounds=ends, method="bounded", options={"xatol": 1e-9}).fun
        assert distance_from_optimal(Gains.normalised(g)).percent == pytest.approx(100 * expected, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("order", ORDERS)
@given(data=st.data())
def test_distance_is_never_negative(stable_gains, order, data):
    """For random stable gains, from the slowest to those at the border; the index stays within its domain."""
    seed, radius = data.draw(st.integers(0, 10**6)), data.draw(st.sampled_from([0.5, 0.9, 0.999]))
    (g,) = stable_gains(order, 1, seed=seed, radius=radius)
    if not is_stable(Gains.normalised(g)):
        return
    found = distance_from_optimal(Gains.normalised(g))
    assert 0 <= found.percent < math.inf
    assert 1e-12 <= found.tracking_index <= 1e6


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("xi", [0, 1e-6, 0.999, 0.999999])
def test_distance_at_the_ends_of_the_domain(order, xi):
    """Without memory, and with a very long one: the best index is beyond the domain, or just within."""
    found = distance_from_optimal(Gains.normalised(DESIGNS["fading-memory"].gains(order, xi=xi)))
    assert 0 <= found.percent < math.inf
    assert 1e-12 <= found.tracking_index <= 1e6


def test_a_step_off_the_curve_costs_its_square():
    """At order 3, along each gain; the index of the least moves along."""
    best = optimal_gains(3, 0.1)
    for k in range(3):
        small, large = (
            distance_from_optimal(Gains.normalised(best * (1 + step * np.eye(3)[k]))) for step in (0.01, 0.02)
        )
        assert small.percent > 0
        assert large.percent / small.percent == pytest.approx(4, rel=0.1)


@pytest.mark.parametrize("g", [(0.5, 3.5), (0.5, 0.0), (0.5, 0.3, 5.0), (0.5, 0.3, 0.1, 0.0)], ids=str)
def test_unstable_gains_are_at_no_distance_from_anything(g):
    with pytest.raises(InputError, match="^gains must be stable"):
        distance_from_optimal(Gains(g))


@pytest.mark.parametrize("g", [(1e-310, 1e-320), (1e-155, 1e-155), (1e-100, 1e-200, 1e-310)], ids=str)
def test_gains_that_are_all_but_nothing_are_at_no_distance_either(g):
    """What the process noise does to them is beyond all numbers."""
    with pytest.raises(InputError, match="^gains must be stable by more than rounding"):
        distance_from_optimal(Gains(g))


# The path ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tracking_index", np.geomspace(1.01e-4, 99, 9), ids="{:.1e}".format)
def test_the_index_is_read_off_the_noise_gain(order, tracking_index):
    value = float(noise_gain(optimal_gains(order, tracking_index)))
    assert index_of_noise_gain(order, value) == pytest.approx(tracking_index, rel=1e-9)


@pytest.mark.parametrize("order", ORDERS)
@given(share=st.floats(0, 1))
def test_the_optimal_filter_of_the_index_has_the_noise_gain(order, share):
    low, high = (float(noise_gain(optimal_gains(order, end))) for end in (SMOOTHEST, MOST_RESPONSIVE))
    value = low + share * (high - low)
    found = index_of_noise_gain(order, value)
    assert SMOOTHEST * (1 - 1e-9) <= found <= MOST_RESPONSIVE * (1 + 1e-9)
    assert noise_gain(optimal_gains(order, found)) == pytest.approx(value, rel=1e-10)


@pytest.mark.parametrize("order", ORDERS)
def test_the_nearer_end_stands_in_where_there_is_none(order):
    assert index_of_noise_gain(order, 0.0) == index_of_noise_gain(order, -math.inf) == SMOOTHEST
    assert index_of_noise_gain(order, 3.0) == index_of_noise_gain(order, math.inf) == MOST_RESPONSIVE


def test_no_number_is_no_noise_gain():
    with pytest.raises(InputError, match="^value must be a number"):
        index_of_noise_gain(2, math.nan)


@pytest.mark.parametrize("order", ORDERS)
def test_noise_gain_grows_along_the_path(order):
    values = [float(noise_gain(optimal_gains(order, path_index(share)))) for share in np.linspace(0, 1, 200)]
    assert (np.diff(values) > 0).all()


@given(share=st.floats(0, 1))
def test_share_and_index_are_inverse(share):
    assert path_share(path_index(share)) == pytest.approx(share, abs=1e-14)


def test_the_path_has_its_ends():
    assert (path_index(0), path_index(1)) == (SMOOTHEST, MOST_RESPONSIVE)
    assert path_index(0.5) == pytest.approx(0.1, rel=1e-14)
    assert (path_index(-3), path_index(7)) == (SMOOTHEST, MOST_RESPONSIVE)
    assert (path_share(1e-9), path_share(1e9)) == (0, 1)


@pytest.mark.parametrize("value", [math.nan, math.inf, "much", None])
def test_what_is_no_place_on_the_path_is_refused(value):
    with pytest.raises(InputError, match="^share must be"):
        path_index(value)
    with pytest.raises(InputError, match="^tracking_index must be"):
        path_share(value)


@pytest.mark.parametrize("value", [0, -1])
def test_only_positive_indices_have_a_share(value):
    with pytest.raises(InputError, match="^tracking_index must be a finite number > 0"):
        path_share(value)


@pytest.mark.parametrize("order", [1, 5, 2.5, "x"])
def test_the_input_is_of_an_order_that_there_is(order):
    with pytest.raises(InputError, match="^order must be"):
        process_input(order)
