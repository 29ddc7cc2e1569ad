"""Places for connections, without any."""

import pytest

from server.entrance import SPARE, Entrance
from server.settings import Settings


def test_a_place_that_becomes_free_is_taken_by_who_is_there_already(monkeypatch):
    monkeypatch.setattr("server.entrance.SPARE_OF_ONE", 0)
    entrance = Entrance(Settings(sockets_per_client=1))
    first, second = entrance.take("a"), entrance.take("a")
    assert [entrance.serves(held, 0) for held in (first, second)] == [True, False]
    assert entrance.take("a", second) is second
    first.leave("a")
    third = entrance.take("a", second)
    assert entrance.serves(third, 0)
    assert (len(first), len(second)) == (1, 0)


def test_no_more_is_worked_on_than_there_are_places():
    entrance = Entrance(Settings(sockets=1))
    held = entrance.take("a")
    assert [entrance.serves(held, working) for working in (SPARE, SPARE + 1)] == [True, False]


@pytest.mark.parametrize(
    ("peer", "name", "is_spared"),
    [
        (("192.0.2.1", 5), "192.0.2.1", False),
        (("2001:db8::1", 5), "2001:db8::/64", False),
        (("127.0.0.1", 5), "127.0.0.1", True),
        (("10.1.2.3", 5), "10.1.2.3 5", True),
        (None, "unknown", False),
    ],
)
def test_a_client_is_an_address_but_a_proxy_is_many(peer, name, is_spared):
    entrance = Entrance(Settings(proxies="10.0.0.0/8"))
    assert (entrance.client(peer), entrance.spares(peer)) == (name, is_spared)
