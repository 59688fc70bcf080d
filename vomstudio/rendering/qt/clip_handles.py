"""Clipping box of a view, with handles on its faces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QPainter

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.rendering.qt import bar_painting
from vomstudio.rendering.qt.annotations import Annotations
from vomstudio.rendering.qt.scene_lifetime import SceneLifetime
from vomstudio.rendering.qt.scene_picture import ScenePicture
from vomstudio.rendering.qt.viewport_protocol import Pane
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.clipping import BOX_FACES, ClipBox, along_axis
from vomstudio.rendering.view.drawing import FeatureDrawing

FACE_PICK_DISTANCE_PIXELS = 14.0


class ClipHandles(QObject):
    """Clipping box with draggable faces.

    Attributes
    ----------
    box : ClipBox or None
        Nothing is drawn or picked outside this box.
    handles : bool
        Whether its faces can be dragged.
    hovered : int or None
        Face under the cursor.
    """

    changed = Signal(object)
    """Emits the ClipBox while a handle is dragged."""

    def __init__(
        self,
        camera: Camera,
        pane: Pane,
        lifetime: SceneLifetime,
        picture: ScenePicture,
        annotations: Annotations,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self.box: ClipBox | None = None
        self.handles = True
        self.hovered: int | None = None
        self._camera, self._pane = camera, pane
        self._lifetime, self._picture, self._annotations = lifetime, picture, annotations

    def set_box(self, box: ClipBox | None, *, handles: bool = True) -> None:
        """Set the clipping box (None disables clipping), and whether it has handles."""
        if handles != self.handles:
            self.handles = handles
            self._pane.update()
        if box != self.box:
            self.box = box
            self._annotations.clear_state()

            def apply() -> None:
                self._cut()
                self._picture.redraw()

            self._lifetime.call_when_started(apply)

    def _cut(self) -> None:
        if self._lifetime.scene is not None:
            self._lifetime.scene.set_clip(self.box)

    # -- contents of the box

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which points (n, 3) in the World frame are inside the box; all without a box."""
        if self.box is None:
            return np.ones(len(points), np.bool_)
        return self.box.contains(points)

    def intersects(self, drawing: FeatureDrawing) -> bool:
        """Return whether any vertex of a feature is inside the box; True without a box."""
        if self.box is None:
            return True
        points = drawing.line if len(drawing.line) else drawing.anchor
        return bool(self.box.contains(points).any())

    # -- drag of a face

    def places(self) -> tuple[FloatArray, FloatArray, list[bool]]:
        """Return the pixels of the corners and handles, and which handles can be dragged."""
        assert self.box is not None
        extent = self._pane.extent()
        corners, _ = self._camera.project(self.box.corners(), extent)
        centres = np.stack([self.box.face_centre(*face) for face in BOX_FACES])
        pixels, _ = self._camera.project(centres, extent)
        is_usable_face = []
        for (axis, _side), position in zip(BOX_FACES, pixels, strict=True):
            is_drawable = bool(np.isfinite(position).all())
            if is_drawable:
                origin, direction = self._camera.ray(float(position[0]), float(position[1]), extent)
                is_drawable = along_axis(origin, direction, np.zeros(3), axis) is not None
            is_usable_face.append(is_drawable)
        return corners, pixels, is_usable_face

    def face_at(self, x: float, y: float) -> int | None:
        """Return the face whose handle is at a pixel, or None."""
        if self.box is None or not self.handles:
            return None
        _, pixels, is_usable = self.places()
        distance = np.hypot(pixels[:, 0] - x, pixels[:, 1] - y)
        distance = np.where(np.isfinite(distance) & np.array(is_usable), distance, np.inf)
        best_row = int(np.argmin(distance))
        return best_row if distance[best_row] <= FACE_PICK_DISTANCE_PIXELS else None

    def drag_face(self, face: int, x: float, y: float) -> None:
        """Move a face along its axis so that it follows the cursor at a pixel."""
        assert self.box is not None
        axis, side = BOX_FACES[face]
        origin, direction = self._camera.ray(x, y, self._pane.extent())
        value = along_axis(origin, direction, self.box.face_centre(axis, side), axis)
        if value is None:
            return
        self.box = self.box.move_face(axis, side, value)
        self._annotations.clear_state()
        self._cut()
        self._picture.begin_motion()
        self.changed.emit(self.box)

    def release_face(self) -> None:
        """End dragging a face."""
        self._picture.schedule_rest()
        self._pane.update()

    def hover(self, x: float, y: float, *, is_free: bool) -> None:
        """Update the face under the cursor; `is_free` means that it is over no other handle."""
        face = self.face_at(x, y) if is_free else None
        if face != self.hovered:
            self.hovered = face
            self._pane.update()

    def paint(self, painter: QPainter, dragged_face: int | None, letters: Sequence[str]) -> None:
        if self.box is not None and self.handles:
            corners, centres, is_usable = self.places()
            hovered = self.hovered if dragged_face is None else dragged_face
            bar_painting.draw_clip_box(painter, corners, centres, is_usable, hovered, letters)
