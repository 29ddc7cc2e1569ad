"""Headers of every answer: what a browser may do with it.

Strict-Transport-Security is not among them: only the proxy that ends TLS knows whether, and for how long, there is any.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

Pairs = list[tuple[bytes, bytes]]

NO_PAGE = "default-src 'none'"
"""Policy of what has none of its own, which pages have: opened by itself, it may load and run nothing."""

UNUSED = (
    "accelerometer", "autoplay", "camera", "clipboard-read", "display-capture", "encrypted-media", "geolocation",
    "gyroscope", "hid", "idle-detection", "local-fonts", "magnetometer", "microphone", "midi", "payment",
    "picture-in-picture", "publickey-credentials-get", "screen-wake-lock", "serial", "usb", "xr-spatial-tracking",
)  # fmt: skip
"""Features of a browser that no page uses, of those that browsers know: of an unknown name they complain."""

USED = ("clipboard-write", "fullscreen")

POLICY = b"content-security-policy"
_ANCESTORS = "frame-ancestors"


class Headers:
    """What is added to the headers of an answer; what it says itself stands.

    Args:
        frames: sources that may show pages in a frame, as in `frame-ancestors`. This server always may, since pages
            show scenes of its own in frames: 'none' is as good as 'self'.
    """

    def __init__(self, frames: str = "'self'") -> None:
        others = [source for source in frames.split() if source not in ("'self'", "'none'")]
        ancestors = " ".join(["'self'", *others])
        self._fitted = lru_cache(maxsize=64)(lambda own: with_ancestors(own, ancestors))
        self._no_page = with_ancestors(NO_PAGE.encode(), ancestors)
        features = [f"{name}=()" for name in UNUSED] + [f"{name}=(self)" for name in USED]
        self._always = [
            (b"x-content-type-options", b"nosniff"),
            # Addresses hold what somebody works on, and sometimes a token: no other site hears of them.
            (b"referrer-policy", b"same-origin"),
            (b"permissions-policy", ", ".join(features).encode()),
            # Both leave frames alone: in one, the first is not looked at, and the second is about what is loaded.
            (b"cross-origin-opener-policy", b"same-origin"),
            (b"cross-origin-resource-policy", b"same-origin"),
        ]
        if not others:
            # For browsers that know nothing newer; it cannot name others.
            self._always.append((b"x-frame-options", b"SAMEORIGIN"))

    def complete(self, status: int, headers: Iterable[Sequence[bytes]], request: bytes) -> Pairs:
        """All headers of an answer.

        Args:
            status: of HTTP.
            headers: that it has, their names in small letters.
            request: number that the log knows the request by.
        """
        own: dict[bytes, bytes] = {}
        full: Pairs = []
        for name, value in headers:
            own[name] = value
            full.append((name, self._fitted(value) if name == POLICY else value))
        # 304 changes the headers of what the browser has: its policy stays as it is.
        if POLICY not in own and status != 304:
            full.append((POLICY, self._no_page))
        full += [pair for pair in self._always if pair[0] not in own]
        full.append((b"x-request-id", request))
        return full


def with_ancestors(policy: bytes, ancestors: str) -> bytes:
    """A content security policy with these sources, and no others, that may show the page in a frame."""
    directives = [directive.strip() for directive in policy.decode("latin-1").split(";")]
    kept = [directive for directive in directives if directive and directive.split()[0].lower() != _ANCESTORS]
    return "; ".join([*kept, f"{_ANCESTORS} {ancestors}"]).encode("latin-1")
