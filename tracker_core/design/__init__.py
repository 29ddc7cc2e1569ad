"""Gain designs: one file each, and the ordered registry that menus, docs, command line and tests read."""

from tracker_core.design import (
    benedict_bordner,
    critically_damped,
    fading_memory,
    gray_murray,
    jeong_fading_memory,
    jeong_gray_murray,
    kalata,
    simpson,
    steady_kalman,
)
from tracker_core.design.base import Design

MANUAL = "manual"
"""The gains are given as numbers, by no design."""

DESIGNS: dict[str, Design] = {
    design.name: design
    for design in (
        fading_memory.DESIGN,
        benedict_bordner.DESIGN,
        critically_damped.DESIGN,
        kalata.DESIGN,
        simpson.DESIGN,
        gray_murray.DESIGN,
        steady_kalman.DESIGN,
        jeong_gray_murray.DESIGN,
        jeong_gray_murray.AS_RUN,
        jeong_fading_memory.AS_RUN,
    )
}

__all__ = ["DESIGNS", "MANUAL", "Design"]
