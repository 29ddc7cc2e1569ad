"""Who asks: as far as limits and logs have to know, and no further.

A limit counts an IPv6 client by its /64, since one machine has as many addresses as it likes there. A log shows a
network alone, the last part of the address left out: an address is a person's, and what is wrong with a server shows
without it. Whoever needs more has the log of the proxy in front.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from functools import lru_cache
from ipaddress import IPv4Address, IPv4Network, IPv6Address, IPv6Network, ip_address
from typing import Any, cast

from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

UNKNOWN = "unknown"

CLIENT: ContextVar[str] = ContextVar("client", default=UNKNOWN)
"""By which limits know who is being answered: see `Client.key`."""

LONGEST = 64
"""Characters of what is no address."""

FORWARDED = (b"forwarded", b"x-forwarded-for", b"x-forwarded-host", b"x-real-ip", b"via")
"""Headers by one of which a proxy gives itself away."""


@dataclass(frozen=True, slots=True)
class Client:
    """Who asks.

    Attributes:
        key: by which limits know it.
        shown: in logs.
        loopback: whether the address is one of this machine's own.
    """

    key: str
    shown: str
    loopback: bool


@lru_cache(maxsize=4096)
def client_at(address: str) -> Client:
    """Who asks from an address, as a server or a proxy gives it; one that is none is a client as well."""
    try:
        ip = ip_address(address.partition("%")[0])
    except ValueError:
        return Client(address[:LONGEST] or UNKNOWN, UNKNOWN, loopback=False)
    if isinstance(ip, IPv6Address) and ip.ipv4_mapped is not None:
        ip = ip.ipv4_mapped
    if isinstance(ip, IPv4Address):
        return Client(str(ip), str(IPv4Network((ip, 24), strict=False)), ip.is_loopback)
    return Client(str(IPv6Network((ip, 64), strict=False)), str(IPv6Network((ip, 48), strict=False)), ip.is_loopback)


def is_forwarded(headers: Mapping[bytes, bytes]) -> bool:
    """Whether a proxy passed a request on, by its own account."""
    return any(name in headers for name in FORWARDED)


def proxies_of(setting: str) -> Callable[[str], bool]:
    """Whether an address is one of those whose word is taken for who the client is, as a setting names them."""
    return ProxyHeadersMiddleware(cast(Any, None), setting or []).trusted_hosts.__contains__


def watchers_of(setting: str) -> Callable[[str], bool]:
    """Whether from an address it is asked again and again if the server lives: from this machine, and by known proxies.

    Args:
        setting: as for `proxies_of`.
    """
    is_proxy = proxies_of(setting)
    return lambda address: is_proxy(address) or client_at(address).loopback
