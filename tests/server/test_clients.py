"""Who asks: how addresses are told apart, and what a log shows of them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.clients import FORWARDED, LONGEST, client_at, is_forwarded


@pytest.mark.parametrize(
    ("address", "key", "shown", "loopback"),
    [
        ("192.0.2.77", "192.0.2.77", "192.0.2.0/24", False),
        ("127.0.0.1", "127.0.0.1", "127.0.0.0/24", True),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64", "2001:db8:1::/48", False),
        ("2001:db8:1:2:ffff::1", "2001:db8:1:2::/64", "2001:db8:1::/48", False),
        ("2001:db8:1:3::1", "2001:db8:1:3::/64", "2001:db8:1::/48", False),
        ("::ffff:192.0.2.77", "192.0.2.77", "192.0.2.0/24", False),
        ("fe80::1%eth0", "fe80::/64", "fe80::/48", False),
        ("::1", "::/64", "::/48", True),
        ("", "unknown", "unknown", False),
        ("_hidden", "_hidden", "unknown", False),
        ("x" * 1000, "x" * LONGEST, "unknown", False),
    ],
)
def test_a_client_is_an_address_or_a_network_of_its_own(address, key, shown, loopback):
    client = client_at(address)
    assert (client.key, client.shown, client.loopback) == (key, shown, loopback)


@given(st.ip_addresses(v=4))
def test_a_log_does_not_tell_the_addresses_of_a_network_apart(address):
    shown = {client_at(f"{str(address).rpartition('.')[0]}.{last}").shown for last in range(256)}
    assert len(shown) == 1


@given(st.ip_addresses(), st.ip_addresses())
def test_the_same_network_is_shown_of_what_counts_as_the_same_client(one, other):
    first, second = client_at(str(one)), client_at(str(other))
    assert first.key != second.key or first.shown == second.shown


@pytest.mark.parametrize("name", FORWARDED)
def test_what_a_proxy_passed_on_is_known(name):
    assert is_forwarded({b"host": b"a", name: b"anything"})
    assert not is_forwarded({b"host": b"a"})
