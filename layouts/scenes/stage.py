"""What both scenes stand on: a box in the data's own numbers, its floor with a grid, ticks and labels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from layouts.theme import tokens
from tracker_core.types import FloatArray

if TYPE_CHECKING:
    import viser

FIELD = 0.6
"""Vertical field of view, rad."""

ASPECT = 1.35
"""Width of a view through its height for which the cameras are placed."""

ROD = 0.0012
"""Half the thickness of a rod in the scene."""

Colour = tuple[int, int, int]
Place = tuple[float, float, float]
Anchor = Literal["center-center", "center-left", "center-right"]
Points = npt.NDArray[np.float32]
"""Coordinates of the scene, shape (n, 3)."""
Segments = npt.NDArray[np.float32]
"""Coordinates of the scene, shape (n, 2, 3): both ends of straight lines."""

TICK = 0.012
"""Length of a tick in the scene."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of the box.

    Attributes:
        title: written at its end, with the unit.
        low: the one end in the data's own unit.
        high: the other end.
        size: its length in the scene.
        unit: by what the data are divided for the numbers at the ticks.
    """

    title: str
    low: float
    high: float
    size: float
    unit: float = 1.0

    def place(self, values: FloatArray) -> FloatArray:
        """Data to coordinates of the scene, the middle of the axis at zero."""
        shift, scale = self._scale()
        placed: FloatArray = np.multiply(values - shift, scale)
        return placed

    def place_one(self, value: float) -> float:
        """The same for one number."""
        shift, scale = self._scale()
        return (value - shift) * scale

    def _scale(self) -> tuple[float, float]:
        return (self.low + self.high) / 2, self.size / (self.high - self.low)

    def ticks(self, count: int = 5) -> FloatArray:
        """About so many round numbers within the axis, in the data's unit."""
        low, high = self.low / self.unit, self.high / self.unit
        step = round_step((high - low) / count)
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        return np.array([number * step * self.unit for number in range(first, last + 1)])

    def text(self, tick: float) -> str:
        """The number at a tick."""
        return f"{tick / self.unit:.6g}".replace("-", "−")


Box = tuple[Axis, Axis, Axis]


def round_step(step: float) -> float:
    """1, 2 or 5 times a power of ten, the nearest that is not smaller."""
    power = 10.0 ** math.floor(math.log10(step))
    return next((factor * power for factor in (1, 2, 5) if factor * power >= step * (1 - 1e-9)), 10 * power)


def mixed(colour: Colour, ground: Colour, part: float) -> Colour:
    """A colour laid thinly on a ground: that much of it."""
    red, green, blue = (round(part * a + (1 - part) * b) for a, b in zip(colour, ground, strict=True))
    return red, green, blue


def channels(colour: str) -> Colour:
    """A colour of the tokens as three numbers of 0 to 255."""
    return (int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16))


def place(box: Box, points: FloatArray) -> Points:
    """Data of shape (n, 3) to coordinates of the scene."""
    return np.stack([axis.place(points[:, i]) for i, axis in enumerate(box)], axis=1).astype(np.float32)


def joined(points: Points) -> Segments:
    """A line through points as segments, shape (at least 1, 2, 3); broken where a point is not finite."""
    finite = np.asarray(np.isfinite(points).all(axis=1))
    whole = finite[:-1] & finite[1:]
    segments = np.stack((points[:-1][whole], points[1:][whole]), axis=1)
    # What is empty cannot be drawn, and a handle that is removed cannot be updated.
    return segments if len(segments) else np.zeros((1, 2, 3), dtype=np.float32)


def add_line(
    scene: viser.SceneApi, name: str, segments: Segments, colour: Colour, width: float
) -> viser.LineSegmentsHandle:
    """Segments of one colour, `width` pixels wide."""
    return scene.add_line_segments(
        name, segments, np.array(colour, dtype=np.uint8), thickness=width, thickness_units="screen"
    )


class Pin:
    """A ball with rods that start at its middle or elsewhere: one mesh, so that one message moves all of it.

    Args:
        radius: of the ball.
        rods: pairs of places, by their index; the ball stands at place 0.
    """

    def __init__(self, radius: float, *rods: tuple[int, int]) -> None:
        ball, faces = _unit_ball()
        # Each end of a rod is a small triangle, so that it shows from every side.
        self._around = np.concatenate((radius * ball, *(ROD * _TRIANGLE for rod in rods for _ in rod)))
        self._at = np.array([0] * len(ball) + [place for rod in rods for place in rod for _ in _TRIANGLE])
        self.faces = np.concatenate((faces, *(len(ball) + 6 * rod + _SIDES for rod in range(len(rods)))))

    def vertices(self, *places: Place) -> Points:
        """The mesh for the places; shrunk to nothing where one of them is not finite."""
        where = np.array(places)
        if not np.isfinite(where).all():
            return np.zeros_like(self._around, dtype=np.float32)
        return (where[self._at] + self._around).astype(np.float32)

    def add(self, scene: viser.SceneApi, name: str, colour: Colour, *places: Place) -> viser.MeshHandle:
        """Add it to a scene; its vertices can be assigned."""
        return scene.add_mesh_simple(
            name, self.vertices(*places), self.faces, color=colour, side="double", cast_shadow=False,
            receive_shadow=False,
        )  # fmt: skip


def _unit_ball(rows: int = 9, columns: int = 16) -> tuple[FloatArray, npt.NDArray[np.uint32]]:
    """Vertices on circles of latitude, and the triangles between them."""
    latitude, longitude = np.meshgrid(
        np.linspace(0, np.pi, rows), np.linspace(0, 2 * np.pi, columns, endpoint=False), indexing="ij"
    )
    circle = np.sin(latitude)
    vertices = np.stack((circle * np.cos(longitude), circle * np.sin(longitude), np.cos(latitude)), axis=-1)
    here = np.arange((rows - 1) * columns)
    right = here - here % columns + (here + 1) % columns
    faces = np.concatenate(
        (np.stack((here, here + columns, right), axis=1), np.stack((right, here + columns, right + columns), axis=1))
    )
    return vertices.reshape(-1, 3), faces.astype(np.uint32)


_TRIANGLE = np.array([(1, -1, -1), (-1, 1, -1), (-1, -1, 1)], dtype=np.float64)
_SIDES = np.array([(0, 1, 3), (1, 4, 3), (1, 2, 4), (2, 5, 4), (2, 0, 5), (0, 3, 5)], dtype=np.uint32)


def add_label(
    scene: viser.SceneApi,
    name: str,
    text: str,
    where: Place,
    size: float = 0.95,
    anchor: Anchor = "center-center",
    *,
    through: bool = False,
) -> None:
    """A text that always faces the viewer, the same size at any distance; `through` whatever stands before it."""
    scene.add_label(name, text, position=where, font_screen_scale=size, anchor=anchor, depth_test=not through)


def add_box(scene: viser.SceneApi, box: Box, theme: str, *, flat: bool = False) -> None:
    """The floor with its grid, the axes with ticks and titles.

    Args:
        scene: of one browser.
        box: the three axes.
        theme: "light" or "dark".
        flat: whether only the first two axes mean something.
    """
    t = tokens(theme)
    x, y, z = (axis.size / 2 for axis in box)
    ticks = [[(axis.text(tick), axis.place_one(tick)) for tick in axis.ticks()] for axis in box]
    grid = [((p, -y, -z), (p, y, -z)) for _, p in ticks[0]] + [((-x, p, -z), (x, p, -z)) for _, p in ticks[1]]
    axes = [((-x, -y, -z), (x, -y, -z)), ((-x, -y, -z), (-x, y, -z))]
    axes += [((p, -y, -z), (p, -y - TICK, -z)) for _, p in ticks[0]]
    axes += [((-x, p, -z), (-x - TICK, p, -z)) for _, p in ticks[1]]
    labels = [(text, (p, -y - 4 * TICK, -z)) for text, p in ticks[0]]
    labels += [(text, (-x - 4 * TICK, p, -z)) for text, p in ticks[1]]
    titles = [(box[0].title, (0.0, -y - 11 * TICK, -z)), (box[1].title, (-x - 11 * TICK, 0.0, -z))]
    if not flat:
        grid += [part for _, p in ticks[2] for part in (((-x, y, p), (x, y, p)), ((-x, -y, p), (-x, y, p)))]
        axes += [((-x, y, -z), (-x, y, z)), *(((-x, y, p), (-x - TICK, y, p)) for _, p in ticks[2])]
        # The number at the floor would stand on that of the second axis.
        labels += [(text, (-x - 4 * TICK, y, p)) for text, p in ticks[2] if p > TICK - z]
        titles.append((box[2].title, (-x, y, z + 6 * TICK)))
    add_line(scene, "/box/grid", np.array(grid, dtype=np.float32), channels(t["line"]), 1)
    add_line(scene, "/box/axes", np.array(axes, dtype=np.float32), channels(t["control"]), 1.5)
    for i, (text, where) in enumerate(labels):
        add_label(scene, f"/box/number/{i}", text, where)
    for i, (text, where) in enumerate(titles):
        add_label(scene, f"/box/title/{i}", text, where, 1.25)


def light(client: viser.ClientHandle, theme: str) -> None:
    """Even light without shadows, nothing of viser's own around the scene."""
    client.gui.configure_theme(dark_mode=theme == "dark", show_logo=False, show_share_button=False)
    client.scene.configure_default_lights(enabled=True, cast_shadow=False)


def look(client: viser.ClientHandle, eye: Place, at: Place) -> None:
    """Put the camera somewhere, the third axis upwards; further away where the view is narrow."""
    away = max(1.0, ASPECT / client.camera.aspect) if client.camera.image_height else 1.0
    client.camera.up_direction = (0.0, 0.0, 1.0)
    client.camera.position = np.array(at) + away * (np.array(eye) - np.array(at))
    client.camera.look_at = at
    client.camera.fov = FIELD
    client.camera.min_orbit_distance = 0.2
    client.camera.max_orbit_distance = 12.0
