"""The clipping box of a view and the handles on its faces."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from PySide6.QtGui import QPainter

from vomstudio.rendering.qt import bar_painting
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.clipping import FACES, ClipBox, along_axis
from vomstudio.rendering.view.drawing import FeatureDrawing

Array = npt.NDArray[np.float64]
Size = tuple[float, float]

FACE_PIXELS = 14.0


class ClipHandles:
    """box : what is shown and picked, None for everything; handles : whether its faces can be
    dragged; hot : the face under the cursor."""

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self.box: ClipBox | None = None
        self.handles = True
        self.hot: int | None = None

    def places(self, size: Size) -> tuple[Array, Array, list[bool]]:
        """Pixels of the box's corners and handles, and which handles can be dragged from here."""
        assert self.box is not None
        corners, _ = self._camera.project(self.box.corners(), size)
        centres = np.stack([self.box.face_centre(*face) for face in FACES])
        pixels, _ = self._camera.project(centres, size)
        usable = []
        for (axis, _side), at in zip(FACES, pixels, strict=True):
            good = bool(np.isfinite(at).all())
            if good:
                origin, direction = self._camera.ray(float(at[0]), float(at[1]), size)
                good = along_axis(origin, direction, np.zeros(3), axis) is not None
            usable.append(good)
        return corners, pixels, usable

    def face_at(self, x: float, y: float, size: Size) -> int | None:
        """Which handle lies under a pixel."""
        if self.box is None or not self.handles:
            return None
        _, pixels, usable = self.places(size)
        off = np.hypot(pixels[:, 0] - x, pixels[:, 1] - y)
        off = np.where(np.isfinite(off) & np.array(usable), off, np.inf)
        best = int(np.argmin(off))
        return best if off[best] <= FACE_PIXELS else None

    def drag(self, face: int, x: float, y: float, size: Size) -> bool:
        """Move a face to where the line of sight through a pixel passes; False where that is
        nowhere."""
        assert self.box is not None
        axis, side = FACES[face]
        origin, direction = self._camera.ray(x, y, size)
        value = along_axis(origin, direction, self.box.face_centre(axis, side), axis)
        if value is None:
            return False
        self.box = self.box.with_face(axis, side, value)
        return True

    def paint(self, painter: QPainter, size: Size, held: int | None, letters: str) -> None:
        if self.box is not None and self.handles:
            corners, centres, usable = self.places(size)
            hot = self.hot if held is None else held
            bar_painting.draw_clip_box(painter, corners, centres, usable, hot, letters)

    def meets(self, drawing: FeatureDrawing) -> bool:
        """Whether a part of a feature is inside the box."""
        if self.box is None:
            return True
        points = drawing.line if len(drawing.line) else drawing.anchor
        return bool(self.box.holds(points).any())
