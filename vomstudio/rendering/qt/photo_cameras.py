"""Display and picking of camera positions over the outcrop."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QRect
from PySide6.QtGui import QPainter

from vomstudio.geometry.frusta import Frustum, find_frustum_at_pixel
from vomstudio.rendering.qt import painting
from vomstudio.rendering.qt.scene_lifetime import SceneLifetime
from vomstudio.rendering.qt.scene_picture import ScenePicture
from vomstudio.rendering.qt.viewport_protocol import Pane
from vomstudio.rendering.view.camera import Camera

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene

PICK_DISTANCE_PIXELS = 9.0


class PhotoCameras:
    """Camera positions of photos in the view.

    Attributes
    ----------
    frusta : sequence of Frustum
        Cameras in the World frame.
    selection : frozenset of str
        Names of the emphasised photos.
    hovered : str or None
        Name of the photo under the cursor.
    """

    def __init__(
        self, camera: Camera, pane: Pane, lifetime: SceneLifetime, picture: ScenePicture
    ) -> None:
        self.frusta: tuple[Frustum, ...] = ()
        self.selection: frozenset[str] = frozenset()
        self.hovered: str | None = None
        self._camera, self._pane = camera, pane
        self._lifetime, self._picture = lifetime, picture

    def attach_to(self, scene: Scene) -> None:
        """Pass the state to a new scene."""
        scene.cameras.show(self.frusta)
        scene.cameras.select(self.selection)

    def show(self, frusta: Sequence[Frustum]) -> None:
        """Show the cameras of photos, given in the World frame."""
        previous_frusta = self.frusta
        self.frusta, self.hovered = tuple(frusta), None
        if not previous_frusta and not self.frusta:
            return
        scene = self._lifetime.scene
        if scene is not None:
            scene.cameras.show(self.frusta)
            # Cameras far from the models need another depth range.
            self._picture.redraw()

    def select(self, names: Iterable[str]) -> None:
        """Emphasise only the cameras of these photos."""
        selection = frozenset(names)
        if selection == self.selection:
            return
        self.selection = selection
        scene = self._lifetime.scene
        if scene is not None:
            scene.cameras.select(selection)
        if self.frusta:
            self._picture.redraw_features()

    def at(self, x: float, y: float) -> str | None:
        """Return the name of the photo whose camera is at a pixel, or None."""
        if not self.frusta:
            return None
        extent = self._pane.extent()
        tips, _ = self._camera.project(np.stack([f.tip for f in self.frusta]), extent)
        bases = np.concatenate([f.corners for f in self.frusta])
        corners = self._camera.project(bases, extent)[0].reshape(-1, 4, 2)
        frustum = find_frustum_at_pixel(tips, corners, x, y, PICK_DISTANCE_PIXELS)
        return None if frustum is None else self.frusta[frustum].name

    def hover(self, x: float, y: float) -> None:
        """Update the photo under the cursor at a pixel."""
        if self.frusta and (name := self.at(x, y)) != self.hovered:
            self.hovered = name
            self._pane.update()

    def leave(self) -> None:
        """Handle the cursor leaving the view."""
        if self.hovered is not None:
            self.hovered = None
            self._pane.update()

    def paint(self, painter: QPainter, available_rect: QRect) -> None:
        """Paint the name of the photo under the cursor, inside `available_rect`."""
        position = next((f.tip for f in self.frusta if f.name == self.hovered), None)
        if position is None or self.hovered is None:
            return
        (pixel,), _ = self._camera.project(position[None], self._pane.extent())
        if np.isfinite(pixel).all():
            painting.draw_name(
                painter, float(pixel[0]), float(pixel[1]), self.hovered, available_rect
            )
