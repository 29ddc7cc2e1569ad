"""Gain designs: against Riccati solutions, characteristic polynomials, least squares, mpmath and printed numbers."""

import math
from decimal import Decimal

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_lyapunov

from tracker_core import DESIGNS, InputError
from tracker_core.conventions import GAIN
from tracker_core.design import MANUAL, Design
from tracker_core.design.curves import SPANS, curve_designs, design_curve
from tracker_core.design.steady_kalman import optimal_gains

TRACKING_INDICES = np.logspace(-4, 3, 29)
XI = st.floats(0, 0.99)


def gains(name, order=None, **parameters):
    return DESIGNS[name].gains(order, **parameters)


def half_a_unit(printed):
    """Half a unit of the last printed digit."""
    return 0.5 * 10.0 ** int(Decimal(printed).as_tuple().exponent)


def assert_prints(value, printed):
    assert float(value) == pytest.approx(float(printed), rel=0, abs=half_a_unit(printed) + 1e-17)


# The registry ------------------------------------------------------------------------------------------------------

EXAMPLE = {"alpha": 0.5, "beta": 0.3, "xi": 0.6, "tracking_index": 0.5}


@pytest.mark.parametrize("name", DESIGNS)
def test_design_is_described(name):
    design = DESIGNS[name]
    assert isinstance(design, Design)
    assert design.name == name != MANUAL
    assert design.title
    assert design.source
    assert tuple(design.formula) == design.orders
    assert all("=" in formula for formula in design.formula.values())
    assert set(design.orders) <= {2, 3, 4}
    assert design.orders == tuple(sorted(design.formulas))
    assert design.parameters


@pytest.mark.parametrize(
    ("name", "order"), [(design.name, order) for design in DESIGNS.values() for order in design.orders]
)
def test_design_gives_as_many_gains_as_the_order(name, order):
    given_parameters = {key: EXAMPLE[key] for key in DESIGNS[name].parameters}
    g = gains(name, order, **given_parameters)
    assert g.shape == (order,)
    assert g.dtype == np.float64
    assert all(value in GAIN for value in g)


@pytest.mark.parametrize(
    "design", [design for design in DESIGNS.values() if len(design.orders) == 1], ids=lambda d: d.name
)
def test_the_order_may_be_left_out_where_there_is_one(design):
    given_parameters = {key: EXAMPLE[key] for key in design.parameters}
    assert np.array_equal(design.gains(**given_parameters), design.gains(design.orders[0], **given_parameters))


@pytest.mark.parametrize(
    ("name", "order"), [("fading-memory", None), ("fading-memory", 5), ("kalata", 3), ("gray-murray", 2)]
)
def test_an_order_that_the_design_does_not_serve_is_refused(name, order):
    given_parameters = {key: EXAMPLE[key] for key in DESIGNS[name].parameters}
    with pytest.raises(InputError, match="^order must be .* for the design '" + name) as caught:
        gains(name, order, **given_parameters)
    assert caught.value.received == order


@pytest.mark.parametrize("name", DESIGNS)
def test_a_missing_parameter_is_named(name):
    design = DESIGNS[name]
    with pytest.raises(InputError) as caught:
        design.gains(design.orders[0])
    assert caught.value.field == next(iter(design.parameters))
    assert "must be given" in caught.value.rule


@pytest.mark.parametrize("name", DESIGNS)
def test_a_parameter_of_another_design_is_refused(name):
    design = DESIGNS[name]
    given_parameters = {key: EXAMPLE[key] for key in design.parameters}
    with pytest.raises(InputError) as caught:
        design.gains(design.orders[0], **given_parameters, eta=0.5)
    assert (caught.value.field, caught.value.received) == ("eta", 0.5)


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [
        ("benedict-bordner", "alpha", 0),
        ("benedict-bordner", "alpha", 2),
        ("benedict-bordner", "alpha", 2.5),
        ("benedict-bordner", "alpha", -0.1),
        ("critically-damped", "alpha", 0),
        ("critically-damped", "alpha", 1.0000001),
        ("simpson", "alpha", 2),
        ("simpson", "beta", 0),
        ("fading-memory", "xi", -1e-9),
        ("fading-memory", "xi", 1),
        ("fading-memory", "xi", math.nan),
        ("jeong-fading-memory-as-run", "xi", 1),
        ("kalata", "tracking_index", 0),
        ("kalata", "tracking_index", -1),
        ("kalata", "tracking_index", 9e-13),
        ("kalata", "tracking_index", 1000001),
        ("kalata", "tracking_index", math.inf),
        ("gray-murray", "tracking_index", 0),
        ("gray-murray", "tracking_index", 9e-13),
        ("gray-murray", "tracking_index", 1000001),
        ("jeong-gray-murray", "tracking_index", 0),
        ("jeong-gray-murray-as-run", "tracking_index", "much"),
    ],
)
def test_a_parameter_outside_its_domain_is_refused(name, parameter, value):
    design = DESIGNS[name]
    given_parameters = {key: EXAMPLE[key] for key in design.parameters} | {parameter: value}
    with pytest.raises(InputError) as caught:
        design.gains(design.orders[0], **given_parameters)
    assert caught.value.field == parameter
    assert caught.value.rule == design.parameters[parameter].rule
    assert caught.value.received is value


# Steady Kalman filters ---------------------------------------------------------------------------------------------


OPTIMAL = [("kalata", 2), ("gray-murray", 3), ("steady-kalman", 2), ("steady-kalman", 3), ("steady-kalman", 4)]


def held_acceleration(order, interval):
    """How the process noise enters, G: an acceleration held over the interval, and for order 3 kept afterwards.

    At order 4 a jerk takes its place, kept afterwards.
    """
    if order == 4:
        return np.array([interval**3 / 6, interval**2 / 2, interval, 1.0])[:, None]
    return np.array([interval**2 / 2, interval, 1.0])[:order, None]


@pytest.mark.parametrize("tracking_index", TRACKING_INDICES, ids="{:.3g}".format)
@pytest.mark.parametrize(("name", "order"), OPTIMAL)
def test_tracking_index_designs_solve_the_riccati_equation(steady_kalman, name, order, tracking_index):
    spread = held_acceleration(order, 1.0)
    expected = steady_kalman(spread @ spread.T * tracking_index**2)
    assert gains(name, order, tracking_index=tracking_index) == pytest.approx(expected, rel=1e-9, abs=0)


@pytest.mark.parametrize(
    ("interval", "process_std", "sensor_std"), [(0.1, 5, 2), (3, 0.03162, 10), (0.5, 1, 0.5), (10, 0.2, 80)]
)
@pytest.mark.parametrize(("name", "order"), OPTIMAL)
def test_the_tracking_index_is_all_that_counts(steady_kalman, name, order, interval, process_std, sensor_std):
    """Interval and both noises enter through process_std T^2 / sensor_std alone; T^3 at order 4."""
    spread = held_acceleration(order, interval)
    expected = steady_kalman(spread @ spread.T * process_std**2, sensor_std**2, interval)
    found = gains(name, order, tracking_index=process_std * interval ** (3 if order == 4 else 2) / sensor_std)
    assert found == pytest.approx(expected, rel=1e-9, abs=0)


@pytest.mark.parametrize(
    ("interval", "process_std", "sensor_std", "alpha", "velocity_gain"),
    [
        ("1", "0.1", "2", "0.270867118992628", "0.042694639037219"),
        ("0.5", "1", "0.5", "0.628373457204967", "0.609611796797792"),
        ("2", "0.02", "10", "0.118799444828764", "0.003754891327687"),
    ],
)
def test_kalata_to_fifteen_decimals(interval, process_std, sensor_std, alpha, velocity_gain):
    """Alpha and beta/T."""
    index = Decimal(process_std) * Decimal(interval) ** 2 / Decimal(sensor_std)
    g = gains("kalata", tracking_index=float(index))
    assert_prints(g[0], alpha)
    assert_prints(g[1] / float(interval), velocity_gain)


@pytest.mark.parametrize(
    ("tracking_index", "printed"),
    [
        (0.01, ("0.35006678", "0.07512900", "0.00806184")),
        (0.1, ("0.60475875", "0.27575389", "0.06286822")),
        (1, ("0.86431794", "0.79796229", "0.36835046")),
    ],
)
def test_gray_murray_to_eight_decimals(tracking_index, printed):
    for value, text in zip(gains("gray-murray", tracking_index=tracking_index), printed, strict=True):
        assert_prints(value, text)


def exact_kalata(tracking_index):
    """In fifty digits, where the textbook form may cancel as it likes."""
    with mp.workdps(50):
        index = mp.mpf(tracking_index)
        r = (4 + index - mp.sqrt(8 * index + index**2)) / 4
        return 1 - r**2, 2 * (1 - r) ** 2


def exact_gray_murray(tracking_index):
    """The root of s^3 + (L/2 - 3)s^2 + (L/2 + 3)s - 1 in (0, 1), in eighty digits."""
    with mp.workdps(80):
        half = mp.mpf(tracking_index) / 2
        low, high = mp.mpf(0), mp.mpf(1)
        for _ in range(200):  # the cubic rises from -1 at 0 to L at 1
            s = (low + high) / 2
            if s**3 + (half - 3) * s**2 + (half + 3) * s - 1 < 0:
                low = s
            else:
                high = s
        alpha, beta = 1 - s**2, 2 * (1 - s) ** 2
        return alpha, beta, beta**2 / (2 * alpha)


ENDS = [1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e3, 1e4, 1e5, 1e6]


@pytest.mark.parametrize(
    ("name", "exact", "tracking_index"),
    [pytest.param("gray-murray", exact_gray_murray, index, id=f"gray-murray-{index:g}") for index in ENDS]
    + [pytest.param("kalata", exact_kalata, index, id=f"kalata-{index:g}") for index in ENDS],
)
def test_tracking_index_designs_keep_their_digits_at_both_ends(name, exact, tracking_index):
    expected = [float(value) for value in exact(tracking_index)]
    assert gains(name, tracking_index=tracking_index) == pytest.approx(expected, rel=1e-12, abs=0)


@pytest.mark.parametrize("tracking_index", [*ENDS, 0.1, 1, 10], ids="{:g}".format)
@pytest.mark.parametrize(("name", "order"), [("kalata", 2), ("gray-murray", 3)])
def test_steady_kalman_is_kalata_and_gray_murray(name, order, tracking_index):
    expected = gains(name, tracking_index=tracking_index)
    assert gains("steady-kalman", order, tracking_index=tracking_index) == pytest.approx(expected, rel=1e-12, abs=0)


@given(exponent=st.floats(-12, 6))
@example(exponent=math.log10(12 * math.sqrt(3)))
def test_steady_kalman_of_order_three_is_gray_murray_everywhere(exponent):
    """In the example two of the optimal poles are equal: below it they are complex, above it real."""
    expected = gains("gray-murray", tracking_index=10.0**exponent)
    assert optimal_gains(3, 10.0**exponent) == pytest.approx(expected, rel=1e-13, abs=0)


def improved(g, tracking_index):
    """The gains that the covariance of a filter with gains g asks for, in eighty digits.

    This is Newton's method on the Riccati equation (Hewer 1971): where g misses the optimum by a little, they miss it
    by the square of that.
    """
    with mp.workdps(80):
        n = len(g)
        gain, h = mp.matrix([mp.mpf(float(value)) for value in g]), mp.matrix([[1] + [0] * (n - 1)])
        f = mp.matrix(n, n)
        for i in range(n):
            for j in range(i, n):
                f[i, j] = 1 / mp.factorial(j - i)
        # Held over the interval: 1/2, 1, and at order 3 the increment itself; one power more at order 4.
        drive = mp.matrix(([mp.mpf(1) / 6] if n == 4 else []) + [mp.mpf(1) / 2, 1, 1][: 3 if n > 2 else 2])
        q = mp.mpf(tracking_index) ** 2 * drive * drive.T
        keep = mp.eye(n) - gain * h
        p, a = keep * q * keep.T + gain * gain.T, keep * f
        for _ in range(50):
            p, a = p + a * p * a.T, a * a
        predicted = f * p * f.T + q
        return [float(predicted[i, 0] / (predicted[0, 0] + 1)) for i in range(n)]


@pytest.mark.parametrize("tracking_index", [*ENDS, 0.1, 1, 10], ids="{:g}".format)
@pytest.mark.parametrize("order", [2, 3, 4])
def test_steady_kalman_keeps_its_digits_at_both_ends(order, tracking_index):
    g = gains("steady-kalman", order, tracking_index=tracking_index)
    assert g == pytest.approx(improved(g, tracking_index), rel=1e-12, abs=0)


@pytest.mark.parametrize(
    ("order", "tracking_index", "field"),
    [
        (1, 1.0, "order"),
        (5, 1.0, "order"),
        (2, 0.0, "tracking_index"),
        (3, -1.0, "tracking_index"),
        (4, math.nan, "tracking_index"),
        (4, 1e7, "tracking_index"),
    ],
)
def test_optimal_gains_of_nothing_are_refused(order, tracking_index, field):
    with pytest.raises(InputError) as caught:
        optimal_gains(order, tracking_index)
    assert caught.value.field == field


@given(tracking_index=st.floats(1e-5, 1e6))
def test_gray_murray_relations(tracking_index):
    """beta = 2(2 - alpha) - 4 sqrt(1 - alpha) and gamma = beta^2/(2 alpha), as for Kalata."""
    alpha, beta, gamma = gains("gray-murray", tracking_index=tracking_index)
    assert beta == pytest.approx(2 * (2 - alpha) - 4 * math.sqrt(1 - alpha), rel=1e-9, abs=0)
    assert gamma == pytest.approx(beta**2 / (2 * alpha), rel=1e-14, abs=0)


@given(tracking_index=st.floats(1e-5, 1e6))
def test_the_tracking_index_can_be_read_off_the_gains(tracking_index):
    """L^2 = beta^2/(1 - alpha) for order 2 (Kalata), gamma^2/(1 - alpha) for order 3 (Gray & Murray)."""
    for name, last in (("kalata", 1), ("gray-murray", 2)):
        g = gains(name, tracking_index=tracking_index)
        if g[0] < 0.99:
            assert g[last] ** 2 / (1 - g[0]) == pytest.approx(tracking_index**2, rel=1e-10, abs=0)


def widespread_gray_murray(tracking_index):
    """Cardano's formula with -cbrt(q + v/2), as found in much public code; right is -cbrt((q + v)/2)."""
    b, c, d = tracking_index / 2 - 3, tracking_index / 2 + 3, -1
    p, q = c - b**2 / 3, 2 * b**3 / 27 - b * c / 3 + d
    v = math.sqrt(q**2 + 4 * p**3 / 27)
    z = -math.cbrt(q + v / 2)
    s = z - p / (3 * z) - b / 3
    alpha, beta = 1 - s**2, 2 * (1 - s) ** 2
    return np.array([alpha, beta, beta**2 / (2 * alpha)])


def position_variance(g, tracking_index):
    """Steady variance of the smoothed position under the process noise that the design assumes (Joseph's form)."""
    f = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]])
    keep = np.eye(3) - np.outer(g, [1, 0, 0])
    q = held_acceleration(3, 1.0) @ held_acceleration(3, 1.0).T * tracking_index**2
    return solve_discrete_lyapunov(keep @ f, keep @ q @ keep.T + np.outer(g, g))[0, 0]


@pytest.mark.parametrize(("tracking_index", "percent"), [(0.001, 4.6), (0.01, 5.6), (0.1, 7.7), (1, 9.3)])
def test_the_widespread_gray_murray_formula_costs_position_variance(tracking_index, percent):
    best = position_variance(gains("gray-murray", tracking_index=tracking_index), tracking_index)
    wrong = position_variance(widespread_gray_murray(tracking_index), tracking_index)
    assert 100 * (wrong / best - 1) == pytest.approx(percent, abs=0.05)


@pytest.mark.parametrize("tracking_index", [0.01, 0.1, 1, 10])
def test_no_neighbour_of_gray_murray_is_better(tracking_index):
    """The optimum: any step away from it costs variance, whatever the direction."""
    g = gains("gray-murray", tracking_index=tracking_index)
    best = position_variance(g, tracking_index)
    for direction in np.random.default_rng(0).normal(size=(20, 3)):
        assert position_variance(g * (1 + 0.01 * direction), tracking_index) > best


@pytest.mark.parametrize("q", np.logspace(-6, 4, 21), ids="{:.2g}".format)
def test_benedict_bordner_is_the_kalman_filter_with_noise_on_velocity_alone(steady_kalman, q):
    alpha, beta = steady_kalman(np.diag([0.0, q]))
    assert gains("benedict-bordner", alpha=alpha) == pytest.approx([alpha, beta], rel=1e-10, abs=0)


# Fading memory and critical damping --------------------------------------------------------------------------------


def characteristic_polynomial(matrix):
    """Coefficients by the Faddeev-LeVerrier recursion: no roots, so nothing is lost where they coincide."""
    n = len(matrix)
    coefficients, m = [1.0], np.zeros((n, n))
    for k in range(1, n + 1):
        m = matrix @ m + coefficients[-1] * np.eye(n)
        coefficients.append(-np.trace(matrix @ m) / k)
    return np.array(coefficients)


@pytest.mark.parametrize("order", [2, 3, 4])
@given(xi=XI)
def test_fading_memory_has_every_pole_at_xi(closed_loop, order, xi):
    found = characteristic_polynomial(closed_loop(gains("fading-memory", order, xi=xi)))
    expected = [math.comb(order, k) * (-xi) ** k for k in range(order + 1)]
    assert found == pytest.approx(expected, rel=0, abs=1e-12)


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("xi", [0.1, 0.36, 0.64, 0.74, 0.9, 0.98])
def test_fading_memory_is_discounted_least_squares(order, xi):
    """The fit with weights xi^k to all the past, k samples ago, reacts to the newest sample with these gains."""
    with mp.workdps(60):
        # Normal equations: the sums over the past of xi^k (-k)^m are polylogarithms.
        power = [(-1) ** m * mp.polylog(-m, mp.mpf(xi)) for m in range(2 * order - 1)]
        power[0] += 1  # the newest sample, k = 0
        normal = mp.matrix(order, order)
        for i in range(order):
            for j in range(order):
                normal[i, j] = power[i + j] / (mp.factorial(i) * mp.factorial(j))
        newest = mp.matrix([1] + [0] * (order - 1))
        expected = [float(value) for value in mp.lu_solve(normal, newest)]
    assert gains("fading-memory", order, xi=xi) == pytest.approx(expected, rel=1e-12, abs=0)


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("distance", [1e-2, 1e-4, 1e-6, 1e-9])
def test_fading_memory_keeps_its_digits_close_to_one(order, distance):
    xi = 1 - distance
    with mp.workdps(50):
        x = mp.mpf(xi)
        beta = {2: (1 - x) ** 2, 3: 1.5 * (1 - x) ** 2 * (1 + x), 4: (1 - x) ** 2 * (11 + 14 * x + 11 * x**2) / 6}
        expected = [float(1 - x**order), float(beta[order])]
    assert gains("fading-memory", order, xi=xi)[:2] == pytest.approx(expected, rel=1e-12, abs=0)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_fading_memory_without_memory_follows_the_measurements(order):
    """At xi = 0 all poles are at zero: the polynomial through the last measurements."""
    expected = {2: [1, 1], 3: [1, 1.5, 1], 4: [1, 11 / 6, 2, 1]}[order]
    assert gains("fading-memory", order, xi=0) == pytest.approx(expected, rel=1e-15, abs=0)


@given(alpha=st.floats(1e-6, 1))
def test_critically_damped_has_a_double_root(alpha):
    """The discriminant of z^2 + (alpha + beta - 2)z + 1 - alpha vanishes, and both roots lie in [0, 1)."""
    a, beta = gains("critically-damped", alpha=alpha)
    assert a == alpha
    assert (alpha + beta - 2) ** 2 == pytest.approx(4 * (1 - alpha), rel=1e-12, abs=1e-15)
    assert 0 <= (2 - alpha - beta) / 2 < 1


@given(alpha=st.floats(1e-12, 1))
def test_critically_damped_keeps_its_digits(alpha):
    with mp.workdps(50):
        exact = 2 - mp.mpf(alpha) - 2 * mp.sqrt(1 - mp.mpf(alpha))
        assert gains("critically-damped", alpha=alpha)[1] == pytest.approx(float(exact), rel=1e-14, abs=0)


@given(alpha=st.floats(0.0199, 1))
@example(alpha=1.0)
@example(alpha=math.nextafter(1, 0))
def test_critically_damped_is_the_fading_memory_filter_of_order_two(alpha):
    """With xi from alpha; the other way round, one rounding of an alpha near 1 moves beta in the eighth digit."""
    expected = gains("critically-damped", alpha=alpha)
    assert gains("fading-memory", 2, xi=math.sqrt(1 - alpha)) == pytest.approx(expected, rel=1e-13, abs=0)


@given(tracking_index=st.floats(1e-3, 1e3))
def test_kalata_has_twice_the_critically_damped_beta(tracking_index):
    alpha, beta = gains("kalata", tracking_index=tracking_index)
    assert beta == pytest.approx(2 * gains("critically-damped", alpha=alpha)[1], rel=1e-11, abs=0)


# Simpson's condition -----------------------------------------------------------------------------------------------


@given(alpha=st.floats(0.01, 1.99), beta=st.floats(0.01, 4))
def test_simpson_condition(alpha, beta):
    """2 beta - alpha (alpha + beta + gamma/2) = 0 (Jeong et al. 2017, eq. 8)."""
    g = gains("simpson", alpha=alpha, beta=beta)
    assert g[:2].tolist() == [alpha, beta]
    assert 2 * beta == pytest.approx(alpha * (alpha + beta + g[2] / 2), rel=1e-12, abs=0)


@given(alpha=st.floats(0.01, 1.99))
def test_simpson_with_benedict_bordner_leaves_no_third_gain(alpha):
    """Eq. 8 with eq. 7 forces gamma = 0 identically."""
    _, beta = gains("benedict-bordner", alpha=alpha)
    size = 2 * (2 * beta / alpha + alpha + beta)
    assert abs(gains("simpson", alpha=alpha, beta=beta)[2]) <= 1e-15 * size


@given(alpha=st.floats(0.01, 1.99), factor=st.floats(0.5, 2))
def test_simpson_gamma_has_the_sign_of_what_beta_exceeds(alpha, factor):
    _, beta = gains("benedict-bordner", alpha=alpha)
    gamma = gains("simpson", alpha=alpha, beta=beta * factor)[2]
    if abs(factor - 1) > 1e-9:
        assert (gamma > 0) == (factor > 1)


# The filters of Jeong, Njonjo & Pan 2017 ---------------------------------------------------------------------------


@given(tracking_index=st.floats(1e-4, 1e3))
def test_jeong_gray_murray_is_kalata_with_a_third_gain(tracking_index):
    alpha, beta, gamma = gains("jeong-gray-murray", tracking_index=tracking_index)
    assert [alpha, beta] == gains("kalata", tracking_index=tracking_index).tolist()
    assert gamma == pytest.approx(beta**2 / (2 * alpha), rel=1e-14, abs=0)


@pytest.mark.parametrize("tracking_index", [0.01, 0.2846, 1])
def test_jeong_gray_murray_is_not_the_optimum(tracking_index):
    best = position_variance(gains("gray-murray", tracking_index=tracking_index), tracking_index)
    approximate = position_variance(gains("jeong-gray-murray", tracking_index=tracking_index), tracking_index)
    assert approximate > 1.01 * best


@pytest.mark.parametrize(
    ("as_run", "designed", "order", "parameters"),
    [
        ("jeong-gray-murray-as-run", "jeong-gray-murray", 3, {"tracking_index": 0.2846}),
        ("jeong-fading-memory-as-run", "fading-memory", 3, {"xi": 0.64}),
        ("jeong-fading-memory-as-run", "fading-memory", 4, {"xi": 0.74}),
    ],
)
def test_as_run_the_acceleration_gain_is_doubled(as_run, designed, order, parameters):
    """Eq. 6 applies 2 gamma/T^2 to a gamma that eq. 13, 16 and 27 define for gamma/T^2."""
    expected = gains(designed, order, **parameters)
    expected[2] *= 2
    assert gains(as_run, order, **parameters).tolist() == expected.tolist()


def test_as_run_the_poles_of_the_fading_memory_filter_differ(closed_loop):
    found = np.sort(np.abs(np.linalg.eigvals(closed_loop(gains("jeong-fading-memory-as-run", 3, xi=0.64)))))
    assert found == pytest.approx([0.404, 0.806, 0.806], abs=0.0005)


# Curves ------------------------------------------------------------------------------------------------------------

CURVES = [(name, order) for order in (2, 3, 4) for name in curve_designs(order)]


def test_curves_are_the_designs_of_one_parameter():
    assert curve_designs(2) == ("fading-memory", "benedict-bordner", "critically-damped", "kalata", "steady-kalman")
    assert curve_designs(3) == ("fading-memory", "gray-murray", "steady-kalman")
    assert curve_designs(4) == ("fading-memory", "steady-kalman")


@pytest.mark.parametrize(("name", "order"), CURVES)
def test_a_curve_is_the_design_along_its_parameter(name, order):
    """Every point is one of the design, the ends are those of the span, and the last gain grows or falls throughout."""
    curve = design_curve(name, order, points=50)
    assert curve.shape == (50, order)
    ((parameter, domain),) = DESIGNS[name].parameters.items()
    low, high = SPANS[parameter]
    ends = max(low, domain.low), min(high, domain.high)
    for row, end in zip(curve[[0, -1]], ends, strict=True):
        assert row == pytest.approx(gains(name, order, **{parameter: end}), rel=1e-12, abs=1e-15)
    assert len(set(np.sign(np.diff(curve[:, -1])).tolist())) == 1
    if parameter == "alpha":
        assert [gains(name, order, alpha=float(row[0])).tolist() for row in curve] == curve.tolist()


def test_a_curve_cannot_be_written_to():
    with pytest.raises(ValueError, match="read-only"):
        design_curve("kalata", 2)[0, 0] = 0.0


@pytest.mark.parametrize(("name", "order"), [("simpson", 3), ("kalata", 3), ("manual", 2), ("jeong-gray-murray", 3)])
def test_a_design_without_a_curve_is_refused(name, order):
    with pytest.raises(InputError, match="^design must be one of"):
        design_curve(name, order)
