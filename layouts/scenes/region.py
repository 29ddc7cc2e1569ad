"""The stable region of order 3 in (alpha, beta, gamma), with the design curves and the operating point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from layouts.scenes.pictures import Drawing, RegionPicture
from layouts.scenes.stage import Axis, Box, add_box, add_line, light, look, place, rgb
from layouts.theme import tokens
from tracker_core.types import FloatArray, IntArray

if TYPE_CHECKING:
    import viser

BOX: Box = (Axis("α", 0, 2, 1.0), Axis("β", 0, 4, 1.0), Axis("γ", 0, 8, 1.0))
EYE, AT = (1.55, -2.6, 1.25), (-0.05, 0.0, -0.05)

REACH = 0.1
"""Gains outside the box are drawn at its border, so far outside as a fraction of its size."""


def region_surface(rows: int = 40, columns: int = 40) -> tuple[FloatArray, IntArray]:
    """Stand-in."""
    alpha, s = np.meshgrid(np.linspace(0, 2, rows), np.linspace(0, 1, columns), indexing="ij")
    sheets = [
        (alpha, s * (4 - 2 * alpha), 4 * alpha * s),
        (alpha, s * (4 - 2 * alpha), 0 * s),
        (alpha, 4 - 2 * alpha, 4 * alpha * s),
    ]
    vertices = np.concatenate([np.stack(sheet, axis=-1).reshape(-1, 3) for sheet in sheets])
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack((corner, corner + 1, corner + columns), axis=1),
            np.stack((corner + 1, corner + columns + 1, corner + columns), axis=1),
        ]
    )
    return vertices, np.concatenate([faces + i * rows * columns for i in range(3)])


class RegionScene:
    """The region as one browser sees it."""

    def __init__(self, client: viser.ClientHandle, picture: RegionPicture) -> None:
        self.picture = picture
        scene, t = client.scene, tokens(picture.theme)
        light(client, picture.theme)
        add_box(scene, BOX, picture.theme)
        vertices, faces = region_surface(40, 40)
        scene.add_mesh_simple(
            "/region", place(BOX, vertices), faces.astype(np.uint32), color=rgb(t["region-line"]), opacity=0.22,
            side="double", cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        self.drop = add_line(scene, "/gains/drop", _drop(picture), rgb(t["ink-soft"]), 1.25)
        self.point = scene.add_icosphere(
            "/gains/point", 0.024, _colour(picture), position=_point(picture), cast_shadow=False, receive_shadow=False
        )

    def update(self, picture: Drawing) -> bool:
        """Move the operating point; False when the picture needs another scene."""
        if not isinstance(picture, RegionPicture) or picture.theme != self.picture.theme:
            return False
        self.point.position = _point(picture)
        self.drop.points = _drop(picture)
        if picture.stable != self.picture.stable:
            self.point.color = _colour(picture)
        self.picture = picture
        return True

    @staticmethod
    def look(client: viser.ClientHandle) -> None:
        """Put the camera where the region shows well."""
        look(client, EYE, AT)


def _colour(picture: RegionPicture) -> tuple[int, int, int]:
    return rgb(tokens(picture.theme)["good" if picture.stable else "bad"])


def _point(picture: RegionPicture) -> npt.NDArray[np.float32]:
    low, high = (np.array([getattr(axis, end) for axis in BOX]) for end in ("low", "high"))
    reach = REACH * (high - low)
    return place(BOX, np.clip(np.array([picture.gains]), low - reach, high + reach))[0]


def _drop(picture: RegionPicture) -> npt.NDArray[np.float32]:
    """From the point down to the floor, and along the floor to both axes."""
    point = _point(picture)
    x, y, floor = (-axis.size / 2 for axis in BOX)
    foot = np.array([point[0], point[1], floor], dtype=np.float32)
    return np.array([(point, foot), (foot, (x, foot[1], floor)), (foot, (foot[0], y, floor))], dtype=np.float32)
