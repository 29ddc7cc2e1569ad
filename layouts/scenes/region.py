"""The stable region of order 3 in (alpha, beta, gamma), with the design curves and the operating point."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from layouts.scenes.pictures import Drawing, RegionPicture
from layouts.scenes.stage import (
    Anchor,
    Axis,
    Box,
    Colour,
    Pin,
    Place,
    Points,
    Segments,
    add_box,
    add_label,
    add_line,
    channels,
    joined,
    light,
    look,
    mixed,
    place,
)
from layouts.theme import tokens
from tracker_core.design import DESIGNS
from tracker_core.design.curves import curve_designs, design_curve
from tracker_core.region import region_surface

if TYPE_CHECKING:
    import viser

BOX: Box = (Axis("α", 0, 2, 1.0), Axis("β", 0, 4, 1.0), Axis("γ", 0, 8, 1.0))
EYE, AT = (1.35, -2.45, 1.15), (-0.02, 0.0, -0.08)

POINT = Pin(0.022, (0, 1), (1, 2), (1, 3))
"""The operating point, with rods down to the floor and along the floor to both axes."""

NEAR = 0.03
"""Ends of curves that are closer than about this share a label."""

OFFSET = 0.02
"""From the end of a curve to its name in the scene."""

REACH = 0.1
"""Gains outside the box are drawn at its border, so far outside as a fraction of its size."""


class RegionScene:
    """The region as one browser sees it."""

    def __init__(self, client: viser.ClientHandle, picture: RegionPicture) -> None:
        self.picture = picture
        scene, t = client.scene, tokens(picture.theme)
        light(client, picture.theme)
        add_box(scene, BOX, picture.theme)
        vertices, faces = _surface()
        scene.add_mesh_simple(
            "/region", vertices, faces, color=channels(t["region-line"]), opacity=0.2, side="double", cast_shadow=False,
            receive_shadow=False,
        )  # fmt: skip
        line, ground = channels(t["region-line"]), channels(t["surface"])
        add_line(scene, "/region/edges", _edges(), mixed(line, ground, 0.7), 1.5)
        add_line(scene, "/region/rulings", _rulings(), mixed(line, ground, 0.35), 1)
        add_designs(scene, channels(t["ink-soft"]))
        self.point = POINT.add(scene, "/gains", _colour(picture), *_places(picture))

    def update(self, picture: Drawing) -> bool:
        """Move the operating point; False when the picture needs another scene."""
        if not isinstance(picture, RegionPicture) or picture.theme != self.picture.theme:
            return False
        self.point.vertices = POINT.vertices(*_places(picture))
        if picture.stable != self.picture.stable:
            self.point.color = _colour(picture)
        self.picture = picture
        return True

    @staticmethod
    def look(client: viser.ClientHandle) -> None:
        """Put the camera where the region shows well."""
        look(client, EYE, AT)


@cache
def _surface() -> tuple[Points, npt.NDArray[np.uint32]]:
    """The border of the region in the scene, and the triangles of it."""
    vertices, faces = region_surface(40, 40)
    return place(BOX, vertices), faces.astype(np.uint32)


@cache
def _curves() -> dict[str, Points]:
    """The designs of one parameter in the scene, where they lie within the box."""
    return {name: place(BOX, design_curve(name, 3)) for name in curve_designs(3)}


def add_designs(scene: viser.SceneApi, colour: Colour) -> None:
    """The curves of the designs, each with its name where its gains are largest."""
    named: dict[tuple[int, ...], str] = {}
    for name, curve in _curves().items():
        add_line(scene, f"/designs/{name}", joined(curve), colour, 1.75)
        x, y, z = curve[curve[:, 0].argmax()].tolist()
        # Of two that end at one place, both names stand there, one above the other.
        spot = tuple(round(part / NEAR) for part in (x, y, z))
        named[spot] = f"{named[spot]}\n{DESIGNS[name].title}" if spot in named else DESIGNS[name].title
        # The two families of curves end close to each other: their names go to either side.
        fading = "xi" in DESIGNS[name].parameters
        where = (x - OFFSET if fading else x + OFFSET, y, z)
        anchor: Anchor = "center-right" if fading else "center-left"
        add_label(scene, f"/designs/title-{spot}", named[spot], where, 0.8, anchor, through=True)


def _colour(picture: RegionPicture) -> tuple[int, int, int]:
    return channels(tokens(picture.theme)["good" if picture.stable else "bad"])


def _edges() -> Segments:
    """The edges of the region, all straight."""
    corners = np.array([(0, 0, 0), (2, 0, 0), (0, 4, 0), (2, 0, 8)], dtype=np.float64)
    edges = corners[[(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)]]
    return place(BOX, edges.reshape(-1, 3)).reshape(-1, 2, 3)


def _rulings() -> Segments:
    """Some of the straight lines that make up the curved upper face."""
    alpha = np.array([0.5, 1, 1.5])
    ends = np.stack((alpha, 0 * alpha, 0 * alpha, alpha, 4 - 2 * alpha, 4 * alpha), axis=1)
    return place(BOX, ends.reshape(-1, 3)).reshape(-1, 2, 3)


def _places(picture: RegionPicture) -> tuple[Place, Place, Place, Place]:
    """The operating point, the place below it on the floor, and those beside that on the two axes."""
    # Plain numbers: this is done for every move of every browser, and small arrays cost more.
    x, y, z = (
        axis.place_one(min(max(gain, axis.low - REACH * axis.high), axis.high + REACH * axis.high))
        for axis, gain in zip(BOX, picture.gains, strict=True)
    )
    left, front, floor = (-axis.size / 2 for axis in BOX)
    return (x, y, z), (x, y, floor), (left, y, floor), (x, front, floor)
