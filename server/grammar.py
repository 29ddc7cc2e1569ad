"""How what is set is written: hosts, networks, sources of frames, addresses with a password in them."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Callable

from tracker_core.checks import InputError

_LABEL = r"[A-Za-z0-9](?:[A-Za-z0-9_-]{0,61}[A-Za-z0-9])?"
_NAME = re.compile(rf"{_LABEL}(?:\.{_LABEL})*\.?")
_SOURCE = re.compile(
    rf"(?:[A-Za-z][A-Za-z0-9+.-]*://)?(?:\*|(?:\*\.)?{_LABEL}(?:\.{_LABEL})*)(?::(?:[0-9]{{1,5}}|\*))?"
)
_ALONE = "'none'"

HOST_RULE = "must be the name or the address of a host"
NETWORKS_RULE = "must be addresses or networks such as 10.0.0.0/8, with a comma between them"
FRAMES_RULE = f"must be 'self' and sources such as https://*.example.org with a space between them, or {_ALONE} alone"


def check_host(field: str, text: str) -> str:
    """The name or the address of a host.

    Raises:
        InputError: for anything else.
    """
    if not _NAME.fullmatch(text):
        _network(field, HOST_RULE, text, ipaddress.ip_address)
    return text


def check_networks(field: str, text: str) -> str:
    """Addresses and networks, with a comma between them and nothing else; empty for none.

    Raises:
        InputError: where one is neither; a network's address has no bits beyond its mask.
    """
    items = [item.strip() for item in text.split(",")] if text else []
    for item in items:
        _network(field, NETWORKS_RULE, item, ipaddress.ip_network)
    return ",".join(items)


def check_frames(field: str, text: str) -> str:
    """Sources of a content security policy, with one space between them.

    Nothing else can stand in it, so that it ends neither its directive nor its header.

    Raises:
        InputError: where one is none, and where there is none.
    """
    items = text.split(" ")
    sound = items == [_ALONE] or all(item == "'self'" or _SOURCE.fullmatch(item) for item in items)
    if not sound:
        raise InputError(field, FRAMES_RULE, text)
    return text


def without_password(address: str) -> str:
    """An address without the name and the password of who may use it."""
    scheme = re.match(r"[a-z]+://", address)
    return f"{scheme[0] if scheme else ''}…@{address.rpartition('@')[2]}" if "@" in address else address


def _network(field: str, rule: str, text: str, read: Callable[[str], object]) -> None:
    try:
        read(text)
    except ValueError:
        raise InputError(field, rule, text) from None
