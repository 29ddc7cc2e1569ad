"""A track in three dimensions: two axes and time, three axes, or one axis and time in a plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layouts.scenes.pictures import Drawing, TrackDrawing
from layouts.scenes.stage import (
    Axis,
    Box,
    Pin,
    Place,
    Points,
    Segments,
    add_box,
    add_line,
    channels,
    joined,
    light,
    look,
    mixed,
    place,
)
from layouts.theme import LINES, tokens
from tracker_core.types import FloatArray

if TYPE_CHECKING:
    import viser

HEIGHT = 0.7
"""Of the third axis, where it has a scale of its own; the larger of the other two is 1."""

FLAT = 0.35
"""A third position axis that would be lower than this on the scale of the others is drawn so high."""

DRAWN_MARKERS = 600
"""Of more measurements every n-th is marked."""

CURSOR, MEASURED = Pin(0.014, (0, 1)), Pin(0.008)
"""The smoothed position at the cursor, with a rod down to the floor, and the measured one."""

MARGIN = 0.04
KILOMETRES = 5_000
FAR = 3.0
"""Beyond so many boxes nothing is drawn, so that a diverging run cannot spoil the picture."""

EYES = {1: (0.0, -0.5, 2.1), 2: (1.0, -1.95, 1.05), 3: (1.0, -1.95, 1.05)}


def box_of(drawing: TrackDrawing) -> Box:
    """The box of truth and measurements: the filter's lines do not change it. x and y are on equal scale."""
    seen = np.concatenate((drawing.series["truth"], drawing.series["observed"]))
    ends = [_ends(seen[:, i]) for i in range(seen.shape[1])]
    time = Axis("time (s)", *_padded(float(drawing.times[0]), float(drawing.times[-1]), 0.0), HEIGHT)
    spans = [high - low for low, high in ends]
    if len(ends) == 1:
        across = Axis(time.title, time.low, time.high, 1.4)
        return across, _metres(drawing.names[0], *ends[0], 0.8, spans[0]), Axis("", -1.0, 1.0, 0.02)
    widest = max(spans[:2])
    plane = [_metres(drawing.names[i], *ends[i], spans[i] / widest, widest) for i in (0, 1)]
    if len(ends) == 2:
        return plane[0], plane[1], time
    height = max(FLAT, min(1.0, spans[2] / widest))
    return plane[0], plane[1], _metres(drawing.names[2], *ends[2], height, spans[2])


def _ends(values: FloatArray) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return _padded(float(finite.min()), float(finite.max()), MARGIN)


def _padded(low: float, high: float, margin: float) -> tuple[float, float]:
    # A target that stands still has an extent of nothing; the box has one.
    pad = margin * (high - low) if high > low else max(abs(low), 1.0) * 0.05
    return low - pad, high + pad


def _metres(name: str, low: float, high: float, size: float, span: float) -> Axis:
    unit, word = (1e3, "km") if span > KILOMETRES else (1.0, "m")
    return Axis(f"{name} ({word})", low, high, size, unit)


def points_of(box: Box, times: FloatArray, positions: FloatArray) -> Points:
    """Positions of shape (n, n_axes) in the scene, shape (n, 3); NaN where they are far outside."""
    axes = positions.shape[1]
    if axes == 1:
        columns = np.stack((times, positions[:, 0], np.zeros_like(times)), axis=1)
    elif axes == 2:
        columns = np.column_stack((positions, times))
    else:
        columns = positions
    for i, axis in enumerate(box):
        reach = FAR * (axis.high - axis.low)
        outside = (columns[:, i] < axis.low - reach) | (columns[:, i] > axis.high + reach)
        columns = np.where(outside[:, None], np.nan, columns)
    return place(box, columns)


class TrackScene:
    """A track as one browser sees it."""

    def __init__(self, client: viser.ClientHandle, drawing: TrackDrawing) -> None:
        self.drawing = drawing
        self.box = box_of(drawing)
        scene, t = client.scene, tokens(drawing.theme)
        light(client, drawing.theme)
        axes = drawing.series["truth"].shape[1]
        add_box(scene, self.box, drawing.theme, flat=axes == 1)
        truth = self._points("truth")
        add_line(scene, "/truth", joined(truth), channels(t["truth"]), LINES["truth"]["width"])
        if axes > 1:
            shadow = truth.copy()
            shadow[:, 2] = -self.box[2].size / 2
            add_line(scene, "/shadow", joined(shadow), mixed(channels(t["truth"]), channels(t["surface"]), 0.3), 1.5)
        observed = self._points("observed")
        observed = observed[np.isfinite(observed).all(axis=1)]
        observed = observed[:: max(1, -(-len(observed) // DRAWN_MARKERS))]
        scene.add_point_cloud(
            "/observed", observed, np.array(channels(t["observed"]), dtype=np.uint8), point_size=0.0035,
            point_shape="circle", point_shading="flat", precision="float32",
        )  # fmt: skip
        self.refused = scene.add_point_cloud(
            "/refused", self._refused(), np.array(channels(t["bad"]), dtype=np.uint8), point_size=0.014,
            point_shape="diamond", point_shading="flat", precision="float32", visible=len(drawing.refused) > 0,
        )  # fmt: skip
        self.lines = {
            name: add_line(scene, f"/{name}", joined(self._points(name)), channels(t[name]), LINES[name]["width"])
            for name in ("predicted", "smoothed")
        }
        self.trail = add_line(scene, "/cursor/trail", self._trail(), channels(t["marker"]), 4)
        self.measured = MEASURED.add(scene, "/cursor/observed", channels(t["observed"]), self._here("observed"))
        self.cursor = CURSOR.add(scene, "/cursor/smoothed", channels(t["marker"]), *self._cursor())

    def update(self, drawing: Drawing) -> bool:
        """Change the lines that are others than before, and move the cursor; False when it needs another scene."""
        before = self.drawing
        if not isinstance(drawing, TrackDrawing) or drawing.still != before.still:
            return False
        self.drawing = drawing
        for name, handle in self.lines.items():
            if not drawing.same_line(before, name):
                handle.points = joined(self._points(name))
        if not np.array_equal(drawing.refused_times, before.refused_times):
            self.refused.points = self._refused()
            self.refused.visible = len(drawing.refused) > 0
        self.trail.points = self._trail()
        self.measured.vertices = MEASURED.vertices(self._here("observed"))
        self.cursor.vertices = CURSOR.vertices(*self._cursor())
        return True

    def look(self, client: viser.ClientHandle) -> None:
        """Put the camera where the track shows well."""
        look(client, EYES[len(self.drawing.names)], (0.0, 0.0, -0.04))

    def _points(self, name: str) -> Points:
        return points_of(self.box, self.drawing.times, self.drawing.series[name])

    def _refused(self) -> Points:
        """What the gate did not believe; one point somewhere where that is nothing, since no cloud may be empty."""
        points = points_of(self.box, self.drawing.refused_times, self.drawing.refused)
        points = points[np.isfinite(points).all(axis=1)]
        return points if len(points) else np.zeros((1, 3), dtype=np.float32)

    def _here(self, name: str) -> Place:
        """Where the cursor is on a series."""
        time = np.array([self.drawing.cursor_time])
        x, y, z = points_of(self.box, time, self.drawing.cursor[name][None])[0].tolist()
        return x, y, z

    def _cursor(self) -> tuple[Place, Place]:
        """The smoothed position, and the place below it on the floor."""
        x, y, z = self._here("smoothed")
        return (x, y, z), (x, y, -self.box[2].size / 2)

    def _trail(self) -> Segments:
        return joined(points_of(self.box, self.drawing.trail_times, self.drawing.trail))
