"""What both scenes stand on: a box in the data's own numbers, its floor with a grid, ticks and labels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from layouts.theme import tokens
from tracker_core.types import FloatArray

if TYPE_CHECKING:
    import viser

Colour = tuple[int, int, int]

TICK = 0.012
"""Length of a tick in the scene."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of the box.

    Attributes:
        title: written at its end, with the unit.
        low, high: the ends in the data's own unit.
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
        centred: FloatArray = np.asarray(values - (self.low + self.high) / 2)
        return centred * (self.size / (self.high - self.low))

    def ticks(self, count: int = 4) -> FloatArray:
        """About so many round numbers within the axis, in the data's unit."""
        low, high = self.low / self.unit, self.high / self.unit
        step = round_step((high - low) / count)
        numbers = np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)
        return numbers * step * self.unit

    def text(self, tick: float) -> str:
        """The number at a tick."""
        return f"{tick / self.unit:.6g}".replace("-", "−")


Box = tuple[Axis, Axis, Axis]


def round_step(step: float) -> float:
    """1, 2 or 5 times a power of ten, the nearest that is not smaller."""
    power = 10.0 ** math.floor(math.log10(step))
    return next((factor * power for factor in (1, 2, 5) if factor * power >= step * (1 - 1e-9)), 10 * power)


def rgb(colour: str) -> Colour:
    """A token such as #0072b2 as three numbers of 0 to 255."""
    return (int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16))


def place(box: Box, points: FloatArray) -> npt.NDArray[np.float32]:
    """Data of shape (n, 3) to coordinates of the scene."""
    return np.stack([axis.place(points[:, i]) for i, axis in enumerate(box)], axis=1).astype(np.float32)


def joined(points: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """A line through points as segments, shape (at least 1, 2, 3); broken where a point is not finite."""
    finite = np.asarray(np.isfinite(points).all(axis=1))
    whole = finite[:-1] & finite[1:]
    segments = np.stack((points[:-1][whole], points[1:][whole]), axis=1)
    # What is empty cannot be drawn, and a handle that is removed cannot be updated.
    return segments if len(segments) else np.zeros((1, 2, 3), dtype=np.float32)


def add_line(
    scene: viser.SceneApi, name: str, segments: npt.NDArray[np.float32], colour: Colour, width: float
) -> viser.LineSegmentsHandle:
    """Segments of one colour, `width` pixels wide."""
    return scene.add_line_segments(
        name, segments, np.array(colour, dtype=np.uint8), thickness=width, thickness_units="screen"
    )


def add_label(
    scene: viser.SceneApi, name: str, text: str, where: tuple[float, float, float], size: float = 0.8
) -> None:
    """A text that always faces the viewer."""
    scene.add_label(name, text, position=where, font_screen_scale=size, anchor="center-center", depth_test=False)


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
    ticks = [[(axis.text(tick), float(axis.place(tick))) for tick in axis.ticks()] for axis in box]
    grid = [((p, -y, -z), (p, y, -z)) for _, p in ticks[0]] + [((-x, p, -z), (x, p, -z)) for _, p in ticks[1]]
    axes = [((-x, -y, -z), (x, -y, -z)), ((-x, -y, -z), (-x, y, -z))]
    axes += [((p, -y, -z), (p, -y - TICK, -z)) for _, p in ticks[0]]
    axes += [((-x, p, -z), (-x - TICK, p, -z)) for _, p in ticks[1]]
    labels = [(text, (p, -y - 4 * TICK, -z)) for text, p in ticks[0]]
    labels += [(text, (-x - 4 * TICK, p, -z)) for text, p in ticks[1]]
    titles = [(box[0].title, (0, -y - 10 * TICK, -z)), (box[1].title, (-x - 10 * TICK, 0, -z))]
    if not flat:
        grid += [part for _, p in ticks[2] for part in (((-x, y, p), (x, y, p)), ((-x, -y, p), (-x, y, p)))]
        axes += [((-x, y, -z), (-x, y, z)), *(((-x, y, p), (-x - TICK, y, p)) for _, p in ticks[2])]
        labels += [(text, (-x - 4 * TICK, y, p)) for text, p in ticks[2]]
        titles.append((box[2].title, (-x, y, z + 6 * TICK)))
    add_line(scene, "/box/grid", np.array(grid, dtype=np.float32), rgb(t["grid"]), 1)
    add_line(scene, "/box/axes", np.array(axes, dtype=np.float32), rgb(t["control"]), 1.25)
    for i, (text, where) in enumerate(labels):
        add_label(scene, f"/box/number/{i}", text, where)
    for i, (text, where) in enumerate(titles):
        add_label(scene, f"/box/title/{i}", text, where, 1)


def light(client: viser.ClientHandle, theme: str) -> None:
    """Even light without shadows, nothing of viser's own around the scene."""
    client.gui.configure_theme(dark_mode=theme == "dark", show_logo=False, show_share_button=False)
    client.scene.configure_default_lights(enabled=True, cast_shadow=False)


def look(client: viser.ClientHandle, eye: tuple[float, float, float], at: tuple[float, float, float]) -> None:
    """Put the camera somewhere, the third axis upwards."""
    client.camera.up_direction = (0.0, 0.0, 1.0)
    client.camera.position = eye
    client.camera.look_at = at
    client.camera.fov = 0.6
    client.camera.min_orbit_distance = 0.2
    client.camera.max_orbit_distance = 12.0
