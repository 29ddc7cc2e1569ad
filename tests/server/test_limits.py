"""What one client may take: the law of the bucket, and that remembering clients is bounded."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.limits import Buckets, Places, Rate, Turns

rates = st.builds(Rate, per_second=st.floats(0.01, 1e3), at_once=st.integers(1, 5000))
times = st.lists(st.floats(0, 1e5), max_size=300).map(sorted)


@given(rates, st.floats(0, 1e6), times)
def test_nobody_takes_more_than_a_burst_and_what_came_back_since(rate, began, later):
    """In every span of time, not only from the beginning on."""
    bucket = Buckets(rate)
    taken = [began + after for after in later if not bucket.take("a", began + after)]
    for first in range(0, len(taken), 7):
        for last in range(first, len(taken), 5):
            span = taken[last] - taken[first]
            assert last - first + 1 <= rate.at_once + rate.per_second * span + 1e-2


@given(rates, st.floats(0, 1e6), times)
def test_as_many_are_given_as_the_textbooks_bucket_has(rate, began, later):
    """Tokens that are counted one by one; where both are within rounding of a whole token, either may be right."""
    bucket, tokens, last = Buckets(rate), float(rate.at_once), began
    for after in later:
        now = began + after
        tokens, last = min(rate.at_once, tokens + (now - last) * rate.per_second), now
        given_one = not bucket.take("a", now)
        if abs(tokens - 1) > 1e-2:
            assert given_one == (tokens > 1)
        tokens -= given_one


@given(rates, st.floats(0, 1e6))
def test_who_waits_as_long_as_said_is_given_one(rate, now):
    bucket = Buckets(rate)
    while not (wait := bucket.take("a", now)):
        pass
    assert bucket.take("a", now + wait / 2) or wait < 1e-5
    assert not bucket.take("a", now + wait)


@given(rates, st.floats(0, 1e6), times)
def test_what_is_booked_comes_in_its_order_and_no_faster_than_it_comes_back(rate, began, later):
    bucket, twin = Buckets(rate), Buckets(rate)
    due, is_first = [], True
    for now in (began + after for after in later):
        wait = bucket.book("a", now)
        # Nobody waits who might have taken one.
        if is_first:
            assert wait == twin.take("a", now)
        is_first = is_first and not wait
        due.append(now + wait)
    assert all(one <= other + 1e-6 for one, other in itertools.pairwise(due))
    for first in range(0, len(due), 7):
        for last in range(first, len(due), 5):
            assert last - first + 1 <= rate.at_once + rate.per_second * (due[last] - due[first]) + 1e-2


def test_who_draws_more_than_there_is_waits_until_that_has_come_back():
    bucket = Buckets(Rate(2, 10))
    bucket.draw("a", 100.0, 30)
    # 30 of 10: 20 have to come back, and then one.
    assert math.isclose(bucket.wait("a", 100.0), 10.5)
    assert bucket.wait("a", 110.5) == 0
    assert bucket.wait("b", 100.0) == 0
    # Who merely looks takes nothing.
    assert len(bucket) == 1


def test_a_burst_of_one_is_one_after_the_other():
    bucket = Buckets(Rate(10, 1))
    assert [bucket.take("a", 100 + at) > 0 for at in (0, 0.05, 0.1, 0.15, 0.2)] == [False, True, False, True, False]


@given(st.lists(st.sampled_from("abcdefgh"), max_size=200), st.integers(1, 5))
def test_the_clients_heard_of_last_are_remembered_and_no_more(clients, most):
    bucket = Buckets(Rate(0.001, 1), most)
    remembered = []
    for client in clients:
        # Who is remembered has to wait; who is not has a full bucket.
        assert bool(bucket.take(client, 5000.0)) == (client in remembered)
        remembered = [*(other for other in remembered if other != client), client][-most:]
        assert len(bucket) == len(remembered)


@given(st.lists(st.tuples(st.sampled_from("abc"), st.booleans()), max_size=200), st.integers(0, 6), st.integers(0, 3))
def test_places_are_never_more_than_there_are(moves, most, most_of_one):
    places, held = Places(most, most_of_one), {"a": 0, "b": 0, "c": 0}
    for client, comes in moves:
        if comes:
            fits = sum(held.values()) < most and held[client] < most_of_one
            assert places.enter(client) == fits
            held[client] += fits
        elif held[client]:
            places.leave(client)
            held[client] -= 1
        assert places.total == sum(held.values())
        # Nobody is remembered who holds nothing.
        assert len(places) == sum(count > 0 for count in held.values())


def test_places_are_taken_many_at_a_time_or_not_at_all():
    places = Places(100, 60)
    assert places.enter("a", 60)
    assert not places.enter("a")
    assert not places.enter("b", 41)
    assert (places.has("b", 40), places.total, places.held("a")) == (True, 60, 60)
    places.leave("a", 60)
    assert (places.total, len(places)) == (0, 0)


def test_turns_are_a_clients_own_and_forgotten_with_it():
    turns = Turns(2)
    mine, others = turns.of("a"), turns.of("b")
    assert turns.of("a") is mine is not others
    assert len(turns) == 2
    del mine
    assert len(turns) == 1
    assert turns.of("b") is others


@pytest.mark.parametrize("now", [0.0, 1.0, 1e9])
def test_a_bucket_is_full_in_the_beginning_whatever_the_clock_says(now):
    bucket = Buckets(Rate(0.5, 3))
    waits = [bucket.take("a", now) for _ in range(4)]
    assert waits[:3] == [0, 0, 0]
    assert math.isclose(waits[3], 2, rel_tol=1e-6)
