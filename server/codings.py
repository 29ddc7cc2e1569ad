"""How an answer is written: as it is, or compressed in a way that the browser says it reads."""

from __future__ import annotations

import gzip
from functools import lru_cache
from typing import Literal

import brotli

Coding = Literal["br", "gzip", "identity"]
Effort = Literal["quick", "thorough", "best"]

COMPRESSED: tuple[Coding, ...] = ("br", "gzip")
"""In the order in which they are preferred. Browsers read brotli over TLS and on the own machine alone."""

BROTLI: dict[Effort, int] = {"quick": 1, "thorough": 5, "best": 10}
GZIP: dict[Effort, int] = {"quick": 1, "thorough": 6, "best": 9}


@lru_cache(maxsize=256)
def preferred(accepted: str) -> Coding:
    """The coding for a client, by its Accept-Encoding header; what cannot be understood there is not accepted."""
    weights: dict[str, float] = {}
    for part in accepted.lower().split(","):
        name, *parameters = (piece.strip() for piece in part.split(";"))
        weights[name] = _weight(parameters)
    others = weights.get("*", 0.0)
    return next((coding for coding in COMPRESSED if weights.get(coding, others) > 0), "identity")


def _weight(parameters: list[str]) -> float:
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        if name.strip() == "q":
            try:
                return float(value)
            except ValueError:
                return 0.0
    return 1.0


def write(data: bytes, coding: Coding, effort: Effort) -> bytes:
    """The data in a coding.

    Args:
        data: as it is.
        coding: that the client reads.
        effort: "quick" takes about a millisecond for 100 kB, "thorough" several, "best" seconds for a megabyte. No time
            is written into it: the same data are the same bytes.
    """
    if coding == "br":
        return brotli.compress(data, quality=BROTLI[effort])
    return gzip.compress(data, GZIP[effort], mtime=0) if coding == "gzip" else data
