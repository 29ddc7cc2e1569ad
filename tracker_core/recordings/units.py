"""Units of length and angle that a file may use."""

from __future__ import annotations

from math import pi
from types import MappingProxyType

LENGTHS = MappingProxyType({"m": 1.0, "km": 1000.0, "ft": 0.3048, "NM": 1852.0})
"""Metres in one of each: metre, kilometre, international foot, nautical mile."""

ANGLES = MappingProxyType({"deg": pi / 180, "rad": 1.0})
"""Radians in one of each."""
