"""Where photos were taken, over the outcrop: shown, named under the cursor, and picked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QRect
from PySide6.QtGui import QPainter

from vomstudio.geometry.frusta import Frustum, frustum_at
from vomstudio.rendering.qt import painting
from vomstudio.rendering.qt.scene_lifetime import SceneLife
from vomstudio.rendering.qt.scene_picture import ScenePicture
from vomstudio.rendering.qt.viewport_protocol import Pane
from vomstudio.rendering.view.camera import Camera

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene

CAMERA_PIXELS = 9.0


class PhotoCameras:
    """frusta : in World; chosen : the names of the emphasised ones; hot : of the one under the
    cursor"""

    def __init__(self, camera: Camera, pane: Pane, life: SceneLife, picture: ScenePicture) -> None:
        self.frusta: tuple[Frustum, ...] = ()
        self.chosen: frozenset[str] = frozenset()
        self.hot: str | None = None
        self._camera, self._pane = camera, pane
        self._life, self._picture = life, picture

    def furnish(self, scene: Scene) -> None:
        """Give a scene that starts what is to be shown."""
        scene.cameras.show(self.frusta)
        scene.cameras.choose(self.chosen)

    def show(self, frusta: Sequence[Frustum]) -> None:
        """Where photos were taken, in World; none for nothing."""
        before = self.frusta
        self.frusta, self.hot = tuple(frusta), None
        if not before and not self.frusta:
            return
        scene = self._life.scene
        if scene is not None:
            scene.cameras.show(self.frusta)
            # What is far from the models asks for another range of depths.
            self._picture.redraw()

    def choose(self, names: Iterable[str]) -> None:
        """Emphasise the cameras of these photos, and no others."""
        chosen = frozenset(names)
        if chosen == self.chosen:
            return
        self.chosen = chosen
        scene = self._life.scene
        if scene is not None:
            scene.cameras.choose(chosen)
        if self.frusta:
            self._picture.redraw_features()

    def at(self, x: float, y: float) -> str | None:
        """The photo whose camera lies under a pixel."""
        if not self.frusta:
            return None
        extent = self._pane.extent()
        tips, _ = self._camera.project(np.stack([f.tip for f in self.frusta]), extent)
        bases = np.concatenate([f.corners for f in self.frusta])
        corners = self._camera.project(bases, extent)[0].reshape(-1, 4, 2)
        found = frustum_at(tips, corners, x, y, CAMERA_PIXELS)
        return None if found is None else self.frusta[found].name

    def hover(self, x: float, y: float) -> None:
        """The cursor stands at a pixel."""
        if self.frusta and (name := self.at(x, y)) != self.hot:
            self.hot = name
            self._pane.update()

    def leave(self) -> None:
        """The cursor is elsewhere."""
        if self.hot is not None:
            self.hot = None
            self._pane.update()

    def paint(self, painter: QPainter, room: QRect) -> None:
        """The name of the photo under the cursor, inside `room`."""
        place = next((f.tip for f in self.frusta if f.name == self.hot), None)
        if place is None or self.hot is None:
            return
        (at,), _ = self._camera.project(place[None], self._pane.extent())
        if np.isfinite(at).all():
            painting.draw_name(painter, float(at[0]), float(at[1]), self.hot, room)
