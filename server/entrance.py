"""Places for connections: how many may be open, of one client and of all, and who is heard when there are no more."""

from __future__ import annotations

from server.clients import client_at, proxies_of, watchers_of
from server.limits import Buckets, Places
from server.settings import Settings
from server.socket_wire import ASIDES

SPARE, SPARE_OF_ONE = 1000, 500
"""Connections that may be open beside all sockets, and beside those of one client: a browser opens up to six."""

EXTRA, EXTRA_OF_ONE = 500, 50
"""Connections of those for whom there is no place, who are told so; more are closed without a word."""


def most_connections(settings: Settings) -> int:
    """How many may be open at a time."""
    return settings.sockets + SPARE + EXTRA


class Entrance:
    """Places for connections; a client is an address, but the connections of a known proxy are those of many.

    Args:
        settings: `sockets`, `sockets_per_client` and `proxies` of them.

    Attributes:
        asides: what sockets say beside messages.
    """

    def __init__(self, settings: Settings) -> None:
        self._most = settings.sockets + SPARE
        self._places = Places(self._most, settings.sockets_per_client + SPARE_OF_ONE)
        self._extra = Places(EXTRA, EXTRA_OF_ONE)
        self.asides = Buckets(ASIDES)
        self._is_proxy, self._watches = proxies_of(settings.proxies), watchers_of(settings.proxies)

    def client(self, peer: tuple[str, int] | None) -> str:
        """By what name a connection from an address and port takes a place."""
        address, port = peer or ("", 0)
        return f"{address} {port}" if self._is_proxy(address) else client_at(address).key

    def spares(self, peer: tuple[str, int] | None) -> bool:
        """Whether who comes from there is heard in any case: some of them ask whether the server lives."""
        return self._watches(peer[0] if peer else "")

    def take(self, client: str, held: Places | None = None) -> Places | None:
        """Take the best place that there is, and give back the one that is held for it; None for no place."""
        if held is not self._places and self._places.enter(client):
            if held is not None:
                held.leave(client)
            return self._places
        return self._extra if held is None and self._extra.enter(client) else held

    def serves(self, held: Places | None, working: int) -> bool:
        """Whether who holds this place is served while so many others are being answered."""
        return held is self._places and working < self._most
