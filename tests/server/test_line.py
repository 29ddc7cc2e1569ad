"""Whose turn it is: that no client takes everything, that none waits for nothing, and that places come back."""

import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.clients import CLIENT
from server.limits import share
from server.line import Door, Line


def turns(line):
    """Whose turn it is by now."""
    given = []
    while (one := line.next()) is not None:
        given.append(one)
    return given


def entered(line, *names):
    """Put some in the line who are called after their client; those who found room."""
    return [name for name in names if line.enter(name[0], name)]


def test_one_client_has_its_share_and_the_next_free_turn_is_anothers():
    line = Line(3, 2, 10)
    entered(line, "a1", "a2", "a3", "b1", "b2")
    assert turns(line) == ["a1", "b1", "a2"]
    line.leave("a")
    # As many are the one's as the other's, whose turn has been longer ago.
    assert turns(line) == ["b2"]
    line.leave("b")
    assert turns(line) == ["a3"]
    assert (line.taken, len(line)) == (3, 0)


def test_alone_a_client_is_held_up_by_its_own_share_only():
    line = Line(3, 2, 10)
    entered(line, "a1", "a2", "a3")
    assert turns(line) == ["a1", "a2"]
    entered(line, "b1")
    assert turns(line) == ["b1"]


def test_the_line_says_in_which_order_it_will_be():
    line = Line(1, 1, 10)
    entered(line, "a1", "a2", "a3", "b1", "c1", "b2")
    assert turns(line) == ["a1"]
    assert [*line] == ["b1", "c1", "a2", "b2", "a3"]
    order = []
    while line.taken:
        line.leave("a" if not order else order[-1][0])
        order += turns(line)
    assert order == ["b1", "c1", "a2", "b2", "a3"]


@pytest.mark.parametrize("most", [1, 2])
def test_whoever_comes_later_does_not_come_first_for_ever(most):
    """A client that has had a turn and wants another, while others come who never had one."""
    line = Line(most, most, 1000)
    entered(line, "a1", "a2", "a3")
    running, order = turns(line), []
    for number in range(20):
        name = f"{chr(0x4E00 + number)}1"
        entered(line, name)
        line.leave(running.pop(0)[0])
        called = turns(line)
        running += called
        order += called
    assert order.index("a3") <= 4


def test_the_line_ends_and_half_of_it_is_one_clients():
    line = Line(1, 1, 4)
    assert entered(line, "a1") == turns(line) == ["a1"]
    assert entered(line, "a2", "a3", "a4", "b1", "c1", "d1") == ["a2", "a3", "b1", "c1"]


def test_without_room_to_wait_there_is_a_turn_all_the_same():
    line = Line(2, 1, 0)
    assert entered(line, "a1") == turns(line) == ["a1"]
    assert entered(line, "a2", "b1") == ["b1"]


def test_who_leaves_the_line_is_not_called():
    line = Line(1, 1, 4)
    entered(line, "a1")
    turns(line)
    entered(line, "b1", "c1")
    assert line.remove("b", "b1")
    assert not line.remove("b", "b1")
    line.leave("a")
    assert turns(line) == ["c1"]


@given(
    st.lists(st.tuples(st.sampled_from("abc"), st.integers(0, 2)), max_size=120),
    st.integers(1, 4), st.integers(1, 4), st.integers(0, 5),
)  # fmt: skip
def test_nobody_waits_for_a_turn_that_he_could_have(moves, most, most_of_one, waiting):
    line, has, waits, number = Line(most, most_of_one, waiting), [], [], 0
    for client, move in moves:
        if move == 0:
            number += 1
            if line.enter(client, (client, number)):
                waits.append((client, number))
        elif move == 1 and has:
            line.leave(has.pop(0)[0])
        elif waits:
            one = waits.pop()
            line.remove(one[0], one)
        for one in turns(line):
            waits.remove(one)
            has.append(one)
        counts = [sum(name == each for name, _ in has) for each in "abc"]
        assert (line.taken, len(line)) == (len(has), len(waits))
        assert len(has) <= most
        assert max(counts) <= most_of_one
        assert len(waits) <= waiting
        assert sorted(line) == sorted(waits)
        assert all(len(has) == most or counts["abc".index(name)] == most_of_one for name, _ in waits)


@pytest.mark.parametrize(("most", "part"), [(0, 1), (1, 1), (2, 1), (3, 2), (100, 50)])
def test_a_share_is_half_and_never_nothing(most, part):
    assert share(most) == part


# A door -------------------------------------------------------------------------------------------------------------


class Guests:
    """Who passes a door, each as a client's; they go when they are told to."""

    def __init__(self, door):
        self.door, self.inside, self.away, self.going = door, [], [], {}

    def come(self, name):
        """A guest who is called after his client."""
        self.going[name] = asyncio.Event()
        return asyncio.create_task(self._visit(name))

    async def _visit(self, name):
        CLIENT.set(name[0])
        async with self.door.passed() as there:
            if there:
                self.inside.append(name)
                await self.going[name].wait()
                self.inside.remove(name)
            else:
                self.away.append(name)

    async def settle(self):
        for _ in range(5):
            await asyncio.sleep(0)
        return sorted(self.inside)


def played(test):
    async def within():
        async with asyncio.timeout(20):
            await test()

    return lambda: asyncio.run(within())


@played
async def test_a_client_that_stays_leaves_the_others_their_places():
    guests = Guests(Door(4, 10, 20))
    visits = [guests.come(name) for name in ("a1", "a2", "a3", "b1")]
    assert await guests.settle() == ["a1", "a2", "b1"]
    guests.going["a1"].set()
    assert await guests.settle() == ["a2", "a3", "b1"]
    for name in guests.going:
        guests.going[name].set()
    await asyncio.gather(*visits)
    assert guests.door.inside == 0


@played
async def test_who_waits_in_vain_or_goes_away_leaves_no_trace():
    guests = Guests(Door(1, 4, 0.05))
    first = guests.come("a1")
    await guests.settle()
    late, gone = guests.come("b1"), guests.come("c1")
    await guests.settle()
    gone.cancel()
    await late
    assert guests.away == ["b1"]
    guests.going["a1"].set()
    await first
    last = guests.come("d1")
    assert await guests.settle() == ["d1"]
    guests.going["d1"].set()
    await last
    assert guests.door.inside == 0


@played
async def test_who_finds_no_room_to_wait_hears_it_at_once():
    guests = Guests(Door(1, 2, 20))
    visits = [guests.come(name) for name in ("a1", "a2", "a3", "b1", "c1")]
    assert await guests.settle() == ["a1"]
    assert guests.away == ["a3", "c1"]
    for name in guests.going:
        guests.going[name].set()
    await asyncio.gather(*visits)


@played
async def test_who_breaks_off_inside_makes_room():
    guests = Guests(Door(1, 2, 20))
    first, second = guests.come("a1"), guests.come("b1")
    await guests.settle()
    first.cancel()
    await guests.settle()
    assert "b1" in guests.inside
    guests.going["b1"].set()
    await second
