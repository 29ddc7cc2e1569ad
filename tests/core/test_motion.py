"""The transition matrix: powers of time over factorials."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from tracker_core.motion import transition

INTERVAL = st.floats(-10, 10)
ORDERS = range(1, 6)


@pytest.mark.parametrize("order", ORDERS)
@given(interval=INTERVAL)
def test_is_the_exponential_of_the_shift_matrix(order, interval):
    shift = np.eye(order, k=1)
    assert transition(order, interval) == pytest.approx(expm(shift * interval), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("order", ORDERS)
@given(first=INTERVAL, second=INTERVAL)
def test_two_steps_are_one_long_step(order, first, second):
    assert transition(order, first) @ transition(order, second) == pytest.approx(
        transition(order, first + second), rel=1e-12, abs=1e-10
    )


@pytest.mark.parametrize("order", ORDERS)
@given(interval=st.floats(-3, 3))
def test_backwards_undoes_forwards(order, interval):
    assert transition(order, interval) @ transition(order, -interval) == pytest.approx(np.eye(order), abs=1e-12)


def test_moves_a_state_as_a_polynomial_does():
    # 1 + 2t + 3t^2/2 + 4t^3/6 at t = 2, and its derivatives.
    state = transition(4, 2.0) @ [1, 2, 3, 4]
    assert state == pytest.approx([1 + 4 + 6 + 16 / 3, 2 + 6 + 8, 3 + 8, 4], rel=1e-15, abs=0)
